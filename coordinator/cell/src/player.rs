//! The token player: the interpreter of seed 001 (§5.1, L120-129), firing in three phases (seed 000, definition 44, L2369).
//!
//! An activity takes its tokens when it starts, its stations get orders, and it gives its tokens when all of them are
//! done. One [`Coordination::step`] takes what was received, lets limits run out, closes what has ended, lets happen what
//! happens by itself, puts the question to the dispatcher, starts what that decides, and repeats that until nothing is
//! new. It has no clock, no file and no network; its knowledge of the cell is its [`PlayerState`], which changes by
//! records alone.
//!
//! # Why a crash at any moment loses nothing and repeats nothing
//! 1. The caller has `records` on disk before it performs `sends`. So no station ever has an order that the log lacks.
//! 2. Numbers come from counters that are folded from the records, and the life before the first order of a life is a
//!    record, [`RecordKind::Epoch`]. So no two orders ever have one key.
//! 3. A station remembers the orders it has had, over its own restarts, and does none of them twice. So an order may be
//!    sent again at any time. All without acknowledgement are: after a restart too, since they may not have been sent.
//! 4. Each station is sent its orders one by one, the oldest first, the next when it has answered to the one before.
//!    Keys therefore reach it rising, over restarts as well, and it never takes an order for an old one that it has not
//!    had.
//! 5. Ends are repeated by the stations until they are acknowledged. A report that was not yet written down is received
//!    again.
//! 6. A station that reports a new memory may have done its order or not. Such an order fails as
//!    [`OrderFailure::Forgotten`] and is never sent again. To tell a new memory from the first one, an order is sent only
//!    after the station's memory is in a record; and it contains the memory it is meant for, so that one which is on its
//!    way while the memory is lost is not done for a second time.
//!
//! A failed activity stays where it is, with its tokens, its part and the reports on its orders, until an answer settles
//! it; see [`super::exception`].

use std::collections::{BTreeMap, BTreeSet};

use linewright_line::{StationId, Tick};
use linewright_orders::{TaskFailure, TaskOrder};
use thiserror::Error;

use super::exception::{AlarmAnswerRefusal, StationMonitor};
use super::fifo::Fifo;
use super::firing::{ActivityPhase, OrderProgress, PendingRecord};
use super::ids::{FiringId, ModeId, OrderKey, PartId, ProductionId, ResourceId};
use super::orders::{
    CellEvent, CellMessage, OrderMessage, PlayerInput, PlayerOutbox, ProductionCommand, ProductionCommandError,
    Sending, TaskOutcome, TaskReply, TaskReport,
};
use super::production::ProductionChange;
use super::protocol::ProtocolRules;
use super::question::{Candidate, DispatchDecision, Dispatcher, HoldReason, Question, check, pose};
use super::record::{ActivityFailure, OrderFailure, Record, RecordKind};
use super::state::PlayerState;

/// At most so much happens by itself in one step, and as many activities start: a net may have circles that take no time.
const FIRINGS_MAX: usize = 10_000;

/// The epoch of a new life is not a new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("epoch {asked} is not newer than epoch {newest} of the log")]
pub struct OldEpoch {
    /// Epoch requested.
    pub asked: u64,
    /// The newest there was.
    pub newest: u64,
}

/// One life of the coordinator of a cell.
#[derive(Clone, Debug)]
pub struct Coordination {
    pub(super) state: PlayerState,
    pub(super) starts: bool,
    /// The stations that were received in this life.
    pub(super) heard: BTreeSet<StationId>,
    /// Orders sent in this life and not acknowledged: how often, and when last.
    pub(super) sent: BTreeMap<OrderKey, (u32, Tick)>,
    pub(super) superseded: bool,
    pub(super) watch: StationMonitor,
    pub(super) rules: ProtocolRules,
    /// Time of the next question, set by the dispatcher.
    ask_again: Option<Tick>,
    /// Number of records when it had answered, and number of stations received.
    answered: Option<(u64, usize)>,
    /// The last step was cut short.
    cut_short: bool,
}

/// Passes new records to a dispatcher.
fn tell(dispatcher: &mut dyn Dispatcher, out: &PlayerOutbox, told: &mut usize) {
    out.records[*told..].iter().for_each(|record| dispatcher.note(record));
    *told = out.records.len();
}

impl Coordination {
    /// Begins a life, from `state` (see [`PlayerState::replay`]). The epoch is above that of every life before, also of those
    /// that only stations have received.
    pub fn begin(state: PlayerState, now: Tick, epoch: u64, out: &mut PlayerOutbox) -> Result<Self, OldEpoch> {
        if epoch <= state.epoch() {
            return Err(OldEpoch { asked: epoch, newest: state.epoch() });
        }
        let now = now.max(state.now());
        let mut new = Coordination {
            watch: StationMonitor::new(&state, now),
            state,
            starts: false,
            heard: BTreeSet::new(),
            sent: BTreeMap::new(),
            superseded: false,
            rules: ProtocolRules::default(),
            ask_again: None,
            answered: None,
            cut_short: false,
        };
        new.write(now, RecordKind::Epoch { epoch }, out);
        Ok(new)
    }

    /// State of the cell.
    pub fn state(&self) -> &PlayerState {
        &self.state
    }

    /// Progress of an order towards its station; none if its station has answered, or it is not waited for.
    pub fn sending(&self, key: OrderKey) -> Option<Sending> {
        let (_, order) = self.state.order(key)?;
        let is_unheard = self.state.unheard.get(&order.station).is_some_and(|keys| keys.contains(&key));
        is_unheard.then(|| match self.sent.get(&key) {
            Some(&(tries, at)) => Sending::Sent { tries, at },
            None => Sending::Unsent,
        })
    }

    /// Takes all arrivals, then decides and acts. A time before that of the newest record is taken for that.
    pub fn step(
        &mut self,
        now: Tick,
        inputs: &[PlayerInput<'_>],
        dispatcher: &mut dyn Dispatcher,
        out: &mut PlayerOutbox,
    ) {
        let now = self.watch.steps(now.max(self.state.now()));
        let mut told = out.records.len();
        out.is_requested |= inputs.iter().any(PlayerInput::is_request);
        for input in inputs {
            match *input {
                PlayerInput::Station(station, heard) => self.hear(now, station, heard, out),
                PlayerInput::Reply(station, key, reply) => {
                    // What has failed may be gone back from: its end does not give the station's place.
                    if reply == TaskReply::Ended(TaskOutcome::Done) {
                        self.watch.done(station, key);
                    }
                    self.reply(now, station, key, reply, out);
                }
                PlayerInput::Secured(_, key, way, reply) => self.watch.answered(now, key, way, reply),
                PlayerInput::Starts(may) => self.starts = may,
                PlayerInput::InManual(stations) => self.lead_by_hand(stations),
                PlayerInput::Production(ticket, command) => {
                    let reply = self.change(now, command, out);
                    out.replies.push((ticket, reply));
                }
                PlayerInput::Answer { alarm, word } => self.answer(now, alarm, word, out),
                PlayerInput::Alarm { resource, text } => self.alarmed(now, resource, text, out),
                PlayerInput::Resource { resource, up } => self.set_resource(now, resource, up, out),
                PlayerInput::Reset(station) => self.reset(now, station, out),
            }
        }
        let (mut room, mut starts) = (FIRINGS_MAX, FIRINGS_MAX);
        loop {
            self.run_out(now, out);
            self.miss(now, out);
            self.settle(now, out);
            self.attend(now, out);
            let happened = self.immediates(now, &mut room, out);
            tell(dispatcher, out, &mut told);
            let started = self.ask(now, &mut starts, dispatcher, out);
            if !(happened || started) || room == 0 || starts == 0 {
                break;
            }
        }
        tell(dispatcher, out, &mut told);
        self.cut_short = room == 0 || starts == 0;
        self.send(now, out);
    }

    /// For a change that is in no record: another dispatcher, other rules. It is asked in the next step.
    pub fn reconsider(&mut self) {
        self.answered = None;
    }

    /// Time of the next call if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        let limit = self.state.due.first().map(|&(due, _)| due);
        let resend = self.next_to_send().map(|key| match self.sent.get(&key) {
            Some(&(_, at)) => at + self.state.table.repeat_interval(),
            None => self.state.now(),
        });
        let again = self.cut_short.then_some(self.state.now());
        limit.into_iter().chain(self.next_of_exceptions()).chain(self.ask_again).chain(resend).chain(again).min()
    }

    pub(super) fn is_superseded(&self) -> bool {
        self.superseded
    }

    /// An order that is not sent any more.
    pub(super) fn not_sent(&mut self, key: OrderKey) {
        self.sent.remove(&key);
    }

    pub(super) fn write(&mut self, at: Tick, fact: RecordKind, out: &mut PlayerOutbox) {
        let record = Record { at, fact };
        // Every caller has looked at the state it writes about, and nothing else changes it.
        self.state.apply(&record).expect("the player writes only what fits");
        out.records.push(record);
    }

    fn hear(&mut self, now: Tick, station: StationId, heard: &TaskReport, out: &mut PlayerOutbox) {
        match self.state.memory.get(&station) {
            Some(&memory) if memory == heard.memory => (),
            Some(_) => {
                // First what follows from it: a crash in between would make the new memory one that was always there.
                let open = self.state.orders.keys().copied().filter(|&key| self.may_be_known(station, key));
                for key in open.collect::<Vec<_>>() {
                    self.write(now, RecordKind::OrderFailed { key, failure: OrderFailure::Forgotten }, out);
                }
                self.write(now, RecordKind::Memory { station, memory: heard.memory }, out);
            }
            None => self.write(now, RecordKind::Memory { station, memory: heard.memory }, out),
        }
        self.heard.insert(station);
        self.watch_station(now, station, heard, out);
        if heard.epoch > self.state.epoch() && !self.superseded {
            self.superseded = true;
            out.events.push(CellEvent::Superseded { by: station, epoch: heard.epoch });
        }
        if let Some(key) = heard.slot {
            self.reply(now, station, key, TaskReply::Running, out);
        }
        for &(key, outcome) in &heard.results {
            self.reply(now, station, key, TaskReply::Ended(outcome), out);
        }
    }

    /// Whether an order that is waited for may have reached its station: only those of this life are surely unsent.
    pub(super) fn may_be_known(&self, station: StationId, key: OrderKey) -> bool {
        let open = self.state.order(key).is_some_and(|(_, order)| order.station == station && order.is_open());
        open && (key.epoch < self.state.epoch() || self.sending(key) != Some(Sending::Unsent))
    }

    fn reply(&mut self, now: Tick, station: StationId, key: OrderKey, reply: TaskReply, out: &mut PlayerOutbox) {
        // Of orders that are over, or another station's, nothing need be known.
        let Some((firing, order)) = self.state.order(key).filter(|(_, order)| order.station == station) else { return };
        let has_failed = firing.phase != ActivityPhase::Running;
        let fact = match (reply, order.state) {
            (TaskReply::Running, OrderProgress::Written) => RecordKind::Acknowledged { key },
            (TaskReply::Ended(TaskOutcome::Done), OrderProgress::Written | OrderProgress::Running) => {
                RecordKind::OrderEnded { key }
            }
            // Kept for the diagnosis.
            (TaskReply::Ended(TaskOutcome::Done), OrderProgress::Failed(_)) if has_failed => {
                RecordKind::OrderEnded { key }
            }
            (TaskReply::Ended(TaskOutcome::Failed(ended)), OrderProgress::Written | OrderProgress::Running) => {
                RecordKind::OrderFailed { key, failure: OrderFailure::of(ended) }
            }
            // Its time was over here first. The station reports what it waited for when it stands.
            (
                TaskReply::Ended(TaskOutcome::Failed(ended @ TaskFailure::Waiting(_))),
                OrderProgress::Failed(OrderFailure::TimedOut),
            ) if self.state.exceptions().is_securing(firing.id) => {
                RecordKind::OrderFailed { key, failure: OrderFailure::of(ended) }
            }
            (TaskReply::Refused(refusal), OrderProgress::Written) if !refusal.is_passing() => {
                RecordKind::OrderFailed { key, failure: OrderFailure::Refused(refusal) }
            }
            // It is repeated when the time has come.
            (TaskReply::Refused(_), OrderProgress::Written) => return,
            // A refusal of what is being done answers a doubled message. What has failed or ended has.
            (
                TaskReply::Running | TaskReply::Refused(_),
                OrderProgress::Running | OrderProgress::Ended | OrderProgress::Failed(_),
            )
            | (TaskReply::Ended(_), OrderProgress::Ended | OrderProgress::Failed(_)) => return,
        };
        self.sent.remove(&key);
        self.write(now, fact, out);
    }

    /// Changes production orders.
    fn change(
        &mut self,
        now: Tick,
        command: ProductionCommand<'_>,
        out: &mut PlayerOutbox,
    ) -> Result<Vec<ProductionId>, ProductionCommandError> {
        if self.superseded {
            return Err(ProductionCommandError::Superseded);
        }
        let production = self.state.production();
        let changes = match command {
            ProductionCommand::Submit(requests) => {
                production.submit(requests).map_err(ProductionCommandError::Request)?
            }
            ProductionCommand::Cancel(name) => vec![production.cancel(name).map_err(ProductionCommandError::Order)?],
            ProductionCommand::Withdraw(name) => {
                vec![production.withdraw(name).map_err(ProductionCommandError::Order)?]
            }
        };
        let changed = changes.iter().filter_map(ProductionChange::order).collect();
        changes.into_iter().for_each(|change| self.write(now, RecordKind::Production { change }, out));
        Ok(match command {
            // The reply has those that existed already, too.
            ProductionCommand::Submit(requests) => {
                let production = self.state.production();
                requests.iter().filter_map(|request| production.by_key(request.key)).map(|order| order.id).collect()
            }
            ProductionCommand::Cancel(_) | ProductionCommand::Withdraw(_) => changed,
        })
    }

    /// Lets time run out: of orders, of activities, and of those that end by the clock alone.
    fn run_out(&mut self, now: Tick, out: &mut PlayerOutbox) {
        while let Some(&(due, id)) = self.state.due.first().filter(|(due, _)| *due <= now) {
            let Some(firing) = self.state.firing(id) else { return };
            let late = firing.orders.iter().filter(|order| order.is_open() && order.limit <= due);
            let late: Vec<OrderKey> = late.map(|order| order.key).collect();
            if firing.orders.is_empty() {
                self.write(now, RecordKind::Ended { firing: id }, out);
            } else if firing.next() != PendingRecord::Wait {
                // A report of this moment counts for more than a limit that runs out now.
                self.settle(now, out);
            } else if late.is_empty() {
                self.write(now, RecordKind::Raised { firing: id, cause: ActivityFailure::TimedOut }, out);
            } else {
                for key in late {
                    self.sent.remove(&key);
                    self.write(now, RecordKind::OrderFailed { key, failure: OrderFailure::TimedOut }, out);
                }
                self.settle(now, out);
            }
        }
    }

    /// Closes activities that have ended or failed.
    fn settle(&mut self, now: Tick, out: &mut PlayerOutbox) {
        while let Some(&id) = self.state.settled.first() {
            match self.state.firing(id).map(|firing| firing.next()) {
                Some(PendingRecord::End) => self.end(now, id, out),
                Some(PendingRecord::Fail(cause)) => self.fail(now, id, cause, out),
                // Only firings that have something next are listed.
                Some(PendingRecord::Wait) | None => return,
            }
        }
    }

    /// Fires the modes that happen by themselves, the first mode first.
    fn immediates(&mut self, now: Tick, room: &mut usize, out: &mut PlayerOutbox) -> bool {
        let before = *room;
        while *room > 0 {
            let Some(mode) = self.state.enabling().immediate().iter().copied().min() else { break };
            let part = self.state.part_for(mode);
            self.write(now, RecordKind::Fired { mode, part }, out);
            *room -= 1;
            if *room == 0 {
                out.events.push(CellEvent::Busy { mode });
            }
        }
        *room < before
    }

    /// Puts the question, and starts the modes of the answer.
    fn ask(&mut self, now: Tick, room: &mut usize, dispatcher: &mut dyn Dispatcher, out: &mut PlayerOutbox) -> bool {
        if !self.starts || self.superseded {
            return false;
        }
        if self.again(now, room, out) {
            return true;
        }
        // A repeated report is no reason to ask again.
        let is_due = self.ask_again.is_some_and(|at| at <= now);
        if !is_due && self.answered == Some((self.state.sequence(), self.heard.len())) {
            return false;
        }
        self.ask_again = None;
        let modes = self.state.enabling().decided().iter().copied();
        let (candidates, groups) = pose(&self.state, modes.filter(|&mode| self.is_heard(now, mode)));
        if candidates.is_empty() {
            self.answered = Some((self.state.sequence(), self.heard.len()));
            return false;
        }
        let number = self.state.questions + 1;
        let question = Question { now, state: &self.state, candidates: &candidates, groups: &groups };
        let mut answer = dispatcher.decide(&question);
        if let Err(why) = check(&question, &answer) {
            out.events.push(CellEvent::BadAnswer { question: number, why });
            answer = Fifo.decide(&question);
        }
        answer.start.truncate(*room);
        *room -= answer.start.len();
        let wakes = answer.held.iter().filter_map(|held| held.until).filter(|&until| until > now);
        self.ask_again = wakes.min();
        self.start(now, number, &candidates, &answer, out);
        if let Some(last) = answer.start.last().filter(|_| *room == 0) {
            out.events.push(CellEvent::Busy { mode: candidates[last.candidate].mode });
        }
        // What has started makes it another question.
        self.answered = answer.start.is_empty().then(|| (self.state.sequence(), self.heard.len()));
        !answer.start.is_empty()
    }

    /// Whether all stations that a mode needs were received in this life and can work, and its resources were compared with the
    /// model. Until then it waits; it is not an exception. A station at another rest than its task begins at is ordered all the same, unless its
    /// resource is about to be left out for it: its refusal is an alarm, and an order that waits would be none.
    pub(super) fn is_heard(&self, now: Tick, mode: ModeId) -> bool {
        self.unready(now, mode).is_none() && self.uncompared(mode).is_none() && !self.is_to_be_left_out(mode)
    }

    /// The first resource of a mode that has still to be compared with the model.
    pub(super) fn uncompared(&self, mode: ModeId) -> Option<ResourceId> {
        let mut resources = self.state.table.handling().mode(mode).resources();
        resources.find(|&id| self.watch.is_to_be_compared(&self.state, id))
    }

    /// The first station that keeps a mode from starting; none if all its stations were received and can be given an
    /// order.
    pub fn unready(&self, now: Tick, mode: ModeId) -> Option<AlarmAnswerRefusal> {
        let why = |station| match self.heard.contains(&station) {
            false => Some(AlarmAnswerRefusal::NotHeard(station)),
            true => self
                .objection(now, station)
                .or_else(|| self.moves(now, station).then_some(AlarmAnswerRefusal::Moves(station))),
        };
        self.state.table.activity(mode).orders.iter().find_map(|order| why(order.station))
    }

    fn start(
        &mut self,
        now: Tick,
        question: u64,
        candidates: &[Candidate],
        answer: &DispatchDecision,
        out: &mut PlayerOutbox,
    ) {
        let mode = |index: usize| candidates[index].mode;
        let held: Vec<(ModeId, HoldReason)> =
            answer.held.iter().map(|held| (mode(held.candidate), held.reason)).collect();
        let started: Vec<_> = answer.start.iter().map(|start| (mode(start.candidate), start.part)).collect();
        if !started.is_empty() || held != self.state.held() {
            self.write(now, RecordKind::Decided { question, started: started.clone(), held }, out);
        }
        started.into_iter().for_each(|(mode, part)| self.start_one(now, mode, part, out));
    }

    pub(super) fn start_one(&mut self, now: Tick, mode: ModeId, part: Option<PartId>, out: &mut PlayerOutbox) {
        let part = part.or_else(|| self.state.part_for(mode));
        let (epoch, last) = (self.state.epoch(), self.state.last_order);
        let count = self.state.table.activity(mode).orders.len() as u64;
        let orders = (1..=count).map(|k| OrderKey { epoch, id: last + k }).collect();
        let firing = FiringId(self.state.last_firing + 1);
        self.write(now, RecordKind::Started { firing, mode, part, orders }, out);
        self.expect(mode);
    }

    /// For each station that was received, the oldest order it has not answered to.
    fn heads(&self) -> impl Iterator<Item = OrderKey> + '_ {
        let heard = self.state.unheard.iter().filter(|(station, _)| !self.superseded && self.heard.contains(station));
        heard.filter_map(|(_, keys)| keys.first().copied())
    }

    fn next_to_send(&self) -> Option<OrderKey> {
        self.heads().min_by_key(|key| self.sent.get(key).map_or(Tick::ZERO, |&(_, at)| at))
    }

    fn send(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let repeat_interval = self.state.table.repeat_interval();
        let is_due = |key: &OrderKey| self.sent.get(key).is_none_or(|&(_, at)| at + repeat_interval <= now);
        for key in self.heads().filter(is_due).collect::<Vec<_>>() {
            let Some(message) = self.message(now, key) else { continue };
            self.sent.entry(key).and_modify(|(tries, at)| (*tries, *at) = (*tries + 1, now)).or_insert((1, now));
            out.sends.push(CellMessage::Order(message));
        }
        self.send_secure(now, out);
    }

    fn message(&self, now: Tick, key: OrderKey) -> Option<OrderMessage> {
        let (firing, order) = self.state.order(key)?;
        // Without its numbers nothing is sent, and the order runs out of time.
        let (task, parameters) = self.state.ordered_task(key)?;
        let task = TaskOrder {
            key,
            memory: *self.state.memory.get(&order.station)?,
            task: task.clone(),
            parameters,
            limit: order.limit.max(firing.spared_until).since(now),
        };
        Some(OrderMessage { station: order.station, part: firing.part, order: task })
    }
}
