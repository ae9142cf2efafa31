//! A cell: parts, orders and alarms with all that is reported of them, and ages by one clock.

use linewright_msgs::{ActivityState, AlarmState, Bounded, CellState, Header, PartState, ProductionState, Time};
use serde_json::json;

use crate::bench::ViewBench;

/// A clock that is far from the one of the console.
fn at(sec: i32) -> Time {
    Time { sec, nanosec: 0 }
}

pub fn cell() -> CellState {
    let alarm = AlarmState {
        id: 4,
        raised: at(940),
        text: "R came to M1 without part 7.".to_owned(),
        answers: vec!["in-store".to_owned(), "scrap".to_owned()],
        meanings: vec!["part in the store".to_owned(), "part gone".to_owned()],
        verdicts: vec![AlarmState::VERDICT_CONTRADICTS, AlarmState::VERDICT_FITS],
        verdict_reasons: vec!["ST: sensor off".to_owned(), String::new()],
        lead: vec!["robot".to_owned()],
        reset: vec!["robot".to_owned()],
        at_order: vec!["mill".to_owned()],
        lead_to: AlarmState::LEAD_BACK,
        lead_because: "it has not grasped".to_owned(),
        bring: "robot".to_owned(),
        to_rest: "over store".to_owned(),
    };
    let part = PartState { id: 7, stage: "A.turn".to_owned(), place: "in M1".to_owned(), since: at(870), order: 1 };
    let failed = ActivityState {
        id: 3,
        name: "load M1".to_owned(),
        part: 7,
        began: at(990),
        running: false,
        text: "failed".to_owned(),
        ..ActivityState::default()
    };
    let order = |id, name: &str, due, ended| ProductionState {
        id,
        name: name.to_owned(),
        product: "A".to_owned(),
        quantity: 5,
        done: 2,
        text: "in work".to_owned(),
        due,
        ended,
        ..ProductionState::default()
    };
    CellState {
        header: Header { stamp: at(1000), ..Header::default() },
        starting: true,
        parts_inside: 1,
        orders_open: 1,
        alarms: Bounded::new(vec![AlarmState { id: 9, raised: at(999), ..alarm.clone() }, alarm]).expect("few"),
        parts: Bounded::new(vec![part]).expect("few"),
        activities: Bounded::new(vec![failed]).expect("few"),
        orders: Bounded::new(vec![order(1, "rush", at(900), at(0)), order(2, "old", at(900), at(950))]).expect("few"),
        down: Bounded::new(vec!["M2".to_owned()]).expect("few"),
        ..CellState::default()
    }
}

#[test]
fn ages_are_those_of_the_coordinators_clock() {
    let mut bench = ViewBench::new(true);
    bench.cell = Some((cell(), 50_000));
    let page = bench.page(52_000);
    let cell = page.cell.expect("received");
    assert_eq!(cell.parts[0].age, "2 min 12 s");
    assert_eq!((cell.parts[0].order.as_deref(), cell.activities[0].age.as_str()), (Some("rush"), "12 s"));
    assert_eq!((cell.orders[0].due.as_deref(), cell.orders[0].is_late), (Some("overdue for 1 min 42 s"), true));
    assert_eq!((cell.orders[1].due.as_deref(), cell.orders[1].is_late, cell.orders[1].is_over), (None, false, true));
    assert_eq!(cell.out_of_service[0].text, "M2");
    assert_eq!((cell.products, cell.resources), (vec!["A".to_owned()], vec!["M1".to_owned(), "R".to_owned()]));
}

#[test]
fn an_alarm_has_every_field_that_is_reported() {
    let mut bench = ViewBench::new(true);
    bench.cell = Some((cell(), 0));
    let page = serde_json::to_value(bench.page(0)).expect("JSON");
    let alarms = page["alarms"].as_array().expect("a list");
    let found: Vec<&serde_json::Value> = alarms.iter().filter(|alarm| !alarm["number"].is_null()).collect();
    assert_eq!((&found[0]["number"], &found[1]["number"]), (&json!(9), &json!(4)), "the newest first");
    let expected = json!({
        "key": "cell 4 940",
        "source": "cell",
        "priority": 2,
        "priority_text": "medium",
        "shown": 6,
        "state": "active, not acknowledged",
        "acknowledged": null,
        "text": "R came to M1 without part 7.",
        "age": "1 min 0 s",
        "number": 4,
        "answers": [
            { "answer": "in-store", "meaning": "part in the store", "verdict": "contradicts", "why": "ST: sensor off" },
            { "answer": "scrap", "meaning": "part gone", "verdict": "fits", "why": null },
        ],
        "lead": ["robot"],
        "reset": ["robot"],
        "at_order": ["mill"],
        "lead_to": "back to where the task began",
        "lead_because": "it has not grasped",
        "bring": ["robot", "over store"],
    });
    assert_eq!(*found[1], expected);
}

#[test]
fn a_cell_that_is_not_received_is_unknown_and_a_line_has_none() {
    let mut bench = ViewBench::new(true);
    bench.cell = Some((cell(), 0));
    assert!(bench.page(2_499).cell.is_some());
    let page = bench.page(2_500);
    assert!(page.cell.is_none());
    assert_eq!(page.cell_unknown.as_deref(), Some("no state received for 2 s"));
    assert!(page.alarms.iter().any(|of| of.source == "cell" && of.text == "no state received for 2 s"));
    let mut bench = ViewBench::new(false);
    bench.cell = Some((cell(), 0));
    let page = bench.page(0);
    assert!(page.cell.is_none() && page.cell_unknown.is_none() && page.alarms.iter().all(|of| of.source != "cell"));
}
