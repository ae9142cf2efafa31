//! The shipped line over a real bus, with `candump` as its witness.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use linewright_line::TransferLine;

use crate::support::chart::starts_follow_the_chart;
use crate::support::eye::Seen;
use crate::support::pause;
use crate::support::plan::Plan;
use crate::{BUS, Beside, line_of, linewright, no_bus, patient};

/// Number of cycles.
const CYCLES: usize = 3;

/// The frames judged here are received and read by none of our code.
#[test]
fn cycles_seen_by_an_independent_listener() {
    if no_bus() {
        return;
    }
    let text = patient(&TransferLine::default().text());
    let (directory, line) = line_of(&text, &[]);
    let log = directory.path().join("candump.log");
    let file = File::create(&log).expect("a file");
    let candump = Beside::start(Command::new("candump").args(["-L", BUS]).stdout(file));
    pause(500);
    let state = directory.path().join("state").display().to_string();
    let cycles = CYCLES.to_string();
    let mut run = linewright(&["run", &line, "--bus", BUS, "--cycles", &cycles, "--json", "--state-dir", &state]);
    // That five participants find each other can take half a minute of a guest's one processor.
    run.args(["--patience", "150"]);
    let ended = run.stdin(Stdio::null()).output().expect("it runs");
    pause(500);
    drop(candump);
    let (said, error) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
    assert!(ended.status.success(), "{said}{error}");
    let report: serde_json::Value = serde_json::from_slice(&ended.stdout).expect("a report");
    assert_eq!((&report["cycles"], &report["restarts"]), (&CYCLES.into(), &0.into()), "{report}");

    let plan = Plan::of(&text);
    let seen = Seen::of_log(plan.clone(), &fs::read_to_string(&log).expect("the recording"));
    assert_eq!(seen.conflicts(), [""; 0]);
    starts_follow_the_chart(seen.starts(), CYCLES);
    for operation in &plan.operations {
        assert_eq!(seen.arrivals(&operation.station, &operation.name), CYCLES as i32, "{operation:?}");
    }
    assert_eq!(seen.energised(), [""; 0], "at the end everything is off");
    println!("{CYCLES} cycles: candump saw {} frames; a cycle took {}", seen.frames(), report["cycle_time_s"]);
}
