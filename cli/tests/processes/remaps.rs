//! A line under another namespace: the same remap for every node, and for whoever operates it.

use linewright_msgs::StationState;

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};

const REMAP: [&str; 3] = ["--ros-args", "-r", "__ns:=/hall_2/transfer_line"];

#[test]
fn a_line_in_another_namespace_is_operated_there() {
    let mut rig = Rig::new(&line(0.3));
    let mut options = REMAP.to_vec();
    // What follows is the command's own again, and none of its nodes' business.
    options.extend(["--", "--no-auto"]);
    rig.start(&options);
    let operator = Operator::join_as(&rig, "/hall_2/transfer_line");

    let start = rig.command(&["mode"], &["start", REMAP[0], REMAP[1], REMAP[2]]).output().expect("the command starts");
    assert!(start.status.success(), "{start:?}");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    let nobody = rig.command(&["mode"], &[]).output().expect("the command starts");
    assert!(!nobody.status.success(), "nobody is in the line's own namespace: {nobody:?}");

    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    operator.go_home();
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!(code, 0, "{report}");
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}
