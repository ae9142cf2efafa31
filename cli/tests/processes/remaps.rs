//! A line under another namespace, by the same remap for every node and every operator; its logs cannot be written, or
//! are not read.

use std::path::Path;
use std::process::Stdio;

use linewright_msgs::StationState;

use crate::support::operator::{Operator, STATIONS};
use crate::support::rig::{Rig, line};

const REMAP: [&str; 3] = ["--ros-args", "-r", "__ns:=/hall_2/transfer_line"];

#[test]
fn a_line_in_another_namespace_is_operated_there_and_runs_without_its_logs() {
    let mut rig = Rig::new(&line(0.3));
    for name in ["plant", "coordinator", "transfer"] {
        rig.log_into(name, Path::new("/dev/full"));
    }
    let _unread = ["clamp_1", "mill_1"].map(|name| rig.log_into_a_full_pipe(name));
    let mut options = REMAP.to_vec();
    // Arguments after `--` are options of the command again.
    options.extend(["--", "--no-auto"]);
    rig.start(&options);
    let operator = Operator::join_line(&rig, "/hall_2/transfer_line", &STATIONS);

    let start = rig.command(&["mode"], &["start", REMAP[0], REMAP[1], REMAP[2]]).output().expect("the command starts");
    assert!(start.status.success(), "{start:?}");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    // It listens for seconds; the line runs meanwhile.
    let elsewhere = rig.command(&["mode"], &[]).stderr(Stdio::piped()).spawn().expect("the command starts");

    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    operator.go_home();
    let nobody = elsewhere.wait_with_output().expect("a child");
    assert!(!nobody.status.success(), "nobody is in the line's own namespace: {nobody:?}");
    rig.ends_well(0);
}
