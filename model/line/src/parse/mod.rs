//! Text → checked [`Line`], or everything that is wrong with the text at once.
//!
//! The text goes through five passes, each of which knows only its own question:
//!
//! 1. `raw`: is it TOML, and has each key the right type? → values with their places
//! 2. `names`: are the names well formed and unique?
//! 3. `resolve`: what does each name stand for? → `draft`, the line as far as it can be understood
//! 4. `rules`: does it hold together? One function per rule
//! 5. `finish`: draft → [`Line`]
//!
//! No pass stops at a mistake. What could not be read is absent in the later passes and is passed over there, so that
//! one run reports all that can be known, and none of it twice. The passes know nothing of nets or of running lines.

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
mod task;
mod wiring;

pub use linewright_text::{Problem, Problems, suggestion};

use linewright_text::{Keys, Report, Shape};

use crate::Line;

/// A sound description.
#[derive(Clone, Debug)]
pub struct ParsedLine {
    /// The line it describes.
    pub line: Line,
    /// What is suspicious about it, in the order of the text; [`Problems::new`] has them drawn.
    pub warnings: Vec<Problem>,
}

/// Reads the description `text` of a line; `file_name` is for messages.
///
/// # Errors
/// All problems of the text at once, warnings included, each with its place.
pub fn parse(file_name: &str, text: &str) -> Result<ParsedLine, Problems> {
    let mut report = Report::default();
    let line = understand(text, &mut report);
    let (line, warnings) = report.close(line, file_name, text)?;
    Ok(ParsedLine { line, warnings })
}

/// What a description of a line may contain: its keys, with types and bounds. What holds between them, [`parse`] knows.
pub fn schema() -> Shape {
    raw::RawLine::shape()
}

fn understand(text: &str, report: &mut Report) -> Option<Line> {
    if !linewright_text::is_bounded(text, "the description", report) {
        return None;
    }
    let raw = raw::read(text, report)?;
    let names = names::names(&raw, report);
    let draft = resolve::resolve(&raw, names, report);
    rules::check(&draft, report);
    if report.has_errors() { None } else { finish::finish(&draft) }
}
