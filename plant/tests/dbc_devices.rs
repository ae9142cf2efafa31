//! A device without CANopen, from its description and DBC file on: manager and simulated plant together.

use linewright_canopen::BusEvent;
use linewright_line::{DeviceKind, Line};
use linewright_plant::DeviceFault;

use crate::managed::Managed;
use linewright_testkit::presses::PRESSING;

const ADVANCE: u128 = 1;
const RETURN: u128 = 2;

/// The valves and switches of the press hang on a box with frames of its own.
const DEVICE: &str = r#"
[[device]]
name = "valve box"
station = "press"

[device.dbc]
file = "box.dbc"
receive = [{ message = "BoxState", timeout_ms = 40, counter = "Alive", checksum = { signal = "Check", kind = "crc8" }, inputs = [
    { input = "front", signal = "Place", above = 79.5, hysteresis = 0.4 },
    { input = "rear", signal = "Place", below = 0.5 },
] }]
send = [{ message = "BoxCommand", every_ms = 10, counter = "Count", checksum = { signal = "Check", kind = "xor" }, outputs = [
    { output = "forward", signal = "Forward" },
    { output = "back", signal = "Back", on = 3 },
] }]
"#;

const BOX: &str = r#"VERSION ""

NS_ :

BS_:

BU_: Box Controller

BO_ 2564817408 BoxState: 8 Box
 SG_ Place : 7|16@0- (0.1,0) [-100|200] "mm" Controller
 SG_ Alive : 16|4@1+ (1,0) [0|15] "" Controller
 SG_ Check : 56|8@1+ (1,0) [0|255] "" Controller

BO_ 320 BoxCommand: 3 Controller
 SG_ Forward : 0|1@1+ (1,0) [0|1] "" Box
 SG_ Back : 4|2@1+ (1,0) [0|3] "" Box
 SG_ Count : 8|8@1+ (1,0) [0|255] "" Box
 SG_ Check : 16|8@1+ (1,0) [0|255] "" Box
"#;

fn line(text: &str, file: &str) -> Line {
    let mut line = match linewright_line::parse("line.toml", &format!("{PRESSING}{text}")) {
        Ok(parsed) => parsed.line,
        Err(problems) => panic!("{problems:#}"),
    };
    let database = linewright_dbc::read(file.as_bytes()).expect("a sound file");
    let DeviceKind::Frames(frames) = &mut line.devices[0].kind else { panic!("a device of frames") };
    frames.bound = Some(linewright_dbc::bind(frames, &database).expect("it fits"));
    line
}

fn up(text: &str, file: &str) -> Managed {
    Managed::up(&line(text, file))
}

/// Front, rear; `None` while they cannot be trusted.
fn inputs(bus: &Managed) -> Option<(bool, bool)> {
    bus.is_valid().then(|| (bus.bits() & 1 != 0, bus.bits() & 2 != 0))
}

fn fail(bus: &mut Managed, fault: Option<DeviceFault>) {
    let device = line(DEVICE, BOX).devices.remove(0);
    bus.rack.fail_device(bus.now, &device, fault);
}

#[test]
fn outputs_move_the_ram_and_inputs_say_where_it_is() {
    let mut bus = up(DEVICE, BOX);
    assert_eq!(inputs(&bus), Some((false, true)));
    bus.set(ADVANCE);
    bus.run(100);
    assert_eq!(inputs(&bus), Some((false, false)), "on the way");
    bus.run(110);
    assert_eq!(inputs(&bus), Some((true, false)));
    bus.set(RETURN);
    bus.run(210);
    assert_eq!(inputs(&bus), Some((false, true)));
    assert!(!bus.events.iter().any(|event| matches!(event, BusEvent::FramesLost { .. } | BusEvent::Ignored { .. })));
}

/// 0 mm, which is what it would send otherwise while the ram is at neither end, is beyond the limits.
#[test]
fn it_sends_nothing_that_its_file_says_is_no_value() {
    let file = BOX.replace("[-100|200]", "[0.1|79.6]");
    let mut bus = up(DEVICE, &file);
    assert_eq!(inputs(&bus), Some((false, true)));
    bus.set(ADVANCE);
    for _ in 0..250 {
        bus.run(1);
        assert!(inputs(&bus).is_some());
    }
    assert_eq!(inputs(&bus), Some((true, false)));
    assert!(!bus.events.iter().any(|event| matches!(event, BusEvent::FramesLost { .. })));
}

/// A form for each valve. By the device's counter, which is one, no frame is taken for the one before it.
#[test]
fn a_message_in_two_forms_moves_the_ram() {
    let (head, tail) = DEVICE.split_once("send = [").expect("what it is sent");
    assert!(tail.contains("Back"));
    let form = |which: u8, output: &str, signal: &str| {
        format!(
            r#"{{ message = "BoxCommand", every_ms = 10, counter = "Count", checksum = {{ signal = "Check", kind = "xor" }}, set = [{{ signal = "Which", value = {which} }}], outputs = [{{ output = "{output}", signal = "{signal}" }}] }}"#
        )
    };
    let line = format!("{head}send = [{}, {}]\n", form(0, "forward", "Forward"), form(1, "back", "Back"));
    let file = BOX.replace(
        " SG_ Forward : 0|1@1+ (1,0) [0|1] \"\" Box\n SG_ Back : 4|2",
        " SG_ Which M : 6|2@1+ (1,0) [0|3] \"\" Box\n SG_ Forward m0 : 0|1@1+ (1,0) [0|1] \"\" Box\n SG_ Back m1 : 0|2",
    );
    let mut bus = up(&line, &file);
    bus.set(ADVANCE);
    bus.run(220);
    assert_eq!(inputs(&bus), Some((true, false)));
    bus.set(RETURN);
    bus.run(220);
    assert_eq!(inputs(&bus), Some((false, true)));
}

#[test]
fn one_that_is_unplugged_lets_go_and_so_does_its_owner() {
    let mut bus = up(DEVICE, BOX);
    bus.set(ADVANCE);
    bus.run(50);
    fail(&mut bus, Some(DeviceFault::Silent));
    bus.run(41);
    assert_eq!(inputs(&bus), None);
    assert_eq!(bus.outputs(), 0, "its own time-out, 30 ms");
    fail(&mut bus, None);
    bus.run(20);
    assert!(inputs(&bus).is_some());
    assert_eq!(bus.outputs(), 0, "what was ordered before is forgotten");
    bus.set(ADVANCE);
    bus.run(210);
    assert_eq!(inputs(&bus), Some((true, false)));
}

#[test]
fn without_its_manager_it_lets_go_by_itself() {
    let mut bus = up(DEVICE, BOX);
    bus.set(ADVANCE);
    bus.run(50);
    assert_eq!(bus.outputs(), ADVANCE);
    bus.passes = |_| false;
    bus.run(31);
    assert_eq!(bus.outputs(), 0);
}
