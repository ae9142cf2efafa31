//! What the scenarios have found and the code under test does not do yet.
//!
//! Each is a minimal story that fails; `cargo test -p linewright-tests --test known_gaps -- --ignored` shows them.
//! Whoever closes a gap takes the `ignore` off and moves the story to its neighbours.

use std::time::Duration;

use linewright_coordinator_logic::Command;
use linewright_line::net::{ControlMode, Place};
use linewright_node_shell::NewestBySequence;
use linewright_tests::{Conditions, Sim, transfer_line};

/// Behind the gateway an input image is on its way for a while, and counts until it is stale. A station that takes a
/// stopped motion back looks at the switch "as it stands" in that image, and finds it as it was *before* the motion:
/// the clamp believes it is open, says so, and the bar lifts under a clamp that is three quarters closed.
///
/// An image would have to say which of the station's output images it was taken under; a stopped motion then ends
/// only on an image taken under the outputs that drive it.
#[test]
#[ignore = "an input image does not say which outputs it was taken under"]
fn a_motion_taken_back_is_not_ended_by_an_image_from_before_it() {
    let mut sim = Sim::new(&transfer_line(1.0), 1);
    sim.start_auto();
    let (transfer, lower) = sim.op("transfer", "4th lower");
    sim.run_until("the bar comes down", |s| s.marking(transfer) == [Place::operating(lower)]);
    sim.order(Command::EStop);
    sim.run_for(Duration::from_millis(100));
    sim.order(Command::Reset);
    sim.go_manual();
    sim.resume("transfer");
    let late = Conditions { delay_min_us: 190_000, delay_max_us: 200_000, ..Conditions::QUIET };
    sim.image_conditions(late);
    sim.run_for(Duration::from_millis(500));
    let clamp = sim.id("clamp_1");
    sim.press(clamp, true);
    // The output image takes 0.2 s to the gateway, the clamp 0.2 s to close.
    sim.run_for(Duration::from_millis(360));
    sim.release(clamp, true);
    sim.run_for(Duration::from_millis(5));
    sim.press(clamp, false);
    sim.run_for(Duration::from_millis(20));
    let advance = sim.op("clamp_1", "advance clamp").1;
    assert_ne!(sim.marking(clamp), [Place::undone(advance)], "the clamp has moved by now");
}

/// A coordinator comes up at home whatever the stations say, so replacing it is a way out of the emergency stop that
/// does not lead through manual. It would have to read from its journal that the stop was latched, or hear it from
/// the stations before it gives its first order.
#[test]
#[ignore = "the emergency stop is latched in the coordinator's memory alone"]
fn an_emergency_stop_is_not_left_by_replacing_the_coordinator() {
    let mut sim = Sim::new(&transfer_line(1.0), 2);
    sim.start();
    sim.order(Command::EStop);
    sim.run_for(Duration::from_millis(100));
    sim.kill_coordinator();
    sim.restart_coordinator(true);
    sim.settle();
    let auto = sim.ask(Command::Start).and_then(|()| sim.ask(Command::Auto));
    assert_eq!(sim.mode(), Some(ControlMode::EStop), "start and auto: {auto:?}");
}

/// A writer that is restarted twice within the time a message is on its way: the last word of its second life comes
/// after the first word of its third, counts as a fourth life, and its reader is deaf from then on.
#[test]
#[ignore = "boot ids have no order, so a boot never heard before counts as the newest"]
fn the_last_word_of_a_short_life_does_not_deafen_its_readers() {
    let mut newest = NewestBySequence::new();
    assert!(newest.offer(1, 500).is_newest());
    assert!(newest.offer(3, 1).is_newest());
    newest.offer(2, 1);
    assert!(newest.offer(3, 2).is_newest(), "the writer that lives is heard");
}
