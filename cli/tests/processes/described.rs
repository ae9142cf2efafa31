//! The description written by `linewright new`, run as it is: stations of a type among them.

use std::time::Duration;

use crate::support::command::Scratch;
use crate::support::rig::{Rig, TIMING};

/// A rig for what `new` has written. The observer reads no station types, so it has them written out.
fn rig(kind: &str) -> (Scratch, Rig) {
    let scratch = Scratch::new();
    let dir = scratch.path("made");
    let made = std::process::Command::new(env!("CARGO_BIN_EXE_linewright"))
        .args(["new", kind, "--name", "made_by_hand", "--dir", &dir])
        .output()
        .expect("the command starts");
    assert!(made.status.success(), "{made:?}");
    // Images may be a second old here, and an index takes more than twice that.
    let slow = scratch.read("made/line.toml").replace("duration_s = 1.0  #", "duration_s = 2.5  #");
    let text = slow.replace("watchdog_s = 1.8  #", "watchdog_s = 4.5  #") + TIMING;
    assert!(text.contains("[[station_type]]") && text.contains("name = \"made_by_hand\""), "{text}");
    let rig = Rig::new(&linewright_line::expand("line.toml", &text).expect("types are right"));
    rig.file("line.toml", &text);
    (scratch, rig)
}

#[test]
fn a_new_rotary_table_runs_its_cycles() {
    let (_scratch, mut rig) = rig("rotary-table");
    rig.start(&["--cycles", "3"]);
    let (code, report) = rig.ended();
    assert_eq!((code, &report["line"], &report["cycles"]), (0, &"made_by_hand".into(), &3.into()), "{report}");
    assert_eq!((&report["mode"], &report["restarts"]), (&"home".into(), &0.into()), "{report}");
    let seen = rig.eye.seen();
    assert_eq!(seen.conflicts(), [""; 0]);
    for unit in ["load", "drill", "ream", "unload"] {
        assert_eq!(seen.arrivals(unit, "advance"), 3, "{unit}");
    }
    assert_eq!(seen.arrivals("table", "index"), 3);
    // No unit is at a table that turns.
    let turning = seen.starts().iter().filter(|start| start.what == "table: turn");
    let at_it = |what: &String| what.ends_with(": forward") || what.ends_with(": back");
    assert!(turning.clone().count() == 3 && turning.flat_map(|start| &start.beside).all(|what| !at_it(what)));
}

#[test]
fn a_new_cell_makes_its_parts() {
    let (scratch, mut rig) = rig("cell");
    rig.file("cell.toml", &scratch.read("made/cell.toml"));
    rig.start(&["--parts", "bowl=2", "--patience", "140"]);
    let (code, report) = rig.ended_within(Duration::from_secs(150));
    assert_eq!((code, &report["parts_made"], &report["parts_wanted"]), (0, &2.into(), &2.into()), "{report}");
    let seen = rig.eye.seen();
    assert_eq!((seen.arrivals("washer", "work"), seen.arrivals("dryer", "work")), (2, 2));
}
