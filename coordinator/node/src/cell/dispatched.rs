//! The action `~/dispatch_order`: a production order that a program makes, follows and cancels.
//!
//! It is the services `submit_order`, `withdraw_order` and `cancel_order` and the topic `cell_state` for one order: the player takes
//! the same commands. Only which goal follows which order is here, in memory: the order is the cell's, and goes on without its goal.

use linewright_coordinator_cell::production::Production;
use linewright_coordinator_cell::{ProductionId, RequestId};
use linewright_line::Tick;
use linewright_msgs::{DispatchOrder, DispatchOrderFeedback, DispatchOrderGoal, DispatchOrderResult, ProductionState};
use linewright_node_line::quoted;
use linewright_node_shell::{ActionOwner, GoalAsked, GoalEnd, GoalHandle, GoalRequest};

use super::pending_replies::{GoalNews, Requester};
use super::play::CellLoop;
use super::requests::PlayerMessage;
use super::wire;
use super::words::{by_whom, ordered};

/// A goal, and what its client has received of its order.
struct FollowedGoal {
    goal: GoalHandle,
    /// None until the player has made the order.
    order: Option<ProductionId>,
    told: ProductionState,
    is_cancelled: bool,
}

/// The goals that are under way. Their number is bounded by the action's server.
pub struct DispatchedOrders {
    owner: ActionOwner<DispatchOrder>,
    goals: Vec<FollowedGoal>,
}

/// What a change of its order means for a goal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GoalStep {
    Wait,
    Tell,
    End(GoalEnd, u8),
}

/// What is to be done about a goal. `told`: state of its order in the last feedback; `now`: its present state, none where the cell does not
/// keep the order any more.
pub fn step_of(told: &ProductionState, now: Option<&ProductionState>, is_cancelled: bool) -> GoalStep {
    let Some(now) = now else { return GoalStep::End(GoalEnd::Aborted, DispatchOrderResult::END_UNKNOWN) };
    // Only its client cancels a goal. An order that another program has cancelled ends it as aborted.
    let cancelled = if is_cancelled { GoalEnd::Canceled } else { GoalEnd::Aborted };
    let is_over = now.ended != Default::default();
    match now.status {
        ProductionState::STATUS_WITHDRAWN => GoalStep::End(cancelled, DispatchOrderResult::END_WITHDRAWN),
        ProductionState::STATUS_CANCELLED if is_over => GoalStep::End(cancelled, DispatchOrderResult::END_CANCELLED),
        ProductionState::STATUS_DONE => GoalStep::End(GoalEnd::Succeeded, DispatchOrderResult::END_DONE),
        _ => {
            let seen = |of: &ProductionState| (of.id, of.status, of.entered, of.done, of.lost);
            if seen(told) == seen(now) { GoalStep::Wait } else { GoalStep::Tell }
        }
    }
}

impl DispatchedOrders {
    pub fn new(owner: ActionOwner<DispatchOrder>) -> Self {
        DispatchedOrders { owner, goals: Vec::new() }
    }

    fn refuse(&mut self, goal: GoalHandle, problems: Vec<String>) {
        let result = DispatchOrderResult { end: DispatchOrderResult::END_REFUSED, problems, ..Default::default() };
        self.owner.end(goal, GoalEnd::Aborted, result);
        self.goals.retain(|known| known.goal != goal);
    }

    fn find(&mut self, goal: GoalHandle) -> Option<&mut FollowedGoal> {
        self.goals.iter_mut().find(|known| known.goal == goal)
    }

    /// Passes on what has become of the orders.
    fn follow(&mut self, production: &Production, now: Tick) {
        let owner = &self.owner;
        self.goals.retain_mut(|known| {
            let Some(id) = known.order else { return true };
            let order = production.order(id).map(|order| ordered(production, order, now));
            match step_of(&known.told, order.as_ref(), known.is_cancelled) {
                GoalStep::Wait => true,
                GoalStep::Tell => {
                    known.told = order.unwrap_or_default();
                    owner.feedback(known.goal, DispatchOrderFeedback { order: known.told.clone() });
                    true
                }
                GoalStep::End(ended, end) => {
                    let order = order.unwrap_or_else(|| known.told.clone());
                    owner.end(known.goal, ended, DispatchOrderResult { end, order, problems: Vec::new() });
                    false
                }
            }
        });
    }
}

impl CellLoop {
    /// Takes a request of the action, unless its result could not be written down.
    pub(super) fn goal(&mut self, asked: GoalRequest<DispatchOrderGoal>, refusal: Option<String>) {
        match (asked.asked, refusal) {
            (GoalAsked::New(_), Some(reason)) => self.dispatched.refuse(asked.goal, vec![reason]),
            (GoalAsked::New(wanted), None) => self.order_by_goal(asked.goal, &wanted),
            (GoalAsked::Cancel, refusal) => {
                let Some(known) = self.dispatched.find(asked.goal) else { return };
                known.is_cancelled = true;
                match (known.order, refusal) {
                    (_, Some(reason)) => self.goes_on(asked.goal, &reason),
                    (Some(order), None) => self.cancel_order_of(asked.goal, order),
                    // As soon as it is known.
                    (None, None) => {}
                }
            }
        }
    }

    fn order_by_goal(&mut self, goal: GoalHandle, wanted: &DispatchOrderGoal) {
        let DispatchOrderGoal { request, by } = wanted;
        tracing::info!("order {}: request by an action{}", quoted(&request.name), by_whom(by));
        // A goal that is given twice, since its acceptance was lost, is one order.
        match wire::request(request, goal.key()) {
            Ok(request) => {
                let told = ProductionState::default();
                self.dispatched.goals.push(FollowedGoal { goal, order: None, told, is_cancelled: false });
                let ticket: RequestId = self.people.ticket(Requester::Goal(goal));
                self.told.push(PlayerMessage::Submit(ticket, vec![request]));
            }
            Err(problem) => self.dispatched.refuse(goal, vec![problem]),
        }
    }

    /// Withdraws the order of a goal; if something of it has entered, nothing more is to enter.
    fn cancel_order_of(&mut self, goal: GoalHandle, id: ProductionId) {
        let Some(order) = self.coordination.state().production().order(id) else { return };
        let (name, has_begun) = (order.request.name.clone(), order.begun.is_some());
        let ticket = self.people.ticket(Requester::Cancellation(goal));
        self.told.push(match has_begun {
            true => PlayerMessage::Cancel(ticket, name),
            false => PlayerMessage::Withdraw(ticket, name),
        });
    }

    /// A cancellation that is not followed.
    fn goes_on(&mut self, goal: GoalHandle, reason: &str) {
        tracing::warn!("cancellation of a goal not followed: {reason}");
        if let Some(known) = self.dispatched.find(goal) {
            known.is_cancelled = false;
            self.dispatched.owner.goes_on(goal);
        }
    }

    /// Takes the replies of the player to requests of goals, and passes on what has become of their orders. Call it after each step.
    pub(super) fn follow_goals(&mut self) {
        for news in std::mem::take(&mut self.people.goal_news) {
            match news {
                GoalNews::Ordered(goal, Ok(id)) => {
                    let Some(known) = self.dispatched.find(goal) else { continue };
                    known.order = Some(id);
                    if known.is_cancelled {
                        self.cancel_order_of(goal, id);
                    }
                }
                GoalNews::Ordered(goal, Err(problems)) => self.dispatched.refuse(goal, problems),
                GoalNews::Cancelled(_, Ok(())) => {}
                GoalNews::Cancelled(goal, Err(reason)) => self.goes_on(goal, &reason),
            }
        }
        let now = self.now();
        self.dispatched.follow(self.coordination.state().production(), now);
    }
}
