//! What can be answered to an alarm, each with what sensors say of it, as text and as data.

use linewright_coordinator_cell::texts::{AnswerFit, AnswerRemark, ListedAnswer};
use linewright_msgs::AlarmState;
use serde::Serialize;

use crate::bounds::text;

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
#[derive(Debug, Serialize)]
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

impl AnswerJson {
    /// Cuts its texts to their bound.
    pub(crate) fn bound(&mut self) {
        self.answer = text(&self.answer);
        self.meaning = text(&self.meaning);
        self.why = self.why.as_deref().map(text);
    }
}

/// The verdict on an answer, in JSON.
pub const fn verdict(fit: AnswerFit) -> &'static str {
    match fit {
        AnswerFit::Fits => "fits",
        AnswerFit::Contradicts => "contradicts",
        AnswerFit::Refused => "refused",
        AnswerFit::NotMeasured => "not measured",
        AnswerFit::NotKnown => "not known",
    }
}
