//! The thread of a cell: a log that is not read does not hold it up, and where it stands still the process ends with outputs
//! off, and is started again.

use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::faster::faster;
use crate::support::gate::Gates;
use crate::support::operator::Operator;
use crate::support::rig::{Rig, TIMING};
use crate::support::wait_for;

const LONG: Duration = Duration::from_secs(90);

/// The assembly cell, four times as fast.
fn cell() -> Rig {
    let file = |file: &str| {
        let path = format!("{}/../launch-config/lines/assembly-cell/{file}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
    };
    let rig = Rig::new(&(faster(&file("line.toml"), 4.0) + TIMING));
    rig.file("cell.toml", &faster(&file("cell.toml"), 4.0));
    rig
}

#[test]
fn a_cell_makes_its_parts_while_its_log_is_a_full_pipe_that_is_not_read() {
    let mut rig = cell();
    let _unread = rig.log_into_a_full_pipe("coordinator");
    rig.start(&["--parts", "1=2", "--patience", "80"]);
    let (code, report) = rig.ended_within(LONG);
    assert_eq!((code, &report["parts_made"]), (0, &2.into()), "{report}");
}

/// The cell's thread waits for a disk that stands still, for ever. The coordinator's own loop goes on meanwhile: it is the watchdog
/// of that thread that ends the process.
#[test]
fn a_coordinator_whose_cell_stands_still_ends_and_is_started_again() {
    let mut rig = cell();
    let gates = Gates::build(&rig.state().with_file_name("gates"));
    for (name, value) in gates.environment() {
        rig.environment(name, value);
    }
    rig.start(&["--no-auto"]);
    let operator = Operator::join_line(&rig, "/assembly_cell", &["robot_1", "robot_2", "human"]);
    operator.order("start", StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);
    let before = operator.heard().line.boot_id;
    let gate = gates.close("cell.log.1");
    rig.said(&["order"], &["submit", "1", "--name", "first"]).expect_err("its reply waits for the disk");
    assert!(gate.is_reached(), "the cell's thread waits for its disk");
    assert_eq!(operator.heard().line.boot_id, before, "the line goes on meanwhile");
    let stood =
        wait_for(LONG, || rig.log("coordinator").contains("the cell's thread has stood still for 10 s; it ends"));
    assert!(stood, "{}", rig.log("coordinator"));
    drop(gate);
    operator.wait("another coordinator", |heard| heard.line.boot_id != before);
    rig.eye.within(LONG, "every output off", |seen| seen.energised().is_empty());
    rig.signal("INT");
    let (_, report) = rig.ended_within(LONG);
    assert!(report["restarts"].as_u64().is_some_and(|restarts| restarts >= 1), "{report}");
}
