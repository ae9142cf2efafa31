//! Record of a line in the database, beside the loop.
//!
//! Nothing waits for it: notes go through a bounded queue to a thread of their own. Where there is no room for one, nothing
//! more is offered for a second; then the observation *begins* anew with the whole situation, and a report has a gap. While
//! the database fails its thread counts what it drops, and tries again; then the observation begins anew as well. That it
//! fails, or hangs for a minute, is logged once, and the line goes on.

mod observer;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use linewright_coordinator_logic::CompletedCycle;
use linewright_history::{
    History, HistoryError, HistoryFeed, HistoryReader, LineAbout, LineOperation, LineStation, Note, TimeBase,
};
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};
use linewright_msgs::StationState;
use linewright_simulation::LinePlan;
use linewright_station_shell::NewestBySequence;

use crate::node::CoordinatorLoop;
use crate::situation::LineSituation;
pub use observer::StationObserver;

/// Longest time between two notes, so that a report shows until when the line was observed.
const NOTE_EVERY: Duration = Duration::from_secs(60);
/// Longest wait at the end of the process for notes not yet written.
const END: Duration = Duration::from_secs(1);
/// After notes have found no room, the observation begins anew this much later at the earliest.
const BEGIN_EVERY: Duration = Duration::from_secs(1);
/// A database that takes nothing for so long is reported.
const HANGS: Duration = Duration::from_secs(60);
/// The cycle that is drawn as planned: by then the line has run in.
const PLANNED_CYCLE: i32 = 10;

/// Writes what has become of a database into the log.
pub(crate) fn log_news(feed: &HistoryFeed) {
    while let Some(news) = feed.news() {
        if news.is_warning() {
            tracing::warn!("{news}");
        } else {
            tracing::info!("{news}");
        }
    }
}

/// Feeds the database of a line.
pub struct LineHistory {
    feed: HistoryFeed,
    /// The calendar's time when the clock of the loop was at zero.
    origin: Tick,
    stations: Vec<StationObserver>,
    newest: Vec<NewestBySequence>,
    /// The situation noted last; none before everything has been noted.
    noted: Option<LineSituation>,
    /// The observation does not begin before.
    begin_due: Tick,
    /// [`HistoryFeed::resumed`] as the situation was noted last.
    resumed: u64,
    /// Time since which notes have found no room, and whether that is reported.
    no_room: Option<(Tick, bool)>,
    note_due: Tick,
    notes: Vec<Note>,
}

/// Identity of the line for the database.
fn about(line: &Line) -> LineAbout {
    let plan = LinePlan::of(line);
    let schedule = plan.schedule(usize::try_from(PLANNED_CYCLE).unwrap_or(0) + 1);
    let planned = |id: StationId| {
        let ops = line.station(id).op_ids();
        ops.map(|op| plan.planned(&schedule, (id, op), PLANNED_CYCLE)).collect::<Vec<_>>()
    };
    let all: Vec<Vec<_>> = line.station_ids().map(planned).collect();
    let first = all.iter().flatten().flatten().map(|times| times.start).min().unwrap_or(0);
    let stations = line.station_ids().zip(&all).map(|(id, planned)| LineStation {
        name: line.station(id).name.clone(),
        operations: std::iter::zip(&line.station(id).operations, planned)
            .map(|(operation, planned)| LineOperation {
                name: operation.name.clone(),
                planned_us: planned.map(|times| (times.start - first, times.end - first)),
            })
            .collect(),
    });
    LineAbout {
        line: line.name.clone(),
        title: line.title.clone(),
        clock: TimeBase::Unix,
        stations: stations.collect(),
        cycle_us: plan.cycle_time().max(0.0).round() as u64,
    }
}

/// Its file in a state directory.
fn database(dir: &Path) -> PathBuf {
    dir.join("line.db")
}

/// Why nothing of this line would be recorded in `dir`, and what to do, if the database there is another one's. A damaged or empty one
/// is not: a new one is begun.
pub fn not_recorded(dir: &Path, line: &Line) -> Option<String> {
    let path = database(dir);
    let found = path.exists().then(|| HistoryReader::open(&path).and_then(|db| db.fits(&about(line))))?;
    let error = found.err().filter(|error| matches!(error, HistoryError::Other { .. } | HistoryError::Form { .. }))?;
    let remedy = error.remedy().map_or_else(String::new, |remedy| format!("; {remedy}"));
    Some(format!("nothing of this run is recorded: {error}{remedy}"))
}

impl LineHistory {
    /// Feeds the database in `dir`, which is made if there is none, and keeps so much. Nothing is waited for.
    pub fn begin(dir: &Path, line: &Line, now: Tick, retention: Option<Duration>) -> Self {
        let (path, of) = (database(dir), line.clone());
        let mut known = None;
        let open = move || Ok(History::open(&path, &*known.get_or_insert_with(|| about(&of)))?.keeping(retention));
        Self::with(open, line, now)
    }

    /// The same with a database that `open` opens, on the thread that feeds it, and again after each failure.
    pub fn with(open: impl FnMut() -> Result<History, HistoryError> + Send + 'static, line: &Line, now: Tick) -> Self {
        let wall = Tick::ZERO + SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        LineHistory {
            feed: HistoryFeed::of_notes(open),
            origin: wall - now.since(Tick::ZERO),
            stations: line.stations.iter().map(|station| StationObserver::new(station.operations.len())).collect(),
            newest: vec![NewestBySequence::new(line.timing.stale); line.stations.len()],
            noted: None,
            begin_due: now,
            resumed: 0,
            no_room: None,
            note_due: now,
            notes: Vec::new(),
        }
    }

    /// A station's state has arrived.
    pub fn state(&mut self, now: Tick, station: StationId, state: &StationState) {
        if self.newest[station.index()].offer(now, state.boot_id, state.sequence) {
            let at = self.at(now);
            self.stations[station.index()].state(number(station), at, state, &mut self.notes);
            self.offer(now);
        }
    }

    /// The line has completed a cycle.
    pub fn cycle(&mut self, now: Tick, cycle: CompletedCycle) {
        let took_us = cycle.took.map(|took| u64::try_from(took.as_micros()).unwrap_or(u64::MAX));
        self.notes.push(Note::Cycle { number: cycle.number, took_us });
        self.offer(now);
    }

    /// Records the situation of the line, and logs what has become of the database. False if nothing will be written any
    /// more.
    pub fn situation(&mut self, now: Tick, situation: &LineSituation) -> bool {
        log_news(&self.feed);
        if self.feed.has_ended() {
            tracing::error!("{}; the line continues without", self.feed.failed().unwrap_or_default());
            return false;
        }
        let resumed = self.feed.resumed();
        if std::mem::replace(&mut self.resumed, resumed) != resumed {
            (self.noted, self.begin_due) = (None, now);
        }
        if let Some((since, is_reported @ false)) = &mut self.no_room
            && now.since(*since) >= HANGS
        {
            *is_reported = true;
            tracing::error!("the database has taken nothing for {} s; the line continues", HANGS.as_secs());
        }
        let at = self.at(now);
        match &mut self.noted {
            Some(noted) if *noted != *situation => {
                for (index, observer) in self.stations.iter_mut().enumerate() {
                    if noted.heard[index] && !situation.heard[index] {
                        observer.lost(index_number(index), at, &mut self.notes);
                    }
                }
                self.notes.extend(situation.notes_since(noted));
                noted.clone_from(situation);
            }
            Some(_) => {}
            None if now < self.begin_due => {}
            None => {
                // The mode is always noted, stations only where they are not well.
                let all_well = LineSituation {
                    starts: !situation.starts,
                    heard: vec![true; situation.heard.len()],
                    devices: vec![true; situation.devices.len()],
                    ..LineSituation::new(0)
                };
                self.notes.push(Note::Began {});
                self.notes.extend(situation.notes_since(&all_well));
                for (index, observer) in self.stations.iter_mut().enumerate() {
                    observer.begin(index_number(index), at, &mut self.notes);
                }
                self.noted = Some(situation.clone());
            }
        }
        if self.notes.is_empty() && now >= self.note_due {
            for (index, observer) in self.stations.iter_mut().enumerate() {
                observer.flush(index_number(index), at, &mut self.notes);
            }
            self.notes.push(Note::Observed {});
        }
        self.offer(now);
        true
    }

    /// Writes the rest, as far as the disk takes it at once.
    pub fn end(mut self, now: Tick) {
        let at = self.at(now);
        for (index, observer) in self.stations.iter_mut().enumerate() {
            observer.flush(index_number(index), at, &mut self.notes);
        }
        self.notes.push(Note::Observed {});
        self.offer(now);
        self.feed.end_within(END);
    }

    fn at(&self, now: Tick) -> Tick {
        self.origin + now.since(Tick::ZERO)
    }

    /// Offers the notes. Before the observation has begun, and from one on that finds no room, they are dropped.
    fn offer(&mut self, now: Tick) {
        if self.notes.is_empty() {
            return;
        }
        let at = self.at(now);
        self.note_due = now + NOTE_EVERY;
        let is_begun = self.noted.is_some();
        let mut notes = self.notes.drain(..);
        if !is_begun {
            return;
        }
        if notes.all(|note| self.feed.offer_note(at, note)) {
            self.no_room = None;
        } else {
            drop(notes);
            self.noted = None;
            self.begin_due = now + BEGIN_EVERY;
            self.no_room.get_or_insert((now, false));
        }
    }
}

fn number(station: StationId) -> u16 {
    index_number(station.index())
}

/// A line has far fewer stations than that.
fn index_number(index: usize) -> u16 {
    u16::try_from(index).unwrap_or(u16::MAX)
}

impl CoordinatorLoop {
    /// Passes the situation to the cell, or to the database of the line.
    pub(crate) fn tell_situation(&mut self, at: Tick) {
        let coordinator = self.shell.coordinator();
        let order = coordinator.order();
        let now = &mut self.situation;
        // A cell starts nothing while the line stops at home; a line goes on until it is there.
        let may_start = self.cell.is_none() || order.master_stop.is_none();
        now.starts = order.mode == ControlMode::Auto && order.enabled && may_start;
        now.mode = order.mode;
        for id in self.line.station_ids() {
            now.heard[id.index()] = coordinator.hears(id);
            now.devices[id.index()] = self.shell.has_devices(id);
        }
        let by_hand = self.line.station_ids().filter(|&id| coordinator.is_by_hand(id));
        now.in_manual = by_hand.map(|id| (id, coordinator.single_epoch(id))).collect();
        if let Some(cell) = &self.cell {
            cell.tell(now);
        }
        if let Some(history) = &mut self.history
            && !history.situation(at, now)
        {
            self.history = None;
        }
    }
}
