//! The token player with pretended stations, in virtual time.

use std::collections::{BTreeMap, BTreeSet};
use std::{sync::Arc, time::Duration};

use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::{
    ActivityPhase, ActivityTiming, CellEvent, CellMessage, CellTable, Coordination, Dispatcher, ModeId, OrderKey,
    OrderMessage, PlayerInput, PlayerOutbox, PlayerState, Presence, ProductionCommand, ProductionCommandError,
    ProductionId, Record, RequestId, ResourceId, TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};
use linewright_orders::LeaveWay;

use super::floor::ShopFloor;
use super::station::SimulatedStation;
use super::store::{InMemory, RecordStore};
use super::task_times::TaskTimes;
use super::truth::PartTruth;
use crate::rng::Rng;

/// Full steps at one moment after which there will be no other moment.
const SPINS_MAX: usize = 3;
/// A cell in which nothing has happened for so long, and nothing is going to, has come to its end.
const QUIET: Duration = Duration::from_secs(3);

/// Time of stations for an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StationSpeed {
    /// The nominal time of its activity, longer or shorter by this fraction at most.
    Nominal {
        /// Between 0 and 1.
        spread: f64,
    },
    /// Anything between these.
    Between(Duration, Duration),
}

/// Options of a simulation of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSimOptions {
    /// Seed of everything random.
    pub seed: u64,
    /// Time of stations for an order.
    pub pace: StationSpeed,
    /// Delay of a message, least and most.
    pub delay: (Duration, Duration),
    /// One message in so many is lost, as many are doubled, and some take far longer; none with 0.
    pub bad_luck: u64,
    /// Period of stations' reports.
    pub period: Duration,
    /// The coordinator is killed at these of its steps: each record and each message is one.
    pub crash_at: Vec<usize>,
    /// Whether after each step all records are replayed, which must give the state. It takes its time.
    pub replays: bool,
}

impl Default for CellSimOptions {
    /// Times as they should be, messages that take no time and get there.
    fn default() -> Self {
        CellSimOptions {
            seed: 1,
            pace: StationSpeed::Nominal { spread: 0.0 },
            delay: (Duration::ZERO, Duration::ZERO),
            bad_luck: 0,
            period: Duration::from_secs(60),
            crash_at: Vec::new(),
            replays: false,
        }
    }
}

/// A message on its way.
enum MessageInTransit {
    /// To a station, for which it will be so much work.
    Order(OrderMessage, Duration),
    Reply(usize, OrderKey, TaskReply),
    /// To a station, to leave an order, or to stop; and its reply.
    Secure(usize, OrderKey, LeaveWay),
    Secured(usize, OrderKey, LeaveWay, TaskReply),
    /// With a number that rises.
    State(usize, u64, TaskReport),
}

/// The coordinator's part of that.
enum PlayerInbound {
    Reply(StationId, OrderKey, TaskReply),
    Secured(StationId, OrderKey, LeaveWay, TaskReply),
    State(StationId, TaskReport),
}

/// A cell in virtual time.
pub struct CellSim {
    /// Table that is played.
    pub table: Arc<CellTable>,
    /// Options. They may be changed while it goes on.
    pub options: CellSimOptions,
    /// The coordinator, in its present life.
    pub coordination: Coordination,
    /// All its stations, by number.
    pub stations: Vec<SimulatedStation>,
    /// The real ones, which then take the place of those that are pretended.
    pub floor: Option<ShopFloor>,
    /// Records written, in all lives.
    pub log: Vec<Record>,
    /// Events for operators, with times.
    pub events: Vec<(Tick, CellEvent)>,
    pub now: Tick,
    /// Whether anything may start.
    pub starts: bool,
    /// The stations that are in manual by themselves.
    pub in_manual: BTreeMap<StationId, u64>,
    /// Number of steps of the coordinator, in all lives.
    pub steps: usize,
    /// Number of its lives.
    pub lives: usize,
    /// Requests for production orders, repeated until there is a reply.
    pub asked: Vec<Vec<ProductionOrderRequest>>,
    /// Replies to them.
    pub told: Vec<Result<Vec<ProductionId>, ProductionCommandError>>,
    /// True places of the parts.
    pub truth: PartTruth,
    /// Whether stations report their sensors.
    pub senses: bool,
    /// Factors on the described times of orders, drawn for each activity; by default the pace counts.
    pub times: TaskTimes,
    store: Box<dyn RecordStore>,
    rng: Rng,
    flying: BTreeMap<(Tick, u64), MessageInTransit>,
    sent: u64,
    /// The newest state of each station that this life has received.
    newest: Vec<u64>,
    publish: Tick,
}

impl CellSim {
    /// A cell in which nothing has happened, with so many stations; records are kept in memory.
    pub fn new(table: Arc<CellTable>, stations: usize, options: CellSimOptions) -> Self {
        Self::with_store(table, stations, options, Box::new(InMemory::default()))
    }

    /// The same with another store, which is empty.
    pub fn with_store(
        table: Arc<CellTable>,
        stations: usize,
        options: CellSimOptions,
        store: Box<dyn RecordStore>,
    ) -> Self {
        let (coordination, out) = life(PlayerState::new(table.clone()), Tick::ZERO);
        let mut new = CellSim {
            table,
            coordination,
            stations: vec![SimulatedStation::default(); stations],
            floor: None,
            log: Vec::new(),
            events: Vec::new(),
            now: Tick::ZERO,
            starts: true,
            in_manual: BTreeMap::new(),
            steps: 0,
            lives: 1,
            asked: Vec::new(),
            told: Vec::new(),
            truth: PartTruth::default(),
            senses: false,
            times: TaskTimes::default(),
            store,
            rng: Rng::new(options.seed),
            flying: BTreeMap::new(),
            sent: 0,
            newest: vec![0; stations],
            publish: Tick::ZERO,
            options,
        };
        new.perform(out);
        new
    }

    /// State of the coordinator.
    pub fn state(&self) -> &PlayerState {
        self.coordination.state()
    }

    /// Goes on until nothing happens any more, at most until a time. A cell whose failed activities wait for an answer,
    /// and whose others are over, has come to its end. The dispatcher outlives the coordinator, so it should keep nothing
    /// that is not in the state.
    pub fn run(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) {
        self.coordination.reconsider();
        while !self.is_over() && self.goes_on(dispatcher, until) {}
    }

    /// Goes on until a time, also while nothing happens. Ends early where time does not go on.
    pub fn run_on(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) {
        while self.spins().is_none() && self.goes_on(dispatcher, until) {}
    }

    /// The same with a dispatcher of its own for each life, made from the state.
    pub fn run_by(&mut self, made: &dyn Fn(&PlayerState) -> Box<dyn Dispatcher>, until: Tick) {
        let mut dispatcher = made(self.state());
        let mut life = self.lives;
        while !self.is_over() && self.goes_on(&mut *dispatcher, until) {
            if self.lives != life {
                (dispatcher, life) = (made(self.state()), self.lives);
            }
        }
    }

    /// Whether a station works on an order, or a message is under way.
    pub fn is_working(&self) -> bool {
        !self.flying.is_empty() || self.stations.iter().any(|station| station.ends().is_some())
    }

    /// Time of the next event, stations' reports left out; none if there is none.
    pub fn next_event(&self) -> Option<Tick> {
        let ends = self.stations.iter().filter_map(SimulatedStation::ends);
        let arrives = self.flying.keys().next().map(|&(at, _)| at);
        let deadline = self.coordination.next_deadline();
        let floor = self.floor.as_ref().and_then(ShopFloor::next);
        ends.chain(arrives).chain(deadline).chain(floor).min()
    }

    /// Time of the next event, or of stations' reports.
    pub(super) fn next_moment(&self) -> Tick {
        self.next_event().map_or(self.publish, |next| next.min(self.publish))
    }

    /// The next moment; false if that is after a time.
    pub(super) fn goes_on(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) -> bool {
        let next = self.next_moment();
        if next > until {
            return false;
        }
        self.now = self.now.max(next);
        self.stations_go_on();
        let arrived = self.arrived();
        self.coordinate(dispatcher, &arrived, &[]);
        true
    }

    /// Gives operators' input now.
    pub fn say(&mut self, dispatcher: &mut dyn Dispatcher, what: &[PlayerInput<'_>]) {
        self.coordinate(dispatcher, &[], what);
    }

    /// A mode that fires at one moment without end, if one does: time does not go on any more.
    pub fn spins(&self) -> Option<ModeId> {
        let busy = |(at, event): &(Tick, CellEvent)| match event {
            CellEvent::Busy { mode } if *at == self.now => Some(*mode),
            CellEvent::Busy { .. }
            | CellEvent::BadAnswer { .. }
            | CellEvent::Superseded { .. }
            | CellEvent::Objected { .. } => None,
        };
        let newest = self.events.iter().rev().map_while(busy).take(SPINS_MAX);
        newest.clone().next().filter(|_| newest.count() == SPINS_MAX)
    }

    /// Whether nothing happens any more.
    pub(super) fn is_over(&self) -> bool {
        if self.spins().is_some() {
            return true;
        }
        let is_idle = self.state().firings().all(|firing| firing.phase != ActivityPhase::Running);
        let is_quiet = self.now.since(self.state().now()) > QUIET;
        // Before a station is received for the first time, everything waits for it.
        is_idle
            && is_quiet
            && self.asked.is_empty()
            && self.coordination.next_deadline().is_none()
            && self.publish > Tick::ZERO
    }

    /// One step of the coordinator.
    fn coordinate(&mut self, dispatcher: &mut dyn Dispatcher, arrived: &[PlayerInbound], said: &[PlayerInput<'_>]) {
        let mut inputs = vec![PlayerInput::Starts(self.starts), PlayerInput::InManual(&self.in_manual)];
        inputs.extend(arrived.iter().map(|arrived| match arrived {
            PlayerInbound::Reply(station, key, reply) => PlayerInput::Reply(*station, *key, *reply),
            PlayerInbound::Secured(station, key, way, reply) => PlayerInput::Secured(*station, *key, *way, *reply),
            PlayerInbound::State(station, heard) => PlayerInput::Station(*station, heard),
        }));
        let asked = std::mem::take(&mut self.asked);
        let asks =
            |(ticket, requests): (RequestId, _)| PlayerInput::Production(ticket, ProductionCommand::Submit(requests));
        inputs.extend((0..).zip(asked.iter().map(Vec::as_slice)).map(asks));
        inputs.extend_from_slice(said);
        let mut out = PlayerOutbox::default();
        self.coordination.step(self.now, &inputs, dispatcher, &mut out);
        if !self.perform(out) {
            self.asked = asked;
        }
        let stopped: BTreeSet<StationId> = self.state().exceptions().stopped().collect();
        match &mut self.floor {
            Some(floor) => floor.stop(stopped),
            None => stopped.iter().for_each(|id| self.stations[id.index()].emergency_stop(self.now)),
        }
        if self.options.replays {
            let replayed = PlayerState::replay(self.table.clone(), &self.log);
            assert_eq!(replayed.as_ref(), Ok(self.state()), "at {}", self.now);
        }
    }

    fn stations_go_on(&mut self) {
        for index in 0..self.stations.len() {
            if let Some((key, reply)) = self.stations[index].tick(self.now, &mut self.rng) {
                self.truth.ended(&self.table, key, reply);
                self.tell(index, || MessageInTransit::Reply(index, key, reply));
            }
        }
        self.sense();
        let news = self.floor.as_mut().map(|floor| floor.go_on(self.now)).unwrap_or_default();
        let due = if self.publish <= self.now {
            self.publish = self.now + self.options.period;
            (0..self.stations.len()).collect()
        } else {
            news
        };
        for index in due {
            let heard = match &self.floor {
                Some(floor) => floor.heard(index),
                None => Some(self.stations[index].heard()),
            };
            let number = self.sent + 1;
            if let Some(heard) = heard {
                self.tell(index, || MessageInTransit::State(index, number, heard.clone()));
            }
        }
    }

    /// Sensors see the parts that are there.
    fn sense(&mut self) {
        let sensed = self.table.handling().resources.iter().enumerate().filter(|(_, of)| of.is_sensed && self.senses);
        for (index, of) in sensed {
            let has = self.truth.has(ResourceId(index as u32));
            if let Some(station) = of.station.and_then(|station| self.stations.get_mut(station.index())) {
                station.presence = if has { Presence::On } else { Presence::Off };
            }
        }
    }

    fn tell(&mut self, index: usize, what: impl Fn() -> MessageInTransit) {
        if !self.stations[index].is_away {
            self.fly(what);
        }
    }

    /// Sends something on its way, perhaps twice, perhaps not at all.
    fn fly(&mut self, what: impl Fn() -> MessageInTransit) {
        let one_in = |rng: &mut Rng, cases: u64| cases > 0 && rng.below(cases) == 0;
        let luck = self.options.bad_luck;
        let times = match luck {
            0 => 1,
            _ if one_in(&mut self.rng, luck) => 0,
            _ if one_in(&mut self.rng, luck) => 2,
            _ => 1,
        };
        let (least, most) = self.options.delay;
        for _ in 0..times {
            self.sent += 1;
            let is_long = luck > 0 && one_in(&mut self.rng, 20);
            let delay = if is_long { most * 20 } else { between(&mut self.rng, least, most) };
            self.flying.insert((self.now + delay, self.sent), what());
        }
    }

    /// Delivers messages that have arrived; the coordinator's part of them.
    fn arrived(&mut self) -> Vec<PlayerInbound> {
        let mut arrived = Vec::new();
        while let Some(entry) = self.flying.first_entry().filter(|entry| entry.key().0 <= self.now) {
            match entry.remove() {
                MessageInTransit::Order(order, takes) => {
                    let index = order.station.index();
                    let reply = match &mut self.floor {
                        Some(floor) => floor.told(self.now, &order),
                        None => self.stations.get_mut(index).and_then(|station| station.told(self.now, &order, takes)),
                    };
                    if let Some(reply) = reply {
                        self.fly(|| MessageInTransit::Reply(index, order.order.key, reply));
                    }
                }
                MessageInTransit::Secure(index, key, way) => {
                    let now = self.now;
                    let reply = match &mut self.floor {
                        Some(floor) => floor.told_to_leave(now, StationId::at(index), key, way),
                        None => self.stations.get_mut(index).and_then(|station| station.told_to_leave(now, key, way)),
                    };
                    if let Some(reply) = reply {
                        self.fly(|| MessageInTransit::Secured(index, key, way, reply));
                    }
                }
                MessageInTransit::Secured(index, key, way, reply) => {
                    arrived.push(PlayerInbound::Secured(StationId::at(index), key, way, reply));
                }
                MessageInTransit::Reply(index, key, reply) => {
                    arrived.push(PlayerInbound::Reply(StationId::at(index), key, reply))
                }
                // The newest state counts, whatever comes after it.
                MessageInTransit::State(index, number, heard) if number > self.newest[index] => {
                    self.newest[index] = number;
                    arrived.push(PlayerInbound::State(StationId::at(index), heard));
                }
                MessageInTransit::State(..) => (),
            }
        }
        arrived
    }

    /// Writes records, then sends, then replies, unless the coordinator is killed in between; false if it was.
    fn perform(&mut self, out: PlayerOutbox) -> bool {
        for record in out.records {
            if self.dies() {
                return self.restart();
            }
            self.store.append(&record);
            if let Some(floor) = &mut self.floor {
                floor.note(&record, self.coordination.state());
            }
            self.truth.note(&self.table, &record);
            self.log.push(record);
        }
        if !out.sends.is_empty() {
            self.store.sync();
        }
        for send in out.sends {
            if self.dies() {
                return self.restart();
            }
            match send {
                CellMessage::Order(order) => {
                    let takes = self.takes(&order);
                    self.fly(|| MessageInTransit::Order(order.clone(), takes));
                }
                CellMessage::Secure { station, key, way } => {
                    self.fly(|| MessageInTransit::Secure(station.index(), key, way))
                }
            }
        }
        if !out.replies.is_empty() {
            self.store.sync();
            if self.dies() {
                return self.restart();
            }
        }
        self.told.extend(out.replies.into_iter().map(|(_, reply)| reply));
        self.events.extend(out.events.into_iter().map(|event| (self.now, event)));
        self.store.settled(self.coordination.state());
        true
    }

    /// Time of a station for an order.
    fn takes(&mut self, order: &OrderMessage) -> Duration {
        match self.options.pace {
            StationSpeed::Between(least, most) => between(&mut self.rng, least, most),
            StationSpeed::Nominal { spread } => {
                let of = self.state().order(order.order.key).map(|(firing, _)| (firing.id, firing.mode));
                let nominal = match of.map(|(_, mode)| self.table.activity(mode).kind) {
                    Some(ActivityTiming::Decided { time, limit: _ }) => time,
                    Some(ActivityTiming::Immediate) | None => Duration::ZERO,
                };
                if let Some(factor) = of.and_then(|(firing, mode)| self.times.factor(firing, mode)) {
                    return nominal.mul_f64(factor);
                }
                let spread = nominal.mul_f64(spread.clamp(0.0, 1.0));
                if spread.is_zero() { nominal } else { between(&mut self.rng, nominal - spread, nominal + spread) }
            }
        }
    }

    fn dies(&mut self) -> bool {
        let dies = self.options.crash_at.contains(&self.steps);
        self.steps += 1;
        dies
    }

    /// Another life, from the records written.
    fn restart(&mut self) -> bool {
        let state = self.store.restart(&self.table, &mut self.rng);
        let kept = usize::try_from(state.sequence()).unwrap_or(usize::MAX);
        assert!(kept <= self.log.len(), "nothing can be found that was not written");
        self.log.truncate(kept);
        let (coordination, out) = life(state, self.now);
        self.coordination = coordination;
        self.newest.fill(0);
        self.lives += 1;
        self.perform(out);
        false
    }
}

/// A life of the coordinator from a state.
fn life(state: PlayerState, now: Tick) -> (Coordination, PlayerOutbox) {
    let (mut out, epoch) = (PlayerOutbox::default(), state.epoch() + 1);
    let coordination = Coordination::begin(state, now, epoch, &mut out).expect("it is the next epoch");
    (coordination, out)
}

fn between(rng: &mut Rng, least: Duration, most: Duration) -> Duration {
    let micros = |span: Duration| u64::try_from(span.as_micros()).unwrap_or(u64::MAX / 2);
    let (least, most) = (micros(least), micros(most));
    if least < most { Duration::from_micros(rng.within(least, most)) } else { Duration::from_micros(least) }
}
