//! Conflicts of tasks, at the shipped workcell: which the cell's net excludes, and the effect of switches on those.

use linewright_cell::Cell;
use linewright_line::{Conflict, Line, StateSpan, Station, StationId, TaskId};
use linewright_proof::cell::{CellExploration, CellProperty, Verdict, check_conflicts};
use linewright_proof::positions::{PositionRules, explore_positions};

use super::described;

const WHY: &str = "they would meet";

/// Workcell C1 with this conflict.
fn with(a: (&str, &str), b: (&str, &str)) -> (Cell, Line) {
    let side = |(station, task)| format!("{{ station = \"{station}\", task = \"{task}\" }}");
    described("workcell-c1", &format!("\n[[conflict]]\nwhy = \"{WHY}\"\na = {}\nb = {}\n", side(a), side(b)))
}

fn judged(a: (&str, &str), b: (&str, &str)) -> CellProperty {
    let (cell, line) = with(a, b);
    let mut found = check_conflicts(&CellExploration::new(&cell), &line).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(found.len(), 1);
    found.remove(0)
}

#[test]
fn a_machine_is_not_loaded_and_run_at_once() {
    let found = judged(("robot", "load m1"), ("m1", "machine"));
    assert_eq!(found.verdict, Verdict::Holds, "{found:?}");
    let found = judged(("robot", "unload m1"), ("m1", "machine"));
    assert_eq!(found.verdict, Verdict::Holds, "{found:?}");
}

#[test]
fn a_machine_runs_while_another_one_is_loaded_and_here_is_how() {
    let found = judged(("robot", "load m3"), ("m2", "machine"));
    assert_eq!(found.verdict, Verdict::Fails, "{found:?}");
    let story = found.counterexample.expect("it is told");
    assert!(story.end.starts_with("`load M3` and `M2.process` can both start here"), "{}", story.end);
    assert!(story.end.ends_with(WHY), "{}", story.end);
    // One part each, one of which is in the machine before its work, and one in the store.
    let holds = |name: &str| story.resources.iter().find(|of| of.name == name).map(|of| of.parts.len());
    assert_eq!((holds("M2"), holds("ST"), holds("M3")), (Some(1), Some(1), Some(0)), "{story:?}");
}

#[test]
fn what_one_activity_orders_is_under_way_at_once() {
    let found = judged(("robot", "load m1"), ("m1", "clamp"));
    assert_eq!(found.verdict, Verdict::Fails);
    let end = found.counterexample.expect("it is told").end;
    assert_eq!(end, format!("`load M1` orders `load m1` of robot and `clamp` of m1 at once: {WHY}"));
}

/// With one part in the cell nothing is done to two.
#[test]
fn with_one_part_at_a_time_two_machines_never_run_at_once() {
    let (mut cell, line) = with(("m1", "machine"), ("m3", "machine"));
    let verdict = |cell: &Cell| check_conflicts(&CellExploration::new(cell), &line).expect("it has a net")[0].verdict;
    assert_eq!(verdict(&cell), Verdict::Fails);
    cell.limits.wip_max = 1;
    assert_eq!(verdict(&cell), Verdict::Holds);
}

/// Two machines whose slides would meet. Each slide is moved by this task alone, so each has the other's clearance.
#[test]
fn measured_positions_by_themselves_keep_two_tasks_apart() {
    let text = include_str!("../../../model/line/tests/descriptions/task_driven.toml");
    let mut line = linewright_line::parse("task_driven.toml", text).unwrap_or_else(|why| panic!("{why:#}")).line;
    line.stations[1] = Station { name: "m2".to_owned(), ..line.stations[0].clone() };
    let machine = line.stations[0].task(TaskId(1)).steps.clone();
    let [from, until] = [machine.start, machine.end - 1].map(|step| line.stations[0].steps[step][0]);
    let span = |station| StateSpan { station: StationId(station), from, until };
    let conflict = Conflict { why: WHY.to_owned(), a: span(0), b: span(1) };
    line.conflicts.push(conflict.clone());
    let explore = |rules| explore_positions(&line, &conflict, rules, 1_000_000).expect("they compile");
    let found = explore(PositionRules::ALL);
    assert!(found.exhausted && found.counterexample.is_none(), "{found:?}");
    for starts in [true, false] {
        let without = explore(PositionRules { starts, stops: false });
        assert!(without.counterexample.is_some(), "starts {starts}: {without:?}");
    }
}
