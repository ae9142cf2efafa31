//! A disk that stands still in the middle of a record: an emergency stop is obeyed all the same, and the line comes back. All
//! the while it takes nothing into the line's database either, for which nothing waits.
//!
//! ```text
//!   station      ── "a" is there, "b" runs ── record ··· (the disk stands) ··· estop ──▶ off      record ──▶ e-stop
//!   coordinator  ── auto, both run ── selector, record ··· (the disk stands) ··· estop ──▶ off      record ──▶ e-stop
//! ```

use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::gate::{Gate, Gates};
use crate::support::operator::Operator;
use crate::support::rig::{OWN_BUS, Rig};
use crate::support::wait_for;

const NAMES: &[&str] = &["jaws"];

/// Two jaws that close and open side by side, one of them slowly, on a bus of their own. Nothing here is too old before the disk
/// goes on.
fn line() -> String {
    let operation = |name: &str, axis: &str, (from, to): (u32, u32), seconds: f64, hand: &str, with: &str| {
        let on = |to: u32| format!("{axis}_{to}");
        format!(
            "[[station.operation]]\nname = \"{name}\"\nmodule = \"R\"\n\
             moves = {{ axis = \"{axis}\", from = {from}, to = {to} }}\nduration_s = {seconds:.1}\nwatchdog_s = 60.0\n\
             normal = {{ actuator = \"to_{to}_{axis}\", complete = \"{}\" }}\n\
             recovery = {{ actuator = \"to_{from}_{axis}\", complete = \"{}\" }}\n\
             hand = {hand}\n{with}\n",
            on(to),
            on(from)
        )
    };
    let last = "{ type = 6, forward = \"PB_go\", back = \"PB_back\", next = \"PB_go\" }";
    let operations = [
        operation("up", "z", (0, 100), 0.3, last, ""),
        operation("close a", "a", (0, 100), 1.0, last, ""),
        operation("close b", "b", (0, 100), 6.0, last, "with = \"close a\""),
        operation("open a", "a", (100, 0), 1.0, last, ""),
        operation("open b", "b", (100, 0), 6.0, last, "with = \"open a\""),
        operation("down", "z", (100, 0), 0.3, last, ""),
    ];
    format!(
        "name = \"jaws_line\"\nbuttons = [\"PB_go\", \"PB_back\"]\n\n\
         [[station]]\nname = \"jaws\"\nbus = \"{OWN_BUS}\"\nhome = \"down\"\naxes = {{ z = 0.0, a = 0.0, b = 0.0 }}\n\
         panel = {{ manual = \"SS_manual\", advance = \"PB_advance\", return = \"PB_return\" }}\n\n{}\n\
         [[device]]\nname = \"jaws io\"\nstation = \"jaws\"\nnode = 0x11\n\
         inputs = [\"z_0\", \"z_100\", \"a_0\", \"a_100\", \"b_0\", \"b_100\", \"SS_manual\", \"PB_advance\", \"PB_return\"]\n\
         outputs = [\"to_0_z\", \"to_100_z\", \"to_0_a\", \"to_100_a\", \"to_0_b\", \"to_100_b\"]\n\n\
         [timing]\nstale_ms = 6000\nlease_ms = 7000\nheartbeat_timeout_ms = 5000\n",
        operations.concat()
    )
}

#[test]
fn an_emergency_stop_does_not_wait_for_the_disk() {
    let mut rig = Rig::new(&line());
    let gates = Gates::build(&rig.state().with_file_name("gates"));
    for (name, value) in gates.environment() {
        rig.environment(name, value);
    }
    rig.start(&["--no-auto"]);
    let operator = Operator::join_line(&rig, "/jaws_line", NAMES);
    let database = gates.close("line.db-wal");
    operator.order("start", StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);

    rig.eye.wait("both jaws close", |seen| seen.output("jaws", "to_100_a") && seen.output("jaws", "to_100_b"));
    let gate = gates.close("jaws.journal");
    rig.eye.wait("the station waits for its disk", |seen| gate.is_reached() && !seen.output("jaws", "to_100_a"));
    assert!(rig.eye.seen().output("jaws", "to_100_b"), "the other jaw moves on");
    stops_with(&rig, &operator, gate);
    comes_back(&rig, &operator);

    rig.eye.wait("a jaw moves", |seen| seen.output("jaws", "to_100_b") || seen.output("jaws", "to_0_b"));
    let gate = gates.close("coordinator.journal");
    operator.select("jaws", "manual");
    rig.eye.wait("the coordinator waits for its disk", |_| gate.is_reached());
    assert!(!rig.eye.seen().energised().is_empty(), "the jaw moves on");
    stops_with(&rig, &operator, gate);
    operator.select("jaws", "auto");
    comes_back(&rig, &operator);
    assert!(database.is_reached(), "the database has waited for its disk");
    drop(database);
    let has_all = || {
        let reported: serde_json::Value = serde_json::from_str(&rig.reported(&["--json"])).expect("JSON");
        let stops = reported["stops"].as_array().expect("a list");
        stops.iter().any(|stop| stop["kind"] == "emergency stop" && stop["times"] == 2)
    };
    assert!(wait_for(Duration::from_secs(20), has_all), "{}", rig.reported(&["--json"]));
}

/// The outputs go off while the disk stands; then it goes on.
fn stops_with(rig: &Rig, operator: &Operator, gate: Gate) {
    operator.say("estop");
    rig.eye.within(Duration::from_millis(2500), "every output off", |seen| seen.energised().is_empty());
    drop(gate);
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
}

fn comes_back(rig: &Rig, operator: &Operator) {
    operator.say("reset");
    operator.recover();
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}
