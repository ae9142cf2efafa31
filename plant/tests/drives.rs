//! The manager's side of a drive against the simulated drive: motions, their times and lengths, and the inputs.

use std::time::Duration;

use crate::drive_bench::{FAULT, HOME, LOST_MAX, Pair, described};
use linewright_canopen::profile::drive::DriveState;
use linewright_line::{AtRest, Drive as Described, DriveMode};
use linewright_plant::MotionFault;
use proptest::prelude::*;

fn millis(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn absolute() -> Described {
    described(AtRest::Off, false)
}

#[test]
fn an_output_moves_the_axis_to_its_target_and_the_input_says_so() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    assert_eq!(pair.inputs(), 0b001);
    pair.states.clear();
    pair.set(0b0010);
    pair.run(millis(1000), |pair| {
        let at = pair.inputs() & 0b010 != 0;
        assert!(!at || (pair.place() - 80.0).abs() <= 0.05);
    });
    assert_eq!((pair.inputs(), pair.place()), (0b010, 80.0));
    assert!(pair.drive.explain().starts_with("going to 80: there"), "{}", pair.drive.explain());
    pair.set(0);
    pair.run(millis(100), |pair| assert_eq!(pair.inputs(), 0b010));
    // It stood when it got the quick stop, so that state has ended as soon as it began.
    let way = [
        DriveState::ReadyToSwitchOn,
        DriveState::SwitchedOn,
        DriveState::OperationEnabled,
        DriveState::SwitchOnDisabled,
    ];
    assert_eq!(pair.states, way);
}

#[test]
fn letting_go_on_the_way_stops_it_and_switches_it_off() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    pair.set(0b1000);
    pair.run(millis(250), |_| {});
    assert_eq!(pair.speed(), 300.0);
    let place = pair.place();
    pair.set(0);
    pair.run(millis(200), |_| {});
    // 300 mm/s at 4000 mm/s²: 11.25 mm, and what it moved while the frame was under way.
    assert!((place + 11.25..place + 11.7).contains(&pair.place()), "{} after {place}", pair.place());
    assert_eq!((pair.speed(), pair.node.state()), (0.0, DriveState::SwitchOnDisabled));
    assert_eq!(pair.inputs(), 0);
    pair.set(0b1000);
    pair.run(millis(500), |_| {});
    assert_eq!((pair.place(), pair.inputs()), (100.0, 0b100));
}

#[test]
fn a_drive_whose_manager_is_gone_stops_by_itself() {
    for (at_rest, end) in [(AtRest::Off, DriveState::SwitchOnDisabled), (AtRest::Hold, DriveState::QuickStopActive)] {
        let mut pair = Pair::new(Described { velocity: 40.0, ..described(at_rest, false) }, 0.0, 1);
        pair.described.targets[3].velocity = 40.0;
        let mut described = pair.described.clone();
        described.targets.iter_mut().for_each(|target| target.velocity = 40.0);
        let mut pair = Pair::new(described, 0.0, 1);
        pair.set(0b1000);
        pair.run(millis(500), |_| {});
        assert_eq!(pair.speed(), 40.0);
        pair.alive = false;
        pair.run(millis(260), |_| {});
        assert_eq!((pair.speed(), pair.node.state()), (0.0, end));
        let place = pair.place();
        assert!(place < 40.0);
        // It is back, brings the drive up, and the order that is still on is not obeyed.
        pair.alive = true;
        pair.drive.lost(pair.now);
        pair.hear("000#0105");
        pair.run(millis(500), |_| {});
        assert_eq!(pair.place(), place);
        assert_eq!(pair.inputs() & FAULT, FAULT);
        pair.set(0);
        pair.set(0b1000);
        pair.run(millis(3000), |_| {});
        assert_eq!(pair.place(), 100.0, "{}", pair.drive.explain());
    }
}

#[test]
fn a_stuck_axis_trips_and_is_reset_only_when_its_output_is_off() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    pair.set(0b0010);
    pair.run(millis(100), |_| {});
    pair.fail(Some(MotionFault::Stick));
    pair.run(millis(500), |_| {});
    assert_eq!(pair.node.state(), DriveState::Fault);
    assert_eq!(pair.emergencies, [0x8611]);
    assert_eq!(pair.inputs(), FAULT);
    assert!(pair.drive.explain().contains("8611h (following error)"), "{}", pair.drive.explain());
    pair.run(millis(3000), |pair| assert_eq!(pair.node.state(), DriveState::Fault));
    pair.fail(None);
    let place = pair.place();
    pair.set(0);
    pair.run(millis(500), |_| {});
    assert_eq!((pair.node.state(), pair.inputs(), pair.place()), (DriveState::SwitchOnDisabled, 0, place));
    assert_eq!(pair.emergencies, [0x8611, 0]);
    pair.set(0b0010);
    pair.run(millis(1000), |_| {});
    assert_eq!(pair.inputs(), 0b010);
}

#[test]
fn a_motion_that_sticks_leaves_the_others_alone() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    pair.fail_motion(1, Some(MotionFault::Stick));
    pair.set(0b0010);
    pair.run(millis(500), |_| {});
    assert_eq!((pair.place(), pair.inputs()), (0.0, FAULT | 0b001));
    pair.set(0);
    pair.run(millis(500), |_| {});
    pair.set(0b1000);
    pair.run(millis(1000), |_| {});
    assert_eq!((pair.place(), pair.inputs()), (100.0, 0b100));
    // Back to where it sticks, it stays.
    pair.set(0);
    pair.run(millis(50), |_| {});
    pair.set(0b0010);
    pair.run(millis(500), |_| {});
    assert_eq!((pair.place(), pair.inputs()), (100.0, FAULT | 0b100));
}

#[test]
fn an_encoder_that_breaks_at_rest_is_a_fault_until_it_is_mended() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    pair.fail_motion(0, Some(MotionFault::Break));
    pair.run(millis(100), |_| {});
    assert_eq!((pair.node.state(), pair.inputs() & FAULT), (DriveState::Fault, FAULT));
    assert_eq!(pair.emergencies, [0x7305]);
    pair.run(millis(3000), |pair| assert_eq!(pair.node.state(), DriveState::Fault, "it is not reset"));
    pair.fail_motion(0, None);
    pair.run(millis(1500), |_| {});
    assert_eq!(pair.inputs(), 0b001);
    pair.set(0b0010);
    pair.run(millis(1000), |_| {});
    assert_eq!(pair.inputs(), 0b010);
}

#[test]
fn the_output_of_a_target_may_home_first() {
    let mut described = described(AtRest::Off, true);
    if let Some(homing) = &mut described.homing {
        homing.output = described.targets[0].output;
        homing.offset = 5.0;
    }
    // The switch stands at 5 of the drive's axis, so its zero is 5 below the mechanical one.
    let mut pair = Pair::new(described, 37.0, 1);
    pair.set(0b0001);
    pair.run(millis(5000), |_| {});
    assert_eq!((pair.inputs(), pair.place()), (0b1_0001, -5.0));
}

#[test]
fn a_velocity_holds_as_long_as_its_output() {
    let mut described = Described { mode: DriveMode::Velocity, window: 5.0, ..absolute() };
    described.targets.truncate(2);
    let mut pair = Pair::new(described, 0.0, 1);
    assert_eq!(pair.inputs(), 0b01, "it turns at 0");
    pair.set(0b10);
    pair.run(millis(500), |_| {});
    assert_eq!((pair.inputs(), pair.speed()), (0b10, 80.0));
    pair.set(0);
    pair.run(millis(200), |_| {});
    assert_eq!((pair.inputs(), pair.speed()), (0b01, 0.0));
    assert_eq!(pair.node.state(), DriveState::SwitchOnDisabled);
}

#[test]
fn a_drive_found_running_is_taken_over_without_a_jump() {
    let mut pair = Pair::new(absolute(), 0.0, 1);
    pair.set(0b1000);
    pair.run(millis(200), |_| {});
    // A new manager, without any of that history, with an order for the other end.
    pair.drive = linewright_canopen::profile::drive::ManagedDrive::new(pair.drive.binding().clone());
    let place = pair.place();
    pair.set(0b0001);
    pair.run(millis(1500), |pair| assert!(pair.place() < place + 14.0, "on to the old target"));
    assert_eq!((pair.place(), pair.inputs()), (0.0, 0b001));
}

/// Action on the pair.
#[derive(Clone, Debug)]
enum Act {
    Image(u128),
    Stick,
    Break,
    Repair,
    Loss(u32),
    /// Stopped and started by a technician's tool.
    PreOperational,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        10 => (0u32..5).prop_map(|output| Act::Image(1 << output)),
        6 => Just(Act::Image(0)),
        1 => (0u128..32).prop_map(Act::Image),
        1 => Just(Act::Stick),
        1 => Just(Act::Break),
        2 => Just(Act::Repair),
        2 => (0u32..160).prop_map(Act::Loss),
        1 => Just(Act::PreOperational),
    ]
}

/// Longest time a lost word takes to be made good, and a frame to arrive.
const DEAF: Duration = Duration::from_millis(50 * (LOST_MAX as u64 + 1) + 2);
/// Time to stop from full speed, and the distance, at the softest ramp.
const BRAKE: Duration = Duration::from_millis(150);
const BRAKE_MM: f64 = 300.0 * 300.0 / (2.0 * 2000.0);

/// Invariants after every event.
fn holds(pair: &Pair) {
    let image = pair.image;
    // Without a homing its output has no effect.
    let outputs = if pair.described.homing.is_some() { 5 } else { 4 };
    let asked: Vec<usize> = (0..outputs).filter(|output| image >> output & 1 == 1).collect();
    let for_long = pair.now.since(pair.since.0) > DEAF + BRAKE;
    let place = pair.place();
    // Motion only while one output is on.
    if asked.len() != 1 && for_long {
        assert_eq!(pair.speed(), 0.0, "{image:05b}: {}", pair.drive.explain());
    }
    // Never further past a target than it takes to stop; a word that was lost may let the one before go on.
    if let [output @ 0..=3] = asked[..]
        && pair.now.since(pair.since.0) > DEAF + BRAKE
    {
        let to = pair.described.targets[output].to;
        let from = pair.since.1;
        let deaf = 300.0 * DEAF.as_secs_f64() + BRAKE_MM + 0.05;
        let (low, high) = (to.min(from) - deaf, to.max(from) + deaf);
        assert!((low..=high).contains(&place), "{place} on the way from {from} to {to}");
    }
    let margin = BRAKE_MM + 0.05;
    assert!((-margin..=100.0 + margin).contains(&place), "{place} is outside of everything it was sent to");
    // An input is never wrongly on; while nothing moves, not by a hair.
    for (input, target) in [(0, 0.0), (1, 80.0), (2, 100.0)] {
        let slack = if pair.speed() == 0.0 && for_long { 0.0 } else { 300.0 * DEAF.as_secs_f64() };
        if pair.inputs() >> input & 1 == 1 {
            assert!((place - target).abs() <= 0.0505 + slack, "{place} is not {target}: {}", pair.drive.explain());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_is_ordered_and_lost_it_moves_only_under_an_order_and_ends_where_it_was_sent(
        acts in prop::collection::vec((act(), 1u64..700), 1..14),
        hold in any::<bool>(),
        homing in any::<bool>(),
        start in 0.0..100.0f64,
        seed in any::<u64>(),
        last in 0usize..4,
    ) {
        let at_rest = if hold { AtRest::Hold } else { AtRest::Off };
        let mut pair = Pair::new(described(at_rest, homing), start, seed);
        for (act, span) in acts {
            match act {
                Act::Image(image) => pair.set(image),
                Act::Stick => pair.fail(Some(MotionFault::Stick)),
                Act::Break => pair.fail(Some(MotionFault::Break)),
                Act::Repair => pair.fail(None),
                Act::Loss(loss) => pair.loss = loss,
                Act::PreOperational => {
                    pair.hear("000#8005");
                    pair.set(0);
                    pair.drive.lost(pair.now);
                    pair.run(millis(200), holds);
                    pair.hear("000#0105");
                }
            }
            pair.run(millis(span), holds);
        }
        // All well again: it obeys.
        pair.loss = 0;
        pair.fail(None);
        pair.set(0);
        pair.run(millis(1600), holds);
        prop_assert_eq!(pair.speed(), 0.0);
        prop_assert_eq!(pair.inputs() & FAULT, 0, "{}", pair.drive.explain());
        if homing {
            pair.set(HOME);
            pair.run(millis(12_000), holds);
            prop_assert_eq!(pair.inputs() & HOME, HOME, "{}", pair.drive.explain());
            pair.set(0);
            pair.run(millis(50), holds);
        }
        pair.set(1 << last);
        pair.run(millis(3000), holds);
        let target = pair.described.targets[last];
        prop_assert_eq!(pair.inputs() >> target.at.0 & 1, 1, "{}", pair.drive.explain());
        prop_assert!((pair.place() - target.to).abs() <= 0.05);
        let place = pair.place();
        pair.set(0);
        pair.run(millis(500), holds);
        prop_assert_eq!(pair.place(), place);
    }
}
