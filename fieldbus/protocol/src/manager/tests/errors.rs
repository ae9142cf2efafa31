//! Errors that a device reports itself: whose inputs are invalid, until when; and a bus that is off, or full of one
//! node.

use linewright_line::Reaction;

use super::*;

fn trouble(bench: &ManagerBench, owner: Owner) -> Vec<String> {
    bench.manager.trouble(bench.now, owner).collect()
}

const OVERLOAD: &str = "086#1023050000000000";

#[test]
fn a_device_in_error_is_not_trusted_until_it_says_that_the_error_is_gone() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.set(DRILL, 1);
    bench.take();
    bench.hear(OVERLOAD);
    assert_eq!(bench.frames(), ["206#00"], "what was decided before is not energised after it");
    assert!(!bench.inputs(CLAMP).valid && bench.inputs(DRILL).valid);
    assert_eq!(
        trouble(&bench, CLAMP),
        ["clamp (node 06h): emergency 2310h (current at outputs too high, overload), error register 1001h = 05h"]
    );
    // It goes on sending its inputs, and another error joins the first.
    bench.hear("186#01");
    bench.hear("086#1031070000000000");
    bench.hear("086#0000050000000000");
    assert!(!bench.inputs(CLAMP).valid, "one of the two is left");
    bench.hear("086#0000000000000000");
    assert!(bench.inputs(CLAMP).valid && bench.inputs(CLAMP).losses == 1);
    assert_eq!(trouble(&bench, CLAMP), Vec::<String>::new());
    bench.set(CLAMP, 1);
    assert!(bench.frames().contains(&"206#01".to_owned()));
}

#[test]
fn the_end_of_an_error_is_found_though_the_frame_that_says_so_is_lost() {
    let mut bench = ManagerBench::up();
    bench.hear(OVERLOAD);
    bench.take();
    let mut asked = 0;
    for round in 0..60 {
        bench.pass_with(50, &[4, 5, 6]);
        if bench.frames().contains(&"606#4001100000000000".to_owned()) {
            asked += 1;
            let register = if asked < 3 { 5 } else { 0 };
            bench.hear(&format!("586#4F011000{register:02X}000000"));
        }
        assert_eq!(bench.inputs(CLAMP).valid, asked == 3, "{round}");
    }
    assert_eq!(asked, 3, "once a second, and not any more after that");
}

#[test]
fn what_is_about_the_wire_alone_is_reported() {
    for (frame, stands) in [
        ("086#1081110000000000", false), // overrun
        ("086#2081110000000000", false), // error passive
        ("086#5081110000000000", true),  // another node uses its identifier
        ("086#1082110000000000", true),  // outputs not taken
        ("086#1081130000000000", true),  // overrun, and the register has a current
        ("086#1023000000000000", false), // passed
        ("086#00FF810000000000", true),  // the manufacturer's own
    ] {
        let mut bench = ManagerBench::up();
        bench.hear(frame);
        assert!(matches!(bench.take().1[0], BusEvent::Emergency { .. }));
        assert_eq!(bench.inputs(CLAMP).valid, !stands, "{frame}");
    }
}

#[test]
fn a_device_that_comes_up_in_error_is_not_trusted() {
    let mut bench = ManagerBench::up();
    bench.hear("706#00");
    bench.configure_to_register(6);
    bench.hear("586#4F01100009000000");
    bench.hear("706#05");
    bench.hear("186#00");
    assert!(!bench.inputs(CLAMP).valid);
    assert_eq!(trouble(&bench, CLAMP), ["clamp (node 06h): its error register 1001h = 09h (generic, temperature)"]);
    bench.hear("086#0000000000000000");
    assert!(bench.inputs(CLAMP).valid);
}

#[test]
fn one_that_recovered_from_bus_off_has_let_go_and_is_started_again() {
    let mut bench = ManagerBench::up();
    bench.hear("086#4081110000000000");
    assert!(!bench.inputs(CLAMP).valid);
    assert!(bench.frames().contains(&"606#4000100000000000".to_owned()), "it may have booted unheard");
    bench.configure(6);
    assert!(bench.frames().contains(&"000#0106".to_owned()));
    assert!(trouble(&bench, CLAMP)[0].starts_with("clamp (node 06h): emergency 8140h (recovered from bus-off)"));
}

#[test]
fn an_emergency_that_is_only_reported_changes_nothing() {
    let mut devices = devices();
    devices[2].canopen_mut().expect("CANopen").setup.on_emergency = Some(Reaction::Report);
    let mut bench = ManagerBench::of(&devices);
    bench.bring_up(6);
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear(OVERLOAD);
    let (frames, events) = bench.take();
    assert!(frames.is_empty() && matches!(events[..], [BusEvent::Emergency { .. }]));
    assert!(bench.inputs(CLAMP).valid && trouble(&bench, CLAMP).is_empty());
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert!(
        is.ends_with("emergency 2310h (current at outputs too high, overload), error register 1001h = 05h"),
        "{is}"
    );
}

#[test]
fn a_device_that_may_be_lost_takes_nobody_along() {
    // The clamp's owner has two devices here, one of which may be lost.
    let mut devices = devices();
    devices[1].canopen_mut().expect("CANopen").setup.when_lost = Reaction::Report;
    let mut bench = ManagerBench::of(&devices);
    bench.bring_up(4);
    assert!(bench.inputs(DRILL).valid, "it need not even be there");
    bench.bring_up(5);
    bench.hear("185#01");
    bench.set(DRILL, 0b11);
    bench.take();
    assert_eq!(bench.inputs(DRILL).bits, 0b10);
    bench.pass_with(200, &[4, 6]);
    let (frames, events) = bench.take();
    assert!(events.contains(&BusEvent::DeviceLost { node: node(5), silent_for: Duration::from_millis(200) }));
    assert!(frames.contains(&"204#01".to_owned()) && !frames.contains(&"204#00".to_owned()), "{frames:?}");
    let inputs = bench.inputs(DRILL);
    assert!(inputs.valid && inputs.losses == 0);
    assert_eq!(inputs.bits, 0, "its inputs read off while it is away");
    assert_eq!(trouble(&bench, DRILL), Vec::<String>::new());
}

#[test]
fn a_bus_that_is_off_loses_every_device_at_once_for_that_reason() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear("20000040#0000000000000000");
    assert!(!bench.inputs(CLAMP).valid && !bench.inputs(DRILL).valid);
    bench.set(CLAMP, 1);
    bench.pass(120);
    assert!(!bench.frames().iter().any(|f| f.starts_with("206")), "nobody hears it; it must not wait in a queue");
    assert_eq!(trouble(&bench, CLAMP), ["clamp (node 06h): the bus is off since 120 ms: nothing is heard from it"]);
    // Shorter than the devices' own patience: they still have what they were sent.
    bench.hear("20000100#0000000000000000");
    let frames = bench.frames();
    assert_eq!(frames[..3], ["204#00", "205#00", "206#00"], "everything is let go first");
    bench.poll();
    assert!(bench.frames().contains(&"606#4000100000000000".to_owned()), "and everybody asked for");
    bench.hear("706#05");
    assert!(trouble(&bench, CLAMP)[0].starts_with("clamp (node 06h): the bus was off; being identified"));
    bench.configure(6);
    bench.hear("706#05");
    bench.hear("186#01");
    assert!(bench.inputs(CLAMP).valid);
}

#[test]
fn a_bus_whose_return_nobody_reports_is_on_again_with_the_first_frame() {
    let mut bench = ManagerBench::up();
    bench.hear("20000040#0000000000000000");
    bench.take();
    bench.hear("705#05");
    assert_eq!(bench.manager.off_the_bus(), None);
    assert_eq!(bench.frames()[..3], ["204#00", "205#00", "206#00"]);
}

/// Frames and events in response to a second of 4000 of these.
fn flood(frames: &[&str]) -> (ManagerBench, Vec<String>, Vec<BusEvent>) {
    let mut bench = ManagerBench::up();
    bench.set(DRILL, 0b11);
    bench.take();
    for at in 0..4000u32 {
        if at % 200 == 0 {
            bench.hear("704#05");
            bench.hear("705#05");
        }
        bench.now = bench.now + Duration::from_micros(250);
        bench.hear(frames[at as usize % frames.len()]);
        while bench.manager.next_deadline().is_some_and(|due| due <= bench.now) {
            bench.poll();
        }
        assert!(bench.inputs(DRILL).valid, "the others are not concerned");
    }
    let (sent, events) = bench.take();
    (bench, sent, events)
}

#[test]
fn a_node_that_babbles_costs_little_and_concerns_nobody_else() {
    let floods: [&[&str]; 8] = [
        &["186#00", "186#01"],
        &["706#00"],
        &["706#05", "706#7F"],
        &["706#05"],
        &["086#1023050000000000", "086#0000000000000000"],
        &["086#FFFF810102030405", "706#00", "186#01", "706#04"],
        &["187#00"], // an unknown node
        &["586#6017100000000000", "18612345#00", "7E6#00"],
    ];
    for frames in floods {
        let (mut bench, sent, events) = flood(frames);
        assert!(sent.len() < 400, "{frames:?}: {} frames sent", sent.len());
        assert!(events.len() < 600, "{frames:?}: {} events", events.len());
        let own = frames.iter().all(|frame| ["186", "706", "086"].iter().any(|id| frame.starts_with(id)));
        assert!(!bench.inputs(CLAMP).valid, "{frames:?}: it babbles, or has not been heard for a second");
        if own {
            assert!(events.contains(&BusEvent::Babbles { node: node(6) }), "{frames:?}");
        }
        // It comes to its senses, or is replaced, and is as good as any other.
        bench.pass_with(3000, &[4, 5]);
        bench.hear("706#00");
        bench.configure(6);
        bench.hear("086#0000000000000000");
        bench.hear("706#05");
        bench.hear("186#01");
        assert!(bench.inputs(CLAMP).valid, "{frames:?}: {:?}", trouble(&bench, CLAMP));
    }
}

#[test]
fn a_node_that_babbles_says_so() {
    let (bench, _, _) = flood(&["186#00", "186#01", "706#05"]);
    assert_eq!(
        trouble(&bench, CLAMP),
        ["clamp (node 06h): it babbles: more than 200 frames within 100 ms; it is not listened to"]
    );
}

/// The interface has just refused the order to let go when the device reports an error.
#[test]
fn an_order_to_let_go_that_waits_is_sent_all_the_same() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.set(CLAMP, 0);
    assert_eq!(bench.take().0, ["206#01", "206#00"]);
    bench.manager.return_unsent(bench.now, vec!["206#00".parse().unwrap()]);
    bench.manager.handle(bench.now, &OVERLOAD.parse().unwrap(), &mut bench.out);
    bench.take();
    bench.pass(5);
    assert!(bench.frames().contains(&"206#00".to_owned()));
}

/// The device reports that its error is gone; an answer from before reports that it stands.
#[test]
fn an_old_answer_about_an_error_makes_outputs_be_let_go() {
    let mut bench = ManagerBench::up();
    bench.hear(OVERLOAD);
    bench.pass_with(1000, &[4, 5, 6]);
    assert!(bench.frames().contains(&"606#4001100000000000".to_owned()), "it is asked for its register");
    bench.hear("086#0000000000000000");
    assert!(bench.inputs(CLAMP).valid);
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear("586#4F01100005000000");
    assert!(!bench.inputs(CLAMP).valid);
    assert_eq!(bench.frames(), ["206#00"]);
}

/// Whatever the devices are thought to have: what they were sent last may not have left.
#[test]
fn at_the_end_everything_is_let_go_and_nothing_that_waited_is_sent() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.take();
    bench.manager.return_unsent(bench.now, vec!["206#01".parse().unwrap()]);
    bench.manager.release_outputs(bench.now, &mut bench.out);
    assert!(bench.take().0.contains(&"206#00".to_owned()));
    bench.pass(5);
    assert!(!bench.frames().contains(&"206#01".to_owned()));
}

#[test]
fn a_boot_ends_an_error_also_of_a_device_that_was_away_and_has_no_register() {
    let mut bench = ManagerBench::up();
    bench.hear(OVERLOAD);
    bench.pass(1000);
    bench.hear("706#00");
    bench.configure_to_register(6);
    bench.hear("586#8001100000000206");
    bench.hear("186#00");
    assert!(bench.inputs(CLAMP).valid, "{:?}", trouble(&bench, CLAMP));
}

#[test]
fn one_that_somebody_stopped_is_left_so_also_after_it_was_not_heard_for_a_while() {
    let floods = |bench: &mut ManagerBench| (0..300).for_each(|_| bench.hear("186#00"));
    let silence = |bench: &mut ManagerBench| bench.pass_with(400, &[4, 5]);
    let bus_off = |bench: &mut ManagerBench| {
        bench.hear("20000040#0000000000000000");
        bench.hear("20000100#0000000000000000");
    };
    for lost in [&floods as &dyn Fn(&mut ManagerBench), &silence, &bus_off] {
        let mut bench = ManagerBench::up();
        bench.hear("706#04");
        lost(&mut bench);
        (0..30).for_each(|_| bench.pass_with(50, &[4, 5]));
        bench.take();
        for _ in 0..60 {
            bench.hear("706#04");
            bench.pass_with(50, &[4, 5]);
        }
        let frames = bench.frames();
        assert!(!frames.iter().any(|frame| frame.starts_with("000#") || frame.starts_with("606#")), "{frames:?}");
        let said = trouble(&bench, CLAMP);
        assert!(said[0].starts_with("clamp (node 06h): stopped by somebody else (NMT)"), "{said:?}");
        // A device that is made to boot, or put in another state, is brought up again.
        bench.bring_up(6);
        assert!(bench.inputs(CLAMP).valid);
        // And from then on it is like any other: found stopped, it is woken.
        bench.pass_with(400, &[4, 5]);
        bench.take();
        bench.hear("706#04");
        assert!(bench.frames().contains(&"606#4000100000000000".to_owned()));
    }
}

#[test]
fn an_error_of_its_own_that_turns_into_one_of_the_wire_has_ended() {
    for said in ["086#2081110000000000", "586#4F01100011000000"] {
        let mut bench = ManagerBench::up();
        bench.hear(OVERLOAD);
        bench.pass_with(1000, &[4, 5, 6]);
        assert!(!bench.inputs(CLAMP).valid);
        bench.hear(said);
        assert!(bench.inputs(CLAMP).valid, "{said}: {:?}", trouble(&bench, CLAMP));
    }
    // Generic alone is not of the wire, and an identifier used twice does not end by itself.
    for first in ["086#0010010000000000", "086#5081950000000000"] {
        let mut bench = ManagerBench::up();
        bench.hear(first);
        bench.pass_with(1000, &[4, 5, 6]);
        bench.hear("586#4F01100011000000");
        assert!(!bench.inputs(CLAMP).valid, "{first}");
    }
}
