//! Rules about process data that wait for SYNC, and about devices without CANopen: each broken once.

use std::sync::LazyLock;
use std::time::Duration;

use linewright_line::{
    Device, FrameBinding, FrameId, InputId, Owner, ReceivedFrameBinding, StationId, TransferLine, Transmission, When,
    duration_text, parse,
};
use linewright_testkit::presses::PRESSING;

pub static LINE: LazyLock<String> = LazyLock::new(|| PRESSING.to_owned() + DEVICES);

const DEVICES: &str = r#"
[timing]
sync_ms = 10

[[device]]
name = "io"
station = "press"
node = 4
inputs = ["front"]
outputs = ["forward"]
transmission = { inputs = 2, outputs = 1 }

[[device]]
name = "box"
station = "press"

[device.dbc]
file = "box.dbc"
receive = [{ message = "State", timeout_ms = 40, counter = "Alive", inputs = [
    { input = "rear", signal = "Place", below = 0.5, hysteresis = 0.1 },
] }]
send = [{ message = "Command", every_ms = 10, lets_go_after_ms = 30, checksum = { signal = "Check", kind = "sum" }, outputs = [
    { output = "back", signal = "Back", on = 3 },
] }]
"#;

fn devices(text: &str) -> Vec<Device> {
    match parse("line.toml", text) {
        Ok(parsed) => parsed.line.devices,
        Err(problems) => panic!("{problems:#}"),
    }
}

/// The problem that an edit raises, and the words it points to.
fn problem(old: &str, new: &str) -> (String, String) {
    assert!(LINE.contains(old), "{old}");
    let text = LINE.replacen(old, new, 1);
    let problems = match parse("line.toml", &text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec().into_iter().filter(|problem| !problem.is_warning).collect(),
    };
    let first = problems.first().unwrap_or_else(|| panic!("nothing is wrong with {new}"));
    (first.message.clone(), text[first.span.clone()].to_owned())
}

fn raises(old: &str, new: &str, message: &str, place: &str) {
    let (found, at) = problem(old, new);
    assert!(found.starts_with(message) && at.starts_with(place), "{new}: {found} at {at}");
}

#[test]
fn what_is_said_of_them_is_there() {
    let devices = devices(&LINE);
    assert_eq!(
        devices[0].canopen().expect("CANopen").setup.transmission,
        Transmission { inputs: Some(2), outputs: Some(1) }
    );
    let frames = devices[1].frames().expect("a device of frames");
    assert_eq!((frames.file.name.as_str(), devices[1].node_id()), ("box.dbc", None));
    let input = &frames.receive[0].inputs[0];
    assert_eq!(input.when, When::Below { at: 0.5, hysteresis: 0.1 });
    assert_eq!(&LINE[input.signal.at.clone()], "\"Place\"");
    assert_eq!((frames.send[0].outputs[0].on, frames.send[0].outputs[0].off), (3.0, 0.0));
    assert_eq!(frames.source(input.input).as_deref(), Some("State.Place"));
    let mut read = frames.clone();
    let (name, id, timeout) = ("State".to_owned(), FrameId { id: 0x18FE_F100, extended: true }, Duration::ZERO);
    let heard = ReceivedFrameBinding { name, id, len: 8, timeout, counter: None, checksum: None, pages: Vec::new() };
    read.bound = Some(FrameBinding { heard: vec![heard], told: Vec::new() });
    assert_eq!(read.source(input.input).as_deref(), Some("18FEF100h State.Place"));
    assert_eq!(devices[1].carried_inputs().len() + devices[0].carried_inputs().len(), 2);
    assert_eq!(devices[1].carried_outputs().len(), 1);
}

#[test]
fn sync_must_be_sent_and_heard() {
    raises("sync_ms = 10", "", "process data with SYNC, but nobody sends it", "2");
    raises("inputs = 2, outputs = 1", "inputs = 0, outputs = 255", "0 is no transmission type", "0");
    raises("inputs = 2, outputs = 1", "inputs = 2, outputs = 241", "241 is no transmission type", "241");
    let alone = "outputs that wait for SYNC, without inputs that come with it";
    raises("inputs = 2, outputs = 1", "outputs = 7", alone, "7");
    raises("inputs = 2, outputs = 1", "inputs = 255, outputs = 7", alone, "7");
    assert_eq!(devices(&LINE.replace("inputs = 2, outputs = 1", "inputs = 240")).len(), 2);
    assert_eq!(devices(&LINE.replace("inputs = 2, outputs = 1", "outputs = 255")).len(), 2);
}

#[test]
fn a_device_without_canopen_is_described_by_its_frames_alone() {
    let old = "name = \"box\"\nstation = \"press\"\n";
    let with = |more: &str| format!("{old}{more}\n");
    raises(old, &with("node = 5"), "a device with a `dbc` table has no `node`", "5");
    let identity = "a device with a `dbc` table has no `identity`";
    raises(old, &with("identity = { vendor = 7 }"), identity, "7");
    raises(old, &with("inputs = [\"x\"]"), "a device with a `dbc` table has no `inputs` and `outputs`", "\"x\"");
    raises(old, &with("file = \"box.eds\""), "a device with a `dbc` table has no `file`", "\"box.eds\"");
    raises(old, &with("when_lost = \"report\""), "a device with a `dbc` table has no `when_lost`", "\"report\"");
    raises("node = 4\n", "", "a device needs `node`", "[[device]]");
    raises("file = \"box.dbc\"\n", "", "`dbc` needs `file`", "[device.dbc]");
    raises("timeout_ms = 40, ", "", "a message received needs `timeout_ms`", "{ message");
    raises("kind = \"sum\"", "kind = \"crc\"", "unknown kind `crc`", "\"crc\"");
}

#[test]
fn outputs_of_a_device_without_canopen_need_a_time_out_or_are_reported() {
    let warnings = |text: &str| {
        let parsed = parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
        parsed
            .warnings
            .into_iter()
            .map(|warning| warning.message)
            .filter(|text| text.contains("time-out"))
            .collect::<Vec<_>>()
    };
    let silent = LINE.replace("lets_go_after_ms = 30, ", "");
    assert_eq!(warnings(&silent), ["`back` has no time-out: it may stay on without a manager"]);
    assert_eq!(warnings(&LINE), [""; 0]);
    raises(
        "lets_go_after_ms = 30",
        "lets_go_after_ms = 10",
        "this device lets go of its outputs before the next message comes",
        "10",
    );
    let with = "name = \"box\"\nstation = \"press\"\nwithout_error_values = \"none\"\n";
    raises(
        "name = \"box\"\nstation = \"press\"\n",
        with,
        "a device with a `dbc` table has no `without_error_values`",
        "\"none\"",
    );
}

#[test]
fn a_condition_is_one() {
    let old = "below = 0.5, hysteresis = 0.1";
    raises(old, "below = 0.5, equals = 1", "an input that is on for two reasons", "{ input");
    raises(old, "bit = 64", "a signal has no bit 64", "64");
    raises(old, "below = 0.5, hysteresis = -1", "a hysteresis below zero", "-1");
    raises(old, "equals = 1, hysteresis = 1", "a hysteresis without a limit", "1");
    raises(old, "below = nan", "`below` is NaN", "nan");
    raises("on = 3", "on = 0", "`back` is 0 when on, and when off", "\"back\"");
}

#[test]
fn a_signal_is_named_with_device_node_object_and_bit() {
    let line = parse("line.toml", &TransferLine::default().text()).expect("parses").line;
    let text = |station: &str, input: &str| {
        let id = line.station_named(station).expect("there");
        let at = line.station(id).inputs.iter().position(|name| name == input).expect("there");
        line.input_text(Owner::Station(id), InputId(u16::try_from(at).expect("small")))
    };
    assert_eq!(text("clamp_1", "LS_closed"), "LS_closed (clamp 1 io, node 21h, 6000h:01 bit 1)");
    assert_eq!(text("transfer", "LS_horizontal_500"), "LS_horizontal_500 (transfer io, node 11h, 6000h:02 bit 1)");
    let mut bare = line.clone();
    bare.devices.clear();
    assert_eq!(bare.input_text(Owner::Station(StationId(1)), InputId(0)), "LS_open");
    assert_eq!(line.input_text(Owner::Console, InputId(999)), "an input");
    let texts = [250, 1000, 1500].map(|millis| duration_text(Duration::from_millis(millis)));
    assert_eq!(texts, ["250 ms", "1 s", "1.5 s"]);
}
