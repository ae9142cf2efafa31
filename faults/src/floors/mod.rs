//! Flexible cells under faults with their real stations, from a seed: the token player, the mode decision, every station's
//! controller, and the plant with its parts.
//!
//! The coordinator is killed between any two of its records and messages, and with it the mode decision; stations are killed
//! anywhere in a motion and start with their journals or without, or are not received; motions stick, slip, break and run back; messages of
//! orders get lost, come twice and late; people give commands at the wrong moment. Throughout a run an operator follows the
//! recovery plan step by step ([`linewright_recovery::plan`]), and answers alarms by where the part is.
//!
//! The truth is in the plant's parts, which neither the coordinator nor any station sees. Looked for all the time: conflicts of
//! the description by positions, parts that fall, are torn or brought where they cannot be. At the end: every part has left
//! once, with each work of its plan done once, and none is left over.

mod operator;
mod plan;

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_coordinator_cell::compile::dispatcher;
use linewright_coordinator_cell::{Dispatcher, FiringId, PartId, ProtocolRules};
use linewright_coordinator_shell::orders::manual_permit;
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, CoordinatorShell, heard};
use linewright_line::net::ControlMode;
use linewright_line::{HolderId, Line, OpId, StationId, Tick};
use linewright_plant::{PartFault, Plant};
use linewright_simulation::cell::{CellSim, CellSimOptions, ShopFloor, nests};
use linewright_simulation::{ConflictObserver, Rng};
use linewright_station_logic::PanelCommand;

use crate::message::CONSOLE;

pub use plan::{FLOOR_MUTANTS, FloorMutant};
use plan::{FloorTrouble, FloorWork, PlannedTrouble};

/// Between two looks of the coordinator.
const PERIOD: Duration = Duration::from_millis(20);
/// A production takes a tenth of that without faults.
const LONG: Tick = Tick::from_millis(7_200_000);

/// What has become of a seed.
#[derive(Clone, Debug)]
pub struct PlayedFloor {
    pub finding: Option<String>,
    /// A station without its journal stands at a rest where nothing begins, and no button of the console brings it to another one.
    pub is_left_standing: bool,
    /// What has happened, with times.
    pub story: Vec<(Tick, String)>,
    pub lives: usize,
    pub end: Tick,
}

/// Everything of a cell, in virtual time.
pub(crate) struct FloorWorld {
    pub line: Line,
    pub sim: CellSim,
    pub shell: CoordinatorShell,
    pub now: Tick,
    pub story: Vec<(Tick, String)>,
    pub finding: Option<String>,
    pub is_left_standing: bool,
    /// A panel's button that is held, repeated with every look; the console's buttons.
    pub held: Option<(StationId, PanelCommand)>,
    pub buttons: u32,
    pub resumes: bool,
    /// Works done on a part when an activity of it began.
    pub works_before: BTreeMap<FiringId, usize>,
    /// By holder: its resource.
    pub resource_at: BTreeMap<HolderId, String>,
    /// By station: the operation in which it was killed last, as a person beside it has seen.
    pub stood_in: BTreeMap<StationId, OpId>,
    cell: Cell,
    observer: ConflictObserver,
    protocol: ProtocolRules,
    parts_may_fall: bool,
    record: CoordinatorRecord,
    lives: usize,
    sequence: u64,
    troubles: Vec<(PlannedTrouble, TroubleStage)>,
    mode: ControlMode,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TroubleStage {
    Before,
    Lasting,
    Over,
}

/// Plays a seed.
pub fn play_floor(seed: u64, mutant: Option<FloorMutant>) -> PlayedFloor {
    let mut rng = Rng::named(seed, "floor plan");
    let work = FloorWork::of(seed.is_multiple_of(2)).unwrap_or_else(|| unreachable!("the shipped cells are sound"));
    let mut at = 0;
    let crashes = rng.below(4);
    let crash_at = (0..crashes).map(|_| {
        at += 1 + rng.below(80) as usize;
        at
    });
    let options = CellSimOptions {
        seed,
        crash_at: crash_at.collect(),
        delay: (Duration::from_millis(1), Duration::from_millis(20)),
        bad_luck: *rng.pick(&[0, 4, 8, 20]),
        period: Duration::from_millis(100),
        ..CellSimOptions::default()
    };
    let troubles = work.troubles(&mut rng);
    let mut world = FloorWorld::new(&work, options, troubles, mutant);
    world.play(&work);
    let finding = world.finding.clone().or_else(|| world.judge(&work));
    PlayedFloor {
        finding,
        is_left_standing: world.is_left_standing,
        story: world.story,
        lives: world.sim.lives,
        end: world.now,
    }
}

impl FloorWorld {
    fn new(
        work: &FloorWork,
        options: CellSimOptions,
        troubles: Vec<PlannedTrouble>,
        mutant: Option<FloorMutant>,
    ) -> Self {
        let floor = work.floor(options.seed).unwrap_or_else(|| unreachable!("the shipped stations compile"));
        let (protocol, orders) = mutant.map(FloorMutant::rules).unwrap_or_default();
        let floor = floor.with_order_rules(orders);
        let observer = ConflictObserver::new(&work.line, |_| floor.plant());
        let mut sim = CellSim::new(work.table.clone(), work.line.stations.len(), options);
        sim.floor = Some(floor);
        sim.coordination = sim.coordination.clone().with_rules(protocol);
        let stores = work.table.stores().iter().map(|store| store.name.to_string());
        let stores = stores.filter_map(|name| Some((work.line.handling.holder_named(&name)?, name)));
        let nests = nests(&work.cell, &work.line).into_iter().map(|(name, nest)| (nest, name.to_owned()));
        let record = CoordinatorRecord { epoch: 10, estop: false };
        FloorWorld {
            shell: CoordinatorShell::new(&work.line, 1, record),
            resource_at: stores.chain(nests).collect(),
            line: work.line.clone(),
            cell: work.cell.clone(),
            lives: sim.lives,
            sim,
            now: Tick::from_millis(20),
            story: Vec::new(),
            finding: None,
            is_left_standing: false,
            held: None,
            buttons: 0,
            resumes: false,
            works_before: BTreeMap::new(),
            stood_in: BTreeMap::new(),
            observer,
            protocol,
            parts_may_fall: troubles.iter().any(|planned| planned.may_drop_a_part()),
            record,
            sequence: 0,
            troubles: troubles.into_iter().map(|planned| (planned, TroubleStage::Before)).collect(),
            mode: ControlMode::Home,
        }
    }

    /// Until all is made, the operator looking all the time.
    fn play(&mut self, work: &FloorWork) {
        self.run(Duration::from_millis(500));
        while self.finding.is_none() && !self.is_left_standing && !(self.is_made(work) && self.is_calm()) {
            if self.now > LONG {
                self.finding = Some(format!("not completed: {}", self.described()));
                return;
            }
            if let Err(why) = self.look_after() {
                self.finding.get_or_insert(why);
            }
            self.run(Duration::from_millis(500));
        }
    }

    fn is_made(&self, work: &FloorWork) -> bool {
        let state = self.sim.state();
        let gone = state.left() + state.exceptions().scrapped();
        gone >= work.parts && state.parts().len() == 0 && state.firings().len() == 0
    }

    /// No fault lasts or is to come.
    pub fn is_calm(&self) -> bool {
        self.troubles.iter().all(|(_, stage)| *stage == TroubleStage::Over)
    }

    pub fn dispatcher(&self) -> impl Dispatcher + use<> {
        dispatcher(&self.cell, &self.sim.table)
    }

    pub fn note(&mut self, text: impl Into<String>) {
        self.story.push((self.now, text.into()));
    }

    pub fn floor(&self) -> &ShopFloor {
        self.sim.floor.as_ref().unwrap_or_else(|| unreachable!("it has been put in"))
    }

    pub fn floor_mut(&mut self) -> &mut ShopFloor {
        self.sim.floor.as_mut().unwrap_or_else(|| unreachable!("it has been put in"))
    }

    pub fn run(&mut self, time: Duration) {
        let end = self.now + time;
        while self.now < end && self.finding.is_none() {
            self.have_trouble();
            self.decide();
            let mut by = self.dispatcher();
            self.sim.run_on(&mut by, self.now);
            self.watch();
            self.now = self.now + PERIOD;
        }
    }

    /// Faults that begin or end now.
    fn have_trouble(&mut self) {
        for nth in 0..self.troubles.len() {
            let (planned, stage) = self.troubles[nth];
            if stage == TroubleStage::Before && planned.at <= self.now {
                self.troubles[nth].1 = TroubleStage::Lasting;
                self.note(format!("{}: {:?} for {:?}", self.name(planned.station), planned.what, planned.lasts));
                self.begin(planned);
            } else if stage == TroubleStage::Lasting && planned.at + planned.lasts <= self.now {
                self.troubles[nth].1 = TroubleStage::Over;
                self.end(planned);
            }
        }
    }

    fn begin(&mut self, planned: PlannedTrouble) {
        let (now, station) = (self.now, planned.station);
        match planned.what {
            FloorTrouble::Killed { .. } => {
                let place = self.floor().controller(station).marking().next();
                self.stood_in.extend(place.filter(|_| self.floor().is_up(station)).map(|place| (station, place.op)));
                self.floor_mut().kill(station);
            }
            FloorTrouble::Away => self.sim.stations[station.index()].is_away = true,
            FloorTrouble::Motion(op, fault, is_back) => {
                let plant = self.floor_mut().plant_mut();
                match is_back {
                    true => plant.inject_recovery(now, station, op, Some(fault)),
                    false => plant.inject(now, station, op, Some(fault)),
                }
            }
            FloorTrouble::Command(command) => _ = self.shell.handle(now, CoordinatorArrival::Command(command)),
            FloorTrouble::Press(advance) => {
                let button = if advance { PanelCommand::Advance(true) } else { PanelCommand::Retract(true) };
                self.floor_mut().press(station, button);
            }
        }
    }

    fn end(&mut self, planned: PlannedTrouble) {
        let (now, station) = (self.now, planned.station);
        match planned.what {
            // Two faults may have killed it; the first that ends starts it.
            FloorTrouble::Killed { forgets } => {
                let floor = self.floor_mut();
                let started = if forgets { floor.restart_without_journal(station) } else { floor.restart(station) };
                if started.is_err() {
                    self.finding = Some(format!("{} does not start again", self.name(station)));
                }
            }
            FloorTrouble::Away => self.sim.stations[station.index()].is_away = false,
            FloorTrouble::Motion(op, _, is_back) => {
                let plant = self.floor_mut().plant_mut();
                match is_back {
                    true => plant.inject_recovery(now, station, op, None),
                    false => plant.inject(now, station, op, None),
                }
            }
            FloorTrouble::Command(_) => {}
            FloorTrouble::Press(advance) => {
                let button = if advance { PanelCommand::Advance(false) } else { PanelCommand::Retract(false) };
                self.floor_mut().press(station, button);
            }
        }
    }

    pub fn name(&self, station: StationId) -> &str {
        &self.line.station(station).name
    }

    /// Whether messages pass between the coordinator and a station.
    pub fn is_received(&self, station: StationId) -> bool {
        self.floor().is_up(station) && !self.sim.stations[station.index()].is_away
    }

    /// One period of the mode decision: reports in, orders out. It dies and starts again with the token player.
    fn decide(&mut self) {
        let now = self.now;
        if self.sim.lives != self.lives {
            self.lives = self.sim.lives;
            self.note("the coordinator is killed, and started again");
            self.sim.coordination = self.sim.coordination.clone().with_rules(self.protocol);
            self.shell = CoordinatorShell::new(&self.line, self.lives as u64, self.record);
        }
        let untouched = self.line.console.estop.filter(|contact| !contact.pressed);
        let bits = untouched.map_or(0, |contact| 1 << contact.input.0);
        self.shell.handle(now, CoordinatorArrival::Console { bits, valid: true });
        self.shell.handle(now, CoordinatorArrival::Buttons { console: CONSOLE, held: self.buttons });
        self.shell.handle(now, CoordinatorArrival::Resume { console: CONSOLE, held: self.resumes });
        self.sequence += 1;
        for id in self.line.station_ids() {
            if !self.is_received(id) {
                continue;
            }
            let controller = self.floor().controller(id);
            let mut heard = heard(&controller.report());
            heard.follows = controller.followed();
            let sequence = self.sequence;
            self.shell.handle(now, CoordinatorArrival::State { station: id, sequence, heard });
        }
        let coordination = &self.sim.coordination;
        let isolated = linewright_coordinator_cell::exception::isolated(coordination.state());
        self.shell.plays_cell(isolated.into_iter(), coordination.state().exceptions().stopped());
        let held: Vec<StationId> = coordination.held_stations().collect();
        self.shell.hold(|id| held.contains(&id));
        self.shell.permit_manual(|id| Some(manual_permit(coordination, &self.line, now, id)));
        let mut effects = Vec::new();
        self.shell.act(now, &mut effects);
        for effect in effects {
            match effect {
                CoordinatorEffect::Remember(record) => {
                    self.record = record;
                    self.shell.remembered(now, record, true);
                }
                CoordinatorEffect::Refused(refusal) => self.note(format!("refused: {}", refusal.text(&self.line))),
                _ => {}
            }
        }
        self.give_orders();
    }

    fn give_orders(&mut self) {
        let order = self.shell.order();
        self.sim.starts = order.mode == ControlMode::Auto && order.enabled && order.master_stop.is_none();
        let coordinator = self.shell.coordinator();
        let by_hand = self.line.station_ids().filter(|&id| coordinator.is_by_hand(id));
        self.sim.in_manual = by_hand.map(|id| (id, coordinator.single_epoch(id))).collect();
        if order.mode != self.mode {
            self.mode = order.mode;
            self.note(format!("mode {}", self.shell.coordinator().text()));
        }
        for id in self.line.station_ids() {
            if !self.is_received(id) {
                continue;
            }
            let order = self.shell.order_for(id);
            self.floor_mut().order(id, order);
        }
        if let Some((station, button)) = self.held.filter(|&(station, _)| self.floor().is_up(station)) {
            self.floor_mut().press(station, button);
        }
    }

    /// Conflicts, and mishaps of parts that no trouble explains.
    fn watch(&mut self) {
        for firing in self.sim.coordination.state().firings() {
            let done = self.works_on(firing.part);
            self.works_before.entry(firing.id).or_insert(done);
        }
        let Some(floor) = &self.sim.floor else { return };
        let plant: &Plant = floor.plant();
        self.observer.look_everywhere(&self.line, |_| plant);
        let conflict = self.observer.seen().first().map(|seen| format!("conflict: {seen:?}"));
        let mishap = plant
            .mishaps()
            .0
            .iter()
            .find(|(at, mishap)| !self.is_excused(*at, mishap))
            .map(|(at, mishap)| format!("at {at}: {mishap:?}"));
        let trouble = floor.trouble.first().cloned();
        if let Some(found) = conflict.or(mishap).or(trouble) {
            self.finding = Some(found);
        }
    }

    /// Whether it follows from a fault that has begun: a grip of its station fails, an axis of it leaves by itself where it has just been
    /// seen, or it has forgotten the slot that its part is on its way to.
    fn is_excused(&self, at: Tick, mishap: &PartFault) -> bool {
        let (PartFault::Fell { hand, .. } | PartFault::Torn { hand, .. } | PartFault::Blocked { hand, .. }) = *mishap;
        let of = &self.line.handling.holder(hand).name;
        let is_its = |station: StationId| of.strip_prefix(self.name(station)).is_some_and(|rest| rest.starts_with('.'));
        self.troubles
            .iter()
            .any(|(planned, _)| planned.at <= at && planned.may_drop_a_part() && is_its(planned.station))
    }

    pub fn works_on(&self, part: Option<PartId>) -> usize {
        self.floor().done.iter().filter(|work| work.part.is_some() && work.part == part).count()
    }

    pub fn described(&self) -> String {
        let stations = self.line.station_ids().map(|id| {
            let controller = self.floor().controller(id);
            let waits = controller.blocked_by(&self.line, self.now);
            format!("{}: {}, {waits:?}", self.name(id), controller.operation_text(&self.line))
        });
        let parts: Vec<String> = self.floor().plant().parts().map(|part| format!("{part:?}")).collect();
        let firings: Vec<_> =
            self.sim.state().firings().map(|of| (self.sim.table.mode_name(of.mode), of.phase)).collect();
        let down: Vec<_> = self.sim.state().exceptions().down().map(|(id, down)| (id, down.clone())).collect();
        let alarms: Vec<_> = self.sim.state().exceptions().alarms().map(|alarm| &alarm.text).collect();
        format!(
            "{}; {}; parts {parts:?}; activities {firings:?}; alarms {alarms:?}; out of service {down:?}",
            self.shell.coordinator().text(),
            stations.collect::<Vec<_>>().join("; ")
        )
    }

    fn judge(&self, work: &FloorWork) -> Option<String> {
        let floor = self.floor();
        let mut left = floor.left.clone();
        left.sort_unstable();
        left.dedup();
        let scrapped = self.sim.state().exceptions().scrapped();
        if left.len() != floor.left.len() {
            return Some(format!("{:?} have left", floor.left));
        }
        if self.is_left_standing {
            let known = left.len() as u64 + scrapped + self.sim.state().parts().len() as u64;
            return (known > work.parts).then(|| format!("{known} parts are known of {}", work.parts));
        }
        if left.len() as u64 + scrapped != work.parts {
            return Some(format!("{:?} have left of {} parts, {scrapped} were scrapped", floor.left, work.parts));
        }
        if scrapped > 0 && !self.parts_may_fall {
            return Some(format!("{scrapped} parts were scrapped"));
        }
        if floor.plant().parts().count() > 0 {
            return Some(format!("left over: {:?}", floor.plant().parts().collect::<Vec<_>>()));
        }
        let works = |part: PartId| self.works_on(Some(part));
        let wrong = left.iter().find(|&&part| works(part) != work.works)?;
        Some(format!("{wrong}: {} works instead of {}: {:?}", works(*wrong), work.works, floor.done))
    }
}
