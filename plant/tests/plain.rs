//! A device that speaks no CANopen, from its description and DBC file on: manager and simulated plant together.

use std::time::Duration;

use linewright_canopen::{BusEvent, BusOutbox, Manager};
use linewright_line::{DeviceBus, DeviceKind, Line, Owner, StationId, Tick};
use linewright_plant::{DeviceFault, PlantOptions, Rack};

const OWNER: Owner = Owner::Station(StationId(0));
const ADVANCE: u128 = 1;
const RETURN: u128 = 2;

/// A press whose valves and switches hang on a box that speaks frames of its own.
const LINE: &str = r#"
name = "pressing"

[[station]]
name = "press"
home = "return"
axes = { ram = 0.0 }

[[station.operation]]
name = "advance"
module = "R"
moves = { axis = "ram", from = 0, to = 80 }
duration_s = 0.2
watchdog_s = 1.0
normal = { actuator = "forward", complete = "front" }
recovery = { actuator = "back", complete = "rear" }
hand = { type = 6, forward = "PB_1", back = "PB_2", next = "PB_2" }

[[station.operation]]
name = "return"
module = "R"
moves = { axis = "ram", from = 80, to = 0 }
duration_s = 0.2
watchdog_s = 1.0
normal = { actuator = "back", complete = "rear" }
recovery = { actuator = "forward", complete = "front" }
hand = { type = 6, forward = "PB_2", back = "PB_1", next = "PB_1" }

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
    let buttons = text.replacen("name = \"pressing\"", "name = \"pressing\"\nbuttons = [\"PB_1\", \"PB_2\"]", 1);
    let mut line = match linewright_line::parse("line.toml", &buttons) {
        Ok(parsed) => parsed.line,
        Err(problems) => panic!("{problems:#}"),
    };
    let database = linewright_dbc::read(file.as_bytes()).expect("a sound file");
    let DeviceKind::Frames(frames) = &mut line.devices[0].kind else { panic!("a device of frames") };
    frames.bound = Some(linewright_dbc::bind(frames, &database).expect("it fits"));
    line
}

struct Bench {
    now: Tick,
    manager: Manager,
    rack: Rack,
    /// Frames from the manager get lost.
    cut: bool,
    events: Vec<BusEvent>,
}

impl Bench {
    fn new() -> Self {
        Bench::with(LINE, BOX)
    }

    fn with(text: &str, file: &str) -> Self {
        let (line, now) = (line(text, file), Tick::from_millis(100));
        let mut bench = Bench {
            now,
            manager: Manager::new(&line.devices, line.timing).expect("the device"),
            rack: Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default()),
            cut: false,
            events: Vec::new(),
        };
        // The manager listens for another one first.
        bench.run(200);
        bench
    }

    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            let (mut out, mut own) = (BusOutbox::default(), Vec::new());
            self.rack.poll(self.now, &mut own);
            self.manager.poll(self.now, &mut out);
            self.carry(out, own);
        }
    }

    fn set(&mut self, image: u128) {
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, OWNER, image, &mut out);
        self.carry(out, Vec::new());
    }

    fn carry(&mut self, mut out: BusOutbox, mut own: Vec<linewright_canopen::Frame>) {
        while !out.frames.is_empty() || !own.is_empty() {
            let (there, back) = (std::mem::take(&mut out.frames), std::mem::take(&mut own));
            for frame in there.iter().filter(|_| !self.cut) {
                self.rack.handle(self.now, frame, &mut own);
            }
            for frame in &back {
                self.manager.handle(self.now, frame, &mut out);
            }
        }
        self.events.append(&mut out.events);
    }

    /// Front, rear; `None` while they cannot be trusted.
    fn inputs(&self) -> Option<(bool, bool)> {
        let image = self.manager.inputs(self.now, OWNER);
        image.valid.then_some((image.bits & 1 != 0, image.bits & 2 != 0))
    }

    fn fail(&mut self, fault: Option<DeviceFault>) {
        self.rack.plain_mut("valve box").expect("the box").inject(self.now, fault);
    }
}

#[test]
fn outputs_move_the_ram_and_inputs_say_where_it_is() {
    let mut bench = Bench::new();
    bench.run(20);
    assert_eq!(bench.inputs(), Some((false, true)));
    bench.set(ADVANCE);
    bench.run(100);
    assert_eq!(bench.inputs(), Some((false, false)), "on the way");
    bench.run(110);
    assert_eq!(bench.inputs(), Some((true, false)));
    bench.set(RETURN);
    bench.run(210);
    assert_eq!(bench.inputs(), Some((false, true)));
    assert!(!bench.events.iter().any(|event| matches!(event, BusEvent::FramesLost { .. } | BusEvent::Ignored { .. })));
}

/// 0 mm, which is what it would send otherwise while the ram is at neither end, is beyond the limits.
#[test]
fn it_sends_nothing_that_its_file_says_is_no_value() {
    let file = BOX.replace("[-100|200]", "[0.1|79.6]");
    let mut bench = Bench::with(LINE, &file);
    bench.run(20);
    assert_eq!(bench.inputs(), Some((false, true)));
    bench.set(ADVANCE);
    for _ in 0..250 {
        bench.run(1);
        assert!(bench.inputs().is_some());
    }
    assert_eq!(bench.inputs(), Some((true, false)));
    assert!(!bench.events.iter().any(|event| matches!(event, BusEvent::FramesLost { .. })));
}

/// A form for each valve. By the device's counter, which is one, no frame is taken for the one before it.
#[test]
fn a_message_in_two_forms_moves_the_ram() {
    let (head, tail) = LINE.split_once("send = [").expect("what it is sent");
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
    let mut bench = Bench::with(&line, &file);
    bench.run(20);
    bench.set(ADVANCE);
    bench.run(220);
    assert_eq!(bench.inputs(), Some((true, false)));
    bench.set(RETURN);
    bench.run(220);
    assert_eq!(bench.inputs(), Some((false, true)));
}

#[test]
fn one_that_is_unplugged_lets_go_and_so_does_its_owner() {
    let mut bench = Bench::new();
    bench.run(20);
    bench.set(ADVANCE);
    bench.run(50);
    bench.fail(Some(DeviceFault::Silent));
    bench.run(41);
    assert_eq!(bench.inputs(), None);
    let stands = bench.rack.plant().outputs(OWNER);
    assert_eq!(stands, 0, "its own time-out, 30 ms");
    bench.fail(None);
    bench.run(20);
    assert!(bench.inputs().is_some());
    assert_eq!(bench.rack.plant().outputs(OWNER), 0, "what was ordered before is forgotten");
    bench.set(ADVANCE);
    bench.run(210);
    assert_eq!(bench.inputs(), Some((true, false)));
}

#[test]
fn without_its_manager_it_lets_go_by_itself() {
    let mut bench = Bench::new();
    bench.run(20);
    bench.set(ADVANCE);
    bench.run(50);
    assert_eq!(bench.rack.plant().outputs(OWNER), ADVANCE);
    bench.cut = true;
    bench.run(31);
    assert_eq!(bench.rack.plant().outputs(OWNER), 0);
}
