//! Logs that cannot be written, or that are not read: the line runs all the same.

use std::path::Path;

use crate::support::rig::{Rig, line};

#[test]
fn a_line_runs_its_cycles_with_logs_that_are_full_or_not_read() {
    let mut rig = Rig::new(&line(0.3));
    for name in ["plant", "coordinator", "transfer"] {
        rig.log_into(name, Path::new("/dev/full"));
    }
    let _unread = ["clamp_1", "mill_1"].map(|name| rig.log_into_a_full_pipe(name));
    rig.start(&["--cycles", "2"]);
    let (code, report) = rig.ended();
    assert_eq!((code, &report["cycles"], &report["restarts"]), (0, &2.into(), &0.into()), "{report}");
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}
