//! Parameters of a running line: a file gives them at the start, a stranger sets some while the line cycles, and is refused the others.
//!
//! ```text
//!   run --params-file ── auto ── set log_level warn ──▶ the log of that node is silent ── set info ──▶ it is written again
//!                             ── set timing.lease_ms ──▶ refused, with the place that sets it; the line cycles on
//! ```

use std::time::Duration;

use linewright_msgs::{
    DiagnosticArray, GetParameters, GetParametersRequest, Parameter, ParameterValue, SetParameters,
    SetParametersRequest, SetParametersResult, StationState,
};
use linewright_node_shell::{Caller, qos};

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};
use crate::support::stranger::Stranger;
use crate::support::{PATIENCE, wait_for};

fn set(stranger: &Stranger, caller: &Caller<SetParameters>, name: &str, value: ParameterValue) -> SetParametersResult {
    let parameters = vec![Parameter { name: name.to_owned(), value }];
    stranger.ask(caller, &SetParametersRequest { parameters }).results.remove(0)
}

fn text(value: &str) -> ParameterValue {
    let (r#type, string_value) = (ParameterValue::TYPE_STRING, value.to_owned());
    ParameterValue { r#type, string_value, ..ParameterValue::default() }
}

fn double(value: f64) -> ParameterValue {
    ParameterValue { r#type: ParameterValue::TYPE_DOUBLE, double_value: value, ..ParameterValue::default() }
}

const FILE: &str = "\
/**:
  ros__parameters:
    diagnostics_period_s: 5.0
/transfer_line/*:
  ros__parameters:
    timing: {lease_ms: 2000}
    use_sim_time: false
";

#[test]
fn a_stranger_sets_what_no_check_rests_on_while_the_line_cycles() {
    let mut rig = Rig::new(&line(0.3));
    rig.file("line.yaml", FILE);
    let file = rig.state().parent().expect("a directory").join("line/line.yaml").display().to_string();
    rig.start(&["--ros-args", "--params-file", &file, "--"]);
    let operator = Operator::join(&rig);
    operator.wait("auto", |heard| heard.in_mode(StationState::MODE_AUTO));

    let mut stranger = Stranger::join(&rig);
    let get = stranger.caller::<GetParameters>("/transfer_line/coordinator/get_parameters");
    let names = vec!["diagnostics_period_s".to_owned(), "log_level".to_owned()];
    let values = stranger.ask(&get, &GetParametersRequest { names }).values;
    assert_eq!(values, [double(5.0), text("info")], "the file counts");

    let station = stranger.caller::<SetParameters>("/transfer_line/clamp_1/set_parameters");
    assert!(set(&stranger, &station, "log_level", text("warn")).successful);
    let silent = rig.log("clamp_1");
    operator.cycles(1);
    assert_eq!(rig.log("clamp_1"), silent, "what happened in a cycle is not in the log");
    assert!(set(&stranger, &station, "log_level", text("info")).successful);
    assert!(wait_for(PATIENCE, || rig.log("clamp_1").len() > silent.len() + 100), "and now it is again");

    let (r#type, integer_value) = (ParameterValue::TYPE_INTEGER, 60_000);
    let lease = ParameterValue { r#type, integer_value, ..ParameterValue::default() };
    let refused = set(&stranger, &station, "timing.lease_ms", lease);
    let reason =
        "timing.lease_ms is read-only, and is 2000; it is set by lease_ms in [timing] of the line's description";
    assert_eq!((refused.successful, refused.reason.as_str()), (false, reason));

    // A rate that is set is the rate at which messages come.
    let coordinator = stranger.caller::<SetParameters>("/transfer_line/coordinator/set_parameters");
    let refused = set(&stranger, &coordinator, "diagnostics_period_s", double(0.01)).reason;
    assert_eq!(refused, "diagnostics_period_s is from 0.5 to 10.0, and not 0.01");
    assert!(set(&stranger, &coordinator, "diagnostics_period_s", double(0.5)).successful);
    let mut topic = stranger.node.subscription::<DiagnosticArray>("/diagnostics", qos::event()).expect("a topic");
    let eight = async {
        for _ in 0..8 {
            topic.recv().await.expect("the middleware works");
        }
    };
    let came = stranger.runtime.block_on(async { tokio::time::timeout(Duration::from_secs(8), eight).await });
    assert!(came.is_ok(), "every 5 s there would be two");
    for nth in 0..500 {
        let period = if nth % 2 == 0 { 1.0 } else { 0.5 };
        assert!(set(&stranger, &coordinator, "diagnostics_period_s", double(period)).successful);
    }
    let log = rig.log("coordinator");
    assert!(log.matches("diagnostics_period_s is").count() < 30, "{log}");
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(0);
}

#[test]
fn what_a_parameter_file_has_wrong_is_shown_before_anything_starts() {
    let rig = Rig::new(&line(0.3));
    let refused = |file: &str| {
        rig.file("line.yaml", file);
        let path = rig.state().parent().expect("a directory").join("line/line.yaml").display().to_string();
        let state = rig.state().display().to_string();
        let more = ["--state-dir", &state, "--bus", "rig-line", "--ros-args", "--params-file", &path];
        rig.said(&["run"], &more).expect_err("it is refused")
    };
    let slip = refused("/**:\n  ros__parameters:\n    log_levl: warn\n");
    assert!(slip.contains("line.yaml:3:5") && slip.contains("did you mean log_level?"), "{slip}");
    let lease = refused("/transfer_line/mill_1:\n  ros__parameters:\n    timing.lease_ms: 60000\n");
    assert!(lease.contains("parameters of /transfer_line/mill_1") && lease.contains("line.yaml:3:22"), "{lease}");
    assert!(lease.contains("it is set by lease_ms"), "{lease}");
    let form = refused("/**:\n  parameters:\n    log_level: warn\n");
    assert!(form.contains("line.yaml:3:5") && form.contains("has no ros__parameters"), "{form}");
    let missing = rig.said(&["run"], &["--ros-args", "--params-file", "/nowhere.yaml"]).expect_err("it is refused");
    assert!(missing.contains("'--params-file /nowhere.yaml': No such file"), "{missing}");
    assert!(rig.processes().is_empty(), "nothing was started");
}
