//! ROS 2 topics of the coordinator.

use linewright_coordinator_logic::{CompletedCycle, ModeCommand, ModeStanding};
use linewright_lifecycle::LifecycleState;
use linewright_line::{DeviceBus, Line, StationId};
use linewright_msgs::{CycleTime, Flag, LineState, ModeOrder, ProcessImage, StationState, Text};
use linewright_node_shell::{
    Forward, MessagePace, MessageSource, Publisher, RosNode, TopicError, forward, forward_present, forward_timely, qos,
    stamp, watch_middleware,
};
use linewright_station_shell::ParticipantId;
use tokio::sync::mpsc;

use crate::mode_services::{self, ModeRequest};

/// Something a subscription brought.
#[derive(Debug)]
pub enum CoordinatorInbound {
    /// An operator's command in words.
    Command { from: ParticipantId, words: String },
    /// A command by a service.
    Asked(ModeRequest),
    /// Hand-mode buttons held: their names, separated by blanks.
    Buttons { console: ConsoleSource, names: String },
    /// Resume, held or released.
    Resume { console: ConsoleSource, held: bool },
    /// An order that was given on this line: the coordinator's life, and its number there.
    Order { boot_id: u64, sequence: u64 },
    /// A station's state.
    State(Box<StationState>),
    /// Diagnostics of the devices of a station with a bus of its own.
    Trouble(StationId, String),
    /// The output image of a station behind the gateway.
    Outputs(StationId, ProcessImage),
}

/// The console of a held button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConsoleSource {
    /// One for each publisher, and for each start of it.
    pub id: u64,
    pub from: ParticipantId,
}

impl ConsoleSource {
    fn of(source: &MessageSource) -> Self {
        ConsoleSource { id: source.publisher_id(), from: source.participant() }
    }
}

/// The coordinator's publishers.
pub struct CoordinatorPublishers {
    pub order: Publisher<ModeOrder>,
    pub state: Publisher<LineState>,
    pub mode_text: Publisher<Text>,
    pub cycle_time: Publisher<CycleTime>,
    /// Input images, for each station behind the gateway.
    pub inputs: Vec<Option<Publisher<ProcessImage>>>,
}

/// The message about a cycle that has just been completed; none if it has no time.
pub fn cycle_time_message(cycle: CompletedCycle) -> Option<CycleTime> {
    let took = cycle.took?;
    Some(CycleTime { header: stamp(), number: cycle.number, duration_s: took.as_secs_f64() })
}

/// State of a station's node by its message, if that is not active.
pub fn inactive(message: &StationState) -> Option<LifecycleState> {
    LifecycleState::of_code(message.lifecycle).filter(|state| *state != LifecycleState::Active)
}

/// The message with what keeps the mode.
pub fn standing_message(line: &Line, standing: ModeStanding) -> LineState {
    let names = |ids: Vec<StationId>| ids.iter().map(|&id| line.station(id).name.clone()).collect();
    LineState {
        estop_latched: standing.is_latched,
        estop_pressed: standing.is_pressed,
        console_lost: standing.without_console,
        resume: standing.resumes,
        restarted: names(standing.restarted),
        left_out: names(standing.left_out),
        obstacles: standing.obstacles,
        ..LineState::default()
    }
}

/// Enough for a burst of every station's state while the node is busy; the rest waits in the middleware.
const QUEUE: usize = 1024;

/// Opens every topic of the coordinator.
pub fn open(
    node: &mut RosNode,
    line: &Line,
) -> Result<(CoordinatorPublishers, mpsc::Receiver<CoordinatorInbound>, Vec<Forward>), TopicError> {
    let mut says = CoordinatorPublishers {
        order: node.publisher("mode", qos::repeated())?,
        state: node.publisher("state", qos::latched_state())?,
        mode_text: node.publisher("mode_text", qos::latched_state())?,
        cycle_time: node.publisher("cycle_time", qos::latched_state())?,
        inputs: Vec::with_capacity(line.stations.len()),
    };
    let (to, from) = mpsc::channel(QUEUE);
    let mut tasks = vec![
        watch_middleware(),
        forward_timely(
            node.subscription("mode_cmd", qos::event())?,
            to.clone(),
            |m: &Text| m.data.trim() == ModeCommand::EStop.name(),
            |m, source| Some(CoordinatorInbound::Command { from: source.participant(), words: m.data }),
        ),
        // Another coordinator's; this one's own do not come back from the loopback address.
        forward(node.subscription("mode", qos::repeated())?, to.clone(), |m: ModeOrder, _| {
            Some(CoordinatorInbound::Order { boot_id: m.boot_id, sequence: m.sequence })
        }),
        forward_timely(
            node.subscription("buttons", qos::command())?,
            to.clone(),
            |m: &Text| m.data.trim().is_empty(),
            |m, source| Some(CoordinatorInbound::Buttons { console: ConsoleSource::of(&source), names: m.data }),
        ),
        forward_timely(
            node.subscription("resume", qos::command())?,
            to.clone(),
            |m: &Flag| !m.data,
            |m, source| Some(CoordinatorInbound::Resume { console: ConsoleSource::of(&source), held: m.data }),
        ),
    ];
    tasks.extend(mode_services::open(node, &to)?);
    for id in line.station_ids() {
        let station = line.station(id);
        let state = node.subscription(&format!("{}/state", station.name), qos::latched_state())?;
        let pace = MessagePace::new(line.timing.refresh, line.timing.stale);
        tasks.push(forward_present(state, to.clone(), pace, |m, _| Some(CoordinatorInbound::State(Box::new(m)))));
        says.inputs.push(if station.bus == DeviceBus::Line {
            let outputs = node.subscription(&format!("{}/outputs", station.name), qos::repeated())?;
            tasks.push(forward(outputs, to.clone(), move |m, _| Some(CoordinatorInbound::Outputs(id, m))));
            Some(node.publisher(&format!("{}/inputs", station.name), qos::repeated())?)
        } else {
            // Not gated by its pace: it is only read, in texts, and of one publisher the newest comes last. Commands and images are
            // volatile, so that the middleware sends nothing to a reader that was sent before it joined.
            let trouble = node.subscription(&format!("{}/trouble", station.name), qos::latched_state())?;
            tasks.push(forward(trouble, to.clone(), move |m: Text, _| Some(CoordinatorInbound::Trouble(id, m.data))));
            None
        });
    }
    Ok((says, from, tasks))
}
