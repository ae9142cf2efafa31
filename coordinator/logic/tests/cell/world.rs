//! A player with pretended stations, in virtual time: messages take time, may be lost, doubled or overtaken; the log is
//! what has been written; the coordinator can be killed after any of its steps.
//!
//! A station does one order at a time, remembers what it has had, and does no key twice: whoever made it do so would be
//! found by [`Station::done`], which is what really happened and which nobody reads but the tests.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_logic::cell::{
    Coordination, Dispatcher, Heard, Input, OrderKey, OrderMessage, Outbox, Outcome, PartId, Phase, Record, Refusal,
    Reply, Send, State,
};
use linewright_line::{StationId, Tick};

use crate::dice::Dice;
use crate::plans::Compiled;

const PERIOD: Duration = Duration::from_millis(100);

/// A pretended station.
#[derive(Default)]
pub struct Station {
    heard: Heard,
    doing: Option<(OrderKey, Tick)>,
    last: u64,
    /// What it has really done, each time it did it.
    pub done: Vec<(OrderKey, String, Option<PartId>)>,
    /// How often it was told something that it had been told before.
    pub doubled: usize,
    /// One order in so many ends with a code; none with 0.
    pub failing: usize,
    /// How often it would not.
    pub refused: Vec<Refusal>,
}

impl Station {
    /// What it answers to an order, as a station on order must.
    fn told(&mut self, now: Tick, order: &OrderMessage, dice: &mut Dice) -> Reply {
        let key = order.key;
        if self.doing.is_some_and(|(doing, _)| doing == key) {
            self.doubled += 1;
            return Reply::Running;
        }
        if let Some(&(_, outcome)) = self.heard.results.iter().find(|(had, _)| *had == key) {
            self.doubled += 1;
            return Reply::Ended(outcome);
        }
        let refusal = if order.memory != self.heard.memory {
            Refusal::OtherMemory
        } else if key.epoch < self.heard.epoch {
            Refusal::OldEpoch
        } else if key.id <= self.last {
            Refusal::Old
        } else if self.doing.is_some() {
            Refusal::Busy
        } else if order.limit.is_zero() {
            Refusal::Late
        } else {
            (self.heard.epoch, self.last, self.heard.slot) = (key.epoch, key.id, Some(key));
            self.doing = Some((key, now + Duration::from_millis(500 + dice.below(1500) as u64)));
            self.done.push((key, order.task.to_string(), order.part));
            return Reply::Running;
        };
        self.refused.push(refusal);
        Reply::Refused(refusal)
    }

    /// Ends what it is doing when the time has come.
    fn tick(&mut self, now: Tick, dice: &mut Dice) -> Option<(OrderKey, Reply)> {
        let (key, _) = self.doing.take_if(|(_, until)| *until <= now)?;
        self.heard.slot = None;
        let fails = self.failing > 0 && dice.one_in(self.failing);
        let outcome = if fails { Outcome::Failed(7) } else { Outcome::Done };
        self.heard.results.push((key, outcome));
        if self.heard.results.len() > 16 {
            self.heard.results.remove(0);
        }
        Some((key, Reply::Ended(outcome)))
    }
}

pub enum Flying {
    Order(OrderMessage),
    Reply(usize, OrderKey, Reply),
    State(usize, u64, Heard),
}

pub struct World {
    pub it: Compiled,
    pub coordination: Coordination,
    pub log: Vec<Record>,
    pub stations: Vec<Station>,
    pub now: Tick,
    /// Kills the coordinator after so many of its steps: each record and each message is one.
    pub crash_at: Vec<usize>,
    /// One message in so many is lost, and as many are doubled; none with 0.
    pub bad_luck: usize,
    pub steps: usize,
    pub lives: usize,
    /// Whether after each step the records are replayed.
    pub replays: bool,
    pub dice: Dice,
    pub flying: BTreeMap<(Tick, u64), Flying>,
    pub sent: u64,
    /// The newest state of each station that this life has heard.
    pub newest: Vec<u64>,
    pub publish: Tick,
}

impl World {
    pub fn new(it: Compiled, stations: usize, seed: u64) -> Self {
        let state = State::new(it.table.clone());
        let mut out = Outbox::default();
        let coordination = Coordination::begin(state, Tick::ZERO, 1, &mut out).unwrap();
        World {
            it,
            coordination,
            log: out.records,
            stations: (0..stations).map(|_| Station::default()).collect(),
            now: Tick::ZERO,
            crash_at: Vec::new(),
            bad_luck: 0,
            steps: 0,
            lives: 1,
            replays: false,
            dice: Dice::new(seed),
            flying: BTreeMap::new(),
            sent: 0,
            newest: vec![0; stations],
            publish: Tick::ZERO,
        }
    }

    pub fn state(&self) -> &State {
        self.coordination.state()
    }

    /// Goes on until nothing has happened for three seconds, at most until a time.
    pub fn run(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) {
        loop {
            let quiet = self.now.since(self.state().now()) > Duration::from_secs(3);
            let is_idle = self.state().firings().all(|firing| firing.phase != Phase::Running);
            if quiet && is_idle {
                return;
            }
            let ends = self.stations.iter().filter_map(|station| station.doing.map(|(_, until)| until));
            let arrives = self.flying.keys().next().map(|&(at, _)| at);
            let next = ends.chain(arrives).chain(self.coordination.next_deadline()).chain([self.publish]).min();
            self.now = self.now.max(next.unwrap());
            if self.now > until {
                return;
            }
            self.stations_go_on();
            let arrived = self.arrived();
            let mut inputs = vec![Input::Starts(true)];
            for (station, what) in &arrived {
                inputs.push(match what {
                    Ok(heard) => Input::Station(*station, heard),
                    Err((key, reply)) => Input::Reply(*station, *key, *reply),
                });
            }
            let mut out = Outbox::default();
            self.coordination.step(self.now, &inputs, dispatcher, &mut out);
            assert_eq!(out.events, [], "at {}", self.now);
            self.perform(out);
            if self.replays {
                let replayed = State::replay(self.it.table.clone(), &self.log).unwrap();
                assert_eq!(&replayed, self.state(), "at {}", self.now);
            }
        }
    }

    fn stations_go_on(&mut self) {
        for index in 0..self.stations.len() {
            if let Some((key, reply)) = self.stations[index].tick(self.now, &mut self.dice) {
                self.fly(|| Flying::Reply(index, key, reply));
            }
        }
        if self.publish <= self.now {
            self.publish = self.now + PERIOD;
            for index in 0..self.stations.len() {
                let heard = self.stations[index].heard.clone();
                let number = self.sent + 1;
                self.fly(|| Flying::State(index, number, heard.clone()));
            }
        }
    }

    /// Sends something on its way, perhaps twice, perhaps not at all.
    fn fly(&mut self, what: impl Fn() -> Flying) {
        let times = match self.bad_luck {
            0 => 1,
            cases if self.dice.one_in(cases) => 0,
            cases if self.dice.one_in(cases) => 2,
            _ => 1,
        };
        for _ in 0..times {
            self.sent += 1;
            let delay = if self.bad_luck > 0 && self.dice.one_in(20) { 400 } else { 1 + self.dice.below(20) };
            self.flying.insert((self.now + Duration::from_millis(delay as u64), self.sent), what());
        }
    }

    /// Delivers what is there by now; what of it the coordinator gets.
    #[allow(clippy::type_complexity)]
    fn arrived(&mut self) -> Vec<(StationId, Result<Heard, (OrderKey, Reply)>)> {
        let mut arrived = Vec::new();
        while let Some(entry) = self.flying.first_entry().filter(|entry| entry.key().0 <= self.now) {
            match entry.remove() {
                Flying::Order(order) => {
                    let index = usize::from(order.station.0);
                    let reply = self.stations[index].told(self.now, &order, &mut self.dice);
                    self.fly(|| Flying::Reply(index, order.key, reply));
                }
                Flying::Reply(index, key, reply) => arrived.push((StationId(index as u16), Err((key, reply)))),
                // The newest state counts, whatever comes after it.
                Flying::State(index, number, heard) if number > self.newest[index] => {
                    self.newest[index] = number;
                    arrived.push((StationId(index as u16), Ok(heard)));
                }
                Flying::State(..) => (),
            }
        }
        arrived
    }

    /// Writes down, then sends, unless the coordinator is killed in between.
    fn perform(&mut self, out: Outbox) {
        for record in out.records {
            if self.dies() {
                return self.restart();
            }
            self.log.push(record);
        }
        for Send::Order(order) in out.sends {
            if self.dies() {
                return self.restart();
            }
            self.fly(|| Flying::Order(order.clone()));
        }
    }

    fn dies(&mut self) -> bool {
        let dies = self.crash_at.contains(&self.steps);
        self.steps += 1;
        dies
    }

    /// Another life, from what has been written down.
    fn restart(&mut self) {
        let state = State::replay(self.it.table.clone(), &self.log).unwrap();
        let mut out = Outbox::default();
        let epoch = state.epoch() + 1;
        self.coordination = Coordination::begin(state, self.now, epoch, &mut out).unwrap();
        self.newest.fill(0);
        self.lives += 1;
        self.perform(out);
    }
}
