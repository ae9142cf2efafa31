//! Rules for the failure of an activity.

use std::ops::RangeInclusive;

use linewright_line::CODE_MAX;
use linewright_text::{Problem, Report, nearest, suggestion};

use crate::parse::draft::DraftException;
use crate::{Strategy, Whereabouts};

/// Names that may stand in `tell`.
const NAMES: [&str; 7] = ["part", "type", "activity", "carrier", "from", "to", "slot"];

/// Failures that have a word. Those of a task and of its station have a number.
const CODES: [&str; 6] = ["time-out", "refused", "station-lost", "device-lost", "alarm", "*"];
/// The codes of a station's own failures: a fault, an interruption and the like.
const STATION_CODES: RangeInclusive<u16> = 1001..=1006;

pub(super) fn answers_differ(exception: &DraftException<'_>, report: &mut Report) {
    let words: Vec<_> = exception.raw.answers.iter().filter_map(|answer| answer.word.as_ref()).collect();
    for (at, word) in words.iter().enumerate() {
        if let Some(earlier) = words[..at].iter().find(|earlier| earlier.value == word.value) {
            report.add(
                Problem::error(word.at.clone(), format!("two answers are `{}`", word.value))
                    .label("again")
                    .also(&earlier.at, "first here"),
            );
        }
    }
}

pub(super) fn strategies_fit(exception: &DraftException<'_>, report: &mut Report) {
    for answer in &exception.raw.answers {
        let (Some(part), Some(then)) = (&answer.part, &answer.then) else { continue };
        let hint = match (part.value, then.value) {
            (Whereabouts::From, Strategy::Redo | Strategy::Backward)
            | (Whereabouts::To | Whereabouts::Carrier, Strategy::Forward)
            | (Whereabouts::Gone, Strategy::Backward) => continue,
            (Whereabouts::From, Strategy::Forward) => "the part is where it was: \"redo\" or \"backward\"",
            (Whereabouts::To | Whereabouts::Carrier, Strategy::Redo | Strategy::Backward) => {
                "the part is no longer where it was: \"forward\""
            }
            (Whereabouts::Gone, Strategy::Redo | Strategy::Forward) => "there is no part any more: \"backward\"",
        };
        report.add(
            Problem::error(then.at.clone(), "this strategy does not fit where the part is")
                .also(&part.at, "where it is")
                .hint(hint),
        );
    }
}

pub(super) fn retries_are_allowed(exception: &DraftException<'_>, report: &mut Report) {
    if exception.raw.retries > 0 {
        return;
    }
    let redo = exception.raw.answers.iter().filter_map(|answer| answer.then.as_ref());
    for then in redo.filter(|then| then.value == Strategy::Redo) {
        report.add(
            Problem::error(then.at.clone(), "it may not be tried again")
                .hint("allow it with `retries = 1` or more, or choose \"backward\""),
        );
    }
}

pub(super) fn tells_what_is_known(exception: &DraftException<'_>, report: &mut Report) {
    let Some(tell) = &exception.raw.tell else { return };
    let mut rest = tell.value.as_str();
    while let Some((_, behind)) = rest.split_once('{') {
        let Some((name, after)) = behind.split_once('}') else {
            report.add(Problem::error(tell.at.clone(), "a `{` without its `}`").hint("as in \"{part}\""));
            return;
        };
        if !NAMES.contains(&name) {
            report.add(
                Problem::error(tell.at.clone(), format!("unknown placeholder `{{{}}}`", name.escape_debug()))
                    .maybe_hint(suggestion(name, NAMES)),
            );
        }
        rest = after;
    }
}

/// The code is one that an activity can fail with; a rule of any other would never be used.
pub(super) fn code_can_occur(exception: &DraftException<'_>, report: &mut Report) {
    let Some(code) = &exception.raw.code else { return };
    let own = code.value.parse().is_ok_and(|number: u16| {
        let can_occur = (1..=CODE_MAX).contains(&number) || STATION_CODES.contains(&number);
        can_occur && number.to_string() == code.value
    });
    if own || CODES.contains(&code.value.as_str()) {
        return;
    }
    let numbers = format!(
        "a code of a task, \"1\" to \"{CODE_MAX}\", or of its station, \"{}\" to \"{}\"",
        STATION_CODES.start(),
        STATION_CODES.end()
    );
    let words = CODES.map(|word| format!("\"{word}\"")).join(", ");
    let all = format!("permitted: {words}, {numbers}");
    // By one letter everything is near `*`.
    let words_of = || CODES.into_iter().filter(|word| word.len() > 1);
    let hint = words_of().find(|word| *word == code.value.trim()).or_else(|| nearest(&code.value, words_of()));
    report.add(
        Problem::error(code.at.clone(), format!("no activity fails with the code `{}`", code.value))
            .hint(hint.map_or_else(|| all.clone(), |near| format!("did you mean `{near}`? {all}"))),
    );
}

/// The person needed to reset a station can answer as well.
pub(super) fn whoever_resets_answers(exception: &DraftException<'_>, report: &mut Report) {
    if let Some(stop) = exception.raw.emergency_stop.as_ref().filter(|_| exception.raw.automatic) {
        report.add(
            Problem::error(stop.at.clone(), "an emergency stop in a rule that is automatic")
                .hint("`automatic` is not possible with an emergency stop: a reset is needed; remove `automatic`"),
        );
    }
}

pub(super) fn somebody_answers(exception: &DraftException<'_>, report: &mut Report) {
    if exception.raw.answers.is_empty() {
        report.add(
            Problem::error(exception.raw.at.clone(), "an exception without an answer")
                .hint("list the permitted answers in `answers`: { word = …, part = …, then = … }"),
        );
    }
}
