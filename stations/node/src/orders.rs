//! ROS 2 interface of a task-driven station.
//!
//! Orders come as goals of the action `~/run_task`; one order may come by any number of goals, and each of them ends as the
//! order does. It is left by cancelling a goal, or by `~/secure`, where it can be stopped as well. The state of all orders goes
//! out on `~/order`, whole each time: a coordinator reads the ends there, and need not wait for any single answer. Nothing is
//! decided here; that is the controller's affair.

use std::time::Duration;

use linewright_line::{Line, Station};
use linewright_msgs::{
    Bounded, OrderEnd, OrderState, RunTask, RunTaskFeedback, RunTaskGoal, RunTaskResult, SecureOrder, fitting,
};
use linewright_node_shell::{
    ActionOwner, Forward, GoalAsked, GoalEnd, GoalHandle, GoalRequest, Publisher, RosNode, TopicError, forward, qos,
    serve_action, stamp,
};
use linewright_station_logic::{
    Controller, LeaveWay, OrderKey, SlotReport, StationReport, TaskCommand, TaskFailure, TaskOrder, TaskOrderReport,
    TaskOutcome, TaskRefusal, TaskReply,
};
use tokio::sync::mpsc;

use crate::topics::StationInbound;

/// Reason why an order, or an order to leave one, of another sender than the coordinator is not taken.
pub(crate) const REFUSED_SENDER: &str = "rejected: not from the coordinator that the station follows; for another dispatcher, set \
     `orders = \"any\"` in the station's table";

/// A command to the controller, as it came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OrderInbound {
    /// A task.
    Run(TaskOrder),
    /// To leave an order.
    Leave(OrderKey, LeaveWay),
}

impl OrderInbound {
    /// As the controller takes it.
    pub fn command(&self) -> TaskCommand<'_> {
        match self {
            OrderInbound::Run(order) => TaskCommand::Run(order),
            OrderInbound::Leave(key, way) => TaskCommand::Leave(*key, *way),
        }
    }
}

struct OngoingGoal {
    goal: GoalHandle,
    key: OrderKey,
    is_cancelled: bool,
}

/// A station's orders, as ROS 2 sees them.
pub struct TaskOrderTopics {
    owner: ActionOwner<RunTask>,
    state: Publisher<OrderState>,
    goals: Vec<OngoingGoal>,
    /// Progress of the order that was last published.
    told: Option<(OrderKey, RunTaskFeedback)>,
    report: StationReport,
    message: OrderState,
}

impl TaskOrderTopics {
    /// Opens the action and the topics of a task-driven station, with the fingerprint of its description.
    pub fn open(
        node: &mut RosNode,
        (station, description): (&str, u64),
        boot_id: u64,
        to: &mpsc::Sender<StationInbound>,
        tasks: &mut Vec<Forward>,
    ) -> Result<Self, TopicError> {
        let state = node.publisher("~/order", qos::latched_state())?;
        let (owner, serving) = serve_action(node.action::<RunTask>("~/run_task")?, to.clone(), StationInbound::Goal);
        tasks.push(serving);
        let secure = node.subscription("~/secure", qos::command())?;
        tasks.push(forward(secure, to.clone(), |message: SecureOrder, source| {
            let key = OrderKey { epoch: message.epoch, id: message.id };
            Some(StationInbound::Secure(key, LeaveWay::from_number(message.way), source.participant()))
        }));
        let message = OrderState { boot_id, station: station.to_owned(), description, ..OrderState::default() };
        Ok(TaskOrderTopics { owner, state, goals: Vec::new(), told: None, report: StationReport::default(), message })
    }

    /// The station begins another life.
    pub fn renew(&mut self, boot_id: u64) {
        (self.message.boot_id, self.message.sequence, self.told) = (boot_id, 0, None);
    }

    /// Ends a goal of a sender whose orders are not taken, or lets one go on that it would cancel. Only this goal: the coordinator may have one of the same order.
    pub fn refuse_sender(&self, request: GoalRequest<RunTaskGoal>) {
        match request.asked {
            GoalAsked::New(RunTaskGoal { epoch, id, .. }) => {
                let (end, code) = (RunTaskResult::END_REFUSED, RunTaskResult::REFUSED_SENDER);
                let text = REFUSED_SENDER.to_owned();
                self.owner.end(request.goal, GoalEnd::Aborted, RunTaskResult { epoch, id, end, code, text });
            }
            GoalAsked::Cancel => self.owner.goes_on(request.goal),
        }
    }

    /// The controller's input from a goal request.
    pub fn asked(&mut self, request: GoalRequest<RunTaskGoal>) -> Option<OrderInbound> {
        let goal = request.goal;
        match request.asked {
            GoalAsked::New(wanted) => {
                let order = order(wanted);
                self.goals.push(OngoingGoal { goal, key: order.key, is_cancelled: false });
                Some(OrderInbound::Run(order))
            }
            GoalAsked::Cancel => {
                let live = self.goals.iter_mut().find(|live| live.goal == goal)?;
                live.is_cancelled = true;
                let key = live.key;
                // The coordinator orders it back, if no other station relies on where it stands.
                Some(self.secure(key, LeaveWay::Hold))
            }
        }
    }

    /// The controller's input from an order to leave an order.
    pub fn secure(&mut self, key: OrderKey, way: LeaveWay) -> OrderInbound {
        // Nothing follows from a hold but the end of the order, which the results show.
        if way == LeaveWay::Hold {
            return OrderInbound::Leave(key, way);
        }
        // In effect from the next state on, which is made after the controller has taken it in.
        let message = &mut self.message;
        let is_same = (message.secured_epoch, message.secured_id) == (key.epoch, key.id);
        let before = if is_same { message.secured_way } else { 0 };
        (message.secured_epoch, message.secured_id) = (key.epoch, key.id);
        message.secured_way = before.max(way.number());
        OrderInbound::Leave(key, way)
    }

    /// Publishes the progress of orders, once it is recorded. The whole state goes out when it is `due`.
    pub fn tell(
        &mut self,
        line: &Line,
        controller: &Controller,
        replies: impl Iterator<Item = (OrderKey, TaskReply)>,
        inputs: u128,
        due: bool,
    ) {
        for (key, reply) in replies {
            match reply {
                TaskReply::Running => (),
                TaskReply::Ended(outcome) => self.end(key, outcome),
                TaskReply::Refused(refusal) => self.refuse(key, refusal),
            }
        }
        let mut report = std::mem::take(&mut self.report);
        controller.report_into(&mut report);
        if let Some(orders) = &report.order {
            self.follow(line, controller, orders);
            if due {
                let inputs = report.devices_valid.then_some(inputs);
                self.tell_state(line.station(controller.station()), orders, inputs);
            }
        }
        self.report = report;
    }

    /// Goals end as in the report, with feedback on the progress of their order.
    fn follow(&mut self, line: &Line, controller: &Controller, orders: &TaskOrderReport) {
        if !self.goals.is_empty() {
            orders.results.iter().for_each(|&(key, outcome)| self.end(key, outcome));
            orders.refused.iter().for_each(|&(key, refusal)| self.refuse(key, refusal));
            if let Some(slot) = &orders.slot {
                self.feed_back(line, controller, slot);
            }
        }
    }

    fn tell_state(&mut self, station: &Station, orders: &TaskOrderReport, inputs: Option<u128>) {
        let message = &mut self.message;
        message.header = stamp();
        message.sequence += 1;
        (message.memory, message.epoch) = (orders.memory, orders.epoch);
        (message.doing_epoch, message.doing_id) = orders.slot.map_or((0, 0), |slot| (slot.key.epoch, slot.key.id));
        message.phase = orders.slot.map_or(0, phase);
        message.in_handshake = orders.is_in_handshake;
        message.rest = orders.rest.map(|rest| station.rests[rest.index()].name.clone()).unwrap_or_default();
        let ended = orders.results.iter().map(|&(key, outcome)| {
            let (end, code) = end_of(outcome);
            OrderEnd { epoch: key.epoch, id: key.id, end, code }
        });
        // A station keeps no more than the message has room for.
        message.ended = Bounded::new(ended.collect()).unwrap_or_default();
        let refused = orders.refused.iter().map(|&(key, refusal)| {
            let code = refusal.code();
            OrderEnd { epoch: key.epoch, id: key.id, end: RunTaskResult::END_REFUSED, code }
        });
        message.refused = Bounded::new(refused.collect()).unwrap_or_default();
        let bytes = station.inputs.len().div_ceil(8);
        let inputs = inputs.map(|word| word.to_le_bytes()[..bytes].to_vec()).unwrap_or_default();
        message.inputs = Bounded::new(inputs).unwrap_or_default();
        self.state.send(message.clone());
    }

    fn end(&mut self, key: OrderKey, outcome: TaskOutcome) {
        let (end, code) = end_of(outcome);
        let text = match outcome {
            TaskOutcome::Done => String::new(),
            TaskOutcome::Failed(failure) => failure.text(),
        };
        self.conclude(key, RunTaskResult { epoch: key.epoch, id: key.id, end, code, text });
    }

    fn refuse(&mut self, key: OrderKey, refusal: TaskRefusal) {
        let (end, code) = (RunTaskResult::END_REFUSED, refusal.code());
        let text = refusal.text().to_owned();
        self.conclude(key, RunTaskResult { epoch: key.epoch, id: key.id, end, code, text });
    }

    /// All goals of an order end as it has.
    fn conclude(&mut self, key: OrderKey, result: RunTaskResult) {
        let owner = &self.owner;
        self.goals.retain(|live| {
            if live.key != key {
                return true;
            }
            let ended = match result.end {
                RunTaskResult::END_DONE => GoalEnd::Succeeded,
                // With any code: it was left on request.
                _ if live.is_cancelled => GoalEnd::Canceled,
                _ => GoalEnd::Aborted,
            };
            owner.end(live.goal, ended, result.clone());
            false
        });
    }

    fn feed_back(&mut self, line: &Line, controller: &Controller, slot: &SlotReport) {
        let feedback = feedback(line, controller, slot);
        let new = (slot.key, feedback);
        if self.told.as_ref() == Some(&new) {
            return;
        }
        for live in self.goals.iter().filter(|live| live.key == slot.key) {
            self.owner.feedback(live.goal, new.1.clone());
        }
        self.told = Some(new);
    }
}

fn order(wanted: RunTaskGoal) -> TaskOrder {
    TaskOrder {
        key: OrderKey { epoch: wanted.epoch, id: wanted.id },
        memory: wanted.memory,
        task: wanted.task.into(),
        parameters: wanted.parameter_names.into_iter().map(Into::into).zip(wanted.parameters).collect(),
        limit: Duration::from_millis(wanted.limit_ms.into()),
    }
}

const fn phase(slot: SlotReport) -> u8 {
    if slot.is_securing { RunTaskFeedback::PHASE_SECURING } else { RunTaskFeedback::PHASE_RUNNING }
}

fn feedback(line: &Line, controller: &Controller, slot: &SlotReport) -> RunTaskFeedback {
    let (id, station) = (controller.station(), line.station(controller.station()));
    let (first, last) = (station.first_of(slot.task), station.last_of(slot.task));
    let (from, to) = (station.step_of(first), station.step_of(last));
    // Before its first operation has started, the station stands behind the last one of another task.
    let at = controller.marking().next().map(|place| place.op);
    let op = at.filter(|&op| station.task_of(op) == Some(slot.task)).unwrap_or(first);
    let number = |step: usize| u16::try_from(step + 1).unwrap_or(u16::MAX);
    RunTaskFeedback {
        phase: phase(*slot),
        operation: fitting(line.operation((id, op)).name.clone()),
        step: number(station.step_of(op).saturating_sub(from)),
        steps: number(to - from),
    }
}

/// Outcome of an order, as in messages.
const fn end_of(outcome: TaskOutcome) -> (u8, u16) {
    match outcome {
        TaskOutcome::Done => (RunTaskResult::END_DONE, 0),
        TaskOutcome::Failed(TaskFailure::Cancelled) => (RunTaskResult::END_SECURED, TaskFailure::Cancelled.code()),
        TaskOutcome::Failed(failure) => (RunTaskResult::END_FAILED, failure.code()),
    }
}
