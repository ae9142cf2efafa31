//! Plan and actual as a Gantt chart: who did what when, as data, and as text for a terminal.
//!
//! A row for each resource that works or carries; stores are left out, since they do nothing. Where anything was planned,
//! the plan is a line of its own above what was really done.

use std::fmt::Write as _;

use linewright_coordinator_cell::tracking::Done;
use linewright_line::Tick;

use super::story::Story;

/// Characters for the time.
const WIDTH: usize = 100;

/// An activity, in seconds from the beginning of the span.
pub struct Bar {
    /// What, for people.
    pub name: String,
    /// With which part.
    pub part: Option<u64>,
    /// What that is to become.
    pub product: Option<usize>,
    /// When it was planned.
    pub planned: Option<(f64, f64)>,
    /// When it was done; until the end of the span if it goes on.
    pub actual: (f64, f64),
    /// From when on it had failed, and why.
    pub failed: Option<(f64, String)>,
}

/// What one resource did.
pub struct Row {
    /// Its name.
    pub name: String,
    /// In the order in which they started.
    pub bars: Vec<Bar>,
}

/// The chart.
pub struct Chart {
    /// A row for each resource that did anything.
    pub rows: Vec<Row>,
    /// How long it is, in seconds.
    pub span: f64,
    /// Something of it was planned.
    pub has_plan: bool,
}

impl Chart {
    /// Of what was read.
    pub fn new(story: &Story) -> Self {
        let sheet = &story.about.sheet;
        let seconds = |tick: Tick| tick.since(story.from).as_secs_f64();
        let bar = |done: &Done| Bar {
            name: sheet.entry(done.mode).map(|entry| entry.name.clone()).unwrap_or_default(),
            part: done.part.map(|part| part.0),
            product: sheet.entry(done.mode).and_then(|entry| entry.product),
            planned: story.planned.get(&done.firing).map(|&(from, to)| (seconds(from), seconds(to))),
            actual: (seconds(done.began), seconds(done.ended.unwrap_or(story.to).min(story.to))),
            failed: done.failed.as_ref().map(|failed| (seconds(failed.at), failed.cause.clone())),
        };
        let does = |done: &&Done, resource: usize| {
            let entry = sheet.entry(done.mode);
            entry.is_some_and(|entry| [entry.worker, entry.carrier].contains(&Some(resource)))
        };
        let rows = sheet.resources.iter().enumerate().map(|(resource, of)| Row {
            name: of.name.clone(),
            // What takes no time is no bar.
            bars: story
                .activities
                .iter()
                .filter(|done| does(done, resource) && done.ended != Some(done.began))
                .map(bar)
                .collect(),
        });
        let rows: Vec<Row> = rows.filter(|row| !row.bars.is_empty()).collect();
        let bars = || rows.iter().flat_map(|row| &row.bars);
        let planned = bars().filter_map(|bar| bar.planned).map(|(_, to)| to);
        let span = planned.fold(seconds(story.to), f64::max).max(1e-6);
        Chart { has_plan: bars().any(|bar| bar.planned.is_some()), rows, span }
    }

    /// As text: the number of its part where a bar begins, `▒` what was planned, `█` what was done, `░` what had failed.
    pub fn text(&self, from: &str, to: &str) -> String {
        let label = self.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
        let mut text = format!("{:label$} {from}{:>width$}\n", "", to, width = WIDTH - from.chars().count() + 1);
        for row in &self.rows {
            if self.has_plan {
                let planned = row.bars.iter().filter_map(|bar| Some((bar.planned?, bar.part, None)));
                self.line(&mut text, (&row.name, label), '▒', planned);
            }
            let name = if self.has_plan { "" } else { &row.name };
            let actual = row.bars.iter().map(|bar| (bar.actual, bar.part, bar.failed.as_ref().map(|(at, _)| *at)));
            self.line(&mut text, (name, label), '█', actual);
        }
        text
    }

    fn line(
        &self,
        text: &mut String,
        (name, label): (&str, usize),
        glyph: char,
        bars: impl Iterator<Item = ((f64, f64), Option<u64>, Option<f64>)>,
    ) {
        // To the nearest boundary of a character, so that bars which follow each other do not overlap; at least one wide.
        let column = |at: f64| ((at / self.span * WIDTH as f64).round().max(0.0) as usize).min(WIDTH);
        let mut cells = vec![' '; WIDTH];
        for ((from, to), part, failed) in bars {
            let from = column(from).min(WIDTH - 1);
            let bar = from..column(to).max(from + 1);
            let failed = failed.map_or(usize::MAX, column);
            cells[bar.clone()].iter_mut().enumerate().for_each(|(at, cell)| {
                *cell = if from + at >= failed { '░' } else { glyph };
            });
            let number = part.map(|part| part.to_string()).unwrap_or_default();
            if number.len() < bar.len() {
                cells[bar].iter_mut().zip(number.chars()).for_each(|(cell, digit)| *cell = digit);
            }
        }
        let cells: String = cells.into_iter().collect();
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:label$} │{cells}│");
    }
}
