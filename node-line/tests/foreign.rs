//! Words from outside in answers.

use linewright_node_line::quoted;

#[test]
fn a_word_stays_what_it_is() {
    assert_eq!(quoted("launch"), "launch");
    assert_eq!(quoted(&"x".repeat(40)), "x".repeat(40));
}

#[test]
fn what_is_long_is_cut_and_what_moves_a_cursor_is_spelled_out() {
    assert_eq!(quoted(&"x".repeat(4096)), "x".repeat(40) + "…");
    assert_eq!(quoted("a\u{1b}[2J\n"), "a\\u{1b}[2J\\n");
}
