//! Results of motions: what is to be there when an operation of a task has completed, such as a part in the hand.
//!
//! In auto the next operation of the task waits for it as for its other inputs. It has its own time, from the end of the motion;
//! after that the order ends at once with its code, as one does whose time is over. A result that is lost again before the next
//! operation starts ends the order as well. While the inputs are not known, its time does not end the order. In hand and manual mode it is not
//! waited for: people see what is in the hand, and lead a station on to its rest also with an empty one.

use linewright_line::{MotionResult, OpId, Tick};

use super::SlotPhase;
use crate::controller::Controller;
use crate::order::TaskFailure;

impl Controller {
    /// The next time at which a result has to be there.
    pub(crate) fn result_limit(&self) -> Tick {
        let slot = self.slot().filter(|slot| slot.phase == SlotPhase::Running && slot.result_due > self.now);
        slot.map_or(Tick::NEVER, |slot| slot.result_due)
    }

    /// An operation of the order is complete: from now on its result has to come.
    pub(super) fn result_begins(&mut self, op: OpId) {
        let step = usize::from(self.program.step_of[op.index()]) + 1;
        let result = self.program.tasks.as_ref().and_then(|tasks| *tasks.results.get(step)?);
        let due = result.map_or(Tick::NEVER, |result| self.now + result.within);
        if let Some(slot) = self.orders.as_mut().and_then(|orders| orders.slot.as_mut()) {
            slot.result_due = due;
        }
    }

    /// The caller stood still: what is known of the inputs is of before, so the result has its whole time again.
    pub(crate) fn result_after_gap(&mut self, now: Tick) {
        let Some(result) = self.missing_result() else { return };
        if let Some(slot) = self.orders.as_mut().and_then(|orders| orders.slot.as_mut()) {
            slot.result_due = slot.result_due.max(now + result.within);
        }
    }

    /// The result that the next operation of the order waits for, where it is not there.
    pub(super) fn missing_result(&self) -> Option<MotionResult> {
        let step = self.next_step()?;
        let result = (*self.program.tasks.as_ref()?.results.get(usize::from(step))?)?;
        (self.image.bits & result.input.bit() == 0).then_some(result)
    }

    /// Looks whether a result is missing after its time.
    pub(crate) fn watch_result(&mut self) {
        let is_due = self.slot().is_some_and(|slot| slot.phase == SlotPhase::Running && slot.result_due <= self.now);
        let Some(result) = self.missing_result().filter(|_| is_due && self.image.valid) else { return };
        let Some(slot) = self.orders.as_mut().and_then(|orders| orders.slot.as_mut()) else { return };
        slot.phase = SlotPhase::Ending { failure: TaskFailure::Waiting(result.code) };
        slot.limit = slot.limit.min(self.now);
        self.due.report = true;
    }
}
