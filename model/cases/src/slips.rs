//! Slips of the hand, and of merge tools, in a text: whatever it contains then, its reader ends with problems that can be
//! drawn.

use linewright_diagnostics::Problems;
use miette::{GraphicalReportHandler, GraphicalTheme};
use proptest::prelude::*;

/// What may stand anywhere by mistake, beside what a format adds.
const SIGNS: [&str; 24] = [
    "\"", "[", "]", "[[", "{", "}", "=", "\n", "\r\n", ",", ".", "-1", "0", "1e400", "nan", "inf", "0x7f", "\"\"",
    "''", "true", "[]", "\u{feff}", "é", "\u{0}",
];

/// Where, as a fraction, how many bytes are lost, and what is inserted.
pub type Slip = (f64, usize, String);

/// One to three random edits of a text. What they insert is a character, an identifier, one of `SIGNS`, or one of `words`: keywords
/// of the format.
pub fn slips(words: &[&'static str]) -> impl Strategy<Value = Vec<Slip>> + use<> {
    let signs = prop::sample::select([&SIGNS[..], words].concat()).prop_map(String::from);
    let inserted = prop_oneof![any::<char>().prop_map(String::from), "[a-z_]{1,6}", signs];
    prop::collection::vec((0.0..1.0, 0usize..12, inserted), 1..4)
}

/// A whole character near `at` (a fraction) of a text.
pub fn near(text: &str, at: f64) -> usize {
    (0..=(text.len() as f64 * at) as usize).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}

/// The text with its slips.
pub fn slipped(text: &str, slips: Vec<Slip>) -> String {
    let mut text = text.to_owned();
    for (at, removed, inserted) in slips {
        let start = near(&text, at);
        let end = ((start + removed).min(text.len())..=text.len()).find(|&at| text.is_char_boundary(at));
        text.replace_range(start..end.unwrap_or(text.len()), &inserted);
    }
    text
}

/// The text with a line moved, or without it.
pub fn moved(text: &str, from: f64, to: Option<f64>) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let line = lines.remove((lines.len() as f64 * from) as usize);
    if let Some(to) = to {
        lines.insert((lines.len() as f64 * to) as usize, line);
    }
    lines.join("\n")
}

/// Draws problems, which must lie within the text.
///
/// # Panics
///
/// If one points out of the text, or cannot be drawn.
pub fn draw(text: &str, problems: &Problems) {
    for problem in problems.iter() {
        assert!(text.get(problem.span.clone()).is_some(), "{problem} points out of the text");
        assert!(problem.line >= 1 && problem.column >= 1);
    }
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
    handler.render_report(&mut String::new(), problems).expect("every report can be drawn");
}
