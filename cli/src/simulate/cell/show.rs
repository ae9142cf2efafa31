//! Result of a simulation of a cell, as text.

use std::fmt::Write;

use linewright_cell::Cell;
use linewright_coordinator_cell::texts;
use linewright_coordinator_cell::{ActivityFailure, RecordKind};
use linewright_simulation::cell::CellSim;

use super::made::ProductionResult;

/// So many parts are listed; of more the JSON has all.
const LISTED_MAX: usize = 40;

/// Everything that was decided, and why, a line each.
pub fn decisions(sim: &CellSim) -> String {
    let mut text = String::new();
    for record in &sim.log {
        let RecordKind::Decided { started, held, .. } = &record.fact else { continue };
        for line in texts::decision(&sim.table, started, held) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{:>10.3} s  {line}", record.at.as_secs_f64());
        }
    }
    text
}

/// Why an activity has failed.
pub fn cause(cause: &ActivityFailure) -> String {
    match cause {
        ActivityFailure::Order { key, failure } => format!("{key}: {failure}"),
        ActivityFailure::ByHand { resource } => format!("alarm raised by hand for {resource}"),
        ActivityFailure::TimedOut => cause.summary(),
    }
}

/// Parts and resources.
pub fn text(cell: &Cell, made: &ProductionResult, asked: u32) -> String {
    let seconds = |tick: linewright_line::Tick| tick.as_secs_f64();
    let done = made.parts.iter().filter(|part| part.left.is_some()).count();
    let mut text = format!("{}\n{done} of {asked} parts done in {:.3} s\n", cell.title, seconds(made.end));
    let _ = writeln!(text, "\n{:<24} {:>12} {:>12} {:>12}", "part", "entered", "done", "in the cell");
    for part in made.parts.iter().take(LISTED_MAX) {
        let of = part.product.and_then(|of| cell.part_types.get(of)).map_or("?", |of| of.name.as_str());
        let name = format!("{} ({of})", part.part);
        let ended = part.left.map_or(["-".to_owned(), "-".to_owned()], |done| {
            [format!("{:.3} s", seconds(done)), format!("{:.3} s", done.since(part.entered).as_secs_f64())]
        });
        let entered = format!("{:.3} s", seconds(part.entered));
        let _ = writeln!(text, "{name:<24} {entered:>12} {:>12} {:>12}", ended[0], ended[1]);
    }
    if made.parts.len() > LISTED_MAX {
        let _ = writeln!(text, "and {} more; --json has all of them", made.parts.len() - LISTED_MAX);
    }
    let _ = writeln!(text, "\n{:<24} {:>12} {:>12} {:>12}", "resource", "worked", "taken", "at most");
    for (id, of) in cell.resource_ids().zip(&made.report.resources) {
        let resource = cell.resource(id);
        // A store does nothing by itself, and a robot has nothing to be taken.
        let worked = match of.load(made.report.observed).filter(|_| !resource.prototype.stores()) {
            Some(load) => format!("{:.1} %", load * 100.0),
            None => "-".to_owned(),
        };
        let [taken, most] = if of.most > 0 {
            [format!("{:.2}", of.taken), format!("{} of {}", of.most, resource.capacity)]
        } else {
            ["-".to_owned(), "-".to_owned()]
        };
        let _ = writeln!(text, "{:<24} {worked:>12} {taken:>12} {most:>12}", resource.name);
    }
    text
}
