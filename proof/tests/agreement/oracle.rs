//! Invariants of every state, judged from the description alone.

use linewright_line::net::{Block, MotionStage, StationPlace};
use linewright_line::{OpId, StateSpan, StationId};

use super::world::{Setting, World};

/// Largest difference of the cycles of two neighbours. A pair of arrows, one of lag 0 and one of lag 1, lets the one be
/// a cycle ahead; operations listed before the arrow's end may have begun another.
const CYCLES_APART_MAX: i32 = 2;

/// The first thing that is wrong.
pub fn violation(setting: &Setting, world: &World) -> Option<String> {
    let line = &setting.line;
    let is_in = |span: &StateSpan| {
        let mut marking = world.nodes[span.station.index()].controller.marking();
        marking.any(|place| covers(setting, span, place))
    };
    if let Some(conflict) = line.conflicts.iter().find(|c| is_in(&c.a) && is_in(&c.b)) {
        return Some(conflict.why.clone());
    }
    for station in line.station_ids() {
        if let Some(what) = station_violation(setting, world, station) {
            return Some(format!("{}: {what}", line.station(station).name));
        }
    }
    let (least, most) = (world.cycles().min()?, world.cycles().max()?);
    let neighbours = line.stations.len() as i32 - 1;
    (most - least > CYCLES_APART_MAX * neighbours).then(|| format!("cycles {least} and {most} are far apart"))
}

/// The stretch from `from` until `until`, in chart order and cyclic: all places of its operations, but for `until`
/// complete (the stretch is over) and `from` undone (it has not begun).
fn covers(setting: &Setting, span: &StateSpan, place: StationPlace) -> bool {
    let station = setting.line.station(span.station);
    let steps = station.steps.len();
    let distance = |op: OpId| (station.step_of(op) + steps - station.step_of(span.from)) % steps;
    let over = place == StationPlace::completed(span.until);
    let not_begun = place == StationPlace::undone(span.from);
    distance(place.op) <= distance(span.until) && !over && !not_begun && is_of_span(setting, span, place.op)
}

/// Of a group, the operation named alone begins or ends the stretch.
fn is_of_span(setting: &Setting, span: &StateSpan, op: OpId) -> bool {
    let step_of = |op| setting.line.station(span.station).step_of(op);
    let beside = |end: OpId| step_of(op) == step_of(end) && op != end;
    !beside(span.from) && !beside(span.until)
}

fn station_violation(setting: &Setting, world: &World, id: StationId) -> Option<String> {
    let station = setting.line.station(id);
    let node = &world.nodes[id.index()];
    let report = node.controller.report();

    let marking: Vec<StationPlace> = node.controller.marking().collect();
    let step = station.step_of(marking[0].op);
    let mut ops: Vec<OpId> = marking.iter().map(|p| p.op).collect();
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
    // A cycle counts as done only as far as it was done: what is listed later never counts more, nor two less.
    let of_step = |step: &Vec<OpId>| step.iter().map(|op| report.done[op.index()]).collect::<Vec<_>>();
    let counts: Vec<Vec<i32>> = station.steps.iter().map(of_step).collect();
    let (mut floor, first) = (i32::MAX, counts[0][0]);
    for step in &counts {
        let (least, most) = (step.iter().min().copied()?, step.iter().max().copied()?);
        if most > floor || first - least > 1 {
            return Some(format!("the counts {:?} are of no cycle", report.done));
        }
        floor = least;
    }

    let driving: u128 = marking.iter().filter(|p| p.stage == MotionStage::Operating).fold(0, |bits, p| {
        let operation = setting.line.operation((id, p.op));
        let signals = match &operation.module {
            linewright_line::OperationModule::Reversible { recovery, .. } if p.block == Block::Recovery => recovery,
            _ => &operation.normal,
        };
        bits | 1 << signals.actuator.0
    });
    let lamps = marking.iter().filter(|p| p.stage == MotionStage::Incomplete).count();
    if node.outputs & !driving != 0 && lamps == 0 {
        return Some(format!("outputs {:#b} with nothing to drive them", node.outputs));
    }
    None
}
