//! Devices without CANopen: a gauge beside the clamp's device.

use linewright_line::{
    Checksum, Coding, DbcName, FrameBinding, FrameField, FrameId, FrameTable, Page, ReceivedFrameBinding,
    SentFrameBinding, When,
};

use super::*;

fn field(start: u8, size: u8) -> FrameField {
    FrameField { start, size, motorola: false, coding: Coding::Unsigned, factor: 0.5, offset: 0.0 }
}

/// It sends 18FEF100h every so often: a value in byte 0 (input 1 from 20 up, with a hysteresis of 5), a counter in the
/// lower half of byte 1. It is sent 123h: bit 0 is output 1, a counter in byte 1, a sum in byte 2.
fn gauge() -> Device {
    let heard = ReceivedFrameBinding {
        name: "State".to_owned(),
        id: FrameId { id: 0x18FE_F100, extended: true },
        len: 2,
        timeout: Duration::from_millis(100),
        counter: Some(field(8, 4)),
        checksum: None,
        pages: vec![Page {
            selected: None,
            inputs: vec![(InputId(1), field(0, 8), When::Above { at: 20.0, hysteresis: 5.0 })],
            limits: vec![(field(0, 8), 0.0, 60.0)],
        }],
    };
    let told = SentFrameBinding {
        name: "Command".to_owned(),
        id: FrameId { id: 0x123, extended: false },
        len: 3,
        every: Duration::from_millis(20),
        lets_go_after: None,
        counter: Some(field(8, 8)),
        checksum: Some((2, Checksum::Sum)),
        rest: [0; 8],
        outputs: vec![(OutputId(1), field(0, 1), 1)],
    };
    let mut device = devices().remove(2);
    device.name = "gauge".to_owned();
    device.kind = DeviceKind::Frames(FrameTable {
        file: DbcName { name: "gauge.dbc".to_owned(), at: 0..0 },
        receive: Vec::new(),
        send: Vec::new(),
        bound: Some(FrameBinding { heard: vec![heard], told: vec![told] }),
    });
    device
}

fn binding_of(gauge: &mut Device) -> &mut FrameBinding {
    match &mut gauge.kind {
        DeviceKind::Frames(FrameTable { bound: Some(bound), .. }) => bound,
        _ => panic!("a device of frames"),
    }
}

/// The clamp's device is up; the gauge is silent.
fn bench() -> ManagerBench {
    let devices = [devices().remove(2), gauge()];
    let mut bench = ManagerBench::of(&devices);
    bench.bring_up(6);
    bench.take();
    bench
}

fn sent(bench: &mut ManagerBench) -> Vec<String> {
    bench.frames().into_iter().filter(|frame| frame.starts_with("123")).collect()
}

#[test]
fn it_is_sent_rest_again_and_again_and_energised_only_when_it_is_heard() {
    let mut bench = bench();
    bench.set(CLAMP, 0b10);
    for _ in 0..4 {
        bench.hear("706#05");
        bench.pass(10);
    }
    assert_eq!(sent(&mut bench), ["123#000101", "123#000202"], "count 0 went with the first poll");
    assert!(!bench.inputs(CLAMP).valid);
    let trouble: Vec<String> = bench.manager.trouble(bench.now, CLAMP).collect();
    assert_eq!(trouble, ["gauge: nothing of message State (18FEF100h) yet: it does not come"]);
    bench.hear("18FEF100#2800");
    let (frames, events) = bench.take();
    assert_eq!(frames, ["123#010304"], "at once: what its owner has set in the meantime");
    let id = FrameId { id: 0x18FE_F100, extended: true };
    assert_eq!(events, [BusEvent::FramesUp { id }, BusEvent::InputsChanged { owner: CLAMP }]);
    assert_eq!((bench.inputs(CLAMP).valid, bench.inputs(CLAMP).bits), (true, 0b10));
    bench.set(CLAMP, 0);
    assert_eq!(sent(&mut bench), ["123#000404"]);
}

#[test]
fn an_input_follows_its_limit_with_hysteresis() {
    let mut bench = bench();
    for (nth, (text, on)) in [("27", 0), ("28", 2), ("1F", 2), ("1E", 2), ("1D", 0), ("27", 0)].iter().enumerate() {
        bench.hear(&format!("18FEF100#{text}{nth:02X}"));
        assert_eq!(bench.inputs(CLAMP).bits, *on, "{text}");
    }
}

/// A message in two forms: to the device it is one, whose counter never stands still.
#[test]
fn one_counter_runs_through_all_forms_of_a_message() {
    let mut gauge = gauge();
    let bound = binding_of(&mut gauge);
    let mut other = bound.told[0].clone();
    other.rest[0] = 0x80;
    other.outputs.clear();
    bound.told.push(other);
    let mut bench = ManagerBench::of(&[gauge]);
    for _ in 0..3 {
        bench.poll();
        bench.pass(20);
    }
    let sent = sent(&mut bench);
    let counts: Vec<&str> = sent.iter().map(|frame| &frame[6..8]).collect();
    assert_eq!(counts[..6], ["00", "01", "02", "03", "04", "05"], "{sent:?}");
}

#[test]
fn a_value_that_is_none_makes_its_frame_none() {
    // Steps of a half; from 0 to 60 it is a value.
    let mut bench = bench();
    bench.hear("18FEF100#7800");
    assert_eq!((bench.inputs(CLAMP).valid, bench.inputs(CLAMP).bits), (true, 2));
    for _ in 0..10 {
        bench.hear("18FEF100#FF01");
        bench.pass(10);
    }
    assert!(!bench.inputs(CLAMP).valid);
    let trouble: Vec<String> = bench.manager.trouble(bench.now, CLAMP).collect();
    assert!(
        trouble.iter().any(|text| text.ends_with("its signal at bit 0 is beyond its limits in the DBC file")),
        "{trouble:?}"
    );
    // Not even its counter was taken.
    bench.hear("18FEF100#0001");
    assert!(bench.inputs(CLAMP).valid);
    let number = FrameField { size: 32, coding: Coding::Float, factor: 1.0, ..field(16, 32) };
    for when in [When::NotZero, When::Above { at: 1.0, hysteresis: 0.0 }, When::Below { at: 1.0, hysteresis: 0.0 }] {
        let mut gauge = gauge();
        let heard = &mut binding_of(&mut gauge).heard[0];
        (heard.len, heard.pages[0].inputs) = (6, vec![(InputId(1), number, when)]);
        let mut bench = ManagerBench::of(&[gauge]);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            bench.hear(&format!("18FEF100#0000{:08X}", value.to_bits().swap_bytes()));
            assert!(!bench.inputs(CLAMP).valid, "{when:?} {value}");
        }
    }
}

#[test]
fn a_value_between_two_limits_is_off_after_a_silence() {
    let mut bench = bench();
    bench.hear("18FEF100#2800");
    assert_eq!(bench.inputs(CLAMP).bits, 0b10);
    bench.pass_with(100, &[6]);
    assert!(!bench.inputs(CLAMP).valid);
    bench.hear("18FEF100#1F01");
    assert_eq!((bench.inputs(CLAMP).valid, bench.inputs(CLAMP).bits), (true, 0));
}

#[test]
fn one_that_falls_silent_or_says_the_same_again_is_lost_and_takes_its_owners_outputs_along() {
    for (again, why) in [
        (None, "it does not come"),
        (Some("18FEF100#2801"), "its counter stands still"),
        (Some("18FEF100#28"), "it has too few bytes"),
    ] {
        let mut bench = bench();
        bench.hear("18FEF100#2800");
        bench.hear("18FEF100#2801");
        bench.set(CLAMP, 0b11);
        bench.take();
        for _ in 0..9 {
            bench.hear("706#05");
            again.iter().for_each(|text| bench.hear(text));
            bench.pass(10);
        }
        assert!(bench.inputs(CLAMP).valid, "{why}");
        bench.pass(9);
        bench.take();
        again.iter().for_each(|text| bench.hear(text));
        bench.pass(1);
        let (frames, events) = bench.take();
        let said: Vec<String> = events.iter().map(BusEvent::to_string).collect();
        assert!(
            said.contains(&format!("the sender of 18FEF100h is lost: nothing of it for 100 ms: {why}")),
            "{said:?}"
        );
        assert!(frames.contains(&"206#00".to_owned()), "{frames:?}");
        assert!(frames.iter().any(|frame| frame.starts_with("123#00")), "{frames:?}");
        assert!(!bench.inputs(CLAMP).valid);
        // Live again, it gets the outputs set since: none.
        bench.hear("18FEF100#2807");
        assert!(bench.inputs(CLAMP).valid);
        assert!(!bench.frames().iter().any(|frame| frame.starts_with("123#01") || frame == "206#01"));
    }
}

#[test]
fn a_loss_of_the_other_device_switches_it_off() {
    let mut bench = bench();
    bench.hear("18FEF100#2800");
    bench.set(CLAMP, 0b10);
    bench.take();
    bench.hear("706#00");
    assert_eq!(sent(&mut bench).iter().map(|frame| &frame[..6]).collect::<Vec<_>>(), ["123#00"]);
}

#[test]
fn identifiers_have_one_meaning() {
    let refused = |id: u32, extended: bool| {
        let mut gauge = gauge();
        let bound = binding_of(&mut gauge);
        bound.heard[0].id = FrameId { id, extended };
        Manager::new(&[devices().remove(2), gauge], Timing::default()).map(|_| ()).err().map(|error| error.to_string())
    };
    assert_eq!(
        refused(0x186, false).unwrap(),
        "device `gauge` has messages with identifier 186h, which is that of device `clamp`"
    );
    assert!(refused(0x77F, false).is_some() && refused(0x123, false).is_some());
    assert_eq!((refused(0x187, false), refused(0x186, true)), (None, None));
    let mut unread = gauge();
    let DeviceKind::Frames(frames) = &mut unread.kind else { panic!("a device of frames") };
    frames.bound = None;
    let error = Manager::new(&[unread], Timing::default()).map(|_| ()).unwrap_err();
    assert_eq!(error.to_string(), "device `gauge`: its file gauge.dbc has not been read");
}

/// For the end of a process that is stuck: it is sent what an orderly end sends, with the counter that comes next.
#[test]
fn what_would_let_go_of_its_outputs_is_known_all_the_time() {
    let mut bench = bench();
    bench.hear("18FEF100#2800");
    bench.set(CLAMP, 0b10);
    bench.take();
    for _ in 0..3 {
        let mut frames = Vec::new();
        bench.manager.release_frames(&mut frames);
        let mut out = BusOutbox::default();
        bench.manager.release_outputs(bench.now, &mut out);
        let ended: Vec<Frame> = out.frames.into_iter().filter(|frame| frame.id_word() == 0x123).collect();
        assert!(!frames.is_empty() && frames.iter().all(|frame| frame.data()[0] == 0), "{frames:?}");
        assert_eq!(frames, ended);
    }
    let mut frames = Vec::new();
    ManagerBench::listening(&[gauge()]).manager.release_frames(&mut frames);
    assert_eq!(frames, [], "one that may have come second on its bus sends nothing");
}
