//! The event loop: one clock, a tournament of deadlines, no queue of future events beyond messages on their way.
//!
//! Between two events nothing happens, so time costs nothing. What may happen next is one of a fixed set: a message
//! with news arrives, a mechanism presses a switch, a controller's deadline passes, a node repeats its state. Of two at
//! the same moment the order is always the same, so a seed gives the same run to the microsecond.

use std::collections::VecDeque;

use linewright_coordinator_logic::{ModeCommand, RefusedCommand};
use linewright_coordinator_shell::{CoordinatorEffect, CoordinatorRecord};
use linewright_line::net::ControlMode;
use linewright_line::{Line, Owner, Tick};
use linewright_plant::PlantOptions;
use linewright_station_logic::Restore;
use linewright_station_shell::StationEffect;

use crate::error::StartError;
use crate::field::SimulatedField;
use crate::held_buttons::HeldButtons;
use crate::link::{Link, LinkPayload};
use crate::log::{LogKind, RunLog};
use crate::network::links_of;
use crate::node::{CoordinatorNode, StationNode};
use crate::observer::ConflictObserver;
use crate::options::SimOptions;
use crate::record::RunRecord;
use crate::timers::Timers;

/// An answer to a command: obeyed, or refused.
#[derive(Clone, Debug)]
pub(crate) struct CommandAnswer {
    pub(crate) command: ModeCommand,
    pub(crate) refusal: Option<RefusedCommand>,
}

/// A line in virtual time.
pub struct LineSim {
    pub(crate) line: Line,
    pub(crate) options: SimOptions,
    pub(crate) now: Tick,
    pub(crate) stations: Vec<StationNode>,
    pub(crate) coordinator: CoordinatorNode,
    pub(crate) hands: HeldButtons,
    /// The operator's screen hangs.
    pub(crate) hangs: bool,
    pub(crate) field: SimulatedField,
    pub(crate) observer: ConflictObserver,
    pub(crate) links: Vec<Link>,
    /// By node: links to it and from it.
    pub(crate) into: Vec<Vec<usize>>,
    pub(crate) out_of: Vec<Vec<usize>>,
    /// By link between stations: the arrows from its writer into its reader.
    pub(crate) arrows: Vec<Vec<usize>>,
    pub(crate) timers: Timers,
    /// Next repetition of each node's state, with its life; sorted, because all have the same period.
    pub(crate) repeats: VecDeque<(Tick, usize, u64)>,
    /// By node: number of its life.
    pub(crate) lives: Vec<u64>,
    pub(crate) life: u64,
    pub(crate) log: RunLog,
    pub(crate) record: RunRecord,
    pub(crate) answers: Vec<CommandAnswer>,
    pub(crate) mode: ControlMode,
    /// Time at which the line entered it, and the coordinator's text of that time.
    pub(crate) entered: (Tick, String),
    /// Time of the last event of a station, change of mode, or action of an operator.
    pub(crate) last_event: Tick,
    pub(crate) renewals: Vec<(Tick, usize)>,
    pub(crate) events: u64,
}

impl LineSim {
    /// A line switched on at time zero.
    ///
    /// # Errors
    /// When a station does not compile, or a bus cannot be managed.
    pub fn new(line: &Line, mut options: SimOptions) -> Result<Self, StartError> {
        options.one_by_one |= options.frames;
        let count = line.stations.len();
        let plant = PlantOptions { seed: options.seed, variation: options.variation, people: false };
        let field = SimulatedField::new(line, plant, options.frames)?;
        let (links, arrows) = links_of(line, &options);
        let of = |end: &dyn Fn(&Link) -> usize| -> Vec<Vec<usize>> {
            let of_node = |node: usize| (0..links.len()).filter(|&at| end(&links[at]) == node).collect();
            (0..count + 2).map(of_node).collect()
        };
        let mut sim = LineSim {
            observer: ConflictObserver::new(line, |id| field.plant_of(id)),
            into: of(&|link| link.to),
            out_of: of(&|link| link.from),
            timers: Timers::new(links.len() + 2 * (count + 1)),
            links,
            arrows,
            field,
            stations: Vec::with_capacity(count),
            coordinator: CoordinatorNode::start(line, 1, CoordinatorRecord::default(), &options),
            hands: HeldButtons::default(),
            hangs: false,
            repeats: VecDeque::new(),
            lives: vec![1; count + 2],
            life: 1,
            log: RunLog::default(),
            record: RunRecord::new(line),
            answers: Vec::new(),
            mode: ControlMode::Home,
            entered: (Tick::ZERO, String::new()),
            last_event: Tick::ZERO,
            renewals: Vec::new(),
            events: 0,
            line: line.clone(),
            options,
            now: Tick::ZERO,
        };
        for id in line.station_ids() {
            let life = sim.next_life();
            sim.stations.push(StationNode::start(line, id, life, Restore::Fresh, &options)?);
            sim.begin(id.index(), life);
        }
        let life = sim.next_life();
        sim.coordinator = CoordinatorNode::start(line, life, CoordinatorRecord::default(), &options);
        sim.begin(sim.coordinator_node(), life);
        sim.repeats.push_back((Tick::ZERO, sim.operator_node(), 1));
        Ok(sim)
    }

    pub(crate) fn coordinator_node(&self) -> usize {
        self.line.stations.len()
    }

    pub(crate) fn operator_node(&self) -> usize {
        self.line.stations.len() + 1
    }

    pub(crate) fn is_up(&self, node: usize) -> bool {
        match self.stations.get(node) {
            Some(station) => station.is_up(),
            None => node != self.coordinator_node() || self.coordinator.is_up,
        }
    }

    /// Whether messages go out to a node. Without numbers none go to one that is down: it would take them for new.
    pub(crate) fn is_reached(&self, node: usize) -> bool {
        self.options.frames || self.is_up(node)
    }

    pub(crate) fn field_slot(&self, at: usize) -> usize {
        self.links.len() + at
    }

    pub(crate) fn node_slot(&self, node: usize) -> usize {
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

    pub(crate) fn wake_node(&mut self, node: usize, at: Tick) {
        self.timers.set(self.node_slot(node), at);
    }

    /// Time of the next event.
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

    fn arrival(&mut self, at: usize) {
        let node = self.links[at].to;
        if !self.is_reached(node) {
            self.links[at].forget_heard();
            self.timers.set(at, Tick::NEVER);
            return;
        }
        self.catch_up(node);
        let said = self.links[at].take_news(self.now);
        self.timers.set(at, self.links[at].wakes());
        if !self.is_up(node) {
            return;
        }
        let from = self.links[at].from;
        match self.stations.get_mut(node) {
            Some(station) => {
                if let Some(said) = &said {
                    station.hear(self.now, from, said);
                    if let Some(report) = said.report() {
                        self.record.hear(&self.line, self.now, &self.arrows[at], report);
                    }
                }
                self.play_station(node);
            }
            None => {
                if let Some(said) = &said {
                    self.coordinator.hear(self.now, from, said);
                }
                let command = if let Some(LinkPayload::Command(command)) = said { Some(command) } else { None };
                self.play_coordinator(command);
            }
        }
    }

    fn field_changes(&mut self, at: usize) {
        let is_console = at == self.coordinator_node();
        let SimulatedField::Images(field) = &mut self.field else { return self.bus_changes(at) };
        field.poll(self.now, at);
        if is_console {
            if field.has_console() && self.coordinator.is_up {
                let image = field.image(at);
                self.catch_up(at);
                if self.coordinator.see(self.now, image) {
                    self.play_coordinator(None);
                }
            }
        } else {
            let image = field.image(at);
            self.observer.look(&self.line, |id| self.field.plant_of(id), at);
            if self.stations[at].is_up() {
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
        self.play(node);
    }

    pub(crate) fn play(&mut self, node: usize) {
        if node < self.stations.len() {
            self.play_station(node);
        } else {
            self.play_coordinator(None);
        }
    }

    fn play_station(&mut self, at: usize) {
        let now = self.now;
        self.look_at_own_bus(at);
        let node = &mut self.stations[at];
        let (id, before) = (node.id, node.outputs);
        let mut effects = node.step(now);
        let mut says = false;
        for effect in effects.drain(..) {
            match effect {
                // Also when the station is dying: it is written down.
                StationEffect::Happened(event) => {
                    self.last_event = now;
                    self.record.enter(&self.line, now, id, &event);
                    if self.options.keeps_log {
                        self.log.push(now, LogKind::Station(id, event));
                    }
                }
                StationEffect::Remember => self.stations[at].remember(),
                _ if self.stations[at].is_dying => {}
                StationEffect::Drive(image) if self.options.frames => self.send_outputs(at, image),
                StationEffect::Drive(image) => self.stations[at].drive(image.bits),
                StationEffect::Tell { sequence } if self.options.frames => self.tell_station(at, sequence),
                StationEffect::Tell { .. } => says = true,
                StationEffect::Reply(..) | StationEffect::Ignored { .. } => {}
            }
        }
        let node = &mut self.stations[at];
        node.effects = effects;
        let outputs = node.outputs;
        if outputs != before {
            if let SimulatedField::Images(field) = &mut self.field {
                field.ask(now, at, outputs);
            }
            self.observer.look(&self.line, |id| self.field.plant_of(id), at);
            self.timers.set(self.field_slot(at), self.field.deadline(at));
        }
        self.send_frames(at);
        if self.stations[at].is_dying {
            return self.kill_station(at);
        }
        if says {
            self.stations[at].is_to_say();
            self.attend(at);
            self.say_station(at);
        }
        let deadline = self.stations[at].next_deadline();
        self.wake_node(at, deadline.max(now));
    }

    fn play_coordinator(&mut self, asked: Option<ModeCommand>) {
        let now = self.now;
        self.look_at_line_bus();
        let (mut refusal, mut says) = (None, false);
        // Once more after a record that could not be written: the emergency stop.
        for _ in 0..2 {
            let mut effects = std::mem::take(&mut self.coordinator.effects);
            self.coordinator.shell.act(now, &mut effects);
            let mut goes_on = true;
            for effect in effects.drain(..) {
                match effect {
                    CoordinatorEffect::Entered(mode) => self.enter(mode),
                    CoordinatorEffect::Refused(refused) => {
                        if self.options.keeps_log {
                            self.log.push(now, LogKind::Refusal(refused.text(&self.line)));
                        }
                        refusal = Some(refused);
                    }
                    CoordinatorEffect::Remember(record) => goes_on = self.coordinator.remember(now, record),
                    CoordinatorEffect::Order { sequence } if self.options.frames => self.send_orders(sequence),
                    CoordinatorEffect::Order { .. } => says = true,
                    CoordinatorEffect::Lamps(bits) => self.put(Owner::Console, bits),
                    CoordinatorEffect::Energise(station, bits) => self.put(Owner::Station(station), bits),
                    CoordinatorEffect::Inputs { station, sequence, image } => {
                        self.send_inputs(station, sequence, image);
                    }
                    CoordinatorEffect::Obeyed | CoordinatorEffect::Tell { .. } | CoordinatorEffect::Completed(_) => {}
                }
                if !goes_on {
                    break;
                }
            }
            self.coordinator.effects = effects;
            if goes_on {
                break;
            }
        }
        if let Some(command) = asked {
            self.answers.push(CommandAnswer { command, refusal });
        }
        if says {
            self.say_order();
        }
        self.send_frames(self.coordinator_node());
        let deadline = self.coordinator.shell.next_deadline(now);
        self.wake_node(self.coordinator_node(), deadline.max(now));
    }

    fn enter(&mut self, mode: ControlMode) {
        self.mode = mode;
        self.entered = (self.now, self.coordinator.shell.coordinator().text());
        self.last_event = self.now;
        if self.options.keeps_log {
            self.log.push(self.now, LogKind::Mode(mode));
        }
    }

    pub(crate) fn note(&mut self, what: String) {
        if self.options.keeps_log {
            self.log.push(self.now, LogKind::Act(what));
        }
    }
}
