//! The shipped transfer line: it parses without a warning, it is the line that was meant, and it can be multiplied.

use std::time::Duration;

use linewright_line::{
    Arrow, DeviceBus, HandMode, InputId, Line, MotionSignals, OpId, OperationModule, OutputId, Owner, StationId,
    TransferLine, parse,
};

const SHIPPED: &str = include_str!("../../../launch-config/lines/transfer-line/line.toml");

/// The line of a text that must be sound and raise no warning.
fn sound(text: &str) -> Line {
    let parsed = parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
    assert_eq!(parsed.warnings, [], "no warnings");
    parsed.line
}

#[test]
fn the_shipped_line_has_its_stations_and_operations() {
    let line = sound(SHIPPED);
    assert_eq!((line.name.as_str(), line.title.as_str()), ("transfer_line", "Transfer line"));
    let stations: Vec<(&str, Vec<&str>, usize)> = line
        .stations
        .iter()
        .map(|s| (s.name.as_str(), s.operations.iter().map(|o| o.name.as_str()).collect(), s.home.index()))
        .collect();
    assert_eq!(
        stations,
        [
            (
                "transfer",
                vec![
                    "1st lift",
                    "2nd lift",
                    "3rd lift",
                    "4th lift",
                    "advance transfer",
                    "1st lower",
                    "2nd lower",
                    "3rd lower",
                    "4th lower",
                    "return transfer",
                ],
                9
            ),
            ("clamp_1", vec!["return clamp", "advance clamp"], 0),
            (
                "mill_1",
                vec![
                    "rapid advance positioning slide",
                    "decel",
                    "feed main slide",
                    "rapid return positioning slide",
                    "reset main slide",
                ],
                4
            ),
        ]
    );
    assert!(line.stations.iter().all(|s| s.steps.iter().all(|step| step.len() == 1) && s.bus == DeviceBus::Line));
}

#[test]
fn the_shipped_line_has_the_hand_types_of_table_3() {
    let line = sound(SHIPPED);
    let button = |id: linewright_line::ButtonId| line.buttons[id.index()].as_str();
    let entries: Vec<String> = line
        .stations
        .iter()
        .flat_map(|s| &s.operations)
        .map(|op| {
            let hand = op.hand;
            let or = |b: Option<_>| b.map_or("-", button);
            format!("{} {} {} {}", hand.number(), button(hand.forward()), or(hand.back()), or(hand.next()))
        })
        .collect();
    assert_eq!(
        entries,
        [
            "3 PB_2 PB_4 -",
            "4 PB_2 PB_4 -",
            "4 PB_2 PB_4 -",
            "5 PB_2 PB_4 PB_3",
            "6 PB_3 PB_7 PB_4",
            "3 PB_4 PB_2 -",
            "4 PB_4 PB_2 -",
            "4 PB_4 PB_2 -",
            "5 PB_4 PB_2 PB_7",
            "6 PB_7 PB_3 PB_2",
            "6 PB_1 PB_5 PB_5",
            "6 PB_5 PB_1 PB_1",
            "1 PB_8 - -",
            "1 PB_8 - -",
            "1 PB_8 - -",
            "1 PB_8 - -",
            "2 PB_8 - PB_8",
        ]
    );
}

#[test]
fn an_operation_has_its_signals_times_and_motion() {
    let line = sound(SHIPPED);
    let (transfer, mill) = (&line.stations[0], &line.stations[2]);
    let lift = &transfer.operations[0];
    assert_eq!((lift.duration, lift.watchdog), (Duration::from_millis(120), Duration::from_secs(1)));
    assert_eq!((lift.motion.axis.index(), lift.motion.from, lift.motion.to), (0, 0.0, 50.0));
    assert_eq!(
        lift.normal,
        MotionSignals {
            actuator: OutputId(0),
            complete: InputId(1),
            fault: Some(InputId(5)),
            lamp: Some(OutputId(10))
        }
    );
    assert_eq!(transfer.inputs[1], "LS_vertical_50", "unconnected bits have no place in the image");
    let OperationModule::Reversible { recovery, recovery_duration, recovery_watchdog } = &lift.module else {
        panic!("a lift is reversible")
    };
    assert_eq!((transfer.outputs[recovery.actuator.index()].as_str(), recovery.complete), ("lower_to_0", InputId(0)));
    assert_eq!((*recovery_duration, *recovery_watchdog), (lift.duration, lift.watchdog), "the normal ones by default");
    assert_eq!(mill.operations[2].module, OperationModule::Irreversible { recovery_path: vec![OpId(0)] });
    assert!(matches!(mill.operations[4].hand, HandMode::SequenceEnd { .. }));
    assert_eq!(transfer.panel.retract.map(|id| transfer.inputs[id.index()].as_str()), Some("PB_return"));
}

#[test]
fn a_recovery_without_times_has_those_of_the_operation_that_is_the_same_motion() {
    let at = SHIPPED.find("name = \"return transfer\"").expect("it is there");
    let slow = SHIPPED[at..].replacen("duration_s = 0.5", "duration_s = 6", 1).replacen(
        "watchdog_s = 1.5",
        "watchdog_s = 9",
        1,
    );
    let line = sound(&format!("{}{slow}", &SHIPPED[..at]));
    let advance = line.stations[0].operations.iter().find(|op| op.name == "advance transfer").expect("it is there");
    let OperationModule::Reversible { recovery_duration, recovery_watchdog, .. } = advance.module else {
        panic!("it is reversible")
    };
    assert_eq!((recovery_duration, recovery_watchdog), (Duration::from_secs(6), Duration::from_secs(9)));
    assert_eq!(advance.duration, Duration::from_millis(500));
}

#[test]
fn arrows_conflicts_devices_and_console_are_resolved() {
    let line = sound(SHIPPED);
    let end = |station, op| (StationId(station), OpId(op));
    let arrow = |from, to, lag, manual| Arrow { from, to, lag, auto: true, manual };
    assert_eq!(
        line.arrows,
        [
            arrow(end(1, 0), end(0, 0), 0, true),
            arrow(end(0, 8), end(1, 1), 0, true),
            arrow(end(1, 1), end(2, 0), 0, true),
            arrow(end(2, 4), end(1, 0), 1, true),
            arrow(end(1, 1), end(0, 9), 0, false),
        ]
    );
    assert_eq!(line.conflicts.len(), 2);
    let first = &line.conflicts[0];
    assert_eq!((first.a.from, first.a.until, first.b.from, first.b.until), (OpId(0), OpId(8), OpId(1), OpId(0)));
    let nodes: Vec<(u8, Owner)> = line.devices.iter().map(|d| (d.node_id().expect("CANopen"), d.owner)).collect();
    let station = |id| Owner::Station(StationId(id));
    let of_the_mill = [(0x22, station(2)), (0x23, station(2)), (0x24, station(2))];
    assert_eq!(nodes[..3], [(0x01, Owner::Console), (0x11, station(0)), (0x21, station(1))]);
    assert_eq!(nodes[3..], of_the_mill);
    let slides: Vec<Option<usize>> = line.devices.iter().map(|d| d.drive().map(|d| d.axis.index())).collect();
    assert_eq!(slides, [None, None, None, None, Some(0), Some(1)]);
    assert_eq!(line.devices[0].input_bits()[4..8], [Some(InputId(4)), None, Some(InputId(5)), Some(InputId(6))]);
    assert!(line.console.buttons.iter().all(Option::is_some) && line.console.lamps.iter().all(Option::is_some));
    let estop = line.console.estop.expect("it has one");
    assert_eq!((line.console.inputs[estop.input.index()].as_str(), estop.pressed), ("ES_pressed", true));
}

/// Along the longest chain of waiting: the clamp opens, the bar lifts, advances and lowers, the clamp closes, the mill
/// works; the bar returns meanwhile.
#[test]
fn a_cycle_takes_three_to_four_seconds() {
    let line = sound(SHIPPED);
    let all: Duration = line.stations.iter().flat_map(|s| &s.operations).map(|op| op.duration).sum();
    let cycle = (all - line.stations[0].operations[9].duration).as_secs_f64();
    assert!((3.0..4.0).contains(&cycle), "{cycle} s");
}

#[test]
fn one_machine_at_full_scale_is_the_shipped_file() {
    let (schema, rest) = SHIPPED.split_once('\n').expect("it has lines");
    assert!(schema.starts_with("#:schema "), "{schema}");
    assert_eq!(TransferLine { machines: 1, time_scale: 1.0 }.text(), rest);
    assert_eq!(TransferLine::default().text(), rest);
}

#[test]
fn every_number_of_machines_is_a_sound_line() {
    for machines in 1..=TransferLine::MACHINES_MAX {
        let line = sound(&TransferLine { machines, time_scale: 1.0 }.text());
        assert_eq!(line.stations.len(), 1 + 2 * machines);
        assert_eq!(line.devices.len(), 2 + 4 * machines);
        assert_eq!(line.arrows.len(), 5 * machines);
        assert_eq!(line.conflicts.len(), 2 * machines);
        for machine in 1..=machines {
            for (kind, title, first_node) in [("clamp", "Clamp", 0x21), ("mill", "Mill", 0x22)] {
                let id = line.station_named(&format!("{kind}_{machine}")).expect("each machine is there");
                assert_eq!(line.station(id).title, format!("{title} {machine}"));
                let node = line.devices_of(Owner::Station(id)).next().and_then(|d| d.node_id().map(usize::from));
                assert_eq!(node, Some(first_node + 4 * (machine - 1)));
                let arrows = line.arrows.iter().filter(|a| a.from.0 == id || a.to.0 == id).count();
                assert_eq!(arrows, if kind == "clamp" { 5 } else { 2 }, "arrows of {kind} {machine}");
            }
        }
    }
}

#[test]
fn times_scale_but_watchdogs_stay_above_a_second() {
    let scaled = |time_scale| {
        let line = sound(&TransferLine { machines: 2, time_scale }.text());
        let feed = &line.stations[3].operations[2];
        (feed.name.clone(), feed.duration.as_secs_f64(), feed.watchdog.as_secs_f64())
    };
    assert_eq!(scaled(0.1).0, "feed main slide");
    assert_eq!((scaled(0.1).1, scaled(0.1).2), (0.07, 1.0));
    assert_eq!((scaled(10.0).1, scaled(10.0).2), (7.0, 20.0));
    let slide = |time_scale| {
        let line = sound(&TransferLine { machines: 2, time_scale }.text());
        line.devices.last().and_then(|d| d.drive().cloned()).expect("the second mill's main slide has a drive")
    };
    let (slow, fast) = (slide(1.0), slide(0.1));
    assert_eq!((slow.velocity, slow.acceleration, slow.targets[1].velocity), (217.0, 2e4, 88.0));
    assert_eq!(
        (fast.velocity.round(), fast.acceleration.round(), fast.targets[1].velocity.round()),
        (2170.0, 2e6, 880.0)
    );
    let duration = |drive: &linewright_line::Drive| drive.time_for(60.0, drive.targets[1].velocity);
    assert!((duration(&slow) / duration(&fast) - 10.0).abs() < 1e-6, "a tenth of the time");
    for bound in [TransferLine::TIME_SCALE.start(), TransferLine::TIME_SCALE.end()] {
        // Motions of many minutes give warnings.
        let text = TransferLine { machines: 2, time_scale: *bound }.text();
        assert!(parse("line.toml", &text).is_ok(), "{bound}");
    }
}
