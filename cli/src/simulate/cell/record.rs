//! Writes a simulation into a database, as a coordinator does while it runs: `linewright report` reads both.

use std::collections::BTreeMap;
use std::path::Path;

use linewright_cell::Cell;
use linewright_coordinator_cell::described::{Described, sheet};
use linewright_coordinator_cell::schedule::Foreman;
use linewright_coordinator_cell::tracking::Done;
use linewright_coordinator_cell::{FiringId, Record};
use linewright_history::{About, Clock, History, Note};
use linewright_line::Line;
use miette::miette;

/// So many records are written at once.
const BATCH: usize = 10_000;

/// A new database about a cell.
pub fn begin(path: &Path, cell: &Cell, line: Option<&Line>, played: &Described) -> miette::Result<History> {
    let stations = match line {
        Some(line) => line.stations.iter().map(|station| station.name.clone()).collect(),
        None => cell.controllers.clone(),
    };
    let about = About {
        cell: cell.name.clone(),
        title: cell.title.clone(),
        table: played.table.digest(),
        clock: Clock::Simulated,
        stations,
        sheet: sheet(cell, played),
    };
    History::create(path, &about).map_err(|error| miette!("{error}"))
}

/// Writes all records.
pub fn write(history: &mut History, records: &[Record]) -> miette::Result<()> {
    for (batch, first) in records.chunks(BATCH).zip((1..).step_by(BATCH)) {
        history.feed(first, batch).map_err(|error| miette!("{error}"))?;
    }
    Ok(())
}

/// Writes down when each activity was planned at first, if it was.
pub fn write_plan(history: &mut History, plan: &Foreman, activities: &[Done]) -> miette::Result<()> {
    let key = |done: &Done| ((done.mode, done.part, done.began), done.firing);
    let firings: BTreeMap<_, FiringId> = activities.iter().map(key).collect();
    for bar in plan.bars() {
        let (Some((from, to)), Some((began, _))) = (bar.promised, bar.actual) else { continue };
        if let Some(&firing) = firings.get(&(bar.mode, bar.part, began)) {
            history.note(began, &Note::Planned { firing, from, to }).map_err(|error| miette!("{error}"))?;
        }
    }
    Ok(())
}
