//! A way through the states as people see it: numbered steps, and a bar chart up to the last of them.

use std::fmt;

use linewright_line::net::{Block, MotionStage};
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::StationHappening;

use super::setting::LineExploration;
use super::state::ComposedState;
use super::station::{PanelKey, StationAct};
use super::system::{System, SystemMove};

/// Path to a state, in words and as a bar chart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinePath {
    /// Steps, in order: `clamp_1: starts advance clamp`.
    pub steps: Vec<String>,
    /// Violation at the end.
    pub end: String,
    /// The operations that moved, a line of text each: a column for every step, `█` while an operation runs, `░` while
    /// it is undone, `✗` while it stands incomplete.
    pub chart: Vec<String>,
}

impl LinePath {
    /// A way in words: from the states before each move with the move, and the last state.
    pub(crate) fn tell(
        system: &System,
        way: &[(ComposedState, SystemMove)],
        last: &ComposedState,
        end: String,
    ) -> Self {
        let steps = way.iter().map(|(state, what)| step(system, state, *what)).collect();
        let after = way.iter().skip(1).map(|(state, _)| state).chain([last]);
        LinePath { steps, end, chart: chart(system, after) }
    }
}

impl fmt::Display for LinePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (nth, step) in self.steps.iter().enumerate() {
            writeln!(f, "{:4}. {step}", nth + 1)?;
        }
        writeln!(f, "      and so: {}", self.end)?;
        writeln!(f)?;
        self.chart.iter().try_for_each(|row| writeln!(f, "  {row}"))
    }
}

fn step(system: &System, state: &ComposedState, what: SystemMove) -> String {
    let line = &system.setting.line;
    let cause = cause(system, state, what);
    let Some((station, events)) = system.events(state, what) else { return cause };
    let name = &line.station(station).name;
    let said: Vec<String> = events.iter().filter(|event| worth_telling(event)).map(|e| e.text(line, station)).collect();
    match (cause.is_empty(), said.is_empty()) {
        (_, true) => format!("{name}: {cause}"),
        (true, false) => format!("{name}: {}", said.join(", ")),
        (false, false) => format!("{name}: {cause}; {}", said.join(", ")),
    }
}

/// A motion that starts or ends needs no cause; devices that come back in the next image are part of a failure.
fn worth_telling(event: &StationHappening) -> bool {
    !matches!(event.what, linewright_station_logic::HappeningKind::Devices(true))
}

/// Cause of a move; empty where the events themselves show it.
fn cause(system: &System, state: &ComposedState, what: SystemMove) -> String {
    let setting = &system.setting;
    match what {
        SystemMove::Grant(mode) => format!("coordinator: grants {}", setting.modes[mode]),
        SystemMove::Hear { link, .. } => {
            format!("receives the state of {}", setting.line.stations[setting.links[link].writer].name)
        }
        SystemMove::Act { station, nth } => {
            let situation = state.situations[station] as usize;
            act(setting, StationId::at(station), system.stations[station].facts[situation].acts[nth])
        }
    }
}

fn act(setting: &LineExploration, station: StationId, act: StationAct) -> String {
    let motion = |op: OpId, block: Block| {
        let name = &setting.line.operation((station, op)).name;
        if block == Block::Recovery { format!("undoing {name}") } else { name.clone() }
    };
    match act {
        StationAct::Mode(_) => String::new(),
        StationAct::Key(Some(PanelKey::Advance)) => "its operator holds `advance`".to_owned(),
        StationAct::Key(Some(PanelKey::Return)) => "its operator holds `return`".to_owned(),
        StationAct::Key(None) => "its operator releases the button".to_owned(),
        StationAct::Button(Some(button)) => {
            format!("receives: button {} held", setting.line.buttons[usize::from(button)])
        }
        StationAct::Button(None) => "receives: button released".to_owned(),
        StationAct::Arrive(op, block) => format!("{} arrives", motion(op, block)),
        StationAct::Fail(op, block) => format!("{} fails", motion(op, block)),
        StationAct::Step => "next step".to_owned(),
        StationAct::Order(task) => format!("receives task order {}", setting.line.station(station).task(task).name),
        StationAct::Secure => "receives: secure the order".to_owned(),
        StationAct::Expire => "time limit of its order exceeded".to_owned(),
        StationAct::Sensors(true) => "inputs of its operations come on".to_owned(),
        StationAct::Restart => "restarts".to_owned(),
        StationAct::Forget => "restarts without its journal".to_owned(),
        StationAct::Sensors(false) => "inputs of its operations go off".to_owned(),
    }
}

/// A row for each operation that moved, and a column for the state after each step.
fn chart<'a>(system: &System, states: impl Iterator<Item = &'a ComposedState>) -> Vec<String> {
    let line = &system.setting.line;
    let mut rows: Vec<(StationId, OpId, String)> = Vec::new();
    for id in line.station_ids() {
        rows.extend(line.station(id).op_ids().map(|op| (id, op, String::new())));
    }
    let mut columns = 0;
    for state in states {
        columns += 1;
        for (station, op, cells) in &mut rows {
            let situation = &system.stations[station.index()].all[state.situations[station.index()] as usize];
            let place = situation.controller.marking().find(|place| place.op == *op);
            cells.push(match place.map(|place| (place.block, place.stage)) {
                Some((Block::Normal, MotionStage::Operating)) => '█',
                Some((Block::Recovery, MotionStage::Operating)) => '░',
                Some((_, MotionStage::Incomplete)) => '✗',
                Some((_, MotionStage::Completed)) | None => ' ',
            });
        }
    }
    rows.retain(|(_, _, cells)| cells.trim() != "");
    let label = |station: StationId, op: OpId| label(line, station, op);
    let width = rows.iter().map(|(station, op, _)| label(*station, *op).chars().count()).max().unwrap_or(0);
    let mut drawn = vec![ruler(width, columns)];
    drawn.extend(rows.iter().map(|(station, op, cells)| {
        let label = label(*station, *op);
        format!("{label}{} │{cells}", " ".repeat(width - label.chars().count()))
    }));
    drawn
}

fn label(line: &Line, station: StationId, op: OpId) -> String {
    format!("{}: {}", line.station(station).name, line.operation((station, op)).name)
}

/// The numbers of the steps, every tenth.
fn ruler(width: usize, columns: usize) -> String {
    let mut numbers = String::new();
    for ten in (10..=columns).step_by(10) {
        numbers.push_str(&format!("{ten:>10}"));
    }
    format!("{} │{numbers}", " ".repeat(width))
}
