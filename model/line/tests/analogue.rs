//! Analogue channels of a device: what is read, and every rule about them broken once.

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
fn with(inputs: &str, outputs: &str) -> String {
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

/// Message and text of the only problem that these channels have beyond those of the whole and unused signals.
fn problem(inputs: &str, outputs: &str) -> (String, String) {
    let text = with(inputs, outputs);
    let problems = match parse("line.toml", &text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.iter().cloned().collect(),
    };
    let known = parse("line.toml", LINE).expect("it is sound").warnings;
    let is_known = |message: &str| known.iter().any(|problem| problem.message == message);
    let mut new = problems.into_iter().filter(|p| !is_known(&p.message) && !p.message.starts_with("nothing uses"));
    let first = new.next().unwrap_or_else(|| panic!("nothing wrong with {inputs} {outputs}"));
    assert_eq!(new.next().map(|other| other.message), None, "{inputs} {outputs}");
    (first.message.clone(), text[first.span.clone()].to_owned())
}

#[test]
fn what_makes_no_sense_of_an_input_is_refused_in_place() {
    let input = |from: &str, to: &str| {
        assert!(INPUT.contains(from), "{from}");
        problem(&format!("{{ {} }}", INPUT.replace(from, to)), "")
    };
    let is = |(message, at): (String, String), expected: &str, place: &str| {
        assert_eq!((message.as_str(), at.as_str()), (expected, place));
    };
    is(input("channel = 2", "channel = 13"), "there is no channel 13", "13");
    is(input("factor = 0.01", "factor = 0.0"), "a factor of zero", "0.0");
    is(input("most = 10.0", "most = 0.0"), "no value is from 0 to 0", "0.0");
    is(input("hysteresis = 0.2", "hysteresis = -1"), "a hysteresis below zero", "-1");
    is(input("above = 5.0", "above = 10.5"), "a limit that is never reached", "10.5");
    is(input("hysteresis = 0.2", "hysteresis = 5.0"), "a limit that is never left again", "5.0");
    is(input("below = 1", "below = -0.5"), "a limit that is never reached", "-0.5");
    is(
        input("above = 5.0", "above = 5.0, below = 3.0"),
        "an input on above one limit and below another",
        "{ input = \"high\", above = 5.0, below = 3.0, hysteresis = 0.2 }",
    );
    is(input(", below = 1", ""), "an input without a limit", "{ input = \"low\" }");
    is(input("\"low\"", "\"high\""), "`high` is bound to two bits", "\"high\"");
    is(input("below = 1", "bleow = 1, below = 1"), "unknown key `bleow` in a limit", "bleow");
    let twice = problem(&format!("{{ {INPUT} }}, {{ channel = 2, inputs = [{{ input = \"more\", above = 1 }}] }}"), "");
    is(twice, "analogue input 2 twice", "2");
    is(problem("{ channel = 1 }", ""), "nothing follows from this analogue input", "{ channel = 1 }");
}

#[test]
fn what_makes_no_sense_of_an_output_or_a_model_is_refused_in_place() {
    let output = |from: &str, to: &str| problem("", &format!("{{ {} }}", OUTPUT.replace(from, to))).0;
    assert_eq!(output("value = 8", "value = 40"), "40 is beyond what the channel can be set to");
    assert_eq!(output("rest = 4.0", "rest = -33.0"), "-33 is beyond what the channel can be set to");
    assert_eq!(output("value = 8", "value = 4.0001"), "`Y_soft` changes nothing");
    assert_eq!(output("rest = 4.0, ", ""), "an analogue output needs `rest`");
    let model = |model: &str| problem(&format!("{{ {INPUT}, simulated = {{ lag_ms = 100, {model} }} }}"), "").0;
    assert_eq!(model("output = \"Y_opne\", on = 1.0"), "no output `Y_opne` here");
    assert_eq!(model("output = \"Y_open\""), "a simulated value that goes nowhere");
    assert_eq!(model("on = 1.0"), "a value that follows nothing");
    assert_eq!(model("channel = 1"), "this device has no analogue output 1");
    assert_eq!(model("channel = 1, output = \"Y_open\", on = 1.0"), "a value that follows two things");
}

#[test]
fn only_io_devices_have_channels_and_the_manager_writes_what_they_rest_upon() {
    let at_drive = LINE.replace("[device.drive]", &format!("analogue_inputs = [{{ {INPUT} }}]\n[device.drive]"));
    let problems = parse("line.toml", &at_drive).expect_err("a drive has none");
    assert!(problems.iter().any(|p| p.message == "a device with a `drive` table has no analogue channels"));
    for object in ["6423", "6443:01", "1801:05", "1402:01"] {
        let settings = format!("settings = [{{ object = \"{object}\", value = 0 }}]\nanalogue_inputs");
        let text = with(&format!("{{ {INPUT} }}"), "").replace("analogue_inputs", &settings);
        let problems = parse("line.toml", &text).expect_err("it is the manager's");
        assert!(problems.iter().any(|p| p.message == "an object that the manager writes for analogue channels"));
    }
}

#[test]
fn a_device_that_may_be_lost_decides_nothing_by_its_channels_either() {
    let text = with("{ channel = 1, inputs = [{ input = \"C_0\", above = 5 }] }", "").replace(
        "inputs = [\"C_0\", \"C_5\", \"S0\", \"S1\", \"S2\"]\noutputs = [\"Y_open\", \"Y_close\"]",
        "when_lost = \"report\"",
    );
    let problems = parse("line.toml", &text).expect_err("an operation ends by it");
    let message = "this device cannot be lost without a fault: `C_0` is one of its inputs";
    assert!(problems.iter().any(|problem| problem.message == message), "{problems:#}");
}
