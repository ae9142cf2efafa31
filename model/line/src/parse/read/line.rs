//! The description's outermost tables: everything but the stations' insides.

use linewright_text::{At, Fields, Name, Problem, Report, Where, suggestion};

use super::{
    ARROWS_MAX, CONFLICTS_MAX, DEVICE_BITS, DEVICES_MAX, HOLDERS_MAX, SENSORS_MAX, SETTINGS_MAX, STATIONS_MAX,
    analogue, drive, frames, handling, modbus, setup, station,
};
use crate::BUTTONS_MAX;
use crate::parse::raw::{
    RawArrow, RawConflict, RawConsole, RawDevice, RawDeviceKind, RawEnd, RawLine, RawSpan, RawTiming,
};

/// A lag above this is a slip: it would let one station run that many cycles ahead.
const LAG_MAX: i64 = 8;

pub(super) fn line(mut top: Fields<'_>, report: &mut Report) -> RawLine {
    let raw = RawLine {
        name: top.required_text(report, "name"),
        title: top.text(report, "title"),
        buttons: top.texts(report, "buttons", BUTTONS_MAX).map(|b| b.value).unwrap_or_default(),
        timing: top.table(report, "timing", "`[timing]`").map(|f| timing(f, report)).unwrap_or_default(),
        stations: each(top.tables(report, "station", "a station", STATIONS_MAX), report, station::station),
        arrows: each(top.tables(report, "arrow", "an arrow", ARROWS_MAX), report, arrow),
        conflicts: each(top.tables(report, "conflict", "a conflict", CONFLICTS_MAX), report, conflict),
        devices: each(top.tables(report, "device", "a device", DEVICES_MAX), report, device),
        holders: each(top.tables(report, "holder", "a holder", HOLDERS_MAX), report, handling::store),
        sensors: each(top.tables(report, "sensor", "a sensor", SENSORS_MAX), report, handling::sensor),
        console: top.table(report, "console", "`[console]`").map(|f| console(f, report)),
    };
    top.finish(report);
    raw
}

pub(super) fn each<T>(
    tables: Vec<Fields<'_>>,
    report: &mut Report,
    read: impl Fn(Fields<'_>, &mut Report) -> T,
) -> Vec<T> {
    tables.into_iter().map(|fields| read(fields, report)).collect()
}

fn timing(mut f: Fields<'_>, report: &mut Report) -> RawTiming {
    let raw = RawTiming {
        refresh: f.millis(report, "refresh_ms"),
        stale: f.millis(report, "stale_ms"),
        lease: f.millis(report, "lease_ms"),
        heartbeat: f.millis(report, "heartbeat_ms"),
        heartbeat_timeout: f.millis(report, "heartbeat_timeout_ms"),
        sync: f.millis(report, "sync_ms"),
    };
    f.finish(report);
    raw
}

fn arrow(mut f: Fields<'_>, report: &mut Report) -> RawArrow {
    let from = f.required_text(report, "from").and_then(|text| end(text, report));
    let to = f.required_text(report, "to").and_then(|text| end(text, report));
    let lag = f.integer(report, "lag");
    let (auto, manual) = modes(&mut f, report);
    let raw = RawArrow {
        at: f.at.clone(),
        from,
        to,
        lag: lag.as_ref().and_then(|lag| checked_lag(lag, report)).unwrap_or(0),
        auto,
        manual,
    };
    f.finish(report);
    raw
}

/// Takes `station: operation` apart, keeping a place for each half where the text is written plainly.
fn end(text: Name, report: &mut Report) -> Option<RawEnd> {
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
        At::new(part.to_owned(), at)
    };
    Some(RawEnd { station: half(station), operation: half(operation) })
}

fn checked_lag(lag: &At<i64>, report: &mut Report) -> Option<u32> {
    match u32::try_from(lag.value) {
        Ok(value) if lag.value <= LAG_MAX => {
            if value > 1 {
                report.add(
                    Problem::warning(lag.at.clone(), format!("a lag of {value} cycles"))
                        .label("unusually long")
                        .hint("0 is the same cycle, 1 the one before; more lets a station run that far ahead"),
                );
            }
            Some(value)
        }
        _ => {
            report.add(
                Problem::error(lag.at.clone(), format!("a lag of {} cycles", lag.value))
                    .hint(format!("a lag is 0 (same cycle), 1 (the cycle before) or, rarely, up to {LAG_MAX}")),
            );
            None
        }
    }
}

/// The modes an arrow holds in: both, unless it says otherwise.
fn modes(f: &mut Fields<'_>, report: &mut Report) -> (bool, bool) {
    let Some(modes) = f.texts(report, "modes", 8) else { return (true, true) };
    if modes.value.is_empty() {
        report.add(
            Problem::error(modes.at, "an arrow that holds in no mode")
                .label("empty")
                .hint("leave `modes` out for both, or name \"auto\", \"manual\", or remove the arrow"),
        );
        return (true, true);
    }
    let (mut auto, mut manual) = (false, false);
    for mode in modes.value {
        let seen = match mode.value.as_str() {
            "auto" => &mut auto,
            "manual" => &mut manual,
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
    (auto, manual)
}

fn conflict(mut f: Fields<'_>, report: &mut Report) -> RawConflict {
    let raw = RawConflict {
        at: f.at.clone(),
        why: f.required_text(report, "why"),
        a: f.required_table(report, "a", "a state of a conflict").map(|f| span(f, report)),
        b: f.required_table(report, "b", "a state of a conflict").map(|f| span(f, report)),
    };
    f.finish(report);
    raw
}

fn span(mut f: Fields<'_>, report: &mut Report) -> RawSpan {
    let (at, station, task) = (f.at.clone(), f.required_text(report, "station"), f.text(report, "task"));
    let (from, until) = (f.text(report, "from"), f.text(report, "until"));
    let missing = match (&task, &from, &until) {
        (Some(_), Some(end), _) | (Some(_), None, Some(end)) => Some(
            Problem::error(end.at.clone(), "a stretch of a cycle beside `task`")
                .hint("a task is a state from its start to its end: leave `from` and `until` out"),
        ),
        (None, None, None) => Some(
            Problem::error(at.clone(), "a state of a conflict needs `from` and `until`, or `task`")
                .hint("the first and the last operation of a stretch of the cycle; of a station on order, a task"),
        ),
        (None, None, Some(_)) => Some(Problem::error(at.clone(), "a state of a conflict needs `from`")),
        (None, Some(_), None) => Some(Problem::error(at.clone(), "a state of a conflict needs `until`")),
        (Some(_), None, None) | (None, Some(_), Some(_)) => None,
    };
    missing.into_iter().for_each(|problem| report.add(problem));
    let raw = RawSpan { at, station, from, until, task };
    f.finish(report);
    raw
}

fn device(mut f: Fields<'_>, report: &mut Report) -> RawDevice {
    let mut bits = |key| f.texts(report, key, DEVICE_BITS).map(|b| b.value).unwrap_or_default();
    let (inputs, outputs) = (bits("inputs"), bits("outputs"));
    let frames = f.table(report, "dbc", "`dbc`").map(|f| frames::frames(f, report));
    let kinds = [("canopen", RawDeviceKind::Canopen), ("modbus", RawDeviceKind::Modbus)];
    let kind = f.maybe_word(report, "kind", &kinds);
    let modbus = f.table(report, "modbus", "`modbus`").map(|f| modbus::modbus(f, report));
    // Whoever speaks no CANopen has no node id.
    let speaks_another =
        frames.is_some() || modbus.is_some() || kind.as_ref().is_some_and(|kind| kind.value == RawDeviceKind::Modbus);
    let node = if speaks_another { f.integer(report, "node") } else { f.required_integer(report, "node") };
    let raw = RawDevice {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        node,
        station: f.text(report, "station"),
        console: f.flag(report, "console"),
        inputs,
        outputs,
        file: f.text(report, "file"),
        identity: f.table(report, "identity", "`identity`").map(|f| setup::identity(f, report)),
        settings: each(f.tables(report, "settings", "a setting", SETTINGS_MAX), report, setup::setting),
        without_error_values: f.text(report, "without_error_values"),
        transmission: f.table(report, "transmission", "`transmission`").map(|f| setup::transmission(f, report)),
        on_emergency: setup::reaction(&mut f, "on_emergency", report),
        when_lost: setup::reaction(&mut f, "when_lost", report),
        drive: f.table(report, "drive", "`drive`").map(|f| drive::drive(f, report)),
        analogue: analogue::channels(&mut f, report),
        frames,
        kind,
        modbus,
    };
    f.finish(report);
    raw
}

fn console(mut f: Fields<'_>, report: &mut Report) -> RawConsole {
    let at: Where = f.at.clone();
    let lamps = match f.table(report, "lamps", "`lamps`") {
        None => [None, None, None, None],
        Some(mut f) => {
            let lamps = ["auto", "hand", "manual", "fault"].map(|key| f.text(report, key));
            f.finish(report);
            lamps
        }
    };
    let (estop, estop_pressed) = estop(&mut f, report);
    let raw = RawConsole {
        at,
        start: f.text(report, "start"),
        stop: f.text(report, "stop"),
        auto: f.text(report, "auto"),
        hand: f.text(report, "hand"),
        estop,
        estop_pressed,
        reset: f.text(report, "reset"),
        lamps,
    };
    f.finish(report);
    raw
}

/// An input, on while pressed; or `{ input = …, pressed = "off" }`.
fn estop(f: &mut Fields<'_>, report: &mut Report) -> (Option<Name>, bool) {
    if !f.is_table("estop") {
        return (f.text(report, "estop"), true);
    }
    let Some(mut contact) = f.table(report, "estop", "`estop`") else { return (None, true) };
    let input = contact.required_text(report, "input");
    let pressed = contact.required_word(report, "pressed", &[("on", true), ("off", false)]);
    contact.finish(report);
    (input, pressed.is_none_or(|pressed| pressed.value))
}
