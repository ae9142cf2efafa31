//! The simulated drive on its own, led through the figure of the profile by controlwords as a technician would send
//! them: every state and every transition, on the wire.

use std::time::Duration;

use crate::drive_bench::described;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{AtRest, Tick, Timing};
use linewright_plant::{DeviceOutbox, DriveNode, MotionFault};

struct Bench {
    node: DriveNode,
    now: Tick,
    sent: Vec<String>,
}

impl Bench {
    /// Just switched on.
    fn new() -> Self {
        let id = NodeId::new(5).expect("a node id");
        let now = Tick::from_millis(1000);
        let node = DriveNode::new(now, id, &described(AtRest::Off, false), 0.0, &Timing::default());
        Bench { node, now, sent: Vec::new() }
    }

    /// Started, with the mapping it has after a boot: controlword in, statusword out.
    fn started() -> Self {
        let mut bench = Bench::new();
        bench.pass(30);
        bench.hear("000#0105");
        bench
    }

    fn enabled() -> Self {
        let mut bench = Bench::started();
        for word in [0x06, 0x07, 0x0F] {
            bench.word(word);
        }
        bench
    }

    /// Enabled, and at full speed on a long way.
    fn moving() -> Self {
        let mut bench = Bench::enabled();
        bench.put(0x6081, 4, 10_000);
        bench.put(0x6083, 4, 1_000_000);
        bench.put(0x607A, 4, 1_000_000);
        bench.word(0x3F);
        bench.pass(50);
        assert_eq!(bench.speed(), 10_000.0);
        bench
    }

    fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(due) = self.node.next_deadline().filter(|due| *due <= until) {
            self.now = due;
            let mut out = DeviceOutbox::default();
            self.node.poll(due, &mut out);
            self.sent.extend(out.frames.iter().map(Frame::to_string));
        }
        self.now = until;
    }

    fn hear(&mut self, text: &str) {
        let mut out = DeviceOutbox::default();
        self.node.handle(self.now, &text.parse().expect("a frame"), &mut out);
        self.sent.extend(out.frames.iter().map(Frame::to_string));
    }

    /// Sends a controlword; the state that the statusword then says, as the table of the standard has its bits.
    fn word(&mut self, word: u16) -> &'static str {
        let [low, high] = word.to_le_bytes();
        self.hear(&format!("205#{low:02X}{high:02X}"));
        self.state()
    }

    fn state(&mut self) -> &'static str {
        self.sent.clear();
        self.hear("605#4041600000000000");
        let answer = self.sent.pop().expect("an answer");
        let byte = |at: usize| u16::from_str_radix(&answer[4 + 2 * at..6 + 2 * at], 16).expect("hexadecimal");
        let word = byte(4) | byte(5) << 8;
        match (word & 0x4F, word >> 5 & 1) {
            (0x00, _) => "not ready",
            (0x40, _) => "disabled",
            (0x01, 1) => "ready",
            (0x03, 1) => "on",
            (0x07, 1) => "enabled",
            (0x07, 0) => "quick stop",
            (0x0F, _) => "reaction",
            (0x08, _) => "fault",
            _ => panic!("{word:04X} is no state"),
        }
    }

    fn put(&mut self, index: u16, len: u8, value: u32) {
        let data: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect();
        let [low, high] = index.to_le_bytes();
        self.sent.clear();
        self.hear(&format!("605#{:02X}{low:02X}{high:02X}00{data}", 0x23 | (4 - len) << 2));
        assert!(self.sent.iter().any(|frame| frame.starts_with("585#60")), "{:?}", self.sent);
    }

    fn speed(&self) -> f64 {
        self.node.speed(self.now)
    }
}

#[test]
fn from_nothing_to_enabled_and_back_by_every_arrow() {
    let mut bench = Bench::new();
    bench.pass(10);
    // 0 and 1 happen by themselves; before that it does not answer.
    bench.pass(20);
    assert!(bench.sent.contains(&"705#00".to_owned()));
    assert_eq!(bench.state(), "disabled");
    bench.hear("000#0105");
    for (word, state) in [
        (0x07, "disabled"), // not from here
        (0x06, "ready"),    // 2
        (0x00, "disabled"), // 7
        (0x06, "ready"),
        (0x02, "disabled"), // 7, by quick stop
        (0x06, "ready"),
        (0x07, "on"),    // 3
        (0x06, "ready"), // 6
        (0x07, "on"),
        (0x00, "disabled"), // 10
        (0x06, "ready"),
        (0x07, "on"),
        (0x02, "disabled"), // 10, by quick stop
        (0x06, "ready"),
        (0x0F, "enabled"), // 3 and 4 in one
        (0x07, "on"),      // 5
        (0x0F, "enabled"), // 4
        (0x06, "ready"),   // 8
        (0x0F, "enabled"),
        (0x00, "disabled"), // 9
        (0x0F, "disabled"), // not from here
        (0x80, "disabled"), // nothing to reset
    ] {
        assert_eq!(bench.word(word), state, "after {word:02X}");
    }
}

#[test]
fn quick_stop_brakes_and_then_does_what_its_option_says() {
    // Option, ms until it stands at 10 000/s with 50 000/s² (quick stop) or 10 000/s² (slow down), the state then.
    for (option, millis, end) in
        [(1u32, 1000, "disabled"), (2, 200, "disabled"), (5, 1000, "quick stop"), (6, 200, "quick stop")]
    {
        let mut bench = Bench::moving();
        bench.put(0x605A, 2, option);
        assert_eq!(bench.word(0x02), "quick stop", "11");
        bench.pass(millis - 1);
        assert!(bench.speed() > 0.0 && bench.state() == "quick stop", "{option}");
        bench.pass(2);
        assert_eq!((bench.speed(), bench.state()), (0.0, end), "{option}: 12");
        let again = bench.word(0x0F);
        assert_eq!(again, if option > 4 { "enabled" } else { "disabled" }, "{option}: 16");
    }
    let mut bench = Bench::moving();
    bench.put(0x605A, 2, 6);
    bench.word(0x02);
    assert_eq!(bench.word(0x00), "disabled", "12, by command");
}

#[test]
fn disabling_waits_for_the_ramp_where_its_option_says_so() {
    for (word, object, end) in [(0x07u16, 0x605C, "on"), (0x06, 0x605B, "ready")] {
        let mut bench = Bench::moving();
        bench.put(object, 2, 1);
        assert_eq!(bench.word(word), "enabled");
        bench.pass(999);
        assert_eq!(bench.state(), "enabled");
        bench.pass(2);
        assert_eq!((bench.speed(), bench.state()), (0.0, end));
        let mut bench = Bench::moving();
        bench.put(object, 2, 0);
        assert_eq!(bench.word(word), end, "at once; the brake does the rest");
        bench.pass(201);
        assert_eq!(bench.speed(), 0.0);
    }
}

#[test]
fn a_fault_reacts_fails_and_is_reset_by_an_edge() {
    let mut bench = Bench::moving();
    let mut out = DeviceOutbox::default();
    bench.node.fail(bench.now, Some(MotionFault::Break), &mut out);
    assert!(out.frames.iter().any(|frame| frame.to_string() == "085#0573210000000000"), "{:?}", out.frames);
    assert_eq!(bench.state(), "reaction", "13");
    assert_eq!(bench.word(0x80), "reaction", "not to be reset yet");
    bench.pass(201);
    assert_eq!((bench.state(), bench.speed()), ("fault", 0.0), "14");
    assert_eq!(bench.word(0x80), "fault", "the bit was set already");
    for word in [0x06, 0x07, 0x0F, 0x00] {
        assert_eq!(bench.word(word), "fault");
    }
    assert_eq!(bench.word(0x80), "disabled", "15");
}

#[test]
fn a_set_point_is_taken_on_the_edge_and_acknowledged_until_it_falls() {
    let mut bench = Bench::enabled();
    let acknowledged = |bench: &mut Bench| {
        bench.sent.clear();
        bench.hear("605#4041600000000000");
        u8::from_str_radix(&bench.sent[0][14..16], 16).expect("hexadecimal") & 0x10 != 0
    };
    bench.put(0x607A, 4, 500);
    bench.word(0x2F);
    assert!(!acknowledged(&mut bench));
    bench.word(0x3F);
    assert!(acknowledged(&mut bench));
    bench.pass(2000);
    assert_eq!(bench.node.place(bench.now), 500.0);
    bench.put(0x607A, 4, 900);
    bench.word(0x3F);
    bench.pass(2000);
    assert_eq!(bench.node.place(bench.now), 500.0, "no edge");
    bench.word(0x2F);
    assert!(!acknowledged(&mut bench));
    // Without "change immediately" the second waits for the first; relative it counts from there.
    bench.word(0x1F);
    bench.word(0x0F);
    bench.put(0x607A, 4, -100i32 as u32);
    bench.word(0x5F);
    assert!(acknowledged(&mut bench));
    bench.word(0x4F);
    assert!(acknowledged(&mut bench), "there is no room for a third");
    bench.pass(5000);
    assert_eq!(bench.node.place(bench.now), 800.0);
    assert!(!acknowledged(&mut bench));
}

#[test]
fn halt_stands_and_goes_on() {
    let mut bench = Bench::moving();
    bench.word(0x012F);
    bench.pass(1100);
    assert_eq!((bench.speed(), bench.state()), (0.0, "enabled"));
    bench.word(0x2F);
    bench.pass(100);
    assert!(bench.speed() > 0.0);
}

#[test]
fn without_its_manager_it_does_what_its_option_says() {
    for (option, end) in [(1u32, "fault"), (2, "disabled"), (3, "disabled"), (0, "enabled")] {
        let mut bench = Bench::moving();
        bench.put(0x6007, 2, option);
        bench.hear("77F#05");
        bench.pass(199);
        assert_eq!(bench.state(), "enabled");
        bench.pass(700);
        assert_eq!(bench.state(), end, "{option}");
        assert_eq!(bench.speed() == 0.0, option != 0);
    }
}

#[test]
fn whatever_is_sent_to_it_it_answers_or_not_and_goes_on() {
    let mut random = 0x9E37_79B9_97F4_A7C1u64;
    let mut bench = Bench::started();
    for _ in 0..20_000 {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        let ids = [0x000, 0x205, 0x605, 0x77F, 0x705];
        let id = ids[(random >> 8) as usize % ids.len()];
        let data = random.rotate_left(29).to_le_bytes();
        let mut data = data[..(random >> 16) as usize % 9].to_vec();
        // Mostly things that mean something.
        if id == 0x605 && data.len() == 8 && random >> 20 & 3 != 0 {
            let at = 0x6000 + (random >> 40) as u16 % 0x100;
            data[0] = [0x2F, 0x2B, 0x23, 0x40][(random >> 24) as usize % 4];
            data[1..3].copy_from_slice(&at.to_le_bytes());
            data[3] = 0;
        }
        let mut out = DeviceOutbox::default();
        bench.node.handle(bench.now, &Frame::data_frame(id, &data).expect("a frame"), &mut out);
        assert!(out.frames.len() < 200);
        bench.pass(random >> 60);
        assert!(bench.node.place(bench.now).is_finite() && bench.speed().is_finite());
        assert!(bench.node.next_deadline().is_none_or(|due| due >= bench.now));
    }
}
