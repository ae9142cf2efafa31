//! Analogue channels of a device: what is read.

use linewright_line::{
    Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, Follows, InputId, Lag, Line, OutputId, Owner, StationId,
    When, parse,
};

const LINE: &str = include_str!("descriptions/drives.toml");

const INPUT: &str = "channel = 2, unit = \"bar\", factor = 0.01, offset = -1.0, least = 0.0, most = 10.0, \
    broken = \"gauge_broken\", inputs = [{ input = \"high\", above = 5.0, hysteresis = 0.2 }, { input = \"low\", below = 1 }]";
const OUTPUT: &str =
    "channel = 1, unit = \"mA\", factor = 0.001, rest = 4.0, outputs = [{ output = \"Y_soft\", value = 8 }]";

/// The description with these channels added to the device of the valves.
pub fn with(inputs: &str, outputs: &str) -> String {
    let channels = format!("analogue_inputs = [{inputs}]\nanalogue_outputs = [{outputs}]\n");
    LINE.replace("outputs = [\"Y_open\", \"Y_close\"]\n", &format!("outputs = [\"Y_open\", \"Y_close\"]\n{channels}"))
}

fn line(inputs: &str, outputs: &str) -> Line {
    parse("line.toml", &with(inputs, outputs)).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn channels_are_read_and_their_signals_are_bits_like_any() {
    let simulated = "simulated = { output = \"Y_open\", on = 6.0, lag_ms = 300 }";
    let line = line(&format!("{{ {INPUT}, {simulated} }}"), &format!("{{ {OUTPUT} }}"));
    let channel =
        |number, unit: &str, factor, offset| AnalogueChannel { number, unit: unit.to_owned(), factor, offset };
    let first = line.devices[0].input_bits().iter().flatten().count() as u16;
    let follows = Follows::Output { output: OutputId(0), on: 6.0, off: 0.0 };
    let input = AnalogueInput {
        channel: channel(2, "bar", 0.01, -1.0),
        least: Some(0.0),
        most: Some(10.0),
        inputs: vec![
            (InputId(first), When::Above { at: 5.0, hysteresis: 0.2 }),
            (InputId(first + 1), When::Below { at: 1.0, hysteresis: 0.0 }),
        ],
        broken: Some(InputId(first + 2)),
        simulated: Some(Lag { follows, time_constant: std::time::Duration::from_millis(300) }),
    };
    let output = AnalogueOutput { channel: channel(1, "mA", 0.001, 0.0), rest: 4.0, outputs: vec![(OutputId(2), 8.0)] };
    assert_eq!(line.devices[0].io().expect("I/O").analogue, Analogue { inputs: vec![input], outputs: vec![output] });
    let station = &line.stations[0];
    assert_eq!(station.inputs[usize::from(first)..][..3], ["high", "low", "gauge_broken"]);
    assert_eq!(station.outputs[2], "Y_soft");
    let text = |nth| line.input_text(Owner::Station(StationId(0)), InputId(nth));
    assert!(text(first).ends_with("6401h:02 above 5.00 bar)"), "{}", text(first));
    assert!(text(first + 2).ends_with("6401h:02 is no measurement)"), "{}", text(first + 2));
    assert!(line.devices[0].carried_outputs().contains(&OutputId(2)));
}

fn channel(number: u8, factor: f64, offset: f64) -> AnalogueChannel {
    AnalogueChannel { number, unit: "bar".to_owned(), factor, offset }
}

#[test]
fn channels_lie_four_to_a_process_data_object() {
    let place = |number| (channel(number, 1.0, 0.0).pdo(), channel(number, 1.0, 0.0).field().start);
    assert_eq!([1, 4, 5, 8, 9, 12].map(place), [(2, 0), (2, 48), (3, 0), (3, 48), (4, 0), (4, 48)]);
}

#[test]
fn numbers_and_values_are_each_others_inverse() {
    for (factor, offset) in [(0.01, 0.0), (-0.5, 3.0), (2.5, -1000.0), (1.0 / 3.0, 0.1)] {
        let channel = channel(1, factor, offset);
        for number in i16::MIN..=i16::MAX {
            assert_eq!(channel.number_of(channel.value_of(number)), Some(number), "{factor} {offset}");
        }
        assert_eq!(channel.number_of(factor * 32768.0 + offset), None);
    }
    assert_eq!(channel(1, 0.01, 0.0).text(5.0), "5.00 bar");
    assert_eq!(channel(1, 20.0, 0.0).text(-40.0), "-40 bar");
}

#[test]
fn a_channel_rests_while_none_or_two_of_its_outputs_are_on() {
    let outputs = vec![(OutputId(0), 3.5), (OutputId(5), 6.0)];
    let output = AnalogueOutput { channel: channel(1, 0.01, 0.0), rest: 0.5, outputs };
    assert_eq!([0, 1, 1 << 5, 1 | 1 << 5, 1 << 4].map(|image| output.number(image)), [50, 350, 600, 50, 50]);
}

#[test]
fn the_ends_of_the_range_and_what_is_beyond_the_limits_is_no_measurement() {
    let channel = channel(1, 0.001, 0.0);
    let (inputs, broken, simulated) = (Vec::new(), None, None);
    let mut input = AnalogueInput { channel, least: None, most: None, inputs, broken, simulated };
    let measured = |input: &AnalogueInput| {
        [i16::MIN, -32767, 3599, 3600, 21000, 21001, 32766, i16::MAX].map(|number| input.is_measured(number))
    };
    assert_eq!(measured(&input), [false, true, true, true, true, true, true, false]);
    (input.least, input.most) = (Some(3.6), Some(21.0));
    assert_eq!(measured(&input), [false, false, false, true, true, false, false, false]);
}
