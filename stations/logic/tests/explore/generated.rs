//! Lines nobody has thought of: random stations in a row, neighbours kept apart by a pair of arrows.
//!
//! Station `x` and the next, `y`, each have a stretch of their cycle in which the other must be out of its own. `y`
//! enters when `x` has left in the same cycle, `x` again when `y` has left in the cycle before. Home lies anywhere
//! outside the stretches' inside, some operations run side by side, and some are irreversible.

use linewright_line::{Conflict, Line, OpId, StateSpan, Station, StationId};
use linewright_random::Random;

use super::build::{Op, arrow, beside, i, line, r, station};
use super::lines::without_haste;

/// A line of two or three stations; the same for the same seed. `None` where the home positions contradict an arrow:
/// an operation that counts as done at home although its cause does not. Taking such an operation back leads behind
/// the arrow, where nobody is asked; a description must not begin there.
pub fn generated(seed: u64) -> Option<Line> {
    let line = arranged(seed);
    let at_home = |(station, op): (StationId, OpId)| {
        let station = line.station(station);
        station.home_count(op, station.initial_round())
    };
    line.arrows.iter().all(|a| at_home(a.to) - a.lag as i32 <= at_home(a.from)).then_some(line)
}

fn arranged(seed: u64) -> Line {
    let mut random = Random::new(seed);
    let count = 2 + random.below(2) as u16;
    let mut spans = Vec::new();
    let stations = (0..count).map(|n| random_station(n, &mut random, &mut spans)).collect();
    let mut arrows = Vec::new();
    let mut conflicts = Vec::new();
    for x in 0..count - 1 {
        let (a, b): ((u16, u16), (u16, u16)) = (spans[usize::from(x)], spans[usize::from(x) + 1]);
        arrows.push(arrow((x, a.1), (x + 1, b.0), 0));
        arrows.push(arrow((x + 1, b.1), (x, a.0), 1));
        let span = |station: u16, (from, until): (u16, u16)| StateSpan {
            station: StationId(station),
            from: OpId(from),
            until: OpId(until),
        };
        conflicts.push(Conflict { why: format!("stations {x} and {} meet", x + 1), a: span(x, a), b: span(x + 1, b) });
    }
    let mut line = without_haste(line(stations, arrows));
    line.conflicts = conflicts;
    settle(&mut line);
    line
}

fn random_station(n: u16, random: &mut Random, spans: &mut Vec<(u16, u16)>) -> Station {
    let length = 2 + random.below(4) as u16;
    let from = random.below(length.into()) as u16;
    let until = from + random.below((length - from).into()) as u16;
    spans.push((from, until));
    // Home is where the station is outside its stretch: `until` complete, or anything beyond it either way.
    let outside: Vec<u16> = (0..length).filter(|&h| h < from || h >= until).collect();
    let home = *random.pick(&outside);
    let ops: Vec<Op> = (0..length).map(|op| random_op(op, home, length, (from, until), random)).collect();
    station(&format!("s{n}"), usize::from(home), &ops, n * 10, false)
}

fn random_op(op: u16, home: u16, length: u16, span: (u16, u16), random: &mut Random) -> Op {
    let since_home = |op: u16| (op + length - home) % length;
    let named = [span.0, span.1, home, 0].contains(&op);
    // Hand type 2 stands for a sequence of one operation, which is all an irreversible one may have.
    match random.below(4) {
        0 if since_home(op) >= 2 => {
            let before = (op + length - 1) % length;
            i(2, &[usize::from(before)])
        }
        // The operation before must be reversible, of the same type and by itself; `settle` sees to that.
        1 if !named => beside(6),
        _ => r(6),
    }
}

/// Undoes choices that do not go together: a path over an irreversible operation or a group, a group with a home, a
/// named or an irreversible operation in it.
fn settle(line: &mut Line) {
    for station in &mut line.stations {
        let ids: Vec<OpId> = station.op_ids().collect();
        let alone = |station: &Station, op: OpId| station.steps[station.step_of(op)].len() == 1;
        for &op in &ids {
            let path = match &station.operations[op.index()].module {
                linewright_line::OperationModule::Irreversible { recovery_path } => recovery_path.clone(),
                linewright_line::OperationModule::Reversible { .. } => continue,
            };
            let sound = path.iter().all(|&p| is_reversible(station, p) && alone(station, p)) && alone(station, op);
            if !sound {
                station.operations[op.index()] = reversible_instead(station, op);
            }
        }
        if !alone(station, station.home) || !alone(station, OpId(0)) {
            station.steps = ids.iter().map(|&op| vec![op]).collect();
        }
    }
}

fn is_reversible(station: &Station, op: OpId) -> bool {
    matches!(station.operations[op.index()].module, linewright_line::OperationModule::Reversible { .. })
}

fn reversible_instead(described: &Station, op: OpId) -> linewright_line::Operation {
    let types: Vec<Op> = described.operations.iter().map(|_| r(6)).collect();
    let first_button = described.operations[0].hand.forward().0;
    let plain = station(&described.name, described.home.index(), &types, first_button, false);
    plain.operations[op.index()].clone()
}
