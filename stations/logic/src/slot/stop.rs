//! An order whose motion is stopped: by a fault, or because the station is ordered to stop.
//!
//! Ordered to hold or to go back a station ends the motion under way first. Ordered to stop it stands where it is, as a
//! fault would stop it: the operation is incomplete, and only a person leads on from there. That lasts. The order counts as
//! secured from then on, also after a restart, so no copy of a message to leave it moves anything later; and one that was on
//! its way is not begun.
//!
//! It is the order that is stopped, not the station: a message about another order than the one in the slot stops nothing.

use crate::controller::Controller;
use crate::event::StopCause;
use crate::order::{OrderKey, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};

use super::SlotPhase;

impl Controller {
    /// Stops the motions of an order, whichever way it goes.
    pub(super) fn stop_order(&mut self, key: OrderKey) -> TaskReply {
        let Some(orders) = &self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        if !orders.rules.stops_at_once {
            return self.secure(key);
        }
        if let Some(slot) = orders.slot.filter(|slot| slot.key == key) {
            let waited = self.waited_for().map_or(TaskFailure::Cancelled, TaskFailure::Waiting);
            while let Some(moving) = self.tokens().iter().position(|token| self.place(token).is_operating()) {
                self.stop(moving, StopCause::Ordered);
            }
            // Where nothing moves nothing was stopped, and the order is over all the same.
            let failure = if slot.begun { TaskFailure::Stopped } else { waited };
            self.conclude(TaskOutcome::Failed(slot.phase.failed_with(failure)));
            self.stays_where_it_is(key);
        } else if orders.last_has_failed() == Some(key) {
            self.stays_where_it_is(key);
        }
        self.secure(key)
    }

    /// Nothing goes back from this order any more.
    fn stays_where_it_is(&mut self, key: OrderKey) {
        let Some(orders) = &mut self.orders else { return };
        if orders.secured.replace(key) != Some(key) {
            (self.due.report, self.due.outputs) = (true, true);
        }
    }

    /// An operation was stopped: nothing goes on by itself.
    pub(crate) fn order_stops(&mut self, cause: StopCause) {
        let Some(slot) = self.slot() else { return };
        let failure = match cause {
            StopCause::EStop | StopCause::Released => TaskFailure::Interrupted,
            StopCause::Restart => TaskFailure::Restarted,
            StopCause::Ordered => TaskFailure::Stopped,
            StopCause::Signal
            | StopCause::Watchdog
            | StopCause::SwitchStuck
            | StopCause::BothSwitchesOn { .. }
            | StopCause::Devices
            | StopCause::NotAtHome
            | StopCause::Interlock { .. }
            | StopCause::PositionLost { .. }
            | StopCause::IndexDoubtful { .. }
            | StopCause::Ambiguous => TaskFailure::Fault,
        };
        self.conclude(TaskOutcome::Failed(slot.phase.failed_with(failure)));
    }
}

impl SlotPhase {
    /// Outcome of an order that something has stopped: `stopped`, unless it was given up before.
    fn failed_with(self, stopped: TaskFailure) -> TaskFailure {
        match (self, stopped) {
            (SlotPhase::Ending { failure } | SlotPhase::Securing { failure: Some(failure) }, _) => failure,
            (SlotPhase::Running, stopped) => stopped,
            (SlotPhase::Securing { failure: None } | SlotPhase::Returning, TaskFailure::Stopped) => {
                TaskFailure::Stopped
            }
            (SlotPhase::Securing { failure: None } | SlotPhase::Returning, _) => TaskFailure::Held,
        }
    }
}
