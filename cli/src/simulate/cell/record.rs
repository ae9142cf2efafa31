//! Writes a simulation into a database, as a coordinator does while it runs: `linewright report` reads both.

use std::collections::BTreeMap;
use std::path::Path;

use linewright_cell::Cell;
use linewright_coordinator_cell::compile::{CompiledCell, sheet};
use linewright_coordinator_cell::schedule::ScheduleFollower;
use linewright_coordinator_cell::tracking::FinishedActivity;
use linewright_coordinator_cell::{FiringId, Record};
use linewright_history::{CellAbout, History, Note, TimeBase};
use linewright_line::Line;
use miette::miette;

/// So many records are written at once.
const BATCH: usize = 10_000;

/// A new database about a cell.
pub fn begin(path: &Path, cell: &Cell, line: Option<&Line>, played: &CompiledCell) -> miette::Result<History> {
    let stations = match line {
        Some(line) => line.stations.iter().map(|station| station.name.clone()).collect(),
        None => cell.controllers.clone(),
    };
    let about = CellAbout {
        cell: cell.name.clone(),
        title: cell.title.clone(),
        table: played.table.digest(),
        clock: TimeBase::Simulated,
        stations,
        sheet: sheet(cell, played),
    };
    History::create(path, &about).map_err(|error| miette!("{error}"))
}

/// Writes all records, and when each activity was planned at first, if it was.
pub fn write(
    history: &mut History,
    records: &[Record],
    plan: Option<&ScheduleFollower>,
    activities: &[FinishedActivity],
) -> miette::Result<()> {
    for (batch, first) in records.chunks(BATCH).zip((1..).step_by(BATCH)) {
        history.feed(first, batch).map_err(|error| miette!("{error}"))?;
    }
    let key = |done: &FinishedActivity| ((done.mode, done.part, done.began), done.firing);
    let firings: BTreeMap<_, FiringId> = activities.iter().map(key).collect();
    for bar in plan.into_iter().flat_map(ScheduleFollower::bars) {
        let (Some((from, to)), Some((began, _))) = (bar.promised, bar.actual) else { continue };
        if let Some(&firing) = firings.get(&(bar.mode, bar.part, began)) {
            history.note(began, &Note::Planned { firing, from, to }).map_err(|error| miette!("{error}"))?;
        }
    }
    Ok(())
}
