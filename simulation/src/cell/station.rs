//! A task-driven station, pretended: it does one order at a time, keeps past ones over its own restarts, and does
//! no key twice.
//!
//! It answers as the token player expects of every station. What it has really done is in [`SimulatedStation::done`], which the
//! player cannot see: work done twice is found there.

use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::{OrderMessage, PartId, Presence, StationUnavailable, TaskReport};
use linewright_line::{RestId, Tick};
use linewright_orders::{LeaveWay, OrderKey, RESULTS_MAX, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};

use crate::rng::Rng;

/// The code of those orders that fail by chance.
const CODE: u16 = 7;
/// Time of going back.
const WAY_BACK: Duration = Duration::from_millis(400);

/// Something that a station has begun to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BegunTask {
    pub key: OrderKey,
    /// Name of the task.
    pub task: Arc<str>,
    /// Parameters of the task, by name.
    pub parameters: Vec<(Arc<str>, i32)>,
    pub part: Option<PartId>,
    /// Time of the start.
    pub began: Tick,
}

/// A pretended station.
#[derive(Clone, Debug, Default)]
pub struct SimulatedStation {
    heard: TaskReport,
    doing: Option<(OrderKey, Tick)>,
    /// It is on its way back from its order, for this reason.
    is_securing: Option<TaskFailure>,
    /// The order that it has been ordered to leave last.
    secured: Option<OrderKey>,
    /// Time limit of its order.
    limit: Tick,
    /// Time since which it stands, and nothing goes on, if it does.
    stands: Option<Tick>,
    /// Time at work until `metered`.
    worked: Duration,
    metered: Tick,
    last: u64,
    /// All it has really done, each time it did it.
    pub done: Vec<BegunTask>,
    /// Number of repeated messages received.
    pub doubled: usize,
    /// Refusals.
    pub refused: Vec<TaskRefusal>,
    /// One order in so many ends with a code; none with 0.
    pub failing: u64,
    /// The code with which the order ends that it is doing, or the next.
    pub fails_with: Option<u16>,
    /// What is wrong with it, for people.
    pub fault: String,
    /// Nothing reaches it, and nothing is received from it. Its work goes on.
    pub is_away: bool,
    /// Its work does not end. It can be left nevertheless.
    pub is_stuck: bool,
    /// Its orders wait for an input before their first operation: nothing has moved when one is left.
    pub waits_to_begin: bool,
    /// Code of an endless wait of an order.
    pub waits_code: Option<u16>,
    /// By so much the time of its orders is over sooner than it was given.
    pub fast: Duration,
    /// Ordered to leave an order it stays where it is, between rests.
    pub holds: bool,
    /// It stands between rests.
    pub is_held: bool,
    /// The rest at which it says that it stands; its first where it waits to begin.
    pub rest: Option<RestId>,
    /// Why it takes nothing on.
    pub unable: Option<StationUnavailable>,
    /// State of its sensor.
    pub presence: Presence,
    /// Outcomes of all that it has really begun, with times.
    pub ended: Vec<(OrderKey, TaskOutcome, Tick)>,
}

impl SimulatedStation {
    /// Its report.
    pub fn heard(&self) -> TaskReport {
        let SimulatedStation { is_held, unable, presence, .. } = *self;
        let rest = self.rest.or(self.waits_to_begin.then_some(RestId(0)));
        // Whatever it does it may do with another station.
        let fault = self.fault.clone();
        TaskReport { is_held, is_in_handshake: is_held, rest, unable, presence, fault, ..self.heard.clone() }
    }

    /// The order it is doing, or going back from.
    pub fn doing(&self) -> Option<OrderKey> {
        self.doing.map(|(key, _)| key)
    }

    /// A person stops it, and brings it to a rest.
    pub fn bring_to_rest(&mut self, now: Tick) {
        self.is_held = false;
        if let Some((key, _)) = self.doing.take() {
            self.end(now, key, TaskOutcome::Failed(TaskFailure::Interrupted));
        }
    }

    /// Whatever it does ends where it is.
    pub(super) fn emergency_stop(&mut self, now: Tick) {
        if let Some((key, _)) = self.doing.take() {
            self.is_held = true;
            self.end(now, key, TaskOutcome::Failed(TaskFailure::Interrupted));
        }
    }

    /// It breaks down: its order stands still, and new orders wait.
    pub fn stand(&mut self, now: Tick) {
        self.meter(now);
        self.stands.get_or_insert(now);
    }

    /// It is repaired: its order goes on where it stood.
    pub fn go_on(&mut self, now: Tick) {
        self.meter(now);
        if let Some(since) = self.stands.take() {
            let stood = now.since(since);
            self.limit = self.limit + stood;
            self.doing = self.doing.map(|(key, until)| (key, until + stood));
        }
    }

    /// Time at work so far, without the time in which it stood.
    pub fn worked(&mut self, now: Tick) -> Duration {
        self.meter(now);
        self.worked
    }

    fn meter(&mut self, now: Tick) {
        if self.doing.is_some() && self.stands.is_none() {
            self.worked += now.since(self.metered);
        }
        self.metered = now;
    }

    /// From when on the time of a new order counts: as long as it stands, nothing goes on.
    fn counts_from(&self, now: Tick) -> Tick {
        self.stands.unwrap_or(now)
    }

    /// Time at which its work will be done.
    pub fn ends(&self) -> Option<Tick> {
        let (_, until) = self.doing.filter(|_| self.stands.is_none())?;
        let goes_on = self.is_securing.is_some() || (!self.does_not_end() && until <= self.limit);
        Some(if goes_on { until } else { self.limit })
    }

    fn does_not_end(&self) -> bool {
        self.is_stuck || self.waits_to_begin
    }

    /// Erases its memory; it is doing nothing.
    pub fn forget(&mut self) {
        self.heard = TaskReport { memory: self.heard.memory + 1, ..TaskReport::default() };
        (self.doing, self.is_securing, self.last) = (None, None, 0);
    }

    /// The same, and no report shows it: broken on purpose, for a check that has to find it.
    pub fn forget_unseen(&mut self) {
        let memory = self.heard.memory;
        self.forget();
        self.heard.memory = memory;
    }

    /// Reply to an order, which takes so long; none if it does not arrive.
    pub(super) fn told(&mut self, now: Tick, order: &OrderMessage, takes: Duration) -> Option<TaskReply> {
        if self.is_away {
            return None;
        }
        let OrderMessage { part, order, .. } = order;
        let key = order.key;
        if self.doing.is_some_and(|(doing, _)| doing == key) {
            self.doubled += 1;
            return Some(TaskReply::Running);
        }
        if let Some(&(_, outcome)) = self.heard.results.iter().find(|(had, _)| *had == key) {
            self.doubled += 1;
            return Some(TaskReply::Ended(outcome));
        }
        let refusal = if order.memory != self.heard.memory {
            TaskRefusal::OtherMemory
        } else if key.epoch < self.heard.epoch {
            TaskRefusal::OldEpoch
        } else if key.epoch == self.heard.epoch && key.id <= self.last {
            TaskRefusal::Old
        } else if self.doing.is_some() {
            TaskRefusal::Busy
        } else if order.limit.is_zero() {
            TaskRefusal::Late
        } else if self.is_held {
            TaskRefusal::NotThere
        } else if let Some(unable) = self.unable {
            match unable {
                StationUnavailable::Devices => TaskRefusal::Devices,
                StationUnavailable::Incomplete => TaskRefusal::Incomplete,
                StationUnavailable::Inactive | StationUnavailable::ByHand | StationUnavailable::InManual => {
                    TaskRefusal::Mode
                }
            }
        } else {
            (self.heard.epoch, self.last, self.heard.slot) = (key.epoch, key.id, Some(key));
            self.meter(now);
            self.doing = Some((key, self.counts_from(now) + takes));
            self.limit = self.counts_from(now) + order.limit.saturating_sub(self.fast);
            let (task, parameters) = (order.task.clone(), order.parameters.clone());
            self.done.push(BegunTask { key, task, parameters, part: *part, began: now });
            return Some(TaskReply::Running);
        };
        self.refused.push(refusal);
        Some(TaskReply::Refused(refusal))
    }

    /// Ends its order when the time has come.
    pub(super) fn tick(&mut self, now: Tick, rng: &mut Rng) -> Option<(OrderKey, TaskReply)> {
        self.ends().filter(|&until| until <= now)?;
        self.meter(now);
        let (key, until) = self.doing.take()?;
        if let Some(failure) = self.is_securing.take() {
            return Some((key, self.end(now, key, TaskOutcome::Failed(failure))));
        }
        if self.does_not_end() || until > now {
            // Its time is over: it stands where it is.
            self.is_held = !self.waits_to_begin;
            let failure = self.waits_code.map_or(TaskFailure::TimedOut, TaskFailure::from_code);
            return Some((key, self.end(now, key, TaskOutcome::Failed(failure))));
        }
        let by_chance = self.failing > 0 && rng.below(self.failing) == 0;
        let code = self.fails_with.take().or(by_chance.then_some(CODE));
        let outcome = code.map_or(TaskOutcome::Done, |code| TaskOutcome::Failed(TaskFailure::from_code(code)));
        Some((key, self.end(now, key, outcome)))
    }

    fn end(&mut self, now: Tick, key: OrderKey, outcome: TaskOutcome) -> TaskReply {
        (self.heard.slot, self.is_securing) = (None, None);
        self.ended.push((key, outcome, now));
        self.remember(key, outcome)
    }

    /// An order that was gone back from ends with what it had failed with before.
    fn remember(&mut self, key: OrderKey, outcome: TaskOutcome) -> TaskReply {
        if let Some(&(_, before)) = self.heard.results.iter().find(|(had, _)| *had == key) {
            return TaskReply::Ended(before);
        }
        self.heard.results.push((key, outcome));
        if self.heard.results.len() > RESULTS_MAX {
            self.heard.results.remove(0);
        }
        TaskReply::Ended(outcome)
    }

    /// Reply to the order to leave an order; none if it does not arrive.
    pub(super) fn told_to_leave(&mut self, now: Tick, key: OrderKey, way: LeaveWay) -> Option<TaskReply> {
        if self.is_away {
            return None;
        }
        if self.doing() == Some(key) {
            self.leave(now, key, way);
        } else if self.heard.results.last().is_some_and(|(last, end)| *last == key && *end != TaskOutcome::Done) {
            self.return_from(now, key, way);
        }
        if self.doing() == Some(key) {
            return Some(TaskReply::Running);
        }
        if let Some(&(_, outcome)) = self.heard.results.iter().find(|(had, _)| *had == key) {
            return Some(TaskReply::Ended(outcome));
        }
        if key.epoch < self.heard.epoch {
            return Some(TaskReply::Refused(TaskRefusal::OldEpoch));
        }
        if key.epoch == self.heard.epoch && key.id <= self.last {
            return Some(TaskReply::Refused(TaskRefusal::Old));
        }
        // Not received yet, and not to be done when it is.
        (self.heard.epoch, self.last) = (key.epoch, key.id);
        Some(self.remember(key, TaskOutcome::Failed(TaskFailure::Cancelled)))
    }

    fn leave(&mut self, now: Tick, key: OrderKey, way: LeaveWay) {
        if way != LeaveWay::Hold {
            self.secured = Some(key);
        }
        let waited = self.waits_code.filter(|_| self.does_not_end()).map(TaskFailure::from_code);
        if self.waits_to_begin {
            self.doing = None;
            self.end(now, key, TaskOutcome::Failed(waited.unwrap_or(TaskFailure::Cancelled)));
        } else if self.holds || way != LeaveWay::Back {
            (self.doing, self.is_held) = (None, true);
            let failure = match way {
                LeaveWay::Back => TaskFailure::Held,
                LeaveWay::Hold => waited.unwrap_or(TaskFailure::Held),
                LeaveWay::Stop => TaskFailure::Stopped,
            };
            self.end(now, key, TaskOutcome::Failed(failure));
        } else if self.is_securing.is_none() {
            let failure = waited.unwrap_or(TaskFailure::Cancelled);
            (self.doing, self.is_securing) = (Some((key, self.counts_from(now) + WAY_BACK)), Some(failure));
        }
    }

    /// It goes back once from an order that has failed.
    fn return_from(&mut self, now: Tick, key: OrderKey, way: LeaveWay) {
        if way == LeaveWay::Hold {
            return;
        }
        if self.secured.replace(key) != Some(key) && self.is_held && !self.holds && way == LeaveWay::Back {
            self.meter(now);
            (self.heard.slot, self.is_held) = (Some(key), false);
            let failure = TaskFailure::Cancelled;
            (self.doing, self.is_securing) = (Some((key, self.counts_from(now) + WAY_BACK)), Some(failure));
        }
    }
}
