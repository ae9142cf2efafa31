//! What is known of a line when a plan is made.

use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, OpId, StationId};
use linewright_station_logic::{StationReport, StopCause};

use crate::read::ModeRead;

/// State of the console's devices, as far as the mode's text says it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConsoleSituation {
    #[default]
    Heard,
    /// Its emergency stop button is pressed.
    ButtonPressed,
    /// Its devices are not operational, or were never heard.
    Lost,
}

/// An alarm of a cell that waits for its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StandingAlarm {
    pub id: u64,
    /// What has happened, and what to do.
    pub text: String,
    /// What can be answered, when it is done.
    pub answers: Vec<String>,
}

impl StandingAlarm {
    const LEAD: &str = "lead ";
    const TO_A_REST: &str = " to a rest in manual.";

    /// The stations that it asks to be led to a rest by hand, before it can be answered.
    pub fn asks_to_lead(&self, line: &Line) -> Vec<StationId> {
        let before = self.text.split_once(Self::TO_A_REST).map_or("", |(before, _)| before);
        let names = before.rfind(Self::LEAD).map_or("", |at| &before[at + Self::LEAD.len()..]);
        names.split(" and ").filter_map(|name| line.station_named(name)).collect()
    }

    /// What it asks for before anything is led, as its text has it: the reset of a station that is in emergency stop by itself.
    pub fn asks_before(&self) -> Option<&str> {
        let (before, _) = self.text.split_once(", then lead ")?;
        before.rfind("First ").map(|at| &before[at + "First ".len()..])
    }
}

/// A situation of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSituation {
    pub mode: ControlMode,
    /// Every station has acknowledged it.
    pub enabled: bool,
    /// Master stop was given: in auto, the line halts at home.
    pub is_stopping: bool,
    /// The emergency stop has been reset.
    pub is_reset: bool,
    pub console: ConsoleSituation,
    /// Stations that were restarted and have not been looked at since.
    pub restarted: Vec<StationId>,
    /// Task-driven stations that the mode does not depend on: an alarm of their cell asks about them, or they are out of service.
    pub left_out: Vec<StationId>,
    pub alarms: Vec<StandingAlarm>,
    /// What else keeps every mode from being given, in words: a second coordinator, a journal that cannot be written.
    pub obstacles: Vec<String>,
    /// By station; none where it is not heard.
    pub stations: Vec<Option<StationReport>>,
}

impl LineSituation {
    /// A situation in which nothing is amiss but what the stations report.
    pub fn of(line: &Line, mode: ControlMode, stations: Vec<Option<StationReport>>) -> Self {
        debug_assert_eq!(stations.len(), line.stations.len());
        LineSituation {
            mode,
            enabled: true,
            is_stopping: false,
            is_reset: false,
            console: ConsoleSituation::Heard,
            restarted: Vec::new(),
            left_out: Vec::new(),
            alarms: Vec::new(),
            obstacles: Vec::new(),
            stations,
        }
    }

    /// A situation as the state of the line and those of the stations show it: the mode, whether every station has
    /// acknowledged it, and its text.
    pub fn read(
        line: &Line,
        mode: ControlMode,
        enabled: bool,
        text: &str,
        stations: Vec<Option<StationReport>>,
    ) -> Self {
        let read = ModeRead::of(line, text);
        let console = match (read.without_console, read.is_pressed) {
            (true, _) => ConsoleSituation::Lost,
            (false, true) => ConsoleSituation::ButtonPressed,
            (false, false) => ConsoleSituation::Heard,
        };
        let ModeRead { is_stopping, is_reset, restarted, left_out, obstacles, .. } = read;
        LineSituation {
            enabled,
            is_stopping,
            is_reset,
            console,
            restarted,
            left_out,
            obstacles,
            ..LineSituation::of(line, mode, stations)
        }
    }

    /// The stations that alarms ask to be led to a rest by hand and that are not there.
    pub(crate) fn to_be_led(&self, line: &Line) -> Vec<StationId> {
        let asked: Vec<StationId> = self.alarms.iter().flat_map(|alarm| alarm.asks_to_lead(line)).collect();
        let is_away =
            |report: &StationReport| !report.at_home || !report.incomplete.is_empty() || report.position_lost.is_some();
        let is_to_be = |id: &StationId| {
            asked.contains(id) && self.stations.get(id.index()).and_then(Option::as_ref).is_some_and(is_away)
        };
        line.station_ids().filter(is_to_be).collect()
    }
}

/// The part of a report that its message has, for simulations whose consoles receive none: no cause of a stop, no place of a doubt, and
/// no order.
pub fn as_received(report: StationReport) -> StationReport {
    StationReport {
        position_lost: report.position_lost.map(|_| (OpId(0), InputId(0))),
        incomplete: report.incomplete.iter().map(|&(op, _)| (op, StopCause::Signal)).collect(),
        order: None,
        ..report
    }
}
