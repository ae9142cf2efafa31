//! Hand-mode types against each other (seed 002 Figure 21 and Table 3).
//!
//! In hand mode one held button runs a sequence of operations. A type is the part of a sequence that an operation is,
//! so the types of neighbours, going round the cycle, must agree.

use linewright_text::{Located, Problem, Report, TextRange};

use crate::parse::draft::{DraftOperation, DraftStation, DraftTask};
use crate::parse::raw::ModuleKind;
use crate::{HandMode, HandType};

/// Each step's hand entry with the operation that stands for the step, and the following step's, going round; at a
/// task-driven station as far as the task goes.
fn neighbours<'s>(
    station: &'s DraftStation<'s>,
) -> impl Iterator<Item = (&'s DraftOperation<'s>, &'s Located<HandMode>, &'s DraftOperation<'s>, &'s Located<HandMode>)>
{
    let count = station.steps.len();
    let task = |index: usize| station.operation(*station.steps[index].first()?).task.as_ref().map(|task| task.value);
    // Sequences stay within a task; in a cycle they go round.
    let follows =
        move |index: &usize| !station.is_task_driven() || (index + 1 < count && task(*index) == task(index + 1));
    (0..count).filter(follows).filter_map(move |index| {
        let this = station.operation(*station.steps[index].first()?);
        let next = station.operation(*station.steps[(index + 1) % count].first()?);
        Some((this, this.hand.as_ref()?, next, next.hand.as_ref()?))
    })
}

pub(super) fn modules_suit_their_types(station: &DraftStation<'_>, report: &mut Report) {
    for operation in station.operations.iter().filter(|operation| operation.task.is_none()) {
        let Some(hand) = &operation.hand else { continue };
        let kind = hand.value.kind();
        if operation.kind() == Some(ModuleKind::Irreversible) && kind.has_back() {
            report.add(
                Problem::error(
                    hand.at.clone(),
                    format!("irreversible operation `{}` has hand type {kind}", operation.name),
                )
                .label("reverses")
                .hint(format!("an irreversible operation has hand type {}", types(|kind| !kind.has_back()))),
            );
        }
    }
}

pub(super) fn groups_share_one_entry(station: &DraftStation<'_>, report: &mut Report) {
    for step in &station.steps {
        let Some(first) = step.first().map(|&op| station.operation(op)) else { continue };
        for &op in &step[1..] {
            let operation = station.operation(op);
            if let (Some(a), Some(b)) = (&first.hand, &operation.hand)
                && a.value != b.value
            {
                report.add(
                    Problem::error(
                        b.at.clone(),
                        format!("`{}` runs beside `{}`, but has another hand entry", operation.name, first.name),
                    )
                    .also(&a.at, "this one")
                    .hint("operations side by side are started by the same buttons: give them equal entries"),
                );
            }
        }
    }
}

/// Types 1, 3 and 4 are followed by more of the same sequence.
pub(super) fn sequences_continue(station: &DraftStation<'_>, report: &mut Report) {
    for (this, hand, next, next_hand) in neighbours(station) {
        let (kind, next_kind) = (hand.value.kind(), next_hand.value.kind());
        let Some(allowed) = kind.followed_by() else { continue };
        if !allowed.contains(&next_kind) {
            if station.is_task_driven() {
                continue;
            }
            let message =
                format!("`{}` has hand type {kind}, but `{}` after it has type {next_kind}", this.name, next.name);
            let hint = format!("type {kind} is followed by {} or {}: it is {}", allowed[0], allowed[1], kind.purpose());
            report.add(Problem::error(hand.at.clone(), message).also(&next_hand.at, "what follows").hint(hint));
        } else if (hand.value.forward(), hand.value.back()) != (next_hand.value.forward(), next_hand.value.back()) {
            let message = format!("`{}` and `{}` are one sequence, but have different buttons", this.name, next.name);
            report.add(
                Problem::error(next_hand.at.clone(), message)
                    .also(&hand.at, "the same sequence")
                    .hint("one button runs a whole sequence; a second one runs it back"),
            );
        }
    }
}

/// Types 4 and 5 are preceded by the beginning of a reversed sequence. (A type 2 may stand alone.)
pub(super) fn sequences_begin(station: &DraftStation<'_>, report: &mut Report) {
    for (this, hand, next, next_hand) in neighbours(station) {
        let (kind, next_kind) = (hand.value.kind(), next_hand.value.kind());
        let Some(allowed) = next_kind.preceded_by().filter(|allowed| !allowed.contains(&kind)) else { continue };
        if station.is_task_driven() {
            continue;
        }
        let message =
            format!("`{}` has hand type {next_kind}, but `{}` before it has type {kind}", next.name, this.name);
        let hint =
            format!("type {next_kind} is preceded by {} or {}: it is {}", allowed[0], allowed[1], next_kind.purpose());
        report.add(Problem::error(next_hand.at.clone(), message).also(&hand.at, "what comes before").hint(hint));
    }
}

/// A sequence that goes round the whole cycle would run for as long as the button is held.
pub(super) fn sequences_end(station: &DraftStation<'_>, report: &mut Report) {
    let kinds: Option<Vec<HandType>> =
        station.operations.iter().map(|op| op.hand.as_ref().map(|hand| hand.value.kind())).collect();
    let Some([first, others @ ..]) = kinds.as_deref() else { return };
    // A type that may follow itself all round.
    if let Some([again, last]) = first.followed_by()
        && again == *first
        && others.iter().all(|kind| kind == first)
    {
        report.add(
            Problem::error(station.place(), format!("in hand mode the cycle of station `{}` never ends", station.name))
                .hint(format!("give the last operation of the sequence hand type {last}")),
        );
    }
}

pub(super) fn next_is_the_following_forward(station: &DraftStation<'_>, report: &mut Report) {
    for (this, hand, next, next_hand) in neighbours(station) {
        let Some(button) = hand.value.next() else { continue };
        if button != next_hand.value.forward() {
            let at = this.raw.hand.as_ref().and_then(|h| h.next.as_ref()).map_or(&hand.at, |n| &n.at);
            let forward = next.raw.hand.as_ref().and_then(|h| h.forward.as_ref());
            let wanted = forward.map_or("?", |f| f.value.as_str());
            report.add(
                Problem::error(at.clone(), format!("`next` of `{}` does not start `{}`", this.name, next.name))
                    .also(forward.map_or(&next_hand.at, |f| &f.at), "its `forward`")
                    .hint(format!("write next = \"{wanted}\": it is the button that runs what follows")),
            );
        }
    }
}

/// The types of a task's operations: a button runs one task at most, since what follows is an operator's choice. One problem for a task,
/// whose advice has the types of all its operations. Where operations of a task stand apart, that is reported alone.
pub(super) fn tasks_are_sequences(station: &DraftStation<'_>, report: &mut Report) {
    for (at, task) in station.tasks.iter().enumerate().filter(|(_, task)| !task.ops.is_empty()) {
        let operations = &station.operations[task.ops.clone()];
        let of_task =
            |operation: &&DraftOperation<'_>| operation.task.as_ref().is_some_and(|of| of.value.index() == at);
        if station.operations.iter().filter(of_task).count() != operations.len() {
            continue;
        }
        if let Some((at, message)) = wrong_type(task, operations) {
            report.add(Problem::error(at, message).hint(types_of_task(task, operations)));
        }
    }
}

/// The type as it is written, also where a button that it needs is missing.
fn written(operation: &DraftOperation<'_>) -> Option<HandType> {
    HandType::numbered(operation.raw.hand.as_ref()?.number.as_ref()?.value)
}

/// The first operation of a task whose type does not fit its place in it, or what it is.
fn wrong_type(task: &DraftTask<'_>, operations: &[DraftOperation<'_>]) -> Option<(TextRange, String)> {
    let last = operations.len() - 1;
    operations.iter().enumerate().find_map(|(nth, this)| {
        let (kind, at) = (written(this)?, this.raw.hand.as_ref()?.at.clone());
        let next = operations.get(nth + 1).and_then(|next| Some((next, written(next)?)));
        let misfit = |(_, next): &(&DraftOperation<'_>, HandType)| {
            let follows = kind.followed_by().is_none_or(|allowed| allowed.contains(next));
            !follows || next.preceded_by().is_some_and(|allowed| !allowed.contains(&kind))
        };
        let name = this.name;
        let message = if this.kind() == Some(ModuleKind::Irreversible) && kind.has_back() {
            format!("irreversible operation `{name}` has hand type {kind}")
        } else if nth == 0 && kind.preceded_by().is_some() {
            format!("`{name}` begins task `{}`, but has hand type {kind}", task.name)
        } else if nth == last && kind.followed_by().is_some() {
            format!("`{name}` ends task `{}`, but has hand type {kind}", task.name)
        } else {
            let (after, next) = next.filter(misfit)?;
            format!("`{name}` has hand type {kind}, but `{}` after it has type {next}", after.name)
        };
        Some((at, message))
    })
}

/// Types with which the operations of a task are one sequence, with the buttons that they need.
fn types_of_task(task: &DraftTask<'_>, operations: &[DraftOperation<'_>]) -> String {
    let of = |first: HandType, middle: HandType, last: HandType| {
        let end = operations.len() - 1;
        let kind = |nth: usize| match nth {
            nth if nth == end => last,
            0 => first,
            _ => middle,
        };
        let one = |(nth, operation): (usize, &DraftOperation<'_>)| format!("`{}` {}", operation.name, kind(nth));
        operations.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
    };
    let onwards = of(HandType::Sequence, HandType::Sequence, HandType::SequenceEnd);
    let is_alone = operations.len() == 1;
    let each = if is_alone { "" } else { "each " };
    let onwards = format!("{onwards}, {each}with `forward` alone");
    let types = format!("give task `{}` the types {onwards}", task.name);
    if operations.iter().any(|operation| operation.kind() == Some(ModuleKind::Irreversible)) {
        return types;
    }
    let end = if is_alone { HandType::Single } else { HandType::ReversedEnd };
    let reversed = of(HandType::ReversedStart, HandType::ReversedMiddle, end);
    format!("{types}; or, where a button is to lead it back, {reversed}, {each}with `forward` and `back`")
}

/// The types that suit, as `1, 2 or 6`.
fn types(suits: fn(HandType) -> bool) -> String {
    let types: Vec<String> = HandType::ALL.iter().filter(|kind| suits(**kind)).map(ToString::to_string).collect();
    let (last, others) = types.split_last().expect("some type suits");
    format!("{} or {last}", others.join(", "))
}

/// Where several tasks begin, each has a button of its own, and none takes back what has just ended there. Within a task
/// too, a button that takes an operation back does not lead on: there are no arrows that could decide which is meant.
pub(super) fn buttons_tell_tasks_apart(station: &DraftStation<'_>, report: &mut Report) {
    let whole = || station.tasks.iter().filter(|task| !task.ops.is_empty());
    for (nth, task) in whole().enumerate() {
        let first = &station.operations[task.ops.start];
        let (Some(hand), Some(from)) = (&first.hand, &task.from) else { continue };
        let forward = hand.value.forward();
        let at = first.raw.hand.as_ref().and_then(|hand| hand.forward.as_ref()).map_or(&hand.at, |name| &name.at);
        let begins = |other: &&DraftTask<'_>| other.from.as_ref().is_some_and(|rest| rest.value == from.value);
        let same = whole().take(nth).filter(begins).find(|other| {
            station.operations[other.ops.start].hand.as_ref().is_some_and(|hand| hand.value.forward() == forward)
        });
        if let Some(other) = same {
            let message = format!("tasks `{}` and `{}` begin at one rest by one button", other.name, task.name);
            report.add(
                Problem::error(at.clone(), message)
                    .also(&other.place(), "the other one")
                    .hint("give each task that begins at a rest a `forward` of its own"),
            );
        }
        let ended = whole().filter(|other| other.to.as_ref().is_some_and(|rest| rest.value == from.value));
        let back = ended
            .map(|other| &station.operations[other.ops.end - 1])
            .find(|last| last.hand.as_ref().is_some_and(|hand| hand.value.back() == Some(forward)));
        if let Some(last) = back {
            let message = format!("one button begins task `{}` and takes back `{}`", task.name, last.name);
            report.add(
                Problem::error(at.clone(), message)
                    .also(&last.place(), "which ends there")
                    .hint("give `back` a button of its own, or the operation hand type 2, which has none"),
            );
        }
    }
    for (this, hand, next, _) in neighbours(station).filter(|_| station.is_task_driven()) {
        if hand.value.next().is_some() && hand.value.next() == hand.value.back() {
            let message = format!("one button takes `{}` back and leads on to `{}`", this.name, next.name);
            report.add(
                Problem::error(hand.at.clone(), message)
                    .hint("give `back` a button of its own, or the operation hand type 2, which has none"),
            );
        }
    }
}
