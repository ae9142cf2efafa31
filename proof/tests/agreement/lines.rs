//! The lines that are explored: the shipped one, and smaller ones with the same arrows and conflicts.

use std::time::Duration;

use linewright_line::{Conflict, Line, OpId, StateSpan, StationId};

use linewright_testkit::built::{arrow, beside, i, line, r, station, transfer_line};

/// Nothing expires while the clock stands still, but a lease of zero would.
pub fn without_haste(mut line: Line) -> Line {
    line.timing.stale = Duration::from_secs(1 << 20);
    line.timing.lease = Duration::from_secs(1 << 20);
    line
}

fn conflict(why: &str, a: (u16, u16, u16), b: (u16, u16, u16)) -> Conflict {
    let span = |(station, from, until)| StateSpan { station: StationId(station), from: OpId(from), until: OpId(until) };
    Conflict { why: why.to_owned(), a: span(a), b: span(b) }
}

const BAR_AND_CLAMP: &str = "the bar is off its rest while the clamp is not open";
const TOOL_AND_CLAMP: &str = "the tool is forward while the clamp is not closed";

/// The line as it is shipped: 10, 2 and 5 operations.
pub fn shipped() -> Line {
    without_haste(transfer_line())
}

/// A bar that lifts (op 0) and lowers (op 1), and a clamp that opens (op 0, home) and closes (op 1).
pub fn bar_and_clamp() -> Line {
    let stations = vec![bar(), clamp()];
    let mut line = without_haste(line(stations, vec![arrow((1, 0), (0, 0), 0), arrow((0, 1), (1, 1), 0)]));
    // Without a mill the clamp opens when it likes: the bar's round is what holds it.
    line.arrows.push(arrow((0, 1), (1, 0), 1));
    line.conflicts = vec![conflict(BAR_AND_CLAMP, (0, 0, 1), (1, 1, 0))];
    line
}

/// The same clamp, and a mill that approaches (op 0), feeds (op 1, irreversible) and resets (op 2, home).
pub fn clamp_and_mill() -> Line {
    let mut clamp = clamp();
    clamp.name = "clamp".to_owned();
    let arrows = vec![arrow((0, 1), (1, 0), 0), arrow((1, 2), (0, 0), 1)];
    let mut line = without_haste(line(vec![clamp, mill()], arrows));
    line.conflicts = vec![conflict(TOOL_AND_CLAMP, (1, 0, 2), (0, 0, 1))];
    line
}

/// All three, as short as they can be.
pub fn small() -> Line {
    let arrows =
        vec![arrow((1, 0), (0, 0), 0), arrow((0, 1), (1, 1), 0), arrow((1, 1), (2, 0), 0), arrow((2, 2), (1, 0), 1)];
    let mut line = without_haste(line(vec![bar(), clamp(), mill()], arrows));
    line.conflicts =
        vec![conflict(BAR_AND_CLAMP, (0, 0, 1), (1, 1, 0)), conflict(TOOL_AND_CLAMP, (2, 0, 2), (1, 0, 1))];
    line
}

/// A table that indexes (op 0, home), and a drill that goes down (op 0) and up (op 1, home).
pub fn table_and_drill() -> Line {
    let mut table = station("table", 0, &[i(2, &[])], 0, false);
    table.axes[0].index = Some(1.0);
    table.operations[0].motion.to = table.axes[0].home;
    let drill = station("drill", 1, &[r(6), r(6)], 4, false);
    let mut line = without_haste(line(vec![table, drill], vec![arrow((0, 0), (1, 0), 0), arrow((1, 1), (0, 0), 1)]));
    line.conflicts = vec![conflict("the table turns under the drill", (0, 0, 0), (1, 0, 1))];
    line
}

/// A bar, and a clamp of two jaws that close side by side (ops 1 and 2) and open one after the other.
pub fn two_jaws() -> Line {
    let jaws = station("jaws", 0, &[r(6), r(6), beside(6)], 8, false);
    let arrows =
        vec![arrow((1, 0), (0, 0), 0), arrow((0, 1), (1, 1), 0), arrow((0, 1), (1, 2), 0), arrow((0, 1), (1, 0), 1)];
    let mut line = without_haste(line(vec![bar(), jaws], arrows));
    line.conflicts = vec![conflict(BAR_AND_CLAMP, (0, 0, 1), (1, 1, 0)), conflict(BAR_AND_CLAMP, (0, 0, 1), (1, 2, 0))];
    line
}

/// Two stations in one another's way, where the second's home motion (op 2) is in its stretch: its irreversible op 1
/// goes home by undoing op 0 and then running op 2.
pub fn home_in_the_way() -> Line {
    let x = station("x", 2, &[r(6), r(6), r(6)], 0, false);
    let y = station("y", 2, &[r(6), i(2, &[0]), r(6)], 10, false);
    let mut line = without_haste(line(vec![x, y], vec![arrow((0, 1), (1, 2), 0), arrow((1, 2), (0, 0), 1)]));
    line.conflicts = vec![conflict("x and y meet", (0, 0, 1), (1, 2, 2))];
    line
}

fn bar() -> linewright_line::Station {
    station("bar", 1, &[r(6), r(6)], 0, false)
}

fn clamp() -> linewright_line::Station {
    station("clamp", 0, &[r(6), r(6)], 8, true)
}

fn mill() -> linewright_line::Station {
    station("mill", 2, &[r(1), i(1, &[0]), r(2)], 16, false)
}
