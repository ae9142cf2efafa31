//! Any bytes as the description of a cell: an answer, never a panic, and every place in it within the text.
//!
//! A description that parses must also go all the way: to nets, and to a check that ends at its limits. What the parser
//! lets through, nothing behind it may trip over.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_cell::net::Detail;
use linewright_cell::{Cell, parse};
use linewright_fuzz::draw_description;
use linewright_proof::cell::{CellExploration, ExplorationLimits, Verdict, check};
use linewright_text::Problems;

/// Larger cells take long, and are not different.
const RESOURCES_MAX: usize = 24;
const STAGES_MAX: usize = 48;
const ROOM_MAX: u32 = 64;

fuzz_target!(|bytes: &[u8]| {
    // A file is read as UTF-8 before the parser sees it.
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match parse("any.toml", text, None) {
        Ok(parsed) => {
            draw_description(text, &Problems::new("any.toml", text, parsed.warnings));
            explore(&parsed.cell);
        }
        Err(problems) => {
            assert!(problems.errors() > 0, "no cell and no error");
            draw_description(text, &problems);
        }
    }
});

/// Both details have a net, and the same verdicts as far as both were explored.
fn explore(cell: &Cell) {
    let room: u32 = cell.resources.iter().map(|resource| resource.capacity).fold(0, u32::saturating_add);
    if cell.resources.len() > RESOURCES_MAX || cell.stages.len() > STAGES_MAX || room > ROOM_MAX {
        return;
    }
    let limits = ExplorationLimits { states: 2_000, bytes: 16 << 20, threads: 1 };
    let mut known: Option<bool> = None;
    for detail in [Detail::Coordination, Detail::Expanded] {
        let found = check(&CellExploration { detail, limits, ..CellExploration::new(cell) })
            .expect("a cell that parses has a net");
        for property in &found.properties {
            assert!(!property.reason.is_empty());
            let steps = property.counterexample.as_ref().map(|story| story.steps.len());
            assert!(steps != Some(0) && (steps.is_none() || property.verdict == Verdict::Fails));
        }
        if found.properties.iter().all(|property| property.verdict != Verdict::Undecided) {
            assert_eq!(*known.get_or_insert(found.holds()), found.holds(), "the details disagree");
        }
    }
}

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
