//! The state of a line under exploration: controllers, operators' hands, and reports on their way.

use std::rc::Rc;

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{
    AgreementAnswer, Controller, ModeOrder, PanelCommand, Restore, Rules, StationInput, StationOutbox, StationReport,
};

/// The one moment at which everything happens.
const NOW: Tick = Tick::from_millis(1);

/// Subject and freedom of an exploration.
#[derive(Clone, Debug)]
pub struct Setting {
    pub line: Line,
    /// Modes a station may receive, in any order.
    pub modes: Vec<ControlMode>,
    /// Reports on their way to one reader; one more pushes the oldest out, for every one may be lost.
    pub reports_max: usize,
    pub restarts: bool,
    /// Operators let go of their panels before the mode changes. Fewer states; what a held button may do is tested
    /// elsewhere.
    pub tidy_hands: bool,
    links: Vec<Link>,
}

/// Reader and writer, and the writer's counts that matter to the reader.
#[derive(Clone, Debug)]
struct Link {
    writer: usize,
    reader: usize,
    counts: Vec<usize>,
}

/// The panel's buttons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    Advance,
    Return,
}

/// One station with its operator.
#[derive(Clone)]
pub struct Node {
    pub controller: Controller,
    pub key: Option<Key>,
    pub button: Option<u16>,
    pub mode: ControlMode,
    epoch: u64,
    pub outputs: u128,
}

#[derive(Clone)]
pub struct World {
    pub nodes: Vec<Rc<Node>>,
    /// For each link, what the reader holds and what is on its way, oldest first.
    mail: Vec<(Rc<StationReport>, Vec<Rc<StationReport>>)>,
}

impl Setting {
    pub fn new(line: Line) -> Self {
        let mut links = Vec::new();
        for writer in line.station_ids() {
            for reader in line.station_ids() {
                let between = |a: StationId, b: StationId| line.arrows.iter().any(|x| x.from.0 == a && x.to.0 == b);
                if between(writer, reader) || between(reader, writer) {
                    let read = line.arrows.iter().filter(|a| a.from.0 == writer && a.to.0 == reader);
                    let counts = read.map(|a| a.from.1.index()).collect();
                    links.push(Link { writer: writer.index(), reader: reader.index(), counts });
                }
            }
        }
        Setting {
            line,
            modes: vec![ControlMode::Auto, ControlMode::Manual],
            reports_max: 1,
            restarts: false,
            tidy_hands: true,
            links,
        }
    }

    pub fn links(&self) -> usize {
        self.links.len()
    }

    pub fn ends_of(&self, link: usize) -> (usize, usize) {
        (self.links[link].writer, self.links[link].reader)
    }

    /// All stations at home in stand-by, with each other's reports received.
    pub fn start(&self) -> World {
        let nodes: Vec<Rc<Node>> = self.line.station_ids().map(|station| Rc::new(self.node(station))).collect();
        let mail =
            self.links.iter().map(|link| (Rc::new(nodes[link.writer].controller.report()), Vec::new())).collect();
        let mut world = World { nodes, mail };
        for link in 0..self.links.len() {
            let report = Rc::clone(&world.mail[link].0);
            let (writer, reader) = self.ends_of(link);
            world.tell(reader, |c| {
                c.handle(NOW, StationInput::View(StationId::at(writer), &report));
            });
        }
        world
    }

    fn node(&self, station: StationId) -> Node {
        let controller = Controller::new(&self.line, station, 1, Restore::Fresh)
            .expect("explored lines compile")
            .with_rules(Rules::COUNTS);
        let mut node = Node { controller, key: None, button: None, mode: ControlMode::StandBy, epoch: 0, outputs: 0 };
        let home = self.line.station(station).home;
        let at_home = 1u128 << self.line.operation((station, home)).normal.complete.0;
        for bits in [at_home, 0] {
            node.act(|c| image(c, bits, true));
        }
        node.hear_order(&self.line);
        node
    }
}

fn image(controller: &mut Controller, bits: u128, valid: bool) {
    controller.handle(
        NOW,
        StationInput::Inputs { bits, valid, until: Tick::NEVER, under: linewright_station_logic::NO_DELAY },
    );
}

impl Node {
    fn act(&mut self, what: impl FnOnce(&mut Controller)) {
        let mut out = StationOutbox::default();
        what(&mut self.controller);
        self.controller.step(NOW, &mut out);
        self.outputs = out.outputs;
    }

    fn hear_order(&mut self, line: &Line) {
        self.epoch += 1;
        let order = ModeOrder {
            manual_all: true,
            buttons: self.button.map_or(0, |b| 1 << b),
            // For the lives of the start.
            found: (self.controller.writer().boot_id == 1).then_some(1),
            ..ModeOrder::of(1, self.epoch, self.mode, line.timing.lease)
        };
        self.act(|c| {
            c.handle(NOW, StationInput::Order(order));
        });
    }
}

impl World {
    /// Lets something happen to one station, and one step follow. The caller posts the report.
    fn tell(&mut self, station: usize, what: impl FnOnce(&mut Controller)) {
        Rc::make_mut(&mut self.nodes[station]).act(what);
    }

    /// The station's new report goes on its way to every reader for which it is new.
    fn post(&mut self, setting: &Setting, writer: usize) {
        let mut report = None;
        for (link, (held, waiting)) in setting.links.iter().zip(&mut self.mail) {
            if link.writer != writer {
                continue;
            }
            let report = report.get_or_insert_with(|| Rc::new(self.nodes[writer].controller.report()));
            let newest = waiting.last().unwrap_or(held);
            let reader = &self.nodes[link.reader].controller;
            if !link.says_the_same(newest, report, reader) {
                waiting.push(Rc::clone(report));
                if waiting.len() > setting.reports_max {
                    waiting.remove(0);
                }
            }
        }
    }

    pub fn waiting(&self, link: usize) -> usize {
        self.mail[link].1.len()
    }

    pub fn set_mode(&mut self, setting: &Setting, station: usize, mode: ControlMode) {
        let node = Rc::make_mut(&mut self.nodes[station]);
        node.mode = mode;
        node.hear_order(&setting.line);
        self.post(setting, station);
    }

    pub fn set_key(&mut self, setting: &Setting, station: usize, key: Option<Key>) {
        let node = Rc::make_mut(&mut self.nodes[station]);
        node.key = key;
        for command in
            [PanelCommand::Advance(key == Some(Key::Advance)), PanelCommand::Retract(key == Some(Key::Return))]
        {
            node.controller.handle(NOW, StationInput::Panel(command));
        }
        node.act(|_| {});
        self.post(setting, station);
    }

    pub fn set_button(&mut self, setting: &Setting, station: usize, button: Option<u16>) {
        let node = Rc::make_mut(&mut self.nodes[station]);
        node.button = button;
        node.hear_order(&setting.line);
        self.post(setting, station);
    }

    /// A step without anything new.
    pub fn step(&mut self, setting: &Setting, station: usize) {
        self.tell(station, |_| {});
        self.post(setting, station);
    }

    /// An input comes on and, in the next image, goes off. Without a bit the devices are lost and come back.
    pub fn pulse(&mut self, setting: &Setting, station: usize, bit: Option<u128>) {
        let first = (bit.unwrap_or(0), bit.is_some());
        for (bits, valid) in [first, (0, true)] {
            self.tell(station, |c| image(c, bits, valid));
            self.post(setting, station);
        }
    }

    /// A reader takes the `nth` report on its way to it; the ones before are lost.
    pub fn deliver(&mut self, setting: &Setting, link: usize, nth: usize) {
        let (held, waiting) = &mut self.mail[link];
        let taken: Vec<_> = waiting.drain(..=nth).collect();
        *held = Rc::clone(&taken[nth]);
        let report = Rc::clone(held);
        let (writer, reader) = setting.ends_of(link);
        self.tell(reader, |c| {
            c.handle(NOW, StationInput::View(StationId::at(writer), &report));
        });
        self.post(setting, reader);
    }

    /// A station ends and comes up from its snapshot. Its middleware gives it the newest report of each writer that it
    /// had before, then later ones; its commands start anew.
    pub fn restart(&mut self, setting: &Setting, station: usize) {
        let id = StationId::at(station);
        let node = Rc::make_mut(&mut self.nodes[station]);
        let (snapshot, boot) = (node.controller.snapshot(), node.controller.writer().boot_id + 1);
        node.controller = Controller::new(&setting.line, id, boot, Restore::From(snapshot))
            .expect("its own snapshot fits")
            .with_rules(Rules::COUNTS);
        (node.key, node.button) = (None, None);
        node.act(|c| image(c, 0, true));
        node.hear_order(&setting.line);
        for (link, (held, _)) in setting.links.iter().zip(&self.mail).filter(|(link, _)| link.reader == station) {
            let (writer, report) = (StationId::at(link.writer), Rc::clone(held));
            Rc::make_mut(&mut self.nodes[station]).act(|c| {
                c.handle(NOW, StationInput::View(writer, &report));
            });
        }
        self.post(setting, station);
    }

    /// The same number for indistinguishable states: counts are relative to the first station's cycle.
    pub fn key(&self, setting: &Setting, scratch: &mut Vec<i64>) -> u128 {
        scratch.clear();
        let origin = self.nodes[0].controller.cycle();
        for node in &self.nodes {
            let writer = |station: StationId| self.nodes[station.index()].controller.writer();
            node.controller.situation(origin, writer, scratch);
            scratch.push(i64::MIN);
        }
        for (link, (_, waiting)) in setting.links.iter().zip(&self.mail) {
            for report in waiting {
                self.write_report(link, report, origin, scratch);
            }
            scratch.push(i64::MIN);
        }
        hash(scratch)
    }

    fn write_report(&self, link: &Link, report: &StationReport, origin: i32, out: &mut Vec<i64>) {
        let writer = self.nodes[link.writer].controller.writer();
        let reader = &self.nodes[link.reader].controller;
        out.push(i64::from(writer.boot_id == report.boot_id));
        out.extend(link.counts.iter().map(|&op| i64::from(report.done[op] - origin)));
        match report.request {
            None => out.push(-1),
            Some(request) => out.extend([i64::from(writer.open == Some(request.number)), request.ops as i64]),
        }
        let to_reader = |a: &&AgreementAnswer| {
            a.to == reader.station() && a.boot_id == reader.writer().boot_id && reader.awaits(a.number)
        };
        match report.answers.iter().find(to_reader) {
            None => out.push(-1),
            Some(answer) => out.push(answer.in_the_way.map_or(0, |op| 1 + i64::from(op.0))),
        }
    }

    pub fn cycles(&self) -> impl Iterator<Item = i32> + '_ {
        self.nodes.iter().map(|n| n.controller.cycle())
    }

    pub fn all_at_home(&self) -> bool {
        self.nodes.iter().all(|n| n.controller.is_at_home())
    }
}

impl Link {
    fn says_the_same(&self, a: &StationReport, b: &StationReport, reader: &Controller) -> bool {
        // An answer that is not awaited any more may go without a change.
        let awaited = |x: &&AgreementAnswer| x.to.index() == self.reader && reader.awaits(x.number);
        let to_reader = |report: &StationReport| report.answers.iter().find(awaited).copied();
        a.boot_id == b.boot_id
            && a.generation == b.generation
            && a.request == b.request
            && to_reader(a) == to_reader(b)
            && self.counts.iter().all(|&op| a.done[op] == b.done[op])
    }
}

/// 128 bits, so that among millions of states no two share a number by accident.
fn hash(words: &[i64]) -> u128 {
    const MULTIPLIER: u128 = 0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645;
    words.iter().fold(0x9E37_79B9_7F4A_7C15_u128, |hash, &word| {
        let mixed = (hash ^ u128::from(word as u64)).wrapping_mul(MULTIPLIER);
        mixed ^ (mixed >> 67)
    })
}

/// The bits of an operation's motion: what completes it, and what fails it.
pub fn bits_of(line: &Line, station: StationId, op: OpId, recovery: bool) -> (u128, Option<u128>) {
    let operation = line.operation((station, op));
    let signals = match &operation.module {
        linewright_line::OperationModule::Reversible { recovery: back, .. } if recovery => back,
        _ => &operation.normal,
    };
    (1 << signals.complete.0, signals.fault.map(|input| 1 << input.0))
}
