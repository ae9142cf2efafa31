//! Emergency stops that the coordinator has not given, and its own standstill.

use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, StationView};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord};
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::rig::Rig;

#[test]
fn a_coordinator_without_a_record_adopts_the_stop_that_a_station_is_in() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.heard[1] = StationView { estopped: true, mode_epoch: 57, ..rig.heard[1] };
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::EStop);
    assert!(rig.shell.coordinator().epoch() > 57 && rig.record.estop);
}

#[test]
fn a_stop_that_somebody_else_gives_a_station_in_auto_is_adopted_and_adopted_again_while_it_lasts() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    rig.heard[2].estopped = true;
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::EStop);
    rig.command(ModeCommand::Reset);
    rig.command(ModeCommand::Manual);
    rig.refresh();
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::EStop, "it has heard of the way out and is in it still");
    rig.heard[2].estopped = false;
    rig.command(ModeCommand::Reset);
    rig.command(ModeCommand::Manual);
    rig.refresh();
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::Manual);
}

/// The last state from before the arrival of the way out has no effect.
#[test]
fn a_station_that_has_not_heard_of_the_way_out_yet_stops_nothing() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    rig.command(ModeCommand::EStop);
    rig.refresh();
    let stopped = rig.shell.coordinator().epoch();
    rig.command(ModeCommand::Reset);
    rig.command(ModeCommand::Manual);
    rig.act();
    assert_eq!(rig.mode(), ControlMode::Manual);
    let heard = StationView { estopped: true, mode_epoch: stopped, ..rig.heard[0] };
    rig.shell.handle(rig.now, CoordinatorArrival::State { station: StationId(0), sequence: 900, heard });
    rig.act();
    assert_eq!(rig.mode(), ControlMode::Manual);
}

#[test]
fn after_a_standstill_what_waited_says_nothing_of_the_present() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let station = rig.line.station_named("clamp_1").expect("a clamp");
    rig.now = rig.now + Duration::from_secs(10);
    rig.outputs(station, 1);
    rig.hear_all();
    let done = rig.act();
    assert_eq!(rig.mode(), ControlMode::StandBy, "nobody was heard");
    assert!(!done.contains(&CoordinatorEffect::Energise(station, 1)), "{done:?}");
    rig.refresh();
    rig.outputs(station, 1);
    let done = rig.act();
    assert!(rig.shell.coordinator().hears(station));
    assert!(done.contains(&CoordinatorEffect::Energise(station, 1)), "{done:?}");
}

/// The finger never left it: what waited while the coordinator stood still holds it down, and so does what follows.
#[test]
fn a_button_that_was_held_over_a_standstill_counts_when_it_was_released() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    let held = |rig: &mut Rig, buttons: u32| {
        rig.shell.handle(rig.now, CoordinatorArrival::Buttons { console: 1, held: buttons });
        rig.refresh();
        rig.shell.order().buttons
    };
    assert_eq!(held(&mut rig, 0b01), 0b01);
    rig.now = rig.now + Duration::from_secs(10);
    for _ in 0..5 {
        assert_eq!(held(&mut rig, 0b01), 0);
    }
    assert_eq!(held(&mut rig, 0b00), 0);
    assert_eq!(held(&mut rig, 0b01), 0b01);
}

/// Its journal is gone, and the line's epochs have come far.
#[test]
fn a_station_in_an_emergency_stop_is_believed_whatever_its_epoch() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.heard[1] = StationView { estopped: true, mode_epoch: 1 << 40, ..rig.heard[1] };
    let beyond = CoordinatorArrival::State { station: StationId(1), sequence: u64::MAX, heard: rig.heard[1] };
    assert!(!rig.shell.handle(rig.now, beyond), "it is reported");
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::EStop);
    assert!(rig.shell.coordinator().epoch() < 1 << 20, "its epoch is not followed");
}

/// The cell has put one station into emergency stop: its outputs go off and its order is the stop, at once; the others go on.
/// Reset, nothing that it decided before is put out.
#[test]
fn a_station_is_stopped_by_itself_and_follows_again_in_an_epoch_of_its_own() {
    let mut rig = Rig::with_one_task_driven(CoordinatorRecord::default());
    rig.shell.plays_cell([].into_iter(), [].into_iter());
    rig.in_auto();
    let (id, other) = (rig.line.station_named("clamp_1").expect("there"), StationId(0));
    rig.outputs(id, 1);
    assert!(rig.act().contains(&CoordinatorEffect::Energise(id, 1)));
    let epoch = rig.shell.order().epoch;

    rig.shell.plays_cell([id].into_iter(), [id].into_iter());
    let done = rig.act();
    assert!(done.contains(&CoordinatorEffect::Energise(id, 0)), "{done:?}");
    assert!(done.iter().any(|effect| matches!(effect, CoordinatorEffect::Order { .. })), "{done:?}");
    assert_eq!(
        (rig.shell.order_for(id).mode, rig.shell.order_for(other).mode),
        (ControlMode::EStop, ControlMode::Auto)
    );
    assert_eq!((rig.shell.order_for(id).epoch, rig.shell.order_for(other).enabled), (epoch, true));
    rig.heard[id.index()].estopped = true;
    rig.heard[id.index()].incomplete = true;
    rig.outputs(id, 1);
    let done = rig.refresh();
    assert!(!done.contains(&CoordinatorEffect::Energise(id, 1)), "{done:?}");
    assert_eq!(rig.mode(), ControlMode::Auto);

    // What it decided in the epoch before its reset comes late.
    rig.outputs(id, 1);
    rig.shell.plays_cell([id].into_iter(), [].into_iter());
    let done = rig.act();
    assert!(!done.contains(&CoordinatorEffect::Energise(id, 1)), "{done:?}");
    assert_eq!((rig.shell.order_for(id).mode, rig.shell.order_for(id).epoch), (ControlMode::Auto, epoch + 1));
    assert_eq!(rig.record.epoch, epoch + 1, "it is written down");
    rig.heard[id.index()].estopped = false;
    rig.refresh();
    rig.outputs(id, 1);
    assert!(rig.act().contains(&CoordinatorEffect::Energise(id, 1)));
}

/// A cell whose log cannot be written raises no alarm and stops nothing: then a fault of any station ends auto.
#[test]
fn what_fails_while_the_cell_decides_nothing_ends_auto() {
    for is_unattended in [false, true] {
        let mut rig = Rig::with_one_task_driven(CoordinatorRecord::default());
        let id = rig.line.station_named("clamp_1").expect("there");
        rig.shell.plays_cell([].into_iter(), [].into_iter());
        rig.in_auto();
        rig.shell.leaves_unattended(is_unattended);
        rig.refresh();
        assert_eq!(rig.mode(), ControlMode::Auto, "as long as nothing fails");
        rig.heard[id.index()].incomplete = true;
        rig.refresh();
        assert_eq!(rig.mode() == ControlMode::Auto, !is_unattended, "{}", rig.shell.coordinator().text());
    }
}

/// Its coordinator has been started again: the cell's log is read before any station is received. Without the log the reason
/// of the stop is lost, and the line is stopped.
#[test]
fn a_new_coordinator_knows_the_station_or_stops_the_line() {
    for is_known in [true, false] {
        let mut rig = Rig::with_one_task_driven(CoordinatorRecord { epoch: 40, estop: false });
        let id = rig.line.station_named("clamp_1").expect("there");
        let stopped = is_known.then_some(id);
        rig.shell.plays_cell(stopped.into_iter(), stopped.into_iter());
        rig.heard[id.index()] = StationView { estopped: true, mode_epoch: 41, ..rig.heard[id.index()] };
        rig.refresh();
        assert_eq!(rig.mode() == ControlMode::EStop, !is_known, "{}", rig.shell.coordinator().text());
        assert_eq!(rig.shell.order_for(id).mode, ControlMode::EStop);
    }
}

/// The state of its start was not received: it is of an earlier start, or its node was started with another description, and its
/// bits mean other outputs.
#[test]
fn an_image_of_a_station_that_is_not_received_is_not_put_out() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    let station = rig.line.station_named("clamp_1").expect("a clamp");
    let is_on = |done: &[CoordinatorEffect]| done.contains(&CoordinatorEffect::Energise(station, 1));
    rig.outputs(station, 1);
    assert!(!is_on(&rig.act()));
    rig.hear_all();
    rig.act();
    rig.outputs(station, 1);
    assert!(is_on(&rig.act()));
}
