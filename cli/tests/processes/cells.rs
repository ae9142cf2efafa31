//! Flexible cells of real processes: seed 001's story of a failed loading, and processes killed while parts are inside.
//!
//! ```text
//!   run ──▶ plant, coordinator, stations          what an operator does: `order`, `answer`, `resource`, and a panel
//!   a part missing in the gripper ── watchdog ──▶ secured ──▶ alarm ──▶ answer ──▶ loaded again
//!   coordinator ✝ ✝ ✝, station ✝                  every part that was ordered is made, once
//! ```
//!
//! That nothing is lost or done twice wherever a coordinator is killed is shown in virtual time, at every record and every
//! message. Here it is the signal, the file and the process.

use std::time::Duration;

use linewright_msgs::{OrderState, RunTask, RunTaskGoal, RunTaskResult, StationState};
use linewright_node_shell::{GoalOutcome, Mapping, Participant, RosArgs, qos};
use tokio::time::timeout;

use crate::support::eye::Seen;
use crate::support::faster::faster;
use crate::support::operator::Operator;
use crate::support::rig::{BUS, Rig, TIMING};
use crate::support::wait_for;

pub const LONG: Duration = Duration::from_secs(90);

/// What can be answered when the robot has grasped nothing, and when it came to machine 1 without the part.
const ANSWERS: &str =
    "Answers: in-store (once more, part at ST; not measured: look at ST), scrap (part gone; not measured: look at ST)";
const IN_MACHINE: &str = ", in-machine (done, part at M1; contradicts the sensors: M1: part expected, sensor off)";

/// A shipped cell, so many times as fast.
pub fn cell(name: &str, times: f64) -> Rig {
    let file = |file: &str| {
        let path = format!("{}/../launch-config/lines/{name}/{file}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
    };
    let rig = Rig::new(&(faster(&file("line.toml"), times) + TIMING));
    rig.file("cell.toml", &faster(&file("cell.toml"), times));
    rig
}

/// Waits until a command prints this; gives all its output then.
fn until(rig: &Rig, words: &[&str], holds: impl Fn(&str) -> bool) -> String {
    let mut said = String::new();
    let came = wait_for(LONG, || {
        said = rig.said(words, &[]).unwrap_or_else(|error| error);
        holds(&said)
    });
    assert!(came, "`linewright {}` says at last: {said}", words.join(" "));
    said
}

/// Whether this line of `order` is there with all parts made.
fn is_made(said: &str, name: &str) -> bool {
    said.lines().any(|line| line.contains(&format!(" {name} ")) && line.contains("1 of 1 "))
}

/// The robot grasps nothing, which the sensor in its hand shows: the alarm is answered after the part was put back, the marking is
/// restored, and the part is loaded again. Seed 001, §6 (L227-229): the robot comes to the machine without the part, the watchdog
/// fires, and the resources are secured.
#[test]
fn a_part_that_was_not_grasped_is_loaded_after_it_was_put_back_and_one_that_fell_is_lost() {
    let mut rig = cell("workcell-c1", 8.0);
    // The watchdog of a loading that takes 3 s.
    rig.change("cell.toml", &[("max_s = 24", "max_s = 8"), ("max_s = 26", "max_s = 9")]);
    rig.start(&["--parts", "A=1", "--patience", "140"]);
    let missed = || rig.said(&["fail"], &["robot", "miss", "--operation", "grasp for m1", "--bus", BUS]).is_ok();
    assert!(wait_for(LONG, missed), "the gripper can be made to miss");

    let alarm = until(&rig, &["answer"], |said| said.contains("alarm 1:"));
    // The production order has the number of the run in its name.
    for part in [
        "R grasped no part at slot 1 of ST. Put part 1 (order A of run ",
        ", 1 of 1) into that slot; if it lies there, look",
    ] {
        assert!(alarm.contains(part), "{part}: {alarm}");
    }
    assert!(alarm.contains("(code 24): part_in_hand at `grasp for m1`, after "), "{alarm}");
    assert!(alarm.contains(ANSWERS) && !alarm.contains("in-machine"), "{alarm}");
    assert_eq!(rig.eye.seen().arrivals("robot", "carry to m1"), 0, "it has not left the store with an empty hand");
    let why = rig.said(&["why"], &["part", "1"]).expect("it is known");
    assert!(why.contains("waits for an answer to alarm 1"), "{why}");
    let why = rig.said(&["why"], &["R"]).expect("a resource is known");
    for part in [
        "R in service.",
        "It takes part in `load M1` with part 1, which has failed",
        "alarm 1: R grasped no part",
        "\nrobot ",
    ] {
        assert!(why.contains(part), "{part}: {why}");
    }
    // The station of one resource: of that as well.
    let why = rig.said(&["why"], &["robot"]).expect("a station is known");
    assert!(why.starts_with("R in service.") && why.contains("\nrobot "), "{why}");
    is_watched(&rig);
    let wrong = rig.said(&["answer"], &["1", "somewhere"]).expect_err("that is no answer");
    assert!(wrong.contains("in-store"), "{wrong}");
    a_stranger_orders(&rig);
    assert_eq!(rig.eye.seen().arrivals("m1", "clamp-close"), 0, "nothing was clamped");

    // The next time it falls on the way, which the simulated machine reports, and nothing in the line sees.
    assert!(!rig.run_notes().contains("simulated machine"), "{}", rig.run_notes());
    let gripper = |what| rig.said(&["fail"], &["robot", what, "--operation", "grasp for m1", "--bus", BUS]);
    gripper("drop").expect("the gripper can be made to drop");
    rig.said(&["answer"], &["1", "in-store"]).expect("it is believed");
    let alarm = until(&rig, &["answer"], |said| said.contains("alarm 2:"));
    assert!(alarm.contains("R came to M1 without part 1") && alarm.contains(IN_MACHINE), "{alarm}");
    let fell =
        "simulated machine: a part has fallen down and is gone: gripper `robot.hand` did not hold it fast (arm at ";
    assert_eq!(rig.run_notes().matches(fell).count(), 1, "{}", rig.run_notes());
    gripper("clear").expect("the gripper works");
    rig.said(&["answer"], &["2", "scrap"]).expect("it is believed");
    let (code, report) = rig.ended_within(LONG);
    assert_eq!((code, &report["parts_made"], &report["parts_wanted"]), (0, &1.into(), &1.into()), "{report}");
    assert_eq!(rig.eye.seen().arrivals("m1", "clamp-close"), 1, "it was clamped once");
    let report = rig.report();
    assert!(report.contains("1 parts have left, 0 are inside, 1 were lost; 2 activities have failed"), "{report}");
    assert!(report.contains("quality 50.0 %"), "{report}");
    assert!(report.contains('▒') && report.contains('█') && report.contains('░'), "planned, done, failed: {report}");
}

/// Another node orders a task that machine 1 could do. It is refused.
fn a_stranger_orders(rig: &Rig) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(async {
        let args = RosArgs { domain_id: rig.domain(), ..RosArgs::default() };
        let participant = Participant::open(&args).expect("joins");
        let mut node = participant.node("/workcell_c1", "stranger").expect("a node");
        let mut states = node.subscription::<OrderState>("m1/order", qos::latched_state()).expect("a topic");
        let (state, _) = timeout(LONG, states.recv()).await.expect("in time").expect("a state");
        assert_eq!((state.rest.as_str(), state.doing_id), ("open", 0), "it could do it");
        let caller = node.action_caller::<RunTask>("m1/run_task", Mapping::Enhanced).expect("a caller");
        let goal = RunTaskGoal {
            memory: state.memory,
            epoch: state.epoch.max(1),
            id: 1 << 40,
            task: "clamp".into(),
            limit_ms: 60_000,
            ..RunTaskGoal::default()
        };
        // The server may not be discovered yet.
        let mut began = caller.begin(goal.clone(), Duration::from_secs(2)).await;
        for _ in 0..5 {
            if began.is_err() {
                began = caller.begin(goal.clone(), Duration::from_secs(2)).await;
            }
        }
        let ended = caller.result(began.expect("accepted"), LONG).await.expect("it has ended");
        assert_eq!((ended.0, ended.1.code), (GoalOutcome::Aborted, RunTaskResult::REFUSED_SENDER), "{:?}", ended.1);
        assert!(ended.1.text.contains("not from the coordinator"), "{}", ended.1.text);
    });
}

/// The view has the alarm with its answers, where the part is, and what recovery waits for.
fn is_watched(rig: &Rig) {
    let picture = rig.said(&["watch"], &["--once"]).expect("a picture");
    let whole = picture.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "alarms: 1: R grasped no part at slot 1 of ST. Put part 1 (order A of run ",
        ANSWERS,
        "of part 1 for",
        "failed, waits for an answer to alarm 1",
        "parts: 1 inside, 0 have left",
        "part 1",
        "orders: 1 not over",
        "0 of 1 A, in work",
    ] {
        assert!(whole.contains(part), "{part}: {picture}");
    }
    let json = rig.said(&["watch"], &["--json"]).expect("an object");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let cell = &json["cell"];
    assert_eq!((&cell["alarms"][0]["id"], &cell["parts"][0]["part"]), (&1.into(), &1.into()), "{json}");
    assert_eq!(
        (&cell["orders"][0]["product"], &cell["in_progress"][0]["running"]),
        (&"A".into(), &false.into()),
        "{json}"
    );
}

#[test]
fn through_kills_and_an_alarm_every_part_that_was_ordered_is_made_once() {
    let mut rig = cell("assembly-cell", 2.0);
    let rule = "[[exception]]\nin = \"robot_2.process\"\ncode = \"alarm\"\ntell = \"Look at part {part}.\"\n\
                emergency_stop = [\"*\"]\nanswers = [{ word = \"as-done\", part = \"to\", then = \"forward\" }]\n[cell]";
    rig.change("cell.toml", &[("[cell]", rule)]);
    rig.start(&["--no-auto"]);
    let operator = Operator::join_line(&rig, "/assembly_cell", &["robot_1", "robot_2", "human"]);
    to_auto(&operator);

    // In the middle of an operation that is not undone.
    assembles(&rig, "first");
    coordinator_is_killed(&rig, &operator);
    put_right(&rig, &operator);
    until(&rig, &["order"], |said| is_made(said, "first"));

    // A station in the middle of its order: the others go on.
    assembles(&rig, "second");
    let boot = operator.station("robot_2").boot_id;
    rig.kill(&["--station", "robot_2"]);
    operator.wait("it comes back", |heard| heard.station("robot_2").boot_id != boot);
    until(&rig, &["answer"], |said| said.contains("robot_2.process with part"));
    assert_eq!(operator.heard().line.mode, StationState::MODE_AUTO, "{}", operator.picture());
    put_right_beside_auto(&rig, &operator);
    until(&rig, &["order"], |said| is_made(said, "second"));

    assembles(&rig, "third");
    an_alarm_stops_a_station_by_itself_until_it_is_reset(&rig, &operator);
    put_right(&rig, &operator);
    let said = until(&rig, &["order"], |said| is_made(said, "third"));

    assert!(said.starts_with("parts: 0 inside, 3 have left"), "{said}");
    assert!(!said.contains("lost") && !said.contains("alarm"), "{said}");
    let state = rig.said(&["order"], &["--json"]).expect("it is heard");
    let state: serde_json::Value = serde_json::from_str(&state).expect("one object");
    let orders: Vec<_> = state["orders"].as_array().expect("a list").iter().map(|order| &order["done"]).collect();
    assert_eq!((&state["parts_left"], orders), (&3.into(), vec![&1.into(); 3]), "{state}");
    assert_eq!(rig.eye.seen().arrivals("robot_2", "assemble"), 3, "each part was assembled once");
    rig.signal("INT");
    let (_, report) = rig.ended_within(LONG);
    assert_eq!(report["restarts"], 2, "{report}");
}

/// Orders a part, and waits until robot 2 assembles it.
fn assembles(rig: &Rig, name: &str) {
    let starts = |seen: &Seen| seen.starts().iter().filter(|start| start.what == "robot_2: assemble").count();
    let before = starts(&rig.eye.seen());
    rig.said(&["order"], &["submit", "1", "--name", name]).unwrap_or_else(|error| panic!("{name}: {error}"));
    rig.eye.within(LONG, "robot 2 assembles", |seen| starts(seen) > before);
}

/// An alarm is given of robot 2 while it assembles, and the rule for that puts it into emergency stop: it stands at once,
/// the others stay in auto, and only a reset leads out.
fn an_alarm_stops_a_station_by_itself_until_it_is_reset(rig: &Rig, operator: &Operator) {
    let arrived = rig.eye.seen().arrivals("robot_2", "assemble");
    rig.said(&["resource"], &["robot_2", "alarm", "smoke"]).expect("it is taken");
    let is_stopped = |heard: &crate::support::operator::Heard| {
        heard.station("robot_2").mode == StationState::MODE_ESTOP && !heard.station("robot_2").incomplete.is_empty()
    };
    operator.wait("robot 2 is in emergency stop", is_stopped);
    rig.eye.within(LONG, "its outputs are off", |seen| !seen.output("robot_2", "assemble"));
    assert_eq!(rig.eye.seen().arrivals("robot_2", "assemble"), arrived, "it has not gone on");
    assert_eq!(operator.heard().line.mode, StationState::MODE_AUTO);
    assert_eq!(operator.station("robot_1").mode, StationState::MODE_AUTO);
    operator.wait("the line's text names it", |heard| heard.line.text.contains("robot_2 in emergency stop"));
    let picture = rig.said(&["watch"], &["--once"]).expect("a picture");
    for part in ["emergency stop of its own, not reset", "robot_2 out of service for", "alarm raised by hand: smoke"] {
        assert!(picture.split_whitespace().collect::<Vec<_>>().join(" ").contains(part), "{part}: {picture}");
    }
    let why = rig.said(&["resource"], &["robot_2", "up"]).expect_err("not without looking");
    assert!(why.contains("robot_2: an activity with it failed"), "{why}");
    let is_reset = || rig.said(&["resource"], &["robot_2", "reset"]).is_ok();
    assert!(wait_for(LONG, is_reset), "{:?}", rig.said(&["resource"], &["robot_2", "reset"]));
    operator.wait("it follows the line again", |heard| heard.station("robot_2").mode != StationState::MODE_ESTOP);
}

fn coordinator_is_killed(rig: &Rig, operator: &Operator) {
    let before = operator.heard().line.clone();
    rig.kill(&["coordinator"]);
    operator.wait("another coordinator", |heard| heard.line.boot_id != before.boot_id);
    operator.wait_until_connected();
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
}

fn to_auto(operator: &Operator) {
    if operator.heard().line.mode == StationState::MODE_HOME {
        operator.order("start", StationState::MODE_STANDBY);
    }
    operator.order("auto", StationState::MODE_AUTO);
}

/// Robot 2 has been stopped while it assembled. It alone is in manual, and is led to the end of its task while the others stay in auto.
fn put_right_beside_auto(rig: &Rig, operator: &Operator) {
    let said = until(rig, &["answer"], |said| said.starts_with("alarm ") && said.contains("robot_2.process"));
    let others_are_in_auto = || {
        let line = operator.heard().line.mode;
        let modes = ["robot_1", "human"].map(|name| operator.station(name).mode);
        assert_eq!((line, modes), (StationState::MODE_AUTO, [StationState::MODE_AUTO; 2]), "{}", operator.picture());
    };
    is_listed_beside_auto(rig);
    rig.said(&["mode"], &["manual", "--station", "robot_2"]).expect("it is left out");
    operator.wait("its panel acts", |heard| heard.station("robot_2").mode == StationState::MODE_MANUAL);
    operator.complete();
    operator.jog("robot_2", "advance");
    others_are_in_auto();
    let alarm = alarm_number(&said);
    let why = rig.said(&["answer"], &[alarm, "as-done"]).expect_err("not while it may be moved");
    assert!(why.contains("robot_2: in manual by itself"), "{why}");
    rig.said(&["mode"], &["auto", "--station", "robot_2"]).expect("at a rest");
    operator.wait("it follows the line again", |heard| heard.station("robot_2").mode == StationState::MODE_AUTO);
    others_are_in_auto();
    is_answered(rig, &said);
}

/// `recover` lists that way: the only station that stands half-way.
fn is_listed_beside_auto(rig: &Rig) {
    let output = rig.command(&["recover"], &["--json"]).output().expect("the command starts");
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let steps = plan["steps"].as_array().expect("a list");
    let kinds: Vec<&str> = steps.iter().filter_map(|step| step["kind"].as_str()).collect();
    let ["manual_alone", presses @ .., "auto_again", "answer"] = &kinds[..] else { panic!("{plan:#}") };
    assert!(!presses.is_empty() && presses.iter().all(|kind| *kind == "press"), "{plan:#}");
    let words: Vec<&str> =
        steps[0]["arguments"].as_array().expect("words").iter().filter_map(|word| word.as_str()).collect();
    let ["mode", _, "manual", "--station", "robot_2"] = words[..] else { panic!("{plan:#}") };
}

/// Robot 2 has been stopped while it assembled. It is led to the end of its task by hand, and the alarm is answered with that.
fn put_right(rig: &Rig, operator: &Operator) {
    let said = until(rig, &["answer"], |said| said.starts_with("alarm ") && said.contains("robot_2.process"));
    if operator.heard().line.mode == StationState::MODE_AUTO {
        // It stands half-way: the line is not at home.
        operator.order("stop", StationState::MODE_STANDBY);
    }
    if operator.heard().line.mode == StationState::MODE_HOME {
        operator.order("start", StationState::MODE_STANDBY);
    }
    operator.order("manual", StationState::MODE_MANUAL);
    operator.complete();
    // Its arm is still in: the last operation of the task.
    operator.jog("robot_2", "advance");
    operator.order("auto", StationState::MODE_AUTO);
    is_answered(rig, &said);
}

/// The number of the alarm of which this is the text.
fn alarm_number(said: &str) -> &str {
    said.split_whitespace().nth(1).map(|number| number.trim_end_matches(':')).unwrap_or_default()
}

/// The alarm, of which this is the text, is answered with the end of the task.
fn is_answered(rig: &Rig, said: &str) {
    let alarm = alarm_number(said);
    rig.said(&["answer"], &[alarm, "as-done"]).unwrap_or_else(|error| panic!("{said}: {error}"));
    // A resource that was unable to work when the activity was closed stays out of service until `resource … up`.
    if rig.said(&["resource"], &[]).is_ok_and(|said| said.contains("robot_2 out of service")) {
        rig.said(&["resource"], &["robot_2", "up"]).expect("it works");
    }
}
