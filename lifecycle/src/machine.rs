//! The state of one node.

use crate::state::LifecycleState;
use crate::table::{ERROR, FAILURE, LifecycleStep, SUCCESS, steps_from};

/// A request for a transition. ROS 2 goes by the label if there is one, and by the number otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LifecycleRequest<'a> {
    Label(&'a str),
    Code(u8),
}

impl<'a> LifecycleRequest<'a> {
    /// The request of a message with both.
    pub fn of(code: u8, label: &'a str) -> Self {
        if label.is_empty() { LifecycleRequest::Code(code) } else { LifecycleRequest::Label(label) }
    }
}

/// How the work of a transition has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LifecycleOutcome {
    /// It is done.
    Success,
    /// It could not be done; the node is as before.
    Failure,
    /// It could not be done, and the node has to be brought into order.
    Error,
}

impl LifecycleOutcome {
    const fn label(self) -> &'static str {
        match self {
            LifecycleOutcome::Success => SUCCESS,
            LifecycleOutcome::Failure => FAILURE,
            LifecycleOutcome::Error => ERROR,
        }
    }
}

/// The state of one node. It begins unconfigured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeLifecycle {
    state: LifecycleState,
}

impl NodeLifecycle {
    /// A node that is active, to ask what a request does there.
    pub const fn active() -> Self {
        NodeLifecycle { state: LifecycleState::Active }
    }

    pub fn state(&self) -> LifecycleState {
        self.state
    }

    /// Begins the transition that is requested: the node is in the state between, and its work is to be done. `None`, and nothing changes,
    /// if no such transition leads out of the present state, or the work of another one is not concluded.
    pub fn begin(&mut self, request: LifecycleRequest<'_>) -> Option<&'static LifecycleStep> {
        let is_asked = |step: &&LifecycleStep| match request {
            LifecycleRequest::Label(label) => step.label == label,
            LifecycleRequest::Code(code) => step.code == code,
        };
        self.state.is_primary().then(|| steps_from(self.state).find(is_asked)).flatten().inspect(|step| self.go(step))
    }

    /// Concludes the work of the transition that has begun. After an error it is the work of error processing that is to be concluded
    /// next. `None`, and nothing changes, if none has begun.
    pub fn conclude(&mut self, outcome: LifecycleOutcome) -> Option<&'static LifecycleStep> {
        let is_so = |step: &&LifecycleStep| step.label == outcome.label();
        let is_between = !self.state.is_primary();
        is_between.then(|| steps_from(self.state).find(is_so)).flatten().inspect(|step| self.go(step))
    }

    fn go(&mut self, step: &LifecycleStep) {
        self.state = step.to;
    }
}
