//! An event as a row of a table: with names instead of numbers.

use std::time::Duration;

use linewright_history::{EventKind, HistoryEvent};
use serde::Serialize;
use serde_json::Value;

use super::story::ReportSource;

/// A time in seconds, as near as a number has it: in a sum of whole and parts of a second 2.908088 is 2.9080880000000002.
pub fn in_seconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e9
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_no_more_digits_than_they_were_measured_with() {
        for micros in [2_908_088_u64, 1, 60_000_001, 7_200_123_457] {
            let (time, text) = (Duration::from_micros(micros), in_seconds(Duration::from_micros(micros)).to_string());
            let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len());
            assert!(digits <= 6 && text.parse() == Ok(in_seconds(time)), "{text}");
        }
        assert_eq!(in_seconds(Duration::from_micros(2_908_088)).to_string(), "2.908088");
    }
}
