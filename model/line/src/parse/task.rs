//! Tasks and rests of a task-driven station: from the text to a draft, and from a draft to the line.
//!
//! A task's operations are found by the name of their task; that they stand together is for the rules.

use linewright_text::{Located, Report};

use super::draft::{DraftOperation, DraftParameter, DraftStation, DraftTask};
use super::names::StationNames;
use super::raw::RawStation;
use super::resolve::StationScope;
use crate::{OpId, Parameter, Rest, RestId, Task, TaskId};

/// Whether the `nth` operation is the last one of its task.
pub(super) fn ends(raw: &RawStation, nth: usize) -> bool {
    let task = |nth: usize| raw.operations.get(nth)?.task.as_ref().map(|name| &name.value);
    !raw.tasks.is_empty() && task(nth).is_some() && task(nth) != task(nth + 1)
}

/// Position of each axis in each rest: an axis that a rest leaves out is as at home.
pub(super) fn rests(raw: &RawStation, inside: &StationNames<'_>, report: &mut Report) -> Vec<Vec<f64>> {
    let mut rests = Vec::new();
    for rest in &raw.rests {
        let mut at: Vec<f64> = raw.axes.iter().map(|(_, home)| *home).collect();
        for (name, position) in &rest.positions {
            if let Some(axis) = inside.axes.find(name, "axis", report) {
                at[axis] = *position;
            }
        }
        rests.push(at);
    }
    rests
}

/// The tasks, with the operations that name them.
pub(super) fn tasks<'a>(
    raw: &'a RawStation,
    inside: &StationNames<'a>,
    operations: &[DraftOperation<'a>],
    scope: &mut StationScope<'a, '_>,
    report: &mut Report,
) -> Vec<DraftTask<'a>> {
    let mut tasks = Vec::new();
    for (nth, raw) in raw.tasks.iter().enumerate() {
        let mut rest = |name: &'a Option<linewright_text::LocatedName>| {
            let name = name.as_ref()?;
            let rest = inside.rests.find(name, "rest", report)?;
            Some(Located::new(RestId::at(rest), name.at.clone()))
        };
        let (from, to) = (rest(&raw.from), rest(&raw.to));
        let parameters = raw.parameters.iter().map(|(name, bits)| DraftParameter {
            name: &name.value,
            bits: bits.value.iter().map(|bit| scope.output(Some(bit), report)).collect(),
        });
        tasks.push(DraftTask {
            raw,
            name: raw.name.as_ref().map_or("?", |name| name.value.as_str()),
            from,
            to,
            ops: stretch(operations, TaskId::at(nth)),
            parameters: parameters.collect(),
        });
    }
    tasks
}

/// The first operations of a task that stand together.
fn stretch(operations: &[DraftOperation<'_>], task: TaskId) -> std::ops::Range<usize> {
    let of = |op: &DraftOperation<'_>| op.task.as_ref().is_some_and(|of| of.value == task);
    let begin = operations.iter().position(of).unwrap_or(operations.len());
    begin..begin + operations[begin..].iter().take_while(|op| of(op)).count()
}

/// The operation that stands for home: the last one of the first task that ends at the first rest.
pub(super) fn home(tasks: &[DraftTask<'_>]) -> Option<Located<OpId>> {
    let ends_at_home = |task: &&DraftTask<'_>| task.to.as_ref().is_some_and(|to| to.value == RestId(0));
    let task = tasks.iter().filter(|task| !task.ops.is_empty()).find(ends_at_home)?;
    Some(Located::new(OpId::at(task.ops.end - 1), task.place()))
}

/// Puts in what follows where a task ends: the button of the first task listed that begins there.
pub(super) fn lead_on(operations: &mut [DraftOperation<'_>], tasks: &[DraftTask<'_>]) {
    for task in tasks.iter().filter(|task| !task.ops.is_empty()) {
        let rest = |end: &Option<Located<RestId>>| end.as_ref().map(|rest| rest.value);
        let follows = tasks.iter().filter(|next| !next.ops.is_empty()).find(|next| rest(&next.from) == rest(&task.to));
        let button = follows.and_then(|next| operations[next.ops.start].hand.as_ref()).map(|hand| hand.value.forward());
        if let (Some(button), Some(hand)) = (button, &mut operations[task.ops.end - 1].hand) {
            let (forward, back) = (hand.value.forward(), hand.value.back());
            hand.value = hand.value.kind().with(forward, back, Some(button)).unwrap_or(hand.value);
        }
    }
}

pub(super) fn finish_rests(draft: &DraftStation<'_>) -> Option<Vec<Rest>> {
    let rests = draft.raw.rests.iter().zip(&draft.rests);
    rests.map(|(raw, at)| Some(Rest { name: raw.name.as_ref()?.value.clone(), at: at.clone() })).collect()
}

/// Its operations run one at a time, so they are numbered as its steps are.
pub(super) fn finish(draft: &DraftTask<'_>) -> Option<Task> {
    let parameter = |parameter: &DraftParameter<'_>| {
        let bits = parameter.bits.iter().map(|bit| bit.as_ref().map(|bit| bit.value));
        Some(Parameter { name: parameter.name.to_owned(), bits: bits.collect::<Option<_>>()? })
    };
    Some(Task {
        name: draft.raw.name.as_ref()?.value.clone(),
        steps: draft.ops.clone(),
        from: draft.from.as_ref()?.value,
        to: draft.to.as_ref()?.value,
        limit: draft.raw.limit.as_ref()?.value,
        parameters: draft.parameters.iter().map(parameter).collect::<Option<_>>()?,
    })
}
