//! The description's outermost tables, and those of what is between stations.

use std::time::Duration;

use linewright_text::{
    KeyKind, KeyPresence, Keys, Located, LocatedName, Problem, Report, Shape, integer, keys, millis, one_of,
    suggestion, table, tables, text, texts,
};

use super::handling::{RawSensor, RawStore, stores};
use super::station_type::{self, RawStationType, TYPES_MAX};
use super::{RawDevice, RawHolder, RawStation};
use crate::BUTTONS_MAX;

/// At most this many stations: far more than one line has, and few enough to explore a mistake quickly.
const STATIONS_MAX: usize = 1000;
/// At most this many arrows, and conflicts.
pub(super) const ARROWS_MAX: usize = 10_000;
pub(super) const CONFLICTS_MAX: usize = 10_000;
/// At most this many devices.
pub(super) const DEVICES_MAX: usize = 4000;
/// At most this many places for parts that belong to no station.
const HOLDERS_MAX: usize = 1000;
/// At most this many inputs that see parts.
pub(super) const SENSORS_MAX: usize = 4000;
/// A lag above this is a slip: it would let one station run that many cycles ahead.
const LAG_MAX: i64 = 8;
/// Far more than there are modes, so that one that is named twice is reported as such.
const MODES_MAX: usize = 8;

keys! {
    /// A production line: its stations and their operations, the arrows of the timing bar chart, what must never happen,
    /// and the devices. Lengths are in millimetres (degrees for a turning axis), times in seconds unless a key ends in `_ms`.
    pub(in crate::parse) struct RawLine is "the description" {
        /// The ROS namespace: lower-case letters, digits and single `_`, a letter first, at most 64.
        name: Option<LocatedName> = text().required(),
        /// Title of the line for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// Names of the hand-mode push buttons on the main console, at most 32.
        buttons: Vec<LocatedName> = texts(BUTTONS_MAX).entries(),
        /// Periods of repetition, and times after which a state or a device is lost. All optional.
        timing: RawTiming = table().or_default(),
        /// Types of like stations, at most 100.
        types as "station_type": Vec<RawStationType> = tables(TYPES_MAX).like(station_type::shape),
        /// The stations, in the order of the timing bar chart; at most 1000.
        stations as "station": Vec<RawStation> = tables(STATIONS_MAX),
        /// The arrows of the timing bar chart, at most 10000.
        arrows as "arrow": Vec<RawArrow> = tables(ARROWS_MAX),
        /// Pairs of states that must never hold together, at most 10000.
        conflicts as "conflict": Vec<RawConflict> = tables(CONFLICTS_MAX),
        /// The devices on the buses, at most 4000.
        devices as "device": Vec<RawDevice> = tables(DEVICES_MAX),
        /// Places for parts outside of stations, for the simulated plant; at most 1000.
        holders as "holder": Vec<RawHolder> = tables::<RawStore>(HOLDERS_MAX).then(stores),
        /// Inputs that report parts, for the simulated plant; at most 4000.
        sensors as "sensor": Vec<RawSensor> = tables(SENSORS_MAX),
        /// The main console: names of its devices' signals, all optional.
        console: Option<RawConsole> = table(),
    }

    /// Periods of repetition, and times after which a state or a device is lost.
    #[derive(Default)]
    pub(in crate::parse) struct RawTiming is "`[timing]`" {
        /// Period of the whole state of each station and of the coordinator when nothing changes, in ms, 1 to 60000.
        refresh as "refresh_ms": Option<Located<Duration>> = millis().usually(50),
        /// Age from which a state, an image or a held button is unknown, which blocks what reads it, in ms; at least
        /// twice `refresh_ms`.
        stale as "stale_ms": Option<Located<Duration>> = millis().usually(250),
        /// Time after which a mode that is not repeated has run out, and the station is in stand-by, in ms; at least
        /// twice `refresh_ms`.
        lease as "lease_ms": Option<Located<Duration>> = millis().usually(500),
        /// Period of the heartbeat of CAN devices and managers, in ms, 1 to 60000.
        heartbeat as "heartbeat_ms": Option<Located<Duration>> = millis().usually(50),
        /// Time without a heartbeat after which a device is lost, in ms; at least twice `heartbeat_ms`.
        heartbeat_timeout as "heartbeat_timeout_ms": Option<Located<Duration>> = millis().usually(200),
        /// Period of SYNC of each manager, in ms, 1 to 60000; no SYNC if left out.
        sync as "sync_ms": Option<Located<Duration>> = millis(),
    }

    /// An arrow of the timing bar chart: an operation of one station that waits for one of another.
    pub(in crate::parse) struct RawArrow is "an arrow" {
        /// Operation that must be done: `"station: operation"`.
        from: Option<RawEnd> = text().required().then(end).like(|| Shape::Like(":")),
        /// Operation of another station that waits for it: `"station: operation"`.
        to: Option<RawEnd> = text().required().then(end).like(|| Shape::Like(":")),
        /// Number of cycles back in which it must be done, 0 to 8: 0 the same cycle, 1 the cycle before. Above 1 with a
        /// warning.
        lag: u32 = integer().then(lag).from_to(0, LAG_MAX).usually(0),
        /// Modes in which the arrow holds, `"auto"` and `"manual"`; both if left out. Hand mode observes the arrows of
        /// both.
        modes: Modes = texts(MODES_MAX).then(modes).like(|| Shape::List(Box::new(Shape::Word(vec!["auto", "manual"])), 2)),
    }

    /// Two states of two stations that must never hold together. `linewright check` proves that the arrows exclude them.
    pub(in crate::parse) struct RawConflict is "a conflict" {
        /// Reason, in words; printed with a counterexample.
        why: Option<LocatedName> = text().required(),
        /// State of one station.
        a: Option<RawSpan> = table().required().then(complete),
        /// State of another station.
        b: Option<RawSpan> = table().required().then(complete),
    }

    /// A stretch of a station's cycle, from the start of one operation to the end of another; or a task.
    pub(in crate::parse) struct RawSpan is "a state of a conflict" {
        /// The station.
        station: Option<LocatedName> = text().required(),
        /// Of a task-driven station, instead of `from` and `until`: the task, from its start to its end.
        task: Option<LocatedName> = text(),
        /// Operation with whose start the state begins.
        from: Option<LocatedName> = text().missed(KeyPresence::Unless(&["task"])),
        /// Operation with whose end the state is over.
        until: Option<LocatedName> = text().missed(KeyPresence::Unless(&["task"])),
    }

    /// The main console: names of its devices' signals.
    pub(in crate::parse) struct RawConsole is "`[console]`" {
        /// Outputs: the lamps of the modes.
        lamps: RawLamps = table().or_default(),
        /// Input: the emergency stop, on while it is pressed; or `{ input, pressed = "off" }` for a closed-circuit contact.
        estop: RawStop = contact(),
        /// Input: the master start push button.
        start: Option<LocatedName> = text(),
        /// Input: the master stop push button.
        stop: Option<LocatedName> = text(),
        /// Input: the push button for auto mode.
        auto: Option<LocatedName> = text(),
        /// Input: the push button for hand mode.
        hand: Option<LocatedName> = text(),
        /// Input: the reset push button.
        reset: Option<LocatedName> = text(),
    }

    /// The lamps of the modes.
    #[derive(Default)]
    pub(in crate::parse) struct RawLamps is "`lamps`" {
        /// Output: on in auto mode.
        auto: Option<LocatedName> = text(),
        /// Output: on in hand mode.
        hand: Option<LocatedName> = text(),
        /// Output: on while a station is in manual mode.
        manual: Option<LocatedName> = text(),
        /// Output: on while there is a fault.
        fault: Option<LocatedName> = text(),
    }

    /// The contact of the emergency stop.
    pub(in crate::parse) struct RawContact is "`estop`" {
        /// The input.
        input: Option<LocatedName> = text().required(),
        /// Value of the input while the button is pressed: `"off"` for a closed-circuit contact, whose input is off
        /// when its wire is broken, too.
        pressed: Option<Located<bool>> = one_of(&[("on", true), ("off", false)]).required(),
    }
}

/// An end of an arrow, `station: operation`, taken apart; each half with its own place.
#[derive(Clone, Debug)]
pub(in crate::parse) struct RawEnd {
    pub station: LocatedName,
    pub operation: LocatedName,
}

/// The modes an arrow holds in.
#[derive(Clone, Copy, Debug)]
pub(in crate::parse) struct Modes {
    pub auto: bool,
    pub manual: bool,
}

/// The emergency stop's input, and what it reads while it is pressed.
#[derive(Debug)]
pub(in crate::parse) struct RawStop {
    pub input: Option<LocatedName>,
    pub pressed: bool,
}

/// Takes `station: operation` apart, keeping a place for each half where the text is written plainly.
fn end(text: Option<LocatedName>, report: &mut Report) -> Option<RawEnd> {
    let text = text?;
    let Some((station, operation)) = text.value.split_once(':') else {
        report.add(
            Problem::error(text.at, format!("`{}` names no operation", text.value))
                .label("no colon")
                .hint("an end of an arrow is written \"station: operation\""),
        );
        return None;
    };
    let (station, operation) = (station.trim(), operation.trim());
    // Quotes and nothing else around the text: no escapes, so byte offsets inside it are offsets in the file.
    let plain = text.at.len() == text.value.len() + 2;
    let half = |part: &str| {
        let offset = part.as_ptr() as usize - text.value.as_ptr() as usize;
        let start = text.at.start + 1 + offset;
        let at = if plain && !part.is_empty() { start..start + part.len() } else { text.at.clone() };
        Located::new(part.to_owned(), at)
    };
    Some(RawEnd { station: half(station), operation: half(operation) })
}

fn lag(lag: Option<Located<i64>>, report: &mut Report) -> u32 {
    let Some(Located { value: cycles, at }) = lag else { return 0 };
    match u32::try_from(cycles) {
        Ok(value) if cycles <= LAG_MAX => {
            if value > 1 {
                report.add(
                    Problem::warning(at, format!("a lag of {value} cycles"))
                        .label("unusually long")
                        .hint("0 is the same cycle, 1 the one before; more lets a station run that far ahead"),
                );
            }
            value
        }
        _ => {
            report.add(
                Problem::error(at, format!("a lag of {cycles} cycles"))
                    .hint(format!("a lag is 0 (same cycle), 1 (the cycle before) or, rarely, up to {LAG_MAX}")),
            );
            // With this no circle of arrows is a deadlock, which would follow from the slip.
            1
        }
    }
}

/// Both by default.
fn modes(modes: Option<Located<Vec<LocatedName>>>, report: &mut Report) -> Modes {
    const BOTH: Modes = Modes { auto: true, manual: true };
    let Some(modes) = modes else { return BOTH };
    if modes.value.is_empty() {
        report.add(
            Problem::error(modes.at, "an arrow that holds in no mode")
                .label("empty")
                .hint("leave `modes` out for both, or name \"auto\", \"manual\", or remove the arrow"),
        );
        return BOTH;
    }
    let mut holds = Modes { auto: false, manual: false };
    for mode in modes.value {
        let seen = match mode.value.as_str() {
            "auto" => &mut holds.auto,
            "manual" => &mut holds.manual,
            other => {
                let hint = match other {
                    "hand" => Some("hand mode observes the arrows of auto and manual alike".to_owned()),
                    _ => suggestion(other, ["auto", "manual"]),
                };
                report.add(Problem::error(mode.at, format!("unknown mode `{other}` of an arrow")).maybe_hint(hint));
                continue;
            }
        };
        if std::mem::replace(seen, true) {
            report.add(Problem::error(mode.at, format!("mode `{}` twice", mode.value)).label("again"));
        }
    }
    holds
}

/// Reports a state that is neither a stretch of a cycle nor a task.
fn complete(span: Option<RawSpan>, report: &mut Report) -> Option<RawSpan> {
    let span = span?;
    let at = || span.at.clone();
    let missing = match (&span.task, &span.from, &span.until) {
        (Some(_), Some(end), _) | (Some(_), None, Some(end)) => Some(
            Problem::error(end.at.clone(), "a stretch of a cycle beside `task`")
                .hint("a task is a state from its start to its end: leave `from` and `until` out"),
        ),
        (None, None, None) => Some(
            Problem::error(at(), "a state of a conflict needs `from` and `until`, or `task`")
                .hint("the first and the last operation of a stretch of the cycle; of a task-driven station, a task"),
        ),
        (None, None, Some(_)) => Some(Problem::error(at(), "a state of a conflict needs `from`")),
        (None, Some(_), None) => Some(Problem::error(at(), "a state of a conflict needs `until`")),
        (Some(_), None, None) | (None, Some(_), Some(_)) => None,
    };
    missing.into_iter().for_each(|problem| report.add(problem));
    Some(span)
}

/// An input, on while pressed; or `{ input = …, pressed = "off" }`.
fn contact() -> KeyKind<RawStop> {
    KeyKind::new(
        |f, report, key| {
            if !f.is_table(key) {
                return RawStop { input: text().read(f, report, key), pressed: true };
            }
            let Some(contact) = table::<RawContact>().read(f, report, key) else {
                return RawStop { input: None, pressed: true };
            };
            RawStop { input: contact.input, pressed: contact.pressed.is_none_or(|pressed| pressed.value) }
        },
        || Shape::Either(vec![Shape::Text, RawContact::shape()]),
    )
}
