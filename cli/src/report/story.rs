//! Data of a database for a span of time, read once for all forms of output.

use std::collections::BTreeMap;

use linewright_coordinator_cell::FiringId;
use linewright_coordinator_cell::production::ProductionOrder;
use linewright_coordinator_cell::tracking::{Activities, CellSummary, FinishedActivity, Tracking};
use linewright_history::{CellAbout, EventKind, HistoryError, HistoryReader, Note, TimeBase};
use linewright_line::Tick;
use miette::miette;

use super::when::{self, Zone};

/// The requested span, as far as the database has it: after its last event nothing is recorded.
///
/// # Errors
/// A fault of the database, or of the span.
pub fn span(
    reader: &HistoryReader,
    (from, to): (Option<&str>, Option<&str>),
    clock: TimeBase,
    zone: Zone,
) -> miette::Result<(Tick, Tick)> {
    let time = |text: Option<&str>| text.map(|text| when::parse(text, clock, zone)).transpose();
    let (from, to) = (time(from)?, time(to)?);
    let Some((first, last)) = reader.span().map_err(failed)? else {
        return Err(miette!("nothing has happened yet in this database"));
    };
    let (from, to) = (from.unwrap_or(first).max(first), to.unwrap_or(last));
    if from > to {
        let show = |tick| when::show(tick, clock, zone);
        let (from, to, first, last) = (show(from), show(to), show(first), show(last));
        return Err(miette!("nothing lies from {from} to {to}; the database has {first} to {last}"));
    }
    Ok((from, to.min(last)))
}

/// Data of a cell's database.
pub struct ReportSource {
    /// The database, as it was at one moment.
    pub reader: HistoryReader,
    pub about: CellAbout,
    /// Time zone of the output.
    pub zone: Zone,
    /// The span that is reported.
    pub from: Tick,
    /// Its end.
    pub to: Tick,
    /// Sums.
    pub tracking: Tracking,
    /// The same, of the span.
    pub report: CellSummary,
    /// The activities that are at least partly within the span.
    pub activities: Vec<FinishedActivity>,
    /// When each of them was planned, if it was.
    pub planned: BTreeMap<FiringId, (Tick, Tick)>,
    /// Records that are not in the database.
    pub missing: Vec<(u64, u64)>,
    /// Notes that could not be written: first, last, how many.
    pub gaps: Vec<(Tick, Tick, u64)>,
}

/// From when on a database has data, as a line, if older ones were removed.
pub fn removed_text(reader: &HistoryReader, show: impl Fn(Tick) -> String) -> String {
    let removed = reader.removed().ok().flatten();
    removed.map_or_else(String::new, |removed| {
        format!("what was before {} is removed by --retention\n", show(removed.until))
    })
}

/// Converts an error of the database.
pub fn failed(error: HistoryError) -> miette::Report {
    miette!("{error}")
}

impl ReportSource {
    /// Reads the database of a cell.
    ///
    /// # Errors
    /// A fault of the database.
    pub fn read(reader: HistoryReader, about: CellAbout, span: (Tick, Tick), zone: Zone) -> miette::Result<Self> {
        let (from, to) = span;
        let (mut tracking, mut activities) = (Tracking::since(about.sheet.clone(), from), Activities::default());
        let (mut planned, mut missing, mut gaps) = (BTreeMap::new(), Vec::new(), Vec::new());
        reader
            .each(to, |event| {
                if let Some(record) = event.record() {
                    tracking.take(&record);
                    activities.take(&record);
                }
                match event.what {
                    EventKind::Note(Note::Planned { firing, from, to }) => _ = planned.insert(firing, (from, to)),
                    EventKind::Note(Note::Missing { from, to }) => missing.push((from, to)),
                    EventKind::Note(Note::Gap { from, to, lost }) => gaps.push((from, to, lost)),
                    EventKind::Note(
                        Note::Mode { .. }
                        | Note::EmergencyStop { .. }
                        | Note::Station { .. }
                        | Note::Device { .. }
                        | Note::Began {}
                        | Note::Motion { .. }
                        | Note::Waited { .. }
                        | Note::Fault { .. }
                        | Note::Cycle { .. }
                        | Note::Observed {}
                        | Note::Said { .. },
                    )
                    | EventKind::Fact(..) => (),
                }
            })
            .map_err(failed)?;
        let within = activities.all().iter().filter(|done| done.ended.is_none_or(|ended| ended >= from));
        let activities = within.cloned().collect();
        let report = tracking.report(to);
        Ok(ReportSource { reader, about, zone, from, to, tracking, report, activities, planned, missing, gaps })
    }

    /// The production orders that were not over before the span.
    pub fn orders(&self) -> impl Iterator<Item = &ProductionOrder> {
        let all = self.tracking.production().orders();
        all.filter(|order| order.ended.is_none_or(|ended| ended >= self.from))
    }

    /// A time, as people read it.
    pub fn show(&self, tick: Tick) -> String {
        when::show(tick, self.about.clock, self.zone)
    }

    /// From when on there is anything, if older data were removed.
    fn removed(&self) -> String {
        removed_text(&self.reader, |at| self.show(at))
    }

    pub fn text(&self) -> String {
        // What was removed is no fault of the record.
        let removed_to = self.reader.removed().ok().flatten().map_or(0, |removed| removed.log);
        let missing = self.missing.iter().filter(|(_, to)| *to > removed_to);
        let missing = missing.map(|(from, to)| format!("records {from} to {to} of the log are missing\n"));
        let (title, from, to) = (&self.about.title, self.show(self.from), self.show(self.to));
        let gaps = self.gaps.iter().map(|&(from, to, lost)| {
            format!("{lost} notes from {} to {} could not be written\n", self.show(from), self.show(to))
        });
        let (removed, missing, gaps) = (self.removed(), missing.collect::<String>(), gaps.collect::<String>());
        format!("{title}, {from} to {to}\n{removed}{missing}{gaps}{}", self.report)
    }
}
