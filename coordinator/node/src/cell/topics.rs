//! ROS 2 topics and services of the coordinator of a cell, beside those of every line.

use linewright_coordinator_cell::{OrderKey, OrderMessage};
use linewright_line::{Line, StationId};
use linewright_msgs::{
    AnswerAlarm, CellState, ChangeOrder, DispatchOrder, DispatchOrderGoal, OrderState, RunTask, SecureOrder,
    SetResource, SetResourceRequest, StationState, SubmitOrders, SubmitOrdersRequest, WhyNot,
};
use linewright_node_shell::{
    ActionCaller, ActionOwner, Forward, GoalRequest, Mapping, MessagePace, Publisher, RosNode, ServiceReply,
    TopicError, forward_present, qos, serve, serve_action,
};
use linewright_orders::LeaveWay;
use tokio::sync::mpsc;

use super::wire;

/// Messages and requests received.
pub enum CellInbound {
    /// A station's state of its task orders.
    Heard(StationId, Box<OrderState>),
    /// Request to make something.
    Submit(SubmitOrdersRequest, ServiceReply<SubmitOrders>),
    /// Nothing more of an order is to enter.
    Cancel(String, ServiceReply<ChangeOrder>),
    /// An order is to be as if it had never been.
    Withdraw(String, ServiceReply<ChangeOrder>),
    /// A program makes an order by a goal, or cancels that.
    Goal(GoalRequest<DispatchOrderGoal>),
    /// Further state of a task-driven station.
    State(StationId, Box<StationState>),
    /// Answer to an alarm: its number, the answer, and the operator's name.
    Answer(u64, String, String, ServiceReply<AnswerAlarm>),
    /// An operator's request about a resource.
    Resource(SetResourceRequest, ServiceReply<SetResource>),
    /// Question why something does not go on.
    Why(String, ServiceReply<WhyNot>),
}

/// A task-driven station.
struct TaskStationTopics {
    station: StationId,
    tasks: ActionCaller<RunTask>,
    secure: Publisher<SecureOrder>,
}

/// Messages sent.
pub struct CellPublishers {
    pub state: Publisher<CellState>,
    stations: Vec<TaskStationTopics>,
}

impl CellPublishers {
    /// Sends an order to its station. The station's state acknowledges it.
    pub fn order(&self, order: &OrderMessage) {
        let Some(station) = self.station(order.station) else { return };
        if let Err(error) = station.tasks.send(wire::goal(order)) {
            tracing::debug!("{error}");
        }
    }

    /// Orders a station to leave an order.
    pub fn secure(&self, station: StationId, key: OrderKey, way: LeaveWay) {
        if let Some(station) = self.station(station) {
            station.secure.send(SecureOrder { epoch: key.epoch, id: key.id, way: way.number() });
        }
    }

    fn station(&self, id: StationId) -> Option<&TaskStationTopics> {
        self.stations.iter().find(|known| known.station == id)
    }
}

/// Enough for a burst of every station's state while a decision is computed; the rest waits in the middleware.
const QUEUE: usize = 1024;

/// Topics, services and the action of a cell.
pub struct CellTopics {
    pub says: CellPublishers,
    pub dispatch: ActionOwner<DispatchOrder>,
    pub from: mpsc::Receiver<CellInbound>,
    pub tasks: Vec<Forward>,
}

/// Opens every topic and service of a cell.
pub fn open(node: &mut RosNode, line: &Line) -> Result<CellTopics, TopicError> {
    let (to, from) = mpsc::channel(QUEUE);
    let mut tasks = vec![
        serve(node.service::<SubmitOrders>("~/submit_order")?, to.clone(), CellInbound::Submit),
        serve(node.service::<ChangeOrder>("~/cancel_order")?, to.clone(), |asked, reply| {
            CellInbound::Cancel(asked.name, reply)
        }),
        serve(node.service::<ChangeOrder>("~/withdraw_order")?, to.clone(), |asked, reply| {
            CellInbound::Withdraw(asked.name, reply)
        }),
        serve(node.service::<AnswerAlarm>("~/answer_alarm")?, to.clone(), |asked, reply| {
            CellInbound::Answer(asked.alarm, asked.word, asked.by, reply)
        }),
        serve(node.service::<SetResource>("~/set_resource")?, to.clone(), CellInbound::Resource),
        serve(node.service::<WhyNot>("~/why_not")?, to.clone(), |asked, reply| CellInbound::Why(asked.about, reply)),
    ];
    let dispatch = node.action::<DispatchOrder>("~/dispatch_order")?;
    let (dispatch, task) = serve_action(dispatch, to.clone(), CellInbound::Goal);
    tasks.push(task);
    let mut says =
        CellPublishers { state: node.publisher("~/cell_state", qos::latched_state())?, stations: Vec::new() };
    let pace = MessagePace::new(line.timing.refresh, line.timing.stale);
    for id in line.station_ids().filter(|&id| line.station(id).is_task_driven()) {
        let name = &line.station(id).name;
        let state = node.subscription(&format!("{name}/order"), qos::latched_state())?;
        tasks.push(forward_present(state, to.clone(), pace.clone(), move |message, _| {
            Some(CellInbound::Heard(id, Box::new(message)))
        }));
        let state = node.subscription(&format!("{name}/state"), qos::latched_state())?;
        tasks.push(forward_present(state, to.clone(), pace.clone(), move |message, _| {
            Some(CellInbound::State(id, Box::new(message)))
        }));
        says.stations.push(TaskStationTopics {
            station: id,
            tasks: node.action_caller::<RunTask>(&format!("{name}/run_task"), Mapping::Enhanced)?,
            secure: node.publisher(&format!("{name}/secure"), qos::command())?,
        });
    }
    Ok(CellTopics { says, dispatch, from, tasks })
}
