//! Words from outside, made fit to be quoted in an answer.
//!
//! A command may have four thousand characters, or characters that move a terminal's cursor. An answer that repeated
//! them would itself be too long to be a valid message, and would be dropped, with everything else in the same message.

/// Enough of a word to recognise it by.
const CHARS_MAX: usize = 40;

/// The beginning of a foreign text, without control characters.
pub fn quoted(text: &str) -> String {
    let mut quoted: String = text.chars().take(CHARS_MAX).flat_map(char::escape_debug).collect();
    if text.chars().nth(CHARS_MAX).is_some() {
        quoted.push('…');
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::quoted;

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
}
