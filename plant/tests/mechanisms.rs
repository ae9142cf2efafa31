//! The mechanisms by themselves: where they stand, when their switches change, how they fail.

use std::time::Duration;

use linewright_line::{InputId, OutputId, Owner, Tick};
use linewright_plant::{MotionFault, Plant, PlantOptions};
use linewright_testkit::presses::*;
use proptest::prelude::*;

const OWNER: Owner = Owner::Station(PRESS);

fn plant() -> Plant {
    Plant::new(&line(), PlantOptions::default())
}

fn at(millis: u64) -> Tick {
    Tick::from_millis(millis)
}

#[test]
fn a_motion_presses_its_switches_at_its_time() {
    let mut plant = plant();
    assert_eq!(plant.inputs(OWNER), BACK);
    assert_eq!(plant.next_change(), None, "nothing moves by itself");
    plant.set_outputs(at(1000), OWNER, FORWARD);
    // Out of the back switch's reach after a thousandth of the way, just over 0.2 ms.
    let left = plant.next_change().unwrap();
    plant.advance(left);
    assert_eq!(plant.inputs(OWNER), 0);
    assert_eq!(left, Tick::from_micros(1_000_201));
    let arrived = plant.next_change().unwrap();
    plant.advance(arrived);
    assert_eq!(plant.inputs(OWNER), FRONT);
    assert!(arrived <= at(1200) && arrived >= at(1199), "{arrived}");
    plant.advance(at(9000));
    assert_eq!((plant.position(PRESS, RAM), plant.next_change()), (80.0, None), "it stops at its target");
    plant.set_outputs(at(9000), OWNER, RETURN);
    plant.advance(at(9100));
    assert_eq!((plant.position(PRESS, RAM), plant.inputs(OWNER)), (0.0, BACK));
}

/// Under way its switch is off, and at every place of the table it is at home.
#[test]
fn an_index_goes_from_its_switch_to_its_switch_and_rests_there_until_its_output_comes_on_again() {
    let text = include_str!("../../examples/rotary-table.toml");
    let line = linewright_line::parse("rotary-table.toml", text).expect("the example is sound").line;
    let table = linewright_line::StationId(0);
    let index = linewright_line::OpId(0);
    const IN_PLACE: u128 = 1;
    const FAILED: u128 = 2;
    let mut plant = Plant::new(&line, PlantOptions::default());
    let axis = linewright_line::AxisId(0);
    assert_eq!(plant.inputs(OWNER), IN_PLACE);
    for round in 0..3 {
        let start = 3000 * round;
        plant.set_outputs(at(start), OWNER, 1);
        let left = plant.next_change().expect("it sets out");
        plant.advance(left);
        assert!(left <= at(start + 2), "{left}");
        assert_eq!(plant.inputs(OWNER), 0);
        plant.advance(at(start + 500));
        assert!((plant.position(table, axis) - 45.0).abs() < 0.2, "{}", plant.position(table, axis));
        let arrived = plant.next_change().expect("it arrives");
        plant.advance(arrived);
        assert!(arrived > at(start + 998) && arrived <= at(start + 1001), "{arrived}");
        assert_eq!(plant.inputs(OWNER), IN_PLACE);
        // Let go at its switch, or somewhat later: the gear holds it.
        let let_go = if round == 1 { arrived } else { at(start + 1700) };
        plant.set_outputs(let_go, OWNER, 0);
        plant.advance(at(start + 2900));
        assert_eq!((plant.inputs(OWNER), plant.next_change()), (IN_PLACE, None));
        assert!(plant.position(table, axis).abs() < 0.2, "{}", plant.position(table, axis));
    }
    // Stopped half-way it stays there, and goes on.
    for (fault, inputs) in [(MotionFault::Stick, 0), (MotionFault::SlipBack, 0), (MotionFault::Break, FAILED)] {
        let mut plant = Plant::new(&line, PlantOptions::default());
        plant.set_outputs(at(0), OWNER, 1);
        plant.inject(at(500), table, index, Some(fault));
        plant.advance(at(5000));
        assert_eq!(plant.inputs(OWNER), inputs, "{fault:?}");
        plant.set_outputs(at(5000), OWNER, 0);
        plant.inject(at(5000), table, index, None);
        plant.set_outputs(at(6000), OWNER, 1);
        plant.advance(at(6400));
        assert_eq!(plant.inputs(OWNER), 0, "{fault:?}");
        plant.advance(at(6600));
        assert_eq!(plant.inputs(OWNER), IN_PLACE, "{fault:?}");
    }
    // It does not set out at all.
    let mut plant = Plant::new(&line, PlantOptions::default());
    plant.inject(at(0), table, index, Some(MotionFault::Stick));
    plant.set_outputs(at(0), OWNER, 1);
    plant.advance(at(5000));
    assert_eq!((plant.inputs(OWNER), plant.alarms()), (IN_PLACE, 0));
}

/// A drive that is stuck just before the place it was ordered to goes on to that one.
#[test]
fn a_drive_stuck_before_its_place_does_not_go_on_to_the_one_after_it() {
    let text = include_str!("../../examples/driven-table.toml");
    let line = linewright_line::parse("driven-table.toml", text).expect("the example is sound").line;
    let (table, axis, index) = (linewright_line::StationId(0), linewright_line::AxisId(0), linewright_line::OpId(0));
    let drive = line.devices.iter().find_map(|device| device.drive());
    let places = drive.and_then(|drive| drive.index.as_ref()).expect("a drive with numbered places");
    let turn = line.operation((table, index)).normal.actuator.bit();
    for part in [0.9984, 0.9986, 0.99875, 0.9989, 0.9991] {
        let mut plant = Plant::new(&line, PlantOptions::default());
        plant.set_outputs(at(0), OWNER, turn | places.order(2));
        let whole = line.operation((table, index)).duration.as_micros() as f64;
        let stuck = Tick::from_micros((whole * part) as u64);
        plant.inject(stuck, table, index, Some(MotionFault::Stick));
        plant.inject(stuck + Duration::from_secs(1), table, index, None);
        plant.advance(stuck + Duration::from_secs(9));
        assert_eq!((plant.indexes(table, axis), plant.next_change()), (1, None), "{part}");
    }
}

#[test]
fn a_motion_goes_on_where_it_was_left() {
    let mut plant = plant();
    plant.set_outputs(at(0), OWNER, FORWARD);
    plant.set_outputs(at(50), OWNER, 0);
    plant.advance(at(500));
    assert_eq!(plant.position(PRESS, RAM), 20.0);
    plant.set_outputs(at(500), OWNER, FORWARD);
    plant.advance(at(650));
    assert_eq!(plant.inputs(OWNER), FRONT);
}

#[test]
fn drives_both_ways_stand_still_and_raise_one_alarm() {
    let mut plant = plant();
    plant.set_outputs(at(0), OWNER, FORWARD);
    plant.set_outputs(at(100), OWNER, FORWARD | RETURN);
    plant.advance(at(1000));
    assert_eq!((plant.position(PRESS, RAM), plant.alarms()), (40.0, 1));
    plant.set_outputs(at(1000), OWNER, RETURN);
    plant.advance(at(1050));
    assert_eq!((plant.position(PRESS, RAM), plant.alarms()), (0.0, 1));
}

#[test]
fn faults_stop_slow_break_and_slip_back() {
    for (fault, position, inputs) in [
        (MotionFault::Stick, 40.0, 0),
        (MotionFault::Slip, 50.0, 0),
        (MotionFault::Break, 40.0, FAILED),
        (MotionFault::SlipBack, 30.0, 0),
    ] {
        let mut plant = plant();
        plant.set_outputs(at(0), OWNER, FORWARD);
        plant.inject(at(100), PRESS, ADVANCE, Some(fault));
        plant.advance(at(200));
        assert_eq!((plant.position(PRESS, RAM), plant.inputs(OWNER)), (position, inputs), "{fault:?}");
        plant.inject(at(200), PRESS, ADVANCE, None);
        plant.advance(at(400));
        assert_eq!(plant.inputs(OWNER), FRONT, "{fault:?} is cleared");
    }
}

#[test]
fn the_other_way_is_free_while_one_is_stuck() {
    let mut plant = plant();
    plant.set_outputs(at(0), OWNER, FORWARD);
    plant.inject(at(100), PRESS, ADVANCE, Some(MotionFault::Stick));
    plant.set_outputs(at(200), OWNER, RETURN);
    plant.advance(at(250));
    assert_eq!(plant.inputs(OWNER), BACK);
    // By its output, both motions that use it are hit: here the return, and the undoing of the advance.
    plant.inject_output(at(250), OWNER, OutputId(0), None);
    plant.set_outputs(at(250), OWNER, FORWARD);
    plant.advance(at(450));
    plant.inject_output(at(450), OWNER, OutputId(1), Some(MotionFault::Stick));
    plant.set_outputs(at(450), OWNER, RETURN);
    plant.advance(at(900));
    assert_eq!(plant.position(PRESS, RAM), 80.0);
}

#[test]
fn a_finger_holds_an_input_whatever_the_mechanism_does() {
    let mut plant = plant();
    plant.force(OWNER, InputId(1), Some(false));
    plant.force(OWNER, InputId(3), Some(true));
    plant.force(Owner::Console, InputId(0), Some(true));
    assert_eq!((plant.inputs(OWNER), plant.inputs(Owner::Console)), (0b1000, 1));
    plant.force(OWNER, InputId(1), None);
    plant.force(OWNER, InputId(3), None);
    assert_eq!(plant.inputs(OWNER), BACK);
}

#[test]
fn one_output_may_serve_two_operations_in_a_row() {
    let mut line = line();
    let mut second = line.stations[0].operations[0].clone();
    second.motion.from = 80.0;
    second.motion.to = 100.0;
    second.normal.complete = InputId(3);
    second.duration = Duration::from_millis(100);
    line.stations[0].operations.push(second);
    let run = |step: Duration| {
        let mut plant = Plant::new(&line, PlantOptions::default());
        plant.set_outputs(at(0), OWNER, FORWARD);
        while plant.now() < at(250) {
            plant.advance(plant.now() + step);
        }
        plant.position(PRESS, RAM)
    };
    // 200 ms to 80, then on at 0.2 mm a millisecond.
    assert_eq!(run(Duration::from_millis(250)), 90.0);
    assert_eq!(run(Duration::from_millis(1)), 90.0);
}

/// Events of a plant: after so many microseconds, outputs or a fault.
fn any_happening() -> impl Strategy<Value = (u64, u128, u8)> {
    (0u64..150_000, 0u128..4, 0u8..8)
}

fn happen(plant: &mut Plant, now: Tick, outputs: u128, fault: u8) {
    plant.set_outputs(now, OWNER, outputs);
    if fault < 5 {
        plant.inject(now, PRESS, ADVANCE, MotionFault::from_code(fault.into()).unwrap());
    }
}

proptest! {
    // No file of failing cases: a case worth keeping becomes a test with a name.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_motion_ends_at_its_time_and_not_earlier(
        from in -1000.0..1000.0f64, target in -1000.0..1000.0f64, micros in 1000u64..100_000_000
    ) {
        prop_assume!((target - from).abs() > 1e-3);
        let mut line = line();
        let station = &mut line.stations[PRESS.index()];
        station.axes[RAM.index()].home = from;
        station.operations.truncate(1);
        (station.home, station.steps) = (ADVANCE, vec![vec![ADVANCE]]);
        let forward = &mut station.operations[ADVANCE.index()];
        (forward.motion.from, forward.motion.to) = (from, target);
        forward.duration = Duration::from_micros(micros);
        let mut plant = Plant::new(&line, PlantOptions::default());
        plant.set_outputs(Tick::ZERO, OWNER, FORWARD);
        plant.advance(Tick::from_micros(micros - 2));
        prop_assert!(plant.position(PRESS, RAM) != target);
        plant.advance(Tick::from_micros(micros + 1));
        prop_assert_eq!(plant.position(PRESS, RAM), target);
    }

    #[test]
    fn positions_stay_in_range_and_move_with_their_drive(
        happenings in prop::collection::vec(any_happening(), 1..40), seed: u64
    ) {
        let mut plant = Plant::new(&line(), PlantOptions { seed, variation: 0.3, ..PlantOptions::default() });
        let mut now = Tick::ZERO;
        for (micros, outputs, fault) in happenings {
            happen(&mut plant, now, outputs, fault);
            let mut before = plant.position(PRESS, RAM);
            for _ in 0..4 {
                now = now + Duration::from_micros(micros / 4 + 1);
                plant.advance(now);
                let here = plant.position(PRESS, RAM);
                prop_assert!((0.0..=80.0).contains(&here), "{here}");
                match outputs {
                    FORWARD if fault != 4 => prop_assert!(here >= before || fault >= 5),
                    RETURN => prop_assert!(here <= before),
                    FORWARD => {}
                    _ => prop_assert_eq!(here, before),
                }
                prop_assert!(plant.inputs(OWNER) & (FRONT | BACK) != FRONT | BACK);
                before = here;
            }
        }
    }

    #[test]
    fn fine_steps_coarse_steps_and_steps_by_event_agree_to_the_bit(
        happenings in prop::collection::vec(any_happening(), 1..20), seed: u64
    ) {
        let options = PlantOptions { seed, variation: 0.3, ..PlantOptions::default() };
        let mut plants = [0; 3].map(|_| Plant::new(&line(), options));
        let mut now = Tick::ZERO;
        for (micros, outputs, fault) in happenings {
            let next = now + Duration::from_micros(micros);
            for (at, plant) in plants.iter_mut().enumerate() {
                happen(plant, now, outputs, fault);
                match at {
                    0 => {}
                    1 => while plant.now() < next {
                        plant.advance(next.min(plant.now() + Duration::from_micros(997)));
                    },
                    _ => while let Some(change) = plant.next_change().filter(|c| *c < next) {
                        let before = plant.inputs(OWNER);
                        plant.advance(change - Duration::from_micros(1));
                        prop_assert_eq!(plant.inputs(OWNER), before, "no change is missed");
                        plant.advance(change);
                    },
                }
                plant.advance(next);
            }
            now = next;
            let seen = plants.each_ref().map(|p| (p.position(PRESS, RAM).to_bits(), p.inputs(OWNER), p.alarms()));
            prop_assert!(seen[0] == seen[1] && seen[1] == seen[2], "{seen:?}");
        }
    }
}
