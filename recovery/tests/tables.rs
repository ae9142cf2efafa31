//! Texts about an index: a turn of an endless axis, of which its switch says neither where it is nor whether it is done.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{AxisId, Line, OpId, StationId, parse};
use linewright_recovery::{PanelButton, PlannedMotion, RecoveryAction, RecoveryStep};
use linewright_station_logic::RejoinAt;

/// The shipped rotary table, its station with the index, and that operation.
fn table() -> (Line, StationId, OpId) {
    let text = include_str!("../../examples/rotary-table.toml");
    let line = parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let index = |id: StationId| line.station(id).op_ids().find(|&op| line.station(id).index_of(op).is_some());
    let (station, op) = line.station_ids().find_map(|id| Some((id, index(id)?))).expect("it has an index");
    (line, station, op)
}

fn text(line: &Line, action: RecoveryAction, moves: Vec<PlannedMotion>) -> String {
    RecoveryStep { action, moves, is_doubtful: false, mode: ControlMode::Manual, after: None }.text(line)
}

#[test]
fn an_index_is_named_by_its_turn_and_not_by_an_end() {
    let (line, station, op) = table();
    let motion = PlannedMotion { station, place: StationPlace::operating(op), time: Duration::from_millis(800) };
    let held = text(&line, RecoveryAction::Press(station, PanelButton::Advance), vec![motion]);
    assert!(held.contains(" on by ") && held.contains(" to the next place, ") && !held.contains(" to 0"), "{held}");
}

#[test]
fn how_to_tell_an_index_that_is_done_from_one_that_has_not_begun_is_in_the_step() {
    let (mut line, station, op) = table();
    // A bolt, as the axis of another station goes: texts need no devices.
    let other = line.stations.iter().find(|other| other.axes.iter().all(|axis| axis.index.is_none())).expect("one");
    let (mut bolt, mut unlock) = (other.axes[0].clone(), other.operations[0].clone());
    let table = &mut line.stations[station.index()];
    bolt.name = "bolt".into();
    unlock.name = "unlock".into();
    unlock.motion.axis = AxisId::at(table.axes.len());
    table.axes.push(bolt);
    table.operations.push(unlock);
    let before = line.station(station).operation_named("unlock").expect("it has it now");
    let name = |op: OpId| line.operation((station, op)).name.as_str();
    for (within, other) in [(op, before), (before, op)] {
        let action = RecoveryAction::Rejoin { station, at: RejoinAt::Within(within), or_within: vec![other] };
        let said = text(&line, action, Vec::new());
        let moved = format!("moved on to the next place: --within `{}`", name(op));
        let began = format!("where it began: --within `{}`", name(before));
        assert!(said.contains(&moved) && said.contains(&began), "{said}");
        assert!(said.contains("goes on with the operation after that"), "{said}");
    }
}
