//! Requests to the cell that wait for their reply until the result is on disk.
//!
//! The player replies to production orders by tickets. To answers to alarms and requests about resources it only objects: a
//! request in a step without an objection is accepted.

use linewright_coordinator_cell::exception::{AlarmAnswerRefusal, ResourceRequest};
use linewright_coordinator_cell::texts::answer_refused;
use linewright_coordinator_cell::{
    CellEvent, PlayerOutbox, PlayerState, ProductionCommandError, ProductionId, RequestId,
};
use linewright_line::Line;
use linewright_msgs::{
    AnswerAlarm, AnswerAlarmResponse, ChangeOrder, ChangeOrderResponse, SetResource, SetResourceResponse, SubmitOrders,
    SubmitOrdersResponse,
};
use linewright_node_shell::{GoalHandle, ServiceReply};

/// Destination of the reply to a ticket.
pub enum Requester {
    Submit(ServiceReply<SubmitOrders>),
    Change(ServiceReply<ChangeOrder>),
    /// A goal that makes an order.
    Goal(GoalHandle),
    /// A goal that is cancelled, with its order.
    Cancellation(GoalHandle),
}

/// Reply to the request of a goal.
#[derive(Debug)]
pub enum GoalNews {
    /// The order that was made for the goal, or the reasons why none was made.
    Ordered(GoalHandle, Result<ProductionId, Vec<String>>),
    /// Its order is cancelled or withdrawn, or why it is not.
    Cancelled(GoalHandle, Result<(), String>),
}

/// Destination of the reply to an operator's answer or request.
pub enum AnsweringOperator {
    Answer(ServiceReply<AnswerAlarm>),
    Resource(ServiceReply<SetResource>),
}

/// Requesters that wait for a reply.
#[derive(Default)]
pub struct PendingReplies {
    tickets: RequestId,
    customers: Vec<(RequestId, Requester)>,
    operators: Vec<(ResourceRequest, AnsweringOperator)>,
    /// Replies to goals, to be taken after each step.
    pub goal_news: Vec<GoalNews>,
}

impl PendingReplies {
    /// A ticket for a request to make or not to make something.
    pub fn ticket(&mut self, customer: Requester) -> RequestId {
        self.tickets += 1;
        self.customers.push((self.tickets, customer));
        self.tickets
    }

    /// A request that is handed over in the next step.
    pub fn expect(&mut self, asked: ResourceRequest, operator: AnsweringOperator) {
        self.operators.push((asked, operator));
    }

    /// Refuses all requests that no step has taken.
    pub fn refuse(&mut self, reason: &str) {
        let news = self.customers.drain(..).filter_map(|(_, customer)| customer.refuse(reason.to_owned()));
        self.goal_news.extend(news);
        self.operators.drain(..).for_each(|(_, operator)| operator.hear(Some(reason.to_owned())));
    }

    /// Replies to all requests of a step, when it is on disk.
    pub fn reply(&mut self, line: &Line, state: &PlayerState, out: &mut PlayerOutbox) {
        for (ticket, reply) in out.replies.drain(..) {
            if let Some(at) = self.customers.iter().position(|(known, _)| *known == ticket) {
                let (_, customer) = self.customers.swap_remove(at);
                self.goal_news.extend(customer.hear(reply));
            }
        }
        for (asked, operator) in self.operators.drain(..) {
            let objection = out.events.iter().find_map(|event| match event {
                CellEvent::Objected { to, why } if *to == asked => Some(*why),
                CellEvent::Objected { .. }
                | CellEvent::BadAnswer { .. }
                | CellEvent::Superseded { .. }
                | CellEvent::Busy { .. } => None,
            });
            operator.hear(objection.map(|why: AlarmAnswerRefusal| answer_refused(line, state, asked, why)));
        }
    }
}

impl Requester {
    fn refuse(self, reason: String) -> Option<GoalNews> {
        match self {
            Requester::Submit(to) => to.send(denied_all(vec![reason])),
            Requester::Change(to) => to.send(ChangeOrderResponse { done: false, reason }),
            Requester::Goal(goal) => return Some(GoalNews::Ordered(goal, Err(vec![reason]))),
            Requester::Cancellation(goal) => return Some(GoalNews::Cancelled(goal, Err(reason))),
        }
        None
    }

    fn hear(self, reply: Result<Vec<ProductionId>, ProductionCommandError>) -> Option<GoalNews> {
        match self {
            Requester::Submit(to) => to.send(match reply {
                Ok(ids) => SubmitOrdersResponse {
                    accepted: true,
                    ids: ids.into_iter().map(|id| id.0).collect(),
                    problems: Vec::new(),
                },
                Err(denied) => denied_all(problems(&denied)),
            }),
            Requester::Change(to) => to.send(match reply {
                Ok(_) => ChangeOrderResponse { done: true, reason: String::new() },
                Err(denied) => ChangeOrderResponse { done: false, reason: denied.to_string() },
            }),
            Requester::Goal(goal) => {
                // One request makes one order.
                let made = reply.map_err(|denied| problems(&denied));
                let made = made.and_then(|ids| ids.first().copied().ok_or_else(Vec::new));
                return Some(GoalNews::Ordered(goal, made));
            }
            Requester::Cancellation(goal) => {
                return Some(GoalNews::Cancelled(goal, reply.map(drop).map_err(|denied| denied.to_string())));
            }
        }
        None
    }
}

/// The reasons for which production orders were denied: one for each wrong request, or one of all.
fn problems(denied: &ProductionCommandError) -> Vec<String> {
    match denied {
        ProductionCommandError::Request(wrongs) => wrongs.iter().map(ToString::to_string).collect(),
        ProductionCommandError::Order(_) | ProductionCommandError::Superseded => vec![denied.to_string()],
    }
}

/// None of the requests was taken.
pub fn denied_all(problems: Vec<String>) -> SubmitOrdersResponse {
    SubmitOrdersResponse { accepted: false, ids: Vec::new(), problems }
}

impl AnsweringOperator {
    fn hear(self, objection: Option<String>) {
        let (accepted, reason) = (objection.is_none(), objection.unwrap_or_default());
        match self {
            AnsweringOperator::Answer(to) => to.send(AnswerAlarmResponse { accepted, reason }),
            AnsweringOperator::Resource(to) => to.send(SetResourceResponse { accepted, reason }),
        }
    }
}
