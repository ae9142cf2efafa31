//! What can be answered to an alarm, each with what sensors say of it, as text and as data.

use linewright_coordinator_cell::texts::{AnswerFit, AnswerRemark, ListedAnswer};
use linewright_msgs::AlarmState;
use serde::Serialize;

/// Answers to an alarm as one line of text, each with its meaning and what sensors say of it in parentheses.
pub fn answers(alarm: &AlarmState) -> String {
    permitted(alarm).iter().map(ListedAnswer::text).collect::<Vec<_>>().join(", ")
}

/// Answers to an alarm, as the coordinator reports them. A verdict that is not known here is none.
pub fn permitted(alarm: &AlarmState) -> Vec<ListedAnswer> {
    let fit = |at: usize| match alarm.verdicts.get(at).copied() {
        Some(AlarmState::VERDICT_FITS) => Some(AnswerFit::Fits),
        Some(AlarmState::VERDICT_CONTRADICTS) => Some(AnswerFit::Contradicts),
        Some(AlarmState::VERDICT_REFUSED) => Some(AnswerFit::Refused),
        Some(AlarmState::VERDICT_NOT_MEASURED) => Some(AnswerFit::NotMeasured),
        Some(AlarmState::VERDICT_NOT_KNOWN) => Some(AnswerFit::NotKnown),
        _ => None,
    };
    let text = |of: &[String], at: usize| of.get(at).cloned().unwrap_or_default();
    let answer = |(at, word): (usize, &String)| ListedAnswer {
        word: word.clone(),
        meaning: text(&alarm.meanings, at),
        remark: fit(at).map(|fit| AnswerRemark { fit, why: text(&alarm.verdict_reasons, at) }),
    };
    alarm.answers.iter().enumerate().map(answer).collect()
}

/// An answer that is permitted.
#[derive(Serialize)]
pub struct AnswerJson {
    answer: String,
    /// What becomes of the activity, and where its part is then.
    meaning: String,
    /// `fits`, `contradicts`, `refused`, `not measured` or `not known` (see [`AnswerFit`]); null where the text of the alarm covers every
    /// answer.
    verdict: Option<&'static str>,
    /// Sensors that contradict it, why it is refused, where to look, or which station is not received.
    why: Option<String>,
}

impl From<&ListedAnswer> for AnswerJson {
    fn from(of: &ListedAnswer) -> Self {
        AnswerJson {
            answer: of.word.clone(),
            meaning: of.meaning.clone(),
            verdict: of.remark.as_ref().map(|remark| verdict(remark.fit)),
            why: of.remark.as_ref().map(|remark| remark.why.clone()).filter(|why| !why.is_empty()),
        }
    }
}

/// The verdict on an answer, in JSON.
pub(super) const fn verdict(fit: AnswerFit) -> &'static str {
    match fit {
        AnswerFit::Fits => "fits",
        AnswerFit::Contradicts => "contradicts",
        AnswerFit::Refused => "refused",
        AnswerFit::NotMeasured => "not measured",
        AnswerFit::NotKnown => "not known",
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// The verdict is read from its own field, also where the text of a meaning looks like one.
    #[test]
    fn text_and_data_of_an_answer_are_made_from_the_fields_of_its_alarm() {
        let (fits, off) = ("once more; fits the sensors", "M1: part expected, sensor off");
        let texts = |of: [&str; 5]| of.map(str::to_owned).to_vec();
        let alarm = AlarmState {
            answers: texts(["a", "b", "c", "d", "e"]),
            meanings: texts(["part gone", "done", "", fits, fits]),
            verdicts: vec![AlarmState::VERDICT_FITS, AlarmState::VERDICT_CONTRADICTS, 3, AlarmState::VERDICT_NONE, 9],
            verdict_reasons: texts(["", off, "R: sensor on", "", "of another version"]),
            ..AlarmState::default()
        };
        let text = format!(
            "a (part gone; fits the sensors), b (done; contradicts the sensors: {off}), c (refused now: R: sensor on), d ({fits}), e ({fits})"
        );
        assert_eq!(answers(&alarm), text);
        let data = |answer, meaning, verdict: Option<&str>, why: Option<&str>| json!({ "answer": answer, "meaning": meaning, "verdict": verdict, "why": why });
        let expected = [
            data("a", "part gone", Some("fits"), None),
            data("b", "done", Some("contradicts"), Some(off)),
            data("c", "", Some("refused"), Some("R: sensor on")),
            data("d", fits, None, None),
            data("e", fits, None, None),
        ];
        let found: Vec<AnswerJson> = permitted(&alarm).iter().map(AnswerJson::from).collect();
        assert_eq!(json!(found), json!(expected));
        let bare = AlarmState { answers: vec!["up".to_owned()], ..AlarmState::default() };
        assert_eq!(answers(&bare), "up");
    }
}
