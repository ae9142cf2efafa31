//! Tables: their homing, and texts about an index: a turn of an endless axis, of which its switch says neither where it is nor whether it is done.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{AxisId, Device, Line, OpId, Owner, StationId, Tick, parse};
use linewright_recovery::{
    LineSituation, PanelButton, PlannedMotion, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, RejoinChoice,
    plan,
};
use linewright_station_logic::{
    Controller, NO_DELAY, RejoinAt, Restore, StationInput, StationOutbox, StationReport, StationSnapshot,
};

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
    let place = StationPlace::operating(op);
    let time = Duration::from_millis(800);
    let motion = PlannedMotion { station, place, to_place: None, homes: false, time };
    let held = |motion| text(&line, RecoveryAction::Press(station, PanelButton::Advance), vec![motion]);
    let by_switch = held(motion);
    assert!(by_switch.contains(" on by ") && by_switch.contains(" to the next place, "), "{by_switch}");
    assert!(!by_switch.contains(" to 0"), "{by_switch}");
    let by_drive = held(PlannedMotion { to_place: Some(3), ..motion });
    assert!(by_drive.contains(" to place 3, "), "{by_drive}");
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
        let [at, other] = [within, other].map(|op| RejoinChoice {
            at: RejoinAt::Within(op),
            places: vec![StationPlace::completed(op)],
            on: 0,
            numbers: Vec::new(),
            activity: None,
        });
        let action = RecoveryAction::Rejoin { station, at, or: vec![other] };
        let said = text(&line, action, Vec::new());
        let moved = format!("moved on to the next place: --within `{}`", name(op));
        let began = format!("where it began: --within `{}`", name(before));
        assert!(said.contains(&moved) && said.contains(&began), "{said}");
        assert!(said.contains("goes on with the operation after that"), "{said}");
    }
}

/// The plan for a line at home in stand-by whose table stood last at this place, and whose drive has lost its reference since.
fn unreferenced(place: u16) -> (Line, RecoveryPlan) {
    let (absolute, index) = (include_str!("../../examples/driven-table.toml"), "\"place_4\"] }");
    let homing = "homing = { method = 17, fast = 30, slow = 5, output = \"turn\" }";
    let text = absolute.replacen(index, &format!("{index}\n{homing}"), 1);
    let line = parse("driven-table.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let report = |id: StationId| -> StationReport {
        let station = line.station(id);
        let mut drives = line.devices_of(Owner::Station(id)).filter_map(Device::drive);
        let is_silent = drives.any(|drive| drive.index.is_some() && drive.homing.is_some());
        let home = StationPlace::completed(station.home);
        let at_home = station.rest_inputs(home) | station.operations[station.home.index()].normal.complete.bit();
        let fresh = Controller::new(&line, id, 7, Restore::Fresh).expect("it compiles").snapshot();
        let kept = StationSnapshot { generation: 5, placed: true, place: if is_silent { place } else { 0 }, ..fresh };
        let mut controller = Controller::new(&line, id, 7, Restore::From(kept)).expect("its own");
        let bits = if is_silent { 0 } else { at_home };
        let image = StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY };
        controller.handle(Tick::from_millis(1), image);
        controller.step(Tick::from_millis(1), &mut StationOutbox::default());
        assert_eq!(controller.report().position_lost.is_some(), is_silent);
        controller.report()
    };
    let stations = line.station_ids().map(|id| Some(report(id))).collect();
    let found = plan(&line, &LineSituation::of(&line, ControlMode::StandBy, stations));
    (line, found)
}

#[test]
fn a_table_at_rest_without_its_reference_is_homed_by_a_held_button() {
    let (line, found) = unreferenced(1);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
    let homing = found.steps.iter().position(|step| step.moves.iter().any(|motion| motion.homes));
    let homing = homing.unwrap_or_else(|| panic!("{texts:#?}"));
    assert!(texts[homing].contains("hold advance until the drive of `"), "{texts:#?}");
    assert!(!texts.concat().contains("rejoin"), "nobody judges it by eye: {texts:#?}");
    assert_eq!(found.presses(), 1, "{texts:#?}");
}

/// A homing ends at the reference: where it stood elsewhere, a person confirms.
#[test]
fn homed_at_another_place_than_it_stood_at_a_table_is_confirmed() {
    let (line, found) = unreferenced(2);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
    let homing = texts.iter().position(|text| text.contains("the drive of `")).expect("it is homed");
    let confirmed = texts.iter().position(|text| text.contains("rejoin")).expect("it is confirmed");
    assert!(homing < confirmed && !texts.concat().contains("--within"), "{texts:#?}");
}
