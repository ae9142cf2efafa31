//! Transitions of the node: what each does at the coordinator.

use linewright_lifecycle::{LifecycleOutcome, LifecycleState};
use linewright_node_shell::ChangeRequest;

use crate::node::{CoordinatorLoop, CoordinatorNodeError};

impl CoordinatorLoop {
    /// Makes the transition of a request, and answers. An order that follows from it is given before the answer.
    pub(crate) async fn change(&mut self, asked: ChangeRequest) -> Result<(), CoordinatorNodeError> {
        let mut is_made = false;
        let mut between = self.lifecycle.begin(&asked);
        let begun = between;
        while let Some(state) = between {
            let outcome = self.work_of(state);
            is_made |= Some(state) == begun && outcome == LifecycleOutcome::Success;
            between = self.lifecycle.conclude(outcome);
        }
        self.shell.follow_lifecycle(self.clock.now(), self.lifecycle.state());
        let acted = self.act().await;
        asked.answer(is_made);
        acted
    }

    /// The state to begin with: active, or unconfigured.
    pub(crate) fn come_up(&mut self, autostart: bool) {
        if autostart {
            self.lifecycle.bring_up();
        }
        self.shell.follow_lifecycle(self.clock.now(), self.lifecycle.state());
    }

    fn work_of(&mut self, state: LifecycleState) -> LifecycleOutcome {
        let obstacle = match state {
            LifecycleState::Configuring => self.shell.against_configuring(),
            LifecycleState::Activating => self.shell.against_requests(self.clock.now()),
            _ => None,
        };
        let Some(obstacle) = obstacle else { return LifecycleOutcome::Success };
        self.ignore(format_args!("lifecycle, {}: {obstacle}", state.label()));
        LifecycleOutcome::Failure
    }
}
