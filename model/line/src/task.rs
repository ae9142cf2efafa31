//! Task-driven stations: they rest until one of their tasks is ordered, and rest again when it is done.
//!
//! A rest is a position of the whole station, by name: a clamp has two, open and closed on a part. A task leads from one
//! rest to another, or to the same, and its operations are a stretch of the station's list. What is at one rest is at one
//! physical position, so a rest needs no place of its own in the net: the station is at it where the last operation of
//! any task that ends there is complete. The source of orders is elsewhere.

use std::ops::Range;
use std::time::Duration;

use linewright_text::index_id;

use crate::{Conflict, InputId, Line, MotionResult, OpId, OutputId, Station};

index_id! {
    /// A task of one station, by its place in [`Station::tasks`].
    TaskId
}
index_id! {
    /// A rest of one station, by its place in [`Station::rests`].
    RestId
}

/// At most this many tasks in one station.
pub const TASKS_MAX: usize = 16;
/// What a confirmation of a station's position begins with where it names a rest, and no operation.
pub const REJOIN_AT_REST: &str = "rest: ";

/// At most this many rests in one station.
pub const RESTS_MAX: usize = 8;
/// At most this many parameters of one task.
pub const PARAMETERS_MAX: usize = 8;
/// At most this many bits of one parameter: it is an `i32` that is not negative.
pub const PARAMETER_BITS_MAX: usize = 31;
/// The greatest code that a description may give; greater ones are the controller's own.
pub const CODE_MAX: u16 = 999;

/// Senders from which a task-driven station takes orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TaskOrderSource {
    /// The participant of ROS 2 that sends the mode the station follows.
    Coordinator,
    /// Any participant, for a dispatcher beside the coordinator.
    Any,
}

/// Rest of a task-driven station, between its tasks.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// Name, as in the description.
    pub name: String,
    /// Position of each axis, in the order of [`Station::axes`]; millimetres, or degrees.
    pub at: Vec<f64>,
}

/// Task of a task-driven station.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Name, as in the description.
    pub name: String,
    /// Its steps, a stretch of [`Station::steps`], of one operation each; never empty.
    pub steps: Range<usize>,
    /// Rest at its beginning.
    pub from: RestId,
    /// Rest at its end.
    pub to: RestId,
    /// After this long it has failed, whatever time an order leaves it.
    pub limit: Duration,
    /// Numbers that come with an order and stand on outputs while the task is done.
    pub parameters: Vec<Parameter>,
}

/// A number that comes with an order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Name, as in the description.
    pub name: String,
    /// The outputs that carry it, the lowest bit first; none drives anything.
    pub bits: Vec<OutputId>,
}

impl Parameter {
    /// The greatest value it may have.
    pub fn most(&self) -> i32 {
        ((1u64 << self.bits.len().min(PARAMETER_BITS_MAX)) - 1) as i32
    }

    /// The output image of a value; none where the value does not fit.
    pub fn image(&self, value: i32) -> Option<u128> {
        let fits = (0..=self.most()).contains(&value);
        let on = self.bits.iter().enumerate().filter(|(nth, _)| value >> nth & 1 != 0);
        fits.then(|| on.fold(0, |image, (_, output)| image | output.bit()))
    }
}

impl Line {
    /// Whether a conflict is of tasks: orders keep its states apart, and no arrows do.
    pub fn is_of_tasks(&self, conflict: &Conflict) -> bool {
        [conflict.a, conflict.b].iter().all(|span| self.station(span.station).is_task_driven())
    }

    /// The line without its conflicts of tasks.
    pub fn without_conflicts_of_tasks(&self) -> Line {
        let mut line = self.clone();
        line.conflicts.retain(|conflict| !self.is_of_tasks(conflict));
        line
    }
}

impl Station {
    /// Whether it is task-driven; else it goes round a cycle.
    pub fn is_task_driven(&self) -> bool {
        !self.tasks.is_empty()
    }

    /// The task with this id.
    pub fn task(&self, id: TaskId) -> &Task {
        &self.tasks[id.index()]
    }

    /// The task with this name.
    pub fn task_named(&self, name: &str) -> Option<TaskId> {
        self.tasks.iter().position(|task| task.name == name).map(TaskId::at)
    }

    /// All task ids, in the order of the description.
    pub fn task_ids(&self) -> impl Iterator<Item = TaskId> + use<> {
        (0..self.tasks.len()).map(TaskId::at)
    }

    /// The operations of a task, in their order.
    pub fn operations_of(&self, task: TaskId) -> impl Iterator<Item = OpId> + '_ {
        self.steps[self.task(task).steps.clone()].iter().flatten().copied()
    }

    /// The result that must be there in auto before a step starts: that of the operation before it in its task.
    pub fn result_before(&self, step: usize) -> Option<(OpId, MotionResult)> {
        let task = self.tasks.iter().find(|task| task.steps.contains(&step))?;
        let before = step.checked_sub(1).filter(|before| task.steps.contains(before))?;
        let op = *self.steps[before].first()?;
        self.operations[op.index()].result.map(|result| (op, result))
    }

    /// All inputs that operations wait for before they start, with the results of those before them.
    pub fn awaited_inputs(&self) -> impl Iterator<Item = InputId> + '_ {
        self.operations.iter().flat_map(|op| op.waits.iter().copied().chain(op.result.map(|result| result.input)))
    }

    /// The inputs that must be on before an operation starts in auto, with the result of the one before it in its task.
    pub fn awaited_by(&self, op: OpId) -> impl Iterator<Item = InputId> + '_ {
        let before = self.result_before(self.step_of(op)).map(|(_, result)| result.input);
        self.operations[op.index()].waits.iter().copied().chain(before)
    }

    /// Whether an operation of a task waits for inputs before it starts, in every mode: in auto alone there are results besides.
    pub fn waits_for_inputs(&self, task: TaskId) -> bool {
        self.operations_of(task).any(|op| !self.operations[op.index()].waits.is_empty())
    }

    /// The operation a task begins with.
    pub fn first_of(&self, task: TaskId) -> OpId {
        self.steps[self.task(task).steps.start][0]
    }

    /// The operation a task ends with.
    pub fn last_of(&self, task: TaskId) -> OpId {
        self.steps[self.task(task).steps.end - 1][0]
    }

    /// The task an operation belongs to; none in a station that goes round a cycle.
    pub fn task_of(&self, op: OpId) -> Option<TaskId> {
        let step = self.step_of(op);
        self.task_ids().find(|&task| self.task(task).steps.contains(&step))
    }

    /// The rest of this name.
    pub fn rest_named(&self, name: &str) -> Option<RestId> {
        self.rests.iter().position(|rest| rest.name == name).map(RestId::at)
    }

    /// The rest a station is at when this operation is complete; none within a task.
    pub fn rest_after(&self, op: OpId) -> Option<RestId> {
        let task = self.task_of(op).filter(|&task| self.last_of(task) == op)?;
        Some(self.task(task).to)
    }

    /// The rest a station is at when this operation has been undone; none within a task.
    pub fn rest_before(&self, op: OpId) -> Option<RestId> {
        let task = self.task_of(op).filter(|&task| self.first_of(task) == op)?;
        Some(self.task(task).from)
    }

    /// The tasks that begin at a rest, in the order of the description.
    pub fn tasks_from(&self, rest: RestId) -> impl Iterator<Item = TaskId> + '_ {
        self.task_ids().filter(move |&task| self.task(task).from == rest)
    }

    /// The operation that stands for a rest: the last one of the first task that ends there.
    pub fn arrival_at(&self, rest: RestId) -> Option<OpId> {
        self.task_ids().find(|&task| self.task(task).to == rest).map(|task| self.last_of(task))
    }

    /// The operation at the end of every recovery path from `failed`: that of its own task, or the home operation.
    pub fn path_end(&self, failed: OpId) -> OpId {
        self.task_of(failed).map_or(self.home, |task| self.last_of(task))
    }
}
