//! `linewright can` as a technician meets it: simulated devices on a virtual bus of the test's own, and no manager.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::support::command::{Scratch, json, shipped, text};
use crate::support::turn::{Turn, beside_no_rig};

/// The shipped line's devices, on a bus of their own.
struct Devices {
    plant: Child,
    scratch: Scratch,
    _no_rig: Turn,
}

impl Devices {
    fn new() -> Self {
        Devices::of(&shipped())
    }

    fn of(line: &Path) -> Self {
        let (scratch, no_rig) = (Scratch::new(), beside_no_rig());
        let plant = Command::new(env!("CARGO_BIN_EXE_linewright"))
            .args(["plant", "--bus", "test0", "--virtual-bus", "--end-with-stdin"])
            .arg(line)
            .env("LINEWRIGHT_BUS_DIR", scratch.path("bus"))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the plant starts");
        let devices = Devices { plant, scratch, _no_rig: no_rig };
        let patience = Instant::now() + Duration::from_secs(20);
        while json(&devices.can(&["scan", "--wait", "300", "--json"]))["nodes"].as_array().is_none_or(Vec::is_empty) {
            assert!(Instant::now() < patience, "no device is there");
        }
        devices
    }

    fn can(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
        let bus: &[&str] = if args.contains(&"--bus") { &[] } else { &["--bus", "test0"] };
        command.arg("can").args(bus).args(args).env("LINEWRIGHT_BUS_DIR", self.scratch.path("bus"));
        command.output().expect("the command starts")
    }

    /// Output of a command that succeeds.
    fn says(&self, args: &[&str]) -> String {
        let output = self.can(args);
        assert!(output.status.success(), "{args:?}: {output:?}");
        text(&output.stdout).trim_end().to_owned()
    }

    /// Error text of a command that fails.
    fn refuses(&self, args: &[&str]) -> String {
        let output = self.can(args);
        assert!(!output.status.success(), "{args:?}: {output:?}");
        // Messages are wrapped to the width of a screen.
        text(&output.stderr).replace("\n  │", "")
    }
}

impl Drop for Devices {
    fn drop(&mut self) {
        // Its standard input ends, and with it the plant.
        drop(self.plant.stdin.take());
        let _ = self.plant.wait();
    }
}

#[test]
fn a_scan_finds_every_device_and_what_it_is() {
    let devices = Devices::new();
    let found = json(&devices.can(&["scan", "--json"]));
    let nodes: Vec<_> = found["nodes"].as_array().expect("a list").iter().collect();
    let ids: Vec<u64> = nodes.iter().map(|node| node["node"].as_u64().expect("a number")).collect();
    assert_eq!(ids, [1, 17, 33, 34, 35, 36]);
    assert!(
        nodes[..4].iter().all(|node| node["device_type"] == 0x0003_0191 && node["state"] == "pre-operational"),
        "{found}"
    );
    let shown = devices.says(&["scan"]);
    assert!(shown.contains("CiA 401 I/O: digital inputs, digital outputs"), "{shown}");
}

/// `candump` and `can monitor` remark on it as well.
#[test]
fn a_bus_on_which_nothing_is_sent_is_named() {
    let scratch = Scratch::new();
    let output = Command::new(env!("CARGO_BIN_EXE_linewright"))
        .args(["can", "--bus", "test1", "record", &scratch.path("none.log"), "--seconds", "3"])
        .env("LINEWRIGHT_BUS_DIR", scratch.path("bus"))
        .output()
        .expect("the command starts");
    let said = text(&output.stderr);
    assert!(said.contains("nothing was received in 2 s on") && said.contains("LINEWRIGHT_BUS_DIR"), "{output:?}");
    assert_eq!(said.matches("nothing was received").count(), 1, "{said}");
}

#[test]
fn status_says_how_each_device_of_the_line_is() {
    let devices = Devices::new();
    let line = shipped().to_str().expect("a plain path").to_owned();
    let output = devices.can(&["status", &line, "--json"]);
    assert_eq!(output.status.code(), Some(1), "nothing is operational without a manager");
    let nodes = json(&output)["nodes"].clone();
    assert_eq!((&nodes[1]["name"], &nodes[1]["operational"]), (&"transfer io".into(), &false.into()));
    assert!(nodes[1]["is"].as_str().is_some_and(|is| is.starts_with("pre-operational, a heartbeat every")), "{nodes}");
    let table = devices.can(&["status", &line]);
    let missing = "no manager on the bus test0 (node 7Fh), so devices are not started: the coordinator is missing";
    assert!(text(&table.stdout).contains(missing), "{table:?}");
    // Another line has devices with the same node ids.
    let other = std::fs::read_to_string(shipped().join("line.toml")).expect("the shipped line is there");
    let other = devices.scratch.file("line.toml", &other.replacen("\"transfer_line\"", "\"other_line\"", 1));
    let refused = devices.refuses(&["status", &other]);
    assert!(refused.contains("and this command is for line /other_line"), "{refused}");
    // A bus on which nothing is.
    let silent = devices.can(&["--bus", "test1", "status", &line]);
    assert!(text(&silent.stdout).contains("neither plant nor coordinator of line /transfer_line"), "{silent:?}");
    devices.says(&["nmt", "start", "all"]);
    let after = devices.can(&["status", &line, "--json"]);
    assert_eq!(json(&after)["ok"], true, "{after:?}");
}

/// A line of which one station has a bus of its own.
#[test]
fn status_asks_the_devices_on_every_bus_of_the_line() {
    let described = Path::new(env!("CARGO_MANIFEST_DIR")).join("../model/line/tests/descriptions/cell.toml");
    let scratch = Scratch::new();
    // By its old name it would be taken for a cell's.
    let line = scratch.file("line.toml", &std::fs::read_to_string(described).expect("it is there"));
    let line = Path::new(&line);
    let devices = Devices::of(line);
    let status = || devices.can(&["status", line.to_str().expect("a plain path"), "--json"]);
    let told = json(&status());
    let of_bus = |bus: &str| told["nodes"].as_array().expect("a list").iter().filter(|node| node["bus"] == bus).count();
    assert!(of_bus("test0") > 0 && of_bus("can1") > 0, "{told}");
    // All of the line's bus are operational, none of the other.
    devices.says(&["nmt", "start", "all"]);
    let output = status();
    assert_eq!((output.status.code(), &json(&output)["ok"]), (Some(1), &false.into()), "{output:?}");
    devices.says(&["--bus", "can1", "nmt", "start", "all"]);
    let output = status();
    assert_eq!((output.status.code(), &json(&output)["ok"]), (Some(0), &true.into()), "{output:?}");
}

#[test]
fn an_order_is_given_and_its_effect_waited_for() {
    let devices = Devices::new();
    assert_eq!(devices.says(&["nmt", "start", "17"]), "node 11h: operational");
    assert_eq!(devices.says(&["nmt", "stop", "0x11"]), "node 11h: stopped");
    assert_eq!(devices.says(&["nmt", "reset-node", "11h"]), "node 11h: booted");
    let all = devices.says(&["nmt", "pre-operational", "all"]);
    assert_eq!(all.lines().count(), 6, "{all}");
    let nobody = devices.refuses(&["nmt", "start", "99"]);
    assert!(nobody.contains("node 63h: state operational not reached"), "{nobody}");
    assert_eq!(devices.can(&["nmt", "start", "128"]).status.code(), Some(2));
}

#[test]
fn objects_are_read_and_written() {
    let devices = Devices::new();
    assert_eq!(devices.says(&["sdo", "read", "17", "1000"]), "197009 (00030191h; bytes 91 01 03 00)");
    assert_eq!(devices.says(&["sdo", "read", "17", "1017", "--type", "u16"]), "50");
    devices.says(&["sdo", "write", "17", "1017:00", "100", "--type", "u16"]);
    assert_eq!(devices.says(&["sdo", "read", "17", "1017", "--type", "u16"]), "100");
    let short = devices.refuses(&["sdo", "write", "17", "1017", "100", "--type", "u8"]);
    assert!(short.contains("object 1017h:00: refused: 06070"), "{short}");
    let missing = devices.refuses(&["sdo", "read", "17", "7777"]);
    assert!(missing.contains("object 7777h:00: refused: 06020000h"), "{missing}");
    let nobody = devices.refuses(&["sdo", "read", "99", "1000", "--timeout", "50"]);
    assert!(nobody.contains("node 63h, object 1000h:00: no answer within 50 ms"), "{nobody}");
    let wide = devices.refuses(&["sdo", "write", "17", "1017", "70000", "--type", "u16"]);
    assert!(wide.contains("70000 does not fit 2 bytes"), "{wide}");
}

#[test]
fn what_was_recorded_is_sent_again() {
    let devices = Devices::new();
    let log = devices.scratch.path("bus.log");
    let said = devices.says(&["record", &log, "-n", "12"]);
    assert!(said.starts_with("12 frames"), "{said}");
    let lines = std::fs::read_to_string(&log).expect("the recording");
    assert!(lines.lines().all(|line| line.starts_with('(') && line.contains(") test0 7")), "{lines}");
    assert!(devices.refuses(&["record", &log, "-n", "1"]).contains("cannot write"), "a recording is not overwritten");
    let said = devices.says(&["replay", &log, "--speed", "10"]);
    assert!(said.starts_with("12 of 12 frames sent"), "{said}");
    let bad = devices.scratch.file("bad.log", &format!("{lines}(1.5) test0 nonsense\n"));
    let refused = devices.refuses(&["replay", &bad]);
    assert!(refused.contains("bad.log:13: "), "{refused}");
    assert!(devices.refuses(&["replay", &log, "--from", "can7"]).contains("has no frame of can7"));
}

#[test]
fn the_monitor_says_what_frames_mean() {
    let devices = Devices::new();
    let line = shipped().to_str().expect("a plain path").to_owned();
    let said = devices.says(&["monitor", "-n", "8", "--line", &line]);
    assert!(said.contains("transfer io: pre-operational"), "{said}");
}
