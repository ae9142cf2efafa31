//! The model of the page. Its shape as JSON is what the page's script reads.

use serde::Serialize;

use crate::alarms::AlarmPart;
use crate::cell::CellPart;
use crate::desk::ControlPart;
use crate::lanes::StationLanes;
use crate::operate::OperatePart;
use crate::plan::PlanPart;

/// All that the page shows.
#[derive(Debug, Serialize)]
pub struct ConsolePage {
    /// Title of the line.
    pub title: String,
    /// Whether the description is that of a flexible cell.
    pub is_cell: bool,
    pub mode: ModePart,
    /// What runs with another description than the console, and what to do.
    pub other_descriptions: Vec<String>,
    /// The next step of recovery, where a position is to be confirmed.
    pub next: Option<String>,
    /// In the order of the description.
    pub stations: Vec<StationPart>,
    /// In the order of the description.
    pub lanes: Vec<StationLanes>,
    /// By priority; of one priority an emergency stop first, then those without a time of their own, then those of the cell.
    pub alarms: Vec<AlarmPart>,
    /// None of a line, and while the state of the cell is not received.
    pub cell: Option<CellPart>,
    /// That the state of a cell is not received.
    pub cell_unknown: Option<String>,
    /// What can be commanded, and why the rest cannot.
    pub operate: OperatePart,
    /// The steps back to auto; none in auto and at home, and while they are looked for.
    pub plan: Option<PlanPart>,
    pub control: ControlPart,
}

/// The mode and what keeps it.
#[derive(Debug, Serialize)]
pub struct ModePart {
    /// Whether a state of the coordinator is received. If not, `text` has the time since the last one, and everything after it is empty.
    pub is_known: bool,
    /// Name of the mode; `unknown` where it is not known.
    pub word: &'static str,
    /// The mode with what keeps it, as operators read it.
    pub text: String,
    /// Every station has acknowledged the mode.
    pub is_enabled: Option<bool>,
    /// Stations whose acknowledgement is missing.
    pub waiting_for: Vec<String>,
    /// Stations that are left out of the mode decision.
    pub left_out: Vec<String>,
    /// Stations that were restarted in auto or hand, until the next command.
    pub restarted: Vec<String>,
    /// The last refusal with its age.
    pub refusal: Option<String>,
    /// The command that was refused, in the words in which it was given; empty without a refusal.
    pub refused: String,
    /// The last cycle of the line; none before the first, and while the coordinator is not received.
    pub cycle: Option<CyclePart>,
}

/// A cycle that all stations have completed.
#[derive(Debug, Serialize)]
pub struct CyclePart {
    pub number: i32,
    /// How long it took, in s; the time in which the line stood counts.
    pub duration_s: f64,
}

/// How a station is, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StationHealth {
    /// Its state is not received, or too old.
    Unknown,
    /// In emergency stop.
    EmergencyStop,
    /// It reports a fault.
    Fault,
    /// Left out of the mode decision.
    LeftOut,
    /// Its I/O devices are not received, its position is not known, an operation was stopped before its end, or it was restarted and not
    /// looked at since.
    NotReady,
    /// Its selector stands at manual.
    Manual,
    Ok,
}

/// A station. While it is unknown all but its name, `label`, `health` and `unknown` is empty.
#[derive(Debug, Serialize)]
pub struct StationPart {
    /// As commands need it.
    pub name: String,
    /// Name and title, as people read them.
    pub label: String,
    pub health: StationHealth,
    /// That its state is not received, and for how long.
    pub unknown: Option<String>,
    pub mode: Option<&'static str>,
    pub cycle: Option<i32>,
    /// What it does.
    pub operation: Option<String>,
    /// Whether an operation is in motion.
    pub moves: Option<bool>,
    pub fault: Option<String>,
    /// The selector, an emergency stop of its own.
    pub notes: Vec<String>,
    /// What it waits for.
    pub waits_for: Vec<String>,
}
