//! Transitions of the node: what each does at a station.

use linewright_lifecycle::{LifecycleOutcome, LifecycleState};
use linewright_node_shell::{ChangeRequest, fresh_boot_id};
use linewright_station_shell::StationEffect;

use crate::node::{StationLoop, StationNodeError};

impl StationLoop {
    /// Makes the transition of a request, and answers. Outputs that it takes off are off before the answer.
    pub(crate) async fn change(&mut self, asked: ChangeRequest) -> Result<(), StationNodeError> {
        let mut is_made = false;
        let mut between = self.lifecycle.begin(&asked);
        let begun = between;
        while let Some(state) = between {
            let outcome = self.work_of(state);
            is_made |= Some(state) == begun && outcome == LifecycleOutcome::Success;
            between = self.lifecycle.conclude(outcome);
        }
        self.shell.stay_inactive(self.clock.now(), self.lifecycle.state());
        let acted = self.act().await;
        asked.answer(is_made);
        acted
    }

    fn work_of(&mut self, state: LifecycleState) -> LifecycleOutcome {
        match state {
            LifecycleState::Configuring => self.renew(),
            LifecycleState::Activating => {
                if self.shell.activate(self.clock.now()) {
                    return LifecycleOutcome::Success;
                }
                self.ignore("transition activate: the node stood still just before it; give it again");
                LifecycleOutcome::Failure
            }
            LifecycleState::Deactivating => self.stand_down(LifecycleState::Inactive),
            LifecycleState::ShuttingDown => self.stand_down(LifecycleState::Finalized),
            LifecycleState::ErrorProcessing => self.stand_down(LifecycleState::Unconfigured),
            // Bus, journal and topics are those of the process.
            LifecycleState::CleaningUp
            | LifecycleState::Unknown
            | LifecycleState::Unconfigured
            | LifecycleState::Inactive
            | LifecycleState::Active
            | LifecycleState::Finalized => LifecycleOutcome::Success,
        }
    }

    /// Lets go of everything at once.
    pub(crate) fn stand_down(&mut self, to: LifecycleState) -> LifecycleOutcome {
        if !self.shell.is_active() {
            return LifecycleOutcome::Success;
        }
        let mut effects = Vec::new();
        self.shell.deactivate(to, &mut effects);
        for effect in effects {
            match effect {
                StationEffect::Drive(image) => self.drive(image),
                StationEffect::Tell { sequence } => self.tell_state(self.clock.now(), sequence),
                StationEffect::Remember
                | StationEffect::Reply(..)
                | StationEffect::Happened(_)
                | StationEffect::Ignored { .. } => {}
            }
        }
        self.renew()
    }

    /// Makes the controller anew from what it remembers, in a new life.
    fn renew(&mut self) -> LifecycleOutcome {
        let boot_id = fresh_boot_id();
        match self.shell.renewed(&self.line, boot_id) {
            Ok(renewed) => self.shell = renewed,
            Err(error) => {
                tracing::error!(station = self.name, "the controller cannot be made anew: {error}");
                return LifecycleOutcome::Error;
            }
        }
        if let Some(orders) = &mut self.says.orders {
            orders.renew(boot_id);
        }
        // The new controller has not seen its devices yet.
        self.bus_news(&[]);
        LifecycleOutcome::Success
    }
}
