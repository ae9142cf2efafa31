//! Events of a run, in order: for assertions, and for a person when one fails.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};
use linewright_station_logic::StationHappening;

#[derive(Clone, Debug, PartialEq)]
pub enum LogKind {
    /// At a station, by its own account.
    Station(StationId, StationHappening),
    /// The coordinator entered a mode.
    Mode(ControlMode),
    /// The coordinator refused a command, in words.
    Refusal(String),
    /// An action of an operator or of the scenario.
    Act(String),
}

/// One line of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct SimLogEntry {
    /// Time of the event, in µs of the caller's clock.
    pub at: Tick,
    pub what: LogKind,
}

#[derive(Clone, Debug, Default)]
pub struct RunLog {
    entries: Vec<SimLogEntry>,
    forgotten: u64,
}

/// Bound of the memory of an endless run: beyond this the older half is dropped.
const ENTRIES_MAX: usize = 400_000;

impl RunLog {
    /// Adds an entry.
    pub fn push(&mut self, at: Tick, what: LogKind) {
        if self.entries.len() == ENTRIES_MAX {
            self.entries.drain(..ENTRIES_MAX / 2);
            self.forgotten += ENTRIES_MAX as u64 / 2;
        }
        self.entries.push(SimLogEntry { at, what });
    }

    /// All entries, oldest first; of a very long run the latest.
    pub fn entries(&self) -> &[SimLogEntry] {
        &self.entries
    }

    /// Number of earlier entries that are not kept.
    pub fn forgotten(&self) -> u64 {
        self.forgotten
    }

    /// The events of one station.
    pub fn of(&self, station: StationId) -> impl Iterator<Item = (Tick, StationHappening)> + '_ {
        self.entries.iter().filter_map(move |entry| match entry.what {
            LogKind::Station(id, event) if id == station => Some((entry.at, event)),
            _ => None,
        })
    }

    /// The modes the coordinator entered.
    pub fn modes(&self) -> Vec<ControlMode> {
        let mode = |entry: &SimLogEntry| if let LogKind::Mode(mode) = entry.what { Some(mode) } else { None };
        self.entries.iter().filter_map(mode).collect()
    }

    /// All entries in words, a line each; where the oldest are not kept, that is the first line.
    pub fn text(&self, line: &Line) -> String {
        let missing = match self.forgotten {
            0 => String::new(),
            count => format!("-- {count} earlier entries are not kept\n"),
        };
        missing + &self.tail(line, usize::MAX)
    }

    /// The last `count` entries in words.
    pub fn tail(&self, line: &Line, count: usize) -> String {
        let from = self.entries.len().saturating_sub(count);
        self.entries[from..].iter().map(|entry| entry.text(line) + "\n").collect()
    }
}

impl SimLogEntry {
    /// The entry in words.
    pub fn text(&self, line: &Line) -> String {
        match &self.what {
            LogKind::Station(id, event) => {
                format!("{} {} (cycle {}) {}", self.at, line.station(*id).name, event.cycle, event.text(line, *id))
            }
            LogKind::Mode(mode) => format!("{} the line enters {mode}", self.at),
            LogKind::Refusal(text) => format!("{} {text}", self.at),
            LogKind::Act(text) => format!("{} -- {text}", self.at),
        }
    }
}
