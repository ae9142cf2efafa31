//! Analogue channels: settings, limits with their hysteresis, broken wires, missing values, rest.

use linewright_line::{Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, When};
use proptest::prelude::*;

use super::*;

fn channel(number: u8) -> AnalogueChannel {
    AnalogueChannel { number, unit: "bar".to_owned(), factor: 0.01, offset: 0.0 }
}

fn input(number: u8, first: u16) -> AnalogueInput {
    let above = (InputId(first), When::Above { at: 5.0, hysteresis: 0.2 });
    let below = (InputId(first + 1), When::Below { at: 1.0, hysteresis: 0.1 });
    let (least, most, broken, simulated) = (None, None, None, None);
    AnalogueInput { channel: channel(number), least, most, inputs: vec![above, below], broken, simulated }
}

fn output(number: u8, outputs: &[(u16, f64)]) -> AnalogueOutput {
    let outputs = outputs.iter().map(|(output, value)| (OutputId(*output), *value)).collect();
    AnalogueOutput { channel: channel(number), rest: 0.5, outputs }
}

/// Node 4 of the drill has analogue input 2 (inputs 8 and 9) and output 1 (outputs 8 and 9) beside its bits; node 5 is as
/// always.
fn bench(analogue: Analogue) -> ManagerBench {
    let mut devices = devices();
    devices[0].io_mut().expect("I/O").analogue = analogue;
    ManagerBench::of(&devices[..2])
}

/// Operational, and its channels have not come yet.
fn started(analogue: Analogue) -> ManagerBench {
    let mut bench = bench(analogue);
    bench.bring_up(5);
    bench.hear("704#00");
    bench.hear("584#4300100091010300");
    bench.keeps_what_it_is_told(4);
    bench.hear("704#05");
    bench.hear("184#00");
    bench
}

fn usual() -> Analogue {
    Analogue { inputs: vec![input(2, 8)], outputs: vec![output(1, &[(8, 3.5), (9, 6.0)])] }
}

/// Operational, with 2.00 bar.
fn up() -> ManagerBench {
    let mut bench = started(usual());
    bench.measure(200);
    bench.take();
    assert!(bench.inputs(DRILL).valid);
    bench
}

impl ManagerBench {
    /// Channel 2 of node 4 gives this number.
    fn measure(&mut self, number: i16) {
        let [low, high] = number.to_le_bytes();
        self.hear(&format!("284#0000{low:02X}{high:02X}"));
    }

    fn limits(&self) -> (bool, bool) {
        let bits = self.inputs(DRILL).bits;
        (bits >> 8 & 1 == 1, bits >> 9 & 1 == 1)
    }

    fn trouble(&self) -> Vec<String> {
        self.manager.trouble(self.now, DRILL).collect()
    }

    /// Both devices live on; node 4 sends its bits and its channel, or not.
    fn live(&mut self, millis: u64, number: Option<i16>) {
        for _ in 0..millis / 50 {
            self.pass(50);
            self.hear("704#05");
            self.hear("705#05");
            if let Some(number) = number {
                self.measure(number);
            }
        }
    }
}

#[test]
fn the_device_is_told_to_send_by_itself_and_to_rest_without_a_manager() {
    let mut bench = bench(usual());
    bench.hear("704#00");
    bench.hear("584#4300100091010300");
    let told = bench.keeps_what_it_is_told(4);
    let expected = [
        "604#2F43640101000000", // 6443h:01 = 1: takes its error value
        "604#4043640100000000", // and is it so?
        "604#2344640132000000", // 6444h:01 = 50: 0.50 bar
        "604#4044640100000000",
        "604#23011801840200C0", // 1801h:01: off
        "604#2F011802FF000000", // by event
        "604#2B01180332000000", // at most every 5 ms
        "604#2B01180564000000", // every 100 ms
        "604#2301180184020040", // on
        "604#2F23640001000000", // 6423h = 1: may send by itself
    ];
    assert_eq!(told.iter().filter(|frame| expected.contains(&frame.as_str())).count(), expected.len(), "{told:?}");
    let at: Vec<usize> = expected.iter().map(|one| told.iter().position(|told| told == one).unwrap()).collect();
    assert!(at.is_sorted(), "{told:?}");
}

#[test]
fn the_first_frames_of_a_manager_put_channels_to_rest() {
    let mut bench = bench(usual());
    assert!(bench.frames().contains(&"304#3200".to_owned()));
}

#[test]
fn nothing_is_valid_before_the_channels_have_come() {
    let mut bench = started(usual());
    assert!(!bench.inputs(DRILL).valid);
    assert_eq!(bench.trouble(), ["drill-a (node 04h): operational, but its analogue inputs (TPDO2) do not come"]);
    bench.measure(600);
    assert!(bench.inputs(DRILL).valid);
    assert_eq!(bench.limits(), (true, false));
    assert!(bench.trouble().is_empty());
}

#[test]
fn limits_have_their_hysteresis_each() {
    let mut bench = up();
    let mut steps = Vec::new();
    for number in [499, 500, 481, 480, 479, 499, 500, 101, 100, 110, 111, 100] {
        bench.measure(number);
        steps.push(bench.limits());
    }
    let (none, above, below) = ((false, false), (true, false), (false, true));
    let expected = [none, above, above, above, none, none, above, none, below, below, none, below];
    assert_eq!(steps, expected);
}

#[test]
fn a_broken_wire_is_a_loss_until_it_is_mended_and_says_so() {
    let mut bench = up();
    bench.set(DRILL, 0b01);
    assert!(bench.frames().contains(&"204#01".to_owned()));
    bench.measure(i16::MAX);
    let (frames, events) = bench.take();
    assert!(frames.contains(&"204#00".to_owned()), "{frames:?}");
    let fault = ChannelFault::Number { channel: 2, number: i16::MAX };
    assert!(events.contains(&BusEvent::ChannelFault { node: node(4), fault }), "{events:?}");
    assert!(!bench.inputs(DRILL).valid && bench.limits() == (false, false));
    let said = "drill-a (node 04h): operational, but analogue input 2 (6401h:02) is at the end of its range: is its wire \
                broken?";
    assert_eq!(bench.trouble(), [said]);
    // Reported once, and nothing is energised by what was set before.
    bench.measure(i16::MIN);
    bench.live(300, Some(300));
    assert!(!bench.inputs(DRILL).valid, "not yet: it has measured for 250 ms");
    bench.live(50, Some(300));
    let (frames, events) = bench.take();
    assert!(!events.iter().any(|event| matches!(event, BusEvent::ChannelFault { .. })));
    assert!(!frames.iter().any(|frame| frame == "204#01"), "{frames:?}");
    assert!(bench.inputs(DRILL).valid);
    assert_eq!(bench.inputs(DRILL).losses, 1);
    bench.set(DRILL, 0b01);
    assert!(bench.frames().contains(&"204#01".to_owned()));
}

#[test]
fn a_broken_wire_with_an_input_of_its_own_turns_that_on_and_the_limits_off() {
    let mut analogue = usual();
    analogue.inputs[0].broken = Some(InputId(10));
    let mut bench = started(analogue);
    bench.measure(600);
    assert_eq!((bench.limits(), bench.inputs(DRILL).bits >> 10 & 1), ((true, false), 0));
    bench.measure(i16::MAX);
    assert!(bench.inputs(DRILL).valid);
    assert_eq!((bench.limits(), bench.inputs(DRILL).bits >> 10 & 1), ((false, false), 1));
    // Within the hysteresis it has no memory of before.
    bench.measure(490);
    bench.live(250, Some(490));
    assert_eq!((bench.limits(), bench.inputs(DRILL).bits >> 10 & 1), ((false, false), 1));
    bench.take();
    bench.pass(50);
    assert!(bench.take().1.contains(&BusEvent::InputsChanged { owner: DRILL }), "by time alone");
    assert_eq!((bench.limits(), bench.inputs(DRILL).bits >> 10 & 1), ((false, false), 0));
}

#[test]
fn a_loose_contact_is_one_loss_until_it_has_held_for_a_while() {
    let mut bench = up();
    for at in 0..400 {
        bench.measure(if at % 2 == 0 { i16::MAX } else { 200 });
        bench.now = bench.now + Duration::from_millis(5);
        if at % 10 == 0 {
            bench.live(50, None);
        }
    }
    let changes = |events: &[BusEvent]| {
        events.iter().filter(|event| matches!(event, BusEvent::InputsChanged { owner: DRILL })).count()
    };
    assert_eq!((changes(&bench.take().1), bench.inputs(DRILL).losses), (1, 1));
    bench.measure(200);
    let mended = bench.now + Duration::from_millis(295);
    bench.live(250, Some(200));
    bench.take();
    // The last number of the loop was a measurement too, 5 ms before: since then it holds.
    assert_eq!(bench.manager.next_deadline(), Some(mended));
    bench.pass(44);
    assert!(!bench.inputs(DRILL).valid);
    bench.pass(1);
    assert!(bench.inputs(DRILL).valid && bench.manager.next_deadline().unwrap() > bench.now);
    assert_eq!(changes(&bench.take().1), 1);
}

#[test]
fn values_that_stay_away_while_all_else_goes_on_are_a_loss() {
    let mut bench = up();
    bench.live(1000, Some(600));
    assert!(bench.inputs(DRILL).valid);
    bench.take();
    bench.live(250, None);
    assert!(bench.inputs(DRILL).valid);
    bench.live(100, None);
    assert!(!bench.inputs(DRILL).valid);
    let events = bench.take().1;
    assert!(events.contains(&BusEvent::ChannelFault { node: node(4), fault: ChannelFault::Late { object: 2 } }));
    // It is no busy loop, and over as soon as one comes.
    assert!(bench.manager.next_deadline().unwrap() > bench.now);
    bench.measure(600);
    assert!(bench.inputs(DRILL).valid);
}

#[test]
fn outputs_give_a_channel_its_value_and_two_at_once_are_rest() {
    let mut bench = up();
    let mut sent = |image: u128| {
        bench.set(DRILL, image);
        bench.frames().into_iter().find(|frame| frame.starts_with("304"))
    };
    assert_eq!(sent(1 << 8).as_deref(), Some("304#5E01"));
    assert_eq!(sent(1 << 9).as_deref(), Some("304#5802"));
    assert_eq!(sent(0b11 << 8).as_deref(), Some("304#3200"));
    assert_eq!(sent(0), None, "it is at rest already");
    assert_eq!(sent(1 << 8).as_deref(), Some("304#5E01"));
    bench.live(50, Some(200));
    assert!(bench.frames().contains(&"304#5E01".to_owned()), "refreshed");
    bench.hear("705#7F");
    assert!(bench.frames().contains(&"304#3200".to_owned()), "the loss of the owner's other device is rest");
    assert!(
        bench
            .manager
            .explain(bench.now, node(4))
            .unwrap()
            .ends_with("analogue input 2: 2.00 bar, analogue output 1: 0.50 bar")
    );
}

#[test]
fn twelve_channels_lie_in_three_objects() {
    let inputs = [1, 5, 12].map(|number| input(number, u16::from(number) * 2)).to_vec();
    let outputs = vec![output(4, &[(8, 1.0)]), output(9, &[(9, 2.0)])];
    let mut bench = started(Analogue { inputs, outputs });
    bench.hear("284#5802");
    bench.hear("384#5802");
    assert!(!bench.inputs(DRILL).valid);
    // Channel 12 is the last of its object.
    bench.hear("484#580200000000");
    assert!(!bench.inputs(DRILL).valid, "too short");
    bench.hear("484#0000000000005802");
    assert!(bench.inputs(DRILL).valid);
    assert_eq!(bench.inputs(DRILL).bits & !1, 1 << 2 | 1 << 10 | 1 << 24);
    bench.take();
    bench.set(DRILL, 0b11 << 8);
    let frames = bench.frames();
    assert!(frames.contains(&"304#0000000000006400".to_owned()), "{frames:?}");
    assert!(frames.contains(&"504#C800".to_owned()), "{frames:?}");
    // A frame without a reader has no meaning.
    assert_eq!(bench.manager.ignored(IgnoreReason::UnknownCobId), 0);
    bench.hear("285#00000000");
    assert_eq!(bench.manager.ignored(IgnoreReason::UnknownCobId), 1);
}

proptest! {
    /// Against the slow way: what is on follows from all numbers since the last that was none.
    #[test]
    fn limits_follow_from_the_history_of_numbers(numbers in proptest::collection::vec(
        prop_oneof![40i16..160, 470i16..510, Just(i16::MAX), any::<i16>()], 1..60,
    )) {
        let mut analogue = usual();
        analogue.inputs[0].broken = Some(InputId(10));
        let mut bench = started(analogue);
        for at in 0..numbers.len() {
            bench.measure(numbers[at]);
            let history: Vec<i16> =
                numbers[..=at].iter().copied().rev().take_while(|n| *n != i16::MAX && *n != i16::MIN).collect();
            // The last one clear of the band decides; without any, it is off.
            let above = history.iter().find_map(|n| match n { n if *n >= 500 => Some(true), n if *n < 480 => Some(false), _ => None });
            let below = history.iter().find_map(|n| match n { n if *n <= 100 => Some(true), n if *n > 110 => Some(false), _ => None });
            if !history.is_empty() {
                bench.live(300, None);
            }
            prop_assert_eq!(bench.limits(), (above.unwrap_or(false), below.unwrap_or(false)));
            prop_assert_eq!(bench.inputs(DRILL).bits >> 10 & 1 == 1, history.is_empty());
        }
    }
}
