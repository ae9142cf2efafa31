//! Cells: verdicts of the check against players independent of it.

mod conflicts;
mod oracle;
mod protocol;
mod random;
mod recovery;
mod shipped;

use std::path::Path;

use linewright_cell::Cell;
use linewright_line::Line;
use linewright_proof::cell::{CellExploration, CellProperty, Checked, Verdict, check};

pub use linewright_testkit::cells::{ASSEMBLY, C1, cell, edited};

/// A shipped cell and its line, with more at the end of the line's description.
#[track_caller]
pub fn described(name: &str, more: &str) -> (Cell, Line) {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines").join(name);
    let text = |file: &str| std::fs::read_to_string(dir.join(file)).expect("it is there");
    let line = linewright_line::parse("line.toml", &(text("line.toml") + more)).unwrap_or_else(|why| panic!("{why:#}"));
    let cell = linewright_cell::parse("cell.toml", &text("cell.toml"), Some(&line.line));
    (cell.unwrap_or_else(|why| panic!("{why:#}")).cell, line.line)
}

/// Result of its check, with any mix of parts.
#[track_caller]
pub fn checked(cell: &Cell) -> Checked {
    check(&CellExploration::new(cell)).expect("it is small")
}

/// The properties by their order: stuck, finished, happens.
pub fn verdicts(checked: &Checked) -> [Verdict; 3] {
    [0, 1, 2].map(|at| checked.properties[at].verdict)
}

/// The first property that fails.
#[track_caller]
pub fn failing(checked: &Checked) -> &CellProperty {
    checked.properties.iter().find(|property| property.verdict == Verdict::Fails).expect("something fails")
}
