//! What comes first in a plan: what no command does, what is held at this moment, and fault signals that are on.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{InputId, Line, MotionSignals, OpId, OperationModule, Station, StationId};
use linewright_station_logic::StationReport;

use crate::image;
use crate::situation::{ConsoleSituation, LineSituation};
use crate::step::{Need, PanelButton, PlannedMotion, RecoveryAction, RecoveryStep};

/// What has to be before anything else, and no command does.
pub(crate) fn before_all(line: &Line, situation: &LineSituation) -> Vec<Need> {
    let mut needs: Vec<Need> = situation.obstacles.iter().cloned().map(Need::Other).collect();
    match situation.console {
        ConsoleSituation::Heard => {}
        ConsoleSituation::ButtonPressed if situation.mode == ControlMode::EStop && !situation.is_reset => {
            needs.push(Need::Button);
        }
        ConsoleSituation::ButtonPressed => {}
        ConsoleSituation::Lost => needs.push(Need::Console),
    }
    let stations = || line.station_ids().zip(&situation.stations);
    needs.extend(stations().filter(|(_, report)| report.is_none()).map(|(id, _)| Need::Heard(id)));
    let heard = || stations().filter_map(|(id, report)| Some((id, report.as_ref()?)));
    needs.extend(heard().filter(|(_, report)| !report.devices_valid).map(|(id, _)| Need::Devices(id)));
    let is_in_auto = situation.mode == ControlMode::Auto && situation.enabled;
    let moves = |report: &StationReport| !report.stopped && !is_in_auto && !is_held(report);
    needs.extend(heard().filter(|(_, report)| moves(report)).map(|(id, _)| Need::Standstill(id)));
    needs
}

/// The motions of a station that are under way.
fn under_way(line: &Line, id: StationId, report: &StationReport) -> Vec<PlannedMotion> {
    let moves = report.places.iter().enumerate().filter_map(|(op, &number)| {
        let place = StationPlace::from_number(OpId::at(op), number).filter(|place| place.is_operating())?;
        (op < line.station(id).operations.len()).then_some(place)
    });
    let motion = |place: StationPlace| {
        let arrived = image::arrived(line, id, report.measured, &[place]);
        planned(line, id, place, arrived)
    };
    moves.map(motion).collect()
}

/// A motion, with the image in which it ends.
pub(crate) fn planned(line: &Line, station: StationId, place: StationPlace, arrived: u128) -> PlannedMotion {
    let is_index = line.station(station).index_of(place.op).is_some();
    PlannedMotion {
        station,
        place,
        to_place: if is_index { image::place(line, station, arrived) } else { None },
        homes: false,
        time: image::motion(line.station(station), place).1,
    }
}

/// Whether what moves there is held at a button: in manual nothing moves by itself.
const fn is_held(report: &StationReport) -> bool {
    matches!(report.mode, Some(ControlMode::Manual)) && !report.stopped
}

/// What is held now: it is held on until its motion has ended. Of a homing at a rest the search says so.
pub(crate) fn held(line: &Line, situation: &LineSituation) -> Vec<RecoveryStep> {
    let stations = || line.station_ids().zip(&situation.stations);
    let heard = stations().filter_map(|(id, report)| Some((id, report.as_ref()?)));
    let moves =
        |&(id, report): &(StationId, &StationReport)| is_held(report) && !under_way(line, id, report).is_empty();
    let held: Vec<(StationId, &StationReport)> = heard.filter(moves).collect();
    let step = |action, moves| RecoveryStep { action, moves, is_doubtful: false, mode: situation.mode, after: None };
    if situation.resumes && !held.is_empty() {
        let moves = held.iter().flat_map(|&(id, report)| under_way(line, id, report)).collect();
        return vec![step(RecoveryAction::Resume, moves)];
    }
    let press = |(id, report): (StationId, &StationReport)| {
        let moves = under_way(line, id, report);
        // On a recovery path every motion is one of return.
        let goes_back = report.recovering_home || moves.iter().any(|motion| motion.place.block == Block::Recovery);
        let button = if goes_back { PanelButton::Return } else { PanelButton::Advance };
        step(RecoveryAction::Press(id, button), moves)
    };
    held.into_iter().map(press).collect()
}

/// The fault signals that are on, of the operations that were stopped.
pub(crate) fn fault_signals(station: &Station, report: &StationReport) -> Vec<InputId> {
    let mut on = Vec::new();
    for &(op, _) in &report.incomplete {
        let Some(operation) = station.operations.get(op.index()) else { continue };
        let back = match &operation.module {
            OperationModule::Reversible { recovery, .. } => Some(*recovery),
            OperationModule::Irreversible { .. } => None,
        };
        let faults = std::iter::once(operation.normal).chain(back).filter_map(|signals: MotionSignals| signals.fault);
        for fault in faults.filter(|fault| report.devices_valid && report.measured & fault.bit() != 0) {
            if !on.contains(&fault) {
                on.push(fault);
            }
        }
    }
    on
}
