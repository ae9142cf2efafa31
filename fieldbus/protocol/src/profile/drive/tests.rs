//! The manager's side by itself: a drive is played word by word.

use linewright_line::{AtRest, DriveMode, InputId};

use super::*;
use crate::codec::NodeId;
use crate::sdo::ObjectId;

const TO_0: u128 = 1;
const TO_80: u128 = 2;
const HOME: u128 = 4;
const AT_0: u128 = 1;
const AT_80: u128 = 2;
const DONE: u128 = 4;
const FAULT: u128 = 8;

/// Target 0 at output and input 0, 80 000 increments at output and input 1; homing at output 2 and input 2 if `homing`;
/// fault at input 3.
fn binding(homing: bool) -> DriveBinding {
    let target = |id, to| DriveSetpoint { output: OutputId(id), to, at: InputId(id), velocity: 300_000 };
    let home = HomingBinding {
        method: 17,
        fast: 20_000,
        slow: 2000,
        acceleration: 100_000,
        offset: 0,
        output: OutputId(2),
        done: Some(InputId(2)),
    };
    DriveBinding {
        index: None,
        mode: DriveMode::Position,
        targets: vec![target(0, 0), target(1, 80_000)],
        fault: Some(InputId(3)),
        home: homing.then_some(home),
        window: 50,
        velocity: 300_000,
        acceleration: 2_000_000,
        quick_stop: 6_000_000,
        at_rest: AtRest::Off,
        units: 1000.0,
    }
}

struct DriveBench {
    drive: ManagedDrive,
    now: Tick,
}

impl DriveBench {
    fn new(binding: DriveBinding) -> Self {
        DriveBench { drive: ManagedDrive::new(binding), now: Tick::from_millis(1000) }
    }

    /// Data sent after an image, as controlword, mode and target.
    fn image(&mut self, image: u128) -> (u16, i8, i32) {
        self.drive.set_image(self.now, image);
        self.sent()
    }

    /// Data sent after this feedback.
    fn says(&mut self, word: u16, mode: u8, actual: i32) -> (u16, i8, i32) {
        self.now = self.now + Duration::from_millis(1);
        let bits = u64::from(word) | u64::from(mode) << 16 | u64::from(actual as u32) << 24;
        self.drive.take(self.now, Payload::from_bits(bits, 56)).expect("seven bytes");
        // Looking again without news changes nothing.
        self.drive.poll(self.now);
        self.sent()
    }

    fn sent(&mut self) -> (u16, i8, i32) {
        let bits = self.drive.give().bits();
        assert!(!self.drive.wants_to_send());
        (bits as u16, (bits >> 16) as i8, (bits >> 24) as i32)
    }

    /// From switch on disabled to operation enabled.
    fn enable(&mut self, mode: u8, actual: i32) -> u16 {
        assert_eq!(self.says(0x0250, mode, actual).0, word::SHUTDOWN);
        assert_eq!(self.says(0x0231, mode, actual).0, word::SWITCH_ON);
        assert_eq!(self.says(0x0233, mode, actual).0, word::ENABLE_OPERATION | word::HALT);
        self.says(0x0237, mode, actual).0
    }

    fn moving_to_80(homing: bool) -> Self {
        let mut bench = DriveBench::new(binding(homing));
        bench.says(0x0250, 1, 0);
        bench.image(TO_80);
        assert_eq!(bench.enable(1, 0), 0x003F);
        assert_eq!(bench.says(0x1237, 1, 0), (0x002F, 1, 80_000));
        bench.says(0x0237, 1, 10);
        bench
    }
}

#[test]
fn without_an_order_it_is_sent_quick_stop_whatever_it_says() {
    let mut bench = DriveBench::new(binding(false));
    assert_eq!(bench.sent(), (word::QUICK_STOP, 1, 0));
    for state in [0x0200, 0x0250, 0x0231, 0x0233, 0x0237, 0x0217, 0x021F, 0x0201, 0xFFFF] {
        assert_eq!(bench.says(state, 1, 0).0, word::QUICK_STOP, "{state:04X}");
    }
    assert_eq!(bench.drive.rest().bytes(), [0x02, 0, 1, 0, 0, 0, 0]);
}

#[test]
fn an_order_enables_offers_and_moves_and_the_switch_is_on_when_both_agree() {
    let mut bench = DriveBench::moving_to_80(false);
    assert_eq!(bench.drive.inputs(), AT_0);
    bench.says(0x0237, 1, 40_000);
    assert_eq!(bench.drive.inputs(), 0);
    assert_eq!(bench.drive.explain(), "going to 80: at 40 (statusword 0237h)");
    bench.says(0x0237, 1, 79_960);
    assert_eq!(bench.drive.inputs(), 0, "in the window, and still moving");
    bench.says(0x0637, 1, 79_940);
    assert_eq!(bench.drive.inputs(), 0, "it says so, and is not");
    bench.says(0x0637, 1, 79_950);
    assert_eq!(bench.drive.inputs(), AT_80);
    assert_eq!(bench.image(0).0, word::QUICK_STOP);
    bench.says(0x0250, 1, 79_951);
    assert_eq!(bench.drive.inputs(), AT_80, "as a limit switch would be");
}

#[test]
fn it_says_what_it_waits_for() {
    let mut bench = DriveBench::new(binding(false));
    assert_eq!(bench.drive.explain(), "no process data from it yet");
    bench.image(TO_80);
    bench.says(0x0250, 1, 0);
    assert_eq!(bench.drive.explain(), "switch on disabled: waiting for ready to switch on (statusword 0250h)");
    bench.says(0x0040, 1, 0);
    assert_eq!(
        bench.drive.explain(),
        "switch on disabled: waiting for ready to switch on; operated locally: it does not obey; no voltage \
         (statusword 0040h)"
    );
    bench.says(0x0237, 3, 0);
    assert_eq!(bench.drive.explain(), "operation enabled: waiting for mode 1, it is in 3 (statusword 0237h)");
}

#[test]
fn an_order_that_replaces_another_is_offered_after_the_acknowledge_has_fallen() {
    let mut bench = DriveBench::moving_to_80(false);
    // Straight from one output to the other: halt, and because the bit is known to be low, the other target.
    assert_eq!(bench.image(TO_0), (0x010F, 1, 0));
    assert_eq!(bench.says(0x0237, 1, 20_000), (0x003F, 1, 0));
    // Back before any answer: the last bit it has seen is unknown, so it leaves operation enabled first.
    assert_eq!(bench.image(TO_80), (word::QUICK_STOP, 1, 80_000));
    assert_eq!(bench.says(0x1237, 1, 20_000).0, word::QUICK_STOP, "an answer to what was offered before");
    assert_eq!(bench.enable(1, 19_000), 0x003F);
}

#[test]
fn an_order_right_after_an_end_waits_until_the_stop_is_over() {
    let mut bench = DriveBench::moving_to_80(false);
    bench.image(0);
    assert_eq!(bench.image(TO_0).0, word::QUICK_STOP);
    assert_eq!(bench.says(0x0237, 1, 20_000).0, word::QUICK_STOP, "what it said before it heard of the stop");
    assert_eq!(bench.says(0x0217, 1, 21_000).0, word::QUICK_STOP);
    assert_eq!(bench.enable(1, 21_500), 0x003F);
}

#[test]
fn an_axis_that_would_sink_is_halted_and_held() {
    let mut bench = DriveBench::new(DriveBinding { at_rest: AtRest::Hold, ..binding(false) });
    assert_eq!(bench.says(0x0250, 1, 0).0, word::QUICK_STOP, "not enabled without an order");
    bench.image(TO_80);
    bench.enable(1, 0);
    bench.says(0x1237, 1, 0);
    bench.says(0x0237, 1, 500);
    assert_eq!(bench.image(0).0, 0x010F);
    assert_eq!(bench.says(0x0637, 1, 900).0, 0x010F);
    assert_eq!(bench.drive.explain(), "holding at 0.9 (statusword 0637h)");
    assert_eq!(bench.image(TO_0), (0x010F, 1, 0));
    assert_eq!(bench.says(0x0637, 1, 900), (0x003F, 1, 0), "no need to disable in between");
    // Found in quick stop, as after a loss: enabled from there, without losing its torque.
    bench.drive.set_image(bench.now, 0);
    bench.drive.lost(bench.now);
    assert_eq!(bench.says(0x0217, 1, 900).0, word::QUICK_STOP);
    assert_eq!(bench.image(TO_0).0, 0x010F);
    assert_eq!(bench.says(0x0237, 1, 900).0, 0x003F);
}

#[test]
fn two_orders_at_once_stop_it_until_both_are_gone() {
    let mut bench = DriveBench::moving_to_80(false);
    assert_eq!(bench.image(TO_0 | TO_80).0, word::QUICK_STOP);
    bench.says(0x0250, 1, 3000);
    assert_eq!(bench.drive.inputs(), FAULT);
    assert_eq!(
        bench.drive.explain(),
        "outputs 0 and 1 are on at once: it stands until every output of it is off (statusword 0250h)"
    );
    assert_eq!(bench.image(TO_80).0, word::QUICK_STOP, "the one that is left is not obeyed");
    bench.image(0);
    assert_eq!(bench.drive.inputs(), 0);
    bench.image(TO_80);
    assert_eq!(bench.enable(1, 3000), 0x003F);
}

#[test]
fn a_drive_that_drops_out_is_not_enabled_again_under_the_same_order() {
    for word in [0x0250, 0x0217, 0x0233, 0x0218] {
        let mut bench = DriveBench::moving_to_80(false);
        bench.drive.emergency(bench.now, 0x8611);
        bench.says(word, 1, 500);
        assert_eq!(bench.drive.inputs(), FAULT, "{word:04X}");
        for word in [0x0250, 0x0231, 0x0233] {
            assert!([word::QUICK_STOP, word::DISABLE_VOLTAGE].contains(&bench.says(word, 1, 500).0));
        }
        assert!(bench.drive.explain().contains("8611h (following error)"), "{}", bench.drive.explain());
        bench.image(0);
        bench.image(TO_80);
        assert_eq!(bench.enable(1, 500), 0x003F);
    }
}

#[test]
fn a_fault_is_reset_by_an_edge_and_only_without_an_order() {
    let mut bench = DriveBench::moving_to_80(false);
    bench.says(0x0218, 1, 500);
    for _ in 0..3000 {
        assert_eq!(bench.says(0x0218, 1, 500).0 & word::FAULT_RESET, 0);
    }
    assert_eq!(bench.drive.next_deadline(), None);
    bench.image(0);
    let mut edges = 0;
    let mut before = 0;
    for _ in 0..3000 {
        let word = bench.says(0x0218, 1, 500).0 & word::FAULT_RESET;
        edges += u32::from(word != 0 && before == 0);
        before = word;
    }
    assert_eq!(edges, 3, "once a second");
    assert_eq!(bench.drive.inputs() & FAULT, FAULT);
    // The deadlines alone lead from edge to edge.
    for _ in 0..6 {
        let due = bench.drive.next_deadline().expect("it goes on");
        assert!(due > bench.now);
        bench.now = due;
        bench.drive.poll(due);
        assert!(bench.drive.wants_to_send());
        bench.drive.give();
    }
    bench.says(0x0250, 1, 500);
    assert_eq!((bench.drive.inputs(), bench.drive.next_deadline()), (0, None));
}

#[test]
fn before_homing_it_is_nowhere_and_goes_nowhere() {
    let mut bench = DriveBench::new(binding(true));
    bench.says(0x0250, 1, 0);
    assert_eq!(bench.drive.inputs(), 0, "it reads 0, but does not know");
    assert_eq!(bench.image(TO_80).0, word::QUICK_STOP);
    assert_eq!(bench.drive.inputs(), FAULT);
    assert!(bench.drive.explain().starts_with("not homed"));
    bench.image(0);
    assert_eq!(bench.image(HOME), (word::SHUTDOWN, 6, 0));
    assert_eq!(bench.enable(6, 0), 0x001F);
    assert_eq!(bench.says(0x0637, 6, 0).0, 0x001F, "not begun yet");
    assert_eq!(bench.says(0x0237, 6, -300).0, 0x001F);
    assert_eq!(bench.drive.inputs(), 0);
    bench.says(0x1637, 6, 0);
    assert_eq!(bench.drive.inputs(), DONE | AT_0);
    bench.image(0);
    bench.says(0x0250, 6, 0);
    bench.image(TO_80);
    assert_eq!(bench.enable(1, 0), 0x003F);
    // Whether it kept its zero over a loss is unknown.
    bench.image(0);
    bench.drive.lost(bench.now);
    bench.says(0x0250, 1, 0);
    assert_eq!(bench.drive.inputs(), 0);
}

#[test]
fn an_output_that_homes_first_goes_to_its_target_then() {
    let mut binding = binding(true);
    if let Some(home) = &mut binding.home {
        home.output = OutputId(0);
    }
    let mut bench = DriveBench::new(binding);
    bench.says(0x0250, 1, 7000);
    bench.image(TO_0);
    assert_eq!(bench.enable(6, 7000), 0x001F);
    bench.says(0x0237, 6, 6000);
    assert_eq!(bench.says(0x1637, 6, 12), (0x010F, 1, 0), "homed: now the target, in its own mode");
    assert_eq!(bench.drive.inputs() & AT_0, 0);
    assert_eq!(bench.says(0x0637, 1, 12), (0x003F, 1, 0));
    bench.says(0x1237, 1, 12);
    bench.says(0x0637, 1, 1);
    assert_eq!(bench.drive.inputs(), AT_0 | DONE);
}

#[test]
fn a_homing_that_was_attained_before_counts_only_after_a_while() {
    let mut bench = DriveBench::new(binding(true));
    bench.says(0x0250, 1, 0);
    bench.image(HOME);
    assert_eq!(bench.enable(6, 0), 0x001F);
    bench.drive.set_image(bench.now, 0);
    bench.says(0x1650, 6, 0);
    bench.image(HOME);
    bench.says(0x1650, 6, 0);
    bench.says(0x1631, 6, 0);
    bench.says(0x1633, 6, 0);
    assert_eq!(bench.says(0x1637, 6, 0).0, 0x001F);
    bench.says(0x1637, 6, 0);
    assert_eq!(bench.drive.inputs() & DONE, 0);
    bench.now = bench.now + HOMING_SETTLE;
    bench.says(0x1637, 6, 0);
    assert_eq!(bench.drive.inputs() & DONE, DONE);
}

#[test]
fn a_failed_homing_is_a_fault() {
    let mut bench = DriveBench::new(binding(true));
    bench.says(0x0250, 1, 0);
    bench.image(HOME);
    bench.enable(6, 0);
    bench.says(0x2237, 6, 0);
    assert_eq!(bench.drive.inputs(), FAULT);
    assert!(bench.drive.explain().starts_with("the homing has failed"));
}

#[test]
fn a_target_with_a_velocity_of_its_own_waits_until_that_is_written() {
    let mut binding = binding(false);
    binding.targets[1].velocity = 60_000;
    let mut bench = DriveBench::new(binding);
    bench.says(0x0250, 1, 0);
    bench.image(TO_80);
    let setting = bench.drive.wants_write().expect("the velocity");
    assert_eq!((setting.object, setting.data.as_slice()), (ObjectId::new(0x6081, 0), &[0x60, 0xEA, 0, 0][..]));
    assert_eq!(bench.enable(1, 0), 0x010F);
    assert!(bench.drive.explain().contains("waiting for its velocity"));
    let now = bench.now;
    bench.drive.written(now, &setting, Ok(()));
    assert_eq!(bench.sent().0, 0x003F);
    assert_eq!(bench.drive.wants_write(), None);
    // Refused: it does not go at another velocity instead.
    bench.image(0);
    bench.says(0x0250, 1, 0);
    bench.image(TO_0);
    let setting = bench.drive.wants_write().expect("the usual velocity again");
    bench.drive.written(now, &setting, Err(Abort::VALUE));
    assert_eq!(bench.drive.inputs() & FAULT, FAULT);
    assert!(bench.drive.explain().contains("6081h"));
}

#[test]
fn a_velocity_is_a_target_like_any_other() {
    let mut binding = DriveBinding { mode: DriveMode::Velocity, ..binding(false) };
    binding.targets[1].to = 3000;
    let mut bench = DriveBench::new(binding);
    assert_eq!(bench.sent(), (word::QUICK_STOP, 3, 0));
    bench.says(0x0250, 3, 0);
    bench.image(TO_80);
    for word in [0x0250, 0x0231, 0x0233] {
        assert_eq!(bench.says(word, 3, 0).2, 0, "no velocity before it is enabled");
    }
    assert_eq!(bench.says(0x0637, 3, 0), (0x000F, 3, 3000));
    assert_eq!(bench.drive.inputs(), AT_0, "it stands, whatever it says it has reached");
    bench.says(0x0637, 3, 2960);
    assert_eq!(bench.drive.inputs(), AT_80);
    assert_eq!(bench.image(0), (word::QUICK_STOP, 3, 0));
}

#[test]
fn what_is_too_short_says_nothing() {
    let mut bench = DriveBench::moving_to_80(false);
    let before = bench.sent();
    for len in 1..PDO_BYTES {
        assert_eq!(bench.drive.take(bench.now, Payload::from_bits(0, len * 8)), Err(ShortPdo { actual: len }));
    }
    assert_eq!(bench.sent(), before);
}

#[test]
fn settings_remap_a_process_data_object_only_while_it_is_off() {
    for homing in [false, true] {
        let settings = ManagedDrive::new(binding(homing)).settings(NodeId::new(5).expect("a node id"));
        let mut off = [false; 2];
        let mut count = [3u32; 2];
        for setting in &settings {
            let ObjectId { index, sub } = setting.object;
            let which = usize::from(matches!(index, 0x1800 | 0x1A00));
            let value = setting.data.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
            match (index, sub) {
                (0x1400 | 0x1800, 1) => {
                    off[which] = value >> 31 == 1;
                    assert_eq!(value & 0x7FF, [0x205, 0x185][which]);
                }
                (0x1600 | 0x1A00, 0) => {
                    assert!(off[which]);
                    count[which] = value;
                }
                (0x1600 | 0x1A00, _) => assert!(off[which] && count[which] == 0),
                (0x1400 | 0x1800, _) => assert!(off[which]),
                _ => {}
            }
        }
        assert_eq!((off, count), ([false; 2], [3; 2]));
        let must: Vec<u16> = settings.iter().filter(|s| !s.optional).map(|s| s.object.index).collect();
        assert!([0x605A, 0x605C, 0x605D, 0x6007, 0x6085].iter().all(|index| must.contains(index)));
        assert_eq!(must.contains(&0x6098), homing);
        assert!(settings.iter().all(|s| !s.may_be_refused(Abort::VALUE)));
    }
}

#[test]
fn a_listener_reads_the_place_alone() {
    let binding = binding(true);
    let at = |place: i32, bytes: usize| {
        let bits = u64::from(place.cast_unsigned()) << 24 | 0x01_0637;
        binding.places(Payload::from_bits(bits, 8 * bytes))
    };
    let known = AT_0 | AT_80;
    for (place, on) in
        [(0, AT_0), (-50, AT_0), (-51, 0), (51, 0), (40_000, 0), (79_950, AT_80), (80_050, AT_80), (80_051, 0)]
    {
        assert_eq!(at(place, 7), Some((known, on)), "{place}");
    }
    assert_eq!(at(0, 6), None);
}
