//! A whole text as TOML, within bounds.

use toml_edit::Document;

use crate::advice::{decimal_comma, hexadecimal_number, second_header};
use crate::{Problem, Report};

/// Longest text, in bytes: a shipped line has 16 KiB, a thousand stations fit in one.
pub const BYTES_MAX: usize = 1 << 20;

/// Whether a text is short enough to read; `what` it is, for the message: "the description".
pub fn is_bounded(text: &str, what: &str, report: &mut Report) -> bool {
    if text.len() > BYTES_MAX {
        report.add(
            Problem::error(0..0, format!("{what} has {} bytes", text.len()))
                .hint(format!("at most {BYTES_MAX}; is this the right file?")),
        );
    }
    text.len() <= BYTES_MAX
}

/// Whether one of `keys` stands at the top of a text that is TOML.
pub fn has_key(text: &str, keys: &[&str]) -> bool {
    let is_short = text.len() <= BYTES_MAX;
    let document = if is_short { Document::parse(text).ok() } else { None };
    document.is_some_and(|document| keys.iter().any(|key| document.as_table().contains_key(key)))
}

/// The TOML that a text is; `None`, and a problem, where it is none.
pub fn document<'a>(text: &'a str, report: &mut Report) -> Option<Document<&'a str>> {
    match Document::parse(text) {
        Ok(document) => Some(document),
        Err(error) => {
            let at = error.span().unwrap_or(0..0);
            let message = format!("this is not TOML: {}", error.message().trim_end().replace('\n', ", "));
            let start = text[..text.floor_char_boundary(at.start)].rfind('\n').map_or(0, |end| end + 1);
            let line = text[start..].lines().next().unwrap_or_default();
            let problem = Problem::error(at, message).label("reading stopped here");
            let hint = decimal_comma(line).or_else(|| hexadecimal_number(line));
            report.add(problem.maybe_hint(hint.or_else(|| second_header(line, error.message()))));
            None
        }
    }
}
