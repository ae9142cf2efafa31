//! Descriptions of the devices that keep an owner's image from being valid.

use super::*;

/// The sentences for the clamp.
fn said(bench: &ManagerBench) -> Vec<String> {
    let said: Vec<String> = bench.manager.trouble(bench.now, CLAMP).collect();
    assert_eq!(
        said.is_empty(),
        bench.inputs(CLAMP).valid,
        "there is trouble exactly while inputs are invalid: {said:?}"
    );
    let of_it = bench.manager.trouble_of(bench.now, node(6)).map(|what| format!("clamp (node 06h): {what}"));
    assert_eq!(of_it.as_ref(), said.first(), "the same of the device alone");
    said
}

fn one(bench: &ManagerBench) -> String {
    let said = said(bench);
    let [sentence] = &said[..] else { panic!("{said:?}") };
    sentence.clone()
}

#[test]
fn a_device_that_was_never_there() {
    let bench = ManagerBench::new();
    assert_eq!(
        one(&bench),
        "clamp (node 06h): never heard: no boot-up and no heartbeat (706h, 1017h); asked for its device type (1000h) every 500 ms"
    );
    assert_eq!(bench.manager.trouble(bench.now, DRILL).count(), 2, "one for each device");
}

#[test]
fn a_device_that_fell_silent() {
    let mut bench = ManagerBench::up();
    assert_eq!(said(&bench), Vec::<String>::new());
    bench.set(CLAMP, 1);
    bench.take();
    bench.pass_with(200, &[4, 5]);
    assert_eq!(one(&bench), "clamp (node 06h): no heartbeat (1017h) for 200 ms");
    let last = bench.frames().into_iter().rfind(|frame| frame.starts_with("206"));
    assert_eq!(last.as_deref(), Some("206#00"), "it may hear more than it says");
    assert_eq!(bench.manager.trouble(bench.now, DRILL).count(), 0);
    bench.pass_with(100, &[4, 5]);
    assert_eq!(one(&bench), "clamp (node 06h): no heartbeat (1017h) for 300 ms");
}

#[test]
fn a_device_whose_heartbeat_alone_has_stopped_is_not_trusted_by_its_process_data() {
    let mut bench = ManagerBench::up();
    let mut lost = 0;
    for round in 0..60 {
        bench.hear("186#01");
        bench.pass_with(50, &[4, 5]);
        // It answers every request.
        bench.keeps_what_it_is_told(6);
        let events = bench.take().1;
        lost += events.iter().filter(|e| matches!(e, BusEvent::DeviceLost { .. })).count();
        assert!(round < 5 || !bench.inputs(CLAMP).valid, "{round}");
    }
    assert_eq!(lost, 1, "said once");
    let said = one(&bench);
    assert!(said.starts_with("clamp (node 06h): no heartbeat (1017h) for 3000 ms, though it answers (SDO)"), "{said}");
    // With its next heartbeat it is as good as any other.
    bench.hear("706#05");
    bench.configure(6);
    bench.hear("706#05");
    bench.hear("186#01");
    assert!(bench.inputs(CLAMP).valid);
}

#[test]
fn a_device_that_booted_says_so_while_it_is_brought_up() {
    let mut bench = ManagerBench::up();
    bench.hear("706#00");
    assert_eq!(
        one(&bench),
        "clamp (node 06h): it has booted (boot-up, 706h); being identified: waits for its device type (object 1000h:00)"
    );
    bench.configure(6);
    bench.hear("706#05");
    assert_eq!(one(&bench), "clamp (node 06h): operational, but its inputs (TPDO1, 186h) have not come yet");
    bench.hear("186#00");
    assert_eq!(said(&bench), Vec::<String>::new());
}

#[test]
fn a_device_that_was_stopped_or_let_go_by_itself() {
    let mut bench = ManagerBench::up();
    bench.hear("706#04");
    let said = one(&bench);
    assert_eq!(
        said,
        "clamp (node 06h): stopped by somebody else (NMT), and left so until it is started; its heartbeat says 04h (706h)"
    );
    let mut bench = ManagerBench::up();
    bench.hear("086#3081110000000000");
    let said = one(&bench);
    assert!(said.starts_with("clamp (node 06h): emergency 8130h (heartbeat or life guard error: it does not hear its manager), register 11h; "), "{said}");
}
