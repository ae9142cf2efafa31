//! Text → checked [`Cell`], or all errors of the text at once.
//!
//! The text goes through five passes, each with one question:
//!
//! 1. `raw`: is it TOML, and has each key the right type? → values with their places
//! 2. `names`: are the names well formed and unique?
//! 3. `resolve`: what does each name stand for? → `draft`, the cell as far as it can be understood
//! 4. `rules`: does it hold together? One function per rule
//! 5. `finish`: draft → [`Cell`]
//!
//! No pass stops at a mistake. What could not be read is absent in the later passes and is passed over there, so that
//! one run reports all that can be known, and none of it twice. The passes do not use nets or running cells.

mod draft;
mod finish;
mod names;
mod plan;
mod raw;
mod resolve;
mod rules;

pub use resolve::fits;

use linewright_line::Line;
use linewright_text::{Keys, Problem, Problems, Report, Shape, has_key};

use crate::Cell;

/// A sound description.
#[derive(Clone, Debug)]
pub struct ParsedCell {
    /// The cell it describes.
    pub cell: Cell,
    /// Warnings, in the order of the text; [`Problems::new`] has them drawn.
    pub warnings: Vec<Problem>,
}

/// Reads the description `text` of a cell; `file_name` is for messages. Stations are looked up in `line`, the description
/// beside it; without one they are taken as they are written.
///
/// # Errors
/// All problems of the text at once, warnings included, each with its place.
pub fn parse(file_name: &str, text: &str, line: Option<&Line>) -> Result<ParsedCell, Problems> {
    let mut report = Report::default();
    let cell = understand(text, line, &mut report);
    let (cell, warnings) = report.close(cell, file_name, text)?;
    Ok(ParsedCell { cell, warnings })
}

/// Whether a text is the description of a cell, however wrong, and not of a line.
pub fn is_described(text: &str) -> bool {
    has_key(text, &["cell", "resource", "sync", "part"]) && !linewright_line::is_described(text)
}

/// Keys of a description of a cell, with types and bounds. Rules between them are checked by [`parse`].
pub fn schema() -> Shape {
    raw::RawCell::shape()
}

fn understand(text: &str, line: Option<&Line>, report: &mut Report) -> Option<Cell> {
    if !linewright_text::is_bounded(text, "the description", report) {
        return None;
    }
    let raw = raw::read(text, report)?;
    let names = names::names(&raw, report);
    let draft = resolve::resolve(&raw, &names, line, report);
    let routes = rules::check(&draft, report);
    if report.has_errors() { None } else { finish::finish(&draft, &routes?) }
}
