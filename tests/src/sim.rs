//! The event loop: one queue, one clock, one source of chance.
//!
//! Between two events nothing happens, so time costs nothing. Events of the same moment keep the order in which they
//! were made. After each event that could have moved anything the observer has looked; the loop stops at the first
//! thing it did not like.

use std::time::Duration;

use linewright_coordinator_shell::Remembered;
use linewright_line::{Line, StationId, Tick};
use linewright_plant::PlantOptions;
use linewright_station_logic::{Happening, PanelCommand, Restore, Snapshot};

use crate::bus::{FRAME_TIME, Field};
use crate::coordinator::{CoordinatorPerformed, CoordinatorProcess};
use crate::ledger::Ledger;
use crate::network::{Conditions, Message, Network, Node};
use crate::queue::{Due, Queue};
use crate::station::{StationPerformed, StationProcess};
use linewright_simulation::{Hands, Log, Rng, What};

/// A station as the simulation knows it: running, or what is left of it.
pub(crate) enum Process {
    Running(Box<StationProcess>),
    Killed(Snapshot),
}

/// A line in virtual time.
pub struct Sim {
    pub(crate) line: Line,
    pub(crate) seed: u64,
    pub(crate) rng: Rng,
    pub(crate) now: Tick,
    queue: Queue,
    pub(crate) network: Network,
    pub(crate) field: Field,
    field_wake: Tick,
    /// The manager's interface is off the bus.
    pub(crate) off_the_bus: bool,
    pub(crate) stations: Vec<Process>,
    station_wakes: Vec<Tick>,
    /// Who reads whose state.
    readers: Vec<Vec<Node>>,
    pub(crate) coordinator: Option<CoordinatorProcess>,
    coordinator_wake: Tick,
    /// What the coordinator's disk held when it was last killed.
    pub(crate) journal: Remembered,
    pub(crate) next_boot: u64,
    pub(crate) log: Log,
    pub(crate) ledger: Ledger,
    /// Buttons held by message.
    pub(crate) hands: Hands,
    /// Nobody says held buttons again: the operator's screen hangs.
    pub(crate) fingers_frozen: bool,
    fingers_due: bool,
    said: StationPerformed,
    ordered: CoordinatorPerformed,
    events: u64,
}

impl Sim {
    /// A line switched on at time zero, on a quiet network.
    pub fn new(line: &Line, seed: u64) -> Self {
        Sim::with(line, seed, Conditions::QUIET, 0.0)
    }

    /// A line switched on at time zero, whose motions take up to `variation` (a fraction) longer or shorter.
    pub fn with(line: &Line, seed: u64, conditions: Conditions, variation: f64) -> Self {
        let mut sim = Sim {
            line: line.clone(),
            seed,
            rng: Rng::new(seed),
            now: Tick::ZERO,
            queue: Queue::default(),
            network: Network::new(conditions),
            field: Field::new(line, PlantOptions { seed, variation, people: false }),
            field_wake: Tick::NEVER,
            off_the_bus: false,
            stations: Vec::new(),
            station_wakes: vec![Tick::NEVER; line.stations.len()],
            readers: line.station_ids().map(|station| readers_of(line, station)).collect(),
            coordinator: None,
            coordinator_wake: Tick::NEVER,
            journal: Remembered::default(),
            next_boot: 1,
            log: Log::default(),
            ledger: Ledger::new(line),
            hands: Hands::default(),
            fingers_frozen: false,
            fingers_due: false,
            said: StationPerformed::default(),
            ordered: CoordinatorPerformed::default(),
            events: 0,
        };
        for station in line.station_ids() {
            let boot_id = sim.boot_id();
            let node = StationProcess::start(line, station, boot_id, Restore::Fresh);
            sim.stations.push(Process::Running(Box::new(node)));
            sim.wake(Node::Station(station), Tick::ZERO);
        }
        sim.start_coordinator(Remembered::default());
        sim.wake_field();
        sim
    }

    /// Starts a coordinator with what its disk holds.
    pub(crate) fn start_coordinator(&mut self, journal: Remembered) {
        let boot_id = self.boot_id();
        self.coordinator = Some(CoordinatorProcess::start(&self.line, boot_id, journal));
        self.wake(Node::Coordinator, self.now);
    }

    pub(crate) fn start_station(&mut self, station: StationId, restore: Restore) {
        let boot_id = self.boot_id();
        let node = StationProcess::start(&self.line, station, boot_id, restore);
        self.stations[station.index()] = Process::Running(Box::new(node));
        self.wake(Node::Station(station), self.now);
    }

    fn boot_id(&mut self) -> u64 {
        self.next_boot += 1;
        self.next_boot
    }

    fn wake(&mut self, node: Node, at: Tick) {
        let known = match node {
            Node::Coordinator => &mut self.coordinator_wake,
            Node::Station(id) => &mut self.station_wakes[id.index()],
            Node::Operator => return,
        };
        // A wake that comes too early does no harm; one that is known to come earlier need not be repeated.
        if at < *known {
            *known = at;
            self.queue.push(at, Due::Wake(node));
        }
    }

    pub(crate) fn wake_field(&mut self) {
        for frame in self.field.drain() {
            self.queue.push(self.now + FRAME_TIME, Due::ToManager(frame));
        }
        let at = self.field.next_deadline().max(self.now);
        if at < self.field_wake {
            self.field_wake = at;
            self.queue.push(at, Due::Field);
        }
    }

    /// Says something across the network.
    pub(crate) fn say(&mut self, from: Node, to: Node, message: Message) {
        for at in self.network.ways(&mut self.rng, self.now, from, to, &message).into_iter().flatten() {
            self.queue.push(at, Due::Message { from, to, message: message.clone() });
        }
    }

    /// Says held buttons, now and from now on every refresh period, as long as any is held; and a release a few times, since
    /// one message can get lost and silence is no release.
    pub(crate) fn say_fingers(&mut self) {
        for (station, advance, held) in self.hands.panel_again() {
            self.say_panel(station, if advance { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) });
        }
        if let Some(held) = self.hands.buttons_again() {
            self.say(Node::Operator, Node::Coordinator, Message::Buttons(held));
        }
        if !self.fingers_due && self.hands.is_busy() {
            self.fingers_due = true;
            self.queue.push(self.now + self.line.timing.refresh, Due::Fingers);
        }
    }

    pub(crate) fn say_panel(&mut self, station: StationId, command: PanelCommand) {
        self.say(Node::Operator, Node::Station(station), Message::Panel(command));
    }

    /// Runs until `end`.
    ///
    /// # Panics
    /// When the observer sees what must not happen, or the ledger a cycle lost or doubled.
    pub fn run_to(&mut self, end: Tick) {
        while self.next_event().is_some_and(|at| at <= end) {
            self.step();
        }
        self.now = self.now.max(end);
    }

    /// The manager's interface leaves the bus, or comes back to it; the kernel tells the manager.
    pub fn bus_off(&mut self, off: bool) {
        self.act(format!("the manager's interface is off the bus: {off}"));
        self.off_the_bus = off;
        let told = if off { "20000040#0000000000000000" } else { "20000100#0000000000000000" };
        let frame = told.parse().unwrap_or_else(|error| panic!("{error}"));
        self.queue.push(self.now, Due::ToManager(frame));
    }

    /// Runs for a time.
    pub fn run_for(&mut self, time: Duration) {
        self.run_to(self.now + time);
    }

    pub(crate) fn next_event(&self) -> Option<Tick> {
        self.queue.next()
    }

    /// Plays one event.
    pub(crate) fn step(&mut self) {
        let Some((at, due)) = self.queue.pop() else { return };
        self.now = at;
        self.events += 1;
        match due {
            Due::Message { from, to, message } => self.deliver(from, to, &message),
            Due::Wake(node) => self.woken(node, at),
            Due::ToDevices(frame) => {
                self.field.hear(self.now, &frame);
                self.wake_field();
            }
            Due::ToManager(frame) => {
                if self.off_the_bus && frame.cob_id().is_some() {
                    return;
                }
                let Some(node) = &mut self.coordinator else { return };
                node.frame(self.now, &frame, &mut self.ordered);
                self.after_coordinator();
            }
            Due::Field => {
                if self.field_wake == at {
                    self.field_wake = Tick::NEVER;
                }
                self.field.poll(self.now);
                self.wake_field();
            }
            Due::Fingers => {
                self.fingers_due = false;
                if self.fingers_frozen {
                    self.fingers_due = true;
                    self.queue.push(self.now + self.line.timing.refresh, Due::Fingers);
                } else {
                    self.say_fingers();
                }
            }
        }
        self.judge();
    }

    fn deliver(&mut self, from: Node, to: Node, message: &Message) {
        match to {
            Node::Station(id) => {
                let Process::Running(node) = &mut self.stations[id.index()] else { return };
                node.hear(self.now, from, message, &mut self.said);
                self.after_station(id);
            }
            Node::Coordinator => {
                let Some(node) = &mut self.coordinator else { return };
                node.hear(self.now, from, message, &mut self.ordered);
                self.after_coordinator();
            }
            Node::Operator => {}
        }
    }

    fn woken(&mut self, node: Node, at: Tick) {
        match node {
            Node::Station(id) => {
                let wake = &mut self.station_wakes[id.index()];
                if *wake == at {
                    *wake = Tick::NEVER;
                }
                let Process::Running(node) = &mut self.stations[id.index()] else { return };
                if node.next_deadline() <= at {
                    node.step(at, &mut self.said);
                }
                self.after_station(id);
            }
            Node::Coordinator => {
                if self.coordinator_wake == at {
                    self.coordinator_wake = Tick::NEVER;
                }
                let Some(node) = &mut self.coordinator else { return };
                if node.next_deadline(at) <= at {
                    node.step(at, &mut self.ordered);
                }
                self.after_coordinator();
            }
            Node::Operator => {}
        }
    }

    fn after_station(&mut self, id: StationId) {
        let from = Node::Station(id);
        let mut said = std::mem::take(&mut self.said);
        for event in said.events.drain(..) {
            self.ledger.enter(&self.line, id, &event);
            if event.what == Happening::Refused {
                self.refused(id);
            }
            self.log.push(self.now, What::Station(id, event));
        }
        for (to, message) in said.messages.drain(..) {
            if to == Node::Operator {
                for at in 0..self.readers[id.index()].len() {
                    self.say(from, self.readers[id.index()][at], message.clone());
                }
            } else {
                self.say(from, to, message);
            }
        }
        self.said = said;
        if let Process::Running(node) = &self.stations[id.index()] {
            if node.dead {
                let journal = node.journal.clone();
                self.stations[id.index()] = Process::Killed(journal);
            } else {
                let at = node.next_deadline();
                self.wake(from, at.max(self.now));
            }
        }
    }

    /// A press that moves nothing must leave the operator with a reason to read, if nothing is moving anyway.
    fn refused(&mut self, id: StationId) {
        let Some(controller) = self.controller(id) else { return };
        let silent = controller.blocked_by(&self.line, self.now).is_empty();
        if silent && !controller.marking().any(|place| place.is_operating()) {
            self.give_up(&format!("{} refuses a press and does not say why", self.line.station(id).name));
        }
    }

    fn after_coordinator(&mut self) {
        let mut said = std::mem::take(&mut self.ordered);
        for mode in said.modes.drain(..) {
            self.log.push(self.now, What::Mode(mode));
        }
        for refusal in said.refusals.drain(..) {
            let text = refusal.text(&self.line);
            self.log.push(self.now, What::Refusal(text));
        }
        for (to, message) in said.messages.drain(..) {
            self.say(Node::Coordinator, to, message);
        }
        let off_the_bus = self.off_the_bus;
        for frame in said.frames.drain(..).filter(|_| !off_the_bus) {
            self.queue.push(self.now + FRAME_TIME, Due::ToDevices(frame));
        }
        self.ordered = said;
        if let Some(node) = &self.coordinator {
            let at = node.next_deadline(self.now);
            self.wake(Node::Coordinator, at.max(self.now));
        }
    }

    fn judge(&self) {
        let violations = self.field.observer().violations();
        if !violations.is_empty() {
            self.give_up(&violations.join("\n"));
        }
        if self.field.plant().alarms() != 0 {
            self.give_up("drives both ways of one axis came on at once");
        }
        if !self.ledger.errors().is_empty() {
            self.give_up(&self.ledger.errors().join("\n"));
        }
    }

    /// Ends the run with what a person needs to understand it.
    pub(crate) fn give_up(&self, why: &str) -> ! {
        let tail = self.log.tail(&self.line, 120);
        let states = self.states_text();
        panic!("{why}\nat {} with seed {}\n{tail}{states}", self.now, self.seed);
    }

    /// Events played so far.
    pub fn events(&self) -> u64 {
        self.events
    }
}

/// The coordinator and every station with an arrow to or from it.
fn readers_of(line: &Line, station: StationId) -> Vec<Node> {
    let peers = line.station_ids().filter(|&other| {
        let joins = |a: &linewright_line::Arrow| {
            (a.from.0 == station && a.to.0 == other) || (a.to.0 == station && a.from.0 == other)
        };
        let between = |a: StationId, b: StationId| (a, b) == (station, other) || (b, a) == (station, other);
        line.arrows.iter().any(joins) || line.conflicts.iter().any(|c| between(c.a.station, c.b.station))
    });
    [Node::Coordinator].into_iter().chain(peers.map(Node::Station)).collect()
}
