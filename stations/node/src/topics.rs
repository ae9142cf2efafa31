//! ROS 2 topics and services of a station.

use linewright_line::{DeviceBus, Line, StationId};
use linewright_msgs::{Flag, ModeOrder, ProcessImage, RunTaskGoal, StationEvent, StationState, Text};
use linewright_node_line::{ConvertError, of_this_description};
use linewright_node_shell::{
    Forward, GoalRequest, MessagePace, MessageSource, Publisher, RosNode, TopicError, forward, forward_present,
    forward_timely, qos, watch_middleware,
};
use linewright_station_logic::{LeaveWay, OrderKey, PanelCommand};
use linewright_station_shell::{InputsMessage, ParticipantId};
use tokio::sync::mpsc;

use crate::orders::TaskOrderTopics;

/// Message from a subscription.
#[derive(Debug)]
pub enum StationInbound {
    /// A coordinator's order, and its sender.
    Order(ModeOrder, ParticipantId),
    /// Another station's state.
    State(Box<StationState>),
    /// The station's input image, through the coordinator's gateway.
    Inputs(ProcessImage),
    /// Faults of the devices, from their manager.
    Trouble(String),
    /// The panel's selector: `auto` or `manual`.
    Selector(String),
    /// An operator confirms where the station stands: the name of the operation it was stopped in, or nothing where its
    /// switches measure that.
    Rejoin(String),
    /// A button of the panel.
    Button {
        /// One for each publisher, and for each start of it.
        console: u64,
        command: PanelCommand,
    },
    /// A task is ordered, or cancelled.
    Goal(GoalRequest<RunTaskGoal>),
    /// An order is to be left.
    Secure(OrderKey, LeaveWay, ParticipantId),
}

impl StationInbound {
    fn button(of: &MessageSource, command: PanelCommand) -> Self {
        StationInbound::Button { console: of.publisher_id(), command }
    }
}

/// The publishers of a station.
pub struct StationPublishers {
    pub state: Publisher<StationState>,
    pub event: Publisher<StationEvent>,
    /// Only behind the gateway.
    pub outputs: Option<Publisher<ProcessImage>>,
    /// Only where it is task-driven.
    pub orders: Option<TaskOrderTopics>,
}

/// Enough for a burst of every station's state while the node is busy; the rest waits in the middleware.
const QUEUE: usize = 256;

/// Opens every topic of a station.
pub fn open(
    node: &mut RosNode,
    line: &Line,
    station: StationId,
    boot_id: u64,
    peers: &[StationId],
) -> Result<(StationPublishers, mpsc::Receiver<StationInbound>, Vec<Forward>), TopicError> {
    let gateway = line.station(station).bus == DeviceBus::Line;
    let mut says = StationPublishers {
        state: node.publisher("~/state", qos::latched_state())?,
        event: node.publisher("~/event", qos::event())?,
        outputs: if gateway { Some(node.publisher("~/outputs", qos::repeated())?) } else { None },
        orders: None,
    };
    let (to, from) = mpsc::channel(QUEUE);
    let mut tasks = vec![
        watch_middleware(),
        forward(node.subscription("mode", qos::repeated())?, to.clone(), |m, source| {
            Some(StationInbound::Order(m, source.participant()))
        }),
        forward_timely(
            node.subscription("~/selector", qos::command())?,
            to.clone(),
            |_: &Text| false,
            |m, _| Some(StationInbound::Selector(m.data)),
        ),
        forward_timely(
            node.subscription("~/rejoin", qos::command())?,
            to.clone(),
            |_: &Text| false,
            |m, _| Some(StationInbound::Rejoin(m.data)),
        ),
        forward_timely(
            node.subscription("~/advance", qos::command())?,
            to.clone(),
            |m: &Flag| !m.data,
            |m, source| Some(StationInbound::button(&source, PanelCommand::Advance(m.data))),
        ),
        forward_timely(
            node.subscription("~/return", qos::command())?,
            to.clone(),
            |m: &Flag| !m.data,
            |m, source| Some(StationInbound::button(&source, PanelCommand::Retract(m.data))),
        ),
    ];
    let pace = MessagePace::new(line.timing.refresh, line.timing.stale);
    for &peer in peers {
        let state = node.subscription(&format!("{}/state", line.station(peer).name), qos::latched_state())?;
        tasks.push(forward_present(state, to.clone(), pace.clone(), |m, _| Some(StationInbound::State(Box::new(m)))));
    }
    if line.station(station).is_task_driven() {
        says.orders = Some(TaskOrderTopics::open(
            node,
            (&line.station(station).name, line.fingerprint()),
            boot_id,
            &to,
            &mut tasks,
        )?);
    }
    if gateway {
        tasks.push(forward(node.subscription("~/inputs", qos::repeated())?, to.clone(), |m, _| {
            Some(StationInbound::Inputs(m))
        }));
        // Not gated by its pace: it is only read, in texts, and of one publisher the newest comes last. Commands, orders and images
        // are volatile, so that the middleware sends nothing to a reader that was sent before it joined.
        tasks.push(forward(node.subscription("~/trouble", qos::latched_state())?, to.clone(), |m: Text, _| {
            Some(StationInbound::Trouble(m.data))
        }));
    }
    Ok((says, from, tasks))
}

/// The inputs of a station, from the coordinator's message.
///
/// # Errors
/// When the message has another fingerprint of the description than this.
pub fn inputs_from_message(description: u64, message: &ProcessImage) -> Result<InputsMessage, ConvertError> {
    of_this_description("the coordinator", message.description, description)?;
    Ok(InputsMessage {
        boot_id: message.boot_id,
        sequence: message.sequence,
        bits: message.word(),
        valid: message.valid,
        lives: message.lives,
        under: (message.number_boot_id, message.number),
    })
}
