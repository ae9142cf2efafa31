//! Facts on one situation of a station, computed once: possible acts, view keys for its readers, and violations. Judged
//! from the description alone, not from the controller's own reasoning.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Line, MotionSignals, OpId, OperationModule, StateSpan, StationId};

use super::orders;
use super::setting::{Grants, LineExploration};
use super::station::{PanelKey, Situation, Situations, StationAct};
use super::view_key::{ViewKey, ViewKeys};

/// At most this many conflicts: one bit each.
pub(crate) const CONFLICTS_MAX: usize = 64;

/// At most this many stations: one bit each.
pub(crate) const STATIONS_MAX: usize = 32;

/// Facts on one situation.
#[derive(Debug)]
pub(crate) struct SituationFacts {
    /// Acts that may come next, of this station by itself.
    pub acts: Box<[StationAct]>,
    /// Its view key for each outgoing link, relative to its cycle.
    pub says: Box<[ViewKey]>,
    /// The view key it holds for each incoming link, relative to its cycle.
    pub holds: Box<[ViewKey]>,
    /// The conflicts of which it is in the one state, a bit each.
    pub in_a: u64,
    /// The conflicts of which it is in the other.
    pub in_b: u64,
    pub at_home: bool,
    /// It has lost its memory.
    pub is_lost: bool,
    /// It is not in stand-by.
    pub acts_on_a_mode: bool,
    /// Violation by the station itself.
    pub wrong: Option<Box<str>>,
}

impl SituationFacts {
    pub fn of(setting: &LineExploration, words: &mut [ViewKeys], of: &Situations, situation: &Situation) -> Self {
        let line = &setting.line;
        // Without its memory its marking shows what moves, and not where the rest stands.
        let stands = |place: &StationPlace| !situation.is_lost() || place.is_operating();
        let stood = situation.stood.as_deref().unwrap_or_default();
        let inside = |span: &StateSpan| {
            let mut places = situation.controller.marking().filter(stands).chain(stood.iter().copied());
            span.station.index() == of.station && places.any(|place| covers(line, span, place))
        };
        let bits = |side: fn(&linewright_line::Conflict) -> &StateSpan| {
            let conflicts = line.conflicts.iter().take(CONFLICTS_MAX).enumerate();
            conflicts.fold(0, |bits, (nth, conflict)| bits | u64::from(inside(side(conflict))) << nth)
        };
        let says = of.outgoing.iter().map(|&link| situation.says(setting, link, &mut words[link])).collect();
        let holds = of.incoming.iter().enumerate();
        let holds = holds.map(|(nth, &link)| situation.holds(setting, link, nth, &mut words[link])).collect();
        SituationFacts {
            acts: acts(setting, of.station, situation).into(),
            says,
            holds,
            in_a: bits(|conflict| &conflict.a),
            in_b: bits(|conflict| &conflict.b),
            at_home: situation.controller.is_at_home(),
            is_lost: situation.is_lost(),
            acts_on_a_mode: situation.mode != ControlMode::StandBy,
            wrong: wrong(line, StationId::at(of.station), situation).map(Into::into),
        }
    }
}

/// Everything that may happen to this station next, but for reports from others.
fn acts(setting: &LineExploration, station: usize, situation: &Situation) -> Vec<StationAct> {
    let mut acts = Vec::new();
    for place in situation.controller.marking().filter(|place| place.is_operating()) {
        // A mechanism that is not driven stays where it is.
        if situation.drives(setting, place.op, place.block) {
            acts.push(StationAct::Arrive(place.op, place.block));
        }
        if setting.faults {
            acts.push(StationAct::Fail(place.op, place.block));
        }
    }
    if setting.modes.contains(&ControlMode::Manual) && (situation.mode == ControlMode::Manual || !setting.tidy_hands) {
        match situation.key {
            None => acts.extend([PanelKey::Advance, PanelKey::Return].map(|key| StationAct::Key(Some(key)))),
            Some(_) => acts.push(StationAct::Key(None)),
        }
    }
    let hands_off = situation.key.is_none() && situation.button.is_none();
    if hands_off || !setting.tidy_hands {
        acts.extend(modes_from(setting, situation.mode).map(StationAct::Mode));
    }
    if setting.modes.contains(&ControlMode::Hand) && (situation.mode == ControlMode::Hand || !setting.tidy_hands) {
        match situation.button {
            Some(_) => acts.push(StationAct::Button(None)),
            None => acts.extend(buttons_of(&setting.line, station).map(|button| StationAct::Button(Some(button)))),
        }
    }
    if situation.controller.request().is_some() {
        acts.push(StationAct::Step);
    }
    let may_restart = !setting.line.station(StationId::at(station)).is_task_driven();
    acts.extend((setting.restarts && may_restart).then_some(StationAct::Restart));
    acts.extend((setting.forgets && may_restart && !situation.is_lost()).then_some(StationAct::Forget));
    orders::acts(&setting.line, StationId::at(station), situation, &mut acts);
    acts
}

/// The modes it may receive next. In epochs, stand-by comes between any two.
fn modes_from(setting: &LineExploration, mode: ControlMode) -> impl Iterator<Item = ControlMode> + '_ {
    let back = (setting.grants == Grants::InEpochs && mode != ControlMode::StandBy).then_some(ControlMode::StandBy);
    let all = setting.modes.iter().copied().filter(move |&other| back.is_none() && other != mode);
    back.into_iter().chain(all)
}

fn buttons_of(line: &Line, station: usize) -> impl Iterator<Item = u16> + use<> {
    let hands = line.stations[station].operations.iter().map(|op| op.hand);
    let mut all: Vec<u16> = hands
        .flat_map(|hand| [Some(hand.forward()), hand.back(), hand.next()])
        .flatten()
        .map(|button| button.0)
        .collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter()
}

fn signals(line: &Line, station: StationId, op: OpId, block: Block) -> MotionSignals {
    let operation = line.operation((station, op));
    match (&operation.module, block) {
        (OperationModule::Reversible { recovery, .. }, Block::Recovery) => *recovery,
        (OperationModule::Reversible { .. } | OperationModule::Irreversible { .. }, _) => operation.normal,
    }
}

pub(crate) fn actuator(line: &Line, station: StationId, op: OpId, block: Block) -> u128 {
    1 << signals(line, station, op, block).actuator.0
}

/// The bits of a motion: what completes it, and what fails it.
pub(crate) fn bits_of(line: &Line, station: StationId, op: OpId, block: Block) -> (u128, Option<u128>) {
    let signals = signals(line, station, op, block);
    (1 << signals.complete.0, signals.fault.map(|input| 1 << input.0))
}

/// The stretch from `from` until `until`, in chart order and cyclic: all places of its operations, but for `until`
/// complete (the stretch is over) and `from` undone (it has not begun).
pub(crate) fn covers(line: &Line, span: &StateSpan, place: StationPlace) -> bool {
    let station = line.station(span.station);
    let steps = station.steps.len();
    let distance = |op: OpId| (station.step_of(op) + steps - station.step_of(span.from)) % steps;
    // Of a group, the operation named alone begins or ends the stretch.
    let beside = |end: OpId| station.step_of(place.op) == station.step_of(end) && place.op != end;
    let over = place == StationPlace::completed(span.until);
    let not_begun = place == StationPlace::undone(span.from);
    let within = distance(place.op) <= distance(span.until);
    within && !over && !not_begun && !beside(span.from) && !beside(span.until)
}

/// The first thing that is wrong with a station by itself: its tokens, its counts, its outputs.
fn wrong(line: &Line, id: StationId, situation: &Situation) -> Option<String> {
    let station = line.station(id);
    let report = situation.controller.report();
    if situation.is_lost() && report.request.is_some() {
        return Some("takes counts back that are of no generation".to_owned());
    }
    let marking: Vec<StationPlace> = situation.controller.marking().collect();
    let step = station.step_of(marking[0].op);
    let mut ops: Vec<OpId> = marking.iter().map(|place| place.op).collect();
    ops.sort_unstable();
    if ops != station.steps[step] && !(report.recovering_home && ops.len() == 1) {
        return Some(format!("tokens in {ops:?}, which is not one step"));
    }
    for op in station.op_ids() {
        let (done, started) = (report.done[op.index()], report.started[op.index()]);
        if done > started || started > report.cycle + i32::from(report.recovering_home) || started - done > 1 {
            return Some(format!("{}: done {done}, started {started}", station.operations[op.index()].name));
        }
    }
    // At a task-driven station each task is a round of its own.
    let rounds: Vec<&[Vec<OpId>]> = match station.tasks.as_slice() {
        [] => vec![&station.steps],
        tasks => tasks.iter().map(|task| &station.steps[task.steps.clone()]).collect(),
    };
    for round in rounds {
        if let Some(what) = counts_of_no_cycle(&report.done, round) {
            return Some(what);
        }
    }
    let driving = marking.iter().filter(|place| place.is_operating());
    let driving = driving.fold(0, |bits, place| bits | actuator(line, id, place.op, place.block));
    let lamps = marking.iter().filter_map(|place| signals(line, id, place.op, place.block).lamp);
    let lamps = lamps.fold(0, |bits, lamp| bits | 1 << lamp.0);
    let extra = situation.outputs & !driving & !lamps & !orders::parameters(line, id, situation);
    (extra != 0).then(|| format!("outputs {extra:#b} are on with nothing to drive them"))
}

/// A cycle counts as done only as far as it was done: what is listed later never counts more, nor two less.
fn counts_of_no_cycle(done: &[i32], steps: &[Vec<OpId>]) -> Option<String> {
    let first = done[steps[0][0].index()];
    let mut floor = i32::MAX;
    for step in steps {
        let counts = || step.iter().map(|op| done[op.index()]);
        let (least, most) = (counts().min()?, counts().max()?);
        if most > floor || first - least > 1 {
            return Some(format!("the counts {done:?} are of no cycle"));
        }
        floor = least;
    }
    None
}
