//! Alarms of a line and of its cell, as one list.
//!
//! The messages have no priority. It follows from what an alarm is about: 1 stops the line or a station, 2 somebody has to see to, 3 is
//! to be known.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_logic::left_out;
use linewright_msgs::{AlarmState, CellState, LineState, StationState};
use serde::Serialize;

use crate::answers::{AnswerJson, permitted};
use crate::bounds;
use crate::texts::{seconds, span};

/// Priority of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlarmPriority {
    /// The line or a station stands because of it.
    High = 1,
    /// Somebody has to see to it.
    Medium = 2,
    /// To be known.
    Low = 3,
}

/// An alarm. Of those that are none of a cell, everything after `age` is empty.
#[derive(Debug, Serialize)]
pub struct AlarmPart {
    /// Tells it from every other alarm of the page.
    pub key: String,
    /// `line`, `cell` or a station, by name and title.
    pub source: String,
    /// 1 to 3.
    pub priority: u8,
    /// The priority as text.
    pub priority_text: &'static str,
    /// Number of the alarm on the page, by which it is acknowledged.
    pub shown: u64,
    /// State of the alarm as text: each is active as long as its cause is reported, whether it is acknowledged or not.
    pub state: &'static str,
    /// That it is acknowledged; none before.
    pub acknowledged: Option<AcknowledgePart>,
    /// What has happened, and what to do.
    pub text: String,
    /// Time since it was raised, or `shown for` and the time since the console has shown it first.
    pub age: String,
    /// Its number in the cell.
    pub number: Option<u64>,
    /// What can be answered.
    pub answers: Vec<AnswerJson>,
    /// Stations that are to be led to a rest by hand before the answer.
    pub lead: Vec<String>,
    /// Those of them that are to be reset before they are led.
    pub reset: Vec<String>,
    /// Stations that still have an order of what has failed.
    pub at_order: Vec<String>,
    /// Which way they are led; none where no station is.
    pub lead_to: Option<&'static str>,
    /// Why that way; empty where either will do.
    pub lead_because: String,
    /// Station that is to be brought to another rest before the answer, and that rest.
    pub bring: Option<[String; 2]>,
}

/// That an alarm was seen by a person.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AcknowledgePart {
    /// The operator who has acknowledged it, with the address of the page.
    pub by: String,
    pub note: String,
    /// Time since then.
    pub age: String,
}

impl AlarmPriority {
    /// The priority as text.
    pub const fn text(self) -> &'static str {
        match self {
            AlarmPriority::High => "high",
            AlarmPriority::Medium => "medium",
            AlarmPriority::Low => "low",
        }
    }
}

/// An alarm that is none of a cell, before its age is known.
pub(crate) struct LineAlarm {
    pub source: String,
    pub what: &'static str,
    pub priority: AlarmPriority,
    pub text: String,
}

impl LineAlarm {
    pub fn new(source: &str, what: &'static str, priority: AlarmPriority, text: &str) -> Self {
        LineAlarm { source: source.to_owned(), what, priority, text: bounds::text(text) }
    }
}

/// Alarms that are remembered while they are not shown, less those shown.
const KNOWN_MAX: usize = 1000;

/// What alarms are about that a station reports, and that something is not received.
pub(crate) const FAULT: &str = "fault";
pub(crate) const NOT_RECEIVED: &str = "not received";

/// What alarms of an emergency stop are about.
pub(crate) const EMERGENCY_STOP: &str = "emergency stop";

fn plain(key: String, source: String, priority: AlarmPriority, text: String, age: String) -> AlarmPart {
    AlarmPart {
        key,
        source,
        priority: priority as u8,
        priority_text: priority.text(),
        shown: 0,
        state: ACTIVE,
        acknowledged: None,
        text,
        age,
        number: None,
        answers: Vec::new(),
        lead: Vec::new(),
        reset: Vec::new(),
        at_order: Vec::new(),
        lead_to: None,
        lead_because: String::new(),
        bring: None,
    }
}

const ACTIVE: &str = "active, not acknowledged";
const ACKNOWLEDGED: &str = "active, acknowledged";

/// An alarm over all pages on which it is shown.
#[derive(Clone, Debug)]
struct KnownAlarm {
    shown: u64,
    /// When the console has first received it.
    since: Duration,
    /// The operator, the note, and when.
    acknowledged: Option<(String, String, Duration)>,
    /// Its text as shown last.
    text: String,
}

/// The alarms that are shown: since when, and which are acknowledged.
///
/// An alarm that is gone is forgotten with its acknowledgement: if it comes again it is another one. Alarms of a node that is not
/// received are kept, with their acknowledgements.
#[derive(Debug, Default)]
pub(crate) struct AlarmBook {
    known: BTreeMap<String, KnownAlarm>,
    /// Of the alarm shown last.
    last: u64,
}

impl AlarmBook {
    /// Alarms without a time of their own with their ages, by priority, of one priority emergency stops first and then the newest.
    pub fn aged(&mut self, now: Duration, alarms: Vec<LineAlarm>) -> Vec<AlarmPart> {
        let rank = |alarm: &LineAlarm| (alarm.priority, alarm.what != EMERGENCY_STOP);
        let mut all: Vec<_> = alarms
            .into_iter()
            .map(|alarm| {
                // Another fault of the same station is another alarm.
                let of = if alarm.what == FAULT { alarm.text.as_str() } else { "" };
                let key = format!("{} {} {of}", alarm.source, alarm.what);
                let since = self.known(now, &key).since;
                let age = format!("shown for {}", span(now.saturating_sub(since).as_secs_f64()));
                (rank(&alarm), since, plain(key, alarm.source, alarm.priority, alarm.text, age))
            })
            .collect();
        all.sort_by_key(|(rank, since, _)| (*rank, std::cmp::Reverse(*since)));
        all.into_iter().map(|(.., alarm)| alarm).collect()
    }

    fn known(&mut self, now: Duration, key: &str) -> &mut KnownAlarm {
        let last = &mut self.last;
        self.known.entry(key.to_owned()).or_insert_with(|| {
            *last += 1;
            KnownAlarm { shown: *last, since: now, acknowledged: None, text: String::new() }
        })
    }

    /// Puts number and acknowledgement to the alarms of a page, all that there are. `silent`: sources that are not received.
    pub fn finish(&mut self, now: Duration, alarms: &mut [AlarmPart], silent: &[&str]) {
        for alarm in alarms.iter_mut() {
            let known = self.known(now, &alarm.key);
            // Another text about the whole line is another cause, which no person has seen.
            if known.text != alarm.text {
                known.acknowledged.take_if(|_| alarm.source == "line");
                known.text.clone_from(&alarm.text);
            }
            let known = known.clone();
            alarm.shown = known.shown;
            alarm.acknowledged = known.acknowledged.map(|(by, note, at)| AcknowledgePart {
                by,
                note,
                age: span(now.saturating_sub(at).as_secs_f64()),
            });
            alarm.state = if alarm.acknowledged.is_some() { ACKNOWLEDGED } else { ACTIVE };
        }
        let is_shown = |key: &str| alarms.iter().any(|alarm| alarm.key == key);
        let is_silent =
            |key: &str| silent.iter().any(|of| key.strip_prefix(of).is_some_and(|what| what.starts_with(' ')));
        let mut room = KNOWN_MAX;
        self.known.retain(|key, _| {
            let is_kept = is_shown(key) || (room > 0 && is_silent(key));
            room -= usize::from(is_kept && room > 0);
            is_kept
        });
    }

    /// Acknowledges the alarm with this number of the page. Gives its key.
    ///
    /// # Errors
    /// When there is none any more.
    pub fn acknowledge(&mut self, now: Duration, shown: u64, by: String, note: String) -> Result<&str, String> {
        let known = self.known.iter_mut().find(|(_, known)| known.shown == shown);
        let (key, known) = known.ok_or_else(|| "not acknowledged: the alarm is over".to_owned())?;
        known.acknowledged = Some((by, note, now));
        Ok(key)
    }
}

/// What the coordinator reports.
pub(crate) fn of_line(state: &LineState) -> Vec<LineAlarm> {
    let alarm = |what, priority, text: &str| LineAlarm::new("line", what, priority, text);
    let mut alarms = Vec::new();
    if state.mode == StationState::MODE_ESTOP || state.estop_latched {
        alarms.push(alarm(EMERGENCY_STOP, AlarmPriority::High, &state.text));
    }
    if !state.obstacles.is_empty() {
        alarms.push(alarm("obstacles", AlarmPriority::High, &state.obstacles.join("; ")));
    }
    if let Some(text) = waits_for_a_person(state) {
        alarms.push(alarm("stands by", AlarmPriority::Medium, &text));
    }
    if state.console_lost {
        let text = "the devices of the line's console are not operational, or were not received yet";
        alarms.push(alarm("console devices", AlarmPriority::Medium, text));
    }
    if !state.left_out.is_empty() {
        let text = format!("left out of the mode decision: {}", state.left_out.join(", "));
        alarms.push(alarm("left out", AlarmPriority::Low, &text));
    }
    alarms
}

/// Why a line stands by until a person does something: a station or the coordinator was started anew, memory is lost, something stands
/// half-way. Acknowledgements that are missing come by themselves, and stations that are left out are an alarm of their own.
fn waits_for_a_person(state: &LineState) -> Option<String> {
    if state.mode != StationState::MODE_STANDBY || !state.waiting_for.is_empty() {
        return None;
    }
    let text = state.text.replacen(&left_out(&state.left_out), "", 1);
    let (_, why) = text.split_once([',', ':', '.'])?;
    Some(format!("the line stands by:{why}; the steps back: Operate, or `linewright recover`"))
}

/// What the cell reports, the newest first. `now`: the time by the clock of its coordinator, in s since 1970.
pub(crate) fn of_cell(state: &CellState, now: f64) -> Vec<AlarmPart> {
    let mut alarms: Vec<&AlarmState> = state.alarms.as_slice().iter().collect();
    alarms.sort_by(|a, b| seconds(&b.raised).total_cmp(&seconds(&a.raised)).then(b.id.cmp(&a.id)));
    alarms.into_iter().map(|of| of_cell_one(of, now)).collect()
}

fn of_cell_one(of: &AlarmState, now: f64) -> AlarmPart {
    let bounded = |mut answer: AnswerJson| {
        answer.bound();
        answer
    };
    let age = span(now - seconds(&of.raised));
    // With its time: a cell that was started anew without its log numbers its alarms from 1 again.
    let key = format!("cell {} {}", of.id, seconds(&of.raised));
    AlarmPart {
        number: Some(of.id),
        answers: permitted(of).iter().take(bounds::LIST_MAX).map(AnswerJson::from).map(bounded).collect(),
        lead: bounds::texts(&*of.lead),
        reset: bounds::texts(&*of.reset),
        at_order: bounds::texts(&*of.at_order),
        lead_to: (!of.lead.is_empty()).then(|| way(of.lead_to)),
        lead_because: bounds::text(&of.lead_because),
        bring: (!of.bring.is_empty()).then(|| [bounds::text(&of.bring), bounds::text(&of.to_rest)]),
        ..plain(key, "cell".to_owned(), AlarmPriority::Medium, bounds::text(&of.text), age)
    }
}

/// A way that is not known is named so.
fn way(code: u8) -> &'static str {
    match code {
        AlarmState::LEAD_EITHER => "on or back, all of them alike",
        AlarmState::LEAD_ON => "on to the end of the task",
        AlarmState::LEAD_BACK => "back to where the task began",
        _ => "a way that this console does not know",
    }
}
