//! An order that is left, by the coordinator's request: to go back, or to hold; and how far the station goes then.
//!
//! An order that was not received yet is remembered as cancelled, so that its message does nothing when it comes late.

use linewright_line::Tick;
use linewright_line::net::{ControlMode, StationPlace, TransitionKind};

use crate::controller::Controller;
use crate::event::HappeningKind;
use crate::order::{OrderKey, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};
use crate::program::bit;

use super::{ActiveOrder, SlotPhase};

impl Controller {
    /// Takes the station back to where the task of an order began, as far as that goes by itself, when the motion under way has ended.
    pub(super) fn secure(&mut self, key: OrderKey) -> TaskReply {
        // Where people move the station, nothing is ordered to move by itself later.
        let by_itself = match self.commands.granted(self.now) {
            ControlMode::Home | ControlMode::StandBy | ControlMode::Auto => true,
            ControlMode::Hand | ControlMode::Manual | ControlMode::EStop => false,
        };
        let place = self.marking().next().filter(|_| by_itself && self.rest().is_none());
        let leads_back = place.filter(|&place| place.is_operating() || self.goes_back_from(place));
        let task = leads_back.and_then(|place| self.task_of(place.op));
        let failure = self.waited_for().map(TaskFailure::Waiting);
        let Some(orders) = &mut self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        if let Some(slot) = orders.slot.as_mut().filter(|slot| slot.key == key) {
            match slot.phase {
                SlotPhase::Running => self.go_back(failure),
                SlotPhase::Ending { failure } => self.go_back(Some(failure)),
                SlotPhase::Securing { .. } | SlotPhase::Returning => (),
            }
        } else if orders.last_has_failed() == Some(key) && orders.slot.is_none() {
            // Copies of the message come late, when it is known that the station stands.
            let is_first = orders.secured.replace(key) != Some(key) || !orders.rules.secures_once;
            // It may stand where a person has left it since.
            if let Some(task) = task.filter(|_| is_first) {
                let phase = SlotPhase::Returning;
                let (limit, result_due) = (Tick::NEVER, Tick::NEVER);
                orders.slot = Some(ActiveOrder { key, task, limit, begun: true, result_due, phase });
                self.due.report = true;
                self.note(HappeningKind::Securing(task));
            }
        } else if orders.known(key).is_none() {
            return self.cancel(key);
        }
        self.left(key)
    }

    /// An order that was not received yet is not done when it is.
    fn cancel(&mut self, key: OrderKey) -> TaskReply {
        let Some(orders) = &mut self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        if let Some(refusal) = orders.too_old(key) {
            return TaskReply::Refused(refusal);
        }
        if orders.epoch == key.epoch {
            orders.last = key.id;
        }
        orders.remember(key, TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Cancelled)));
        orders.secured = Some(key);
        self.due.report = true;
        self.left(key)
    }

    /// Reply to the order to leave an order.
    fn left(&self, key: OrderKey) -> TaskReply {
        self.orders.as_ref().and_then(|orders| orders.known(key)).unwrap_or(TaskReply::Running)
    }

    /// Ends an order with the motion under way.
    pub(super) fn hold_order(&mut self, key: OrderKey) -> TaskReply {
        let waited = self.waited_for().map(TaskFailure::Waiting);
        let Some(orders) = &mut self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        if orders.known(key).is_none() {
            return self.cancel(key);
        }
        if let Some(slot) = orders.slot.as_mut().filter(|slot| slot.key == key && slot.phase == SlotPhase::Running) {
            let left = if slot.begun { TaskFailure::Held } else { TaskFailure::Cancelled };
            slot.phase = SlotPhase::Ending { failure: waited.unwrap_or(left) };
            self.due.report = true;
            self.follow_given_up();
        }
        self.left(key)
    }

    /// Whether an operation of the task with `waits`, or one that waits for other stations, has started and is not taken back, or it is
    /// not known where the station stands: another one may rely on it. It follows from the place alone, so it outlasts a restart.
    pub(crate) fn is_in_handshake(&self) -> bool {
        let (Some(tasks), Some(place)) = (&self.program.tasks, self.marking().next()) else { return true };
        // Where it stands is not known: it may stand anywhere.
        if self.marking.path.is_some() || !self.is_placed() {
            return true;
        }
        if self.rest().is_some() {
            return false;
        }
        let first = tasks.task(tasks.task_of[place.op.index()]).first_step;
        let at = self.program.step_of[place.op.index()];
        let reached = if place == StationPlace::undone(place.op) { at } else { at + 1 };
        let waits = |step: usize| tasks.waits[step].0 != 0 || !self.program.causes[step].is_empty();
        (usize::from(first)..usize::from(reached)).any(waits)
    }

    /// The order is not done any more: the station goes back if it has begun.
    fn go_back(&mut self, failure: Option<TaskFailure>) {
        let Some(slot) = self.orders.as_mut().and_then(|orders| orders.slot.as_mut()) else { return };
        if !slot.begun {
            return self.conclude(TaskOutcome::Failed(failure.unwrap_or(TaskFailure::Cancelled)));
        }
        slot.phase = SlotPhase::Securing { failure };
        let task = slot.task;
        self.due.report = true;
        self.note(HappeningKind::Securing(task));
    }

    /// Looks whether a station has come as far as it can with an order that it has given up.
    pub(crate) fn follow_given_up(&mut self) {
        let given_up = match self.slot().map(|slot| slot.phase) {
            Some(SlotPhase::Ending { failure }) => return self.end_standing(failure),
            Some(SlotPhase::Securing { failure }) => failure,
            Some(SlotPhase::Returning) => None,
            Some(SlotPhase::Running) => return,
            None => return self.rests(),
        };
        let Some(place) = self.marking().next() else { return };
        if place.is_operating() || (self.rest().is_none() && self.goes_back_from(place)) {
            return;
        }
        // At the first operation's beginning the token goes on to the rest; that is no motion.
        let left = if self.rest().is_some() { TaskFailure::Cancelled } else { TaskFailure::Held };
        self.conclude(TaskOutcome::Failed(given_up.unwrap_or(left)));
    }

    /// An order that goes no further ends when nothing moves.
    fn end_standing(&mut self, failure: TaskFailure) {
        if !self.marking().any(StationPlace::is_operating) {
            self.conclude(TaskOutcome::Failed(failure));
        }
    }

    /// At a rest there is nothing to go back from, wherever a person leads it to before it is ordered to.
    fn rests(&mut self) {
        let failed = self.orders.as_ref().and_then(|orders| orders.last_has_failed().filter(|_| self.rest().is_some()));
        if self.rest().is_some()
            && let Some(orders) = &mut self.orders
        {
            // What begins there next is another task, or has an order of its own.
            orders.parameters = None;
        }
        if let (Some(key), Some(orders)) = (failed, &mut self.orders) {
            self.due.report |= orders.secured != Some(key);
            orders.secured = Some(key);
        }
    }

    /// Whether something leads back from a place in auto. On a recovery path nothing does by itself.
    fn goes_back_from(&self, place: StationPlace) -> bool {
        if self.marking.path.is_some() {
            return false;
        }
        let (start, end) =
            self.program.places[usize::from(self.program.index_of(place))].rows[ControlMode::Auto as usize];
        self.program.rows[usize::from(start)..usize::from(end)].iter().any(|row| {
            let kind = self.program.actions[usize::from(row.transition)].kind;
            row.need & bit::SECURE != 0 || matches!(kind, TransitionKind::GiveUp(_))
        })
    }
}
