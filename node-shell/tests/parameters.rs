//! Parameter services between two participants of this machine.

use std::time::Duration;

use linewright_msgs::{
    DescribeParameters, DescribeParametersRequest, GetParameters, GetParametersRequest, ListParameters,
    ListParametersRequest, Parameter, ParameterEvent, ParameterValue as ValueMessage, RosService, SetParameters,
    SetParametersAtomically, SetParametersAtomicallyRequest, SetParametersRequest, SetParametersResult,
};
use linewright_node_shell::{Caller, Mapping, Parameters, Participant, RosArgs, RosNode, qos};
use linewright_parameters::{Declaration, ParameterChange, ParameterDomain, ParameterSet, ParameterValue};
use tokio::time::{sleep, timeout};

pub const RATE: Declaration = Declaration {
    name: "rate_s",
    domain: ParameterDomain::Double { from: 0.5, to: 10.0 },
    change: ParameterChange::Live,
    description: "How often.",
};
pub const MODE: Declaration = Declaration {
    name: "mode",
    domain: ParameterDomain::OneOf(&["slow", "fast"]),
    change: ParameterChange::Live,
    description: "How.",
};
pub const FIXED: Declaration = Declaration {
    name: "fixed",
    domain: ParameterDomain::Text,
    change: ParameterChange::Elsewhere("the description"),
    description: "What.",
};

pub fn set() -> ParameterSet {
    let text = |text: &str| ParameterValue::Text(text.to_owned());
    ParameterSet::new([(&RATE, ParameterValue::Double(1.0)), (&MODE, text("slow")), (&FIXED, text("as it is"))])
}

/// Domains 90 to 99, beside those of the services.
fn node(name: &str) -> RosNode {
    let domain_id = 90 + (std::process::id() % 4) as u16 * 3;
    let participant = Participant::open(&RosArgs { domain_id, ..RosArgs::default() }).expect("participant");
    participant.node("/line", name).expect("node")
}

/// Repeats a request until it is answered: one sent before discovery is lost.
async fn ask<S: RosService>(caller: &Caller<S>, request: &S::Request) -> S::Response {
    for _ in 0..40 {
        if let Ok(response) = caller.call(request.clone(), Duration::from_millis(500)).await {
            return response;
        }
    }
    panic!("no answer");
}

fn rate(value: f64) -> Parameter {
    let value = ValueMessage { r#type: ValueMessage::TYPE_DOUBLE, double_value: value, ..ValueMessage::default() };
    Parameter { name: "rate_s".into(), value }
}

fn mode(value: &str) -> Parameter {
    let value =
        ValueMessage { r#type: ValueMessage::TYPE_STRING, string_value: value.into(), ..ValueMessage::default() };
    Parameter { name: "mode".into(), value }
}

#[tokio::test]
async fn a_parameter_is_set_by_another_node_and_in_force() {
    let mut server = node("server");
    let mut parameters = Parameters::serve(&mut server, set()).expect("services");
    let mut client = node("client");
    let mut events = client.subscription::<ParameterEvent>("/parameter_events", qos::event()).expect("subscription");
    let caller = client.caller::<SetParameters>("server/set_parameters", Mapping::Enhanced).expect("caller");
    // As it is already; from then on both sides know each other.
    let request = |parameters: &[Parameter]| SetParametersRequest { parameters: parameters.to_vec() };
    assert!(ask(&caller, &request(&[mode("slow")])).await.results[0].successful);
    sleep(Duration::from_millis(500)).await;
    assert_eq!(parameters.seconds("rate_s"), Some(Duration::from_secs(1)));
    let answer = ask(&caller, &request(&[rate(2.5), rate(99.0)])).await;
    let refused = SetParametersResult { successful: false, reason: "rate_s is from 0.5 to 10.0, and not 99.0".into() };
    assert_eq!(answer.results, [SetParametersResult { successful: true, reason: String::new() }, refused]);
    timeout(Duration::from_secs(5), parameters.changed()).await.expect("the loop is woken");
    assert_eq!(parameters.seconds("rate_s"), Some(Duration::from_millis(2500)));
    let changed = loop {
        let (event, _) = timeout(Duration::from_secs(10), events.recv()).await.expect("in time").expect("received");
        if !event.changed_parameters.is_empty() {
            break event;
        }
    };
    assert_eq!((changed.node.as_str(), changed.changed_parameters), ("/line/server", vec![rate(2.5)]));

    // All or none.
    let together = client
        .caller::<SetParametersAtomically>("server/set_parameters_atomically", Mapping::Enhanced)
        .expect("caller");
    let request = SetParametersAtomicallyRequest { parameters: vec![mode("fast"), rate(0.1)] };
    assert!(!ask(&together, &request).await.result.successful);
    let get = client.caller::<GetParameters>("server/get_parameters", Mapping::Cyclone).expect("caller");
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
    let answer = ask(&get, &GetParametersRequest { names: names(&["mode", "none", "rate_s"]) }).await;
    assert_eq!(answer.values, [mode("slow").value, ValueMessage::default(), rate(2.5).value]);
    assert!(!parameters.is_failed());
}

#[tokio::test]
async fn a_request_with_too_many_names_has_an_empty_answer_or_is_refused() {
    let mut server = node("generous");
    let _parameters = Parameters::serve(&mut server, set()).expect("services");
    let mut client = node("greedy");
    let describe =
        client.caller::<DescribeParameters>("generous/describe_parameters", Mapping::Enhanced).expect("caller");
    let names = |count: usize| DescribeParametersRequest { names: vec!["rate_s".to_owned(); count] };
    assert_eq!(ask(&describe, &names(32)).await.descriptors.len(), 32);
    assert_eq!(ask(&describe, &names(33)).await.descriptors.len(), 0);
    let set = client.caller::<SetParameters>("generous/set_parameters", Mapping::Enhanced).expect("caller");
    let answer = ask(&set, &SetParametersRequest { parameters: vec![rate(2.0); 33] }).await;
    assert_eq!(answer.results.len(), 33);
    assert_eq!(answer.results[0].reason, "33 parameters in one request; at most 32");
    let list = client.caller::<ListParameters>("generous/list_parameters", Mapping::Enhanced).expect("caller");
    let answer = ask(&list, &ListParametersRequest::default()).await;
    assert_eq!(
        (answer.result.names, answer.result.prefixes.len()),
        (vec!["fixed".into(), "mode".into(), "rate_s".into()], 0)
    );
}
