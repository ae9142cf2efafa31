//! Cells: what is found wrong with them and what is not, against players that know nothing of the check.

mod oracle;
mod protocol;
mod random;
mod shipped;
mod table;

/// The texts of the shipped cells, and what is made of texts: those of the descriptions' own tests.
#[path = "../../../model/cell/tests/common/mod.rs"]
mod texts;

use linewright_cell::Cell;
use linewright_proof::cell::{Checked, Property, Setting, Verdict, check};

pub use texts::{ASSEMBLY, C1, cell, edited};

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
