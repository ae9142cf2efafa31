//! Lines that are played: shipped ones at several speeds, and generated ones.

use linewright_line::{Line, OperationModule, TransferLine};
use linewright_proof::generate::{self, LineShape};
use linewright_simulation::Rng;

/// A rotary table that a drive turns from place to place, and three stations around it.
const TABLE: &str = include_str!("../../examples/driven-table.toml");

/// The line of a seed, and whether it is a shipped one. `provokes`: with more of what is provoked.
pub(crate) fn drawn(rng: &mut Rng, seed: u64, provokes: bool) -> (Line, bool) {
    let is_shipped = rng.chance(if provokes { 600 } else { 750 });
    let scale = *rng.pick(if provokes { &[0.1, 0.3, 1.0, 1.0] } else { &[0.1, 0.1, 0.3, 1.0] });
    let shipped = match (is_shipped, rng.chance(150)) {
        (false, _) => None,
        (true, true) => table(scale),
        (true, false) => {
            let machines = if rng.chance(150) { 2 } else { 1 };
            let text = TransferLine { machines, time_scale: scale }.text();
            linewright_line::parse("line.toml", &text).ok().map(|parsed| parsed.line)
        }
    };
    shipped.map_or_else(|| (generated(seed, provokes), false), |line| (line, true))
}

/// The rotary table, with its motions that many times as long.
fn table(scale: f64) -> Option<Line> {
    let mut line = linewright_line::parse("driven-table.toml", TABLE).ok()?.line;
    for operation in line.stations.iter_mut().flat_map(|station| &mut station.operations) {
        operation.duration = operation.duration.mul_f64(scale);
        if let OperationModule::Reversible { recovery_duration, .. } = &mut operation.module {
            *recovery_duration = recovery_duration.mul_f64(scale);
        }
    }
    Some(line)
}

/// With more of what is provoked: irreversible operations, and stations that wait for each other.
fn generated(seed: u64, provokes: bool) -> Line {
    let shape = LineShape { operations: 2..=4, ..LineShape::default() };
    let more = LineShape { operations: 3..=5, irreversible: 60, more_arrows: 6, ..shape.clone() };
    generate::line(if provokes { &more } else { &shape }, seed)
}
