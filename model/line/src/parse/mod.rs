//! Text → checked [`Line`], or all errors of the text at once.
//!
//! Stations of a type are written out first ([`types`]). The text then goes through five passes, each with one
//! question:
//!
//! 1. `raw`: is it TOML, and has each key the right type? → values with their places
//! 2. `names`: are the names well formed and unique?
//! 3. `resolve`: what does each name stand for? → `draft`, the line as far as it can be understood
//! 4. `rules`: does it hold together? One function per rule
//! 5. `finish`: draft → [`Line`]
//!
//! No pass stops at a mistake. What could not be read is absent in the later passes and is passed over there, so that
//! one run reports all that can be known, and none of it twice. The passes do not use nets or running lines.

mod analogue;
mod draft;
mod drive;
mod finish;
mod frames;
mod hand;
mod handling;
mod modbus;
mod names;
mod raw;
mod resolve;
mod rules;
mod setup;
mod swapped;
mod task;
mod types;
mod wiring;

pub use linewright_text::{Problem, Problems, suggestion};

use linewright_text::{Keys, Report, Shape, TextRange};

use crate::Line;

/// A sound description.
#[derive(Clone, Debug)]
pub struct ParsedLine {
    /// The line it describes.
    pub line: Line,
    /// The lines of the text, from 1, at which its arrows begin, in their order.
    pub arrow_lines: Vec<usize>,
    /// Warnings, in the order of the text; [`Problems::new`] has them drawn.
    pub warnings: Vec<Problem>,
}

/// Reads the description `text` of a line; `file_name` is for messages.
///
/// # Errors
/// All problems of the text at once, warnings included, each with its place.
pub fn parse(file_name: &str, text: &str) -> Result<ParsedLine, Problems> {
    let mut report = Report::default();
    let line = understand(text, &mut report);
    let ((line, arrows), warnings) = report.close(line, file_name, text)?;
    let line_of =
        |at: &TextRange| text.as_bytes()[..at.start.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() + 1;
    Ok(ParsedLine { line, arrow_lines: arrows.iter().map(line_of).collect(), warnings })
}

/// The description with every station of a type written out: another text of the same line.
///
/// # Errors
/// Errors of types and of the stations that name one; the line itself is not checked.
pub fn expand(file_name: &str, text: &str) -> Result<String, Problems> {
    let mut report = Report::default();
    let is_bounded = linewright_text::is_bounded(text, "the description", &mut report);
    let spliced = if is_bounded { types::expand(text, &mut report) } else { None };
    report.close(spliced, file_name, text).map(|(spliced, _)| spliced.text().to_owned())
}

/// Whether a text is the description of a line, however wrong, and not of a cell.
pub fn is_described(text: &str) -> bool {
    linewright_text::has_key(text, &["station", "station_type", "device"])
}

/// Keys of a description of a line, with types and bounds. Rules between them are checked by [`parse`].
pub fn schema() -> Shape {
    raw::RawLine::shape()
}

/// The line, and the places of its arrows.
fn understand(text: &str, report: &mut Report) -> Option<(Line, Vec<TextRange>)> {
    if !linewright_text::is_bounded(text, "the description", report) {
        return None;
    }
    let spliced = types::expand(text, report)?;
    let mut found = Report::default();
    let line = written_out(spliced.text(), &mut found);
    spliced.put_back(text, &mut found);
    report.join(found);
    let (line, arrows) = line.filter(|_| !report.has_errors())?;
    Some((line, arrows.iter().map(|at| spliced.origin_of(at)).collect()))
}

/// A description without types.
fn written_out(text: &str, report: &mut Report) -> Option<(Line, Vec<TextRange>)> {
    let raw = raw::read(text, report)?;
    let names = names::names(&raw, report);
    let mut draft = resolve::resolve(&raw, names, report);
    rules::wrong_homes(&mut draft, report);
    swapped::turn_round(&mut draft, report);
    rules::check(&draft, report);
    let arrows = draft.arrows.iter().map(|arrow| arrow.at.clone()).collect();
    if report.has_errors() { None } else { Some((finish::finish(&draft)?, arrows)) }
}
