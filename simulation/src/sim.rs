//! The event loop: one clock, a tournament of deadlines, no queue of things to come beyond what is on its way.
//!
//! Between two events nothing happens, so time costs nothing. What may happen next is one of a fixed set: a message
//! that says something new arrives, a mechanism presses a switch, a controller's deadline passes, somebody repeats
//! state. Of two at the same moment the order is always the same, so a seed gives the same run to the microsecond.

use std::collections::VecDeque;

use linewright_coordinator_logic::{Command, Refusal};
use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_plant::PlantOptions;
use linewright_station_logic::{CompileError, Controller, Restore};

use crate::field::Field;
use crate::link::{Link, Said};
use crate::log::{Log, What};
use crate::node::{CoordinatorNode, StationNode};
use crate::observer::{Observer, Seen};
use crate::operator::Hands;
use crate::options::Options;
use crate::record::Record;
use crate::timers::Timers;

/// An answer to a command: obeyed, or refused.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) command: Command,
    pub(crate) refusal: Option<Refusal>,
}

/// A line in virtual time.
pub struct Sim {
    pub(crate) line: Line,
    pub(crate) options: Options,
    pub(crate) now: Tick,
    pub(crate) stations: Vec<StationNode>,
    pub(crate) coordinator: CoordinatorNode,
    pub(crate) hands: Hands,
    pub(crate) field: Field,
    observer: Observer,
    pub(crate) links: Vec<Link>,
    /// By node: links to it and from it.
    pub(crate) into: Vec<Vec<usize>>,
    out_of: Vec<Vec<usize>>,
    /// By link between stations: the arrows from its writer into its reader.
    arrows: Vec<Vec<usize>>,
    timers: Timers,
    /// Who repeats its state when, and in which life; sorted, because all have the same period.
    repeats: VecDeque<(Tick, usize, u64)>,
    /// By node: its life, for whoever knew it before it died.
    lives: Vec<u64>,
    life: u64,
    log: Log,
    record: Record,
    pub(crate) answers: Vec<Answer>,
    mode: ControlMode,
    /// When a station last had something to tell.
    pub(crate) last_event: Tick,
    renewals: Vec<(Tick, usize)>,
    events: u64,
}

impl Sim {
    /// A line switched on at time zero.
    ///
    /// # Errors
    /// When a station does not compile.
    pub fn new(line: &Line, options: Options) -> Result<Self, CompileError> {
        let count = line.stations.len();
        let field = Field::new(line, PlantOptions { seed: options.seed, variation: options.variation });
        let (links, arrows) = links_of(line, &options);
        let of = |end: &dyn Fn(&Link) -> usize| -> Vec<Vec<usize>> {
            let of_node = |node: usize| (0..links.len()).filter(|&at| end(&links[at]) == node).collect();
            (0..count + 2).map(of_node).collect()
        };
        let mut sim = Sim {
            observer: Observer::new(line, &field),
            into: of(&|link| link.to),
            out_of: of(&|link| link.from),
            timers: Timers::new(links.len() + 2 * (count + 1)),
            links,
            arrows,
            field,
            stations: Vec::with_capacity(count),
            coordinator: CoordinatorNode::start(line, 1, 0, false),
            hands: Hands::default(),
            repeats: VecDeque::new(),
            lives: vec![1; count + 2],
            life: 1,
            log: Log::default(),
            record: Record::new(line),
            answers: Vec::new(),
            mode: ControlMode::Home,
            last_event: Tick::ZERO,
            renewals: Vec::new(),
            events: 0,
            line: line.clone(),
            options,
            now: Tick::ZERO,
        };
        for id in line.station_ids() {
            let life = sim.next_life();
            sim.stations.push(StationNode::start(line, id, life, Restore::Fresh, options.rules)?);
            sim.begin(id.index(), life);
        }
        let life = sim.next_life();
        sim.coordinator.life = life;
        sim.begin(sim.coordinator_node(), life);
        sim.repeats.push_back((Tick::ZERO, sim.operator_node(), 1));
        Ok(sim)
    }

    fn next_life(&mut self) -> u64 {
        self.life += 1;
        self.life
    }

    pub(crate) fn coordinator_node(&self) -> usize {
        self.line.stations.len()
    }

    pub(crate) fn operator_node(&self) -> usize {
        self.line.stations.len() + 1
    }

    /// A node begins a life now: it looks at its devices and says its state, now and from now on.
    fn begin(&mut self, node: usize, life: u64) {
        self.lives[node] = life;
        for at in 0..self.out_of[node].len() {
            self.links[self.out_of[node][at]].forget_said();
        }
        for at in 0..self.into[node].len() {
            let link = self.into[node][at];
            self.links[link].forget_heard();
            self.timers.set(link, Tick::NEVER);
        }
        self.repeats.push_front((self.now, node, life));
        self.wake_field(node);
        self.wake_node(node, self.now);
    }

    /// Starts a station that is down, from its journal.
    pub(crate) fn restart_station(&mut self, at: usize) -> Result<(), CompileError> {
        let Some(journal) = self.stations[at].journal.take() else { return Ok(()) };
        let life = self.next_life();
        let id = StationId::at(at);
        self.stations[at] = StationNode::start(&self.line, id, life, Restore::From(journal), self.options.rules)?;
        self.field.owner_up(self.now, at);
        self.begin(at, life);
        Ok(())
    }

    /// Ends a station's process.
    pub(crate) fn kill_station(&mut self, at: usize) {
        let node = &mut self.stations[at];
        if node.is_up() {
            node.journal = Some(node.controller.snapshot());
            // What it asked for stands until the gateway or its own bus's devices miss it.
            let timing = &self.line.timing;
            let until = match self.line.stations[at].bus {
                linewright_line::Bus::Line => timing.stale,
                linewright_line::Bus::Own(_) => timing.heartbeat_timeout,
            };
            self.field.owner_down(at, self.now + until);
            self.timers.set(self.node_slot(at), Tick::NEVER);
            self.wake_field(at);
        }
    }

    /// Ends the coordinator's process, and with it whoever reads the line's bus.
    pub(crate) fn kill_coordinator(&mut self) {
        if self.coordinator.is_up {
            self.coordinator.is_up = false;
            self.field.bus_read(self.now, &self.line, false);
            self.timers.set(self.node_slot(self.coordinator_node()), Tick::NEVER);
            self.wake_fields();
        }
    }

    /// Starts a coordinator that has the journal of the one before.
    pub(crate) fn restart_coordinator(&mut self) {
        if !self.coordinator.is_up {
            let (epoch, estopped) = (self.coordinator.coordinator.epoch(), self.coordinator.coordinator.is_estopped());
            let life = self.next_life();
            self.coordinator = CoordinatorNode::start(&self.line, life, epoch, estopped);
            self.mode = self.coordinator.coordinator.mode();
            self.field.bus_read(self.now, &self.line, true);
            self.wake_fields();
            self.begin(self.coordinator_node(), life);
        }
    }

    fn is_up(&self, node: usize) -> bool {
        match self.stations.get(node) {
            Some(station) => station.is_up(),
            None => node != self.coordinator_node() || self.coordinator.is_up,
        }
    }

    fn field_slot(&self, at: usize) -> usize {
        self.links.len() + at
    }

    fn node_slot(&self, node: usize) -> usize {
        self.links.len() + self.line.stations.len() + 1 + node
    }

    pub(crate) fn wake_field(&mut self, at: usize) {
        if at <= self.line.stations.len() {
            self.timers.set(self.field_slot(at), self.now);
        }
    }

    pub(crate) fn wake_fields(&mut self) {
        for at in 0..=self.line.stations.len() {
            self.wake_field(at);
        }
    }

    fn wake_node(&mut self, node: usize, at: Tick) {
        self.timers.set(self.node_slot(node), at);
    }

    /// When the next thing happens.
    #[inline]
    pub fn next_event(&self) -> Tick {
        let repeat = self.repeats.front().map_or(Tick::NEVER, |repeat| repeat.0);
        self.timers.earliest().min(repeat)
    }

    /// Plays one event.
    pub fn step(&mut self) {
        self.events += 1;
        let at = self.timers.earliest();
        match self.repeats.front() {
            Some(&(due, node, life)) if due < at => {
                self.now = due;
                self.repeats.pop_front();
                self.repeat(node, life);
            }
            _ if at == Tick::NEVER => {}
            _ => {
                self.now = at;
                let slot = self.timers.first();
                let stations = self.line.stations.len();
                if slot < self.links.len() {
                    self.arrival(slot);
                } else if slot - self.links.len() <= stations {
                    self.field_changes(slot - self.links.len());
                } else {
                    self.deadline(slot - self.links.len() - stations - 1);
                }
            }
        }
    }

    /// Runs until `end`, whatever happens.
    pub fn run_to(&mut self, end: Tick) {
        while self.next_event() <= end {
            self.step();
        }
        self.now = self.now.max(end);
    }

    /// Takes what has arrived and says nothing new, each at its own time.
    #[inline]
    fn catch_up(&mut self, node: usize) {
        let mut renewals = std::mem::take(&mut self.renewals);
        for &at in &self.into[node] {
            self.links[at].take_repetitions(self.now, at, &mut renewals);
        }
        if renewals.len() > 1 {
            renewals.sort_unstable();
        }
        for (arrived, at) in renewals.drain(..) {
            let link = &self.links[at];
            let Some(said) = &link.heard else { continue };
            match self.stations.get_mut(node) {
                Some(station) => station.hear(arrived, link.from, said),
                None => self.coordinator.hear(arrived, link.from, said),
            }
        }
        self.renewals = renewals;
    }

    fn arrival(&mut self, at: usize) {
        let node = self.links[at].to;
        if !self.is_up(node) {
            self.links[at].forget_heard();
            self.timers.set(at, Tick::NEVER);
            return;
        }
        self.catch_up(node);
        let said = self.links[at].take_news(self.now);
        self.timers.set(at, self.links[at].wakes());
        let from = self.links[at].from;
        match self.stations.get_mut(node) {
            Some(station) => {
                if let Some(said) = &said {
                    station.hear(self.now, from, said);
                    if let Said::Report(report) = said {
                        self.record.hear(&self.line, self.now, &self.arrows[at], report);
                    }
                }
                self.play_station(node);
            }
            None => {
                if let Some(said) = &said {
                    self.coordinator.hear(self.now, from, said);
                }
                let command = if let Some(Said::Command(command)) = said { Some(command) } else { None };
                self.play_coordinator(command);
            }
        }
    }

    fn field_changes(&mut self, at: usize) {
        self.field.poll(self.now, at);
        if at == self.coordinator_node() {
            if self.field.has_console() && self.coordinator.is_up {
                let image = self.field.image(at);
                self.catch_up(at);
                if self.coordinator.see(self.now, image) {
                    self.play_coordinator(None);
                }
            }
        } else {
            self.observer.look(&self.line, &self.field, at);
            if self.stations[at].is_up() {
                let image = self.field.image(at);
                self.catch_up(at);
                // Otherwise only terms have moved; the deadline that is set comes too early, and does no harm.
                if self.stations[at].see(self.now, image) {
                    self.play_station(at);
                }
            }
        }
        let deadline = self.field.deadline(at);
        self.timers.set(self.field_slot(at), deadline);
    }

    fn deadline(&mut self, node: usize) {
        self.catch_up(node);
        if node < self.stations.len() {
            self.play_station(node);
        } else {
            self.play_coordinator(None);
        }
    }

    fn play_station(&mut self, at: usize) {
        let now = self.now;
        let node = &mut self.stations[at];
        let before = node.outputs;
        let says = node.step(now);
        let (outputs, id) = (node.outputs, node.id);
        if !node.events().is_empty() {
            self.last_event = now;
            let mut events = std::mem::take(node.events());
            for event in events.drain(..) {
                self.record.enter(&self.line, now, id, &event);
                if self.options.keeps_log {
                    self.log.push(now, What::Station(id, event));
                }
            }
            *self.stations[at].events() = events;
        }
        if outputs != before {
            self.field.ask(now, at, outputs);
            self.observer.look(&self.line, &self.field, at);
            self.timers.set(self.field_slot(at), self.field.deadline(at));
        }
        if says {
            self.attend(at);
            self.say_station(at);
        }
        let deadline = self.stations[at].controller.next_deadline().unwrap_or(Tick::NEVER);
        self.wake_node(at, deadline.max(now));
    }

    /// Where a person's button decides what a station does next, its controller is woken by every message: a press is
    /// looked at again in the step after the one it arrived in.
    fn attend(&mut self, at: usize) {
        let mode = self.stations[at].controller.mode();
        let attends = self.options.one_by_one || matches!(mode, ControlMode::Hand | ControlMode::Manual);
        for index in 0..self.into[at].len() {
            let link = self.into[at][index];
            if self.links[link].wakes_always != attends {
                self.links[link].wake_always(attends);
                self.timers.set(link, self.links[link].wakes());
            }
        }
    }

    fn play_coordinator(&mut self, asked: Option<Command>) {
        let now = self.now;
        let node = &mut self.coordinator;
        node.coordinator.step(now, &mut node.outbox);
        for mode in node.outbox.modes.drain(..) {
            self.mode = mode;
            self.last_event = now;
            if self.options.keeps_log {
                self.log.push(now, What::Mode(mode));
            }
        }
        let mut refusal = None;
        for refused in node.outbox.refusals.drain(..) {
            if self.options.keeps_log {
                self.log.push(now, What::Refusal(refused.text(&self.line)));
            }
            refusal = Some(refused);
        }
        if let Some(command) = asked {
            self.answers.push(Answer { command, refusal });
        }
        if node.outbox.changed {
            self.say_order();
        }
        let deadline = self.coordinator.coordinator.next_deadline().unwrap_or(Tick::NEVER);
        self.wake_node(self.coordinator_node(), deadline.max(now));
    }

    /// A node repeats its state.
    fn repeat(&mut self, node: usize, life: u64) {
        if self.lives[node] != life || !self.is_up(node) {
            return;
        }
        if node < self.stations.len() {
            self.say_station(node);
        } else if node == self.coordinator_node() {
            self.say_order();
        } else {
            self.say_held();
        }
        let again = (self.now + self.line.timing.refresh, node, life);
        let place = self.repeats.partition_point(|repeat| repeat.0 <= again.0);
        self.repeats.insert(place, again);
    }

    fn say_station(&mut self, at: usize) {
        self.stations[at].write_report();
        let (now, network, coordinator) = (self.now, self.options.network, self.coordinator_node());
        for index in 0..self.out_of[at].len() {
            let number = self.out_of[at][index];
            if !self.is_up(self.links[number].to) {
                continue;
            }
            let (link, node) = (&mut self.links[number], &self.stations[at]);
            if link.has_said(node.version) {
                link.say_again(now, &network);
            } else if link.to == coordinator {
                link.say_heard(now, &network, node.heard(), node.version);
            } else {
                link.say_report(now, &network, &node.report, node.version);
            }
            self.timers.set(number, self.links[number].wakes());
        }
    }

    fn say_order(&mut self) {
        // Buttons held by message run out without a word.
        let order = self.coordinator.order();
        let (now, network, version) = (self.now, self.options.network, self.coordinator.version);
        let node = self.coordinator_node();
        for index in 0..self.out_of[node].len() {
            let number = self.out_of[node][index];
            if self.is_up(self.links[number].to) {
                self.links[number].say_order(now, &network, order, version);
                self.timers.set(number, self.links[number].wakes());
            }
        }
    }

    /// Says a word of the operator's to a node.
    pub(crate) fn say_word(&mut self, to: usize, said: Said) {
        let operator = self.operator_node();
        let number = self.out_of[operator].iter().copied().find(|&at| self.links[at].to == to);
        if let Some(number) = number.filter(|_| self.is_up(to)) {
            self.links[number].say_word(self.now, &self.options.network, said);
            self.timers.set(number, self.links[number].wakes());
        }
    }

    pub(crate) fn note(&mut self, what: String) {
        if self.options.keeps_log {
            self.log.push(self.now, What::Act(what));
        }
    }

    /// The line.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The present moment.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// Events played so far.
    pub fn events(&self) -> u64 {
        self.events
    }

    /// What has happened, if the log is kept.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Motions, counts, cycles.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The conflicts that were seen.
    pub fn conflicts(&self) -> &[Seen] {
        self.observer.seen()
    }

    /// How often drives both ways of one axis came on at once.
    pub fn alarms(&self) -> u64 {
        self.field.plant().alarms()
    }

    /// The mode of the line, by the coordinator that was last up.
    pub fn mode(&self) -> ControlMode {
        self.mode
    }

    /// The controller of a station; none while its process is down.
    pub fn controller(&self, station: StationId) -> Option<&Controller> {
        let node = &self.stations[station.index()];
        node.is_up().then_some(&node.controller)
    }

    /// The mode a station acts on.
    pub fn mode_of(&self, station: StationId) -> Option<ControlMode> {
        self.controller(station).map(Controller::mode)
    }

    /// The last cycle in which an operation is done.
    pub fn done(&self, station: StationId, op: OpId) -> i32 {
        self.record.count(station, op)
    }

    /// A station is up, heard by the coordinator, and has its devices.
    pub fn hears(&self, station: StationId) -> bool {
        self.coordinator.is_up
            && self.coordinator.coordinator.hears(station)
            && self.controller(station).is_some_and(|controller| controller.report().devices_valid)
    }

    /// Where an axis stands.
    pub fn position(&self, station: StationId, axis: linewright_line::AxisId) -> f64 {
        self.field.position(station, axis)
    }
}

/// Every way of the line with, for those between stations, the arrows it carries.
fn links_of(line: &Line, options: &Options) -> (Vec<Link>, Vec<Vec<usize>>) {
    let (coordinator, operator) = (line.stations.len(), line.stations.len() + 1);
    let (mut links, mut arrows) = (Vec::new(), Vec::new());
    let mut add = |from: usize, to: usize, reads: Vec<OpId>, carried: Vec<usize>| {
        let term = if from == coordinator { line.timing.lease } else { line.timing.stale };
        let mut link = Link::new(from, to, reads, !options.rules.counted, term, options.seed);
        link.wakes_always = options.one_by_one;
        links.push(link);
        arrows.push(carried);
    };
    for from in 0..coordinator {
        for to in (0..coordinator).filter(|&to| to != from) {
            let joins = |a: &linewright_line::Arrow, x: usize, y: usize| a.from.0.index() == x && a.to.0.index() == y;
            let carried: Vec<usize> = (0..line.arrows.len()).filter(|&at| joins(&line.arrows[at], from, to)).collect();
            // A reader of whom the writer has arrows is asked for agreement, and answers.
            if !carried.is_empty() || line.arrows.iter().any(|a| joins(a, to, from)) {
                let mut reads: Vec<OpId> = carried.iter().map(|&at| line.arrows[at].from.1).collect();
                reads.sort_unstable();
                reads.dedup();
                add(from, to, reads, carried);
            }
        }
        add(from, coordinator, Vec::new(), Vec::new());
        add(coordinator, from, Vec::new(), Vec::new());
        add(operator, from, Vec::new(), Vec::new());
    }
    add(operator, coordinator, Vec::new(), Vec::new());
    (links, arrows)
}
