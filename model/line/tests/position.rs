//! Measured positions: the switches of each place, and those that tell the states of conflicts.

use linewright_line::net::{Block, StationPlace};
use linewright_line::{
    Axis, AxisId, InputId, Motion, NoClearance, OpId, OperationModule, StateSpan, Station, StationId, parse,
};
use linewright_testkit::built::transfer_line;

fn names(station: &Station, bits: u128) -> Vec<&str> {
    let on = |(bit, _): &(usize, &String)| bits & (1 << bit) != 0;
    station.inputs.iter().enumerate().filter(on).map(|(_, name)| name.as_str()).collect()
}

#[test]
fn the_conflicts_of_the_shipped_line_are_told_by_one_switch_on_each_side() {
    let line = transfer_line();
    let of = |span: &StateSpan| names(line.station(span.station), line.clearance(span).expect("measured").on).join(" ");
    let sides: Vec<(String, String)> = line.conflicts.iter().map(|c| (of(&c.a), of(&c.b))).collect();
    let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    assert_eq!(sides, [pair("LS_vertical_0", "LS_open"), pair("LS_positioning_0", "LS_closed")]);
}

#[test]
fn a_clearance_is_contradicted_by_the_switches_at_the_other_places_of_the_same_axes() {
    let line = transfer_line();
    let of =
        |span: &StateSpan| names(line.station(span.station), line.clearance(span).expect("measured").off).join(" ");
    let sides: Vec<String> = line.conflicts.iter().flat_map(|c| [of(&c.a), of(&c.b)]).collect();
    let vertical = "LS_vertical_50 LS_vertical_100 LS_vertical_150 LS_vertical_200";
    assert_eq!(sides, [vertical, "LS_closed", "LS_positioning_80 LS_positioning_100", "LS_open"]);
}

#[test]
fn at_rest_every_axis_is_measured_and_under_way_all_but_the_one_that_moves() {
    let line = transfer_line();
    let bar = &line.stations[0];
    let at = |place| names(bar, bar.rest_inputs(place));
    let op = |name| bar.operation_named(name).expect("it has it");
    assert_eq!(at(StationPlace::completed(bar.home)), ["LS_vertical_0", "LS_horizontal_0"]);
    assert_eq!(at(StationPlace::operating(op("advance transfer"))), ["LS_vertical_200"]);
    assert_eq!(at(StationPlace::incomplete(op("advance transfer"))), ["LS_vertical_200"]);
    assert_eq!(at(StationPlace::undone(op("advance transfer"))), ["LS_vertical_200", "LS_horizontal_0"]);
    assert_eq!(at(StationPlace::completed(op("2nd lower"))), ["LS_vertical_100", "LS_horizontal_500"]);
}

#[test]
fn the_switch_that_a_motion_leaves_is_that_of_its_other_end() {
    let line = transfer_line();
    let behind = |station: usize, op: &str, block| {
        let station = &line.stations[station];
        names(station, station.switch_left_behind(station.operation_named(op).expect("it has it"), block)).join(" ")
    };
    assert_eq!(behind(1, "advance clamp", Block::Normal), "LS_open");
    assert_eq!(behind(1, "advance clamp", Block::Recovery), "LS_closed");
    assert_eq!(behind(0, "2nd lift", Block::Normal), "LS_vertical_50");
    assert_eq!(behind(0, "2nd lift", Block::Recovery), "LS_vertical_100");
}

#[test]
fn a_state_outside_which_its_axis_moves_is_not_told_by_switches() {
    let line = transfer_line();
    let bar = &line.stations[0];
    let op = |name| bar.operation_named(name).expect("it has it");
    // Outside it the bar also lifts to 50 and back from there.
    let span = StateSpan { station: StationId(0), from: op("2nd lift"), until: op("3rd lower") };
    assert_eq!(line.clearance(&span), Err(NoClearance::NothingStandsStill));
}

/// A stretch of the shipped line without the operation that ends or begins it.
#[test]
fn a_state_that_is_cut_short_names_the_operation_that_is_missing() {
    let line = transfer_line();
    let why = |station: usize, from: &str, until: &str| {
        let of = &line.stations[station];
        let op = |name| of.operation_named(name).expect("it has it");
        let span = StateSpan { station: StationId::at(station), from: op(from), until: op(until) };
        line.clearance(&span).expect_err("no switch tells it").text(of)
    };
    let missing = |op: &str, of: &str, axis: &str, (away, rest): (u32, u32)| {
        format!(
            "`{op}` of {of} is outside this state: `{axis}` stands at {away} where the state ends, and is back at {rest} only after this \
             operation; if it is in the way until then, write `until = \"{op}\"`"
        )
    };
    assert_eq!(why(0, "1st lift", "3rd lower"), missing("4th lower", "transfer", "vertical", (50, 0)));
    assert_eq!(why(0, "1st lift", "advance transfer"), missing("4th lower", "transfer", "vertical", (200, 0)));
    let back = "rapid return positioning slide";
    let slide = missing(back, "mill_1", "positioning_slide", (100, 0));
    assert_eq!(why(2, "rapid advance positioning slide", "feed main slide"), slide);
    assert_eq!(why(1, "advance clamp", "advance clamp"), missing("return clamp", "clamp_1", "stroke", (60, 0)));
    assert_eq!(
        why(0, "2nd lift", "4th lower"),
        "`1st lift` of transfer is outside this state: `vertical` leaves 0 with this operation, and stands at 50 where the state begins; if \
         it is in the way from then on, write `from = \"1st lift\"`"
    );
}

#[test]
fn a_state_in_which_a_mechanism_returns_to_where_it_stands_outside_is_not_told_by_switches() {
    let line = transfer_line();
    let clamp = &line.stations[1];
    // All of its cycle but the rest at home: open at both ends, and open once more in no place between.
    let all = StateSpan { station: StationId(1), from: OpId(1), until: OpId(0) };
    assert_eq!(names(clamp, line.clearance(&all).expect("measured").on), ["LS_open"]);
    // The mill's main slide stands at 60 while the positioning slide returns to 0 inside this state.
    let mill = &line.stations[2];
    let op = |name| mill.operation_named(name).expect("it has it");
    let whole =
        StateSpan { station: StationId(2), from: op("rapid advance positioning slide"), until: op("reset main slide") };
    let inputs = line.clearance(&whole).expect("the two slides together tell it").on;
    assert_eq!(names(mill, inputs), ["LS_positioning_0", "LS_main_0"]);
}

#[test]
fn a_table_is_told_from_under_way_by_the_switch_it_begins_and_ends_at() {
    let text = include_str!("../../../examples/rotary-table.toml");
    let line = parse("rotary-table.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let table = &line.stations[0];
    let told = line.clearance(&line.conflicts[0].a).expect("its switch is off under way").on;
    assert_eq!(names(table, told), ["LS_in_place"]);
    let index = table.home;
    let at = |place| names(table, table.rest_inputs(place));
    assert_eq!(at(StationPlace::completed(index)), ["LS_in_place"]);
    assert_eq!((at(StationPlace::operating(index)), at(StationPlace::incomplete(index))), (vec![], vec![]));
    assert_eq!(table.measured_after(0), Some(told));
    assert_eq!(table.measured_within(index), Some(0));
    // In a longer state it would be on at the end of the index as well, which is inside.
    let mut line = line;
    let mut drill = line.stations[2].operations[1].clone();
    drill.motion.axis = AxisId(1);
    line.stations[0].axes.push(Axis { name: "spindle".to_owned(), home: 0.0, index: None });
    line.stations[0].operations.push(drill);
    line.stations[0].steps.push(vec![OpId(1)]);
    let span = StateSpan { station: StationId(0), from: OpId(0), until: OpId(1) };
    assert!(line.clearance(&span).is_err());
}

/// Inside the state the one slide comes back to where it stands outside, and the other one, at the same time, leaves it.
#[test]
fn two_axes_that_change_over_in_one_step_do_not_tell_the_state() {
    let mut line = transfer_line();
    let mill = &line.stations[2];
    let op = |name| mill.operation_named(name).expect("it has it");
    let span =
        StateSpan { station: StationId(2), from: op("rapid advance positioning slide"), until: op("reset main slide") };
    assert!(line.clearance(&span).is_ok());
    // Out; over to the other slide, both at once; back.
    let station = &mut line.stations[2];
    let way = |axis: u16, from: f64, to: f64| Motion { axis: AxisId(axis), from, to };
    let ways = [way(0, 0.0, 100.0), way(0, 100.0, 0.0), way(1, 0.0, 60.0), way(1, 60.0, 30.0), way(1, 30.0, 0.0)];
    // A switch for each place of each slide.
    let mut switches = Vec::new();
    let mut switch = |axis: AxisId, at: f64| {
        let nth = switches.iter().position(|known| *known == (axis, at)).unwrap_or_else(|| {
            switches.push((axis, at));
            switches.len() - 1
        });
        InputId::at(station.inputs.len() + nth)
    };
    for (operation, motion) in station.operations.iter_mut().zip(ways) {
        operation.motion = motion;
        operation.normal.complete = switch(motion.axis, motion.to);
        if let OperationModule::Reversible { recovery, .. } = &mut operation.module {
            recovery.complete = switch(motion.axis, motion.from);
        }
    }
    station.steps = vec![vec![OpId(0)], vec![OpId(1), OpId(2)], vec![OpId(3)], vec![OpId(4)]];
    assert_eq!(line.clearance(&span), Err(NoClearance::NotSeen { op: OpId(1) }));
    // One after the other, the first one first out again, is measured.
    line.stations[2].steps = vec![vec![OpId(0), OpId(2)], vec![OpId(1)], vec![OpId(3)], vec![OpId(4)]];
    assert!(line.clearance(&span).is_ok());
}

#[test]
fn a_place_that_two_inputs_tell_of_cannot_be_read_off() {
    let mut line = transfer_line();
    let clamp = &line.stations[1];
    let op = |name| clamp.operation_named(name).expect("it has it");
    let (opened, closes) = (clamp.step_of(op("return clamp")), op("advance clamp"));
    assert_eq!(clamp.measured_after(opened).map(|bits| names(clamp, bits)), Some(vec!["LS_open"]));
    assert_eq!(clamp.measured_within(closes).map(|bits| names(clamp, bits)), Some(vec![]));
    // Undone, the clamp is open by another switch than after its return.
    let station = &mut line.stations[1];
    let other = InputId::at(station.inputs.len());
    station.inputs.push("LS_open_2".to_owned());
    if let OperationModule::Reversible { recovery, .. } = &mut station.operations[closes.index()].module {
        recovery.complete = other;
    }
    assert_eq!(line.stations[1].measured_after(opened), None);
}
