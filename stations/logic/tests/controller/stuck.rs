//! A limit switch that is stuck on: what the switch at the other end of the motion says to it.
//!
//! ```text
//!   LS_open  ●───────── clamp ─────────●  LS_closed, stuck on
//! ```

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId, Tick};
use linewright_station_logic::{Restore, StationInput};

use super::rig::Rig;
use linewright_testkit::built::transfer_line;

const CLAMP: StationId = StationId(1);
const CLOSE: OpId = OpId(1);

/// The clamp of the shipped line by itself.
struct Clamp {
    rig: Rig,
    open: u128,
    closed: u128,
}

impl Clamp {
    fn up(restore: Restore, on: &[&str]) -> Self {
        let line = transfer_line();
        let names = line.station(CLAMP).inputs.clone();
        let bit = |name: &str| 1u128 << names.iter().position(|input| input == name).expect("an input");
        let image = on.iter().fold(0, |bits, name| bits | bit(name));
        let rig = Rig::alone(line, CLAMP, restore, image);
        Clamp { rig, open: bit("LS_open"), closed: bit("LS_closed") }
    }

    /// Stopped by the watchdog, with `LS_closed` on from the start.
    fn stuck(has_moved: bool) -> Self {
        let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
        clamp.rig.set(clamp.closed, true);
        clamp.rig.mode(ControlMode::Auto);
        assert!(!clamp.rig.report().stopped);
        if has_moved {
            clamp.rig.set(clamp.open, false);
        }
        clamp.rig.wait_ms(5000);
        assert!(clamp.rig.report().stopped);
        clamp.rig.mode(ControlMode::Manual);
        clamp
    }

    fn fault(&self) -> String {
        self.rig.fault()
    }

    fn closes(&self) -> i32 {
        self.rig.report().done[CLOSE.index()]
    }

    fn advance(&mut self) {
        self.rig.advance(true);
        self.rig.wait_ms(100);
        self.rig.advance(false);
    }
}

#[test]
fn a_clamp_that_has_not_left_its_open_switch_is_not_closed_whatever_the_other_switch_says() {
    let mut clamp = Clamp::stuck(false);
    assert!(clamp.fault().contains("LS_closed ("), "{}", clamp.fault());
    assert!(clamp.fault().contains(") and LS_open ("), "{}", clamp.fault());
    assert!(clamp.fault().contains("are both on"), "{}", clamp.fault());
    for _ in 0..3 {
        clamp.advance();
        assert_eq!((clamp.closes(), clamp.rig.doing().as_str()), (0, "advance clamp (stopped)"));
    }
    // Held on, it is driven until the watchdog reports it again.
    clamp.rig.advance(true);
    clamp.rig.wait_ms(5000);
    clamp.rig.advance(false);
    assert!(clamp.fault().contains("are both on"), "{}", clamp.fault());
    assert_eq!(clamp.closes(), 0);
    // Not after a restart either.
    let mut again = Clamp::up(Restore::From(clamp.rig.controller.snapshot()), &["LS_open", "LS_closed"]);
    again.rig.mode(ControlMode::Manual);
    again.advance();
    assert_eq!((again.closes(), again.rig.doing().as_str()), (0, "advance clamp (stopped)"));
    // Nor is it open while both are on.
    again.rig.retract(true);
    again.rig.wait_ms(100);
    again.rig.retract(false);
    assert_eq!(again.rig.doing(), "undoing advance clamp (stopped)");
    // Repaired, the clamp may as well have left a closed switch that sticks: the open one was not seen off. Held until the
    // watchdog says so, and once more, it is open.
    again.rig.set(again.closed, false);
    for doing in ["undoing advance clamp (stopped)", "advance clamp (undone)"] {
        again.rig.retract(true);
        again.rig.wait_ms(5000);
        again.rig.retract(false);
        assert_eq!(again.rig.doing(), doing);
    }
}

/// Let go before the watchdog reports it anew, it is stopped by the switches as before: they are still both on.
#[test]
fn released_between_two_switches_that_are_on_it_keeps_its_cause() {
    let mut clamp = Clamp::stuck(false);
    clamp.advance();
    assert_eq!(clamp.rig.doing(), "advance clamp (stopped)");
    assert!(clamp.fault().contains("are both on"), "{}", clamp.fault());
    // Repaired, it is stopped by its button.
    clamp.rig.set(clamp.closed, false);
    clamp.advance();
    assert_eq!(clamp.rig.doing(), "advance clamp (stopped)");
    assert_eq!(clamp.fault(), "");
    // Both on again, it was not stopped by them.
    clamp.rig.set(clamp.closed, true);
    clamp.advance();
    assert_eq!(clamp.fault(), "");
}

#[test]
fn repaired_it_is_led_on_at_once() {
    let mut clamp = Clamp::stuck(false);
    clamp.rig.set(clamp.closed, false);
    clamp.rig.advance(true);
    clamp.rig.set(clamp.open, false);
    clamp.rig.set(clamp.closed, true);
    assert_eq!(clamp.closes(), 1);
}

/// A switch that sticks says nothing of how far the clamp was led: only its watchdog's whole time does.
#[test]
fn led_on_a_little_at_a_time_it_is_not_closed_half_way() {
    let mut clamp = Clamp::stuck(false);
    clamp.advance();
    clamp.rig.set(clamp.open, false);
    for _ in 0..3 {
        clamp.advance();
        assert_eq!(clamp.closes(), 0);
    }
}

#[test]
fn a_clamp_that_really_arrived_at_a_stuck_switch_is_led_on_after_the_report_and_after_a_restart() {
    let mut clamp = Clamp::stuck(true);
    assert!(clamp.fault().contains("was on before the motion started"), "{}", clamp.fault());
    let mut again = Clamp::up(Restore::From(clamp.rig.controller.snapshot()), &["LS_closed"]);
    clamp.advance();
    assert_eq!(clamp.closes(), 1);
    again.rig.mode(ControlMode::Manual);
    again.advance();
    assert_eq!(again.closes(), 1);
}

/// The clamp has not begun to move, and its other switch flickers.
#[test]
fn a_switch_that_comes_on_while_the_one_behind_is_on_completes_nothing() {
    let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
    clamp.rig.mode(ControlMode::Auto);
    for on in [true, false, true, false] {
        clamp.rig.set(clamp.closed, on);
        assert_eq!((clamp.closes(), clamp.rig.report().stopped), (0, false));
    }
    // Really moved, it is complete as ever.
    clamp.rig.set(clamp.open, false);
    assert_eq!(clamp.closes(), 0);
    clamp.rig.set(clamp.closed, true);
    assert_eq!(clamp.closes(), 1);

    // Nothing moves at all: the fault is by what is on when the time is over.
    for (closed, fault) in [(true, "are both on"), (false, "not on within")] {
        let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
        clamp.rig.mode(ControlMode::Auto);
        clamp.rig.set(clamp.closed, true);
        clamp.rig.set(clamp.closed, closed);
        clamp.rig.wait_ms(5000);
        assert_eq!(clamp.closes(), 0);
        assert!(clamp.fault().contains(fault), "{}", clamp.fault());
        // Looked at and led on it is complete where it really arrives.
        clamp.rig.mode(ControlMode::Manual);
        clamp.rig.set(clamp.closed, false);
        clamp.rig.advance(true);
        clamp.rig.set(clamp.open, false);
        clamp.rig.set(clamp.closed, true);
        assert_eq!(clamp.closes(), 1);
    }
}

/// The same on the way back.
#[test]
fn a_way_back_does_not_end_while_the_switch_it_leaves_is_on() {
    let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
    clamp.rig.mode(ControlMode::Auto);
    clamp.rig.set(clamp.open, false);
    clamp.rig.mode(ControlMode::Manual);
    clamp.rig.set(clamp.closed, true);
    clamp.rig.advance(true);
    clamp.rig.advance(false);
    assert_eq!(clamp.closes(), 1);
    clamp.rig.retract(true);
    clamp.rig.set(clamp.open, true);
    assert_eq!(clamp.rig.doing(), "undoing advance clamp", "the switch it leaves is on");
    clamp.rig.set(clamp.open, false);
    clamp.rig.set(clamp.closed, false);
    clamp.rig.set(clamp.open, true);
    assert_eq!(clamp.rig.doing(), "advance clamp (undone)");
}

/// Of a short stroke both switches may be on in the middle: a switch that was seen off is believed where the other one goes off,
/// and one that was not needs the report.
#[test]
fn switches_that_overlap_complete_a_motion_where_the_one_behind_goes_off() {
    let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
    clamp.rig.mode(ControlMode::Auto);
    clamp.rig.set(clamp.closed, true);
    assert_eq!(clamp.closes(), 0, "both are on");
    clamp.rig.set(clamp.open, false);
    assert_eq!(clamp.closes(), 1, "seen off, it has come on");

    // Let go in the middle, it is driven to its end, reported once, and then it is there.
    let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
    clamp.rig.mode(ControlMode::Manual);
    clamp.rig.advance(true);
    clamp.rig.set(clamp.closed, true);
    clamp.rig.advance(false);
    clamp.rig.advance(true);
    clamp.rig.set(clamp.open, false);
    assert_eq!(clamp.closes(), 0);
    clamp.rig.wait_ms(5000);
    clamp.rig.advance(false);
    clamp.advance();
    assert_eq!(clamp.closes(), 1);

    let mut clamp = Clamp::up(Restore::Fresh, &["LS_open"]);
    clamp.rig.mode(ControlMode::Auto);
    let mut again = Clamp::up(Restore::From(clamp.rig.controller.snapshot()), &["LS_open", "LS_closed"]);
    again.rig.mode(ControlMode::Manual);
    again.rig.advance(true);
    again.rig.set(again.open, false);
    again.rig.wait_ms(5000);
    again.rig.advance(false);
    assert_eq!(again.closes(), 0, "which of the two told the truth is not known");
    again.advance();
    assert_eq!(again.closes(), 1, "the open switch is off");
}

/// Images are older than the outputs.
#[test]
fn an_image_from_before_the_motion_decides_nothing() {
    for (open, arrives) in [(true, false), (false, true)] {
        let clamp = Clamp::stuck(!open);
        let mut again = Clamp::up(Restore::From(clamp.rig.controller.snapshot()), &["LS_closed"]);
        let bits = again.closed | if open { again.open } else { 0 };
        again.rig.mode(ControlMode::Manual);
        let image = |under| StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under };
        let now = again.rig.now;
        again.rig.controller.handle(now, image(again.rig.out.number));
        again.rig.step();
        again.rig.advance(true);
        assert!(!again.rig.report().stopped);
        again.rig.controller.handle(now, image(again.rig.out.number));
        again.rig.step();
        assert_eq!(again.closes(), i32::from(arrives));
    }
}

#[test]
fn what_is_done_by_the_other_switch_alone_is_said_until_the_stuck_one_is_seen_off() {
    let mut clamp = Clamp::stuck(true);
    assert!(!clamp.fault().contains("done by"), "{}", clamp.fault());
    clamp.rig.advance(true);
    clamp.rig.wait_ms(100);
    clamp.rig.advance(false);
    assert_eq!(clamp.closes(), 1);
    let fault = clamp.fault();
    assert!(fault.starts_with("advance clamp: done by LS_open ("), "{fault}");
    assert!(fault.contains(") off alone; LS_closed ("), "{fault}");
    assert!(fault.ends_with(") was on from the start: check that switch"), "{fault}");
    clamp.rig.wait_ms(5000);
    assert_eq!(clamp.fault(), fault);
    clamp.rig.set(clamp.closed, false);
    assert!(!clamp.fault().contains("done by"), "{}", clamp.fault());
}
