//! Snapshots of a station as records of its journal.

use std::time::Duration;

use linewright_line::{Line, OpId, StationId, TaskId, Tick, parse};
use linewright_station_logic::{
    Controller, LeaveWay, OrderKey, Restore, StationInput, StationSnapshot, TaskCommand, TaskFailure, TaskOrder,
    TaskOutcome, TaskRefusal, TaskReply,
};
use linewright_station_node::{from_record, to_record};

const TASK_DRIVEN: &str = include_str!("../../../model/line/tests/descriptions/task_driven.toml");
const CYCLIC: &str = include_str!("../../../model/line/tests/descriptions/cell.toml");

/// Final refusals; others are not kept.
const KEPT_REFUSALS: [TaskRefusal; 5] =
    [TaskRefusal::Late, TaskRefusal::NotThere, TaskRefusal::Devices, TaskRefusal::Unknown, TaskRefusal::Incomplete];

fn line(text: &str) -> Line {
    parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

fn snapshot(line: &Line) -> StationSnapshot {
    let mut controller = Controller::new(line, StationId(0), 7, Restore::Fresh).expect("it compiles");
    // Not in auto: refused for now, which is not kept; the order to be left is.
    let order = TaskOrder {
        key: OrderKey { epoch: 2, id: 5 },
        memory: 7,
        task: "clamp".into(),
        parameters: Vec::new(),
        limit: Duration::from_secs(1),
    };
    for command in [TaskCommand::Run(&order), TaskCommand::Leave(order.key, LeaveWay::Back)] {
        controller.handle(Tick::ZERO, StationInput::Task(command));
    }
    // Its devices have confirmed where it stands.
    StationSnapshot { placed: true, ..controller.snapshot() }
}

#[test]
fn a_record_gives_back_what_was_kept_of_orders() {
    let line = line(TASK_DRIVEN);
    let mut kept = snapshot(&line);
    let orders = kept.order.as_mut().expect("it is task-driven");
    assert_eq!((orders.memory, orders.epoch, orders.last, orders.results.len()), (7, 2, 5, 1));
    orders.slot = Some(OrderKey { epoch: 2, id: 6 });
    orders.secured = Some(OrderKey { epoch: 2, id: 4 });
    let failures = [1, 999, 1000, 1001, 1002, 1003, 1004, 1005, 1006].map(TaskFailure::from_code);
    let ends = failures.map(|failure| TaskReply::Ended(TaskOutcome::Failed(failure)));
    let replies = [TaskReply::Ended(TaskOutcome::Done)].into_iter().chain(ends);
    let replies = replies.chain(KEPT_REFUSALS.map(TaskReply::Refused));
    orders.results = replies.enumerate().map(|(id, reply)| (OrderKey { epoch: 2, id: id as u64 }, reply)).collect();
    let record = to_record(&line, StationId(0), &kept, "host");
    assert_eq!(from_record(&line, StationId(0), &record, "host").expect("its own record"), kept);
    for refusal in KEPT_REFUSALS {
        assert!(!refusal.is_passing(), "{refusal:?} is not kept");
    }
}

#[test]
fn the_records_of_other_stations_are_what_they_were_before_there_were_orders() {
    let line = line(CYCLIC);
    let kept = snapshot(&line);
    let record = String::from_utf8(to_record(&line, StationId(0), &kept, "host")).expect("text");
    assert_eq!(
        record,
        r#"{"station":"feeder","operations":["push","pull back"],"marking":[[1,3]],"cycle":0,"done":[0,0],"started":[0,0],"path":null,"next_request":1,"generation":0,"placed":true,"host":"host"}"#
    );
    assert_eq!(from_record(&line, StationId(0), record.as_bytes(), "host").expect("its own record"), kept);
}

#[test]
fn the_doubt_of_an_index_is_kept() {
    let line = line(include_str!("../../../examples/rotary-table.toml"));
    let mut kept = snapshot(&line);
    let without = to_record(&line, StationId(0), &kept, "host");
    assert!(!String::from_utf8_lossy(&without).contains("doubtful"), "as before there were any");
    assert_eq!(from_record(&line, StationId(0), &without, "host").expect("its own record").doubtful, None);
    kept.doubtful = Some(OpId(0));
    let with = to_record(&line, StationId(0), &kept, "host");
    // Also where it is not the newest record: one needless inspection.
    for host in ["host", "another start"] {
        assert_eq!(from_record(&line, StationId(0), &with, host).expect("its own record").doubtful, Some(OpId(0)));
    }
}

#[test]
fn the_place_of_an_axis_that_a_drive_turns_is_kept() {
    let line = line(include_str!("../../../examples/driven-table.toml"));
    let mut kept = snapshot(&line);
    kept.place = 3;
    let record = to_record(&line, StationId(0), &kept, "host");
    // Also where it is not the newest record: what it says is compared with what is measured.
    for host in ["host", "another start"] {
        assert_eq!(from_record(&line, StationId(0), &record, host).expect("its own record").place, 3);
    }
}

#[test]
fn the_parameters_of_the_last_order_are_kept() {
    let line = line(TASK_DRIVEN);
    let mut kept = snapshot(&line);
    let order = kept.order.as_mut().expect("it is task-driven");
    order.parameters = Some((TaskId(1), 1 << 127 | 5));
    let record = to_record(&line, StationId(0), &kept, "host");
    assert_eq!(from_record(&line, StationId(0), &record, "host").expect("its own record"), kept);
}

#[test]
fn a_record_that_contradicts_itself_is_refused_as_a_record() {
    let line = line(CYCLIC);
    let record = String::from_utf8(to_record(&line, StationId(0), &snapshot(&line), "host")).expect("text");
    for (from, to) in [(r#""started":[0,0]"#, r#""started":[-3,0]"#), (r#""cycle":0"#, r#""cycle":2147483647"#)] {
        let text = record.replace(from, to);
        assert_ne!(text, record);
        let error = from_record(&line, StationId(0), text.as_bytes(), "host").expect_err("refused").to_string();
        assert!(error.contains("feeder") && error.contains("counts contradict each other"), "{error}");
    }
}

#[test]
fn a_record_from_before_the_hosts_last_start_has_no_generation() {
    let line = line(CYCLIC);
    let mut kept = snapshot(&line);
    kept.generation = 9;
    let record = to_record(&line, StationId(0), &kept, "this start");
    let read = |host: &str| {
        let read = from_record(&line, StationId(0), &record, host).expect("its own record");
        (read.generation, read.placed)
    };
    assert_eq!([read("this start"), read("another start"), read("")], [(9, true), (0, false), (0, false)]);
    // A record from before there were generations.
    let old = r#"{"station":"feeder","operations":["push","pull back"],"marking":[[1,3]],"cycle":0,"done":[0,0],"started":[0,0],"path":null,"next_request":1}"#;
    assert_eq!(from_record(&line, StationId(0), old.as_bytes(), "this start").expect("it fits").generation, 0);
}

/// The numbers may be those of the order before: the hand would open over another place.
#[test]
fn a_record_from_before_the_hosts_last_start_has_no_parameters() {
    let line = line(TASK_DRIVEN);
    let mut kept = snapshot(&line);
    kept.order.as_mut().expect("it is task-driven").parameters = Some((TaskId(0), 3));
    let record = to_record(&line, StationId(0), &kept, "this start");
    let read = |host: &str| {
        let read = from_record(&line, StationId(0), &record, host).expect("its own record");
        read.order.expect("it is task-driven").parameters
    };
    assert_eq!([read("this start"), read("another start"), read("")], [Some((TaskId(0), 3)), None, None]);
}

#[test]
fn a_record_without_orders_is_not_one_of_a_task_driven_station_nor_the_other_way_round() {
    let line = line(TASK_DRIVEN);
    let mut kept = snapshot(&line);
    let with = String::from_utf8(to_record(&line, StationId(0), &kept, "host")).expect("text");
    kept.order = None;
    let without = to_record(&line, StationId(0), &kept, "host");
    let refused = |record: &[u8]| from_record(&line, StationId(0), record, "host").expect_err("refused").to_string();
    assert!(refused(&without).contains("belongs to another description (orders)"));
    for odd in ["1007", "-1", "fine", ""] {
        let text = with.replace("\"1004\"", &format!("\"{odd}\""));
        assert_ne!(text, with);
        assert!(refused(text.as_bytes()).contains("(orders)"), "{odd}");
    }
}
