//! The goals of an action server, and the clients that wait for their results. No clock, no sockets.
//!
//! ```text
//!  accepted ──▶ executing ──────────────▶ succeeded | aborted
//!                   │                         ▲
//!                   └──cancel──▶ canceling ───┴──▶ canceled
//! ```
//!
//! A goal that has ended is kept until others need its room, so that a late request still gets its end. Unknown goals
//! are not answered: with two ways of sending requests ([`super`]) an unknown goal may be nothing but a request that
//! was meant to be read the other way, where it is known.

use ros2_client::action_msgs::{CancelGoalResponse, CancelGoalResponseEnum, GoalStatus, GoalStatusArray};
use ros2_client::action_msgs::{GoalId, GoalInfo, GoalStatusEnum};
use ros2_client::builtin_interfaces::Time;

/// Goals that are under way at once; more are rejected. A station does one order at a time.
const LIVE_MAX: usize = 16;
/// Most goals kept, those that have ended included.
const KNOWN_MAX: usize = 64;
/// Most clients waiting for the result of one goal. Further ones must repeat the request.
const WAITING_MAX: usize = 8;

/// End of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalEnd {
    /// It was reached.
    Succeeded,
    /// It was not, or it was never begun: the reason is in the result.
    Aborted,
    /// It was cancelled, and that has been done.
    Canceled,
}

impl GoalEnd {
    fn status(self) -> GoalStatusEnum {
        match self {
            GoalEnd::Succeeded => GoalStatusEnum::Succeeded,
            GoalEnd::Aborted => GoalStatusEnum::Aborted,
            GoalEnd::Canceled => GoalStatusEnum::Canceled,
        }
    }
}

/// One goal. `W` is the return address of a client.
struct GoalRecord<R, W> {
    info: GoalInfo,
    status: GoalStatusEnum,
    result: Option<R>,
    waiting: Vec<W>,
}

/// All goals kept, the oldest first.
pub(super) struct Goals<R, W> {
    goals: Vec<GoalRecord<R, W>>,
}

impl<R: Clone, W> Goals<R, W> {
    pub(super) fn new() -> Self {
        Goals { goals: Vec::new() }
    }

    /// Takes a goal if it is new and there is room; gives whether it was taken.
    pub(super) fn begin(&mut self, goal_id: GoalId, stamp: Time) -> bool {
        let live = self.goals.iter().filter(|goal| goal.result.is_none()).count();
        if goal_id == GoalId::ZERO || live >= LIVE_MAX || self.find(goal_id).is_some() {
            return false;
        }
        if self.goals.len() >= KNOWN_MAX
            && let Some(oldest) = self.goals.iter().position(|goal| goal.result.is_some())
        {
            self.goals.remove(oldest);
        }
        let info = GoalInfo { goal_id, stamp };
        self.goals.push(GoalRecord { info, status: GoalStatusEnum::Executing, result: None, waiting: Vec::new() });
        true
    }

    /// Cancels by the rule of `action_msgs/CancelGoal`: one goal, all, or all accepted up to a time. Gives the answer,
    /// and the goals newly to be cancelled; `None` if the goal is unknown.
    pub(super) fn cancel(&mut self, asked: &GoalInfo) -> Option<(CancelGoalResponse, Vec<GoalId>)> {
        let (one, all_until) = (asked.goal_id != GoalId::ZERO, asked.stamp != Time::ZERO);
        if one && self.find(asked.goal_id).is_none() {
            return None;
        }
        let mut response =
            CancelGoalResponse { return_code: CancelGoalResponseEnum::Rejected, goals_canceling: vec![] };
        let mut new = Vec::new();
        for goal in &mut self.goals {
            let meant = match (one, all_until) {
                (false, false) => true,
                (false, true) => goal.info.stamp <= asked.stamp,
                (true, false) => goal.info.goal_id == asked.goal_id,
                (true, true) => goal.info.goal_id == asked.goal_id || goal.info.stamp <= asked.stamp,
            };
            if !meant {
                continue;
            }
            if goal.result.is_some() {
                if goal.info.goal_id == asked.goal_id {
                    response.return_code = CancelGoalResponseEnum::GoalTerminated;
                }
                continue;
            }
            if goal.status != GoalStatusEnum::Canceling {
                goal.status = GoalStatusEnum::Canceling;
                new.push(goal.info.goal_id);
            }
            response.goals_canceling.push(goal.info.clone());
        }
        if !response.goals_canceling.is_empty() {
            response.return_code = CancelGoalResponseEnum::None;
        }
        Some((response, new))
    }

    /// A cancellation is not followed. False if the goal was not being cancelled.
    pub(super) fn goes_on(&mut self, goal_id: GoalId) -> bool {
        let cancelled =
            |goal: &&mut GoalRecord<R, W>| goal.info.goal_id == goal_id && goal.status == GoalStatusEnum::Canceling;
        let goal = self.goals.iter_mut().find(cancelled);
        goal.map(|goal| goal.status = GoalStatusEnum::Executing).is_some()
    }

    /// Gives the result of a goal if it is there, else keeps `who` for it. `None` without a result, or if the goal is
    /// unknown.
    pub(super) fn ask(&mut self, goal_id: GoalId, who: W) -> Option<(GoalStatusEnum, R, W)> {
        let goal = self.goals.iter_mut().find(|goal| goal.info.goal_id == goal_id)?;
        if let Some(result) = &goal.result {
            return Some((goal.status, result.clone(), who));
        }
        if goal.waiting.len() < WAITING_MAX {
            goal.waiting.push(who);
        }
        None
    }

    /// Ends a goal. Gives its status and the waiting clients; `None` if it had ended before, or is unknown.
    pub(super) fn end(&mut self, goal_id: GoalId, ended: GoalEnd, result: R) -> Option<(GoalStatusEnum, Vec<W>)> {
        let goal = self.goals.iter_mut().find(|goal| goal.info.goal_id == goal_id && goal.result.is_none())?;
        goal.status = ended.status();
        goal.result = Some(result);
        Some((goal.status, std::mem::take(&mut goal.waiting)))
    }

    /// Content of the status topic.
    pub(super) fn statuses(&self) -> GoalStatusArray {
        let status = |goal: &GoalRecord<R, W>| GoalStatus { goal_info: goal.info.clone(), status: goal.status };
        GoalStatusArray { status_list: self.goals.iter().map(status).collect() }
    }

    fn find(&self, goal_id: GoalId) -> Option<&GoalRecord<R, W>> {
        self.goals.iter().find(|goal| goal.info.goal_id == goal_id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::from_nanos(seconds * 1_000_000_000)
    }

    fn goals(number: usize) -> (Goals<u8, u8>, Vec<GoalId>) {
        let ids: Vec<_> = (0..number).map(|_| GoalId::new_random()).collect();
        let mut goals = Goals::new();
        for (second, id) in ids.iter().enumerate() {
            assert!(goals.begin(*id, at(second as i64 + 1)));
        }
        (goals, ids)
    }

    #[test]
    fn a_goal_is_taken_on_once_and_only_so_many_at_a_time() {
        let (mut goals, ids) = goals(LIVE_MAX);
        assert!(!goals.begin(ids[0], at(9)), "twice");
        assert!(!goals.begin(GoalId::ZERO, at(9)), "no id");
        assert!(!goals.begin(GoalId::new_random(), at(9)), "too many");
        assert!(goals.end(ids[3], GoalEnd::Aborted, 7).is_some());
        assert!(goals.begin(GoalId::new_random(), at(9)), "room again");
        assert!(!goals.begin(ids[3], at(9)), "it has ended, and is still known");
    }

    #[test]
    fn what_has_ended_is_forgotten_for_what_is_new() {
        let (mut goals, ids) = goals(1);
        goals.end(ids[0], GoalEnd::Succeeded, 1);
        for _ in 0..KNOWN_MAX {
            let id = GoalId::new_random();
            assert!(goals.begin(id, at(5)) && goals.end(id, GoalEnd::Succeeded, 1).is_some());
        }
        assert_eq!(goals.goals.len(), KNOWN_MAX);
        assert!(goals.ask(ids[0], 0).is_none());
    }

    #[test]
    fn a_result_is_given_to_all_who_asked_before_and_to_each_who_asks_after() {
        let (mut goals, ids) = goals(1);
        assert!(goals.ask(ids[0], 1).is_none() && goals.ask(ids[0], 2).is_none());
        let (status, who) = goals.end(ids[0], GoalEnd::Canceled, 42).expect("it was under way");
        assert_eq!((status, who), (GoalStatusEnum::Canceled, vec![1, 2]));
        assert!(goals.end(ids[0], GoalEnd::Succeeded, 43).is_none(), "an end is an end");
        let (status, result, who) = goals.ask(ids[0], 3).expect("known");
        assert_eq!((status, result, who), (GoalStatusEnum::Canceled, 42, 3));
    }

    #[test]
    fn a_goal_whose_cancellation_is_not_followed_can_be_cancelled_again() {
        let (mut goals, ids) = goals(2);
        let one = GoalInfo { goal_id: ids[0], stamp: Time::ZERO };
        assert!(!goals.goes_on(ids[0]), "it was not being cancelled");
        for _ in 0..2 {
            let (_, new) = goals.cancel(&one).expect("it is known");
            assert_eq!(new, [ids[0]]);
            assert!(goals.goes_on(ids[0]));
            assert_eq!(goals.find(ids[0]).map(|goal| goal.status), Some(GoalStatusEnum::Executing));
        }
    }

    #[test]
    fn cancelling_follows_the_rule_of_its_service() {
        let ask = |goal_id, stamp| GoalInfo { goal_id, stamp };
        let which = |response: &CancelGoalResponse| {
            response.goals_canceling.iter().map(|info| info.goal_id).collect::<Vec<_>>()
        };
        let (mut goals, ids) = goals(4);
        assert!(goals.cancel(&ask(GoalId::new_random(), Time::ZERO)).is_none(), "whose?");
        let (response, new) = goals.cancel(&ask(ids[2], Time::ZERO)).expect("known");
        assert_eq!(
            (response.return_code, which(&response), new),
            (CancelGoalResponseEnum::None, vec![ids[2]], vec![ids[2]])
        );
        let (response, new) = goals.cancel(&ask(GoalId::ZERO, at(3))).expect("always");
        assert_eq!((which(&response), new), (ids[..3].to_vec(), ids[..2].to_vec()), "those up to a time");
        let (response, new) = goals.cancel(&ask(GoalId::ZERO, Time::ZERO)).expect("always");
        assert_eq!((which(&response), new), (ids.clone(), vec![ids[3]]), "all");
        goals.end(ids[0], GoalEnd::Succeeded, 0);
        let (response, new) = goals.cancel(&ask(ids[0], Time::ZERO)).expect("known");
        assert_eq!((response.return_code, new.len()), (CancelGoalResponseEnum::GoalTerminated, 0));
        for id in &ids[1..] {
            goals.end(*id, GoalEnd::Canceled, 0);
        }
        let (response, _) = goals.cancel(&ask(GoalId::ZERO, Time::ZERO)).expect("always");
        assert_eq!(response.return_code, CancelGoalResponseEnum::Rejected, "nothing to cancel");
    }
}
