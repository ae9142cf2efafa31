//! What can be commanded now, and why the rest cannot.
//!
//! It follows from the mode alone; a command that the mode takes may be refused for more, in the coordinator's words.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{ButtonId, Line, StationId};
use linewright_msgs::{CellState, LineState, StationState};
use linewright_recovery::PanelButton;
use serde::Serialize;

use crate::hold::{HoldButton, RESUME};
use crate::message::PageAct;
use crate::request::{self, CellRequest};
use crate::texts::coordinator_not_received;

/// Why a hand-mode button does nothing; the mode follows.
pub const HAND_ONLY: &str = "hand-mode buttons act in hand mode only; the mode is";

/// Why a panel does nothing; the mode follows.
pub const PANEL_ONLY: &str = "a panel acts in manual mode only; the mode is";

/// Why resume does nothing; the mode follows.
pub const RESUME_ONLY: &str = "it takes effect in manual only; the mode is";

/// Why resume does nothing in manual.
pub const NOTHING_INCOMPLETE: &str = "no operation is incomplete; go on step by step with advance or return at each station's panel, as `linewright recover` lists it";

const OTHER_DESCRIPTION: &str =
    "the line runs with another description than this console: end the console, and start it with that of the line";

/// The newest states that are fresh.
#[derive(Debug)]
pub struct OperateStates<'s> {
    pub coordinator: Option<&'s LineState>,
    /// In the order of the description.
    pub stations: Vec<Option<&'s StationState>>,
    /// A node runs with another description than this console.
    pub is_other_description: bool,
    /// Of a flexible cell.
    pub cell: Option<&'s CellState>,
}

/// What can be done at a page.
#[derive(Debug, Serialize)]
pub struct OperatePart {
    /// The mode commands.
    pub commands: Vec<OperateButton>,
    /// The hand-mode buttons of the console.
    pub hand: Vec<OperateButton>,
    pub resume: OperateButton,
    /// In the order of the description.
    pub panels: Vec<PanelPart>,
}

/// The panel of a station.
#[derive(Debug, Serialize)]
pub struct PanelPart {
    pub station: String,
    /// Advance and return.
    pub holds: Vec<OperateButton>,
    /// The positions of the selector.
    pub selects: Vec<OperateButton>,
    /// Where the selector stands; none while the station is not received.
    pub is_manual: Option<bool>,
}

/// A button of a page.
#[derive(Clone, Debug, Serialize)]
pub struct OperateButton {
    /// That of its act (see [`PageAct::key`]).
    pub key: String,
    pub label: String,
    /// What the page sends; the number of a press is the page's.
    pub act: PageAct,
    /// Why it would do nothing now; none where it may be given.
    pub why_not: Option<String>,
}

impl OperateButton {
    /// The button of an act.
    pub(crate) fn of(label: &str, act: PageAct, why_not: Option<String>) -> Self {
        OperateButton { key: act.key().unwrap_or_default(), label: label.to_owned(), act, why_not }
    }
}

impl OperatePart {
    pub(crate) fn of(line: &Line, states: &OperateStates<'_>, mode_name: fn(u8) -> &'static str) -> Self {
        let button = |label: &str, act: PageAct| {
            let why = why_not(line, states, &act, mode_name);
            OperateButton::of(label, act, why)
        };
        let command = |command: ModeCommand| {
            let word = command.name().to_owned();
            button(command.name(), PageAct::Command { word, station: None })
        };
        let hold = |label: &str, of: HoldButton| button(label, of.act(line));
        let select = |station: &str, manual: bool| {
            let label = if manual { "selector to manual" } else { "selector to auto" };
            button(label, PageAct::Select { station: station.to_owned(), manual })
        };
        let panel = |id: StationId| {
            let name = line.station(id).name.as_str();
            PanelPart {
                station: name.to_owned(),
                holds: [PanelButton::Advance, PanelButton::Return]
                    .map(|of| hold(of.name(), HoldButton::Panel(id, of)))
                    .into(),
                selects: [true, false].map(|manual| select(name, manual)).into(),
                is_manual: states.stations.get(id.index()).copied().flatten().map(|of| of.selector_manual),
            }
        };
        OperatePart {
            commands: ModeCommand::ALL.map(command).into(),
            hand: line
                .buttons
                .iter()
                .enumerate()
                .map(|(at, name)| hold(name, HoldButton::Hand(ButtonId::at(at))))
                .collect(),
            resume: hold(RESUME, HoldButton::Resume),
            panels: line.station_ids().map(panel).collect(),
        }
    }
}

/// Why an act would do nothing now; none where it may be given.
pub fn why_not(
    line: &Line,
    states: &OperateStates<'_>,
    act: &PageAct,
    mode_name: fn(u8) -> &'static str,
) -> Option<String> {
    if CellRequest::of(act, "").is_some() {
        return request::why_not(states.cell, act);
    }
    // It is the console's own, and of alarms that are shown while nothing is received too.
    if let PageAct::Acknowledge { .. } = act {
        return None;
    }
    let Some(state) = states.coordinator else {
        // The stop is given all the same: a coordinator that is not received may still receive.
        return (!act.is_stop()).then(|| coordinator_not_received(None));
    };
    let other_mode = |needed: u8, id: StationId, why: &str| {
        let mode = states.stations.get(id.index()).copied().flatten().map(|of| of.mode);
        match mode {
            None => Some(format!("no state received from {}", line.station(id).name)),
            Some(mode) => (mode != needed).then(|| format!("{why} {}", mode_name(mode))),
        }
    };
    let is_left_out = |id: StationId| state.left_out.as_slice().contains(&line.station(id).name);
    let is_received = |id: StationId| states.stations.get(id.index()).copied().flatten().is_some();
    // Which stations and operations a button means is that description's.
    if states.is_other_description && matches!(act, PageAct::Press { .. } | PageAct::Select { .. }) {
        return Some(OTHER_DESCRIPTION.to_owned());
    }
    match act {
        PageAct::Command { word, station: None } => {
            let possible = possible(state);
            let is_possible = ModeCommand::parse(word).is_some_and(|command| possible.contains(&command));
            let names: Vec<&str> = possible.iter().map(|command| command.name()).collect();
            (!is_possible).then(|| format!("not possible in {}; possible: {}", mode_name(state.mode), names.join(", ")))
        }
        PageAct::Press { station, button, .. } => match HoldButton::named(line, station.as_deref(), button)? {
            // All that it means something to, or is looked at for it.
            HoldButton::Hand(id) => stations_of(line, &[id])
                .into_iter()
                .filter(|id| !is_left_out(*id))
                .find_map(|id| other_mode(StationState::MODE_HAND, id, HAND_ONLY)),
            HoldButton::Panel(id, _) => other_mode(StationState::MODE_MANUAL, id, PANEL_ONLY),
            HoldButton::Resume if state.mode != StationState::MODE_MANUAL => {
                Some(format!("{RESUME_ONLY} {}", mode_name(state.mode)))
            }
            HoldButton::Resume
                if let Some(id) = line.station_ids().find(|id| !is_left_out(*id) && !is_received(*id)) =>
            {
                Some(format!("no state received from {}", line.station(id).name))
            }
            HoldButton::Resume => {
                let is_any = states.stations.iter().flatten().any(|of| !of.incomplete.is_empty());
                (!is_any).then(|| NOTHING_INCOMPLETE.to_owned())
            }
        },
        _ => None,
    }
}

/// The commands that a mode takes at all. The coordinator may refuse each of them for more.
fn possible(state: &LineState) -> Vec<ModeCommand> {
    use ModeCommand as C;
    let of: &[C] = match state.mode {
        StationState::MODE_ESTOP if state.estop_latched => &[C::Reset, C::EStop],
        StationState::MODE_ESTOP => &[C::Manual, C::EStop],
        StationState::MODE_HOME => &[C::Start, C::Manual, C::EStop],
        StationState::MODE_STANDBY => &[C::Start, C::Stop, C::Auto, C::Hand, C::Manual, C::EStop],
        StationState::MODE_AUTO if state.master_stop => &[C::Start, C::Stop, C::EStop],
        StationState::MODE_AUTO => &[C::Stop, C::EStop],
        StationState::MODE_HAND => &[C::Stop, C::Auto, C::EStop],
        StationState::MODE_MANUAL => &[C::Start, C::Stop, C::Auto, C::Hand, C::EStop],
        // Of another version: the coordinator decides.
        _ => &C::ALL,
    };
    of.to_vec()
}

/// The stations that one of these hand-mode buttons means anything to; all where it is none.
pub fn stations_of(line: &Line, buttons: &[ButtonId]) -> Vec<StationId> {
    let means = |id: &StationId| {
        line.station(*id).operations.iter().any(|operation| {
            let hand = operation.hand;
            [Some(hand.forward()), hand.back(), hand.next()].into_iter().flatten().any(|of| buttons.contains(&of))
        })
    };
    let meant: Vec<StationId> = line.station_ids().filter(means).collect();
    if meant.is_empty() { line.station_ids().collect() } else { meant }
}
