//! Texts about states that the terminal view and the page show alike.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_msgs::{CellState, LineState, PartState, ProductionState, StationState, Time};
use linewright_station_logic::StationWait;

/// Why resources are left out, by their names, as far as the coordinator has answered.
pub type ReasonsByResource = BTreeMap<String, Vec<String>>;

/// Of a station whose selector keeps it in manual.
pub const SELECTOR_AT_MANUAL: &str = "selector at manual";

/// Of a station of a cell that alone is in emergency stop.
pub const OWN_EMERGENCY_STOP: &str =
    "emergency stop of its own, not reset; give `linewright resource … reset`, then manual";

/// The last refusal, with its age; none where it is over.
pub fn refusal(state: &LineState) -> Option<String> {
    let age = Duration::from_millis(state.refusal_age_ms.into()).as_secs();
    (!state.refusal.is_empty()).then(|| format!("last refusal, {age} s ago: {}", state.refusal))
}

/// That no state of the coordinator is received, and for how long where there was one.
pub fn coordinator_not_received(unheard: Option<Duration>) -> String {
    format!("no state received from the coordinator{}", for_how_long(unheard))
}

/// The same of a station.
pub fn station_not_received(unheard: Option<Duration>) -> String {
    format!("no state received{}", for_how_long(unheard))
}

fn for_how_long(unheard: Option<Duration>) -> String {
    unheard.map_or_else(String::new, |unheard| format!(" for {} s", unheard.as_secs()))
}

/// What a station of a cell waits for, without its next order, which is no obstacle.
pub fn waits(state: &StationState) -> impl Iterator<Item = &String> {
    let idle = StationWait::TaskOrder.text();
    state.blocked_by.iter().filter(move |reason| **reason != idle)
}

/// The coordinator's answer for a resource, sentences of which the first begins with its name. Of alarms, which are shown beside it,
/// the number.
pub fn left_out(cell: &CellState, name: &str, reasons: Option<&Vec<String>>) -> String {
    let Some(reasons) = reasons else { return name.to_owned() };
    let shown = cell.alarms.as_slice().iter().map(|of| format!("alarm {}", of.id)).collect::<Vec<_>>();
    let sentence = |reason: &String| {
        let alarm =
            shown.iter().find(|alarm| reason.strip_prefix(&***alarm).is_some_and(|rest| rest.starts_with(": ")));
        let text = alarm.unwrap_or(reason).trim_end_matches('.');
        format!("{text}.")
    };
    reasons.iter().map(sentence).collect::<Vec<_>>().join(" ")
}

/// Whether a production order is over.
pub fn is_over(order: &ProductionState) -> bool {
    order.ended.sec != 0 || order.ended.nanosec != 0
}

/// When an order is due, at the time `now` in s of the clock of its coordinator; none where it is never due.
pub fn due(of: &ProductionState, now: f64) -> Option<String> {
    match seconds(&of.due) {
        0.0 => None,
        due if due >= now => Some(format!("due in {}", span(due - now))),
        due => Some(format!("overdue for {}", span(now - due))),
    }
}

/// How far an order is, in a sentence.
pub fn of_order(of: &ProductionState) -> String {
    let lost = if of.lost > 0 { format!(", {} lost", of.lost) } else { String::new() };
    format!("{} of {} {}, {}{lost}", of.done, of.quantity, of.product, of.text)
}

/// The name of the order that a part counts to; none for a part without one, and where the order is not received.
pub fn of_part<'c>(cell: &'c CellState, part: &PartState) -> Option<&'c str> {
    let order = cell.orders.as_slice().iter().find(|order| part.order != 0 && order.id == part.order);
    order.map(|order| order.name.as_str())
}

/// A stamp in s since 1970, of the clock that has made it.
pub fn seconds(time: &Time) -> f64 {
    f64::from(time.sec) + f64::from(time.nanosec) * 1e-9
}

/// A time that goes by, in the two largest units.
pub fn span(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..86_400 => format!("{} h {} min", whole / 3600, whole / 60 % 60),
        _ => format!("{} d {} h", whole / 86_400, whole / 3600 % 24),
    }
}
