//! The simulated drive on its own, led through the figure of the profile by controlwords as a technician would send
//! them: every state and every transition, on the wire.

use linewright_canopen::sdo::Abort;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{AtRest, Tick, Timing};
use linewright_plant::{CanDevice, DeviceOutbox, DriveNode, MotionFault};

use crate::alone::{Alone, refused};
use crate::drive_bench::described;

fn drive(now: Tick, node: NodeId) -> Box<DriveNode> {
    Box::new(DriveNode::new(now, node, &described(AtRest::Off, false), 0.0, &Timing::default()))
}

/// With the mapping it has after a boot: controlword in, statusword out.
fn started() -> Alone<Box<DriveNode>> {
    Alone::started(5, drive)
}

fn enabled() -> Alone<Box<DriveNode>> {
    let mut bench = started();
    for word in [0x06, 0x07, 0x0F] {
        bench.word(word);
    }
    bench
}

/// Enabled, and at full speed on a long way.
fn moving() -> Alone<Box<DriveNode>> {
    let mut bench = enabled();
    bench.put("6081", &10_000u32.to_le_bytes());
    bench.put("6083", &1_000_000u32.to_le_bytes());
    bench.put("607A", &1_000_000u32.to_le_bytes());
    bench.word(0x3F);
    bench.pass(50);
    assert_eq!(bench.speed(), 10_000.0);
    bench
}

impl Alone<Box<DriveNode>> {
    /// Sends a controlword; gives the state in the statusword then, as the table of the standard has its bits.
    fn word(&mut self, word: u16) -> &'static str {
        let [low, high] = word.to_le_bytes();
        self.hear(&format!("205#{low:02X}{high:02X}"));
        self.state()
    }

    fn statusword(&mut self) -> u16 {
        let bytes = self.read("6041").expect("it is not stopped");
        u16::from_le_bytes([bytes[0], bytes[1]])
    }

    fn state(&mut self) -> &'static str {
        let word = self.statusword();
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

    /// Whether a set-point is acknowledged.
    fn acknowledges(&mut self) -> bool {
        self.statusword() & 0x1000 != 0
    }

    fn put(&mut self, object: &str, data: &[u8]) {
        assert_eq!(self.write(object, data), Ok(()), "{object}");
    }

    fn speed(&self) -> f64 {
        self.device.speed(self.now)
    }
}

/// The effect of each controlword in each state is a table in `device/drive/machine.rs`, with a test of its own.
#[test]
fn from_nothing_to_enabled_and_back() {
    let mut bench = Alone::new(5, drive);
    bench.pass(20);
    // It leaves "not ready" by itself.
    assert_eq!(bench.take(), ["705#00"]);
    assert_eq!(bench.state(), "disabled");
    bench.hear("000#0105");
    for (word, state) in [
        (0x07, "disabled"), // not from here
        (0x06, "ready"),
        (0x07, "on"),
        (0x0F, "enabled"),
        (0x06, "ready"),
        (0x0F, "enabled"), // two arrows in one
        (0x00, "disabled"),
        (0x80, "disabled"), // nothing to reset
    ] {
        assert_eq!(bench.word(word), state, "after {word:02X}");
    }
}

#[test]
fn quick_stop_brakes_and_then_does_what_its_option_says() {
    // Option, ms until it stands at 10 000/s with 50 000/s² (quick stop) or 10 000/s² (slow down), the state then.
    for (option, millis, end) in
        [(1u16, 1000, "disabled"), (2, 200, "disabled"), (5, 1000, "quick stop"), (6, 200, "quick stop")]
    {
        let mut bench = moving();
        bench.put("605A", &option.to_le_bytes());
        assert_eq!(bench.word(0x02), "quick stop", "11");
        bench.pass(millis - 1);
        assert!(bench.speed() > 0.0 && bench.state() == "quick stop", "{option}");
        bench.pass(2);
        assert_eq!((bench.speed(), bench.state()), (0.0, end), "{option}: 12");
        let again = bench.word(0x0F);
        assert_eq!(again, if option > 4 { "enabled" } else { "disabled" }, "{option}: 16");
    }
    let mut bench = moving();
    bench.put("605A", &[6, 0]);
    bench.word(0x02);
    assert_eq!(bench.word(0x00), "disabled", "12, by command");
}

#[test]
fn disabling_waits_for_the_ramp_where_its_option_says_so() {
    for (word, object, end) in [(0x07, "605C", "on"), (0x06, "605B", "ready")] {
        let mut bench = moving();
        bench.put(object, &[1, 0]);
        assert_eq!(bench.word(word), "enabled");
        bench.pass(999);
        assert_eq!(bench.state(), "enabled");
        bench.pass(2);
        assert_eq!((bench.speed(), bench.state()), (0.0, end));
        let mut bench = moving();
        bench.put(object, &[0, 0]);
        assert_eq!(bench.word(word), end, "at once; the brake does the rest");
        bench.pass(201);
        assert_eq!(bench.speed(), 0.0);
    }
}

#[test]
fn a_fault_reacts_fails_and_is_reset_by_an_edge() {
    let mut bench = moving();
    let mut out = DeviceOutbox::default();
    bench.device.fail(bench.now, 0, Some(MotionFault::Break), &mut out);
    assert!(out.frames.iter().any(|frame| frame.to_string() == "085#0573210000000000"), "{:?}", out.frames);
    assert_eq!(bench.state(), "reaction", "13");
    assert_eq!(bench.word(0x80), "reaction", "not to be reset yet");
    bench.pass(201);
    assert_eq!((bench.state(), bench.speed()), ("fault", 0.0), "14");
    assert_eq!(bench.word(0x80), "fault", "the bit was set already");
    for word in [0x06, 0x07, 0x0F, 0x00] {
        assert_eq!(bench.word(word), "fault");
    }
    assert_eq!(bench.word(0x80), "fault", "its cause lasts");
    bench.device.fail(bench.now, 0, None, &mut out);
    bench.word(0x00);
    assert_eq!(bench.word(0x80), "disabled", "15");
}

#[test]
fn a_set_point_is_taken_on_the_edge_and_acknowledged_until_it_falls() {
    let mut bench = enabled();
    bench.put("607A", &500i32.to_le_bytes());
    bench.word(0x2F);
    assert!(!bench.acknowledges());
    bench.word(0x3F);
    assert!(bench.acknowledges());
    bench.pass(2000);
    assert_eq!(bench.device.place(bench.now), 500.0);
    bench.put("607A", &900i32.to_le_bytes());
    bench.word(0x3F);
    bench.pass(2000);
    assert_eq!(bench.device.place(bench.now), 500.0, "no edge");
    bench.word(0x2F);
    assert!(!bench.acknowledges());
    // Without "change immediately" the second waits for the first; relative it counts from there.
    bench.word(0x1F);
    bench.word(0x0F);
    bench.put("607A", &(-100i32).to_le_bytes());
    bench.word(0x5F);
    assert!(bench.acknowledges());
    bench.word(0x4F);
    assert!(bench.acknowledges(), "there is no room for a third");
    bench.pass(5000);
    assert_eq!(bench.device.place(bench.now), 800.0);
    assert!(!bench.acknowledges());
}

#[test]
fn halt_stands_and_goes_on() {
    let mut bench = moving();
    bench.word(0x012F);
    bench.pass(1100);
    assert_eq!((bench.speed(), bench.state()), (0.0, "enabled"));
    bench.word(0x2F);
    bench.pass(100);
    assert!(bench.speed() > 0.0);
}

#[test]
fn without_its_manager_it_does_what_its_option_says() {
    for (option, end) in [(1u16, "fault"), (2, "disabled"), (3, "disabled"), (0, "enabled")] {
        let mut bench = moving();
        bench.put("6007", &option.to_le_bytes());
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
    let mut bench = started();
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
        bench.hear(&Frame::data_frame(id, &data).expect("a frame").to_string());
        assert!(bench.take().len() < 200);
        bench.pass(random >> 60);
        assert!(bench.device.place(bench.now).is_finite() && bench.speed().is_finite());
        assert!(bench.device.next_deadline().is_none_or(|due| due >= bench.now));
    }
}

#[test]
fn a_mapping_is_changed_only_while_it_is_off_and_empty() {
    const STATE: u32 = Abort::DEVICE_STATE.0;
    const VALUE: u32 = Abort::VALUE.0;
    for (parameters, mapping, id, entry) in
        [("1400", "1600", 0x205u32, 0x607A_0020u32), ("1800", "1A00", 0x4000_0185, 0x6064_0020)]
    {
        let mut bench = started();
        // Object, bytes, value, and the abort code with which it is refused.
        for (object, sub, len, value, code, why) in [
            (mapping, 0, 1, 0, STATE, "it is on"),
            (parameters, 1, 4, 0x8000_0000 | id, 0, ""),
            (mapping, 1, 4, entry, STATE, "it is not empty"),
            (mapping, 0, 1, 0, 0, ""),
            (mapping, 1, 4, entry, 0, ""),
            (mapping, 2, 4, 0x6098_0008, Abort::NOT_MAPPABLE.0, "it cannot be mapped"),
            (mapping, 2, 4, entry - 0x10, Abort::NOT_MAPPABLE.0, "half an object"),
            (mapping, 2, 4, entry, 0, ""),
            (mapping, 3, 4, entry, 0, ""),
            (mapping, 0, 1, 3, Abort::PDO_LENGTH.0, "more than eight bytes"),
            (mapping, 0, 1, 4, Abort::PDO_LENGTH.0, "nothing at 4"),
            (mapping, 0, 1, 9, VALUE, "more entries than there can be"),
            (mapping, 0, 1, 2, 0, ""),
            (parameters, 2, 1, 1, VALUE, "synchronous"),
            (parameters, 1, 4, id + 1, VALUE, "another's identifier"),
            (parameters, 1, 4, id, 0, ""),
            (mapping, 0, 1, 0, STATE, "it is on again"),
            ("1800", 3, 2, 10, STATE, "an inhibit time while it is on"),
            ("6060", 0, 1, 4, VALUE, "no such mode"),
            ("5F00", 1, 1, 2, VALUE, "a drive does not slip"),
            ("5F00", 4, 1, 1, 0, "its last target sticks"),
            ("5F00", 5, 1, 1, Abort::NO_SUBINDEX.0, "it has four targets and no homing"),
        ] {
            let answer = bench.write(&format!("{object}:{sub}"), &value.to_le_bytes()[..len]);
            let expected = if code == 0 { Ok(()) } else { refused(Abort(code)) };
            assert_eq!(answer, expected, "{object}:{sub} = {value:X}h {why}");
        }
    }
}
