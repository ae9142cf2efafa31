//! Faults: outputs go off in the very step that sees one.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{OpId, StationId};
use linewright_station_logic::StopCause;

use super::rig::Rig;
use linewright_testkit::built::{alone, complete_bit, i, r};

fn running() -> Rig {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.mode(ControlMode::Auto);
    rig.events();
    rig
}

#[test]
fn a_fault_signal_stops_the_motion_in_the_same_step() {
    let mut rig = running();
    rig.set(complete_bit(OpId(0), false) << 1, true);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.events(), ["stopped op 0: fault signal: in 1 came on"]);
    assert_eq!(rig.controller.fault_text(&rig.line), "op 0: fault signal: in 1 came on, and is still on");
    assert_eq!(rig.report().incomplete, [(OpId(0), StopCause::Signal)]);
    let waits = |rig: &Rig| rig.controller.blocked_by(&rig.line, rig.now).join("; ");
    let names_it = "fault signal in 1 to go off, for op 0: it is on; remove its cause";
    assert!(waits(&rig).contains(names_it), "{}", waits(&rig));
    rig.set(complete_bit(OpId(0), false) << 1, false);
    assert!(!waits(&rig).contains("fault signal in 1"), "{}", waits(&rig));
    assert_eq!(rig.controller.fault_text(&rig.line), "op 0: fault signal: in 1 came on, and is off now");
}

#[test]
fn a_fault_signal_at_rest_is_said_before_the_motion_that_it_would_stop() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    let waits = |rig: &Rig| rig.controller.blocked_by(&rig.line, rig.now).join("; ");
    assert!(!waits(&rig).contains("fault signal"), "{}", waits(&rig));
    rig.set(complete_bit(OpId(0), false) << 1, true);
    assert!(waits(&rig).contains("fault signal in 1 to go off, for op 0: it is on"), "{}", waits(&rig));
}

#[test]
fn a_fault_and_an_arrival_in_one_image_are_a_fault() {
    let mut rig = running();
    rig.set(u128::MAX, false);
    rig.set(complete_bit(OpId(0), false) * 0b11, true);
    assert_eq!(rig.events(), ["stopped op 0: fault signal: in 1 came on"]);
}

#[test]
fn a_motion_that_outlasts_its_watchdog_is_a_fault_at_that_moment() {
    let mut rig = running();
    rig.wait_ms(999);
    assert!(rig.drives(0));
    assert_eq!(rig.controller.next_deadline(), Some(rig.now + std::time::Duration::from_millis(1)));
    rig.wait_ms(1);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.events(), ["stopped op 0: watchdog: in 0 not on within 1 s"]);
}

#[test]
fn a_switch_stuck_on_from_the_start_completes_nothing() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.set(complete_bit(OpId(0), false), true);
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(0), "a switch that was on before the motion proves nothing");
    rig.events();
    rig.wait_ms(1000);
    assert_eq!(rig.events(), ["stopped op 0: watchdog: in 0 was on before the motion started; check the switch"]);
}

#[test]
fn a_switch_stuck_on_completes_nothing_after_a_stop_either() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.set(complete_bit(OpId(0), false), true);
    rig.mode(ControlMode::Manual);
    for _ in 0..3 {
        rig.advance(true);
        assert!(rig.drives(0));
        rig.wait_ms(100);
        rig.advance(false);
        assert_eq!(rig.marking(), [StationPlace::incomplete(OpId(0))], "let go half-way, it is not done");
    }
    // Seen off, it counts: also where the motion has coasted to its end.
    rig.set(complete_bit(OpId(0), false), false);
    rig.advance(true);
    rig.advance(false);
    rig.set(complete_bit(OpId(0), false), true);
    rig.advance(true);
    assert_eq!(rig.marking(), [StationPlace::completed(OpId(0))]);
}

#[test]
fn devices_lost_stops_everything_and_starts_nothing() {
    let mut rig = running();
    rig.devices(false);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.events(), ["I/O devices lost", "stopped op 0: I/O devices lost"].map(String::from));
    let mut resting = Rig::new(alone(1, &[r(6), r(6)]));
    resting.devices(false);
    resting.mode(ControlMode::Auto);
    assert_eq!(resting.outputs, 0);
    assert_eq!(resting.marking(), [StationPlace::completed(OpId(1))], "nothing starts that nobody can watch");
    resting.devices(true);
    assert!(resting.drives(0));
}

#[test]
fn an_image_that_is_not_renewed_in_its_time_is_unknown() {
    let mut rig = running();
    let until = rig.now + std::time::Duration::from_millis(100);
    let image = linewright_station_logic::StationInput::Inputs {
        bits: 0,
        valid: true,
        until,
        under: linewright_station_logic::NO_DELAY,
    };
    rig.controller.handle(rig.now, image);
    rig.step();
    rig.silence_ms(100);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.events(), ["I/O devices lost", "stopped op 0: I/O devices lost"].map(String::from));
}

/// Every operating place of a station, reached by hand from home.
#[test]
fn the_emergency_stop_stops_every_operating_place() {
    let ops = [r(1), r(1), i(1, &[1, 0]), r(1), r(2)];
    for stop_at in 0..ops.len() as u16 {
        for back in [false, true] {
            let mut rig = Rig::new(alone(4, &ops));
            rig.mode(ControlMode::Manual);
            for op in 0..stop_at {
                rig.advance_through(op);
            }
            rig.advance(true);
            if back {
                if stop_at == 2 {
                    continue;
                }
                rig.advance(false);
                rig.retract(true);
            }
            let place =
                if back { StationPlace::undoing(OpId(stop_at)) } else { StationPlace::operating(OpId(stop_at)) };
            assert_eq!(rig.marking(), [place]);
            assert_ne!(rig.outputs, 0);
            rig.mode(ControlMode::EStop);
            assert_eq!(rig.outputs, 0, "{place}");
            assert_eq!(rig.marking(), [place.stopped()]);
            assert_eq!(rig.report().incomplete, [(OpId(stop_at), StopCause::EStop)]);
        }
    }
}

/// A station does not know whether the stop has been reset: what it waits for is true before and after.
#[test]
fn in_an_emergency_stop_a_station_at_rest_waits_for_manual() {
    let mut rig = Rig::new(alone(1, &[r(1), r(2)]));
    rig.mode(ControlMode::EStop);
    assert_eq!(rig.blocked_by(), ["manual, possible once the emergency stop is reset"]);
}

#[test]
fn the_emergency_stop_outlives_its_lease() {
    let mut rig = running();
    rig.mode(ControlMode::EStop);
    rig.silence_ms(10_000);
    assert_eq!(rig.controller.mode(), ControlMode::EStop);
}

#[test]
fn on_its_recovery_path_the_home_motion_too_is_stopped_by_the_emergency_stop() {
    let mut rig = Rig::new(alone(2, &[r(1), i(1, &[0]), r(2)]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.advance(false);
    rig.retract_through(0);
    rig.retract(true);
    assert!(rig.drives(2));
    rig.mode(ControlMode::EStop);
    assert_eq!(rig.outputs, 0);
    assert_eq!(
        rig.marking(),
        [StationPlace { op: OpId(2), block: Block::Normal, stage: linewright_line::net::MotionStage::Incomplete }]
    );
    assert!(rig.report().recovering_home);
    let _ = StationId(0);
}
