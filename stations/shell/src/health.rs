//! What a node reports about itself for diagnostics, as values.
//!
//! A check is *ok* only by something that the node knows now. There is no level for what is not heard: a node that does not report is
//! found by its reader, by the age of its last report.

use std::time::Duration;

use linewright_line::Tick;

/// How a checked thing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HealthLevel {
    /// As it should be.
    Ok,
    /// It works, but is to be looked at; or it is not known yet.
    Warn,
    /// It does not work.
    Error,
}

/// One checked thing of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HealthCheck {
    /// Name of the check, the same in each report.
    pub name: &'static str,
    pub level: HealthLevel,
    /// State in a sentence.
    pub message: String,
    /// Details by name, in the same order in each report.
    pub values: Vec<(String, String)>,
}

impl HealthCheck {
    /// A check without values.
    pub fn new(name: &'static str, level: HealthLevel, message: impl Into<String>) -> Self {
        HealthCheck { name, level, message: message.into(), values: Vec::new() }
    }

    /// The same with one more value.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, value: impl ToString) -> Self {
        self.values.push((name.into(), value.to_string()));
        self
    }
}

/// The checks of a station's node, in the order of its reports.
pub const STATION_CHECKS: [&str; 5] = ["operation", "coordinator", "stations", "journal", "messages"];

/// A time as a value of a check, in whole ms.
pub(crate) fn ms(time: Duration) -> String {
    format!("{} ms", time.as_millis())
}

/// How a node's journal is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JournalFacts {
    /// It has none.
    None,
    /// Records are kept.
    Kept {
        /// Records written since the node started.
        records: u64,
        /// Time that the last one took.
        last: Duration,
        /// Time of the longest.
        longest: Duration,
    },
    /// The last record could not be written.
    Lost,
}

/// The check of a journal. A record is to take less than a `period`, that of whole states.
pub fn journal_check(facts: JournalFacts, period: Duration) -> HealthCheck {
    let check = |level, message: &str| HealthCheck::new("journal", level, message);
    match facts {
        JournalFacts::None => check(HealthLevel::Warn, "nothing is kept over a restart of the node"),
        JournalFacts::Lost => check(HealthLevel::Error, "not writable"),
        JournalFacts::Kept { records, last, longest } => {
            let message = format!("slow: the last record took {}, longer than {}", ms(last), ms(period));
            let found = match last > period {
                true => check(HealthLevel::Warn, &message),
                false => check(HealthLevel::Ok, "written"),
            };
            found.with("records", records).with("last record took", ms(last)).with("longest record took", ms(longest))
        }
    }
}

/// Time for which a count that has grown is worth a look.
const RECENT: Duration = Duration::from_secs(60);

/// Whether a count has grown in the last minute.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecentGrowth {
    count: u64,
    grown: Option<Tick>,
}

impl RecentGrowth {
    /// Takes the count as it is now. Its beginning at 0 is no growth.
    pub fn offer(&mut self, now: Tick, count: u64) -> bool {
        if count > self.count {
            self.grown = Some(now);
        }
        self.count = count;
        self.grown.is_some_and(|grown| now < grown + RECENT)
    }
}

/// The check of messages: how many that arrived were ignored, and how many could not be sent.
pub fn messages_check((ignored, unsent): (u64, u64), is_recent: bool) -> HealthCheck {
    let found = match (is_recent, ignored + unsent) {
        (true, _) => HealthCheck::new(
            "messages",
            HealthLevel::Warn,
            "messages ignored or not sent in the last minute; the log of the node has the reasons",
        ),
        (false, 0) => HealthCheck::new("messages", HealthLevel::Ok, "none ignored, all sent"),
        (false, _) => HealthCheck::new("messages", HealthLevel::Ok, "none ignored and all sent in the last minute"),
    };
    found.with("ignored", ignored).with("not sent", unsent)
}
