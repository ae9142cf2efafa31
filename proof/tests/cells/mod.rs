//! Cells: what is found wrong with them and what is not, against players that know nothing of the check.

mod oracle;
mod random;
mod shipped;
mod table;

use linewright_cell::{Cell, parse};
use linewright_proof::cell::{Checked, Property, Setting, Verdict, check};

/// Seed 001's workcell.
pub const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
/// Seed 000's cell.
pub const ASSEMBLY: &str = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");

/// The cell of a sound text.
#[track_caller]
pub fn cell(text: &str) -> Cell {
    parse("cell.toml", text, None).unwrap_or_else(|problems| panic!("{problems:#}\n{text}")).cell
}

/// A text with the first occurrence of each replaced.
#[track_caller]
pub fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (old, new) in edits {
        assert!(text.contains(old), "the text has no {old:?}");
        text = text.replacen(old, new, 1);
    }
    text
}

/// What is found of it, with any mix of parts.
#[track_caller]
pub fn checked(cell: &Cell) -> Checked {
    check(&Setting::new(cell)).expect("it is small")
}

/// The properties by their order: stuck, finished, happens.
pub fn verdicts(checked: &Checked) -> [Verdict; 3] {
    [0, 1, 2].map(|at| checked.properties[at].verdict)
}

/// The first property that fails.
#[track_caller]
pub fn failing(checked: &Checked) -> &Property {
    checked.properties.iter().find(|property| property.verdict == Verdict::Fails).expect("something fails")
}
