//! A station whose node is not active.
//!
//! It is what it is after a start of its process: restored from its memory, with what moved stopped, and with a life that no order names
//! yet. So everything that is right for a restart is right here, and an order, a button or a goal from before is none. As long as it is
//! not active it takes no order of the mode, so that it stays in stand-by; its outputs are off whatever its controller has. It goes on
//! reading its devices and the others, answers their requests, and reports.

use linewright_lifecycle::LifecycleState;
use linewright_line::{Line, Tick};
use linewright_station_logic::{CompileError, Restore};

use super::StationShell;
use crate::effect::StationEffect;

impl StationShell {
    /// The same of a node that is not activated by its start. To be called before anything is handled.
    #[must_use]
    pub fn unconfigured(mut self) -> Self {
        self.lifecycle = LifecycleState::Unconfigured;
        self
    }

    /// Whether orders are followed and outputs may be on.
    pub fn is_active(&self) -> bool {
        self.lifecycle == LifecycleState::Active
    }

    /// State of the node; a primary one.
    pub fn lifecycle(&self) -> LifecycleState {
        self.lifecycle
    }

    /// Ends activity: everything off at once, and the last report of this life, which has the state `to`. Perform the effects, then go on
    /// with [`StationShell::renewed`].
    pub fn deactivate(&mut self, to: LifecycleState, effects: &mut Vec<StationEffect>) {
        effects.push(StationEffect::Drive(self.off()));
        self.lifecycle = to;
        self.outbox.outputs = 0;
        self.state_sequence += 1;
        effects.push(StationEffect::Tell { sequence: self.state_sequence });
    }

    /// The station in a new life, restored from its memory as by a start of its process, and not active.
    ///
    /// # Errors
    /// As [`StationShell::new`].
    pub fn renewed(&self, line: &Line, boot_id: u64) -> Result<Self, CompileError> {
        let mut renewed = StationShell::new(line, self.controller.station(), boot_id, Restore::From(self.snapshot()))?;
        renewed.rules = self.rules;
        renewed.lifecycle = if self.is_active() { LifecycleState::Inactive } else { self.lifecycle };
        renewed.ignored = self.ignored;
        Ok(renewed)
    }

    /// Goes over to another state that is not active, and reports it at once.
    pub fn stay_inactive(&mut self, now: Tick, state: LifecycleState) {
        if state != LifecycleState::Active && self.lifecycle != state {
            self.lifecycle = state;
            self.refresh_due = self.refresh_due.min(now);
        }
    }

    /// Begins activity: from now on orders are followed that name this life, which nobody gives before it is reported. False, and nothing
    /// changes, if the process stood still just before: the request may be from before that.
    pub fn activate(&mut self, now: Tick) -> bool {
        self.notice_gap(now);
        if now < self.doubts_until {
            return false;
        }
        self.lifecycle = LifecycleState::Active;
        self.refresh_due = self.refresh_due.min(now);
        true
    }
}
