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
