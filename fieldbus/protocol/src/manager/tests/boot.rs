//! Bringing devices up: identity, settings, and the handling of devices that do not answer or refuse.

use linewright_line::{DeviceIdentity, ObjectWrite};

use super::*;
use crate::sdo::{Abort, ObjectId, TransferError, TransferFailure};

/// The clamp's device must be this one.
fn particular() -> ManagerBench {
    let mut devices = devices();
    let setup = &mut devices[2].canopen_mut().expect("CANopen").setup;
    setup.identity = DeviceIdentity { vendor: Some(0x123), revision: Some(0x0001_0002), ..DeviceIdentity::default() };
    setup.settings = vec![ObjectWrite { index: 0x6206, sub: 1, data: vec![0xFF] }];
    let mut bench = ManagerBench::of(&devices);
    bench.hear("706#00");
    bench.hear("586#4300100091010300");
    bench.take();
    bench
}

#[test]
fn a_device_that_does_not_watch_the_manager_is_not_started() {
    let mut bench = ManagerBench::new();
    bench.take();
    bench.hear("706#00");
    bench.hear("586#4300100091010300");
    bench.hear("586#6017100000000000");
    bench.take();
    bench.hear("586#8016100111000906");
    let (frames, events) = bench.take();
    assert!(frames.is_empty());
    let error = TransferError { object: ObjectId::new(0x1016, 1), cause: TransferFailure::Refused(Abort(0x0609_0011)) };
    assert_eq!(events, [BusEvent::BootFailed { node: node(6), why: BootError::Transfer { writing: true, error } }]);
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert!(is.starts_with("not started: it cannot be configured: object 1016h:01: refused: 06090011h"), "{is}");
    bench.hear("706#05");
    bench.hear("186#01");
    assert!(!bench.inputs(CLAMP).valid);
}

#[test]
fn unanswered_questions_and_orders_are_repeated() {
    let mut bench = ManagerBench::new();
    bench.take();
    bench.hear("706#00");
    bench.hear("586#4300100091010300");
    bench.take();
    let alive = |bench: &mut ManagerBench| {
        for _ in 0..10 {
            bench.hear("706#7F");
            bench.pass(50);
        }
        bench.frames()
    };
    assert!(alive(&mut bench).contains(&"606#2B17100032000000".to_owned()));
    bench.hear("586#6017100000000000");
    bench.hear("586#6016100100000000");
    bench.takes_error_values(6);
    bench.take();
    assert!(alive(&mut bench).contains(&"606#4001100000000000".to_owned()));
    bench.hear("586#4F01100000000000");
    bench.take();
    let again = alive(&mut bench);
    assert!(again.contains(&"606#4000100000000000".to_owned()), "a start without effect begins anew: {again:?}");
    assert!(!again.contains(&"000#0106".to_owned()), "it may have booted unheard: never started as it is");
}

#[test]
fn a_device_that_is_alive_but_answers_nothing_is_said_to_be_and_asked_again() {
    let mut bench = ManagerBench::new();
    bench.take();
    let mut events = Vec::new();
    for _ in 0..80 {
        bench.hear("706#7F");
        bench.pass(50);
        events.extend(bench.take().1);
    }
    let [BusEvent::BootFailed { node: which, why: BootError::Transfer { writing: false, error } }] = events[..] else {
        panic!("{events:?}")
    };
    assert_eq!((which, error.object), (node(6), ObjectId::new(0x1000, 0)));
    assert!(matches!(error.cause, TransferFailure::Silent { asked: 2, .. }), "{error}");
    // It is brought up as soon as it answers, without intervention.
    bench.pass(500);
    bench.hear("706#7F");
    bench.take();
    bench.configure(6);
    assert!(bench.frames().contains(&"000#0106".to_owned()));
}

#[test]
fn another_device_than_expected_is_told_nothing_and_not_started() {
    let mut bench = particular();
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert_eq!(is, "being identified: waits for its vendor id (object 1018h:01)");
    bench.hear("586#4318100124010000");
    let (frames, events) = bench.take();
    assert_eq!(frames, Vec::<String>::new());
    let why = BootError::Identity { object: ObjectId::new(0x1018, 1), expected: 0x123, found: 0x124 };
    assert_eq!(events, [BusEvent::BootFailed { node: node(6), why }]);
    let said = events[0].to_string();
    assert!(said.ends_with("another device: its vendor id (object 1018h:01) is 00000124h, not 00000123h"), "{said}");
    // Looked at again after a while, and at once when it boots after a change.
    for _ in 0..100 {
        bench.hear("706#7F");
        bench.pass(50);
    }
    assert_eq!(bench.frames().iter().filter(|f| f.starts_with("606#40")).count(), 1);
    bench.hear("706#00");
    assert_eq!(bench.frames(), ["606#4000100000000000"]);
}

#[test]
fn the_device_that_is_expected_is_told_everything_in_order() {
    let mut bench = particular();
    bench.hear("586#4318100123010000");
    assert_eq!(bench.frames(), ["606#4018100300000000"], "the product is not compared, the revision is");
    bench.hear("586#4318100305000100");
    assert_eq!(bench.frames(), ["606#2F066201FF000000"], "a newer minor revision serves");
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert_eq!(is, "being configured: object 6206h:01 is written, 1 of 5");
    bench.hear("586#6006620100000000");
    assert_eq!(bench.frames(), ["606#4006620100000000"], "what the description says of it is read back as well");
    bench.hear("586#4F066201FF000000");
    assert_eq!(bench.frames(), ["606#2B17100032000000"]);
    bench.hear("586#6017100000000000");
    bench.take();
    bench.hear("586#6016100100000000");
    bench.takes_error_values(6);
    bench.take();
    bench.hear("586#4F01100000000000");
    assert_eq!(bench.frames(), ["000#0106"]);
}

#[test]
fn an_older_revision_does_not_serve() {
    for found in ["586#4318100301000100", "586#4318100302000200"] {
        let mut bench = particular();
        bench.hear("586#4318100123010000");
        bench.hear(found);
        assert!(
            matches!(bench.take().1[..], [BusEvent::BootFailed { why: BootError::Identity { .. }, .. }]),
            "{found}"
        );
    }
}

#[test]
fn devices_boot_side_by_side() {
    let mut bench = ManagerBench::new();
    bench.take();
    for node in 4..=6 {
        bench.hear(&format!("7{node:02X}#00"));
    }
    assert_eq!(bench.frames().len(), 3, "each is asked at once");
    // The first never answers; the others are up all the same.
    for node in 5..=6 {
        bench.configure(node);
        bench.hear(&format!("{:03X}#00", 0x180 + u16::from(node)));
    }
    let up: Vec<BusEvent> = bench.take().1.into_iter().filter(|e| matches!(e, BusEvent::DeviceUp { .. })).collect();
    assert_eq!(up, [BusEvent::DeviceUp { node: node(5) }, BusEvent::DeviceUp { node: node(6) }]);
}

/// The clamp's device is identified, its heartbeats are set, and pre-operational without a manager is requested of it.
fn asked_for_error_values(setup: linewright_line::DeviceSetup) -> ManagerBench {
    let mut devices = devices();
    devices[2].canopen_mut().expect("CANopen").setup = setup;
    let mut bench = ManagerBench::of(&devices);
    for text in ["706#00", "586#4300100091010300", "586#6017100000000000", "586#6016100100000000"] {
        bench.hear(text);
    }
    bench.take();
    bench
}

fn said(bench: &mut ManagerBench) -> String {
    let (frames, events) = bench.take();
    assert!(!frames.contains(&"000#0106".to_owned()), "{frames:?}");
    let [event @ BusEvent::BootFailed { .. }] = &events[..] else { panic!("{events:?}") };
    event.to_string()
}

/// The way out, as every one of these sentences names it.
const REMEDY: &str = "(it turns the outputs off when the manager is gone; without it they may stay on. Use or set up a device \
                      that keeps it, or give the reason in `without_error_values` why that is safe)";

#[test]
fn a_device_without_error_values_is_not_started() {
    let mut bench = asked_for_error_values(Default::default());
    // Without 1029h it goes to pre-operational anyway (CiA 301).
    bench.hear("586#8029100100000206");
    assert_eq!(bench.frames(), ["606#2F066201FF000000"]);
    bench.hear("586#8006620100000206");
    let text = said(&mut bench);
    assert_eq!(
        text,
        format!(
            "node 06h is not started: it cannot be configured: object 6206h:01: refused: 06020000h (no such object) {REMEDY}"
        )
    );
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert!(is.contains("6206h:01") && is.contains("without_error_values"), "{is}");
    bench.hear("706#05");
    bench.hear("186#01");
    assert!(!bench.inputs(CLAMP).valid);
}

#[test]
fn a_device_that_takes_its_error_values_and_keeps_others_is_not_started() {
    for (answers, object, found, written) in [
        (&["586#6029100100000000", "586#4F29100101000000"][..], "1029h:01", "01h", "00h"),
        (&["586#8029100100000206", "586#6006620100000000", "586#4F066201FE000000"], "6206h:01", "FEh", "FFh"),
        (
            &[
                "586#8029100100000206",
                "586#8006620102000106",
                "586#4F066201FF000000",
                "586#6007620100000000",
                "586#4F07620103000000",
            ],
            "6207h:01",
            "03h",
            "00h",
        ),
    ] {
        let mut bench = asked_for_error_values(Default::default());
        answers.iter().for_each(|text| bench.hear(text));
        let expected =
            format!("node 06h is not started: object {object} {REMEDY} is {found}, not {written} as written");
        assert_eq!(said(&mut bench), expected);
    }
}

#[test]
fn a_device_that_the_description_excuses_is_told_all_the_same_and_started() {
    let why = Some("its supply is cut by the safety relay".to_owned());
    let mut bench =
        asked_for_error_values(linewright_line::DeviceSetup { without_error_values: why, ..Default::default() });
    bench.hear("586#8029100100000206");
    bench.hear("586#8006620100000206");
    assert_eq!(bench.frames(), ["606#2F066201FF000000", "606#2F07620100000000"]);
    bench.hear("586#6007620100000000");
    bench.hear("586#4F07620101000000");
    bench.hear("586#4F01100000000000");
    assert_eq!(bench.frames().last().map(String::as_str), Some("000#0106"));
}

#[test]
fn the_error_values_of_every_byte_with_wired_outputs_are_told() {
    let mut devices = devices();
    let wired = |bit: u16| (bit != 3 && !(8..16).contains(&bit)).then_some(OutputId(bit));
    devices[2].io_mut().expect("I/O").outputs = (0..20).map(wired).collect();
    let mut bench = ManagerBench::of(&devices);
    bench.hear("706#00");
    let asked = bench.keeps_what_it_is_told(6);
    let told = asked.iter().filter(|text| text[4..].starts_with("2F"));
    let expected = ["2F29100100000000", "2F066201FF000000", "2F07620100000000", "2F066203FF000000", "2F07620300000000"];
    assert_eq!(told.map(|text| &text[4..]).collect::<Vec<_>>(), expected);
    assert!(
        bench.out.frames.is_empty() && bench.manager.explain(bench.now, node(6)).unwrap().contains("ordered to start")
    );
}
