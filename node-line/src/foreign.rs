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
