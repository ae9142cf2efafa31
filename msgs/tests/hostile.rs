//! Messages that any host on the network may send: cut off, too long, or plain noise.
//!
//! The decoder of the DDS library (`cdr-encoding`, the same crate and version) must answer with an error. It may not
//! panic, and it may not reserve memory for elements that were only announced: sequences grow as their elements are
//! read, and every element takes at least one byte of the sample, so the memory for a sample is a small multiple of its
//! own size.

use byteorder::LittleEndian;
use linewright_msgs::{
    Invalid, LineState, ModeOrder, OrderState, ProcessImage, RosMessage, RunTaskGoal, RunTaskResult, StationEvent,
    StationState, TEXT_BYTES_MAX, Text, fitting,
};
use proptest::prelude::*;

use crate::samples;

fn decode<T: RosMessage>(bytes: &[u8]) -> Option<T> {
    cdr_encoding::from_bytes::<T, LittleEndian>(bytes).ok().map(|(message, _)| message)
}

fn encode<T: RosMessage>(message: &T) -> Vec<u8> {
    cdr_encoding::to_vec::<T, LittleEndian>(message).expect("encodes")
}

#[test]
fn every_truncation_is_an_error() {
    fn all<T: RosMessage>(message: &T) {
        let whole = encode(message);
        for length in 0..whole.len() {
            assert!(decode::<T>(&whole[..length]).is_none(), "{} cut to {length} bytes", T::NAME);
        }
    }
    all(&samples::station_state());
    all(&samples::station_event());
    all(&samples::process_image());
    all(&samples::mode_order());
    all(&samples::line_state());
    all(&samples::cycle_time());
    all(&samples::text());
    all(&samples::flag());
    all(&samples::run_task().0);
    all(&samples::order_state());
    all(&samples::production_request());
    all(&samples::cell_state());
    all(&samples::lifecycle().0);
    all(&samples::lifecycle().1);
}

#[test]
fn announced_lengths_are_not_believed() {
    // A string, then a sequence of structs, that claim four thousand million elements.
    assert!(decode::<Text>(&[0xff, 0xff, 0xff, 0xff, b'a']).is_none());
    let mut state = StationState { answers: vec![], ..samples::station_state() };
    let mut bytes = encode(&state);
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(decode::<StationState>(&bytes).is_none());
    state.answers.push(samples::answer());
    assert!(decode::<StationState>(&encode(&state)).is_some());
}

#[test]
fn a_seventeenth_byte_of_an_image_does_not_decode() {
    let image = samples::process_image();
    let mut bytes = encode(&image);
    let count_at = bytes.len() - 16 - 4;
    bytes[count_at] = 17;
    bytes.push(0);
    assert!(decode::<ProcessImage>(&bytes).is_none());
}

#[test]
fn what_decodes_is_not_yet_believed() {
    let good = samples::station_state();
    type Spoil = fn(&mut StationState);
    let cases: [(Spoil, &str); 10] = [
        (|s| s.boot_id = 0, "boot_id"),
        (|s| s.station.clear(), "station"),
        (|s| s.mode = 6, "mode is 6, known are 0 to 5"),
        (|s| s.lifecycle = 0, "lifecycle is 0, known are 1 to 4"),
        (|s| s.places[0] = 7, "places is 7"),
        (|s| s.done.push(0), "started holds 3 elements but done holds 4"),
        (|s| s.incomplete.push(3), "incomplete names operation 3"),
        (|s| s.fault = "x".repeat(TEXT_BYTES_MAX + 1), "StationState.fault holds 4097"),
        (|s| s.blocked_by = vec![String::new(); 4097], "StationState.blocked_by holds 4097"),
        (|s| s.answers[0].in_the_way = "x".repeat(TEXT_BYTES_MAX + 1), "StationState.answers.in_the_way"),
    ];
    for (spoil, expected) in cases {
        let mut state = good.clone();
        spoil(&mut state);
        let error = state.validate().expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let mut line = samples::line_state();
    line.station_heard.pop();
    assert!(matches!(line.validate(), Err(Invalid::LengthsDiffer { .. })));
    let order = ModeOrder { mode: 200, ..samples::mode_order() };
    assert!(matches!(order.validate(), Err(Invalid::UnknownValue { value: 200, .. })));
}

#[test]
fn orders_are_not_yet_believed() {
    type Spoil = fn(&mut OrderState);
    let good = samples::order_state();
    let cases: [(Spoil, &str); 6] = [
        (|s| s.memory = 0, "memory"),
        (|s| s.doing_id = 0, "doing_id"),
        (|s| s.phase = 3, "phase is 3, known are 1 to 2"),
        (|s| (s.doing_epoch, s.doing_id) = (0, 0), "phase is 1, known are 0 to 0"),
        (|s| s.ended = s.refused.clone(), "ended: end is 3, known are 0 to 2"),
        (|s| s.refused = s.ended.clone(), "refused: end is 0, known are 3 to 3"),
    ];
    for (spoil, expected) in cases {
        let mut state = good.clone();
        spoil(&mut state);
        let error = state.validate().expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let (goal, result, _) = samples::run_task();
    assert!(RunTaskGoal { parameters: vec![1], ..goal.clone() }.validate().is_err());
    assert!(RunTaskGoal { epoch: 0, ..goal }.validate().is_err());
    assert!(RunTaskResult { code: 0, ..result }.validate().is_err(), "a refusal has a reason");
}

#[test]
fn an_image_is_one_little_endian_number() {
    let mut image = samples::process_image();
    image.set_word(1 << 127 | 0b101);
    assert_eq!(image.word(), 1 << 127 | 0b101);
    assert_eq!(image.bits.as_slice()[0], 0b101);
    image.bits = linewright_msgs::Bounded::new(vec![0xff]).expect("fits");
    assert_eq!(image.word(), 0xff, "missing bytes are zero");
}

proptest! {
    #[test]
    fn noise_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        if let Some(message) = decode::<StationState>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<StationEvent>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<ProcessImage>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<ModeOrder>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<LineState>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<Text>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<RunTaskGoal>(&bytes) { let _ = message.validate(); }
        if let Some(message) = decode::<OrderState>(&bytes) { let _ = message.validate(); }
    }

    #[test]
    fn flipped_bytes_never_panic(at in 0usize..1000, value in any::<u8>()) {
        let mut bytes = encode(&samples::station_state());
        let at = at % bytes.len();
        bytes[at] = value;
        if let Some(message) = decode::<StationState>(&bytes) {
            let _ = message.validate();
            // Whatever its content, it came out of these few bytes.
            prop_assert!(message.done.len() + message.started.len() + message.places.len() <= bytes.len());
        }
    }
}

#[test]
fn a_text_is_cut_where_a_character_ends() {
    assert_eq!(fitting("short".to_owned()), "short");
    let longest = "ä".repeat(TEXT_BYTES_MAX / 2);
    assert_eq!(fitting(longest.clone()), longest);
    for before in 0..4 {
        let cut = fitting("a".repeat(before) + &longest + "bb");
        assert!(cut.len() <= TEXT_BYTES_MAX && cut.len() > TEXT_BYTES_MAX - 8 && cut.ends_with(" …"), "{}", cut.len());
    }
}
