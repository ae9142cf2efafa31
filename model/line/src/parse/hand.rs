//! Hand-mode entries: a type's number and its buttons → [`HandMode`] (seed 002 Figure 21 and Table 3).
//!
//! Each type has its own set of buttons; what the types of neighbours have to do with each other is for
//! [`super::rules`].

use linewright_text::{Located, LocatedName, NameTable, Problem, Report, suggestion};

use super::raw::RawHand;
use crate::{ButtonId, HandMode, HandType};

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
        if buttons.is_empty() {
            report.add_unknown(
                Problem::error(name.at.clone(), "the line has no `buttons`")
                    .label("names one")
                    .hint(format!("name all of them above the first header: `buttons = [\"{}\", …]`", name.value)),
            );
            return None;
        }
        let found = buttons.meant(&name.value);
        if found.is_none() && !report.is_full() {
            report.add_unknown(unknown(name, buttons));
        }
        found.map(ButtonId::at)
    };
    let (forward, back, next) = (press(&raw.forward), press(&raw.back), press(&raw.next));
    let number = raw.number.as_ref()?;
    let Some(kind) = HandType::numbered(number.value) else {
        report.add(
            Problem::error(number.at.clone(), format!("unknown hand type {}", number.value))
                .hint("hand types are 1 to 6: 1, 2 sequences; 3, 4, 5 reversed sequences; 6 on its own"),
        );
        return None;
    };
    wanted(raw, kind, "back", &raw.back, kind.has_back(), report);
    match &raw.next {
        Some(name) if ends_task => report.add(
            Problem::error(name.at.clone(), "`next` where a task ends")
                .hint("leave it out: what follows is whichever task is begun, by its own `forward`"),
        ),
        None if ends_task => {}
        next => wanted(raw, kind, "next", next, kind.has_next(), report),
    }
    not_its_own_reverse(raw, kind, report);

    let forward = forward?;
    let next = if ends_task { Some(forward) } else { next };
    let hand = kind.with(forward, back, next)?;
    Some(Located::new(hand, raw.at.clone()))
}

/// A button that the line does not have: those it has, and where a further one is declared.
fn unknown(name: &LocatedName, buttons: &NameTable<'_>) -> Problem {
    let known = suggestion(&name.value, buttons.names()).unwrap_or_default();
    let new = "a new one stands in `buttons`, above the first header, and in the inputs of the console's [[device]]";
    let hint = match known.as_str() {
        "" => new.to_owned(),
        question if question.ends_with('?') => format!("{question} {new}"),
        list => format!("{list}; {new}"),
    };
    Problem::error(name.at.clone(), format!("unknown button `{}`", name.value)).hint(hint)
}

/// Reports a button that the type needs and the entry lacks, or the reverse.
fn wanted(raw: &RawHand, kind: HandType, key: &str, found: &Option<LocatedName>, is_wanted: bool, report: &mut Report) {
    match (found, is_wanted) {
        (None, true) => report.add(
            Problem::error(raw.at.clone(), format!("hand type {kind} needs `{key}`"))
                .label(format!("no `{key}` here"))
                .hint(format!("type {kind} is for {}", kind.purpose())),
        ),
        (Some(name), false) => report.add(
            Problem::error(name.at.clone(), format!("hand type {kind} has no `{key}`"))
                .hint(format!("type {kind} is for {}", kind.purpose())),
        ),
        (None, false) | (Some(_), true) => {}
    }
}

fn not_its_own_reverse(raw: &RawHand, kind: HandType, report: &mut Report) {
    if let (Some(forward), Some(back)) = (&raw.forward, &raw.back)
        && kind.has_back()
        && forward.value == back.value
    {
        report.add(
            Problem::error(back.at.clone(), format!("`{}` runs the operation forward and back", back.value))
                .also(&forward.at, "forward")
                .hint("give the way back a button of its own"),
        );
    }
}
