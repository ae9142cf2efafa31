//! One station on its own: the situations it can be in, and the result of each act in them.
//!
//! A situation is a real controller together with its operator's hands and the mode it has received. Two controllers
//! whose [`Controller::situation`] is equal relative to their own cycle go on alike, so each situation is entered once,
//! under a number, and the result of a stimulus is computed once, by the controller itself. The composed line is then
//! played with numbers: what costs a microsecond here costs a look into a table there.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{OpId, StationId, TaskId, Tick};
use linewright_orders::LeaveWay;
use linewright_station_logic::{
    CompileError, Controller, ModeOrder, NO_DELAY, PanelCommand, RequestWriter, Restore, StationHappening,
    StationInput, StationOutbox, StationReport, TaskCommand,
};
use rustc_hash::FxHashMap;

use super::facts::{SituationFacts, actuator, bits_of};
use super::orders::{LIMIT, order, sensors_of};
use super::setting::LineExploration;
use super::view_key::{ReportNumbers, ViewKey, ViewKeys, report};

/// The moment at which everything happens; the time of an order runs out a moment later, and nothing else does.
const NOW: Tick = Tick::from_millis(1);

/// At most this many incoming links: one bit each.
pub(crate) const LINKS_MAX: usize = 64;

/// The panel's buttons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum PanelKey {
    Advance,
    Return,
}

/// Something that may happen to a station by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum StationAct {
    /// It receives a mode.
    Mode(ControlMode),
    Key(Option<PanelKey>),
    /// A hand-mode button of the console, as the station receives it.
    Button(Option<u16>),
    /// A motion arrives: its switch comes on, and is off again in the next image.
    Arrive(OpId, Block),
    /// A motion fails. Where it has no fault input, the devices are lost and come back.
    Fail(OpId, Block),
    /// A step without anything new, where one may matter: a request is open.
    Step,
    /// It is ordered to do a task.
    Order(TaskId),
    /// It is ordered to leave its order, or the last one, and to go back.
    Secure,
    /// The time of its order runs out.
    Expire,
    /// All inputs that its operations wait for come on, or go off.
    Sensors(bool),
    /// Its process ends and starts again, with its memory.
    Restart,
    /// The same without its memory. Nothing gives it back: common counts are founded only where all stations stand at
    /// home, as at the start of the exploration.
    Forget,
}

/// Result of an act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Effect {
    pub to: u32,
    /// By how much the station's cycle changed.
    pub cycles: i32,
    /// The request that was open is not open any more.
    pub closed: bool,
    /// The change is not observable.
    pub quiet: bool,
    /// An image with every switch off is still to come: reports in between matter.
    pub off_follows: bool,
}

const NOTHING: Effect = Effect { to: 0, cycles: 0, closed: false, quiet: false, off_follows: false };
const UNKNOWN: Effect = Effect { to: u32::MAX, ..NOTHING };

impl Effect {
    /// The situation of its station is all that changes.
    pub fn is_local(&self) -> bool {
        self.quiet && !self.closed && self.cycles == 0 && !self.off_follows
    }
}

/// A controller with everything around it.
#[derive(Clone, Debug)]
pub(crate) struct Situation {
    pub controller: Controller,
    pub key: Option<PanelKey>,
    pub button: Option<u16>,
    pub mode: ControlMode,
    pub outputs: u128,
    epoch: u64,
    pub(super) now: Tick,
    /// Inputs of the image that the station waits for and that are on, whatever moves.
    sensors: u128,
    /// The last order it was given.
    order: u64,
    /// Places of its mechanisms when it lost its memory, if it has; its marking does not show them any more.
    pub stood: Option<Box<[StationPlace]>>,
    /// For each incoming link, whether the request held is still open at its writer.
    pub open: u64,
}

/// A report for this station, relative to its cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct RelativeReport {
    situation: u32,
    /// Position among the incoming links.
    link: u32,
    word: ViewKey,
}

/// All situations of one station that have been met.
#[derive(Debug)]
pub(crate) struct Situations {
    pub station: usize,
    /// Incoming and outgoing links, by their numbers in the setting.
    pub incoming: Vec<usize>,
    pub outgoing: Vec<usize>,
    numbers: FxHashMap<Box<[i64]>, u32>,
    pub all: Vec<Situation>,
    pub facts: Vec<SituationFacts>,
    /// For each act of each situation, one situation after the other.
    effects: Vec<Effect>,
    /// Index of the first one of a situation.
    first_effect: Vec<u32>,
    /// By situation: the image in which every switch is off again.
    off: Vec<Effect>,
    heard: FxHashMap<RelativeReport, Effect>,
    closings: FxHashMap<(u32, u32), u32>,
    /// Transitions of its net that have fired, a flag each.
    pub fired: Vec<bool>,
    words_scratch: Vec<i64>,
}

impl Situations {
    pub fn new(setting: &LineExploration, station: usize, transitions: usize) -> Self {
        Situations {
            station,
            incoming: setting.into(station).collect(),
            outgoing: setting.out_of(station).collect(),
            numbers: FxHashMap::default(),
            all: Vec::new(),
            facts: Vec::new(),
            effects: Vec::new(),
            first_effect: Vec::new(),
            off: Vec::new(),
            heard: FxHashMap::default(),
            closings: FxHashMap::default(),
            fired: vec![false; transitions],
            words_scratch: Vec::new(),
        }
    }

    /// The number of a situation, a new one if it has not been met.
    pub fn enter(&mut self, setting: &LineExploration, words: &mut [ViewKeys], situation: Situation) -> u32 {
        situation.write(setting, &self.incoming, &mut self.words_scratch);
        if let Some(&number) = self.numbers.get(self.words_scratch.as_slice()) {
            return number;
        }
        let number = self.all.len() as u32;
        let facts = SituationFacts::of(setting, words, self, &situation);
        self.numbers.insert(self.words_scratch.as_slice().into(), number);
        self.first_effect.push(self.effects.len() as u32);
        self.effects.resize(self.effects.len() + facts.acts.len(), UNKNOWN);
        self.facts.push(facts);
        self.off.push(UNKNOWN);
        self.all.push(situation);
        number
    }

    /// Result of the `nth` act of a situation.
    #[inline]
    pub fn effect(&mut self, setting: &LineExploration, words: &mut [ViewKeys], from: u32, nth: usize) -> Effect {
        let effect = self.effects[self.first_effect[from as usize] as usize + nth];
        if effect.to == u32::MAX { self.work_out(setting, words, from, nth) } else { effect }
    }

    #[cold]
    fn work_out(&mut self, setting: &LineExploration, words: &mut [ViewKeys], from: u32, nth: usize) -> Effect {
        let act = self.facts[from as usize].acts[nth];
        let mut next = self.all[from as usize].clone();
        next.act(setting, act, &mut Vec::new());
        let mut effect = self.conclude(setting, words, from, next);
        if matches!(act, StationAct::Arrive(..) | StationAct::Fail(..)) {
            let off = self.off(setting, words, effect.to);
            effect = self.both(words, from, effect, off);
        }
        let at = self.first_effect[from as usize] as usize + nth;
        self.effects[at] = effect;
        effect
    }

    /// Two images as one effect, unless a report could be received between them.
    fn both(&self, words: &[ViewKeys], from: u32, on: Effect, off: Effect) -> Effect {
        if !off.quiet || off.closed {
            return Effect { off_follows: true, quiet: false, ..on };
        }
        let cycles = on.cycles + off.cycles;
        let quiet = self.says_the_same(words, from, off.to, cycles);
        Effect { to: off.to, cycles, closed: on.closed, quiet, ..NOTHING }
    }

    fn says_the_same(&self, words: &[ViewKeys], from: u32, to: u32, cycles: i32) -> bool {
        let pairs = self.facts[from as usize].says.iter().zip(&self.facts[to as usize].says);
        pairs.zip(&self.outgoing).all(|((&before, &after), &link)| before == after.shifted(cycles, &words[link]))
    }

    /// The image in which all switches are off, and the devices vouch for it.
    pub fn off(&mut self, setting: &LineExploration, words: &mut [ViewKeys], from: u32) -> Effect {
        let known = self.off[from as usize];
        if known.to != u32::MAX {
            return known;
        }
        let mut next = self.all[from as usize].clone();
        next.image(0, true, &mut Vec::new());
        let effect = self.conclude(setting, words, from, next);
        self.off[from as usize] = effect;
        effect
    }

    /// A word arrives over the `nth` incoming link; its base is relative to the station's cycle.
    pub fn hear(
        &mut self,
        setting: &LineExploration,
        words: &mut [ViewKeys],
        from: u32,
        nth: usize,
        word: ViewKey,
    ) -> Effect {
        let hearing = RelativeReport { situation: from, link: nth as u32, word };
        if let Some(&effect) = self.heard.get(&hearing) {
            return effect;
        }
        let mut next = self.all[from as usize].clone();
        next.hear(setting, words, self.incoming[nth], nth, word, &mut Vec::new());
        let effect = self.conclude(setting, words, from, next);
        self.heard.insert(hearing, effect);
        effect
    }

    /// Whether the station holds a request over the `nth` incoming link that it takes as open.
    pub fn minds_closing(&self, setting: &LineExploration, from: u32, nth: usize) -> bool {
        setting.rules.fresh_numbers && self.all[from as usize].open & (1 << nth) != 0
    }

    /// The writer of the `nth` incoming link has closed its request, which changes nothing but what answers are worth.
    pub fn close(&mut self, setting: &LineExploration, words: &mut [ViewKeys], from: u32, nth: usize) -> u32 {
        if !self.minds_closing(setting, from, nth) {
            return from;
        }
        if let Some(&to) = self.closings.get(&(from, nth as u32)) {
            return to;
        }
        let mut next = self.all[from as usize].clone();
        next.open &= !(1 << nth);
        let to = self.enter(setting, words, next);
        self.closings.insert((from, nth as u32), to);
        to
    }

    fn conclude(&mut self, setting: &LineExploration, words: &mut [ViewKeys], from: u32, next: Situation) -> Effect {
        let before = &self.all[from as usize].controller;
        let open = |controller: &Controller| controller.request().map(|request| request.number);
        let closed = setting.rules.fresh_numbers && open(before).is_some() && open(before) != open(&next.controller);
        // Cycles of a task-driven station are not compared: they count orders and grow for ever.
        let task_driven = setting.line.stations[self.station].is_task_driven();
        // Nor are those of a station without its memory compared.
        let compared = !task_driven && next.stood.is_none();
        let cycles = if compared { next.controller.cycle() - before.cycle() } else { 0 };
        for &transition in next.controller.fired() {
            self.fired[usize::from(transition)] = true;
        }
        let to = self.enter(setting, words, next);
        Effect { to, cycles, closed, quiet: self.says_the_same(words, from, to, cycles), ..NOTHING }
    }

    /// Bytes, about: situations dominate.
    pub fn bytes(&self) -> usize {
        let situation = size_of::<Situation>() + 1024;
        self.all.len() * situation + self.heard.len() * 2 * size_of::<(RelativeReport, Effect)>()
    }
}

impl Situation {
    /// A station at home that has received nothing yet.
    pub fn at_home(setting: &LineExploration, station: StationId) -> Result<Self, CompileError> {
        let line = &setting.line;
        let controller = Controller::new(line, station, 1, Restore::Fresh)?.with_rules(setting.rules);
        let mode = ControlMode::StandBy;
        let mut situation = Situation {
            controller,
            key: None,
            button: None,
            mode,
            outputs: 0,
            epoch: 0,
            now: NOW,
            sensors: 0,
            order: 0,
            stood: None,
            open: 0,
        };
        let home = line.station(station).home;
        let at_home = 1u128 << line.operation((station, home)).normal.complete.0;
        situation.image(at_home, true, &mut Vec::new());
        situation.image(0, true, &mut Vec::new());
        situation.order(setting, &mut Vec::new());
        Ok(situation)
    }

    pub(super) fn step(&mut self, events: &mut Vec<StationHappening>) {
        let mut out = StationOutbox::default();
        self.controller.step(self.now, &mut out);
        self.outputs = out.outputs;
        events.append(&mut out.events);
    }

    pub fn image(&mut self, bits: u128, valid: bool, events: &mut Vec<StationHappening>) {
        let bits = bits | self.sensors;
        self.controller.handle(self.now, StationInput::Inputs { bits, valid, until: Tick::NEVER, under: NO_DELAY });
        self.step(events);
    }

    pub(super) fn order(&mut self, setting: &LineExploration, events: &mut Vec<StationHappening>) {
        self.epoch += 1;
        // Counts of the start are of one generation; it is founded for the first life of each station.
        let found = (setting.forgets && self.controller.writer().boot_id == 1).then_some(1);
        let order = ModeOrder {
            found,
            manual_all: true,
            buttons: self.button.map_or(0, |button| 1 << button),
            ..ModeOrder::of(1, self.epoch, self.mode, setting.line.timing.lease)
        };
        self.controller.handle(self.now, StationInput::Order(order));
        self.step(events);
    }

    /// Lets something happen. Of an arrival or a failure, the first image only.
    pub fn act(&mut self, setting: &LineExploration, act: StationAct, events: &mut Vec<StationHappening>) {
        let station = self.controller.station();
        match act {
            StationAct::Mode(mode) => {
                self.mode = mode;
                self.order(setting, events);
            }
            StationAct::Button(button) => {
                self.button = button;
                self.order(setting, events);
            }
            StationAct::Key(key) => {
                self.key = key;
                let advance = PanelCommand::Advance(key == Some(PanelKey::Advance));
                let retract = PanelCommand::Retract(key == Some(PanelKey::Return));
                for command in [advance, retract] {
                    self.controller.handle(self.now, StationInput::Panel(command));
                }
                self.step(events);
            }
            StationAct::Arrive(op, block) => self.image(bits_of(&setting.line, station, op, block).0, true, events),
            StationAct::Fail(op, block) => match bits_of(&setting.line, station, op, block).1 {
                Some(fault) => self.image(fault, true, events),
                None => self.image(0, false, events),
            },
            StationAct::Step => self.step(events),
            StationAct::Order(task) => {
                self.order += 1;
                let order = order(&setting.line, station, task, self.order);
                self.controller.handle(self.now, StationInput::Task(TaskCommand::Run(&order)));
                self.step(events);
            }
            StationAct::Secure => {
                let key = super::orders::key(self.order);
                self.controller.handle(self.now, StationInput::Task(TaskCommand::Leave(key, LeaveWay::Back)));
                self.step(events);
            }
            StationAct::Expire => {
                self.now = self.now + LIMIT;
                self.step(events);
            }
            StationAct::Restart => self.restart(setting, events),
            StationAct::Forget => self.forget(setting, events),
            StationAct::Sensors(on) => {
                self.sensors = if on { sensors_of(&setting.line, station) } else { 0 };
                self.image(0, true, events);
            }
        }
    }

    /// A word arrives. A request that is not the one held gets the next number, so that it is a new one.
    pub fn hear(
        &mut self,
        setting: &LineExploration,
        words: &[ViewKeys],
        link: usize,
        nth: usize,
        word: ViewKey,
        events: &mut Vec<StationHappening>,
    ) {
        let content = words[link].content(word.id).clone();
        let described = &setting.links[link];
        let writer = StationId::at(described.writer);
        let held = self.controller.held(writer).and_then(|held| held.request);
        let was_open = self.open & (1 << nth) != 0;
        let number = match (content.request, held) {
            _ if !setting.rules.fresh_numbers => 1,
            (Some((_, true)), Some(held)) if was_open => held.number,
            (_, held) => held.map_or(1, |held| held.number + 1),
        };
        let numbers = ReportNumbers { request: number, answered: self.awaited(setting) };
        let base = self.controller.cycle() + word.base;
        let ops = setting.line.station(writer).operations.len();
        let me = (self.controller.station(), self.controller.writer().boot_id);
        let report: StationReport = report(&content, base, &described.counts, ops, me, &numbers);
        self.controller.handle(self.now, StationInput::View(writer, &report));
        self.open &= !(1 << nth);
        if content.request.is_some_and(|(_, open)| open) {
            self.open |= 1 << nth;
        }
        self.step(events);
    }

    fn awaited(&self, setting: &LineExploration) -> Option<u64> {
        if setting.rules.fresh_numbers { self.controller.request().map(|request| request.number) } else { Some(1) }
    }

    /// View key for the reader of a link; bases are relative to its own cycle.
    pub fn says(&self, setting: &LineExploration, link: usize, words: &mut ViewKeys) -> ViewKey {
        if self.is_lost() {
            return ViewKey::LOST;
        }
        let (described, cycle) = (&setting.links[link], self.controller.cycle());
        let reader = StationId::at(described.reader);
        let position = setting.into(described.writer).position(|incoming| incoming == described.reverse);
        let answers = !setting.rules.fresh_numbers || position.is_some_and(|nth| self.open & (1 << nth) != 0);
        let held = self.controller.held(reader);
        let answer = held.filter(|_| answers).and_then(|held| held.answer).map(|answer| answer.in_the_way);
        let counts = described.counts.iter().map(|&op| self.controller.done(op) - cycle);
        words.word(counts, 0, self.controller.request().map(|request| (request.ops, true)), answer)
    }

    /// Whether it has lost its memory.
    pub fn is_lost(&self) -> bool {
        self.stood.is_some()
    }

    /// View key that it holds over its `nth` incoming link; bases are relative to its own cycle.
    pub fn holds(&self, setting: &LineExploration, link: usize, nth: usize, words: &mut ViewKeys) -> ViewKey {
        let (described, cycle) = (&setting.links[link], self.controller.cycle());
        let Some(held) = self.controller.held(StationId::at(described.writer)).filter(|_| !self.is_lost()) else {
            return ViewKey::NONE;
        };
        if setting.forgets && held.generation == 0 {
            return ViewKey::LOST;
        }
        let open = !setting.rules.fresh_numbers || self.open & (1 << nth) != 0;
        let awaited = self.awaited(setting);
        let verdict = held.verdict.filter(|&(number, _)| Some(number) == awaited).map(|(_, in_the_way)| in_the_way);
        let counts = described.counts.iter().map(|&op| held.done[op.index()].wrapping_sub(cycle));
        words.word(counts, held.cycle - cycle, held.request.map(|request| (request.ops, open)), verdict)
    }

    /// Everything that decides what it will do, relative to its own cycle.
    fn write(&self, setting: &LineExploration, incoming: &[usize], out: &mut Vec<i64>) {
        out.clear();
        let key = match self.key {
            None => 0,
            Some(PanelKey::Advance) => 1,
            Some(PanelKey::Return) => 2,
        };
        out.extend([key, self.button.map_or(-1, i64::from), self.mode as i64, self.open as i64]);
        out.push(i64::from(self.sensors != 0));
        if let Some(stood) = &self.stood {
            out.push(-1);
            out.extend(stood.iter().map(|place| i64::from(place.op.0) << 8 | i64::from(place.number())));
        }
        let writers = |station: StationId| {
            let nth = incoming.iter().position(|&link| setting.links[link].writer == station.index());
            let open = !setting.rules.fresh_numbers || nth.is_some_and(|nth| self.open & (1 << nth) != 0);
            let held = self.controller.held(station).and_then(|held| held.request);
            RequestWriter { boot_id: 1, open: held.filter(|_| open).map(|request| request.number) }
        };
        self.controller.situation(self.controller.cycle(), writers, out);
    }

    /// Whether the inputs that it waits for are on.
    pub fn has_sensors(&self) -> bool {
        self.sensors != 0
    }

    /// Whether a motion of this place is driven; one that is not stays where it is.
    pub fn drives(&self, setting: &LineExploration, op: OpId, block: Block) -> bool {
        self.outputs & actuator(&setting.line, self.controller.station(), op, block) != 0
    }
}
