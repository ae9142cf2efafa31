//! Answers to an alarm as text and as data.

use linewright_console_view::{AnswerJson, answers, permitted};
use linewright_msgs::AlarmState;
use serde_json::json;

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
