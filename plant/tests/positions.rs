//! Positions that a plant keeps while its power is off: it stands where it stood, and whatever cannot be is refused.

use std::time::Duration;

use linewright_canopen::NodeId;
use linewright_line::{AxisId, DeviceBus, DeviceKind, Line, Owner, StationId, Tick, parse};
use linewright_plant::{
    AxisPosition, MotionFault, NestPosition, PartNo, PartPosition, PlantOptions, PositionsWatch, Rack, RackPositions,
};
use linewright_testkit::presses::{self, ADVANCE, BACK, FORWARD, FRONT, PRESS, RAM};

use crate::alone::Alone;

const TASK_DRIVEN: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");
const DRIVES: &str = include_str!("../../model/line/tests/descriptions/drives.toml");
const AT: fn(u64) -> Tick = Tick::from_millis;

fn rack(line: &Line) -> Rack {
    Rack::new(Tick::ZERO, line, &DeviceBus::Line, PlantOptions::default())
}

fn resumed(line: &Line, kept: &RackPositions) -> Result<Rack, String> {
    Rack::resumed(Tick::ZERO, line, &DeviceBus::Line, PlantOptions::default(), kept).map_err(|why| why.to_string())
}

fn described(text: &str) -> Line {
    parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn a_mechanism_stands_where_its_power_went_and_its_output_is_off() {
    let line = presses::line();
    let owner = Owner::Station(PRESS);
    for (millis, at, inputs) in [(0, 0.0, BACK), (50, 20.0, 0), (200, 80.0, FRONT)] {
        let mut before = rack(&line);
        before.plant_mut().set_outputs(Tick::ZERO, owner, FORWARD);
        let kept = before.positions(AT(millis), &line);
        let mut after = resumed(&line, &kept).expect("its own positions");
        assert!((after.plant().position(PRESS, RAM) - at).abs() < 1e-9, "{millis} ms");
        assert_eq!((after.plant().inputs(owner), after.plant().outputs(owner)), (inputs, 0), "{millis} ms");
        assert_eq!(after.positions(AT(5000), &line), kept, "nothing moves by itself");
        // The rest of the way.
        after.plant_mut().set_outputs(AT(5000), owner, FORWARD);
        after.plant_mut().advance(AT(5000 + 200 - millis.min(199)));
        assert_eq!(after.plant().inputs(owner), FRONT);
    }
}

#[test]
fn faults_that_were_injected_are_gone() {
    let line = presses::line();
    let mut before = rack(&line);
    before.plant_mut().inject(Tick::ZERO, PRESS, ADVANCE, Some(MotionFault::Stick));
    before.plant_mut().force(Owner::Station(PRESS), linewright_line::InputId(0), Some(true));
    let kept = before.positions(AT(10), &line);
    let mut after = resumed(&line, &kept).expect("its own positions");
    assert_eq!(after.plant().inputs(Owner::Station(PRESS)), BACK);
    after.plant_mut().set_outputs(Tick::ZERO, Owner::Station(PRESS), FORWARD);
    after.plant_mut().advance(AT(200));
    assert_eq!(after.plant().inputs(Owner::Station(PRESS)), FRONT);
}

/// A robot's hand over slot 3, closed around a part: it still has it, and the slot's number is known without outputs.
#[test]
fn parts_are_where_they_were_and_hands_have_what_they_had() {
    let line = described(TASK_DRIVEN);
    let robot = Owner::Station(StationId(1));
    let output = |name: &str| {
        let at = line.station(StationId(1)).outputs.iter().position(|output| output == name).expect("an output");
        1_u128 << at
    };
    let (store, hand) =
        (line.handling.holder_named("ST").expect("a store"), line.handling.holder_named("robot.hand").expect("a hand"));
    let slot = NestPosition { nest: store, position: 3 };
    let mut before = rack(&line);
    before.plant_mut().put(Tick::ZERO, PartNo(101), slot).expect("room");
    before.plant_mut().put(Tick::ZERO, PartNo(102), NestPosition { nest: store, position: 1 }).expect("room");
    let number = output("slot_1") | output("slot_2");
    before.plant_mut().set_outputs(AT(0), robot, output("Y_50") | number);
    before.plant_mut().set_outputs(AT(1000), robot, output("Y_grip") | number);
    let kept = before.positions(AT(2000), &line);
    let mut after = resumed(&line, &kept).expect("its own positions");
    assert!(before.plant().parts().eq(after.plant().parts()));
    assert_eq!((after.plant().part_in(hand), after.plant().part_at(slot)), (Some(PartNo(101)), Some(PartNo(101))));
    assert_eq!(after.plant().inputs(robot), before.plant().inputs(robot));
    // It opens: the part lies in its slot, which no output names any more.
    after.plant_mut().set_outputs(AT(0), robot, output("Y_open"));
    after.plant_mut().advance(AT(1000));
    assert_eq!((after.plant().part_in(hand), after.plant().part_at(slot)), (None, Some(PartNo(101))));
    assert_eq!(after.plant().mishaps().1, 0);
}

/// Moved as with cansend. An absolute drive knows its place, one with homing begins with an unknown zero: its axis stands where it stood.
#[test]
fn a_drive_stands_where_it_stood() {
    for is_absolute in [false, true] {
        let mut line = described(DRIVES);
        for device in &mut line.devices {
            if let DeviceKind::Drive(_, drive) = &mut device.kind {
                assert!(drive.homing.is_some());
                drive.homing = drive.homing.filter(|_| !is_absolute);
            }
        }
        let mut bench = Alone::booted(3, |now, _| Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default()));
        bench.pass(10);
        bench.hear("000#0100");
        for frame in ["603#2381600000A08601", "603#23836000C0C62D00", "603#23846000C0C62D00", "603#237A6000409C0000"] {
            bench.hear(frame);
        }
        for frame in ["203#0600", "203#0700", "203#0F00", "203#3F00"] {
            bench.hear(frame);
        }
        bench.pass(1150);
        let now = bench.now;
        let kept = bench.device.positions(now, &line);
        assert_eq!(kept.axes["slide"]["x"].at, 40.0);
        let mut again = Alone::booted(3, |now, _: NodeId| {
            Rack::resumed(now, &line, &DeviceBus::Line, PlantOptions::default(), &kept).expect("its own positions")
        });
        again.pass(10);
        again.hear("000#0100");
        assert_eq!(again.device.plant().position(StationId(0), AxisId(0)), 40.0);
        let own: u32 = if is_absolute { 40_000 } else { 0 };
        assert_eq!(again.read("6064"), Ok(own.to_le_bytes().to_vec()), "its own increments");
    }
}

#[test]
fn positions_of_another_line_and_impossible_ones_are_refused() {
    let line = described(TASK_DRIVEN);
    let good = rack(&line).positions(Tick::ZERO, &line);
    assert!(resumed(&line, &good).is_ok());
    let refused = |change: &dyn Fn(&mut RackPositions)| {
        let mut kept = good.clone();
        change(&mut kept);
        resumed(&line, &kept).map(|_| ()).expect_err("it is refused")
    };
    let part = |nest: Option<(&str, u16)>, hand: Option<&str>| PartPosition {
        number: 7,
        nest: nest.map(|(name, position)| (name.to_owned(), position)),
        hand: hand.map(str::to_owned),
    };
    let add = |part: PartPosition| move |kept: &mut RackPositions| kept.parts.push(part.clone());
    assert_eq!(
        refused(&|kept| _ = kept.axes.insert("other".to_owned(), Default::default())),
        "there is no station `other` on the coordinator's bus"
    );
    assert_eq!(refused(&|kept| _ = kept.axes.remove("m1")), "m1 has other axes");
    let first = |kept: &mut RackPositions, at: f64| {
        let axes = kept.axes.get_mut("m1").expect("it is there");
        axes.values_mut().for_each(|axis| *axis = AxisPosition { at, left: 0 });
    };
    assert!(refused(&|kept| first(kept, 1e9)).contains("of m1: 1000000000 is no position of it"));
    assert!(refused(&|kept| first(kept, f64::NAN)).contains("is no position of it"));
    assert!(refused(&|kept| kept.reached.clear()).contains("reaches of grippers"));
    assert_eq!(refused(&add(part(Some(("nowhere", 1)), None))), "there is no `nowhere`");
    assert_eq!(refused(&add(part(None, Some("ST")))), "there is no `ST`");
    assert!(refused(&add(part(Some(("ST", 99)), None))).starts_with("position 99 of `ST`, which has"));
    let twice = |kept: &mut RackPositions| kept.parts.extend([part(Some(("ST", 1)), None), part(None, None)]);
    assert_eq!(refused(&twice), "part 7 is where another is, or twice");
}

#[test]
fn positions_are_looked_at_a_few_times_a_second_while_something_moves() {
    let every = Duration::from_millis(200);
    let at = |at: f64| {
        let axes = [("x".to_owned(), AxisPosition { at, left: 0 })].into();
        RackPositions { axes: [("a".to_owned(), axes)].into(), ..RackPositions::default() }
    };
    let mut watch = PositionsWatch::new(AT(0), every);
    assert!(watch.stir(AT(0)), "at once at the beginning");
    assert_eq!(watch.look(AT(0), at(0.0)), Some(at(0.0)));
    assert!(!watch.stir(AT(199)) && watch.stir(AT(200)));
    assert_eq!(watch.look(AT(200), at(0.0)), None);
    assert_eq!(watch.due(), None, "nothing moves");
    assert!(watch.stir(AT(900)), "what comes after a while is looked at at once");
    assert_eq!(watch.look(AT(900), at(1.0)), Some(at(1.0)));
    assert_eq!(watch.due(), Some(AT(1100)), "it goes on, though nothing else happens");
}
