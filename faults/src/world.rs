//! A line with everything around it, and its event loop.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap, VecDeque};
use std::time::Duration;

use linewright_line::{DeviceBus, Line, Owner, StationId, Tick};
use linewright_plant::{Plant, PlantOptions};
use linewright_simulation::Rng;

use crate::broken::LastHeard;
use crate::coordinator::CoordinatorProcess;
use crate::devices::OwnedIo;
use crate::message::Message;
use crate::mutants::Mutant;
use crate::network::Network;
use crate::observer::Observer;
use crate::plan::PlannedFault;
use crate::process::Process;
use crate::station::StationProcess;

/// Something that is going to happen.
#[derive(Debug)]
pub(crate) enum Event {
    Deliver { to: usize, life: u64, message: Message },
    Wake { node: usize, life: u64 },
    Devices(usize),
    Written { node: usize, life: u64 },
    SlowRecord { node: usize, life: u64 },
    OrderAgain { life: u64 },
    Fault(usize),
    FaultEnds(usize),
    Restart { node: usize, remembers: bool },
    Hands,
    LooksForOff { station: usize, stop: u64 },
    LooksForStop { which: usize, life: u64, since: Tick },
}

struct Scheduled {
    at: Tick,
    number: u64,
    event: Event,
}

impl PartialEq for Scheduled {
    fn eq(&self, other: &Self) -> bool {
        (self.at, self.number) == (other.at, other.number)
    }
}

impl Eq for Scheduled {}

impl PartialOrd for Scheduled {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Scheduled {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.at, self.number).cmp(&(other.at, other.number))
    }
}

/// Panel buttons, hand-mode buttons and resume that are held, and releases to be repeated.
#[derive(Debug, Default)]
pub(crate) struct Hands {
    pub(crate) panel: BTreeMap<(usize, bool), Option<u8>>,
    pub(crate) buttons: u32,
    pub(crate) releases: u8,
    pub(crate) resume: bool,
    pub(crate) resume_releases: u8,
}

pub(crate) struct World {
    pub(crate) line: Line,
    pub(crate) now: Tick,
    pub(crate) mutant: Option<Mutant>,
    queue: BinaryHeap<Reverse<Scheduled>>,
    number: u64,
    pub(crate) plant: Plant,
    /// By station; the console last.
    pub(crate) io: Vec<OwnedIo>,
    io_wakes: Vec<Tick>,
    pub(crate) stations: Vec<StationProcess>,
    /// The line's own, and another one without devices.
    pub(crate) coordinators: [CoordinatorProcess; 2],
    pub(crate) network: Network,
    pub(crate) rng: Rng,
    seed: u64,
    lives: u64,
    pub(crate) hands: Hands,
    pub(crate) observer: Observer,
    pub(crate) plan: Vec<PlannedFault>,
    /// Faults that have begun and not ended.
    pub(crate) active: Vec<bool>,
    /// None begins any more.
    pub(crate) is_mended: bool,
    pub(crate) story: Vec<(Tick, String)>,
    pub(crate) hash: u64,
    pub(crate) events: u64,
    /// By station: orders that were sent to it within the last seconds.
    pub(crate) orders: Vec<VecDeque<(Tick, Message)>>,
    /// With a mutant that renews messages: the last of each.
    pub(crate) last: LastHeard,
}

/// Events of one seed. Most have some ten thousand.
const EVENTS_MAX: u64 = 2_000_000;

impl World {
    pub(crate) fn new(line: Line, seed: u64, plan: Vec<PlannedFault>, mutant: Option<Mutant>) -> Self {
        let plant = Plant::new(&line, PlantOptions { seed, variation: 0.05, people: false });
        let timeout = line.timing.heartbeat_timeout;
        let owners = line.station_ids().map(Owner::Station).chain([Owner::Console]);
        let keeps = (mutant == Some(Mutant::OutputsKeptAtLoss), mutant == Some(Mutant::OutputsKeptAtRestart));
        let io: Vec<OwnedIo> = owners.map(|owner| OwnedIo::new(owner, timeout, keeps)).collect();
        let nodes = line.stations.len() + 3;
        let mut world = World {
            observer: Observer::new(&line, &plant),
            stations: line.station_ids().map(StationProcess::new).collect(),
            coordinators: [CoordinatorProcess::new(true), CoordinatorProcess::new(false)],
            network: Network::new(seed, nodes),
            rng: Rng::named(seed, "world"),
            io_wakes: vec![Tick::NEVER; io.len()],
            now: Tick::ZERO,
            queue: BinaryHeap::new(),
            number: 0,
            seed,
            lives: 0,
            hands: Hands::default(),
            active: vec![false; plan.len()],
            is_mended: false,
            story: Vec::new(),
            hash: 0xCBF2_9CE4_8422_2325,
            events: 0,
            last: LastHeard::new(nodes),
            orders: vec![VecDeque::new(); line.stations.len()],
            io,
            plant,
            line,
            plan,
            mutant,
        };
        for at in 0..world.plan.len() {
            world.after(world.plan[at].at.since(Tick::ZERO), Event::Fault(at));
        }
        for io in &mut world.io {
            io.lose(Tick::ZERO, &world.plant);
        }
        for at in 0..world.stations.len() {
            world.start_station(at, true);
        }
        world.start_coordinator(0, true);
        world.after(Duration::ZERO, Event::Hands);
        world
    }

    pub(crate) fn coordinator_node(&self) -> usize {
        self.stations.len()
    }

    pub(crate) fn operator_node(&self) -> usize {
        self.stations.len() + 2
    }

    pub(crate) fn process(&mut self, node: usize) -> &mut Process {
        let stations = self.stations.len();
        match self.stations.get_mut(node) {
            Some(station) => &mut station.process,
            None => &mut self.coordinators[(node - stations).min(1)].process,
        }
    }

    pub(crate) fn name(&self, node: usize) -> &str {
        let others = ["coordinator", "second coordinator", "operator"];
        match self.line.stations.get(node) {
            Some(station) => &station.name,
            None => others[(node - self.stations.len()).min(2)],
        }
    }

    pub(crate) fn is_behind_gateway(&self, station: usize) -> bool {
        self.line.stations[station].bus == DeviceBus::Line
    }

    pub(crate) fn next_life(&mut self) -> (u64, u64) {
        self.lives += 1;
        let boot_id = Rng::new(self.seed ^ self.lives.rotate_left(40)).next() | 1;
        (self.lives, boot_id)
    }

    pub(crate) fn after(&mut self, time: Duration, event: Event) {
        self.number += 1;
        self.queue.push(Reverse(Scheduled { at: self.now + time, number: self.number, event }));
    }

    fn at(&mut self, at: Tick, event: Event) {
        self.number += 1;
        self.queue.push(Reverse(Scheduled { at: at.max(self.now), number: self.number, event }));
    }

    /// The process is called at `at` by its own clock, if not before.
    pub(crate) fn wake(&mut self, node: usize, local: Tick) {
        let now = self.now;
        let process = self.process(node);
        let at = process.world(local).max(now);
        if at < process.wakes {
            process.wakes = at;
            let life = process.life;
            self.at(at, Event::Wake { node, life });
        }
    }

    pub(crate) fn note(&mut self, what: String) {
        self.mix(what.len() as u64 ^ self.now.as_micros());
        self.story.push((self.now, what));
    }

    pub(crate) fn mix(&mut self, number: u64) {
        self.hash = (self.hash ^ number).wrapping_mul(0x0100_0000_01B3).rotate_left(5);
    }

    pub(crate) fn send(&mut self, from: usize, to: usize, message: Message) {
        let arrivals = self.network.send(self.now, (from, to), &message);
        let life = self.process(to).life;
        if let [Some(first), second] = arrivals {
            if let Some(second) = second {
                self.at(second, Event::Deliver { to, life, message: message.clone() });
            }
            self.at(first, Event::Deliver { to, life, message });
        }
    }

    /// Runs until `end`, or until the observer has found something.
    pub(crate) fn run_to(&mut self, end: Tick) {
        while self.observer.finding.is_none() && self.queue.peek().is_some_and(|Reverse(next)| next.at <= end) {
            let Some(Reverse(next)) = self.queue.pop() else { break };
            self.now = self.now.max(next.at);
            self.events += 1;
            self.mix(next.at.as_micros());
            self.play(next.event);
            if self.events > EVENTS_MAX {
                self.observer.find(self.now, "messages follow from messages without end".to_owned());
            }
        }
        self.now = self.now.max(end);
    }

    pub(crate) fn run_for(&mut self, time: Duration) {
        self.run_to(self.now + time);
    }

    fn play(&mut self, event: Event) {
        match event {
            Event::Deliver { to, life, message } => self.deliver(to, life, message),
            Event::Wake { node, life } => {
                let now = self.now;
                let process = self.process(node);
                if process.life == life && process.wakes <= now {
                    process.wakes = Tick::NEVER;
                    self.run_node(node);
                }
            }
            Event::Devices(at) => {
                self.io_wakes[at] = Tick::NEVER;
                self.look_at_devices(at);
            }
            Event::Written { node, life } if self.process(node).life == life => {
                if self.process(node).stalls > 0 {
                    self.after(Duration::from_millis(5), Event::Written { node, life });
                } else if node < self.stations.len() {
                    self.station_written(node);
                } else {
                    self.coordinator_written(node - self.stations.len());
                }
            }
            Event::SlowRecord { node, life } if self.process(node).life == life => {
                if node < self.stations.len() {
                    self.interrupt_station(node);
                } else {
                    self.slow_record(node - self.stations.len());
                }
            }
            Event::Written { .. } | Event::SlowRecord { .. } => {}
            Event::OrderAgain { life } => self.order_again(life),
            Event::Fault(at) => self.begin_fault(at),
            Event::FaultEnds(at) => self.end_fault(at),
            Event::Restart { node, remembers } => self.start(node, remembers),
            Event::Hands => self.hands_again(),
            Event::LooksForOff { station, stop } => self.look_for_off(station, stop),
            Event::LooksForStop { which, life, since } => self.look_for_stop(which, life, since),
        }
    }

    pub(crate) fn run_node(&mut self, node: usize) {
        if node < self.stations.len() {
            self.run_station(node);
        } else if node < self.operator_node() {
            self.run_coordinator(node - self.stations.len());
        }
    }

    /// Something about the devices of an owner may have changed: their manager looks.
    pub(crate) fn look_at_devices(&mut self, at: usize) {
        let now = self.now;
        self.plant.advance(now);
        self.io[at].poll(now, &mut self.plant);
        self.after_plant(at);
        let image = self.io[at].image(now, &self.plant);
        if at < self.stations.len() && !self.is_behind_gateway(at) {
            if self.stations[at].seen != Some(image) {
                self.run_station(at);
            }
        } else if self.coordinators[0].seen[at] != Some(image) {
            self.console_news(at);
        }
    }

    /// Outputs or positions of a station have changed.
    pub(crate) fn after_plant(&mut self, at: usize) {
        let mut next = self.io[at].deadline(self.now);
        if at < self.stations.len() {
            self.observer.look(&self.line, &self.plant, at);
            if self.io[at].unreached.is_none() {
                self.observer.look_at_given(&self.line, &self.plant, at, self.io[at].given());
            }
            self.mix(self.plant.outputs(Owner::Station(StationId::at(at))) as u64);
            next = next.min(self.plant.next_change_of(StationId::at(at)).unwrap_or(Tick::NEVER));
        }
        if next < self.io_wakes[at] {
            self.io_wakes[at] = next;
            self.at(next, Event::Devices(at));
        }
    }

    /// Outputs for the devices of an owner, by their manager.
    pub(crate) fn put(&mut self, at: usize, bits: u128) {
        let now = self.now;
        self.io[at].ask(now, bits, &mut self.plant);
        self.after_plant(at);
    }

    pub(crate) fn behind_gateway(&self) -> Vec<usize> {
        (0..self.stations.len()).filter(|&at| self.is_behind_gateway(at)).collect()
    }

    /// The owners whose devices a node manages.
    pub(crate) fn managed(&self, node: usize) -> Vec<usize> {
        let stations = self.stations.len();
        if node < stations {
            return if self.is_behind_gateway(node) { Vec::new() } else { vec![node] };
        }
        if node > stations {
            return Vec::new();
        }
        [self.behind_gateway(), vec![stations]].concat()
    }

    /// A process ends at once. Its devices keep their outputs until they miss it.
    pub(crate) fn kill(&mut self, node: usize) {
        if !self.process(node).is_up {
            return;
        }
        let (now, stations) = (self.now, self.stations.len());
        // A record that was being written is there whole, or not at all.
        let is_there = self.rng.chance(500);
        if node < stations {
            self.stations[node].die(is_there);
        } else {
            self.coordinators[node - stations].die(is_there);
        }
        let kept = self.stations.get(node).and_then(|station| station.disk.newest());
        self.observer.ended(node, kept.map(|(record, _)| record.clone()));
        for owner in self.managed(node) {
            self.io[owner].lose(now, &self.plant);
            self.after_plant(owner);
        }
    }

    pub(crate) fn start(&mut self, node: usize, remembers: bool) {
        if self.process(node).is_up {
            return;
        }
        if node < self.stations.len() {
            self.start_station(node, remembers);
        } else {
            self.observer.disk_keeps(remembers || node != self.coordinator_node());
            self.start_coordinator(node - self.stations.len(), remembers);
        }
        let shell = self.coordinators.first().and_then(|of| of.shell.as_ref());
        let is_stopped = shell.is_some_and(|of| of.coordinator().is_estopped());
        self.observer.started(node, is_stopped);
    }

    /// The devices of a node that has started, which boots them.
    pub(crate) fn take_devices(&mut self, node: usize) {
        let now = self.now;
        for owner in self.managed(node) {
            self.io[owner].new_manager(now, &mut self.plant);
            self.io[owner].find(now, &mut self.plant);
            self.after_plant(owner);
        }
    }
}
