//! The page of a line, from the newest state of each node.

use std::borrow::Cow;
use std::time::Duration;

use linewright_line::{Line, StationId};
use linewright_msgs::{CellState, CycleTime, LineState, StationState};

use crate::aged::{Aged, CELL_FRESH, state_fresh};
use crate::alarms::{AlarmBook, AlarmPriority, FAULT, LineAlarm, NOT_RECEIVED, of_cell, of_line};
use crate::bounds;
use crate::cell::{CellChoices, CellPart, now_of};
use crate::desk::ControlPart;
use crate::lanes::LaneRecorder;
use crate::next::{NextStep, asks_to_confirm};
use crate::operate::{OperatePart, OperateStates, why_not};
use crate::page::{ConsolePage, CyclePart, ModePart, StationHealth, StationPart};
use crate::plan::PlanPart;
use crate::texts::{
    OWN_EMERGENCY_STOP, ReasonsByResource, SELECTOR_AT_MANUAL, coordinator_not_received, refusal, station_not_received,
    waits,
};

/// What is received of a line at one time. None: never.
#[derive(Debug)]
pub struct ConsoleInputs<'s> {
    /// Time since the begin of the console; never less than before.
    pub now: Duration,
    pub line: Option<Aged<'s, LineState>>,
    /// In the order of the description.
    pub stations: Vec<Option<Aged<'s, StationState>>>,
    /// Of a flexible cell.
    pub cell: Option<Aged<'s, CellState>>,
    pub cycle: Option<&'s CycleTime>,
    /// The next step of recovery.
    pub next: Option<&'s NextStep>,
    /// Why resources of a cell are left out.
    pub out_of_service: &'s ReasonsByResource,
    /// What runs with another description, and what to do.
    pub other_descriptions: Vec<String>,
    /// The steps back to auto.
    pub plan: Option<PlanPart>,
    pub control: ControlPart,
}

/// The view of one line.
#[derive(Debug)]
pub struct ConsoleView {
    line: Line,
    /// Of a flexible cell.
    names: Option<CellChoices>,
    mode_name: fn(u8) -> &'static str,
    lanes: LaneRecorder,
    alarms: AlarmBook,
}

impl ConsoleInputs<'_> {
    /// Nothing was ever received.
    pub fn nothing(now: Duration, line: &Line) -> Self {
        ConsoleInputs {
            now,
            line: None,
            stations: vec![None; line.stations.len()],
            cell: None,
            cycle: None,
            next: None,
            out_of_service: const { &ReasonsByResource::new() },
            other_descriptions: Vec::new(),
            plan: None,
            control: ControlPart::default(),
        }
    }
}

impl ConsoleView {
    /// A view of this line. `names`: of a flexible cell, what can be ordered and taken out of service. `mode_name`: the name of a mode by
    /// its number in the messages.
    pub fn new(line: &Line, names: Option<CellChoices>, mode_name: fn(u8) -> &'static str) -> Self {
        let (lanes, alarms) = (LaneRecorder::new(line), AlarmBook::default());
        ConsoleView { line: line.clone(), names, mode_name, lanes, alarms }
    }

    /// Acknowledges an alarm, by its number on the page. Gives its source and what it is about.
    ///
    /// # Errors
    /// When it is over.
    pub fn acknowledge(&mut self, now: Duration, shown: u64, by: String, note: String) -> Result<&str, String> {
        self.alarms.acknowledge(now, shown, by, note)
    }

    /// Takes a station's state when it is received, so that its lanes have motions that are shorter than the time between two pages.
    pub fn take_station(&mut self, now: Duration, station: StationId, state: &StationState) {
        self.lanes.take(now, station, state);
    }

    /// The page of now.
    pub fn page(&mut self, of: &ConsoleInputs<'_>) -> ConsolePage {
        let limit = state_fresh(&self.line);
        let line = of.line.and_then(|line| line.fresh(limit));
        let mut stations = Vec::new();
        for (id, of_station) in self.line.station_ids().zip(&of.stations) {
            match of_station.filter(|state| state.age < limit) {
                Some(state) => self.lanes.take(of.now.saturating_sub(state.age), id, state.state),
                None => self.lanes.lost(id),
            }
            stations.push(self.station(id, *of_station, line, of.next));
        }
        let is_cell = self.names.is_some();
        let cell = of.cell.filter(|cell| is_cell && cell.age < CELL_FRESH);
        let cell_unknown = (is_cell && cell.is_none())
            .then(|| station_not_received(of.cell.and_then(|cell| cell.unheard_for(CELL_FRESH))));
        let mode = self.mode(of, line);
        let mut alarms =
            line.map_or_else(|| vec![LineAlarm::new("line", NOT_RECEIVED, AlarmPriority::High, &mode.text)], of_line);
        alarms.extend(of_nodes(of, &stations, cell_unknown.as_deref()));
        let mut alarms = self.alarms.aged(of.now, alarms);
        alarms.extend(cell.into_iter().flat_map(|cell| of_cell(cell.state, now_of(cell))));
        alarms.sort_by_key(|alarm| alarm.priority);
        let unheard = stations.iter().filter(|of| of.health == StationHealth::Unknown).map(|of| of.label.as_str());
        let silent =
            [("line", line.is_none()), ("cell", cell_unknown.is_some())].into_iter().filter(|(_, is_so)| *is_so);
        let silent: Vec<&str> = silent.map(|(name, _)| name).chain(unheard).collect();
        self.alarms.finish(of.now, &mut alarms, &silent);
        let fresh = OperateStates {
            coordinator: line,
            stations: of.stations.iter().map(|of| of.and_then(|of| of.fresh(limit))).collect(),
            is_other_description: !of.other_descriptions.is_empty(),
            cell: cell.map(|cell| cell.state),
        };
        let mut plan = of.plan.clone();
        if let Some(button) = plan.as_mut().and_then(|plan| plan.button.as_mut()) {
            let why = button.why_not.take();
            button.why_not = why.or_else(|| why_not(&self.line, &fresh, &button.act, self.mode_name));
        }
        ConsolePage {
            operate: OperatePart::of(&self.line, &fresh, self.mode_name),
            plan,
            control: of.control.clone(),
            title: self.line.title.clone(),
            is_cell,
            mode,
            other_descriptions: of.other_descriptions.clone(),
            next: of.next.map(|next| next.text().to_owned()),
            alarms,
            stations,
            lanes: self.lanes.at(of.now, &self.line),
            cell: cell.zip(self.names.as_ref()).map(|(cell, names)| CellPart::of(cell, of.out_of_service, names)),
            cell_unknown,
        }
    }

    fn mode(&self, of: &ConsoleInputs<'_>, line: Option<&LineState>) -> ModePart {
        let unheard = of.line.and_then(|line| line.unheard_for(state_fresh(&self.line)));
        let Some(state) = line else {
            return ModePart {
                is_known: false,
                word: "unknown",
                text: coordinator_not_received(unheard),
                is_enabled: None,
                waiting_for: Vec::new(),
                left_out: Vec::new(),
                restarted: Vec::new(),
                refusal: None,
                refused: String::new(),
                cycle: None,
            };
        };
        ModePart {
            is_known: true,
            word: (self.mode_name)(state.mode),
            text: bounds::text(&state.text),
            is_enabled: Some(state.enabled),
            waiting_for: bounds::texts(&*state.waiting_for),
            left_out: bounds::texts(&*state.left_out),
            restarted: bounds::texts(&*state.restarted),
            refusal: refusal(state).map(|text| bounds::text(&text)),
            refused: bounds::text(&state.refused),
            cycle: of.cycle.map(|of| CyclePart { number: of.number, duration_s: of.duration_s }),
        }
    }

    fn station(
        &self,
        id: StationId,
        of: Option<Aged<'_, StationState>>,
        line: Option<&LineState>,
        next: Option<&NextStep>,
    ) -> StationPart {
        let (described, limit) = (self.line.station(id), state_fresh(&self.line));
        let (name, label) = (described.name.clone(), described.label());
        let Some(state) = of.and_then(|of| of.fresh(limit)) else {
            return StationPart {
                name,
                label,
                health: StationHealth::Unknown,
                unknown: Some(station_not_received(of.and_then(|of| of.unheard_for(limit)))),
                mode: None,
                cycle: None,
                operation: None,
                moves: None,
                fault: None,
                notes: Vec::new(),
                waits_for: Vec::new(),
            };
        };
        let is_left_out = line.is_some_and(|line| line.left_out.contains(&name));
        let is_alone = self.names.is_some() && line.is_some_and(|line| line.mode != StationState::MODE_ESTOP);
        let is_stopped = state.mode == StationState::MODE_ESTOP;
        let notes = [(state.selector_manual, SELECTOR_AT_MANUAL), (is_alone && is_stopped, OWN_EMERGENCY_STOP)];
        let health = match () {
            () if is_stopped => StationHealth::EmergencyStop,
            () if !state.fault.is_empty() => StationHealth::Fault,
            () if is_left_out => StationHealth::LeftOut,
            () if !state.devices_valid || state.position_lost || asks_to_confirm(state) => StationHealth::NotReady,
            () if !state.incomplete.is_empty() || line.is_some_and(|line| line.restarted.contains(&name)) => {
                StationHealth::NotReady
            }
            () if state.selector_manual => StationHealth::Manual,
            () => StationHealth::Ok,
        };
        let shown = next.map_or(Cow::Borrowed(state), |next| next.shown(id, state));
        let waits_for =
            if self.names.is_some() { bounds::texts(waits(&shown)) } else { bounds::texts(&*shown.blocked_by) };
        StationPart {
            name,
            label,
            health,
            unknown: None,
            mode: Some((self.mode_name)(state.mode)),
            cycle: Some(state.cycle),
            operation: Some(bounds::text(&state.operation)),
            moves: Some(!state.stopped),
            fault: (!state.fault.is_empty()).then(|| bounds::text(&state.fault)),
            notes: notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note.to_owned()).collect(),
            waits_for,
        }
    }
}

/// Faults of stations, what is not received but the coordinator, and what runs with another description.
fn of_nodes(of: &ConsoleInputs<'_>, stations: &[StationPart], cell_unknown: Option<&str>) -> Vec<LineAlarm> {
    let mut all = Vec::new();
    if !of.other_descriptions.is_empty() {
        all.push(LineAlarm::new("line", "description", AlarmPriority::High, &of.other_descriptions.join("; ")));
    }
    for StationPart { label, fault, unknown, .. } in stations {
        all.extend(fault.as_ref().map(|text| LineAlarm::new(label, FAULT, AlarmPriority::High, text)));
        all.extend(unknown.as_ref().map(|text| LineAlarm::new(label, NOT_RECEIVED, AlarmPriority::Medium, text)));
    }
    all.extend(cell_unknown.map(|text| LineAlarm::new("cell", NOT_RECEIVED, AlarmPriority::Medium, text)));
    all
}
