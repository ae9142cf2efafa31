//! A running line and a cell as programs use them: diagnostics, the log, commands of the mode by services, an order as an action.
//!
//! ```text
//!   stranger ── set_mode, stop, estop ──▶ coordinator ── the decision of mode_cmd ──▶ accepted, or all reasons
//!   stranger ◀── /diagnostics of every node, each name in one group ── /rosout
//!   stranger ── dispatch_order ──▶ cell ── parts done of how many ──▶ done; cancelled: withdrawn
//! ```

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use linewright_msgs::{
    DiagnosticArray, DiagnosticStatus, DispatchOrder, DispatchOrderGoal, DispatchOrderResult, Log, ProductionRequest,
    ProductionState, SetMode, SetModeRequest, StationState, Time, Trigger, TriggerRequest,
};
use linewright_node_shell::{ActionCaller, Caller, GoalHandle, GoalOutcome, Mapping, Subscription, qos};

use crate::processes::cells::{LONG, cell};
use crate::support::PATIENCE;
use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};
use crate::support::stranger::Stranger;

/// Names of statuses in the groups of the file for the aggregator.
fn expected(rig: &Rig) -> Vec<String> {
    let file = rig.said(&["diagnostics"], &[]).expect("a file");
    let status = |line: &str| Some(line.strip_prefix("        - '")?.strip_suffix('\'')?.to_owned());
    file.lines().filter_map(status).collect()
}

/// Collects the newest status of each name until `holds`.
fn statuses(
    stranger: &Stranger,
    topic: &mut Subscription<DiagnosticArray>,
    holds: impl Fn(&BTreeMap<String, DiagnosticStatus>) -> bool,
) -> BTreeMap<String, DiagnosticStatus> {
    let (mut newest, end) = (BTreeMap::new(), Instant::now() + PATIENCE);
    while !holds(&newest) {
        assert!(Instant::now() < end, "{newest:#?}");
        let received = stranger.runtime.block_on(async { tokio::time::timeout(PATIENCE, topic.recv()).await });
        let (array, _) = received.expect("in time").expect("the middleware works");
        newest.extend(array.status.into_iter().map(|status| (status.name.clone(), status)));
    }
    newest
}

#[test]
fn every_node_reports_itself_and_each_name_is_in_one_group() {
    let mut rig = Rig::new(&line(0.5));
    let operator = rig.in_auto();
    let mut stranger = Stranger::join(&rig);
    let mut topic = stranger.node.subscription::<DiagnosticArray>("/diagnostics", qos::event()).expect("a topic");
    let mut named = expected(&rig);
    named.sort();
    let all_there = |of: &BTreeMap<String, DiagnosticStatus>| of.len() >= named.len();
    let found = statuses(&stranger, &mut topic, all_there);
    assert_eq!(found.keys().cloned().collect::<Vec<_>>(), named, "no name is in two groups, none is in no group");
    let level = |found: &BTreeMap<String, DiagnosticStatus>, name: &str| found.get(name).map(|status| status.level);
    let is_ok = |found: &BTreeMap<String, DiagnosticStatus>| {
        ["coordinator: mode", "coordinator: stations", "coordinator: journal", "mill_1: coordinator"]
            .iter()
            .all(|name| level(found, name) == Some(DiagnosticStatus::OK))
    };
    let found = statuses(&stranger, &mut topic, is_ok);
    assert_eq!(found["coordinator: mode"].hardware_id, "transfer_line");
    assert!(found["coordinator: mode"].values.iter().any(|value| value.key == "mode" && value.value == "auto"));

    rig.kill(&["station", "mill_1"]);
    let value = |found: &BTreeMap<String, DiagnosticStatus>, key: &str| {
        let stations = found.get("coordinator: stations")?;
        stations.values.iter().find(|value| value.key == key).map(|value| value.value.clone())
    };
    let restarts = "mill_1: restarts seen";
    let found = statuses(&stranger, &mut topic, |found| value(found, restarts).as_deref() == Some("1"));
    assert_eq!(value(&found, "clamp_1: restarts seen").as_deref(), Some("0"));
    operator.order("estop", StationState::MODE_ESTOP);
    let is_error =
        |found: &BTreeMap<String, DiagnosticStatus>| level(found, "coordinator: mode") == Some(DiagnosticStatus::ERROR);
    let found = statuses(&stranger, &mut topic, is_error);
    assert!(found["coordinator: mode"].message.contains("command estop"), "{:?}", found["coordinator: mode"]);
    rig.signal("INT");
    rig.ended();
}

/// Asks once the service is discovered: a question without a command is refused, and changes nothing.
fn meet(stranger: &Stranger, caller: &Caller<SetMode>) -> String {
    stranger.ask(caller, &SetModeRequest::default()).reason
}

#[test]
fn programs_command_the_mode_by_the_rules_of_the_topic_and_are_answered() {
    let mut rig = Rig::new(&line(0.5));
    rig.start(&["--no-auto"]);
    let operator = Operator::join(&rig);
    operator.wait("home", |h| h.line.mode == StationState::MODE_HOME && h.all(|s| s.devices_valid));
    let mut stranger = Stranger::join(&rig);
    let mut log = stranger.node.subscription::<Log>("/rosout", qos::log()).expect("a topic");
    let set = stranger.caller::<SetMode>("/transfer_line/coordinator/set_mode");
    let [stop, estop] =
        ["stop", "estop"].map(|name| stranger.caller::<Trigger>(&format!("/transfer_line/coordinator/{name}")));
    assert_eq!(meet(&stranger, &set), "unknown command 0; commands: START (1) to RESET (7)");
    let unstamped = stranger.ask(&set, &SetModeRequest { command: SetModeRequest::START, ..SetModeRequest::default() });
    assert!(!unstamped.accepted && unstamped.reason.contains("without `stamp`"), "{}", unstamped.reason);
    // A clock of its own, far from any other.
    let began = Instant::now();
    let clock = || 1_000_000 + i32::try_from(began.elapsed().as_secs()).expect("a short test");
    let give = |command: u8| {
        let (by, note) = ("scada".to_owned(), "shift begins".to_owned());
        let stamp = Time { sec: clock(), nanosec: 0 };
        stranger.ask(&set, &SetModeRequest { command, stamp, by, note, ..SetModeRequest::default() })
    };

    let refused = give(SetModeRequest::AUTO);
    assert!(!refused.accepted, "not from home");
    assert_eq!(refused.reason, operator.refused("auto"), "the reasons are those of the topic");
    let started = give(SetModeRequest::START);
    assert!(started.accepted, "{}", started.reason);
    operator.wait("stand-by", |h| h.line.mode == StationState::MODE_STANDBY && h.line.epoch >= started.epoch);
    let auto = give(SetModeRequest::AUTO);
    assert!(auto.accepted && auto.epoch > started.epoch, "{}", auto.reason);
    operator.wait("auto of that epoch", |h| h.in_mode(StationState::MODE_AUTO) && h.line.epoch == auto.epoch);
    operator.cycles(1);

    // By its own stamps it comes ten seconds after another one of the same client.
    let stamped = |command: u8, sec: i32| {
        let stamp = Time { sec, nanosec: 0 };
        stranger.ask(&set, &SetModeRequest { command, stamp, ..SetModeRequest::default() })
    };
    assert!(!stamped(SetModeRequest::AUTO, clock()).accepted, "it is in auto already");
    let late = stamped(SetModeRequest::STOP, clock() - 10);
    assert!(!late.accepted && late.reason.contains("it came more than 2 s late"), "{}", late.reason);
    assert!(operator.heard().in_mode(StationState::MODE_AUTO));

    let trigger = |caller: &Caller<Trigger>| stranger.ask(caller, &TriggerRequest::default());
    assert!(trigger(&stop).success);
    operator.wait("home", |h| h.line.mode == StationState::MODE_HOME);
    assert!(trigger(&estop).success);
    operator.wait("emergency stop", |h| h.line.mode == StationState::MODE_ESTOP);
    assert!(stamped(SetModeRequest::ESTOP, 1).accepted, "this one is never too late");
    let start = give(SetModeRequest::START);
    assert!(!start.accepted && start.reason.contains("emergency stop"), "{}", start.reason);
    let reset = give(SetModeRequest::RESET);
    assert!(reset.accepted && reset.reason.contains("reset; select manual"), "{}", reset.reason);

    let mut came = Vec::new();
    let is_there = |came: &[Log]| {
        let has = |name: &str, text: &str| came.iter().any(|line| line.name == name && line.msg.contains(text));
        has("transfer_line.coordinator", "operator: auto, by scada: shift begins")
            && has("transfer_line.mill_1", "mill")
    };
    let end = Instant::now() + PATIENCE;
    while !is_there(&came) {
        assert!(Instant::now() < end, "{came:#?}");
        let received = stranger.runtime.block_on(async { tokio::time::timeout(PATIENCE, log.recv()).await });
        came.push(received.expect("in time").expect("the middleware works").0);
    }
    assert!(came.iter().any(|line| line.level == Log::WARN.0), "refusals are warnings");
    rig.signal("INT");
    rig.ended();
}

/// A goal, once the server is discovered.
fn begun(stranger: &Stranger, caller: &ActionCaller<DispatchOrder>, name: &str, key: u8, quantity: u32) -> GoalHandle {
    let request = ProductionRequest {
        key: linewright_msgs::Bounded::new(vec![key; 16]).expect("16 bytes"),
        name: name.to_owned(),
        product: "A".to_owned(),
        quantity,
        ..ProductionRequest::default()
    };
    let goal = DispatchOrderGoal { request, by: "mes".to_owned() };
    let end = Instant::now() + PATIENCE;
    loop {
        // A repetition is the same order, by its key.
        match stranger.runtime.block_on(caller.begin(goal.clone(), Duration::from_secs(2))) {
            Ok(begun) => return begun,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
    }
}

#[test]
fn a_program_makes_an_order_follows_it_and_cancels_another() {
    let mut rig = cell("workcell-c1", 8.0);
    rig.start(&["--patience", "140"]);
    let mut stranger = Stranger::join(&rig);
    let name = "/workcell_c1/coordinator/dispatch_order";
    let caller = stranger.node.action_caller::<DispatchOrder>(name, Mapping::Enhanced).expect("a caller");
    let result = |goal| stranger.runtime.block_on(caller.result(goal, LONG)).expect("it has ended");

    let (outcome, wrong) = result(begun(&stranger, &caller, "none", 1, 0));
    assert_eq!((outcome, wrong.end), (GoalOutcome::Aborted, DispatchOrderResult::END_REFUSED));
    assert!(!wrong.problems.is_empty(), "{wrong:?}");

    let rush = begun(&stranger, &caller, "rush", 2, 1);
    let later = begun(&stranger, &caller, "later", 3, 50);
    let (outcome, made) = result(rush);
    assert_eq!((outcome, made.end), (GoalOutcome::Succeeded, DispatchOrderResult::END_DONE), "{made:?}");
    assert_eq!((made.order.name.as_str(), made.order.done, made.order.quantity), ("rush", 1, 1));
    let told = std::iter::from_fn(|| caller.feedback(rush)).map(|feedback| feedback.order.status);
    let told: Vec<u8> = told.collect();
    assert!(told.contains(&ProductionState::STATUS_IN_WORK), "{told:?}");

    // Nothing more of it enters, and what is inside leaves.
    assert!(stranger.runtime.block_on(caller.cancel(later, PATIENCE)).expect("answered"));
    let (outcome, left) = result(later);
    assert_eq!(outcome, GoalOutcome::Canceled, "{left:?}");
    assert!([DispatchOrderResult::END_CANCELLED, DispatchOrderResult::END_WITHDRAWN].contains(&left.end), "{left:?}");
    assert!(left.order.done < 50, "{left:?}");
    // The same request once more is the same order, which is over.
    let (outcome, again) = result(begun(&stranger, &caller, "rush", 2, 1));
    assert_eq!((outcome, again.order.id), (GoalOutcome::Succeeded, made.order.id), "{again:?}");
    rig.signal("INT");
    rig.ended();
}
