//! By trying everything, no shorter list of presses exists than the plan's.
//!
//! Nothing of the search is used here: all controllers are copied in each state, all reports go to all, and every button of
//! every panel is tried, and resume. The controllers are those of the simulation, from their own snapshots.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Line, OperationModule, StationId, Tick};
use linewright_proof::generate::{self, LineShape};
use linewright_recovery::{RecoveryAction, RecoveryEnd, RecoveryStep, plan};
use linewright_simulation::{LineSim, NodeProcess, OperatorAction};
use linewright_station_logic::{
    Controller, ModeOrder, NO_DELAY, PanelCommand, Restore, Rules, StationInput, StationOutbox,
};
use linewright_testkit::built::transfer_line;

use crate::operator::{command, described, in_auto, run_for, situation};

pub const NOW: Tick = Tick::from_millis(1);

#[derive(Clone)]
pub struct LineCopy {
    line: Line,
    pub controllers: Vec<Controller>,
}

impl LineCopy {
    pub fn of(sim: &LineSim) -> Self {
        let line = sim.line().clone();
        let rules = Rules { timely: false, ..Rules::ALL };
        let controller = |id| {
            let before: &Controller = sim.controller(id).expect("it is up");
            let restore = Restore::From(before.snapshot());
            Controller::new(&line, id, before.report().boot_id, restore).expect("its own").with_rules(rules)
        };
        let mut copy = LineCopy { controllers: line.station_ids().map(controller).collect(), line };
        let order = ModeOrder { manual_all: true, ..ModeOrder::of(1, 1, ControlMode::Manual, ModeOrder::FOR_GOOD) };
        for id in sim.line().station_ids() {
            copy.image(id.index(), sim.controller(id).expect("it is up").report().measured);
            copy.give(id.index(), StationInput::Order(order));
        }
        copy
    }

    fn give(&mut self, station: usize, input: StationInput<'_>) {
        self.controllers[station].handle(NOW, input);
        let mut out = StationOutbox::default();
        let reports = |all: &[Controller]| all.iter().map(Controller::report).collect::<Vec<_>>();
        loop {
            let before = reports(&self.controllers);
            for _ in 0..3 {
                self.controllers[station].step(NOW, &mut out);
            }
            let now = reports(&self.controllers);
            for (from, report) in now.iter().enumerate() {
                for to in &mut self.controllers {
                    to.handle(NOW, StationInput::View(StationId::at(from), report));
                    (0..3).for_each(|_| to.step(NOW, &mut out));
                }
            }
            if reports(&self.controllers) == before {
                return;
            }
        }
    }

    fn image(&mut self, station: usize, bits: u128) {
        self.give(station, StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY });
    }

    fn pressed(&self, station: usize, advance: bool) -> Option<LineCopy> {
        let mut next = self.clone();
        let command = |held| if advance { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) };
        next.give(station, StationInput::Panel(command(true)));
        let moving: Vec<StationPlace> = next.controllers[station].marking().filter(|p| p.is_operating()).collect();
        if moving.is_empty() {
            next.give(station, StationInput::Panel(command(false)));
            return (next.key() != self.key()).then_some(next);
        }
        next.arrive(station);
        next.give(station, StationInput::Panel(command(false)));
        let ended = next.controllers[station].marking().all(|place| !place.is_operating());
        ended.then_some(next)
    }

    /// *Resume* held until nothing moves any more.
    fn resumed(&self) -> Option<LineCopy> {
        let mut next = self.clone();
        let hold = |next: &mut LineCopy, resume| {
            let manual = ModeOrder::of(1, 1, ControlMode::Manual, ModeOrder::FOR_GOOD);
            for station in 0..next.controllers.len() {
                next.give(station, StationInput::Order(ModeOrder { manual_all: true, resume, ..manual }));
            }
        };
        hold(&mut next, true);
        for _ in 0..next.controllers.len() * 4 {
            for station in 0..next.controllers.len() {
                next.arrive(station);
            }
        }
        hold(&mut next, false);
        let ended = next.controllers.iter().flat_map(Controller::marking).all(|place| !place.is_operating());
        (ended && next.key() != self.key()).then_some(next)
    }

    /// Whatever moves at a station arrives.
    pub fn arrive(&mut self, station: usize) {
        let moving: Vec<StationPlace> = self.controllers[station].marking().filter(|p| p.is_operating()).collect();
        let described = &self.line.stations[station];
        let mut bits = self.controllers[station].report().measured;
        let mut arrived = 0;
        for place in &moving {
            let axis = described.operations[place.op.index()].motion.axis;
            for operation in described.operations.iter().filter(|operation| operation.motion.axis == axis) {
                bits &= !operation.normal.complete.bit();
                if let OperationModule::Reversible { recovery, .. } = operation.module {
                    bits &= !recovery.complete.bit();
                }
            }
            let operation = &described.operations[place.op.index()];
            arrived |= match (place.block, &operation.module) {
                (Block::Recovery, OperationModule::Reversible { recovery, .. }) => recovery.complete.bit(),
                _ => operation.normal.complete.bit(),
            };
        }
        if !moving.is_empty() {
            self.image(station, bits);
            self.image(station, bits | arrived);
        }
    }

    fn is_in_order(&self, at_home: bool) -> bool {
        self.controllers.iter().map(Controller::report).all(|report| {
            let is_whole = report.incomplete.is_empty() && !report.recovering_home && report.position_lost.is_none();
            is_whole && (report.at_home || !at_home)
        })
    }

    fn key(&self) -> String {
        let of = |controller: &Controller| {
            let report = controller.report();
            format!("{:?}{:?}{:?}{}", report.places, report.done, report.started, report.recovering_home)
        };
        self.controllers.iter().map(of).collect()
    }
}

/// The fewest presses after which nothing is incomplete, and all are at home if so asked; if that is at most so many.
fn fewest(start: LineCopy, most: usize, at_home: bool) -> Option<usize> {
    let mut seen = BTreeSet::from([start.key()]);
    let mut queue = VecDeque::from([(start, 0)]);
    while let Some((copy, presses)) = queue.pop_front() {
        if copy.is_in_order(at_home) {
            return Some(presses);
        }
        let resumed = (presses < most).then(|| copy.resumed()).flatten();
        if let Some(next) = resumed.filter(|next| seen.insert(next.key())) {
            queue.push_back((next, presses + 1));
        }
        for station in (0..copy.controllers.len()).filter(|_| presses < most) {
            for advance in [true, false] {
                if let Some(next) = copy.pressed(station, advance)
                    && seen.insert(next.key())
                {
                    queue.push_back((next, presses + 1));
                }
            }
        }
    }
    None
}

/// The line is stopped at any moment; then panels are pressed at random, and let go half-way.
pub fn disturbed(line: &Line, seed: u64) -> LineSim {
    let mut random = generate::Random::new(seed);
    let mut sim = in_auto(line, seed, Duration::from_millis(random.below(9_000) as u64));
    command(&mut sim, ModeCommand::EStop);
    command(&mut sim, ModeCommand::Reset);
    command(&mut sim, ModeCommand::Manual);
    for _ in 0..random.below(5) {
        let station = StationId::at(random.below(line.stations.len()));
        let advance = random.below(2) == 0;
        for down in [true, false] {
            sim.act(OperatorAction::Panel { station, advance, down }).expect("it is done");
            run_for(&mut sim, Duration::from_millis(50 + random.below(600) as u64));
        }
    }
    run_for(&mut sim, Duration::from_secs(1));
    sim
}

fn compare(line: &Line, seed: u64) -> usize {
    let sim = disturbed(line, seed);
    let found = plan(line, &situation(&sim));
    assert_eq!(found.end, RecoveryEnd::Auto, "seed {seed}: {}", described(&sim));
    assert!(found.is_shortest, "seed {seed}");
    let presses = found.presses();
    assert_eq!(fewest(LineCopy::of(&sim), presses, false), Some(presses), "seed {seed}: {}", described(&sim));
    presses
}

#[test]
fn no_list_of_presses_is_shorter_on_small_lines() {
    let shape = LineShape { irreversible: 40, ..LineShape::small() };
    let most = (0..60).map(|seed| compare(&generate::line(&shape, seed), seed)).max();
    assert!(most > Some(1), "some need more than one: {most:?}");
}

#[test]
fn no_list_of_presses_is_shorter_on_the_shipped_line() {
    let line = transfer_line();
    let most = (0..60).map(|seed| compare(&line, seed)).max();
    assert!(most > Some(0), "some need a press: {most:?}");
}

/// A station has lost its memory, its position is confirmed, and all are led home: they are in each other's way.
#[test]
fn no_list_of_presses_leads_all_home_sooner() {
    let line = transfer_line();
    let (mut compared, mut longest) = (0, 0);
    for seed in 0..40 {
        let mut random = generate::Random::new(seed);
        let mut sim = in_auto(&line, seed, Duration::from_millis(random.below(9_000) as u64));
        let station = StationId::at(random.below(line.stations.len()));
        let process = NodeProcess::Station(station);
        let at = OperatorAction::Rejoin(station, None);
        for action in [OperatorAction::Kill(process), OperatorAction::RestartEmpty(process), at] {
            sim.act(action).expect("it is done");
            run_for(&mut sim, Duration::from_secs(4));
        }
        command(&mut sim, ModeCommand::Manual);
        let found = plan(&line, &situation(&sim));
        let is_press = |step: &RecoveryStep| !matches!(step.action, RecoveryAction::Rejoin { .. });
        let presses = found.presses();
        if found.end != RecoveryEnd::Auto || presses > 7 || !found.steps.iter().all(is_press) {
            continue;
        }
        assert!(found.is_shortest);
        assert_eq!(fewest(LineCopy::of(&sim), presses, true), Some(presses), "seed {seed}: {}", described(&sim));
        (compared, longest) = (compared + 1, longest.max(presses));
    }
    assert!(compared > 10 && longest > 3, "{compared}, at most {longest} presses");
}
