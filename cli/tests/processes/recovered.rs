//! What stands half-way, and the plan of `linewright recover` typed as it stands, until the line is in auto.
//!
//! ```text
//!   mill_1 ── feed ──✝ ── back, incomplete ── recover --json: manual · advance · auto ── each typed ──▶ auto
//!   transfer and mill_1 ── coordinator ✝ ── both incomplete ── manual · resume · auto ── each typed ──▶ auto
//! ```

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use linewright_msgs::{StationState, Text, Trigger, TriggerResponse};
use linewright_node_shell::{Caller, Mapping, Participant, RosArgs, RosNode, Subscription, qos};
use serde_json::Value;

use crate::support::rig::{Rig, line};
use crate::support::{PATIENCE, pause};

/// The plan, which leads to auto: else the command fails.
fn plan(rig: &Rig) -> Value {
    let said = rig.said(&["recover"], &["--once", "--json"]).expect("a plan that leads to auto");
    serde_json::from_str(&said).unwrap_or_else(|error| panic!("{error}: {said}"))
}

fn steps(plan: &Value) -> Vec<Value> {
    plan["steps"].as_array().expect("a list").clone()
}

fn kinds(plan: &Value) -> Vec<Value> {
    steps(plan).iter().map(|step| step["kind"].clone()).collect()
}

/// Types the first step of each plan until none is left; the last plan.
fn type_it(rig: &Rig, first: Value) -> Value {
    let mut now = first;
    for _ in 0..10 {
        let Some(step) = steps(&now).first().cloned() else { break };
        // Nothing is typed while stations still acknowledge a mode.
        if let Some(words) = step["arguments"].as_array() {
            let words: Vec<&str> = words.iter().filter_map(Value::as_str).collect();
            let said = rig.said(&words[..1], &words[2..]);
            assert!(said.is_ok(), "{words:?}: {said:?}");
        }
        pause(500);
        now = plan(rig);
    }
    now
}

/// `linewright recover --publish`, and a console that reads it.
struct Console {
    publishes: Child,
    runtime: tokio::runtime::Runtime,
    plans: Subscription<Text>,
    asks: Caller<Trigger>,
    _node: RosNode,
}

impl Console {
    fn of(rig: &Rig) -> Self {
        let mut command = rig.command(&["recover"], &["--publish"]);
        let publishes = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn().expect("it starts");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        let entered = runtime.enter();
        let args = RosArgs { domain_id: rig.domain(), ..RosArgs::default() };
        let participant = Participant::open(&args).expect("a participant");
        let mut node = participant.node("/transfer_line", "test_console").expect("a node");
        let plans = node.subscription("recovery_plan", qos::latched_state()).expect("a topic");
        let asks = node.caller::<Trigger>("recovery", Mapping::Enhanced).expect("a service");
        drop(entered);
        Console { publishes, runtime, plans, asks, _node: node }
    }

    /// The first plan of which this holds.
    fn plan(&mut self, is_it: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let received = self.runtime.block_on(async { tokio::time::timeout(left, self.plans.recv()).await });
            let (text, _) = received.expect("a plan in time").expect("the middleware works");
            let plan: Value = serde_json::from_str(&text.data).expect("a JSON object");
            if is_it(&plan) {
                return plan;
            }
        }
    }

    fn ask(&mut self) -> TriggerResponse {
        let ask = || self.runtime.block_on(self.asks.call(Default::default(), Duration::from_secs(1)));
        // A request before the two have discovered each other gets no answer.
        let mut answers = (0..20).filter_map(|_| ask().ok());
        answers.next().expect("an answer")
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        let _ = self.publishes.kill();
        let _ = self.publishes.wait();
    }
}

#[test]
fn what_recover_names_is_typed_until_the_line_is_in_auto() {
    let mut rig = Rig::new(&line(2.0));
    let operator = rig.in_stand_by();
    operator.order("auto", StationState::MODE_AUTO);
    rig.eye.wait("the mill feeds", |seen| seen.output("mill_1", "feed"));
    operator.wait("and says so", |heard| heard.station("mill_1").places[2] == StationState::PLACE_OPERATING);
    let before = operator.station("mill_1");
    rig.kill(&["--station", "mill_1"]);
    operator.wait("it comes back", |heard| heard.station("mill_1").boot_id != before.boot_id);
    operator.wait_until_connected();
    operator
        .wait("everything stands", |heard| heard.all(|state| state.stopped && state.mode != StationState::MODE_AUTO));
    pause(700);
    let first = plan(&rig);
    assert_eq!((&first["end"], first["shortest"].as_bool()), (&Value::from("auto"), Some(true)), "{first}");
    assert_eq!(kinds(&first), ["command", "press", "command"], "{first}");
    assert_eq!(first["steps"][1]["station"], "mill_1", "{first}");
    assert_eq!(first["steps"][1]["moves"][0]["operation"], "feed main slide", "{first}");
    let mut console = Console::of(&rig);
    let published = console.plan(|plan| plan["end"] == "auto" && plan["not_heard"] == serde_json::json!([]));
    assert_eq!(published["steps"], first["steps"], "{published}");
    let answer = console.ask();
    let answered: Value = serde_json::from_str(&answer.message).expect("a JSON object");
    assert!(answer.success && answered["steps"] == first["steps"], "{answered}");
    let text = rig.said(&["recover"], &["--once"]).expect("it leads to auto");
    assert!(text.contains("1. command manual") && text.contains("mill_1: hold "), "{text}");
    assert_eq!(text.matches("\n       linewright ").count(), 3, "each step has its command: {text}");
    rig.said(&["mode"], &["manual"]).expect("it is in force");
    let short = rig.said(&["press"], &["advance", "--station", "mill_1", "--for", "0.2"]).expect_err("half-way");
    assert!(short.contains("advance let go before the end: mill_1: feed main slide"), "{short}");
    let now = type_it(&rig, plan(&rig));
    assert_eq!(now["mode"]["mode"], "auto", "{now}");
    console.plan(|plan| plan["mode"]["mode"] == "auto" && steps(plan).is_empty());
    assert_eq!(steps(&now).len(), 0, "{now}");
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(1);
    let unheard = rig.command(&["recover"], &["--json"]).stdout(Stdio::piped()).output().expect("it ends");
    let unheard: Value = serde_json::from_slice(&unheard.stdout).expect("a JSON object");
    assert_eq!((&unheard["mode"], &unheard["end"]), (&Value::Null, &Value::Null), "{unheard}");
}

#[test]
fn after_the_coordinator_was_killed_one_button_leads_every_station_on() {
    let mut rig = Rig::new(&with_slow_motions());
    let operator = rig.in_stand_by();
    operator.order("auto", StationState::MODE_AUTO);
    rig.eye.wait("the bar returns and the mill moves", |seen| {
        seen.output("transfer", "return") && seen.energised().iter().any(|name| name.starts_with("mill_1"))
    });
    rig.kill(&["coordinator"]);
    operator.wait("two stand half-way", |heard| {
        let stands = |name| !heard.station(name).incomplete.is_empty();
        heard.all(|state| state.stopped && state.devices_valid) && stands("transfer") && stands("mill_1")
    });
    operator.wait_until_connected();
    pause(700);
    let in_stand_by = rig.said(&["press"], &["resume", "--for", "0.2"]).expect_err("in manual only");
    assert!(in_stand_by.contains("in manual only"), "{in_stand_by}");
    let first = plan(&rig);
    assert_eq!((&first["end"], first["shortest"].as_bool()), (&Value::from("auto"), Some(true)), "{first}");
    assert_eq!(kinds(&first), ["command", "resume", "command"], "{first}");
    let moved: Vec<&Value> =
        first["steps"][1]["moves"].as_array().expect("a list").iter().map(|of| &of["station"]).collect();
    assert_eq!(moved, ["transfer", "mill_1"], "{first}");
    a_changed_description_is_named_and_not_planned_with(&rig);
    let now = type_it(&rig, first);
    assert_eq!(now["mode"]["mode"], "auto", "{now}");
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(1);
}

/// The line, with the two motions that a restart of the coordinator is to interrupt slow enough to be under way still when the
/// devices stop, about a second later: one that has arrived by then is no motion to be resumed, and a switch that is on would
/// have to be believed.
fn with_slow_motions() -> String {
    let mut text = line(4.0);
    for (old, new) in [
        (
            "from = 500, to = 0 }\nduration_s = 2.0\nwatchdog_s = 6.0",
            "from = 500, to = 0 }\nduration_s = 6.0\nwatchdog_s = 20.0",
        ),
        (
            "from = 0, to = 80 }\nduration_s = 1.2\nwatchdog_s = 4.0",
            "from = 0, to = 80 }\nduration_s = 4.8\nwatchdog_s = 16.0",
        ),
        ("at = \"LS_positioning_80\", velocity = 72.5", "at = \"LS_positioning_80\", velocity = 18.125"),
    ] {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text = text.replace(old, new);
    }
    text
}

/// As many operations of the same names: only the fingerprint differs.
fn a_changed_description_is_named_and_not_planned_with(rig: &Rig) {
    rig.change("line.toml", &[("stale_ms = 1000", "stale_ms = 900")]);
    let named = "the running line was started with another description than ";
    let said = |words: &[&str], more: &[&str]| {
        let output = rig.command(words, more).output().expect("the command starts");
        let text = [output.stdout, output.stderr].concat();
        (output.status.success(), String::from_utf8(text).expect("text"))
    };
    for (words, more, succeeds) in [
        ("recover", &["--once"][..], false),
        ("recover", &["--json"], false),
        ("watch", &["--once"], true),
        ("watch", &["--json"], true),
        ("mode", &[], true),
        ("why", &[], true),
        // Nothing of it has a fault; that is said beside.
        ("fail", &["clamp_1", "clear"], false),
    ] {
        let (is_success, text) = said(&[words], more);
        assert!(text.contains(named) && is_success == succeeds, "{words}: {text}");
        assert!(words != "recover" || !text.contains("resume"), "{text}");
    }
    rig.change("line.toml", &[("stale_ms = 900", "stale_ms = 1000")]);
    assert!(!said(&["mode"], &[]).1.contains(named));
}
