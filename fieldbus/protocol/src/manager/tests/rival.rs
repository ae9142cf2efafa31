//! Two managers on one bus.

use super::*;

const RIVAL: &str = "77F#05";

/// Two managers of the same devices on one bus: what one sends the other receives.
struct ManagerPair {
    managers: [Manager; 2],
    /// Whether each is there.
    running: [bool; 2],
    now: Tick,
    /// Frames and events of each.
    sent: [Vec<String>; 2],
    told: [Vec<(Tick, BusEvent)>; 2],
}

impl ManagerPair {
    fn new() -> Self {
        let manager = || Manager::new(&devices(), Timing::default()).unwrap();
        let none = || [Vec::new(), Vec::new()];
        let now = Tick::from_millis(800);
        let told = [Vec::new(), Vec::new()];
        ManagerPair { managers: [manager(), manager()], running: [false; 2], now, sent: none(), told }
    }

    /// Lets time pass, a millisecond at a time; a manager that yields ends.
    fn pass(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            // Both are polled before either receives the other's frames.
            let mut outs = [BusOutbox::default(), BusOutbox::default()];
            for (at, out) in outs.iter_mut().enumerate() {
                if self.running[at] && self.managers[at].next_deadline().is_none_or(|due| due <= self.now) {
                    self.managers[at].poll(self.now, out);
                }
            }
            for (at, out) in outs.into_iter().enumerate() {
                self.give(at, out);
            }
            for at in 0..2 {
                self.running[at] &= self.managers[at].yields().is_none();
            }
        }
    }

    fn give(&mut self, at: usize, out: BusOutbox) {
        self.told[at].extend(out.events.into_iter().map(|event| (self.now, event)));
        for frame in out.frames {
            self.sent[at].push(frame.to_string());
            if self.running[1 - at] {
                let mut answer = BusOutbox::default();
                self.managers[1 - at].handle(self.now, &frame, &mut answer);
                self.give(1 - at, answer);
            }
        }
    }

    fn set(&mut self, at: usize) {
        let mut out = BusOutbox::default();
        self.managers[at].set_outputs(self.now, CLAMP, 1, &mut out);
        self.give(at, out);
    }
}

#[test]
fn the_one_that_comes_second_sends_nothing_and_yields_and_the_first_never_hears_of_it() {
    for later in [0, 1, 20, 49, 50, 333, 60_000] {
        let mut pair = ManagerPair::new();
        pair.running[0] = true;
        pair.pass(201 + later);
        pair.running[1] = true;
        pair.pass(1);
        pair.set(1);
        pair.pass(500);
        assert_eq!(pair.managers[1].yields(), Some(false), "{later}");
        assert_eq!(pair.sent[1], Vec::<String>::new(), "no reset, no start, no output");
        let mut out = BusOutbox::default();
        pair.managers[1].release_outputs(pair.now, &mut out);
        assert_eq!(out, BusOutbox::default(), "the outputs are the other's");
        assert_eq!((pair.managers[0].yields(), pair.told[0].len()), (None, 0));
        assert!(pair.running[0]);
    }
}

#[test]
fn of_two_that_begin_a_little_apart_the_first_stays() {
    for apart in 1..200 {
        let mut pair = ManagerPair::new();
        pair.running[0] = true;
        pair.pass(apart);
        pair.running[1] = true;
        pair.pass(1000);
        assert_eq!(pair.running, [true, false], "{apart} ms apart");
        assert!(pair.sent[1].is_empty());
    }
}

#[test]
fn two_that_begin_at_the_same_instant_both_yield() {
    let mut pair = ManagerPair::new();
    pair.running = [true, true];
    pair.pass(1000);
    assert_eq!(pair.managers.each_ref().map(Manager::yields), [Some(true); 2]);
    let energises = |frame: &String| ["204#01", "205#01", "206#01", "000#"].iter().any(|bad| frame.starts_with(bad));
    assert!(!pair.sent.iter().flatten().any(energises), "{:?}", pair.sent);
}

#[test]
fn while_another_is_there_every_output_is_off_and_nothing_moves_and_it_is_reported_now_and_then() {
    let mut bench = ManagerBench::up();
    bench.pass_with(1000, &[4, 5, 6]);
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear(RIVAL);
    let (frames, events) = bench.take();
    assert_eq!(frames, ["204#00", "205#00", "206#00"]);
    assert!(events.contains(&BusEvent::AnotherManager), "{events:?}");
    let mut told = 0;
    for _ in 0..400 {
        bench.hear(RIVAL);
        for node in ["704#05", "705#05", "706#05", "184#01", "185#01", "186#01", "706#00"] {
            bench.hear(node);
        }
        bench.set(CLAMP, 1);
        bench.pass(50);
        let (frames, events) = bench.take();
        assert_eq!(frames, [RIVAL], "its own heartbeat alone, by which the other one knows");
        assert!(!bench.inputs(CLAMP).valid && !bench.inputs(DRILL).valid);
        told += events.iter().filter(|event| **event == BusEvent::AnotherManager).count();
    }
    assert_eq!(told, 3, "in twenty seconds, after the first");
    let trouble: Vec<String> = bench.manager.trouble(bench.now, CLAMP).collect();
    assert_eq!(
        trouble,
        [
            "another CANopen manager (node 7Fh) has sent its heartbeat (77Fh) on this bus for 20000 ms: every output is let \
          go and nothing moves; end one of the two"
        ]
    );
    assert_eq!(bench.manager.yields(), None, "perhaps the other one has to go");
}

#[test]
fn when_the_other_is_gone_devices_are_brought_up_and_energised_only_by_what_is_set_then() {
    let mut bench = ManagerBench::up();
    bench.pass_with(1000, &[4, 5, 6]);
    bench.hear(RIVAL);
    bench.set(CLAMP, 1);
    bench.take();
    bench.pass_with(200, &[4, 5, 6]);
    let (frames, events) = bench.take();
    assert!(events.contains(&BusEvent::AloneAgain), "{events:?}");
    for frame in ["204#00", "205#00", "206#00", "604#4000100000000000", "606#4000100000000000"] {
        assert!(frames.contains(&frame.to_owned()), "{frame} {frames:?}");
    }
    bench.hear("706#7F");
    bench.configure(6);
    bench.hear("706#05");
    bench.hear("186#00");
    assert!(bench.inputs(CLAMP).valid);
    assert!(!bench.frames().contains(&"206#01".to_owned()), "it was set while the other was there");
    bench.set(CLAMP, 1);
    assert_eq!(bench.frames(), ["206#01"]);
}

#[test]
fn a_silence_that_nobody_could_have_broken_does_not_count() {
    // The program was held up: the other's frames are still to be read.
    let mut bench = ManagerBench::listening(&devices());
    bench.pass(300);
    assert!(bench.frames().is_empty());
    bench.hear(RIVAL);
    assert_eq!(bench.manager.yields(), Some(false));
    // The interface was off the bus.
    let mut bench = ManagerBench::listening(&devices());
    bench.hear("20000040#0000000000000000");
    bench.pass(200);
    assert!(bench.frames().is_empty());
    bench.hear("20000100#0000000000000000");
    bench.pass(199);
    bench.hear(RIVAL);
    assert_eq!((bench.manager.yields(), bench.frames()), (Some(false), vec![]));
}

#[test]
fn nobody_has_a_device_reset_or_asked_while_it_only_listens() {
    let mut bench = ManagerBench::listening(&devices());
    for frame in ["704#00", "705#05", "706#7F", "186#01", "586#4300100091010300", "086#0000000000000000"] {
        bench.hear(frame);
    }
    bench.manager.reset_node(bench.now, node(6), &mut bench.out);
    assert!(bench.manager.start_node(bench.now, node(6), &mut bench.out).is_err());
    let number =
        bench.manager.ask(bench.now, 6, DeviceRequest::Read(crate::sdo::ObjectId::new(0x1018, 1)), &mut bench.out);
    assert!(matches!(bench.out.answers[..], [(n, Err(DeviceRequestError::NotReady(_)))] if n == number));
    bench.pass(100);
    assert!(bench.frames().is_empty());
}
