//! A file, and a description bound to it.

use std::time::Duration;

use linewright_dbc::{Database, DbcError, Mux, bind, read};
use linewright_line::{
    Checksum, CyclicFrame, DbcName, FrameTable, InputId, OutputId, ReceivedMessageTable, SignalError, SignalInput,
    SignalOutput, When,
};

const GAUGE: &[u8] = include_bytes!("gauge.dbc");

fn gauge() -> Database {
    read(GAUGE).expect("a sound file")
}

fn named(name: &str) -> DbcName {
    DbcName { name: name.to_owned(), at: 0..1 }
}

fn input(id: u16, signal: &str, when: When) -> SignalInput {
    SignalInput { input: InputId(id), signal: named(signal), when }
}

fn receive(message: &str, inputs: Vec<SignalInput>) -> ReceivedMessageTable {
    let timeout = Duration::from_millis(100);
    ReceivedMessageTable { message: named(message), timeout, counter: None, checksum: None, inputs }
}

fn send(outputs: Vec<SignalOutput>) -> CyclicFrame {
    let every = Duration::from_millis(20);
    CyclicFrame {
        message: named("GaugeCommand"),
        every,
        lets_go_after: None,
        counter: None,
        checksum: None,
        outputs,
        set: Vec::new(),
    }
}

fn output(id: u16, signal: &str, on: f64) -> SignalOutput {
    SignalOutput { output: OutputId(id), signal: named(signal), on, off: 0.0 }
}

fn frames(receive: Vec<ReceivedMessageTable>, send: Vec<CyclicFrame>) -> FrameTable {
    FrameTable { file: named("gauge.dbc"), receive, send, bound: None }
}

fn problem(frames: &FrameTable) -> String {
    let problems = bind(frames, &gauge()).expect_err("it must not be bound");
    assert_eq!(problems.len(), 1, "{problems:?}");
    format!("{}; {}", problems[0].message, problems[0].hint.as_deref().unwrap_or("-"))
}

#[test]
fn messages_and_signals_are_read() {
    let gauge = gauge();
    let ids: Vec<String> = gauge.messages.iter().map(|message| message.id.to_string()).collect();
    assert_eq!(ids, ["123h", "18FEF100h", "124h"]);
    let detail = &gauge.messages[1];
    assert_eq!((&detail.signals[0].mux, &detail.signals[2].mux), (&Mux::Selector, &Mux::Selected(vec![(1, 1)])));
    let field = detail.signals[1].field.expect("a float");
    assert_eq!(field.value(u64::from(21.5f32.to_bits())), 21.5);
}

#[test]
fn an_error_has_a_line() {
    let broken = String::from_utf8_lossy(GAUGE).replace("SG_ Mode : 16|3@1+", "SG_ Mode : 16|x@1+");
    let Err(DbcError::Syntax { line, column, .. }) = read(broken.as_bytes()) else { panic!("it is broken") };
    assert_eq!((line, column > 1), (11, true));
    assert!(read(b"\xFF\xFE rubbish").is_err());
}

#[test]
fn a_description_is_bound() {
    let mut state = receive("GaugeState", vec![input(3, "Pressure", When::Above { at: 5.0, hysteresis: 0.2 })]);
    state.counter = Some(named("Alive"));
    state.checksum = Some((named("Check"), Checksum::Xor));
    let detail = receive("GaugeDetail", vec![input(0, "Hours", When::NotZero), input(1, "Temperature", When::NotZero)]);
    let mut command = send(vec![output(2, "Setpoint", 3.5)]);
    command.counter = Some(named("Count"));
    command.checksum = Some((named("Check"), Checksum::Sum));
    command.set = vec![(named("Valve"), 2.0)];
    let bound = bind(&frames(vec![state, detail], vec![command]), &gauge()).expect("it fits");
    assert_eq!((bound.heard[0].pages.len(), bound.heard[1].pages.len()), (1, 2));
    assert_eq!(bound.heard[0].checksum, Some((7, Checksum::Xor)));
    // Pressure 5 bar is 1000 steps above -5.
    let (_, field, when) = bound.heard[0].pages[0].inputs[0];
    assert!(when.holds(&field, 1000, false) && !when.holds(&field, 999, false));
    assert!(when.holds(&field, 980, true) && !when.holds(&field, 979, true));
    // Setpoint 3.5 is 35, high byte first; valve 2, count 3.
    let on = bound.told[0].bytes(1 << 2, 3);
    assert_eq!(on[..4], [0x32, 0, 35, 0x32 + 35]);
    assert_eq!(bound.told[0].bytes(0, 4)[..4], [0x42, 0, 0, 0x42]);
}

#[test]
fn what_does_not_fit_is_said_with_a_way_out() {
    let wrong = frames(vec![receive("GaugeStatus", vec![])], vec![]);
    assert_eq!(problem(&wrong), "gauge.dbc has no message `GaugeStatus`; did you mean `GaugeState`?");
    let wrong = frames(vec![receive("GaugeState", vec![input(0, "Presure", When::NotZero)])], vec![]);
    assert_eq!(problem(&wrong), "message `GaugeState` has no signal `Presure`; did you mean `Pressure`?");
    let wrong = frames(vec![receive("GaugeState", vec![input(0, "Mode", When::Bit(3))])], vec![]);
    assert_eq!(problem(&wrong), "`Mode` has 3 bits, and no bit 3; -");
    let wrong = frames(vec![receive("GaugeState", vec![input(0, "Level", When::Equals(1.2))])], vec![]);
    assert_eq!(problem(&wrong), "`Level` is never 1.2 mm; the nearest value is 1");
    let wrong = frames(vec![], vec![send(vec![output(0, "Valve", 4.0)])]);
    assert_eq!(problem(&wrong), "`Valve` cannot be 4; it has 2 bits");
    let wrong = frames(vec![], vec![send(vec![output(0, "Valve", 1.0), output(1, "Valve", 2.0)])]);
    assert_eq!(problem(&wrong), "`Valve` is given two values; -");
    let mut wrong = send(vec![]);
    wrong.checksum = Some((named("Setpoint"), Checksum::Xor));
    assert_eq!(
        problem(&frames(vec![], vec![wrong])),
        "`Setpoint` is not one whole byte; such checksums are kept in one whole byte"
    );
    let mut wrong = send(vec![output(0, "Hours", 1.0)]);
    wrong.message = named("GaugeDetail");
    assert_eq!(
        problem(&frames(vec![], vec![wrong])).split(';').next(),
        Some("`Hours` is not in the frame that is sent")
    );
}

/// `[-5|300]` in the file; its bits would hold -332.68 to 322.67 bar.
#[test]
fn a_value_beyond_the_files_limits_is_none() {
    let bound = |signal: &str, when| {
        let message = if signal == "Temperature" { "GaugeDetail" } else { "GaugeState" };
        let inputs = vec![input(0, signal, when), input(1, signal, when)];
        bind(&frames(vec![receive(message, inputs)], vec![]), &gauge()).expect("it fits").heard[0].pages[0].clone()
    };
    let page = bound("Pressure", When::NotZero);
    let (field, least, most) = page.limits[0];
    assert_eq!((page.limits.len(), least, most), (1, field.value(0), field.value(30500)));
    let unsound = |bits: i16| {
        let mut data = [0; 8];
        field.put(&mut data, bits as u16 as u64);
        page.unsound(&data)
    };
    assert_eq!([-1, 0, 30500, 30501].map(|bits| unsound(bits).is_none()), [false, true, true, false]);
    assert_eq!(
        unsound(-1).map(|why| why.to_string()).unwrap(),
        "its signal at bit 0 is beyond its limits in the DBC file"
    );
    // Mode has [0|7], as its bits do; Temperature has [0|0], which is nothing.
    assert!(bound("Mode", When::NotZero).limits.is_empty());
    let page = bound("Temperature", When::NotZero);
    assert!(page.limits.is_empty());
    for (value, why) in
        [(-40.0, None), (f32::NAN, Some(SignalError::Number(8))), (f32::INFINITY, Some(SignalError::Number(8)))]
    {
        let mut data = [0; 8];
        data[1..5].copy_from_slice(&value.to_le_bytes());
        assert_eq!(page.unsound(&data), why, "{value}");
    }
}

#[test]
fn a_limit_is_within_what_a_signal_can_be() {
    let limit =
        |signal: &str, when| problem(&frames(vec![receive("GaugeState", vec![input(0, signal, when)])], vec![]));
    assert_eq!(
        limit("Mode", When::Above { at: 0.0, hysteresis: 0.0 }),
        "`Mode` has a limit that is never left again: 0; by gauge.dbc it has values from 0 to 7"
    );
    assert_eq!(
        limit("Mode", When::Below { at: -1.0, hysteresis: 0.0 }),
        "`Mode` has a limit that is never reached: -1; by gauge.dbc it has values from 0 to 7"
    );
    // Its bits would hold it, the file does not.
    assert_eq!(
        limit("Pressure", When::Above { at: 310.0, hysteresis: 0.2 }),
        "`Pressure` has a limit that is never reached: 310 bar; by gauge.dbc it has values from -5 to 300 bar"
    );
    assert_eq!(
        limit("Pressure", When::Equals(310.0)),
        "`Pressure` is never 310 bar; by gauge.dbc it has values from -5 to 300 bar"
    );
    let elsewhere = String::from_utf8_lossy(GAUGE).replace("[0|7]", "[8|9]");
    let wrong = frames(vec![receive("GaugeState", vec![input(0, "Mode", When::NotZero)])], vec![]);
    let problems = bind(&wrong, &read(elsewhere.as_bytes()).expect("a sound file")).expect_err("no value is any");
    assert_eq!(problems[0].message, "no value of `Mode` is within its limits in gauge.dbc");
}

fn detail(page: f64, outputs: Vec<SignalOutput>) -> CyclicFrame {
    CyclicFrame { message: named("GaugeDetail"), set: vec![(named("Page"), page)], ..send(outputs) }
}

#[test]
fn a_message_in_two_forms_shows_in_each_which_it_is() {
    let two = vec![detail(0.0, vec![output(0, "Temperature", 1.0)]), detail(1.0, vec![output(1, "Hours", 1.0)])];
    let bound = bind(&frames(vec![], two), &gauge()).expect("it fits");
    assert_eq!((bound.told[0].rest[0], bound.told[1].rest[0]), (0, 1));
    let twice = vec![detail(1.0, vec![]), detail(1.0, vec![output(1, "Hours", 1.0)])];
    assert_eq!(
        problem(&frames(vec![], twice)),
        "message `GaugeDetail` is sent twice; \
         put all its signals into one entry, or give `Page` another value in `set` of each"
    );
    let twice = vec![send(vec![output(0, "Valve", 1.0)]), send(vec![output(1, "Setpoint", 2.0)])];
    assert_eq!(
        problem(&frames(vec![], twice)),
        "message `GaugeCommand` is sent twice; put all its signals into one entry"
    );
    let mut two = vec![detail(0.0, vec![]), detail(1.0, vec![])];
    two[1].checksum = None;
    two[0].checksum = Some((named("Page"), Checksum::Xor));
    two[0].set.clear();
    assert!(bind(&frames(vec![], two), &gauge()).is_err(), "the selector is nothing else as well");
}

#[test]
fn a_signal_has_one_meaning_and_bits_of_its_own() {
    let mut both = send(vec![]);
    (both.counter, both.checksum) = (Some(named("Check")), Some((named("Check"), Checksum::Xor)));
    assert_eq!(problem(&frames(vec![], vec![both])), "`Check` is given two values; -");
    let mut both = receive("GaugeState", vec![]);
    (both.counter, both.checksum) = (Some(named("Check")), Some((named("Check"), Checksum::Xor)));
    assert_eq!(problem(&frames(vec![both], vec![])), "`Check` is given two values; -");
    let mut selector = detail(0.0, vec![output(0, "Hours", 1.0), output(1, "Page", 1.0)]);
    selector.set.clear();
    selector.outputs[1].off = 1.0;
    selector.outputs[1].on = 0.0;
    assert_eq!(
        problem(&frames(vec![], vec![selector])),
        "`Page` selects what is in the frame, and changes; give it one value, in `set`"
    );
    let overlapping = String::from_utf8_lossy(GAUGE).replace("Valve : 0|2", "Valve : 0|5");
    let mut wrong = send(vec![output(0, "Valve", 1.0)]);
    wrong.counter = Some(named("Count"));
    let problems = bind(&frames(vec![], vec![wrong]), &read(overlapping.as_bytes()).expect("a sound file"))
        .expect_err("they meet");
    assert_eq!(
        problems.iter().map(|problem| problem.message.as_str()).collect::<Vec<_>>(),
        ["`Count` and `Valve` share bits"]
    );
}
