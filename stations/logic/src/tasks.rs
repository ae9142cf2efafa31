//! A station's tasks, compiled: tables of a task-driven station beside those of every station.

use std::sync::Arc;
use std::time::Duration;

use linewright_line::{MotionResult, OpId, Parameter, RestId, Station, TaskId};

/// The tasks of a task-driven station.
#[derive(Clone, Debug)]
pub(crate) struct StationTasks {
    pub tasks: Vec<TaskTable>,
    /// For each operation, its task.
    pub task_of: Vec<TaskId>,
    /// For each step, the inputs that must be on before it starts, and the code for when they are not in time.
    pub waits: Vec<(u128, u16)>,
    /// For each step, the result of the step before it in its task, which must be there before it starts.
    pub results: Vec<Option<MotionResult>>,
    /// All of those inputs.
    pub watched: u128,
}

/// One task.
#[derive(Clone, Debug)]
pub(crate) struct TaskTable {
    pub name: String,
    pub first_step: u8,
    pub first: OpId,
    pub last: OpId,
    pub from: RestId,
    pub to: RestId,
    pub limit: Duration,
    pub parameters: Vec<Parameter>,
}

/// Reason why numbers are not those of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberMisfit {
    Missing,
    /// No parameter of the task has this name, or it is given twice.
    NoParameter,
    OutOfRange,
}

impl TaskTable {
    /// The outputs that carry these numbers. One that is missing is not guessed.
    pub fn image(&self, numbers: &[(Arc<str>, i32)]) -> Result<u128, NumberMisfit> {
        let mut image = 0;
        for parameter in &self.parameters {
            let given = numbers.iter().find(|(name, _)| **name == *parameter.name).ok_or(NumberMisfit::Missing)?;
            image |= parameter.image(given.1).ok_or(NumberMisfit::OutOfRange)?;
        }
        if numbers.len() == self.parameters.len() { Ok(image) } else { Err(NumberMisfit::NoParameter) }
    }
}

impl StationTasks {
    /// Of a task-driven station; none for one that goes round a cycle.
    pub fn of(station: &Station) -> Option<Self> {
        if !station.is_task_driven() {
            return None;
        }
        let task = |id: TaskId| {
            let task = station.task(id);
            TaskTable {
                name: task.name.clone(),
                first_step: task.steps.start as u8,
                first: station.first_of(id),
                last: station.last_of(id),
                from: task.from,
                to: task.to,
                limit: task.limit,
                parameters: task.parameters.clone(),
            }
        };
        let waits = |step: &Vec<OpId>| {
            let operation = &station.operations[step[0].index()];
            (operation.waits.iter().fold(0, |bits, input| bits | input.bit()), operation.waits_code)
        };
        let waits: Vec<(u128, u16)> = station.steps.iter().map(waits).collect();
        Some(StationTasks {
            tasks: station.task_ids().map(task).collect(),
            // A checked description has a task for every operation.
            task_of: station.op_ids().map(|op| station.task_of(op).unwrap_or(TaskId(0))).collect(),
            watched: station.awaited_inputs().fold(0, |all, input| all | input.bit()),
            results: (0..station.steps.len()).map(|step| Some(station.result_before(step)?.1)).collect(),
            waits,
        })
    }

    pub fn task(&self, id: TaskId) -> &TaskTable {
        &self.tasks[id.index()]
    }

    /// Whether a step is the first one of a task.
    pub fn begins_with(&self, step: u8) -> bool {
        self.tasks.iter().any(|task| task.first_step == step)
    }
}
