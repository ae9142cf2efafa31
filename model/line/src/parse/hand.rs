//! Hand-mode entries: a type's number and its buttons → [`HandMode`] (seed 002 Figure 21 and Table 3).
//!
//! Each type has its own set of buttons; what the types of neighbours have to do with each other is for
//! [`super::rules`].

use linewright_text::{Located, LocatedName, NameTable, Problem, Report};

use super::raw::RawHand;
use crate::{ButtonId, HandMode};

/// What the types are for, for hints.
pub(super) fn purpose(number: u8) -> &'static str {
    match number {
        1 => "the first or an intermediate operation of a sequence that is never reversed",
        2 => "the last operation of a sequence that is never reversed",
        3 => "the first operation of a reversed sequence",
        4 => "an intermediate operation of a reversed sequence",
        5 => "the last operation of a reversed sequence",
        _ => "an operation on its own, started by one button and reversed by another",
    }
}

/// Reads one entry. Where a task ends, what follows is whichever is begun: the entry has no `next`, and [`super::task`]
/// puts one in.
pub(super) fn hand(
    raw: &RawHand,
    buttons: &NameTable<'_>,
    ends_task: bool,
    report: &mut Report,
) -> Option<Located<HandMode>> {
    let mut press = |name: &Option<LocatedName>| {
        let name = name.as_ref()?;
        buttons.find(name, "button", report).map(ButtonId::at)
    };
    let (forward, back, next) = (press(&raw.forward), press(&raw.back), press(&raw.next));
    let number = raw.number.as_ref()?;
    let Some(kind) = u8::try_from(number.value).ok().filter(|n| (1..=6).contains(n)) else {
        report.add(
            Problem::error(number.at.clone(), format!("unknown hand type {}", number.value))
                .hint("hand types are 1 to 6: 1, 2 sequences; 3, 4, 5 reversed sequences; 6 on its own"),
        );
        return None;
    };
    wanted(raw, kind, "back", &raw.back, kind >= 3, report);
    match &raw.next {
        Some(name) if ends_task => report.add(
            Problem::error(name.at.clone(), "`next` where a task ends")
                .hint("leave it out: what follows is whichever task is begun, by its own `forward`"),
        ),
        None if ends_task => {}
        next => wanted(raw, kind, "next", next, matches!(kind, 2 | 5 | 6), report),
    }
    not_its_own_reverse(raw, kind, report);

    let forward = forward?;
    let next = if ends_task { Some(forward) } else { next };
    let hand = match kind {
        1 => HandMode::Sequence { forward },
        2 => HandMode::SequenceEnd { forward, next: next? },
        3 => HandMode::ReversedStart { forward, back: back? },
        4 => HandMode::ReversedMiddle { forward, back: back? },
        5 => HandMode::ReversedEnd { forward, back: back?, next: next? },
        _ => HandMode::Single { forward, back: back?, next: next? },
    };
    Some(Located::new(hand, raw.at.clone()))
}

/// Reports a button that the type needs and the entry lacks, or the reverse.
fn wanted(raw: &RawHand, kind: u8, key: &str, found: &Option<LocatedName>, is_wanted: bool, report: &mut Report) {
    match (found, is_wanted) {
        (None, true) => report.add(
            Problem::error(raw.at.clone(), format!("hand type {kind} needs `{key}`"))
                .label(format!("no `{key}` here"))
                .hint(format!("type {kind} is for {}", purpose(kind))),
        ),
        (Some(name), false) => report.add(
            Problem::error(name.at.clone(), format!("hand type {kind} has no `{key}`"))
                .hint(format!("type {kind} is for {}", purpose(kind))),
        ),
        (None, false) | (Some(_), true) => {}
    }
}

fn not_its_own_reverse(raw: &RawHand, kind: u8, report: &mut Report) {
    if let (Some(forward), Some(back)) = (&raw.forward, &raw.back)
        && kind >= 3
        && forward.value == back.value
    {
        report.add(
            Problem::error(back.at.clone(), format!("`{}` runs the operation forward and back", back.value))
                .also(&forward.at, "forward")
                .hint("give the way back a button of its own"),
        );
    }
}
