//! Words that were meant.

use linewright_text::{nearest, suggestion};

#[test]
fn a_slip_is_recognised_and_another_word_is_not() {
    let known = ["watchdog_s", "duration_s", "module"];
    assert_eq!(nearest("watchdgo_s", known), Some("watchdog_s"));
    assert_eq!(nearest("Module", known), Some("module"));
    assert_eq!(nearest("lamp", known), None);
    assert_eq!(nearest("module", known), None, "it would be the same word");
    assert_eq!(suggestion("lamp", ["a", "b"]).as_deref(), Some("known here: `a`, `b`"));
    assert_eq!(suggestion("lamp", []), None);
}

#[test]
fn of_words_equally_near_both_are_named_and_a_longer_or_shorter_form_goes_before_them() {
    assert_eq!(suggestion("of", ["on", "off"]).as_deref(), Some("did you mean `off`?"));
    assert_eq!(suggestion("oo", ["on", "no", "off"]).as_deref(), Some("did you mean `on` or `no`?"));
    assert_eq!(suggestion("LS_1", ["LS_2", "LS_10"]).as_deref(), Some("did you mean `LS_10`?"));
}
