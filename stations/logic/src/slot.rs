//! A station's orders: their course from arrival to end.
//!
//! ```text
//!            taken on                       its last operation is complete
//!   no order ────────▶ running ────────────────────────────────────────────▶ done
//!                       │   │ a fault, another mode, a restart, ordered to stop
//!                       │   └──────────────────────────────────────────────▶ failed: stands where it is
//!                       │ its time is over ┐
//!                       │ ordered to hold ─┴──▶ ending ──the motion under way has ended──▶ failed: stands where it is
//!                       │                         │
//!                       └──ordered to secure──────┴──▶ securing ──it stands: where the task began, or as far as it
//!                                                                 goes by itself──▶ failed
//! ```
//!
//! An order that is given up has not ended before the station stands: until then it is in the slot, and in no result. It fails
//! with the code of what it waited for (a result before other inputs); else because its time was over, or because it was ordered to
//! leave it.
//! When its time is over the station goes no way by itself: another station of the same activity may rely on where it stands, which
//! the coordinator alone can see. One that its time or a fault has ended may be ordered to secure once; it is in the slot again
//! until it stands, and copies of that message start nothing later. An order to stop is in `stop`.
//!
//! A final refusal it keeps: a copy of the message that comes late, when the reason has gone, is refused all the same. A
//! refusal for now is not kept. All that it keeps is in its snapshot, which is written before anything is driven or sent. A
//! station that comes up has ended its order: its outputs went off, and a person should look. One that comes up without its
//! memory draws a new number for it, and orders name the memory they are meant for.
//!
//! The message to leave an order names neither memory nor sender. So it ends nothing but the order that it names, and is no
//! sign of a later life of the coordinator.

mod leave;
mod report;
mod result;
mod stop;

use std::cmp::Ordering;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, RestId, TaskId, Tick};

use crate::controller::Controller;
use crate::event::HappeningKind;
use crate::ignored::Ignored;
use crate::order::{
    EPOCH_AHEAD_MAX, LeaveWay, OrderKey, OrderMemory, RESULTS_MAX, TaskCommand, TaskFailure, TaskOrder, TaskOutcome,
    TaskRefusal, TaskReply,
};
use crate::program::{bit, task_bit};
use crate::rules::OrderRules;
use crate::tasks::StationTasks;

/// The orders of a task-driven station.
#[derive(Clone, Debug, Default)]
pub(crate) struct OrderSlot {
    memory: u64,
    epoch: u64,
    last: u64,
    slot: Option<ActiveOrder>,
    results: Vec<(OrderKey, TaskReply)>,
    /// The ended order that it has been ordered to secure.
    secured: Option<OrderKey>,
    /// The task of the last order, and the outputs that carry its parameters: also when the order has failed, as long as the station stands
    /// within the task. Whichever way it goes on from there, by itself or led by a person, the place that was meant is the same.
    parameters: Option<(TaskId, u128)>,
    /// Whether a person has confirmed them, since this start.
    has_confirmed_parameters: bool,
    pub rules: OrderRules,
    /// Replies since the last step.
    pub replies: Vec<(OrderKey, TaskReply)>,
}

#[derive(Clone, Copy, Debug)]
struct ActiveOrder {
    key: OrderKey,
    task: TaskId,
    limit: Tick,
    /// Its first operation has started.
    begun: bool,
    /// When the result of the operation that was completed last has to be there.
    result_due: Tick,
    phase: SlotPhase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SlotPhase {
    Running,
    /// It goes no further: the order ends with the motion under way.
    Ending {
        failure: TaskFailure,
    },
    /// On its way back; the order ends where that ends.
    Securing {
        /// Reason why it was given up; none if it was ordered to leave it and waited for nothing.
        failure: Option<TaskFailure>,
    },
    /// On its way back from an order that had ended before.
    Returning,
}

impl SlotPhase {
    /// The coordinator has ordered it back.
    const fn goes_back(self) -> bool {
        match self {
            SlotPhase::Running | SlotPhase::Ending { .. } => false,
            SlotPhase::Securing { .. } | SlotPhase::Returning => true,
        }
    }
}

/// The newest epoch that may follow this one; any may be the first.
const fn ahead_of(epoch: u64) -> u64 {
    if epoch == 0 { u64::MAX } else { epoch.saturating_add(EPOCH_AHEAD_MAX) }
}

impl OrderSlot {
    /// Of a station that has never had an order.
    pub fn new(memory: u64) -> Self {
        OrderSlot { memory, ..OrderSlot::default() }
    }

    fn remember(&mut self, key: OrderKey, reply: TaskReply) {
        if self.results.len() == RESULTS_MAX {
            self.results.remove(0);
        }
        self.results.push((key, reply));
    }

    fn known(&self, key: OrderKey) -> Option<TaskReply> {
        let slot = self.slot.filter(|slot| slot.key == key).map(|_| TaskReply::Running);
        slot.or_else(|| self.results.iter().find(|(known, _)| *known == key).map(|(_, reply)| *reply))
    }

    /// The station has nothing to do with a key that is not newer than this.
    fn too_old(&self, key: OrderKey) -> Option<TaskRefusal> {
        match key.epoch.cmp(&self.epoch) {
            Ordering::Less => Some(TaskRefusal::OldEpoch),
            Ordering::Equal => (key.id <= self.last).then_some(TaskRefusal::Old),
            Ordering::Greater => None,
        }
    }

    /// The last order has failed: the station may be ordered back from it.
    fn last_has_failed(&self) -> Option<OrderKey> {
        self.results.last().and_then(|(key, reply)| match reply {
            TaskReply::Ended(TaskOutcome::Failed(_)) => Some(*key),
            TaskReply::Ended(TaskOutcome::Done) | TaskReply::Running | TaskReply::Refused(_) => None,
        })
    }

    /// Everything here that decides the station's future, as numbers (see [`Controller::situation`]).
    pub fn situation(&self, out: &mut Vec<i64>) {
        let failed = self.last_has_failed();
        out.push(i64::from(failed.is_some()) + i64::from(failed.is_some() && failed == self.secured));
        match self.slot {
            None => out.push(-1),
            Some(slot) => {
                let phase = match slot.phase {
                    SlotPhase::Running => 0,
                    SlotPhase::Securing { failure: _ } => 1,
                    SlotPhase::Returning => 2,
                    SlotPhase::Ending { failure: _ } => 3,
                };
                out.extend([i64::from(slot.task.0), i64::from(slot.begun), phase]);
                let image = self.parameters.map_or(0, |(_, image)| image);
                out.extend([(image >> 64) as i64, image as i64]);
            }
        }
    }

    /// Record to keep.
    pub fn memory(&self) -> OrderMemory {
        let open = self.slot.filter(|slot| slot.phase != SlotPhase::Returning);
        let left = open.filter(|slot| slot.phase.goes_back()).map(|slot| slot.key);
        OrderMemory {
            memory: self.memory,
            epoch: self.epoch,
            last: self.last,
            slot: open.map(|slot| slot.key),
            results: self.results.clone(),
            secured: left.or(self.secured),
            parameters: self.parameters,
        }
    }

    /// State of a station that comes up, from its record. The record may be of before a change of the wiring: of its parameters those outputs
    /// are taken that carry parameters of the task now.
    pub fn restored(kept: OrderMemory, tasks: &StationTasks) -> Self {
        let parameters = kept.parameters.and_then(|(task, image)| {
            let bits = tasks.tasks.get(task.index())?.parameters.iter().flat_map(|parameter| &parameter.bits);
            Some((task, image & bits.fold(0, |bits, output| bits | output.bit())))
        });
        let mut orders = OrderSlot {
            memory: kept.memory,
            epoch: kept.epoch,
            last: kept.last,
            results: kept.results,
            secured: kept.secured,
            parameters,
            ..OrderSlot::default()
        };
        let surplus = orders.results.len().saturating_sub(RESULTS_MAX);
        orders.results.drain(..surplus);
        if let Some(key) = kept.slot {
            orders.remember(key, TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Restarted)));
        }
        orders
    }
}

impl Controller {
    /// Takes a command. Gives false at a station that is not task-driven.
    pub(crate) fn command(&mut self, command: TaskCommand<'_>) -> Result<(), Ignored> {
        let orders = self.orders.as_ref().ok_or(Ignored::NoTasks)?;
        let epoch = orders.epoch;
        let (key, known) = match command {
            TaskCommand::Run(order) => (order.key, orders.known(order.key).filter(|_| orders.rules.does_once)),
            TaskCommand::Leave(key, _) => (key, None),
        };
        let reply = match (known, command) {
            (Some(reply), _) => reply,
            (None, TaskCommand::Run(order)) => self.run(order),
            (None, TaskCommand::Leave(key, LeaveWay::Back)) => self.secure(key),
            (None, TaskCommand::Leave(key, LeaveWay::Hold)) => self.hold_order(key),
            (None, TaskCommand::Leave(key, LeaveWay::Stop)) => self.stop_order(key),
        };
        if let Some(orders) = &mut self.orders {
            orders.replies.push((key, reply));
        }
        self.due.settled = false;
        if key.epoch <= ahead_of(epoch) { Ok(()) } else { Err(Ignored::EpochTooHigh) }
    }

    fn run(&mut self, order: &TaskOrder) -> TaskReply {
        let now = self.now;
        let may_start = self.commands.granted(now) == ControlMode::Auto && !self.commands.is_stopping();
        let Some(orders) = &mut self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        let is_of_another = order.memory != orders.memory || order.key.epoch > ahead_of(orders.epoch);
        if is_of_another && orders.rules.own_memory {
            return TaskReply::Refused(TaskRefusal::OtherMemory);
        }
        if let Some(refusal) = orders.too_old(order.key).filter(|_| orders.rules.does_once) {
            return TaskReply::Refused(refusal);
        }
        if orders.epoch != order.key.epoch {
            // Numbers rise within a life; a coordinator that has lost its records begins anew with both.
            (orders.epoch, orders.last) = (order.key.epoch, 0);
            self.due.report = true;
        }
        if orders.slot.is_some() {
            return TaskReply::Refused(TaskRefusal::Busy);
        }
        if !may_start {
            return TaskReply::Refused(TaskRefusal::Mode);
        }
        let begun = self.begin(order);
        let Some(orders) = &mut self.orders else { return TaskReply::Refused(TaskRefusal::Unknown) };
        orders.last = order.key.id;
        self.due.report = true;
        match begun {
            Ok((slot, image)) => {
                orders.slot = Some(slot);
                (orders.parameters, orders.has_confirmed_parameters) = (Some((slot.task, image)), false);
                self.due.outputs = true;
                self.note(HappeningKind::Ordered(slot.task));
                TaskReply::Running
            }
            Err(refusal) => {
                orders.remember(order.key, TaskReply::Refused(refusal));
                self.note(HappeningKind::OrderRefused(refusal));
                TaskReply::Refused(refusal)
            }
        }
    }

    /// The order as it would be done, with the outputs of its parameters; why it will not be.
    fn begin(&self, order: &TaskOrder) -> Result<(ActiveOrder, u128), TaskRefusal> {
        let tasks = self.program.tasks.as_ref().ok_or(TaskRefusal::Unknown)?;
        if order.limit.is_zero() {
            return Err(TaskRefusal::Late);
        }
        let index = tasks.tasks.iter().position(|task| *task.name == *order.task).ok_or(TaskRefusal::Unknown)?;
        let task = &tasks.tasks[index];
        let image = task.image(&order.parameters).map_err(|_| TaskRefusal::Unknown)?;
        if !self.image.valid {
            return Err(TaskRefusal::Devices);
        }
        if self.marking().any(StationPlace::is_incomplete) {
            return Err(TaskRefusal::Incomplete);
        }
        if self.rest() != Some(task.from) {
            return Err(TaskRefusal::NotThere);
        }
        let limit = self.now + order.limit.min(task.limit);
        let task = TaskId::at(index);
        Ok((
            ActiveOrder {
                key: order.key,
                task,
                limit,
                begun: false,
                result_due: Tick::NEVER,
                phase: SlotPhase::Running,
            },
            image,
        ))
    }

    pub(crate) fn task_of(&self, op: OpId) -> Option<TaskId> {
        self.program.tasks.as_ref().map(|tasks| tasks.task_of[op.index()])
    }

    /// The rest a task-driven station stands at.
    pub(crate) fn rest(&self) -> Option<RestId> {
        let tasks = self.program.tasks.as_ref().filter(|_| self.marking.path.is_none())?;
        let place = self.marking().next()?;
        let task = tasks.task(tasks.task_of[place.op.index()]);
        if place == StationPlace::completed(task.last) {
            Some(task.to)
        } else {
            (place == StationPlace::undone(task.first)).then_some(task.from)
        }
    }

    /// Bits of the condition variables that follow from the orders. Nothing goes back without devices.
    pub(crate) fn order_bits(&self) -> u128 {
        match self.slot() {
            Some(ActiveOrder { phase: SlotPhase::Running, task, .. }) => task_bit(task),
            Some(ActiveOrder { phase: SlotPhase::Securing { .. } | SlotPhase::Returning, .. }) if self.image.valid => {
                bit::SECURE
            }
            Some(ActiveOrder {
                phase: SlotPhase::Ending { .. } | SlotPhase::Securing { .. } | SlotPhase::Returning,
                ..
            })
            | None => 0,
        }
    }

    fn refresh_orders(&mut self) {
        let bits = self.order_bits();
        self.levels.now = self.levels.now & !bit::ORDERS | bits;
        self.levels.before = self.levels.before & !bit::ORDERS | bits;
    }

    /// Whether it is doing an order, or going back from one.
    pub(crate) fn has_order(&self) -> bool {
        self.slot().is_some()
    }

    /// The outputs that carry the parameters of this task, as far as they are known.
    pub(crate) fn known_parameters(&self, of: TaskId) -> Option<(TaskId, u128)> {
        self.orders.as_ref()?.parameters.filter(|&(task, _)| task == of)
    }

    /// A person has confirmed the parameters, or a place where there are none.
    pub(crate) fn confirm_parameters(&mut self, parameters: Option<(TaskId, u128)>) {
        if let Some(orders) = &mut self.orders {
            (orders.parameters, orders.has_confirmed_parameters) = (parameters, true);
        }
    }

    /// Whether the parameters are those that a person has confirmed.
    pub(crate) fn has_confirmed_parameters(&self) -> bool {
        self.orders.as_ref().is_some_and(|orders| orders.has_confirmed_parameters)
    }

    fn slot(&self) -> Option<ActiveOrder> {
        self.orders.as_ref().and_then(|orders| orders.slot)
    }

    /// The outputs that carry the parameters of the task that is done, or that a person leads on or back.
    ///
    /// They may be on without an order: a parameter moves nothing, it is where the next motion of the task leads to, and that motion has an
    /// actuator of its own. They are off in the emergency stop, and without an order where nobody leads the station: so none is on after a
    /// restart before a mode was given.
    pub(crate) fn parameter_outputs(&self) -> u128 {
        let Some((task, image)) = self.orders.as_ref().and_then(|orders| orders.parameters) else { return 0 };
        let is_within = || self.marking().next().is_some_and(|place| self.task_of(place.op) == Some(task));
        match self.commands.mode() {
            ControlMode::EStop => 0,
            _ if self.slot().is_some() => image,
            ControlMode::Hand | ControlMode::Manual if self.rest().is_none() && is_within() => image,
            _ => 0,
        }
    }

    /// End of the time of the order.
    pub(crate) fn order_limit(&self) -> Tick {
        self.slot().filter(|slot| slot.phase == SlotPhase::Running).map_or(Tick::NEVER, |slot| slot.limit)
    }

    /// A task's first operation starts.
    pub(crate) fn order_begins(&mut self, step: u8) {
        let Some(tasks) = &self.program.tasks else { return };
        let Some(slot) = self.orders.as_mut().and_then(|orders| orders.slot.as_mut()) else { return };
        slot.begun |= tasks.task(slot.task).first_step == step;
    }

    /// An operation is complete. The last one of the task is its end, on the way back too: the task is done.
    pub(crate) fn order_completes(&mut self, op: OpId) {
        let Some(slot) = self.slot().filter(|slot| slot.begun) else { return };
        if self.program.tasks.as_ref().is_some_and(|tasks| tasks.task(slot.task).last == op) {
            self.conclude(TaskOutcome::Done);
        }
        self.result_begins(op);
    }

    /// The mode has changed: where people move the station, an order is over.
    pub(crate) fn order_in_mode(&mut self, mode: ControlMode) {
        match mode {
            ControlMode::Home | ControlMode::StandBy | ControlMode::Auto => {}
            ControlMode::Hand | ControlMode::Manual | ControlMode::EStop => {
                let failure = match self.slot().map(|slot| slot.phase) {
                    Some(SlotPhase::Ending { failure } | SlotPhase::Securing { failure: Some(failure) }) => failure,
                    Some(SlotPhase::Running | SlotPhase::Securing { failure: None } | SlotPhase::Returning) => {
                        TaskFailure::Interrupted
                    }
                    None => return,
                };
                self.conclude(TaskOutcome::Failed(failure));
            }
        }
    }

    /// Looks whether the time of the order is over.
    pub(crate) fn watch_order(&mut self) {
        if self.now < self.order_limit() {
            return;
        }
        let failure = self.waited_for().map_or(TaskFailure::TimedOut, TaskFailure::Waiting);
        let Some(orders) = &mut self.orders else { return };
        let Some(slot) = &mut orders.slot else { return };
        slot.phase = SlotPhase::Ending { failure };
        if !orders.rules.ends_standing {
            slot.phase = SlotPhase::Returning;
            let key = slot.key;
            orders.remember(key, TaskReply::Ended(TaskOutcome::Failed(failure)));
        }
        self.due.report = true;
    }

    /// The step that the order would go on with, where the station stands between two.
    pub(crate) fn next_step(&self) -> Option<u8> {
        let (tasks, slot) = (self.program.tasks.as_ref()?, self.slot()?);
        if !slot.begun {
            return Some(tasks.task(slot.task).first_step);
        }
        let place = self.marking().next()?;
        (place == StationPlace::completed(place.op)).then(|| self.program.step_of[place.op.index()] + 1)
    }

    /// The code of the inputs that the order waits for.
    fn waited_for(&self) -> Option<u16> {
        // Before its time, or while the inputs are not known, a result is not missing yet.
        let is_due = self.image.valid && self.slot().is_some_and(|slot| slot.result_due <= self.now);
        if let Some(result) = self.missing_result().filter(|_| is_due) {
            return Some(result.code);
        }
        let step = self.next_step().filter(|&step| self.missing(step) != 0)?;
        let (_, code) = *self.program.tasks.as_ref()?.waits.get(usize::from(step))?;
        (code != 0).then_some(code)
    }

    /// The order is over, by this unless it was before.
    fn conclude(&mut self, outcome: TaskOutcome) {
        let Some(orders) = &mut self.orders else { return };
        let Some(slot) = orders.slot.take() else { return };
        if slot.phase.goes_back() {
            orders.secured = Some(slot.key);
        }
        if slot.phase != SlotPhase::Returning {
            orders.remember(slot.key, TaskReply::Ended(outcome));
            self.note(match outcome {
                TaskOutcome::Done => HappeningKind::OrderDone(slot.task),
                // The code is also that of an order whose time was over.
                TaskOutcome::Failed(TaskFailure::Waiting(code)) if self.now < slot.limit => {
                    HappeningKind::OrderLeft(slot.task, code)
                }
                TaskOutcome::Failed(failure) => HappeningKind::OrderFailed(slot.task, failure),
            });
        }
        self.due.report = true;
        self.due.outputs = true;
        self.refresh_orders();
    }
}
