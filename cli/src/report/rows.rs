//! An event as a row of a table: with names instead of numbers.

use linewright_history::{EventKind, HistoryEvent};
use serde::Serialize;
use serde_json::Value;

use super::story::ReportSource;

/// Something that has happened.
#[derive(Default, Serialize)]
pub struct EventRow {
    /// Its number in the log; none for what is no record.
    pub log: Option<u64>,
    /// When, in microseconds.
    pub at_us: u64,
    /// The same, as the report shows times.
    pub time: String,
    /// Its word.
    pub kind: String,
    /// The station it is about.
    pub station: Option<String>,
    /// The mode it is about, by its name.
    pub activity: Option<String>,
    /// The part it is about.
    pub part: Option<u64>,
    /// The activity it is about.
    pub firing: Option<u64>,
    /// All of it, as JSON.
    pub data: String,
}

/// The subject of an event is in its JSON under the same keys, whatever its kind.
pub fn event_row(story: &ReportSource, event: &HistoryEvent) -> EventRow {
    let (kind, data) = event.parts();
    let value: Value = serde_json::from_str(&data).unwrap_or_default();
    let number = |name: &str| value.get(name).and_then(Value::as_u64);
    let index = |name: &str| number(name).and_then(|of| usize::try_from(of).ok());
    EventRow {
        log: match event.what {
            EventKind::Fact(number, _) => Some(number),
            EventKind::Note(_) => None,
        },
        at_us: event.at.as_micros(),
        time: story.show(event.at),
        kind,
        station: index("station").and_then(|of| story.about.stations.get(of)).cloned(),
        activity: index("mode").and_then(|of| story.about.sheet.modes.get(of)).map(|entry| entry.name.clone()),
        part: number("part"),
        firing: number("firing"),
        data,
    }
}
