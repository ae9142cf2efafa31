//! Hand-mode types against each other (seed 002 Figure 21 and Table 3).
//!
//! In hand mode one held button runs a sequence of operations. A type is the part of a sequence that an operation is,
//! so the types of neighbours, going round the cycle, must agree.

use linewright_text::{Located, Problem, Report};

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
    for operation in &station.operations {
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

/// A button runs one task at most: what follows is an operator's choice.
pub(super) fn sequences_stay_in_their_task(station: &DraftStation<'_>, report: &mut Report) {
    for task in station.tasks.iter().filter(|task| !task.ops.is_empty()) {
        let (first, last) = (&station.operations[task.ops.start], &station.operations[task.ops.end - 1]);
        let mut check = |operation: &DraftOperation<'_>, what: &str, suits: fn(HandType) -> bool| {
            let Some(hand) = operation.hand.as_ref().filter(|hand| !suits(hand.value.kind())) else { return };
            let kind = hand.value.kind();
            let message = format!("`{}` {what} task `{}`, but has hand type {kind}", operation.name, task.name);
            report.add(Problem::error(hand.at.clone(), message).hint(format!("it takes {} there", types(suits))));
        };
        check(first, "begins", |kind| kind.preceded_by().is_none());
        check(last, "ends", |kind| kind.followed_by().is_none());
    }
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
