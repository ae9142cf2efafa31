//! Action client, for the coordinator, for tools and for tests.

use std::time::Duration;

use linewright_msgs::{RosAction, RosMessage};
use ros2_client::action::ActionClient;
use ros2_client::action_msgs::{CancelGoalResponseEnum, GoalStatusEnum};
use ros2_client::builtin_interfaces::Time;
use thiserror::Error;

use super::server::GoalHandle;
use crate::caller::WireMessage;

/// Why a goal did not get its answer.
#[derive(Debug, Error)]
pub enum GoalError {
    /// No answer came.
    #[error("{action}: no answer within {} ms", within.as_millis())]
    NoAnswer {
        action: String,
        /// Time waited.
        within: Duration,
    },
    /// The goal was rejected: its id is in use, or too many are under way.
    #[error("{action}: the goal was rejected")]
    Rejected { action: String },
    /// The middleware has failed, or its answer is invalid.
    #[error("{action}: {reason}")]
    Middleware {
        action: String,
        /// The middleware's text.
        reason: String,
    },
}

/// End of a goal, as its client sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalOutcome {
    /// It was reached.
    Succeeded,
    /// It was not; the reason is in the result.
    Aborted,
    /// It was cancelled.
    Canceled,
    /// The server's status is no end.
    Unclear,
}

type RawActionClient<A> = ActionClient<
    WireMessage<<A as RosAction>::Goal>,
    WireMessage<<A as RosAction>::Result>,
    WireMessage<<A as RosAction>::Feedback>,
>;

/// Client of one action.
pub struct ActionCaller<A: RosAction> {
    pub(crate) inner: RawActionClient<A>,
    pub(crate) name: String,
}

impl<A: RosAction> ActionCaller<A> {
    /// Sends a goal and waits for nothing: for callers that learn the outcome in another way, and repeat the goal.
    pub fn send(&self, goal: A::Goal) -> Result<(), GoalError> {
        self.inner.send_goal(WireMessage(goal)).map(drop).map_err(|error| self.failed(&error))
    }

    /// Sends a goal, and waits until it is accepted. A goal sent before the server is discovered is lost: repeat it.
    pub async fn begin(&self, goal: A::Goal, within: Duration) -> Result<GoalHandle, GoalError> {
        let answer = self.in_time(within, self.inner.async_send_goal(WireMessage(goal))).await?;
        let (id, response) = answer.map_err(|error| self.failed(&error))?;
        if response.accepted { Ok(GoalHandle(id)) } else { Err(GoalError::Rejected { action: self.name.clone() }) }
    }

    /// Waits for the end of a goal, and gives its result.
    pub async fn result(&self, goal: GoalHandle, within: Duration) -> Result<(GoalOutcome, A::Result), GoalError> {
        let answer = self.in_time(within, self.inner.async_request_result(goal.0)).await?;
        let (status, WireMessage(result)) = answer.map_err(|error| self.failed(&error))?;
        result.validate().map_err(|invalid| self.failed(&invalid))?;
        let outcome = match status {
            GoalStatusEnum::Succeeded => GoalOutcome::Succeeded,
            GoalStatusEnum::Aborted => GoalOutcome::Aborted,
            GoalStatusEnum::Canceled => GoalOutcome::Canceled,
            GoalStatusEnum::Unknown
            | GoalStatusEnum::Accepted
            | GoalStatusEnum::Executing
            | GoalStatusEnum::Canceling => GoalOutcome::Unclear,
        };
        Ok((outcome, result))
    }

    /// Requests cancellation. Gives whether that was accepted; the end is in the goal's result.
    pub async fn cancel(&self, goal: GoalHandle, within: Duration) -> Result<bool, GoalError> {
        let answer = self.in_time(within, self.inner.async_cancel_goal(goal.0, Time::ZERO)).await?;
        let response = answer.map_err(|error| self.failed(&error))?;
        Ok(response.return_code == CancelGoalResponseEnum::None)
    }

    /// Newest feedback not taken yet.
    pub fn feedback(&self, goal: GoalHandle) -> Option<A::Feedback> {
        let received = self.inner.receive_feedback(goal.0).ok().flatten();
        received.map(|WireMessage(feedback)| feedback).filter(|feedback| feedback.validate().is_ok())
    }

    async fn in_time<T>(&self, within: Duration, answer: impl Future<Output = T>) -> Result<T, GoalError> {
        let late = |_| GoalError::NoAnswer { action: self.name.clone(), within };
        tokio::time::timeout(within, answer).await.map_err(late)
    }

    fn failed(&self, reason: &impl std::fmt::Debug) -> GoalError {
        GoalError::Middleware { action: self.name.clone(), reason: format!("{reason:?}") }
    }
}
