//! The live view of a flexible cell: alarms with their answers, what is left out and why, how recovery goes on, stations,
//! parts and production orders.
//!
//! Pure: the newest state in, lines of text out. What does not fit the screen is counted where there is a line for it,
//! and what needs an operator comes first.

use linewright_console_view::{
    OWN_EMERGENCY_STOP, ReasonsByResource, answers, due, is_over, left_out, of_order, of_part, seconds, span, waits,
};
use linewright_msgs::{ActivityState, AlarmState, CellState, PartState, ProductionState, StationState};
use serde::Serialize;

use super::wrapped;
use crate::cell::CellJson;

/// Lines under a head; each entry is wrapped already.
struct Section {
    head: String,
    entries: Vec<Vec<String>>,
}

/// Picture of a cell, in at most `height` lines of `width` characters.
pub fn picture<'s>(
    cell: &CellState,
    out: &ReasonsByResource,
    stations: impl Iterator<Item = (&'s str, Option<&'s StationState>)>,
    is_line_stopped: bool,
    now: f64,
    (width, height): (usize, usize),
) -> Vec<String> {
    let entry = |text: String, indent: usize| wrapped(&format!("  {text}"), indent, width);
    let mut sections = Vec::new();
    let mut add = |head: String, entries: Vec<Vec<String>>| {
        if !entries.is_empty() || !head.ends_with(':') {
            sections.push(Section { head, entries });
        }
    };
    add("alarms:".to_owned(), cell.alarms.as_slice().iter().map(|of| entry(alarm(of), 4)).collect());
    let down = cell.down.as_slice().iter().map(|name| entry(left_out(cell, name, out.get(name)), 4));
    add("out of service:".to_owned(), down.collect());
    add("stations:".to_owned(), stations.map(|(label, state)| station(label, state, is_line_stopped, width)).collect());
    add("in progress:".to_owned(), cell.activities.as_slice().iter().map(|of| entry(activity(of, now), 4)).collect());
    let starts = if cell.starting { "" } else { "; nothing starts" };
    let parts = format!("parts: {} inside, {} have left{starts}", cell.parts_inside, cell.parts_left);
    add(parts, cell.parts.as_slice().iter().map(|of| entry(part(cell, of, now), 4)).collect());
    let open = cell.orders.as_slice().iter().filter(|order| !is_over(order));
    let orders = format!("orders: {} not over", cell.orders_open);
    add(orders, open.map(|of| entry(order(of, now), 4)).collect());
    fitted(&sections, height)
}

/// Every head, and as many whole entries as there is room for; the rest is counted.
fn fitted(sections: &[Section], height: usize) -> Vec<String> {
    let mut room = height.saturating_sub(sections.len());
    let mut lines = Vec::new();
    for section in sections {
        lines.push(section.head.clone());
        for (number, entry) in section.entries.iter().enumerate() {
            let rest: usize = section.entries[number..].iter().map(Vec::len).sum();
            // Unless all of the rest fits, a line is kept for how many are not shown.
            if rest > room && entry.len() + 1 > room {
                if room > 0 {
                    room -= 1;
                    lines.push(format!("  and {} more", section.entries.len() - number));
                }
                break;
            }
            room -= entry.len();
            lines.extend(entry.iter().cloned());
        }
    }
    lines.truncate(height);
    lines
}

fn alarm(of: &AlarmState) -> String {
    format!("{}: {} Answers: {}", of.id, of.text, answers(of))
}

fn station(label: &str, state: Option<&StationState>, is_line_stopped: bool, width: usize) -> Vec<String> {
    let label = format!("  {label:12}");
    let Some(state) = state else { return wrapped(&format!("{label} no state received"), 15, width) };
    let mut lines = wrapped(&format!("{label} {}", state.operation), 15, width);
    let mut add = |text: String| lines.extend(wrapped(&format!("{:14} {text}", ""), 15, width));
    if !state.fault.is_empty() {
        add(format!("FAULT {}", state.fault));
    }
    if state.mode == StationState::MODE_ESTOP && !is_line_stopped {
        add(OWN_EMERGENCY_STOP.to_owned());
    }
    for reason in waits(state) {
        add(format!("waits for {reason}"));
    }
    lines
}

fn activity(of: &ActivityState, now: f64) -> String {
    let part = if of.part == 0 { String::new() } else { format!(" of part {}", of.part) };
    let text = if of.text.is_empty() { String::new() } else { format!(": {}", of.text) };
    format!("`{}`{part} for {}{text}", of.name, span(now - seconds(&of.began)))
}

fn part(cell: &CellState, of: &PartState, now: f64) -> String {
    let stage = if of.stage.is_empty() { String::new() } else { format!(" {}", of.stage) };
    let order = of_part(cell, of).map(|order| format!(" (order {order})")).unwrap_or_default();
    format!("part {}{stage}{order}: {}, for {}", of.id, of.place, span(now - seconds(&of.since)))
}

fn order(of: &ProductionState, now: f64) -> String {
    let due = due(of, now).map(|due| format!(", {due}")).unwrap_or_default();
    format!("{}: {}{due}", of.name, of_order(of))
}

/// The cell in `watch --json`.
#[derive(Serialize)]
pub struct CellWatchJson {
    #[serde(flatten)]
    cell: CellJson,
    parts: Vec<JsonPart>,
    in_progress: Vec<JsonActivity>,
    out_of_service: Vec<JsonOutOfService>,
}

#[derive(Serialize)]
struct JsonPart {
    part: u64,
    stage: String,
    place: String,
    /// Since when it is there, in s since 1970.
    since_s: f64,
    /// Number of its production order; null if it counts to none.
    order: Option<u64>,
}

#[derive(Serialize)]
struct JsonActivity {
    id: u64,
    name: String,
    part: Option<u64>,
    began_s: f64,
    /// False when it has failed.
    running: bool,
    text: String,
}

#[derive(Serialize)]
struct JsonOutOfService {
    resource: String,
    reasons: Vec<String>,
}

impl CellWatchJson {
    pub fn of(state: &CellState, out: &ReasonsByResource) -> Self {
        let some = |number: u64| (number != 0).then_some(number);
        let part = |of: &PartState| JsonPart {
            part: of.id,
            stage: of.stage.clone(),
            place: of.place.clone(),
            since_s: seconds(&of.since),
            order: some(of.order),
        };
        let activity = |of: &ActivityState| JsonActivity {
            id: of.id,
            name: of.name.clone(),
            part: some(of.part),
            began_s: seconds(&of.began),
            running: of.running,
            text: of.text.clone(),
        };
        let down = |name: &String| JsonOutOfService {
            resource: name.clone(),
            reasons: out.get(name).cloned().unwrap_or_default(),
        };
        CellWatchJson {
            cell: CellJson::of(state),
            parts: state.parts.as_slice().iter().map(part).collect(),
            in_progress: state.activities.as_slice().iter().map(activity).collect(),
            out_of_service: state.down.as_slice().iter().map(down).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use linewright_msgs::{Bounded, Time};
    use linewright_station_logic::StationWait;

    use super::*;

    const NOW: f64 = 10_000.0;
    const ALARM: &str = "R came to M1 without part 7. Put the part back into slot 1 of ST. (`load M1`: robot: motion not \
                         complete in time, after 8.2 s; robot: stopped between two rests, m1: order not begun)";
    const OUT: &str = "M2 out of service for 120 s: alarm raised by hand: smoke";

    fn at(ago: i32) -> Time {
        Time { sec: 10_000 - ago, nanosec: 0 }
    }

    fn cell() -> CellState {
        let part =
            |id, place: &str| PartState { id, stage: "A.turn".into(), place: place.into(), since: at(130), order: 1 };
        let order = |name: &str, due, ended| ProductionState {
            id: if name == "rush" { 1 } else { 0 },
            name: name.into(),
            product: "A".into(),
            quantity: 5,
            done: 2,
            text: "in work".into(),
            due,
            ended,
            ..ProductionState::default()
        };
        let failed = ActivityState {
            id: 3,
            name: "load M1".into(),
            part: 7,
            began: at(12),
            running: false,
            text: "failed, waits for an answer to alarm 4".into(),
            ..ActivityState::default()
        };
        let alarm = AlarmState {
            id: 4,
            raised: at(4),
            text: ALARM.into(),
            answers: vec!["in-store".into(), "scrap".into()],
            ..AlarmState::default()
        };
        CellState {
            starting: true,
            parts_inside: 12,
            parts_left: 3,
            orders_open: 2,
            alarms: Bounded::new(vec![alarm]).expect("one"),
            down: Bounded::new(vec!["M2".into(), "M3".into()]).expect("two"),
            activities: Bounded::new(vec![failed]).expect("one"),
            parts: Bounded::new((1..=12).map(|id| part(id, "in M1, loaded")).collect()).expect("twelve"),
            orders: Bounded::new(vec![
                order("rush", at(75), Time::default()),
                order("monday", at(-7300), Time::default()),
                order("sunday", Time::default(), at(9)),
            ])
            .expect("three"),
            ..CellState::default()
        }
    }

    fn drawn(size: (usize, usize)) -> Vec<String> {
        let robot = StationState {
            mode: StationState::MODE_ESTOP,
            operation: "stopped in grasp for m1".into(),
            fault: "grasp for m1: watchdog: motion not complete in time".into(),
            blocked_by: vec!["recovery of grasp for m1 in manual".into()],
            ..StationState::default()
        };
        let idle = StationState {
            operation: "at rest".into(),
            blocked_by: vec![StationWait::TaskOrder.text()],
            ..StationState::default()
        };
        let out = BTreeMap::from([("M2".to_owned(), vec![OUT.to_owned()])]);
        let stations = [("robot", Some(&robot)), ("m1", Some(&idle)), ("m2", None)];
        picture(&cell(), &out, stations.into_iter(), false, NOW, size)
    }

    fn whole(lines: &[String]) -> String {
        lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn what_needs_an_answer_is_whole_at_sixty_columns_and_the_rest_is_counted() {
        let lines = drawn((60, 24));
        assert!(lines.len() <= 24 && lines.iter().all(|line| line.chars().count() <= 60), "{lines:#?}");
        let whole = whole(&lines);
        for part in [
            ALARM,
            "Answers: in-store, scrap",
            OUT,
            "M3 stations:",
            "FAULT grasp for m1: watchdog: motion not complete in time",
            "emergency stop of its own, not reset; give `linewright resource … reset`, then manual",
            "waits for recovery of grasp for m1 in manual",
            "parts: 12 inside, 3 have left",
            "orders: 2 not over",
        ] {
            assert!(whole.contains(part), "{part}: {lines:#?}");
        }
        assert!(whole.contains(" more"), "{lines:#?}");
        assert!(!whole.contains("a task order"), "a station that waits for its next order waits for nothing");
    }

    /// Sentences stay sentences, and the text of an alarm is shown once.
    #[test]
    fn why_a_resource_is_left_out_repeats_no_alarm() {
        let reasons = [
            "M1 out of service for 9 s: a rule.",
            "m1: in emergency stop",
            &format!("alarm 4: {ALARM}"),
            "alarm 45: x",
        ];
        let reasons = reasons.map(str::to_owned).to_vec();
        assert_eq!(
            left_out(&cell(), "M1", Some(&reasons)),
            "M1 out of service for 9 s: a rule. m1: in emergency stop. alarm 4. alarm 45: x."
        );
    }

    #[test]
    fn with_room_everything_is_shown() {
        let lines = drawn((100, usize::MAX));
        let whole = whole(&lines);
        for part in [
            "`load M1` of part 7 for 12 s: failed, waits for an answer to alarm 4",
            "part 12 A.turn (order rush): in M1, loaded, for 2 min 10 s",
            "rush: 2 of 5 A, in work, overdue for 1 min 15 s",
            "monday: 2 of 5 A, in work, due in 2 h 1 min",
            "m2           no state received",
        ] {
            assert!(whole.contains(part), "{part}: {lines:#?}");
        }
        assert!(!whole.contains("sunday") && !whole.contains(" more"), "{lines:#?}");
    }

    /// However small the screen: never more lines than it has.
    #[test]
    fn a_picture_is_never_higher_than_its_screen() {
        let all = drawn((60, usize::MAX)).len();
        for height in 0..=all + 2 {
            let lines = drawn((60, height));
            assert!(lines.len() <= height.min(all), "{height}: {lines:#?}");
        }
        assert_eq!(drawn((60, all)), drawn((60, usize::MAX)));
    }

    #[test]
    fn the_json_has_parts_orders_and_reasons() {
        let out = BTreeMap::from([("M2".to_owned(), vec![OUT.to_owned()])]);
        let json = serde_json::to_value(CellWatchJson::of(&cell(), &out)).expect("JSON");
        assert_eq!((&json["parts"][6]["part"], &json["parts"][6]["place"]), (&7.into(), &"in M1, loaded".into()));
        assert_eq!(json["out_of_service"][0]["reasons"][0], OUT);
        assert_eq!(json["out_of_service"][1]["reasons"], serde_json::json!([]));
        assert_eq!(json["alarms"][0]["answers"][1], "scrap");
        assert_eq!((&json["in_progress"][0]["running"], &json["orders"][0]["name"]), (&false.into(), &"rush".into()));
    }
}
