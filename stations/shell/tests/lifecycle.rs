//! A node that is not active: off at once, deaf to orders, and after activity as after a restart.

use std::time::Duration;

use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode::{Auto, EStop, Manual, StandBy};
use linewright_station_logic::{Rules, StopCause};
use linewright_station_shell::StationEffect;
use proptest::prelude::*;

use crate::rig::{ADVANCE, FOLLOWED, LIFE, OTHER, Rig};

/// As a node performs it.
fn deactivate(rig: &mut Rig, life: u64) {
    rig.shell.deactivate(LifecycleState::Inactive, &mut rig.effects);
    rig.shell = rig.shell.renewed(&rig.line, life).expect("it compiles").with_rules(Rules::COUNTS);
}

/// No output was put on.
fn is_off(rig: &Rig) -> bool {
    rig.effects.iter().all(|effect| !matches!(effect, StationEffect::Drive(image) if image.bits != 0))
}

/// No motion was driven; a lamp may be on.
fn is_still(rig: &Rig) -> bool {
    rig.effects.iter().all(|effect| !matches!(effect, StationEffect::Drive(image) if rig.motion(image.bits) != 0))
}

#[test]
fn it_lets_go_of_everything_at_once_and_what_moved_is_stopped() {
    let mut rig = Rig::new();
    rig.close();
    deactivate(&mut rig, LIFE + 1);
    assert_eq!(rig.kinds(), ["off", "tell"], "before anything is recorded");
    assert!(is_off(&rig));
    rig.effects.clear();
    rig.act();
    let report = rig.shell.controller().report();
    assert_eq!(report.incomplete, [(ADVANCE, StopCause::Restart)]);
    assert!(report.stopped && report.boot_id == LIFE + 1);
    assert!(rig.kinds().contains(&"remember"), "{:?}", rig.kinds());
}

#[test]
fn it_follows_no_order_and_no_button_and_every_image_is_off() {
    let mut rig = Rig::new();
    rig.close();
    deactivate(&mut rig, LIFE + 1);
    rig.effects.clear();
    for (epoch, mode) in [(6, Manual), (7, Auto), (8, Manual), (9, EStop)] {
        rig.inputs(false);
        rig.refresh(epoch, mode);
        rig.pass(Duration::from_millis(300));
        rig.advance(false);
        rig.advance(true);
        rig.act();
        assert_eq!(rig.mode(), StandBy);
    }
    assert!(is_off(&rig) && rig.kinds().contains(&"off"), "{:?}", rig.kinds());
}

#[test]
fn activity_alone_puts_nothing_on_and_orders_to_the_life_before_are_none() {
    let mut rig = Rig::new();
    rig.close();
    deactivate(&mut rig, LIFE + 1);
    rig.effects.clear();
    rig.pass(Duration::from_secs(2));
    assert!(rig.shell.activate(rig.now));
    for _ in 0..5 {
        rig.sequence += 1;
        rig.order_to(LIFE, rig.sequence, (FOLLOWED, 5, Manual));
        rig.inputs(false);
        rig.advance(true);
        rig.pass(Duration::from_millis(50));
    }
    assert_eq!(rig.mode(), StandBy);
    assert!(is_still(&rig));
    // An order that names this life is followed, and a press after it moves the clamp.
    rig.order(OTHER, 6, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
    assert!(is_still(&rig), "the button was held before");
    for held in [false, true] {
        rig.refresh(6, Manual);
        rig.inputs(false);
        rig.advance(held);
        rig.act();
    }
    assert!(!is_still(&rig));
}

#[test]
fn a_request_to_activate_from_before_a_standstill_counts_for_nothing() {
    let mut rig = Rig::new();
    deactivate(&mut rig, LIFE + 1);
    rig.pass(Duration::from_secs(1));
    rig.stand_still(Duration::from_secs(60));
    assert!(!rig.shell.activate(rig.now));
    assert!(!rig.shell.is_active());
    rig.pass(Duration::from_secs(1));
    assert!(rig.shell.activate(rig.now));
}

#[test]
fn what_is_not_active_stays_so_through_another_life() {
    let rig = Rig::new();
    let shell = rig.shell.renewed(&rig.line, 70).expect("it compiles");
    assert_eq!(shell.lifecycle(), LifecycleState::Inactive, "out of activity");
    let mut finalized = shell;
    finalized.stay_inactive(rig.now, LifecycleState::Finalized);
    let shell = finalized.renewed(&rig.line, 71).expect("it compiles");
    assert_eq!(shell.lifecycle(), LifecycleState::Finalized);
    finalized.stay_inactive(rig.now, LifecycleState::Active);
    assert!(!finalized.is_active(), "by activate alone");
}

#[derive(Clone, Copy, Debug)]
enum Act {
    Deactivate,
    Activate,
    Order(u64, bool),
    Advance(bool),
    Inputs(bool),
    Pass(u64),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        1 => Just(Act::Deactivate),
        2 => Just(Act::Activate),
        4 => (0u64..3, any::<bool>()).prop_map(|(life, is_manual)| Act::Order(life, is_manual)),
        3 => any::<bool>().prop_map(Act::Advance),
        3 => any::<bool>().prop_map(Act::Inputs),
        2 => (1u64..1500).prop_map(Act::Pass),
    ]
}

proptest! {
    #[test]
    fn nothing_is_on_while_it_is_not_active_nor_before_an_order_to_its_life(acts in prop::collection::vec(act(), 1..80)) {
        let mut rig = Rig::new();
        rig.close();
        let (mut life, mut epoch, mut is_ordered) = (LIFE, 5, true);
        for act in acts {
            rig.effects.clear();
            match act {
                Act::Deactivate if rig.shell.is_active() => {
                    life += 1;
                    deactivate(&mut rig, life);
                    is_ordered = false;
                }
                Act::Deactivate => {}
                Act::Activate => {
                    rig.shell.activate(rig.now);
                }
                Act::Order(back, is_manual) => {
                    // To this life, or to one of those before.
                    epoch += 1;
                    let to = life.saturating_sub(back).max(LIFE);
                    rig.sequence += 1;
                    rig.order_to(to, rig.sequence, (FOLLOWED, epoch, if is_manual { Manual } else { StandBy }));
                    is_ordered |= to == life && rig.shell.is_active();
                }
                Act::Advance(held) => rig.advance(held),
                Act::Inputs(is_open) => rig.inputs(is_open),
                Act::Pass(time) => rig.pass(Duration::from_millis(time)),
            }
            rig.act();
            prop_assert!(rig.shell.is_active() || is_off(&rig), "{:?}: {:?}", act, rig.effects);
            prop_assert!(is_ordered || is_still(&rig), "{:?}: {:?}", act, rig.effects);
        }
    }
}
