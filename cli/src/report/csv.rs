//! The same as tables: a directory with a file for events, activities, parts and orders each, for other computations.
//! RFC 4180; a first row of names, times as the report has them and beside that in microseconds.
//!
//! An order may be named by every client that may submit one. A spreadsheet takes a cell that begins with `=`, `+`, `-` or `@` for a formula,
//! and a formula can open addresses and start programs: such a cell has an apostrophe before it, by which spreadsheets take it for text.

use std::borrow::Cow;
use std::fs::File;
use std::path::Path;
use std::time::Duration;

use csv::StringRecord;
use linewright_coordinator_cell::tracking::{FinishedActivity, PartHistory};
use linewright_history::{HistoryEvent, HistoryReader};
use linewright_line::Tick;
use miette::{IntoDiagnostic, WrapErr, miette};
use serde::Serialize;

use super::json::production_order;
use super::rows::{EventRow, event_row, in_seconds};
use super::story::{ReportSource, failed};

/// An activity.
#[derive(Default, Serialize)]
struct ActivityRow {
    firing: u64,
    activity: String,
    mode: String,
    product: Option<String>,
    part: Option<u64>,
    worker: Option<String>,
    carrier: Option<String>,
    planned_start: Option<String>,
    planned_end: Option<String>,
    start: String,
    end: Option<String>,
    start_us: u64,
    end_us: Option<u64>,
    duration_s: Option<f64>,
    nominal_s: f64,
    failed: Option<String>,
    cause: Option<String>,
}

/// A part.
#[derive(Default, Serialize)]
struct PartRow {
    part: u64,
    product: Option<String>,
    entered: String,
    left: Option<String>,
    lead_s: Option<f64>,
    worked_s: f64,
    moved_s: f64,
    waited_s: Option<f64>,
}

/// Writes all tables into a directory, which is made if there is none.
pub fn write(story: &ReportSource, dir: &Path) -> miette::Result<()> {
    std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
    table(dir, "activity.csv", story.activities.iter().map(|done| activity(story, done)))?;
    table(dir, "part.csv", story.tracking.passages().map(|passage| part(story, passage)))?;
    table(dir, "order.csv", story.orders().map(|order| production_order(story, order)))?;
    events(&story.reader, (story.from, story.to), dir, |event| event_row(story, event))
}

/// A table in a file.
struct TableFile(csv::Writer<File>);

impl TableFile {
    /// A table that has its first row even if it has no other.
    fn begin<T: Serialize + Default>(path: &Path) -> Result<Self, csv::Error> {
        let [names, _] = &fields(&T::default())?[..] else { unreachable!("a row has the names before it") };
        let mut to = csv::Writer::from_path(path)?;
        to.write_record(names)?;
        Ok(TableFile(to))
    }

    fn row<T: Serialize>(&mut self, row: &T) -> Result<(), csv::Error> {
        for fields in fields(row)?.iter().skip(1) {
            fields.iter().try_for_each(|field| self.0.write_field(as_text(field).as_bytes()))?;
            self.0.write_record(None::<&[u8]>)?;
        }
        Ok(())
    }
}

/// The names of a row and its fields.
fn fields<T: Serialize>(row: &T) -> Result<Vec<StringRecord>, csv::Error> {
    let mut one = csv::WriterBuilder::new().buffer_capacity(512).from_writer(Vec::new());
    one.serialize(row)?;
    let bytes = one.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    csv::ReaderBuilder::new().has_headers(false).buffer_capacity(512).from_reader(bytes.as_slice()).records().collect()
}

/// A field as it is written. Numbers with a sign are none of the texts that compute.
fn as_text(field: &str) -> Cow<'_, str> {
    let is_formula = field.starts_with(['=', '+', '-', '@', '\t', '\r']) && field.parse::<f64>().is_err();
    if is_formula { Cow::Owned(format!("'{field}")) } else { Cow::Borrowed(field) }
}

pub fn table<T: Serialize + Default>(dir: &Path, name: &str, rows: impl Iterator<Item = T>) -> miette::Result<()> {
    let path = dir.join(name);
    let cannot = || format!("cannot write {}", path.display());
    let mut to = TableFile::begin::<T>(&path).into_diagnostic().wrap_err_with(cannot)?;
    for row in rows {
        to.row(&row).into_diagnostic().wrap_err_with(cannot)?;
    }
    to.0.flush().into_diagnostic().wrap_err_with(cannot)
}

/// Events are not kept in memory: they go from the one file into the other.
pub fn events(
    reader: &HistoryReader,
    (from, to): (Tick, Tick),
    dir: &Path,
    row: impl Fn(&HistoryEvent) -> EventRow,
) -> miette::Result<()> {
    let path = dir.join("event.csv");
    let mut file = TableFile::begin::<EventRow>(&path).into_diagnostic()?;
    let mut written = Ok(());
    let within = |event: HistoryEvent| {
        if event.at >= from && written.is_ok() {
            written = file.row(&row(&event));
        }
    };
    reader.each(to, within).map_err(failed)?;
    let written = written.and_then(|()| Ok(file.0.flush()?));
    written.map_err(|error| miette!("cannot write {}: {error}", path.display()))
}

fn activity(story: &ReportSource, done: &FinishedActivity) -> ActivityRow {
    let sheet = &story.about.sheet;
    let entry = sheet.entry(done.mode);
    let resource = |of: Option<usize>| of.and_then(|of| sheet.resources.get(of)).map(|of| of.name.clone());
    let planned = story.planned.get(&done.firing);
    ActivityRow {
        firing: done.firing.0,
        activity: entry.map(|entry| entry.activity.clone()).unwrap_or_default(),
        mode: entry.map(|entry| entry.name.clone()).unwrap_or_default(),
        product: product(story, entry.and_then(|entry| entry.product)),
        part: done.part.map(|part| part.0),
        worker: resource(entry.and_then(|entry| entry.worker)),
        carrier: resource(entry.and_then(|entry| entry.carrier)),
        planned_start: planned.map(|(from, _)| story.show(*from)),
        planned_end: planned.map(|(_, to)| story.show(*to)),
        start: story.show(done.began),
        end: done.ended.map(|ended| story.show(ended)),
        start_us: done.began.as_micros(),
        end_us: done.ended.map(Tick::as_micros),
        duration_s: done.ended.map(|ended| in_seconds(ended.since(done.began))),
        nominal_s: entry.map_or(0.0, |entry| in_seconds(entry.nominal)),
        failed: done.failed.as_ref().map(|failed| story.show(failed.at)),
        cause: done.failed.as_ref().map(|failed| failed.cause.clone()),
    }
}

fn product(story: &ReportSource, of: Option<usize>) -> Option<String> {
    of.and_then(|of| story.about.sheet.products.get(of)).cloned()
}

fn part(story: &ReportSource, passage: &PartHistory) -> PartRow {
    let times = passage.lead_and_wait();
    PartRow {
        part: passage.part.0,
        product: product(story, passage.product),
        entered: story.show(passage.entered),
        left: passage.left.map(|left| story.show(left)),
        lead_s: times.map(|(lead, _)| in_seconds(lead)),
        worked_s: in_seconds(passage.worked),
        moved_s: in_seconds(passage.moved),
        waited_s: times.map(|(_, waited): (Duration, Duration)| in_seconds(waited)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default, Serialize)]
    struct Row {
        name: String,
        late_s: f64,
        text: Option<String>,
    }

    #[test]
    fn what_a_spreadsheet_would_compute_is_a_text() {
        let dir = tempfile::tempdir().expect("made");
        let row = |name: &str, late_s| Row { name: name.to_owned(), late_s, text: Some("a, \"b\"\n=c".to_owned()) };
        let rows = [
            row("=HYPERLINK(\"http://x\")", -1.5),
            row("+1", 2.0),
            row("@SUM(1)", 0.0),
            row("-x", 0.0),
            row("'=", 0.0),
        ];
        table(dir.path(), "order.csv", rows.into_iter()).expect("written");
        let mut read = csv::Reader::from_path(dir.path().join("order.csv")).expect("there");
        assert_eq!(read.headers().expect("names"), vec!["name", "late_s", "text"]);
        let read: Vec<[String; 3]> = read.deserialize().map(|row| row.expect("a row")).collect();
        let names: Vec<&str> = read.iter().map(|row| row[0].as_str()).collect();
        assert_eq!(names, ["'=HYPERLINK(\"http://x\")", "+1", "'@SUM(1)", "'-x", "'="]);
        assert!(read.iter().all(|row| row[2] == "a, \"b\"\n=c"));
        assert_eq!(read[0][1], "-1.5");
        table(dir.path(), "none.csv", std::iter::empty::<Row>()).expect("written");
        assert_eq!(std::fs::read_to_string(dir.path().join("none.csv")).expect("there"), "name,late_s,text\n");
    }
}
