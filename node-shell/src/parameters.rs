//! The parameter services of a node, and the topic of changes.
//!
//! One task of its own answers the six services of a node, one request after the other: of two that set the same parameter the later
//! one counts, and none is seen half done. What may be set is decided by [`ParameterSet`]. A changed value is in force when the
//! answer is sent as far as this crate knows it ([`LOG_LEVEL_NAME`]); the others are given to the node's loop
//! ([`Parameters::changed`]). A request is never taken as an order: no parameter that may be changed is one that a check rests on.

use linewright_msgs::{
    Bounded, DescribeParameters, DescribeParametersResponse, FloatingPointRange, GetParameterTypes,
    GetParameterTypesResponse, GetParameters, GetParametersResponse, IntegerRange, ListParameters,
    ListParametersResponse, ListParametersResult, Parameter, ParameterDescriptor, ParameterEvent,
    ParameterValue as ValueMessage, RosService, SetParameters, SetParametersAtomically,
    SetParametersAtomicallyResponse, SetParametersResponse, SetParametersResult,
};
use linewright_parameters::{ParameterDomain, ParameterSet, ParameterType, ParameterValue};
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, watch};

use crate::logging::set_log_level;
use crate::service::{ServiceReply, serve};
use crate::subscription::Forward;
use crate::{LogLevel, Publisher, RosNode, TopicError, names, qos, stamp};

/// Name of the parameter with the log level of the process; its values are those of `--log-level`.
pub const LOG_LEVEL_NAME: &str = "log_level";

/// Requests of all services that wait; more wait in the middleware.
const QUEUE: usize = 16;
/// Most parameters that one request may name: more than a node has. An answer is longer than its request, and answers that no reader
/// acknowledges are kept.
const ASKED_MAX: usize = 32;
/// Least time between two lines of the log about requests to set something.
const LOGGED_EVERY: Duration = Duration::from_secs(1);

/// A request to one of the services.
enum ParameterRequest {
    Describe(Vec<String>, ServiceReply<DescribeParameters>),
    Get(Vec<String>, ServiceReply<GetParameters>),
    Types(Vec<String>, ServiceReply<GetParameterTypes>),
    List(Vec<String>, u64, ServiceReply<ListParameters>),
    Set(Vec<Parameter>, ServiceReply<SetParameters>),
    SetAll(Vec<Parameter>, ServiceReply<SetParametersAtomically>),
}

/// The parameters of a node as they are served. Dropping this ends their services.
pub struct Parameters {
    values: watch::Receiver<ParameterSet>,
    tasks: Vec<Forward>,
}

impl Parameters {
    /// Opens the six services of `node` and announces the parameters with their first values. Must be called inside a tokio runtime.
    ///
    /// # Errors
    /// When the middleware refuses a service or the topic of changes.
    pub fn serve(node: &mut RosNode, set: ParameterSet) -> Result<Self, TopicError> {
        let (to, mut from) = mpsc::channel(QUEUE);
        let mut tasks = vec![
            open::<DescribeParameters>(node, "describe_parameters", &to, |asked, reply| {
                ParameterRequest::Describe(asked.names, reply)
            })?,
            open::<GetParameters>(node, "get_parameters", &to, |asked, reply| {
                ParameterRequest::Get(asked.names, reply)
            })?,
            open::<GetParameterTypes>(node, "get_parameter_types", &to, |asked, reply| {
                ParameterRequest::Types(asked.names, reply)
            })?,
            open::<ListParameters>(node, "list_parameters", &to, |asked, reply| {
                ParameterRequest::List(asked.prefixes, asked.depth, reply)
            })?,
            open::<SetParameters>(node, "set_parameters", &to, |asked, reply| {
                ParameterRequest::Set(asked.parameters, reply)
            })?,
            open::<SetParametersAtomically>(node, "set_parameters_atomically", &to, |asked, reply| {
                ParameterRequest::SetAll(asked.parameters, reply)
            })?,
        ];
        let (values, received) = watch::channel(set);
        let mut served = ServedParameters {
            values,
            events: node.publisher("/parameter_events", qos::event())?,
            node: names::expand(node.name(), node.namespace(), node.name())?,
            logged: None,
            unlogged: 0,
        };
        let first = served.values.borrow().iter().map(|(declared, value)| parameter(declared.name, value)).collect();
        served.publish(ParameterEvent { new_parameters: first, ..ParameterEvent::default() });
        tasks.push(Forward::spawn(async move {
            while let Some(asked) = from.recv().await {
                served.answer(asked);
                // A flood of requests must not keep the node's loop waiting.
                tokio::task::yield_now().await;
            }
        }));
        Ok(Parameters { values: received, tasks })
    }

    /// Waits for a change. Cancel safe.
    pub async fn changed(&mut self) {
        if self.values.changed().await.is_err() {
            // Its task has ended; see `is_failed`.
            std::future::pending::<()>().await;
        }
    }

    /// The time that a parameter holds now in s, if it holds one.
    pub fn seconds(&self, name: &str) -> Option<Duration> {
        self.values.borrow().double(name).and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
    }

    /// A service has ended; the middleware has failed.
    pub fn is_failed(&self) -> bool {
        self.tasks.iter().any(Forward::is_finished)
    }
}

fn open<S: RosService>(
    node: &mut RosNode,
    name: &str,
    to: &mpsc::Sender<ParameterRequest>,
    map: impl FnMut(S::Request, ServiceReply<S>) -> ParameterRequest + Send + 'static,
) -> Result<Forward, TopicError> {
    Ok(serve(node.service::<S>(&format!("~/{name}"))?, to.clone(), map))
}

struct ServedParameters {
    values: watch::Sender<ParameterSet>,
    events: Publisher<ParameterEvent>,
    /// Absolute name of the node.
    node: String,
    logged: Option<Instant>,
    /// Lines left out since then.
    unlogged: u64,
}

impl ServedParameters {
    fn answer(&mut self, asked: ParameterRequest) {
        match asked {
            ParameterRequest::Describe(names, reply) => {
                let descriptors = self.each(&names, descriptor);
                reply.send(DescribeParametersResponse { descriptors });
            }
            ParameterRequest::Get(names, reply) => {
                let values = self.each(&names, |set, name| set.get(name).map(value_message).unwrap_or_default());
                reply.send(GetParametersResponse { values });
            }
            ParameterRequest::Types(names, reply) => {
                let types = self.each(&names, |set, name| set.get(name).map_or(0, |value| value.kind().code()));
                reply.send(GetParameterTypesResponse { types });
            }
            ParameterRequest::List(prefixes, depth, reply) => {
                let few = &prefixes[..prefixes.len().min(ASKED_MAX)];
                let (names, prefixes) = self.values.borrow().list(few, depth);
                let owned = |texts: Vec<&str>| texts.into_iter().map(str::to_owned).collect();
                let result = ListParametersResult { names: owned(names), prefixes: owned(prefixes) };
                reply.send(ListParametersResponse { result });
            }
            ParameterRequest::Set(parameters, reply) => {
                let results = match too_many(parameters.len()) {
                    Some(refused) => {
                        // Each has a result; the reason once.
                        let others = vec![SetParametersResult::default(); parameters.len() - 1];
                        std::iter::once(refused).chain(others).collect()
                    }
                    None => self.set(parameters.iter().map(std::slice::from_ref)),
                };
                reply.send(SetParametersResponse { results });
            }
            ParameterRequest::SetAll(parameters, reply) => {
                let result = too_many(parameters.len());
                let result = result.or_else(|| self.set([&*parameters].into_iter()).pop()).unwrap_or_default();
                reply.send(SetParametersAtomicallyResponse { result });
            }
        }
    }

    /// The answer for each name; none where there are too many names, since the answer would be longer than the request.
    fn each<T>(&self, names: &[String], ask: impl Fn(&ParameterSet, &str) -> T) -> Vec<T> {
        if names.len() > ASKED_MAX {
            return Vec::new();
        }
        let set = self.values.borrow();
        names.iter().map(|name| ask(&set, name)).collect()
    }

    /// Sets groups of parameters, of each group all or none; a result for each. What changes is put into force and published once: a request
    /// costs the node's loop no more than one change.
    fn set<'p>(&mut self, groups: impl Iterator<Item = &'p [Parameter]>) -> Vec<SetParametersResult> {
        let before = self.values.borrow().clone();
        let results = groups.map(|group| self.set_group(group)).collect();
        let changed: Vec<&'static str> = {
            let now = self.values.borrow();
            now.iter().filter(|(of, value)| before.get(of.name) != Some(value)).map(|(of, _)| of.name).collect()
        };
        if !changed.is_empty() {
            self.changed(&changed);
        }
        results
    }

    fn set_group(&mut self, group: &[Parameter]) -> SetParametersResult {
        let pairs: Vec<_> = group.iter().map(|asked| (asked.name.as_str(), value_of(&asked.value))).collect();
        let mut outcome = Ok(Vec::new());
        self.values.send_if_modified(|set| {
            outcome = set.set_all(pairs.iter().map(|(name, value)| (*name, value)));
            outcome.as_ref().is_ok_and(|changed| !changed.is_empty())
        });
        match outcome {
            Ok(_) => SetParametersResult { successful: true, reason: String::new() },
            Err(refusal) => {
                let reason = refusal.to_string();
                self.log(|| format!("refused: {reason}"));
                SetParametersResult { successful: false, reason }
            }
        }
    }

    /// Puts a changed log level into force, and logs and publishes what has changed.
    fn changed(&mut self, changed: &[&'static str]) {
        let set = self.values.borrow().clone();
        let all: Vec<(&str, &ParameterValue)> =
            changed.iter().filter_map(|name| set.get(name).map(|value| (*name, value))).collect();
        let level = set.text(LOG_LEVEL_NAME).filter(|_| changed.contains(&LOG_LEVEL_NAME)).and_then(LogLevel::named);
        if level.is_some() {
            // From when on less is logged, the log shows in any case.
            self.logged = None;
        }
        self.log(|| all.iter().map(|(name, value)| format!("{name} is {value} now")).collect::<Vec<_>>().join(", "));
        if let Some(level) = level {
            set_log_level(level);
        }
        let changed_parameters = all.into_iter().map(|(name, value)| parameter(name, value)).collect();
        self.publish(ParameterEvent { changed_parameters, ..ParameterEvent::default() });
    }

    fn publish(&self, event: ParameterEvent) {
        self.events.send(ParameterEvent { stamp: stamp().stamp, node: self.node.clone(), ..event });
    }

    /// Logs a line, at most one in [`LOGGED_EVERY`], so that requests cannot fill a disk.
    fn log(&mut self, text: impl FnOnce() -> String) {
        if self.logged.is_some_and(|logged| logged.elapsed() < LOGGED_EVERY) {
            self.unlogged += 1;
            return;
        }
        self.logged = Some(Instant::now());
        let unlogged = std::mem::take(&mut self.unlogged);
        tracing::info!(node = self.node, unlogged, "parameter: {}", text());
    }
}

fn too_many(asked: usize) -> Option<SetParametersResult> {
    let reason = || format!("{asked} parameters in one request; at most {ASKED_MAX}");
    (asked > ASKED_MAX).then(|| SetParametersResult { successful: false, reason: reason() })
}

/// The message about a parameter; without a type if there is none of this name.
fn descriptor(set: &ParameterSet, name: &str) -> ParameterDescriptor {
    let Some(declared) = set.declaration(name) else {
        return ParameterDescriptor { name: name.to_owned(), ..ParameterDescriptor::default() };
    };
    let mut message = ParameterDescriptor {
        name: declared.name.to_owned(),
        r#type: declared.domain.kind().code(),
        description: declared.description.to_owned(),
        additional_constraints: declared.constraints(),
        read_only: declared.is_read_only(),
        ..ParameterDescriptor::default()
    };
    match declared.domain {
        // One element is within their bound.
        ParameterDomain::Integer { from: from_value, to: to_value } => {
            message.integer_range =
                Bounded::new(vec![IntegerRange { from_value, to_value, step: 0 }]).unwrap_or_default();
        }
        ParameterDomain::Double { from: from_value, to: to_value } => {
            let range = FloatingPointRange { from_value, to_value, step: 0.0 };
            message.floating_point_range = Bounded::new(vec![range]).unwrap_or_default();
        }
        ParameterDomain::Bool | ParameterDomain::Text | ParameterDomain::OneOf(_) => {}
    }
    message
}

fn parameter(name: &str, value: &ParameterValue) -> Parameter {
    Parameter { name: name.to_owned(), value: value_message(value) }
}

fn value_message(value: &ParameterValue) -> ValueMessage {
    let mut message = ValueMessage { r#type: value.kind().code(), ..ValueMessage::default() };
    match value {
        ParameterValue::Bool(value) => message.bool_value = *value,
        ParameterValue::Integer(value) => message.integer_value = *value,
        ParameterValue::Double(value) => message.double_value = *value,
        ParameterValue::Text(value) => message.string_value.clone_from(value),
        ParameterValue::Other(_) => {}
    }
    message
}

fn value_of(message: &ValueMessage) -> ParameterValue {
    match ParameterType::of_code(message.r#type) {
        ParameterType::Bool => ParameterValue::Bool(message.bool_value),
        ParameterType::Integer => ParameterValue::Integer(message.integer_value),
        ParameterType::Double => ParameterValue::Double(message.double_value),
        ParameterType::Text => ParameterValue::Text(message.string_value.clone()),
        other => ParameterValue::Other(other),
    }
}
