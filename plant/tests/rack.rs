//! A rack of devices as the bus sees it, and the mechanisms behind them.

use linewright_canopen::NodeId;
use linewright_canopen::sdo::Abort;
use linewright_line::{AxisId, DeviceBus, StationId, Tick, parse};
use linewright_plant::{NestPosition, PartByHand, PartRefusal, PlantOptions, Rack};

use crate::alone::{Alone, refused};
use linewright_testkit::presses::line;

const PARTS: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");
const DRIVES: &str = include_str!("../../model/line/tests/descriptions/drives.toml");

/// Press 2, by itself on its bus.
fn press(now: Tick, _: NodeId) -> Rack {
    Rack::new(now, &line(), &DeviceBus::Own("press2".to_owned()), PlantOptions::default())
}

#[test]
fn it_boots_beats_and_reports_its_inputs_once_started() {
    let mut bench = Alone::new(4, press);
    bench.pass(19);
    assert!(bench.take().is_empty());
    bench.pass(51);
    assert_eq!(bench.take(), ["704#00", "704#7F"]);
    bench.hear("000#0105");
    assert!(bench.take().is_empty(), "that was for somebody else");
    bench.hear("000#0104");
    assert_eq!(bench.take(), ["184#02"]);
    bench.pass(100);
    assert_eq!(bench.take(), ["704#05", "704#05", "184#02"]);
}

#[test]
fn an_output_drives_and_the_limit_switch_answers() {
    let mut bench = Alone::started(4, press);
    bench.hear("204#01");
    bench.pass(200);
    let inputs: Vec<String> = bench.take().into_iter().filter(|f| f.starts_with("184")).collect();
    assert_eq!(inputs.first().unwrap(), "184#00");
    assert_eq!(inputs.last().unwrap(), "184#01");
}

#[test]
fn its_objects_can_be_read_and_the_unknown_are_refused() {
    let mut bench = Alone::started(4, press);
    bench.hear("204#03");
    let cases = [
        ("604#4000100000000000", "584#4300100091010300"),
        ("604#4017100000000000", "584#4B17100032000000"),
        ("604#4000600000000000", "584#4F00600001000000"),
        ("604#4000600100000000", "584#4F00600102000000"),
        ("604#4000620100000000", "584#4F00620103000000"),
        ("604#2F00620100000000", "584#8000620102000106"),
        ("604#4000600200000000", "584#8000600211000906"),
        ("604#4034120000000000", "584#8034120000000206"),
        ("604#2F00120000000000", "584#8000120000000206"),
        ("604#2F17100032000000", "584#8017100010000706"),
        ("604#40005F0100000000", "584#80005F0101000106"),
        ("604#2F005F0109000000", "584#80005F0130000906"),
        ("604#2F005F0301000000", "584#80005F0311000906"),
    ];
    for (request, answer) in cases {
        assert_eq!(bench.ask(request), answer, "{request}");
    }
}

#[test]
fn faults_and_fingers_come_over_the_bus() {
    let mut bench = Alone::started(4, press);
    // The motion of output 0 breaks: its fault input comes on.
    assert_eq!(bench.ask("604#2F005F0103000000"), "584#60005F0100000000");
    bench.hear("204#01");
    bench.pass(100);
    assert!(bench.take().contains(&"184#06".to_owned()));
    // A finger on input 3, taken off again.
    bench.hear("604#2F015F0401000000");
    assert!(bench.take().contains(&"184#0E".to_owned()));
    bench.hear("604#2F015F0402000000");
    assert!(bench.take().contains(&"184#06".to_owned()));
    // Everything cleared: it moves.
    bench.hear("604#2F005F0000000000");
    bench.pass(200);
    assert!(bench.take().contains(&"184#01".to_owned()));
}

/// Parts of the plant, taken out and put in by an object of a device of its bus.
#[test]
fn parts_are_taken_and_put_over_the_bus() {
    let line = parse("task_driven.toml", PARTS).expect("it is sound").line;
    let rack = |now, _| Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default());
    let mut bench = Alone::booted(3, rack);
    let store = line.handling.holder_named("ST").expect("it is there");
    let place = |position| NestPosition { nest: store, position };
    let mut done = |what: PartByHand, position: u16| {
        let ((index, sub), value) = what.order(place(position)).expect("it has an object");
        bench.write(&format!("{index:04X}:{sub}"), &value.to_le_bytes()).expect("it is taken");
        let outcome = bench.read("5F08").expect("it answers");
        let has = bench.device.plant().part_at(place(2)).is_some();
        (PartRefusal::from_code(outcome[0]), has)
    };
    assert_eq!(done(PartByHand::Take, 2), (Some(PartRefusal::Empty), false));
    assert_eq!(done(PartByHand::Put, 2), (None, true));
    assert_eq!(done(PartByHand::Put, 2), (Some(PartRefusal::Occupied), true));
    assert_eq!(done(PartByHand::Put, 7), (Some(PartRefusal::NoSuchSpot), true));
    assert_eq!(done(PartByHand::Take, 2), (None, false));
    assert!(PartRefusal::ALL.iter().all(|why| PartRefusal::from_code(why.code()) == Some(*why)));
}

/// So a command for another line writes nothing to it, and one that clears nothing says so. A silent device answers it too.
#[test]
fn a_device_names_what_it_is_part_of_and_counts_its_faults() {
    let mut bench = Alone::started(4, press);
    assert_eq!(bench.read("5F06"), Ok(b"no line".to_vec()));
    let part_of = "line /presses in ROS domain 3";
    bench.device.be_part_of(part_of);
    let faults = |bench: &mut Alone<Rack>| {
        assert_eq!(bench.read("5F06").as_deref(), Ok(part_of.as_bytes()));
        u16::from_le_bytes(bench.read("5F07").expect("it answers").try_into().expect("two bytes"))
    };
    let mut count = 0;
    for (object, value, more) in [
        // A motion and an input fail, each twice; a stuck output; what it says it is; its line; and it is unplugged.
        ("5F00:1", 3, 1),
        ("5F00:1", 1, 0),
        ("5F01:4", 0, 1),
        ("5F01:4", 1, 0),
        ("5F03:1", 1, 1),
        ("5F02:3", 9, 0),
        ("5F02:4", 0x10_1802, 1),
        ("5F02:1", 0x05_2310, 1),
        ("5F00:0", 4, 1),
        ("5F00:0", 1, 1),
    ] {
        bench.write(object, &u32::to_le_bytes(value)).expect("it takes that");
        count += more;
        assert_eq!(faults(&mut bench), count, "{object} {value:X}");
    }
    bench.write("5F00:0", &[0]).expect("it is plugged in");
    assert_eq!(faults(&mut bench), 0);
    bench.write("5F00:1", &[1]).expect("it sticks");
    bench.write("5F01:2", &[1]).expect("a finger");
    assert_eq!(faults(&mut bench), 2);
    for (object, value, left) in [("5F00:1", 0, 1), ("5F01:2", 2, 0), ("5F01:2", 2, 0)] {
        bench.write(object, &[value]).expect("it lets go");
        assert_eq!(faults(&mut bench), left, "{object}");
    }
    assert_eq!(bench.write("5F06", b"line /other"), refused(Abort::READ_ONLY));
    assert_eq!(bench.read("5F07:1"), refused(Abort::NO_SUBINDEX));
}

/// Its encoder is the axis's, whichever motion it broke in: to clear one of them mends it.
#[test]
fn a_drive_counts_what_sticks_and_its_encoder() {
    let line = parse("drives.toml", DRIVES).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let mut bench = Alone::booted(3, |now, _| Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default()));
    for (object, value, faults) in
        [("5F00:1", 3, 1), ("5F00:2", 1, 2), ("5F00:2", 1, 2), ("5F00:1", 0, 1), ("5F00:2", 0, 0)]
    {
        bench.write(object, &[value]).expect("it takes that");
        assert_eq!(bench.read("5F07"), Ok(vec![faults, 0]), "{object} {value}");
    }
    bench.write("5F00:2", &[3]).expect("it breaks");
    bench.write("5F00:0", &[0]).expect("all is well");
    assert_eq!(bench.read("5F07"), Ok(vec![0, 0]));
}

#[test]
fn its_axis_follows_it_and_the_others_follow_their_valves() {
    let line = parse("drives.toml", DRIVES).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let mut bench = Alone::booted(3, |now, _| Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default()));
    let place = |bench: &Alone<Rack>, axis| bench.device.plant().position(StationId(0), AxisId(axis));
    bench.pass(10);
    bench.hear("000#0100");
    assert_eq!((place(&bench, 0), place(&bench, 1)), (0.0, 0.0));
    // The clamp closes by its valve; node 3 gets 40 mm at 100 mm/s, as with cansend.
    for frame in [
        "202#02",
        "603#2381600000A08601",
        "603#23836000C0C62D00",
        "603#23846000C0C62D00",
        "603#237A6000409C0000",
        "203#0600",
        "203#0700",
        "203#0F00",
        "203#3F00",
    ] {
        bench.hear(frame);
    }
    bench.pass(150);
    assert!((1.0..39.0).contains(&place(&bench, 0)), "{}", place(&bench, 0));
    assert!((1.0..4.9).contains(&place(&bench, 1)), "{}", place(&bench, 1));
    bench.pass(1000);
    assert_eq!((place(&bench, 0), place(&bench, 1)), (40.0, 5.0));
    assert_eq!(bench.read("6064"), Ok(40_000u32.to_le_bytes().to_vec()), "its own increments");
    // The clamp's switch is on where it is; nothing of the slide is among the I/O device's inputs.
    assert_eq!(bench.out.iter().rev().find(|f| f.cob_id() == Some(0x182)).map(|f| f.data().to_vec()), Some(vec![2]));
}
