//! The Python package `canopen` on the other side, both ways: as manager of the simulated devices, and as a device that
//! our manager boots from its EDS and runs.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::pause;
use crate::{BUS, Beside, TIMING, line_of, linewright, no_bus, own};

const CYCLES: usize = 3;

/// An interpreter that has the packages; prints a message if there is none.
fn python() -> Option<String> {
    let python = std::env::var("LINEWRIGHT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut command = Command::new(&python);
    let has = command.args(["-c", "import can, canopen"]).stderr(Stdio::null()).status();
    if has.is_ok_and(|status| status.success()) {
        return Some(python);
    }
    println!("SKIPPED: no Python with canopen here (pip install canopen python-can; LINEWRIGHT_PYTHON)");
    None
}

#[test]
fn a_foreign_manager_accepts_our_devices() {
    let Some(python) = (if no_bus() { None } else { python() }) else { return };
    let (_directory, line) = line_of(&(linewright_line::TransferLine::default().text() + TIMING), &[]);
    let _plant = Beside::start(linewright(&["plant", &line, "--bus", BUS]).stdout(Stdio::null()));
    pause(1500);
    let devices = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/devices");
    let ended = Command::new(python).arg(own("foreign_manager.py")).arg(BUS).arg(devices).output().expect("it runs");
    let (said, error) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
    println!("{said}");
    assert!(ended.status.success() && said.trim_end().ends_with("OK"), "{said}{error}");
}

/// Our manager, a line of one station, and an independent device; `eds` describes the device, which need not be the one
/// that the line expects. Gives whether the run succeeded, the writes to the device, and the coordinator's log.
fn runs_with_a_foreign_device(python: &str, change: impl Fn(String) -> String) -> (bool, Vec<String>, String) {
    let text = std::fs::read_to_string(own("foreign-device.toml")).expect("a description") + TIMING;
    let (directory, line) = line_of(&text, &["foreign-device.eds"]);
    let eds = directory.path().join("what-it-is.eds");
    let original = std::fs::read_to_string(own("foreign-device.eds")).expect("an EDS");
    std::fs::write(&eds, change(original)).expect("a file");
    let mut device = Command::new(python);
    device.arg(own("foreign_device.py")).args([BUS, "9"]).arg(eds).stdout(Stdio::piped());
    let mut device = Beside::start(&mut device);
    pause(1500);
    let state = directory.path().join("state");
    let shown = state.display().to_string();
    let cycles = CYCLES.to_string();
    let mut args = vec!["run", &line, "--no-plant", "--bus", BUS, "--cycles", &cycles, "--json"];
    args.extend(["--state-dir", &shown, "--patience", "40"]);
    let ended = linewright(&args).stdin(Stdio::null()).output().expect("it runs");
    drop(device.0.stdin.take());
    let mut said = String::new();
    device.0.stdout.take().expect("its output").read_to_string(&mut said).expect("text");
    let log = std::fs::read_to_string(state.join("coordinator.log")).unwrap_or_default();
    println!("{}{said}", String::from_utf8_lossy(&ended.stderr));
    (ended.status.success(), said.lines().map(str::to_owned).collect(), log)
}

#[test]
fn our_manager_boots_a_foreign_device_from_its_eds_and_runs_it() {
    let Some(python) = (if no_bus() { None } else { python() }) else { return };
    let (succeeded, told, log) = runs_with_a_foreign_device(&python, |eds| eds);
    assert!(succeeded, "{told:?}\n{log}");
    let place = |what: &str| told.iter().position(|line| line.starts_with(what));
    let started = place("state OPERATIONAL").expect("it was started");
    let lets_go = ["written 1029:01 00", "written 6206:01 ff", "written 6207:01 00"];
    for setting in
        ["written 2100:00 0f000000", "written 1017:00 f401", "written 1016:01 88137f00"].iter().chain(&lets_go)
    {
        assert!(place(setting).is_some_and(|at| at < started), "{setting} before it was started: {told:?}");
    }
    let motions: Vec<&str> =
        told.iter().map(String::as_str).filter(|l| ["outputs 1", "outputs 2"].contains(l)).collect();
    assert_eq!(motions, ["outputs 1", "outputs 2"].repeat(CYCLES), "out and back, {CYCLES} times");
}

#[test]
fn our_manager_starts_no_foreign_device_that_is_another_than_its_eds_says() {
    let Some(python) = (if no_bus() { None } else { python() }) else { return };
    let (succeeded, told, log) =
        runs_with_a_foreign_device(&python, |eds| eds.replace("DefaultValue=0x808", "DefaultValue=0x809"));
    assert!(!succeeded);
    assert!(!told.iter().any(|line| line.starts_with("written") || line == "state OPERATIONAL"), "{told:?}");
    assert!(log.contains("1018h:02"), "{log}");
}
