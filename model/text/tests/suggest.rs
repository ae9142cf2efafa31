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
