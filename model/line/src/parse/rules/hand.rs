//! Hand-mode types against each other (seed 002 Figure 21 and Table 3).
//!
//! In hand mode one held button runs a sequence of operations. A type says which part of a sequence an operation is,
//! so the types of neighbours, going round the cycle, must tell the same story.

use linewright_text::{At, Problem, Report};

use crate::Hand;
use crate::parse::draft::{DraftOperation, DraftStation};
use crate::parse::hand::purpose;
use crate::parse::raw::Kind;

/// Each step's hand entry with the operation that stands for the step, and the following step's, going round.
fn neighbours<'s>(
    station: &'s DraftStation<'s>,
) -> impl Iterator<Item = (&'s DraftOperation<'s>, &'s At<Hand>, &'s DraftOperation<'s>, &'s At<Hand>)> {
    let count = station.steps.len();
    (0..count).filter_map(move |index| {
        let this = station.operation(*station.steps[index].first()?);
        let next = station.operation(*station.steps[(index + 1) % count].first()?);
        Some((this, this.hand.as_ref()?, next, next.hand.as_ref()?))
    })
}

pub(super) fn modules_suit_their_types(station: &DraftStation<'_>, report: &mut Report) {
    for operation in &station.operations {
        let Some(hand) = &operation.hand else { continue };
        let number = hand.value.number();
        if operation.kind() == Some(Kind::Irreversible) && number >= 3 {
            report.add(
                Problem::error(
                    hand.at.clone(),
                    format!("irreversible operation `{}` has hand type {number}", operation.name),
                )
                .label("reverses")
                .hint("an irreversible operation has hand type 1 or 2"),
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
        let number = hand.value.number();
        let allowed: &[u8] = match hand.value {
            Hand::Sequence { .. } => &[1, 2],
            Hand::ReversedStart { .. } | Hand::ReversedMiddle { .. } => &[4, 5],
            Hand::SequenceEnd { .. } | Hand::ReversedEnd { .. } | Hand::Single { .. } => continue,
        };
        if !allowed.contains(&next_hand.value.number()) {
            let message = format!(
                "`{}` has hand type {number}, but `{}` after it has type {}",
                this.name,
                next.name,
                next_hand.value.number()
            );
            report.add(Problem::error(hand.at.clone(), message).also(&next_hand.at, "what follows").hint(format!(
                "type {number} is followed by {} or {}: it is {}",
                allowed[0],
                allowed[1],
                purpose(number)
            )));
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
        if matches!(next_hand.value.number(), 4 | 5) && !matches!(hand.value.number(), 3 | 4) {
            let number = next_hand.value.number();
            let message = format!(
                "`{}` has hand type {number}, but `{}` before it has type {}",
                next.name,
                this.name,
                hand.value.number()
            );
            report.add(
                Problem::error(next_hand.at.clone(), message)
                    .also(&hand.at, "what comes before")
                    .hint(format!("type {number} is preceded by 3 or 4: it is {}", purpose(number))),
            );
        }
    }
}

/// A sequence that goes round the whole cycle would run for as long as the button is held.
pub(super) fn sequences_end(station: &DraftStation<'_>, report: &mut Report) {
    let numbers: Option<Vec<u8>> =
        station.operations.iter().map(|op| op.hand.as_ref().map(|hand| hand.value.number())).collect();
    let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) else { return };
    if numbers.iter().all(|n| matches!(n, 1 | 3 | 4))
        && (numbers.iter().all(|&n| n == 1) || numbers.iter().all(|&n| n == 4))
    {
        let last = if numbers[0] == 1 { 2 } else { 5 };
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
