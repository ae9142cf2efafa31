//! The observer's stretch of a task: by where the mechanisms stand, and not where another task leads too.

use linewright_line::{AxisId, Conflict, Line, StateSpan, StationId, Tick, parse};
use linewright_plant::{Plant, PlantOptions};
use linewright_simulation::ConflictObserver;

const M1: StationId = StationId(0);

/// Whether the task of a name is seen while clamp and slide of `m1` stand there.
fn is_seen(line: &Line, name: &str, [clamp, slide]: [f64; 2]) -> bool {
    let m1 = line.station(M1);
    let task = m1.tasks.iter().find(|task| task.name == name).expect("it has it");
    let [from, until] = [task.steps.start, task.steps.end - 1].map(|step| m1.steps[step][0]);
    let span = StateSpan { station: M1, from, until };
    let line = Line { conflicts: vec![Conflict { why: name.to_owned(), a: span, b: span }], ..line.clone() };
    let mut plant = Plant::new(&line, PlantOptions::default());
    plant.place(Tick::ZERO, M1, AxisId(0), clamp);
    plant.place(Tick::ZERO, M1, AxisId(1), slide);
    let mut observer = ConflictObserver::new(&line, |_| &plant);
    observer.look_everywhere(&line, |_| &plant);
    !observer.seen().is_empty()
}

#[test]
fn a_task_is_a_state_where_no_other_task_leads() {
    let text = include_str!("../../model/line/tests/descriptions/task_driven.toml");
    let line = parse("task_driven.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    // The clamp, which two other tasks move, and the slide, which this one alone moves.
    for rest in [[0.0, 0.0], [30.0, 0.0], [60.0, 0.0]] {
        assert!(!is_seen(&line, "machine", rest), "{rest:?}");
    }
    for away in [[60.0, 40.0], [60.0, 90.0], [60.0, 100.0], [0.0, 40.0]] {
        assert!(is_seen(&line, "machine", away), "{away:?}");
    }
    // Closing the clamp and opening it look the same.
    assert!(!is_seen(&line, "clamp", [30.0, 0.0]));
}
