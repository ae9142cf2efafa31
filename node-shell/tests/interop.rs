//! A peer that shares no code with us: Cyclone DDS (the PyPI package `cyclonedds`) in Python.
//!
//! Foreign middleware would look for peers on every network. So the test starts itself again inside a network namespace
//! that has nothing but a loopback interface, and both communicate only there. Without the package, or without the
//! right to make a namespace, it is skipped, with a message on the terminal.
//!
//! `LINEWRIGHT_INTEROP_PYTHON` names the interpreter that has the package (default `python3`).

use linewright_lifecycle::LifecycleOutcome;
use linewright_msgs::{
    Answer, CORead, CoReadRequest, CoReadResponse, RunTask, RunTaskFeedback, RunTaskResult, SetMode, SetModeRequest,
    SetModeResponse, StationState, Text, Time,
};
use linewright_node_shell::{
    GoalAsked, GoalEnd, GoalRequest, Lifecycle, Parameters, Participant, RosArgs, Rosout, init_logging, qos, serve,
    serve_action, stamp,
};
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tokio::time::{sleep, timeout};

use crate::parameters::set;

const INSIDE: &str = "interop::inside_the_namespace";

fn python() -> String {
    std::env::var("LINEWRIGHT_INTEROP_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// Writes past the test harness, which would swallow it.
fn skip(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED interop with Cyclone DDS: {why}");
}

fn succeeds(command: &mut Command) -> bool {
    command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[test]
fn cyclone_dds_and_we_understand_each_other() {
    if !succeeds(Command::new(python()).args(["-c", "import cyclonedds.core"])) {
        return skip(&format!("'{}' has no package cyclonedds", python()));
    }
    if !succeeds(Command::new("unshare").args(["-rn", "ip", "link", "set", "lo", "up"])) {
        return skip("no right to make a network namespace");
    }
    let script = "ip link set lo up && ip link set lo multicast on && ip route add 239.0.0.0/8 dev lo \
                  && exec \"$0\" --exact \"$1\" --ignored --nocapture";
    let own = std::env::current_exe().expect("own path");
    let mut inside = Command::new("unshare");
    inside.args(["-rn", "sh", "-c", script]).arg(own).arg(INSIDE).stderr(Stdio::inherit());
    let ended = inside.output().expect("started");
    let said = String::from_utf8_lossy(&ended.stdout);
    println!("{said}");
    assert!(ended.status.success() && said.contains("1 passed"), "see above");
}

/// Whether only the loopback interface is there, however this was started.
fn alone() -> bool {
    let devices = std::fs::read_to_string("/proc/net/dev").unwrap_or_default();
    let up = devices.lines().skip(2).filter_map(|line| line.split_once(':')).map(|(name, _)| name.trim().to_owned());
    up.eq(["lo".to_owned()])
}

#[ignore = "started by cyclone_dds_and_we_understand_each_other"]
#[test]
fn inside_the_namespace() {
    if !alone() {
        return skip("not in a namespace of its own");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().expect("runtime");
    runtime.block_on(both_ways());
    runtime.block_on(a_service_is_called());
    runtime.block_on(an_action_is_asked_for());
    runtime.block_on(parameters_are_asked_for_and_set());
    runtime.block_on(the_state_of_a_node_is_asked_for_and_changed());
    runtime.block_on(a_command_is_given_and_the_log_is_read());
}

async fn both_ways() {
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/transfer_line", "coordinator").expect("node");
    let mut commands = node.subscription::<Text>("mode_cmd", qos::command()).expect("subscription");
    let text = node.publisher::<Text>("mode_text", qos::latched_state()).expect("publisher");
    let states = node.publisher::<StationState>("s1/state", qos::latched_state()).expect("publisher");
    text.send(Text::from("stand-by"));
    states.send(state());

    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/peer.py");
    let started = Instant::now();
    let mut peer = Command::new(python()).args([script, "0"]).stdout(Stdio::piped()).spawn().expect("the peer starts");
    let lines = BufReader::new(peer.stdout.take().expect("piped")).lines();
    let heard = tokio::task::spawn_blocking(move || wait_for_all(lines));

    let (command, source) =
        timeout(Duration::from_secs(15), commands.recv()).await.expect("in time").expect("received");
    assert_eq!(command.data, "auto");
    println!("Cyclone DDS -> us: 'auto' after {} ms, {source:?}", started.elapsed().as_millis());
    // The volatile reader receives what is sent from now on.
    while !heard.is_finished() {
        text.send(Text::from("auto"));
        sleep(Duration::from_millis(100)).await;
    }
    let all = heard.await.expect("the peer's output");
    peer.kill().expect("killed");
    peer.wait().expect("ended");
    assert!(all, "the peer did not hear everything");
    assert_eq!(commands.rejected(), 0);
}

/// As a node under rmw_cyclonedds sends it: the request's identity stands before the data.
async fn a_service_is_called() {
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/transfer_line", "coordinator").expect("node");
    let service = node.service::<CORead>("clamp_1_io/sdo_read").expect("service");
    let (to, mut from) = tokio::sync::mpsc::channel(16);
    let _task = serve(service, to, |asked: CoReadRequest, reply| (asked, reply));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/caller.py");
    let mut peer = Command::new(python()).args([script, "0"]).stdout(Stdio::piped()).spawn().expect("the peer starts");
    let lines = BufReader::new(peer.stdout.take().expect("piped")).lines();
    let said = tokio::task::spawn_blocking(move || lines.map_while(Result::ok).collect::<Vec<String>>());
    while !said.is_finished() {
        if let Ok(Some((asked, reply))) = timeout(Duration::from_millis(100), from.recv()).await {
            assert_eq!(asked, CoReadRequest { index: 0x1018, subindex: 2 });
            reply.send(CoReadResponse { success: true, data: 0x1234_5678 });
        }
    }
    peer.wait().expect("ended");
    let said = said.await.expect("the peer's output");
    println!("Cyclone DDS called a service: {said:?}");
    assert_eq!(said, [format!("answer True True {}", 0x1234_5678)]);
}

/// As rclpy under rmw_cyclonedds sends it: a goal with its result, and one that is cancelled.
async fn an_action_is_asked_for() {
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/cell", "m1").expect("node");
    let action = node.action::<RunTask>("~/run_task").expect("action");
    let (to, mut from) = tokio::sync::mpsc::channel(16);
    let (owner, _task) = serve_action(action, to, |asked| asked);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/goals.py");
    let mut peer = Command::new(python()).args([script, "0"]).stdout(Stdio::piped()).spawn().expect("the peer starts");
    let lines = BufReader::new(peer.stdout.take().expect("piped")).lines();
    let said = tokio::task::spawn_blocking(move || lines.map_while(Result::ok).collect::<Vec<String>>());
    let result = |id, end, text: &str| RunTaskResult { epoch: 1, id, end, code: 0, text: text.to_owned() };
    while !said.is_finished() {
        match timeout(Duration::from_millis(100), from.recv()).await {
            Ok(Some(GoalRequest { goal, asked: GoalAsked::New(asked), .. })) => {
                let names = (asked.task.as_str(), &asked.parameter_names[..], &asked.parameters[..]);
                assert_eq!((names.1, names.2, asked.part.as_str()), (&["slot".to_owned()][..], &[-3][..], "part 7"));
                if names.0 == "clamp" {
                    let phase = RunTaskFeedback::PHASE_RUNNING;
                    // As a station does, repeatedly: the first may go out before the peer's reader is found.
                    for _ in 0..10 {
                        owner.feedback(goal, RunTaskFeedback { phase, operation: "close".into(), step: 1, steps: 1 });
                        sleep(Duration::from_millis(100)).await;
                    }
                    owner.end(goal, GoalEnd::Succeeded, result(asked.id, RunTaskResult::END_DONE, "done"));
                }
            }
            Ok(Some(GoalRequest { goal, asked: GoalAsked::Cancel, .. })) => {
                owner.end(goal, GoalEnd::Canceled, result(6, RunTaskResult::END_SECURED, "secured"));
            }
            Ok(None) | Err(_) => {}
        }
    }
    peer.wait().expect("ended");
    let said = said.await.expect("the peer's output");
    println!("Cyclone DDS asked for an action: {said:?}");
    let expected = [
        "accepted True True",
        "result 4 1 5 0 0 done",
        "feedback ['close']",
        "accepted True True",
        "cancelled 0 [True]",
        "result 5 1 6 2 0 secured",
        "status [5]",
    ];
    assert_eq!(said, expected);
}

/// As rclpy under rmw_cyclonedds sends it, for each of the six services.
async fn parameters_are_asked_for_and_set() {
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/line", "drill").expect("node");
    let parameters = Parameters::serve(&mut node, set()).expect("services");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/parameters.py");
    let peer = Command::new(python()).args([script, "0", "/line/drill"]).stdout(Stdio::piped()).spawn();
    let peer = peer.expect("the peer starts");
    let ended = tokio::task::spawn_blocking(move || peer.wait_with_output()).await.expect("waited for");
    let said = String::from_utf8(ended.expect("its output").stdout).expect("text");
    println!("Cyclone DDS asked for parameters:\n{said}");
    let expected = [
        "list ['fixed', 'mode', 'rate_s'] []",
        "describe rate_s 3 False [(0.5, 10.0)] How often. ",
        "describe mode 4 False [] How. One of slow, fast.",
        "describe none 0 False []  ",
        "types [3, 0, 4]",
        "set True ",
        "set False rate_s is from 0.5 to 10.0, and not 99.0",
        "set False fixed is read-only, and is 'as it is'; it is set by the description",
        "set True ",
        "all False rate_s is a double, and not an integer; write 3.0",
        "all True ",
        "get [(3, 3.0, ''), (4, 0.0, 'slow'), (0, 0.0, '')]",
        "event /line/drill [('mode', 'fast'), ('rate_s', 2.5)]",
        "event /line/drill [('mode', 'slow'), ('rate_s', 3.0)]",
    ];
    assert_eq!(said.lines().collect::<Vec<_>>(), expected);
    assert!(!parameters.is_failed());
}

/// As rclpy under rmw_cyclonedds sends it, for each of the five services.
async fn the_state_of_a_node_is_asked_for_and_changed() {
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/line", "lathe").expect("node");
    let mut lifecycle = Lifecycle::serve(&mut node).expect("services");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/lifecycle.py");
    let peer = Command::new(python()).args([script, "0", "/line/lathe"]).stdout(Stdio::piped()).spawn();
    let peer = peer.expect("the peer starts");
    let ended = tokio::task::spawn_blocking(move || peer.wait_with_output());
    while !ended.is_finished() {
        if let Ok(asked) = timeout(Duration::from_millis(100), lifecycle.next()).await {
            let begun = lifecycle.begin(&asked);
            assert_eq!(begun.map(|_| lifecycle.conclude(LifecycleOutcome::Success)), begun.map(|_| None));
            asked.answer(begun.is_some());
        }
    }
    let said = String::from_utf8(ended.await.expect("waited for").expect("its output").stdout).expect("text");
    println!("Cyclone DDS led a node through its states:\n{said}");
    let expected = [
        "state unconfigured",
        "states [(0, 'unknown'), (1, 'unconfigured'), (2, 'inactive'), (3, 'active'), (4, 'finalized'), (10, 'configuring'), \
         (11, 'cleaningup'), (12, 'shuttingdown'), (13, 'activating'), (14, 'deactivating'), (15, 'errorprocessing')]",
        "available ['configure [1] unconfigured configuring', 'shutdown [5] unconfigured shuttingdown']",
        "graph 25",
        "change False",
        "change True inactive",
        "change True active",
        "change False active",
        "change True inactive",
        "event configure [1] unconfigured configuring True",
        "event transition_success [10] configuring inactive True",
        "event activate [3] inactive activating True",
        "event transition_success [30] activating active True",
        "event deactivate [4] active deactivating True",
        "event transition_success [40] deactivating inactive True",
    ];
    assert_eq!(said.lines().collect::<Vec<_>>(), expected);
    assert!(!lifecycle.is_failed());
}

/// As rclpy under rmw_cyclonedds does it; the log as rclcpp reads it, lines from before it joined included.
async fn a_command_is_given_and_the_log_is_read() {
    init_logging(None).expect("logging");
    let participant = Participant::open(&RosArgs::default()).expect("participant");
    let mut node = participant.node("/transfer_line", "coordinator").expect("node");
    let rosout = Rosout::open(&mut node).expect("the log");
    let service = node.service::<SetMode>("~/set_mode").expect("service");
    let (to, mut from) = tokio::sync::mpsc::channel(16);
    let _task = serve(service, to, |asked: SetModeRequest, reply| (asked, reply));
    tracing::warn!(target: "linewright_test", count = 3, "a late reader has it");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/commands.py");
    let peer = Command::new(python()).args([script, "0"]).stdout(Stdio::piped()).spawn().expect("the peer starts");
    let ended = tokio::task::spawn_blocking(move || peer.wait_with_output());
    while !ended.is_finished() {
        if let Ok(Some((asked, reply))) = timeout(Duration::from_millis(100), from.recv()).await {
            let expected = SetModeRequest {
                command: SetModeRequest::MANUAL,
                station: "robot".into(),
                stamp: Time { sec: 1_700_000_000, nanosec: 5 },
                by: "ada".into(),
                note: "a part lies there".into(),
            };
            assert_eq!(asked, expected);
            assert_ne!(reply.participant(), [0; 12]);
            reply.send(SetModeResponse { accepted: false, reason: "robot: moving".into(), epoch: u64::MAX - 3 });
        }
    }
    let said = String::from_utf8(ended.await.expect("waited for").expect("its output").stdout).expect("text");
    println!("Cyclone DDS gave a command and read the log:\n{said}");
    let mut lines: Vec<&str> = said.lines().collect();
    lines.sort_unstable();
    let answer = format!("answer True False robot: moving {}", u64::MAX - 3);
    assert_eq!(lines, [answer.as_str(), "log 30 transfer_line.coordinator a late reader has it count=3 True"]);
    assert!(!rosout.is_failed());
}

fn state() -> StationState {
    StationState {
        header: stamp(),
        boot_id: u64::MAX - 1,
        sequence: 1,
        station: "s1".into(),
        lifecycle: StationState::LIFECYCLE_ACTIVE,
        description: u64::MAX - 2,
        done: vec![3, 2],
        started: vec![3, 3],
        places: vec![StationState::PLACE_COMPLETED, StationState::PLACE_INCOMPLETE],
        incomplete: vec![1],
        blocked_by: vec!["s2 is unknown".into()],
        request_number: 42,
        answers: vec![Answer {
            station: "s2".into(),
            boot_id: 7,
            request_number: 41,
            agreed: false,
            in_the_way: "lift".into(),
        }],
        ..Default::default()
    }
}

/// Reads until the peer has received everything, or has ended.
fn wait_for_all(lines: impl Iterator<Item = std::io::Result<String>>) -> bool {
    let mut missing = vec![
        "latched-text stand-by".to_owned(),
        "volatile-text auto".to_owned(),
        format!(
            "state s1 {} {} [3, 2] [3, 2] [1] ['s2 is unknown'] 42 [('s2', 7, False, 'lift')]",
            u64::MAX - 1,
            u64::MAX - 2
        ),
    ];
    for line in lines.map_while(Result::ok) {
        println!("Cyclone DDS heard: {line}");
        missing.retain(|expected| *expected != line);
        if missing.is_empty() {
            return true;
        }
    }
    println!("missing: {missing:?}");
    false
}
