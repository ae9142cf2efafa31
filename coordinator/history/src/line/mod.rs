//! History of a line: a fold over its notes, for reports.
//!
//! ```text
//!  of the line:      producing ── in auto, motion enabled, nothing wrong
//!                    start-up ─── from the coordinator's beginning until the line produces, for 30 s at most
//!                    stopped ──── by one cause, from leaving that until coming back to it
//!                    unrecorded ─ no coordinator, or it could not write: until a note of the whole situation
//!  of a station, while the line produces:  busy (an operation in motion), waiting, or neither
//! ```
//!
//! At each moment the line is in one of the four, so they sum to the observed time; and a station to the time in which the
//! line has produced. The cause of a stop is the one that it began with, until there is a graver one (another stop begins) or
//! the line stands at home without any (from there on it is the operator's). What is going on at the end of the notes and is
//! written when it is over, as a motion, is not known yet.

mod report;
mod spans;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::Tick;

use crate::event::{EventKind, HistoryEvent};
use crate::{LineAbout, MotionOutcome, Note};

pub use report::{
    CycleChart, Figure, LineFigures, LineReport, LineStationReport, PlannedRow, ReportParameters, StopTotal, TrendPart,
    WaitTotal,
};
pub use spans::{Spans, Stretch};

/// Most time after a coordinator's beginning in which the line comes up: what still keeps it from producing then is a stop.
const START_UP_MAX: Duration = Duration::from_secs(30);

/// The kinds of causes of a stop, the gravest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StopKind {
    /// Auto is selected, and stations have yet to acknowledge it.
    Starting,
    /// By an operator's command: home, stand-by, hand or manual, and nothing wrong.
    Operator,
    /// A station is not received, or has lost its devices.
    NotHeard,
    /// A station has a fault.
    Alarm,
    EmergencyStop,
}

impl StopKind {
    pub const fn name(self) -> &'static str {
        match self {
            StopKind::Starting => "starting",
            StopKind::Operator => "operator",
            StopKind::NotHeard => "not heard",
            StopKind::Alarm => "alarm",
            StopKind::EmergencyStop => "emergency stop",
        }
    }
}

/// Cause of a stop of a line.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineStopCause {
    pub kind: StopKind,
    /// Station and reason; empty where the kind is enough.
    pub text: String,
}

/// State of a line at a moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineState {
    Unrecorded,
    /// The coordinator has begun, and the line has not produced since.
    StartUp,
    Producing,
    Stopped(LineStopCause),
}

impl LineState {
    /// In words: the state or the kind of its cause, and the cause's text.
    pub fn words(&self) -> (&'static str, &str) {
        match self {
            LineState::Unrecorded => ("not recorded", ""),
            LineState::StartUp => ("start-up", ""),
            LineState::Producing => ("producing", ""),
            LineState::Stopped(of) => (of.kind.name(), &of.text),
        }
    }
}

/// A motion of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineMotion {
    pub operation: usize,
    pub cycle: i32,
    pub from: Tick,
    pub to: Tick,
    pub end: MotionOutcome,
}

/// A station stood and waited.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineWait {
    /// Reason, without the numbers of cycles.
    pub why: String,
    pub from: Tick,
    pub to: Tick,
}

/// A cycle of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineCycle {
    pub number: i32,
    /// When it was heard that it had ended.
    pub ended: Tick,
    /// None if its beginning or its end may have passed unheard.
    pub took: Option<Duration>,
}

/// Notes of a span that could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineGap {
    /// Times of the first and the last of them.
    pub span: Stretch,
    pub lost: u64,
}

/// Notes taken of one station.
#[derive(Clone, Debug, Default)]
pub struct StationTrack {
    pub motions: Vec<LineMotion>,
    pub waits: Vec<LineWait>,
    /// Times of faults.
    pub faults: Vec<Tick>,
}

impl StationTrack {
    /// Waits with their causes. Causes that follow each other without a motion between them are of one wait: the last of them
    /// arrived last, so all of it is charged to that one.
    fn waits_by_last(&self) -> Vec<(Stretch, &str)> {
        // No motion is open during a wait, so one that ended with it passed unseen.
        let moved_at = |at: Tick| {
            let from = self.motions.partition_point(|of| of.to < at);
            self.motions[from..].iter().any(|of| of.to == at)
        };
        let mut all: Vec<(Stretch, &str)> = Vec::with_capacity(self.waits.len());
        for wait in self.waits.iter().rev() {
            let why = match all.last() {
                Some(&((next, _), last)) if next == wait.to && !moved_at(next) => last,
                _ => &wait.why,
            };
            all.push(((wait.from, wait.to), why));
        }
        all
    }
}

/// Present state of the line.
#[derive(Clone, Debug, Default)]
struct Known {
    mode: Option<(String, bool)>,
    faults: BTreeMap<u16, String>,
    unheard: BTreeSet<u16>,
    without_devices: BTreeSet<u16>,
    /// Beginning of the coordinator, while the line comes up.
    starting: Option<Tick>,
}

/// A line, by its notes.
#[derive(Clone, Debug)]
pub struct LineTracking {
    about: LineAbout,
    known: Known,
    /// The state now, and since when.
    now: (Tick, LineState),
    last: Option<Tick>,
    states: Vec<(Stretch, LineState)>,
    cycles: Vec<LineCycle>,
    stations: Vec<StationTrack>,
    gaps: Vec<LineGap>,
}

impl LineTracking {
    /// Before anything has happened.
    pub fn new(about: LineAbout) -> Self {
        LineTracking {
            stations: vec![StationTrack::default(); about.stations.len()],
            about,
            known: Known::default(),
            now: (Tick::ZERO, LineState::Unrecorded),
            last: None,
            states: Vec::new(),
            cycles: Vec::new(),
            gaps: Vec::new(),
        }
    }

    /// The stations, by number.
    pub fn stations(&self) -> &[StationTrack] {
        &self.stations
    }

    /// States of the line, one after the other; the last until `to`.
    pub fn states(&self, to: Tick) -> impl Iterator<Item = (Stretch, &LineState)> {
        let last = ((self.now.0, to), &self.now.1);
        self.states
            .iter()
            .map(|(stretch, state)| (*stretch, state))
            .chain([last].into_iter().filter(move |of| of.0.0 < to))
    }

    /// Takes the next thing that has happened.
    pub fn take(&mut self, event: &HistoryEvent) {
        let (at, EventKind::Note(note)) = (event.at, &event.what) else { return };
        self.end_start_up(at);
        match note {
            Note::Began {} => {
                // The line since the last note is unknown.
                self.change(self.last.unwrap_or(at), LineState::Unrecorded);
                self.known = Known { starting: Some(at), ..Known::default() };
            }
            &Note::Gap { from, to, lost } => {
                let from = from.max(self.last.unwrap_or(from));
                self.change(from, LineState::Unrecorded);
                self.known = Known::default();
                self.gaps.push(LineGap { span: (from, to), lost });
            }
            Note::Mode { name, starts } => self.known.mode = Some((name.clone(), *starts)),
            Note::Station { station, lost } => put(&mut self.known.unheard, *station, *lost),
            Note::Device { station, lost, device: _ } => put(&mut self.known.without_devices, *station, *lost),
            Note::Fault { station, text } => self.fault(*station, text, at),
            &Note::Motion { station, operation, cycle, from, to, end } => {
                let operation = usize::from(operation);
                if let Some(track) = self.stations.get_mut(usize::from(station)) {
                    track.motions.push(LineMotion { operation, cycle, from, to, end });
                }
            }
            Note::Waited { station, why, from, to } => {
                if let Some(track) = self.stations.get_mut(usize::from(*station)) {
                    track.waits.push(LineWait { why: cause(why), from: *from, to: *to });
                }
            }
            &Note::Cycle { number, took_us } => {
                self.cycles.push(LineCycle { number, ended: at, took: took_us.map(Duration::from_micros) });
            }
            Note::EmergencyStop { .. }
            | Note::Planned { .. }
            | Note::Missing { .. }
            | Note::Observed {}
            | Note::Said { .. } => (),
        }
        self.last = Some(at);
        self.settle(at);
    }

    fn fault(&mut self, station: u16, text: &str, at: Tick) {
        if text.is_empty() {
            self.known.faults.remove(&station);
            return;
        }
        self.known.faults.insert(station, text.to_owned());
        if let Some(track) = self.stations.get_mut(usize::from(station)) {
            track.faults.push(at);
        }
    }

    /// The time of a start-up is over before `now`: from then on it is what it is.
    fn end_start_up(&mut self, now: Tick) {
        if let Some(end) = self.known.starting.map(|began| began + START_UP_MAX).filter(|end| *end < now) {
            self.known.starting = None;
            self.settle(end);
        }
    }

    fn settle(&mut self, at: Tick) {
        let mut next = self.state();
        match &next {
            LineState::Stopped(cause) if cause.kind <= StopKind::NotHeard => {
                if self.known.starting.is_some() {
                    next = LineState::StartUp;
                }
            }
            LineState::Unrecorded | LineState::StartUp => {}
            // It produces, or what stops it has happened meanwhile.
            LineState::Producing | LineState::Stopped(_) => self.known.starting = None,
        }
        let is_at_home = self.known.mode.as_ref().is_some_and(|(name, _)| name == "home");
        let goes_on = match (&self.now.1, &next) {
            (LineState::Stopped(is), LineState::Stopped(next)) => {
                let is_operators = is_at_home && next.kind == StopKind::Operator;
                let is_graver = next.kind > is.kind;
                !(is_graver || is_operators && is.kind != StopKind::Operator)
            }
            (is, next) => is == next,
        };
        if !goes_on {
            self.change(at, next);
        }
    }

    fn change(&mut self, at: Tick, to: LineState) {
        let (since, was) = std::mem::replace(&mut self.now, (at, to));
        if since < at && self.last.is_some() {
            self.states.push(((since, at), was));
        }
        // A change that lasted no time is left out.
        if let Some(((from, until), state)) = self.states.last()
            && (*until, state) == (at, &self.now.1)
        {
            self.now.0 = *from;
            self.states.pop();
        }
    }

    /// State of the line by the present notes, whatever it was before.
    fn state(&self) -> LineState {
        let Some((mode, starts)) = &self.known.mode else { return LineState::Unrecorded };
        let name = |station: &u16| {
            let of = self.about.stations.get(usize::from(*station));
            of.map_or_else(|| format!("station {station}"), |of| of.name.clone())
        };
        let stopped = |kind, text| LineState::Stopped(LineStopCause { kind, text });
        if mode == "e-stop" {
            stopped(StopKind::EmergencyStop, String::new())
        } else if let Some((station, text)) = self.known.faults.first_key_value() {
            stopped(StopKind::Alarm, format!("{}: {}", name(station), unmeasured(text)))
        } else if let Some(station) = self.known.unheard.first() {
            stopped(StopKind::NotHeard, format!("{}: no state received", name(station)))
        } else if let Some(station) = self.known.without_devices.first() {
            stopped(StopKind::NotHeard, format!("{}: I/O devices lost", name(station)))
        } else if mode != "auto" {
            stopped(StopKind::Operator, String::new())
        } else if *starts {
            LineState::Producing
        } else {
            stopped(StopKind::Starting, String::new())
        }
    }
}

fn put(set: &mut BTreeSet<u16>, station: u16, is_in: bool) {
    if is_in {
        set.insert(station);
    } else {
        set.remove(&station);
    }
}

/// Reason of waiting, without the number of the cycle, which is another one each time.
fn cause(why: &str) -> String {
    const CYCLE: &str = " (cycle ";
    let (mut text, mut rest) = (String::with_capacity(why.len()), why);
    while let Some((before, behind)) = rest.split_once(CYCLE) {
        text.push_str(before);
        match behind.split_once(')') {
            Some((number, after)) if number.parse::<i32>().is_ok() => rest = after,
            _ => {
                text.push_str(CYCLE);
                rest = behind;
            }
        }
    }
    text + rest
}

/// A fault without the times that were measured as it came: how long nothing was heard, and when it is tried again.
fn unmeasured(fault: &str) -> String {
    ["; tried again in ", " for "].iter().fold(fault.to_owned(), |text, before| without_ms(&text, before))
}

/// The text without each number of milliseconds that follows these words, and without the words.
fn without_ms(text: &str, before: &str) -> String {
    let mut parts = text.split(before);
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let behind = part.trim_start_matches(|c: char| c.is_ascii_digit());
        match behind.strip_prefix(" ms") {
            Some(behind) if behind.len() + 3 < part.len() => kept.push_str(behind),
            _ => kept.extend([before, part]),
        }
    }
    kept
}
