//! The shipped cells, as texts and parsed.

use linewright_cell::{Cell, parse};

pub const C1: &str = include_str!("../../launch-config/lines/workcell-c1/cell.toml");
pub const ASSEMBLY: &str = include_str!("../../launch-config/lines/assembly-cell/cell.toml");
pub const C1_LINE: &str = include_str!("../../launch-config/lines/workcell-c1/line.toml");
pub const ASSEMBLY_LINE: &str = include_str!("../../launch-config/lines/assembly-cell/line.toml");

/// The cell of a sound text without a line.
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
