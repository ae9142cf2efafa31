//! The lifecycle of a node as ROS 2 has it: five services, and the topic of transitions.
//!
//! One task answers the questions about states and transitions. A request to change the state goes to the node's loop
//! ([`Lifecycle::next`]), which does the work and answers when it is done, as `rclcpp` does. The loop decides by [`NodeLifecycle`], so a
//! transition that does not lead out of the present state is refused before anything is done.

use linewright_lifecycle::{
    LIFECYCLE_TABLE, LifecycleOutcome, LifecycleRequest, LifecycleState, LifecycleStep, NodeLifecycle, steps_from,
};
use linewright_msgs::{
    ChangeState, ChangeStateResponse, GetAvailableStates, GetAvailableStatesResponse, GetAvailableTransitions,
    GetAvailableTransitionsResponse, GetState, GetStateResponse, NodeState, NodeTransition, RosService,
    TransitionDescription, TransitionEvent,
};
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, watch};

use crate::identity::nanoseconds;
use crate::service::{ServiceReply, serve};
use crate::subscription::Forward;
use crate::{Publisher, RosNode, TopicError, names, qos};

/// Requests that wait, of the services that ask and of the one that changes; more wait in the middleware.
const QUEUE: usize = 16;
/// Least time between two lines of the log about requests.
const LOGGED_EVERY: Duration = Duration::from_secs(1);

/// A question about the node.
enum LifecycleQuestion {
    State(ServiceReply<GetState>),
    States(ServiceReply<GetAvailableStates>),
    Transitions(ServiceReply<GetAvailableTransitions>),
    Graph(ServiceReply<GetAvailableTransitions>),
}

/// A request to change the state. It is to be answered by [`ChangeRequest::answer`] once its work is done.
#[derive(Debug)]
pub struct ChangeRequest {
    transition: NodeTransition,
    reply: ServiceReply<ChangeState>,
}

impl ChangeRequest {
    /// Whether it may end activity: where that can be done at once, it is done before the request is taken up.
    pub fn may_end_activity(&self) -> bool {
        let asked = LifecycleRequest::of(self.transition.id, &self.transition.label);
        let mut active = NodeLifecycle::active();
        active.begin(asked).is_some()
    }

    /// Answers whether the transition was made.
    pub fn answer(self, success: bool) {
        self.reply.send(ChangeStateResponse { success });
    }
}

/// The lifecycle of a node. Dropping this ends its services.
pub struct Lifecycle {
    node: NodeLifecycle,
    /// The same, for the task that answers.
    state: watch::Sender<LifecycleState>,
    events: Publisher<TransitionEvent>,
    asked: mpsc::Receiver<ChangeRequest>,
    tasks: Vec<Forward>,
    /// Absolute name of the node.
    name: String,
    made: LoggedSeldom,
    refused: LoggedSeldom,
}

/// Lines of the log of one kind.
#[derive(Default)]
struct LoggedSeldom {
    logged: Option<Instant>,
    /// Lines left out since then.
    unlogged: u64,
}

impl LoggedSeldom {
    /// Logs a line, at most one in [`LOGGED_EVERY`], so that requests cannot fill a disk.
    fn log(&mut self, node: &str, text: &str) {
        if self.logged.is_some_and(|logged| logged.elapsed() < LOGGED_EVERY) {
            self.unlogged += 1;
            return;
        }
        self.logged = Some(Instant::now());
        let unlogged = std::mem::take(&mut self.unlogged);
        tracing::info!(node, unlogged, "lifecycle: {text}");
    }
}

impl Lifecycle {
    /// Opens the services of `node`, which is unconfigured. Must be called inside a tokio runtime.
    ///
    /// # Errors
    /// When the middleware refuses a service or the topic of transitions.
    pub fn serve(node: &mut RosNode) -> Result<Self, TopicError> {
        let (to, mut questions) = mpsc::channel(QUEUE);
        let (change, asked) = mpsc::channel(QUEUE);
        let changes = node.service::<ChangeState>("~/change_state")?;
        let mut tasks = vec![
            serve(changes, change, |asked, reply| ChangeRequest { transition: asked.transition, reply }),
            open::<GetState>(node, "get_state", &to, LifecycleQuestion::State)?,
            open::<GetAvailableStates>(node, "get_available_states", &to, LifecycleQuestion::States)?,
            open::<GetAvailableTransitions>(node, "get_available_transitions", &to, LifecycleQuestion::Transitions)?,
            open::<GetAvailableTransitions>(node, "get_transition_graph", &to, LifecycleQuestion::Graph)?,
        ];
        let (state, received) = watch::channel(LifecycleState::default());
        let events = node.publisher("~/transition_event", qos::event())?;
        let name = names::expand(node.name(), node.namespace(), node.name())?;
        tasks.push(Forward::spawn(async move {
            while let Some(question) = questions.recv().await {
                let state = *received.borrow();
                answer(question, state);
                // A flood of questions must not keep the node's loop waiting.
                tokio::task::yield_now().await;
            }
        }));
        Ok(Lifecycle {
            node: NodeLifecycle::default(),
            state,
            events,
            asked,
            tasks,
            name,
            made: LoggedSeldom::default(),
            refused: LoggedSeldom::default(),
        })
    }

    pub fn state(&self) -> LifecycleState {
        self.node.state()
    }

    /// The next request. Cancel safe.
    pub async fn next(&mut self) -> ChangeRequest {
        match self.asked.recv().await {
            Some(asked) => asked,
            // Its service has ended; see `is_failed`.
            None => std::future::pending().await,
        }
    }

    /// Begins the transition of a request: the state whose work is to be done, and concluded. `None` if no such transition leads out of the
    /// present state.
    pub fn begin(&mut self, request: &ChangeRequest) -> Option<LifecycleState> {
        let NodeTransition { id, label } = &request.transition;
        let begun = self.begin_by(LifecycleRequest::of(*id, label));
        if begun.is_none() {
            let (label, state) = (label.chars().take(40).collect::<String>(), self.state().label());
            let text = format!("transition {id} '{}' refused: not out of {state}", label.escape_debug());
            self.refused.log(&self.name, &text);
        }
        begun
    }

    fn begin_by(&mut self, request: LifecycleRequest<'_>) -> Option<LifecycleState> {
        let step = self.node.begin(request)?;
        self.publish(step);
        Some(step.to)
    }

    /// Concludes the work of a state; the state whose work is to be done next, if there is more: that of error processing.
    pub fn conclude(&mut self, outcome: LifecycleOutcome) -> Option<LifecycleState> {
        let step = self.node.conclude(outcome)?;
        self.publish(step);
        if step.to.is_primary() {
            self.made.log(&self.name, &format!("{}, {} now", step.label, step.to.label()));
        }
        (!step.to.is_primary()).then_some(step.to)
    }

    /// Makes these transitions, whose work is done, as at the start of a node that is active at once.
    pub fn bring_up(&mut self) {
        for label in ["configure", "activate"] {
            let step = self.begin_by(LifecycleRequest::Label(label));
            if let Some(step) = step.and_then(|_| self.node.conclude(LifecycleOutcome::Success)) {
                self.publish(step);
            }
        }
    }

    /// A service has ended; the middleware has failed.
    pub fn is_failed(&self) -> bool {
        self.tasks.iter().any(Forward::is_finished)
    }

    fn publish(&mut self, step: &LifecycleStep) {
        self.state.send_replace(step.to);
        self.events.send(TransitionEvent {
            timestamp: nanoseconds(),
            transition: transition(step),
            start_state: state_message(step.from),
            goal_state: state_message(step.to),
        });
    }
}

fn open<S: RosService>(
    node: &mut RosNode,
    name: &str,
    to: &mpsc::Sender<LifecycleQuestion>,
    question: impl Fn(ServiceReply<S>) -> LifecycleQuestion + Send + 'static,
) -> Result<Forward, TopicError> {
    Ok(serve(node.service::<S>(&format!("~/{name}"))?, to.clone(), move |_, reply| question(reply)))
}

fn answer(question: LifecycleQuestion, state: LifecycleState) {
    match question {
        LifecycleQuestion::State(reply) => reply.send(GetStateResponse { current_state: state_message(state) }),
        LifecycleQuestion::States(reply) => {
            let available_states = LifecycleState::ALL.map(state_message).to_vec();
            reply.send(GetAvailableStatesResponse { available_states });
        }
        LifecycleQuestion::Transitions(reply) => {
            let available_transitions = steps_from(state).map(description).collect();
            reply.send(GetAvailableTransitionsResponse { available_transitions });
        }
        LifecycleQuestion::Graph(reply) => {
            let available_transitions = LIFECYCLE_TABLE.iter().map(description).collect();
            reply.send(GetAvailableTransitionsResponse { available_transitions });
        }
    }
}

fn state_message(state: LifecycleState) -> NodeState {
    NodeState { id: state.code(), label: state.label().to_owned() }
}

fn transition(step: &LifecycleStep) -> NodeTransition {
    NodeTransition { id: step.code, label: step.label.to_owned() }
}

fn description(step: &LifecycleStep) -> TransitionDescription {
    let (start_state, goal_state) = (state_message(step.from), state_message(step.to));
    TransitionDescription { transition: transition(step), start_state, goal_state }
}
