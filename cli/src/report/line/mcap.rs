//! The recording of a line for Foxglove Studio and others: `/line` and `/stations/NAME` for panels of state transitions,
//! `/cycle_time` to be plotted, `/log` and `/events` with everything.

use std::path::Path;

use linewright_history::{HistoryEvent, MotionOutcome};
use linewright_line::Tick;
use miette::miette;
use serde_json::{Value, json};

use super::LineSource;
use crate::report::mcap::{McapError, Recording, Schema, say_event};
use crate::report::rows::EventRow;
use crate::report::story::failed;

/// Writes the file.
pub fn write(source: &LineSource, path: &Path) -> miette::Result<()> {
    let cannot = |why: &dyn std::fmt::Display| miette!("cannot write {}: {why}", path.display());
    let mut recording = Recording::create(path)?;
    line(source, &mut recording).map_err(|error| cannot(&error))?;
    stations(source, &mut recording).map_err(|error| cannot(&error))?;
    let mut written = Ok(());
    let take = |event: HistoryEvent| {
        if event.at >= source.report.span.0 && written.is_ok() {
            written = say_event(&mut recording, &source.about.line, &row(source, &event), event.at);
        }
    };
    source.reader.each(source.report.span.1, take).map_err(failed)?;
    written.and_then(|()| recording.finish()).map_err(|error| cannot(&error))
}

fn line(source: &LineSource, to: &mut Recording) -> Result<(), McapError> {
    let (from, until) = source.report.span;
    for ((begin, _), state) in source.tracking.states(until).filter(|((_, end), _)| *end > from) {
        let (state, cause) = state.words();
        to.say("/line", Schema::Line, begin.max(from), &json!({"state": state, "cause": cause}))?;
    }
    let planned = source.report.figures.planned_run_time.map(|time| time.as_secs_f64());
    for cycle in &source.report.cycles {
        let Some(took) = cycle.took else { continue };
        let message = json!({"number": cycle.number, "duration_s": took.as_secs_f64(), "planned_s": planned});
        to.say("/cycle_time", Schema::CycleTime, cycle.ended, &message)?;
    }
    Ok(())
}

/// State of each station, whenever that changes.
fn stations(source: &LineSource, to: &mut Recording) -> Result<(), McapError> {
    let (from, until) = source.report.span;
    for (of, track) in std::iter::zip(&source.about.stations, source.tracking.stations()) {
        let topic = format!("/stations/{}", of.name);
        let mut edges: Vec<(Tick, bool, &str, String)> = Vec::new();
        for motion in track.motions.iter().filter(|motion| motion.end != MotionOutcome::Unseen && motion.to > from) {
            let name = of.operations.get(motion.operation).map(|of| of.name.clone()).unwrap_or_default();
            edges.push((motion.from.max(from), true, "busy", name.clone()));
            edges.push((motion.to, false, "busy", name));
        }
        for wait in track.waits.iter().filter(|wait| wait.to > from) {
            edges.push((wait.from.max(from), true, "waiting", wait.why.clone()));
            edges.push((wait.to, false, "waiting", wait.why.clone()));
        }
        // At one moment what ends comes before what begins.
        edges.sort_by_key(|edge| (edge.0, edge.1));
        to.say(&topic, Schema::Station, from, &json!({"state": "idle", "about": ""}))?;
        let mut going_on: Vec<(&str, String)> = Vec::new();
        let mut edges = edges.into_iter().filter(|edge| edge.0 <= until).peekable();
        while let Some((at, begins, state, about)) = edges.next() {
            if begins {
                going_on.push((state, about));
            } else if let Some(at) = going_on.iter().position(|of| (of.0, &of.1) == (state, &about)) {
                going_on.remove(at);
            }
            if edges.peek().is_none_or(|next| next.0 > at) {
                let (state, about) = going_on.first().map_or(("idle", ""), |of| (of.0, of.1.as_str()));
                to.say(&topic, Schema::Station, at, &json!({"state": state, "about": about}))?;
            }
        }
    }
    Ok(())
}

/// An event as a row of a table: with names instead of numbers.
pub fn row(source: &LineSource, event: &HistoryEvent) -> EventRow {
    let (kind, data) = event.parts();
    let value: Value = serde_json::from_str(&data).unwrap_or_default();
    let index = |name: &str| value.get(name).and_then(Value::as_u64).and_then(|of| usize::try_from(of).ok());
    let station = index("station").and_then(|of| source.about.stations.get(of));
    EventRow {
        at_us: event.at.as_micros(),
        time: source.show(event.at),
        kind,
        station: station.map(|of| of.name.clone()),
        activity: index("operation").and_then(|of| station?.operations.get(of)).map(|of| of.name.clone()),
        data,
        ..EventRow::default()
    }
}
