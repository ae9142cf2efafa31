//! The simulated drive on its own, led through the figure of the profile by controlwords as a technician would send
//! them: every state and every transition, on the wire.

use std::collections::BTreeSet;
use std::time::Duration;

use linewright_canopen::sdo::Abort;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{AtRest, Tick, Timing};
use linewright_plant::{CanDevice, DeviceOutbox, DriveNode, MotionFault};
use proptest::prelude::*;

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

/// The arrows of the figure of the power drive system that a command drives: number, from, to, and the commands as its table
/// prints them, bits 7, 3, 2, 1, 0 (x: does not matter; ^: a rising edge).
const FIGURE: &[(u8, &str, &str, &[&str])] = &[
    (2, "disabled", "ready", &["0x110", "1x110"]),
    (3, "ready", "on", &["xx111"]),
    (4, "on", "enabled", &["x1111"]),
    (5, "enabled", "on", &["x0111"]),
    (6, "on", "ready", &["xx110"]),
    (7, "ready", "disabled", &["xxx0x", "xx01x"]),
    (8, "enabled", "ready", &["xx110"]),
    (9, "enabled", "disabled", &["xxx0x"]),
    (10, "on", "disabled", &["xxx0x", "xx01x"]),
    (11, "enabled", "quick stop", &["xx01x"]),
    (12, "quick stop", "disabled", &["xxx0x"]),
    (15, "fault", "disabled", &["^xxxx"]),
    (16, "quick stop", "enabled", &["x1111"]),
];

fn fits(pattern: &str, word: u16, before: u16) -> bool {
    let bits = [7, 3, 2, 1, 0];
    pattern.bytes().zip(bits).all(|(digit, bit)| match digit {
        b'x' => true,
        b'^' => word >> bit & 1 == 1 && before >> bit & 1 == 0,
        digit => (digit == b'1') == (word >> bit & 1 == 1),
    })
}

/// Where a controlword leads by the figure, arrow by arrow. `stays`: the quick stop can be left by arrow 16.
fn led(mut state: &'static str, word: u16, mut before: u16, stays: bool, seen: &mut BTreeSet<u8>) -> &'static str {
    loop {
        let fits = |commands: &[&str]| commands.iter().any(|command| fits(command, word, before));
        let arrows: Vec<_> = FIGURE.iter().filter(|(_, from, _, commands)| *from == state && fits(commands)).collect();
        assert!(arrows.len() <= 1, "{state} {word:04X}: the commands of one state exclude each other");
        let Some((number, _, to, _)) = arrows.first().filter(|(number, ..)| stays || *number != 16) else {
            return state;
        };
        seen.insert(*number);
        (state, before) = (to, word);
    }
}

/// In a state, in which it stands but for a quick stop that it cannot leave; bit 7 of the controlwords on the way is this.
fn standing_in(state: &str, stays: bool, bit: u16) -> Alone<Box<DriveNode>> {
    let mut bench = if stays { started() } else { moving() };
    bench.put("605A", &[if stays { 6 } else { 2 }, 0]);
    let words: &[u16] = match state {
        "disabled" => &[0x00],
        "ready" => &[0x06],
        "on" => &[0x06, 0x07],
        "enabled" | "fault" => &[0x06, 0x07, 0x0F],
        _ if stays => &[0x06, 0x07, 0x0F, 0x02],
        _ => &[0x02],
    };
    words.iter().for_each(|word| _ = bench.word(word | bit));
    if state == "fault" {
        // It was stuck on its way to a target, and is free again.
        bench.put("6081", &10_000u32.to_le_bytes());
        bench.put("607A", &80_000i32.to_le_bytes());
        bench.word(0x2F | bit);
        bench.word(0x3F | bit);
        let mut out = DeviceOutbox::default();
        bench.device.fail(bench.now, 1, Some(MotionFault::Stick), &mut out);
        bench.pass(2000);
        bench.device.fail(bench.now, 1, None, &mut out);
    }
    assert_eq!(bench.state(), state);
    bench
}

#[test]
fn every_controlword_in_every_state_leads_along_the_arrows_of_the_figure() {
    let mut seen = BTreeSet::new();
    let states = ["disabled", "ready", "on", "enabled", "quick stop", "fault"].map(|state| (state, true));
    for (state, stays) in states.into_iter().chain([("quick stop", false)]) {
        for (word, before) in (0..=0x1FF).flat_map(|word| [(word, 0x00), (word, 0x80)]) {
            let expected = led(state, word, before, stays, &mut seen);
            let found = standing_in(state, stays, before).word(word);
            // One that is not to stay ends by itself once it stands; until then it may be left for disabled alone.
            assert!(found == expected || !stays && found == state, "{state} {word:04X} after {before:04X}: {found}");
        }
    }
    assert_eq!(seen.len(), FIGURE.len());
}

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

/// Enabled, with 100 increments a second, 1000 a second squared up and 500 down.
fn ramped() -> Alone<Box<DriveNode>> {
    let mut bench = enabled();
    for (object, value) in [("6081", 100u32), ("6083", 1000), ("6084", 500)] {
        bench.put(object, &value.to_le_bytes());
    }
    bench
}

impl Alone<Box<DriveNode>> {
    /// Sends it there at once, whatever it does.
    fn go_to(&mut self, target: i32) {
        self.put("607A", &target.to_le_bytes());
        self.word(0x2F);
        self.word(0x3F);
    }
}

#[test]
fn a_way_takes_the_time_of_its_trapezoid() {
    let mut bench = ramped();
    bench.go_to(100);
    let seen = |bench: &Alone<Box<DriveNode>>, millis: u64| {
        let at = bench.now + Duration::from_millis(millis);
        (bench.device.place(at), bench.device.speed(at))
    };
    // 0.1 s up (5), 0.2 s down (10), 85 at 100 a second.
    assert_eq!(seen(&bench, 100).0, 5.0);
    assert_eq!(seen(&bench, 500).1, 100.0);
    assert!(seen(&bench, 1149).1 > 0.0 && seen(&bench, 1149).0 < 100.0);
    assert_eq!([seen(&bench, 1150), seen(&bench, 5000)], [(100.0, 0.0); 2]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Integrated step by step, independently of all formulas: velocity and acceleration within the ramp, never past the target,
    /// but for the way it takes to stop.
    #[test]
    fn whatever_it_did_before_it_ends_at_the_last_target_within_its_limits(
        targets in prop::collection::vec((-500..500i32, 0u64..2000), 1..6)
    ) {
        let mut bench = ramped();
        let (mut before, mut speed) = (0.0, 0.0);
        let step = Duration::from_micros(500);
        for (target, millis) in &targets {
            bench.go_to(*target);
            let (from, target) = (bench.device.place(bench.now), f64::from(*target));
            let braking = bench.speed().powi(2) / (2.0 * 500.0);
            for _ in 0..*millis {
                for now in [bench.now + step, bench.now + 2 * step] {
                    let (here, new) = (bench.device.place(now), bench.device.speed(now));
                    prop_assert!(new.abs() <= 100.0 + 1e-6);
                    prop_assert!((new - speed).abs() <= 1000.0 * step.as_secs_f64() + 1e-6);
                    let way = (new + speed) / 2.0 * step.as_secs_f64();
                    prop_assert!((here - before - way).abs() < 1e-3, "position is not the sum");
                    let past = (here - target.max(from)).max(target.min(from) - here);
                    prop_assert!(past <= braking + 1e-6);
                    (before, speed) = (here, new);
                }
                bench.pass(1);
            }
        }
        bench.pass(20_000);
        let (target, _) = targets[targets.len() - 1];
        prop_assert_eq!((bench.device.place(bench.now), bench.speed()), (f64::from(target), 0.0));
    }
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
