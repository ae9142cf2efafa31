//! What can be answered to an alarm, each with what sensors say of it, as data.
//!
//! The coordinator reports both in one text, made by `judged`; here it is taken apart again.

use linewright_recovery::StandingAlarm;
use serde::Serialize;

/// First characters of the coordinator's remark on an answer, each with the verdict that it states.
const VERDICTS: [(&str, AnswerFit); 5] = [
    ("fits the sensors", AnswerFit::Fits),
    ("not measured: ", AnswerFit::NotMeasured),
    ("not known: ", AnswerFit::NotKnown),
    ("contradicts the sensors: ", AnswerFit::Contradicts),
    ("refused now: ", AnswerFit::Refused),
];

/// An answer that is permitted.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub struct AnswerJson {
    answer: String,
    /// What becomes of the activity, and where its part is then.
    meaning: String,
    /// Null where the alarm says what is so of every answer.
    verdict: Option<AnswerFit>,
    /// Sensors that contradict it, why it is refused, where to look, or which station is not received.
    why: Option<String>,
}

/// What sensors say of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AnswerFit {
    Fits,
    /// No sensor sees what it claims.
    #[serde(rename = "not measured")]
    NotMeasured,
    /// A station is not received.
    #[serde(rename = "not known")]
    NotKnown,
    Contradicts,
    Refused,
}

/// The answers to an alarm, in its order.
pub fn answers(alarm: &StandingAlarm) -> Vec<AnswerJson> {
    let text = |at: usize| alarm.meanings.get(at).map_or("", String::as_str);
    alarm.answers.iter().enumerate().map(|(at, answer)| AnswerJson::of(answer, text(at))).collect()
}

impl AnswerJson {
    fn of(answer: &str, text: &str) -> Self {
        let (meaning, said) = parted(text);
        let found =
            said.and_then(|said| VERDICTS.iter().find_map(|(begin, fit)| Some((*fit, said.strip_prefix(begin)?))));
        AnswerJson {
            answer: answer.to_owned(),
            meaning: meaning.to_owned(),
            verdict: found.map(|(fit, _)| fit),
            why: found.map(|(_, why)| why.to_owned()).filter(|why| !why.is_empty()),
        }
    }
}

/// Splits the text of an answer into its meaning and the coordinator's remark on the sensors; no remark where sensors show nothing.
fn parted(text: &str) -> (&str, Option<&str>) {
    let begins = |said: &str| VERDICTS.iter().any(|(begin, _)| said.starts_with(begin));
    if begins(text) {
        return ("", Some(text));
    }
    let ends = text.match_indices("; ").map(|(at, separator)| (&text[..at], &text[at + separator.len()..]));
    ends.into_iter().find(|(_, said)| begins(said)).map_or((text, None), |(meaning, said)| (meaning, Some(said)))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use linewright_cell::net::Supply;
    use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
    use linewright_coordinator_cell::exception::{AlarmAnswerRefusal, SensorMismatch};
    use linewright_coordinator_cell::texts::judged;
    use linewright_coordinator_cell::{AlarmId, AnswerVerdict, PlayerState, ResourceId};
    use linewright_line::StationId;

    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// For each verdict of the coordinator, with and without a meaning before it.
    #[test]
    fn a_verdict_is_read_as_it_was_written() {
        let line = include_str!("../../../launch-config/lines/workcell-c1/line.toml");
        let line = linewright_line::parse("line.toml", line).expect("it is shipped").line;
        let cell = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
        let cell = linewright_cell::parse("cell.toml", cell, Some(&line)).expect("it is shipped").cell;
        let compiled =
            compile_cell(&cell, Some(&line), Supply::Open, OrderTiming { repeat_interval: SECOND, grace: SECOND })
                .expect("playable");
        let state = PlayerState::new(Arc::new(compiled.table));
        let found = SensorMismatch { resource: ResourceId(1), model: true, plant: false };
        let (off, none) = ("M1: part expected, sensor off", "M1: sensor on, but the answer states no part there");
        let silent = "no state received from m1; start it again, or look at its host and network";
        for (verdict, fit, why) in [
            (AnswerVerdict::Taken { unseen: Vec::new() }, Some(AnswerFit::Fits), None),
            (AnswerVerdict::Taken { unseen: vec![ResourceId(0)] }, Some(AnswerFit::NotMeasured), Some("look at ST")),
            (AnswerVerdict::Open { silent: vec![StationId(1)] }, Some(AnswerFit::NotKnown), Some(silent)),
            (AnswerVerdict::Contradicted(vec![found]), Some(AnswerFit::Contradicts), Some(off)),
            (AnswerVerdict::Refused(AlarmAnswerRefusal::HasPart(ResourceId(1))), Some(AnswerFit::Refused), Some(none)),
            (AnswerVerdict::Open { silent: Vec::new() }, None, None),
        ] {
            for meaning in ["once more, part at ST", "done; part gone", ""] {
                let text = judged(&line, &state, AlarmId(1), meaning.to_owned(), &verdict);
                let why = why.map(str::to_owned);
                let expected = AnswerJson { answer: "redo".to_owned(), meaning: meaning.to_owned(), verdict: fit, why };
                assert_eq!(AnswerJson::of("redo", &text), expected, "{text}");
            }
        }
    }
}
