//! Commands and their leases: hold to run, epochs, silence.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_station_logic::{Handled, Ignored, PanelCommand, StationInput};

use super::rig::Rig;
use linewright_testkit::built::{PANEL, alone, r};

fn rig() -> Rig {
    Rig::new(alone(1, &[r(6), r(6)]))
}

#[test]
fn a_panel_button_already_down_when_manual_begins_moves_nothing_until_pressed_again() {
    let mut rig = rig();
    rig.advance(true);
    rig.mode(ControlMode::Manual);
    rig.wait_ms(500);
    assert_eq!(rig.outputs, 0);
    rig.advance(false);
    rig.advance(true);
    assert!(rig.drives(0));
}

#[test]
fn a_hand_button_already_down_when_hand_mode_begins_moves_nothing_until_pressed_again() {
    let mut rig = rig();
    rig.hold(0);
    rig.mode(ControlMode::Hand);
    rig.wait_ms(500);
    assert_eq!(rig.outputs, 0);
    rig.release(0);
    rig.hold(0);
    assert!(rig.drives(0));
}

#[test]
fn a_hand_button_down_when_the_coordinator_returns_moves_nothing() {
    let mut rig = rig();
    rig.mode(ControlMode::Hand);
    rig.hold(0);
    assert!(rig.drives(0));
    rig.silence_ms(501);
    assert_eq!(rig.outputs, 0, "the lease has run out, and with it the button");
    assert_eq!(rig.controller.mode(), ControlMode::StandBy);
    rig.order();
    assert_eq!(rig.outputs, 0, "down when its sender came back");
    rig.release(0);
    rig.hold(0);
    assert!(rig.drives(0));
}

#[test]
fn a_hand_button_down_in_another_coordinators_first_order_moves_nothing() {
    let mut rig = rig();
    rig.mode(ControlMode::Hand);
    rig.order.boot_id += 1;
    rig.order.epoch += 1;
    rig.hold(0);
    assert_eq!(rig.outputs, 0);
}

#[test]
fn a_wired_panel_button_down_when_the_devices_return_moves_nothing() {
    let mut rig = rig();
    rig.mode(ControlMode::Manual);
    rig.devices(false);
    rig.set(1 << PANEL[1], true);
    rig.devices(true);
    rig.wait_ms(500);
    assert_eq!(rig.outputs, 0);
    rig.set(1 << PANEL[1], false);
    rig.set(1 << PANEL[1], true);
    assert!(rig.drives(0));
}

#[test]
fn a_panel_button_that_is_no_longer_refreshed_counts_as_released() {
    let mut rig = rig();
    rig.mode(ControlMode::Manual);
    rig.advance(true);
    assert!(rig.drives(0));
    rig.silence_ms(250);
    assert_eq!(rig.outputs, 0);
    for silence in [0, 750, 5000, 3_600_000] {
        rig.silence_ms(silence);
        rig.order();
        rig.controller.handle(rig.now, StationInput::Panel(PanelCommand::Advance(true)));
        rig.step();
        assert_eq!(rig.outputs, 0, "a refresh {silence} ms late is no new decision to move");
    }
    rig.advance(false);
    rig.advance(true);
    assert!(rig.drives(0));
}

#[test]
fn a_wired_panel_button_held_while_the_devices_are_away_for_a_moment_moves_nothing() {
    let mut rig = rig();
    rig.mode(ControlMode::Manual);
    rig.set(1 << PANEL[1], true);
    assert!(rig.drives(0));
    for away in [1, 700] {
        rig.devices(false);
        assert_eq!(rig.outputs, 0);
        rig.wait_ms(away);
        rig.devices(true);
        rig.wait_ms(700);
        assert_eq!(rig.outputs, 0, "away for {away} ms, the finger still on it");
    }
    rig.set(1 << PANEL[1], false);
    rig.set(1 << PANEL[1], true);
    assert!(rig.drives(0), "{:?}", rig.blocked_by());
}

#[test]
fn both_panel_buttons_mean_neither_and_letting_go_of_one_is_no_command() {
    let mut rig = rig();
    rig.mode(ControlMode::Manual);
    rig.advance(true);
    rig.retract(true);
    assert_eq!(rig.outputs, 0);
    rig.retract(false);
    assert_eq!(rig.outputs, 0, "the other finger never left its button");
    rig.advance(false);
    rig.advance(true);
    assert!(rig.drives(0));
}

#[test]
fn the_panel_moves_nothing_unless_its_station_is_switched_to_manual() {
    let mut rig = rig();
    rig.order.manual_all = false;
    rig.mode(ControlMode::Manual);
    rig.advance(true);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.blocked_by(), ["its selector at manual"]);
    rig.controller.handle(rig.now, StationInput::Panel(PanelCommand::Selector(true)));
    rig.step();
    assert_eq!(rig.outputs, 0, "the button was down when the switch was turned");
    rig.advance(false);
    rig.advance(true);
    assert!(rig.drives(0));
}

#[test]
fn without_orders_the_station_falls_to_stand_by_and_finishes_what_runs() {
    let mut rig = rig();
    rig.mode(ControlMode::Auto);
    rig.silence_ms(499);
    assert_eq!(rig.controller.mode(), ControlMode::Auto);
    rig.silence_ms(1);
    assert_eq!(rig.controller.mode(), ControlMode::StandBy);
    assert!(rig.drives(0));
    rig.arrive(0);
    assert_eq!(rig.outputs, 0);
}

#[test]
fn a_manual_motion_stops_when_manual_mode_ends_under_it() {
    let mut rig = rig();
    rig.mode(ControlMode::Manual);
    rig.advance(true);
    rig.mode(ControlMode::StandBy);
    assert_eq!((rig.outputs, rig.doing().as_str()), (0, "op 0 (stopped)"));
}

#[test]
fn an_order_of_an_older_epoch_is_not_taken() {
    let mut rig = rig();
    rig.mode(ControlMode::Auto);
    let mut yesterday = rig.order;
    yesterday.epoch -= 1;
    yesterday.mode = ControlMode::Manual;
    assert_eq!(rig.controller.handle(rig.now, StationInput::Order(yesterday)), Handled::Ignored(Ignored::OlderEpoch));
    rig.step();
    assert_eq!(rig.controller.mode(), ControlMode::Auto);
    assert_eq!(rig.report().mode_epoch, rig.order.epoch);
}

#[test]
fn a_mode_that_not_every_station_has_acknowledged_enables_nothing() {
    let mut rig = rig();
    rig.order.enabled = false;
    rig.mode(ControlMode::Auto);
    assert_eq!((rig.outputs, rig.controller.mode()), (0, ControlMode::StandBy));
    assert_eq!(rig.report().mode_epoch, rig.order.epoch, "hearing it is acknowledging it");
    rig.order.enabled = true;
    rig.order();
    assert!(rig.drives(0));
}

#[test]
fn a_lease_of_an_hour_is_an_hour() {
    let mut rig = rig();
    rig.order.lease = Duration::from_secs(3600);
    rig.mode(ControlMode::Auto);
    rig.silence_ms(400);
    assert_eq!(rig.controller.mode(), ControlMode::Auto);
}
