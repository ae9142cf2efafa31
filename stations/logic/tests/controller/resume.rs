//! *Resume* at a console: what was stopped goes on while it is held, and nothing else happens.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, StationId};
use linewright_station_logic::PanelCommand;
use linewright_testkit::built::{alone, beside, complete_bit, i, r, transfer_line};

use super::interlock::{BAR, GENERATION, InterlockBench, MILL};
use super::rig::Rig;

/// In manual, stopped in the middle of its second operation.
fn stopped(ops: &[linewright_testkit::built::Op]) -> Rig {
    let mut rig = Rig::new(alone(ops.len() - 1, ops));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.set(u128::MAX, false);
    rig.advance(false);
    assert_eq!(rig.marking()[0], StationPlace::incomplete(OpId(1)));
    rig.events();
    rig
}

fn resume(rig: &mut Rig, held: bool) {
    rig.order.resume = held;
    rig.order();
}

#[test]
fn a_stopped_operation_goes_on_to_its_end_and_the_next_one_does_not_begin() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    resume(&mut rig, true);
    assert!(rig.drives(1));
    rig.wait_ms(800);
    assert!(rig.drives(1), "held for longer than any lease, while it is renewed");
    rig.arrive(1);
    rig.wait_ms(500);
    assert_eq!((rig.outputs, rig.marking()), (0, vec![StationPlace::completed(OpId(1))]));
    resume(&mut rig, false);
    resume(&mut rig, true);
    assert_eq!((rig.outputs, rig.events()), (0, vec!["started op 1".to_owned(), "completed op 1".to_owned()]));
}

#[test]
fn let_go_it_stops_at_once_and_pressed_again_it_goes_on() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    resume(&mut rig, true);
    resume(&mut rig, false);
    assert_eq!((rig.outputs, rig.marking()), (0, vec![StationPlace::incomplete(OpId(1))]));
    resume(&mut rig, true);
    assert!(rig.drives(1));
}

#[test]
fn an_order_that_comes_late_is_no_new_press() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    resume(&mut rig, true);
    // Within the lease of the order, and too old for a button.
    rig.silence_ms(260);
    assert_eq!((rig.outputs, rig.controller.mode()), (0, ControlMode::Manual));
    rig.wait_ms(500);
    assert_eq!(rig.outputs, 0, "it was not seen released");
    resume(&mut rig, false);
    resume(&mut rig, true);
    assert!(rig.drives(1));
}

#[test]
fn already_held_when_manual_begins_or_in_another_coordinators_order_it_moves_nothing() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    for mode in [ControlMode::StandBy, ControlMode::Hand, ControlMode::Auto, ControlMode::EStop] {
        resume(&mut rig, false);
        rig.mode(mode);
        resume(&mut rig, true);
        assert_eq!(rig.outputs, 0, "{mode}");
        rig.mode(ControlMode::Manual);
        rig.wait_ms(200);
        assert_eq!(rig.outputs, 0, "held from {mode} on");
    }
    resume(&mut rig, false);
    resume(&mut rig, true);
    assert!(rig.drives(1));
    rig.order.boot_id += 1;
    rig.order.epoch += 1;
    rig.order();
    rig.wait_ms(200);
    assert_eq!(rig.outputs, 0, "pressed at another coordinator");
}

#[test]
fn a_panel_that_is_its_stations_own_is_not_the_consoles() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    rig.controller.handle(rig.now, linewright_station_logic::StationInput::Panel(PanelCommand::Selector(true)));
    resume(&mut rig, true);
    assert_eq!(rig.outputs, 0, "its selector stands at manual");
    rig.controller.handle(rig.now, linewright_station_logic::StationInput::Panel(PanelCommand::Selector(false)));
    rig.wait_ms(200);
    assert_eq!(rig.outputs, 0, "turned back while resume is held");
    resume(&mut rig, false);
    resume(&mut rig, true);
    assert!(rig.drives(1));
    // Advance at the panel takes the motion over; let go there it stops, though the console still holds.
    rig.advance(true);
    assert!(rig.drives(1));
    rig.advance(false);
    rig.wait_ms(200);
    assert_eq!(rig.outputs, 0);
    resume(&mut rig, false);
    resume(&mut rig, true);
    rig.retract(true);
    assert_eq!(rig.outputs, 0, "the other button at the panel stops it");
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    rig.order.manual_all = false;
    resume(&mut rig, true);
    assert_eq!(rig.outputs, 0, "manual was not commanded");
}

#[test]
fn what_is_being_taken_back_is_not_turned_round() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    rig.retract(true);
    rig.retract(false);
    assert_eq!(rig.marking(), [StationPlace::undo_incomplete(OpId(1))]);
    resume(&mut rig, true);
    rig.wait_ms(200);
    assert_eq!(rig.outputs, 0);
    resume(&mut rig, false);
    rig.advance(true);
    assert!(rig.drives(1), "by choice, at the panel");
}

#[test]
fn on_a_recovery_path_nothing_moves() {
    let mut rig = stopped(&[r(6), i(6, &[0]), r(6)]);
    rig.retract_through(0);
    rig.retract(true);
    rig.retract(false);
    assert_eq!(rig.marking(), [StationPlace::incomplete(OpId(2))], "on its way home");
    resume(&mut rig, true);
    assert_eq!(rig.outputs, 0);
}

#[test]
fn what_a_fault_stops_while_it_is_held_stays_stopped() {
    let mut rig = stopped(&[r(6), r(6), r(6)]);
    resume(&mut rig, true);
    let fault = complete_bit(OpId(1), false) << 1;
    rig.set(fault, true);
    rig.set(fault, false);
    rig.wait_ms(500);
    assert_eq!((rig.outputs, rig.marking()), (0, vec![StationPlace::incomplete(OpId(1))]));
    resume(&mut rig, false);
    resume(&mut rig, true);
    assert!(rig.drives(1), "after a new press");
}

#[test]
fn operations_side_by_side_go_on_together_and_one_that_is_done_stays() {
    let mut rig = Rig::new(alone(3, &[r(6), r(6), beside(6), r(6)]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.arrive(1);
    rig.advance(false);
    assert_eq!(rig.marking(), [StationPlace::completed(OpId(1)), StationPlace::incomplete(OpId(2))]);
    resume(&mut rig, true);
    assert!(rig.drives(2));
    rig.arrive(2);
    rig.wait_ms(200);
    assert_eq!((rig.outputs, rig.marking().len()), (0, 2), "the next step has not begun");
}

/// The clamp was stopped half-way to closed; the bar and the mill stand outside.
fn clamp_half_way() -> InterlockBench {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    bench.set(&[]);
    bench.release();
    // Each has done its last operation.
    for (station, report) in [(BAR, &mut bench.bar), (MILL, &mut bench.mill)] {
        let home = bench.line.station(station).home;
        report.places = vec![0; report.done.len()];
        report.places[home.index()] = StationPlace::completed(home).number();
    }
    bench
}

fn resumes(bench: &mut InterlockBench) -> bool {
    for held in [false, true] {
        bench.order.resume = held;
        bench.play();
    }
    bench.drives(bench.closing())
}

#[test]
fn inside_its_state_of_a_conflict_it_goes_on_only_while_the_other_is_outside_by_its_marking_too() {
    assert!(resumes(&mut clamp_half_way()));
    let first_lift =
        |bench: &InterlockBench| bench.line.station(BAR).operation_named("1st lift").expect("the bar has it");
    let bar_at = |bench: &mut InterlockBench, place: StationPlace| {
        bench.bar.places.fill(0);
        bench.bar.places[place.op.index()] = place.number();
    };
    // Measured outside still, as where both were stopped as soon as they had begun.
    let mut bench = clamp_half_way();
    let op = first_lift(&bench);
    bar_at(&mut bench, StationPlace::incomplete(op));
    assert!(!resumes(&mut bench));
    bar_at(&mut bench, StationPlace::undone(op));
    assert!(resumes(&mut bench), "taken back");
    bench.bar.recovering_home = true;
    assert!(!resumes(&mut bench));
    let mut bench = clamp_half_way();
    bench.bar.places.clear();
    assert!(!resumes(&mut bench), "not known");
    let mut bench = clamp_half_way();
    bench.bar.position_lost = Some((op, linewright_line::InputId(0)));
    assert!(!resumes(&mut bench));
}

#[test]
fn that_the_other_stands_is_not_enough_where_it_is_not_measured_clear() {
    let mut bench = clamp_half_way();
    bench.bar_has(&["LS_horizontal_0"], true);
    assert!(!resumes(&mut bench));
    // While it is held: what becomes clear lets it go on.
    bench.bar_has(&["LS_horizontal_0", "LS_vertical_0"], true);
    assert!(bench.drives(bench.closing()));
    bench.bar_has(&["LS_horizontal_0"], true);
    assert!(!bench.drives(bench.closing()), "and what is measured in its way stops it");
    bench.bar_has(&["LS_horizontal_0", "LS_vertical_0"], true);
    assert!(!bench.drives(bench.closing()), "once while it is held");
}

#[test]
fn a_station_that_does_not_know_its_place_is_not_moved() {
    // Switched on for the first time, away from home: the home operation counts as incomplete.
    let mut rig = Rig::standing(alone(1, &[r(6), r(6)]), StationId(0), 1, linewright_station_logic::Restore::Fresh, 0);
    rig.mode(ControlMode::Manual);
    assert_eq!(rig.marking(), [StationPlace::incomplete(OpId(1))]);
    resume(&mut rig, true);
    assert_eq!(rig.outputs, 0);
    resume(&mut rig, false);
    rig.advance(true);
    assert!(rig.drives(1), "a person at the panel sees where it stands");
}
