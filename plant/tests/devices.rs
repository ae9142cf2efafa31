//! A rack of devices as the bus sees it. Frames are written as candump prints them.

use std::time::Duration;

use crate::common::*;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{DeviceBus, Tick};
use linewright_plant::{PlantOptions, Rack};
use proptest::prelude::*;

struct Bench {
    rack: Rack,
    now: Tick,
    out: Vec<Frame>,
}

impl Bench {
    fn new() -> Self {
        let now = Tick::from_millis(1000);
        let rack = Rack::new(now, &line(), &DeviceBus::Own("press2".to_owned()), PlantOptions::default());
        Bench { rack, now, out: Vec::new() }
    }

    /// Booted and started.
    fn up() -> Self {
        let mut bench = Bench::new();
        bench.pass(20);
        bench.hear("000#0104");
        bench.take();
        bench
    }

    fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(due) = self.rack.next_deadline().filter(|due| *due <= until) {
            self.now = due;
            self.rack.poll(due, &mut self.out);
        }
        self.now = until;
    }

    fn hear(&mut self, text: &str) {
        self.rack.handle(self.now, &text.parse().unwrap(), &mut self.out);
    }

    fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.out).iter().map(Frame::to_string).collect()
    }

    fn ask(&mut self, text: &str) -> String {
        self.take();
        self.hear(text);
        self.take().iter().find(|f| f.starts_with("584")).cloned().unwrap_or_default()
    }

    fn outputs(&self) -> u64 {
        self.rack.device(NodeId::new(4).unwrap()).unwrap().outputs()
    }
}

#[test]
fn it_boots_beats_and_reports_its_inputs_once_started() {
    let mut bench = Bench::new();
    bench.pass(19);
    assert!(bench.take().is_empty());
    bench.pass(51);
    assert_eq!(bench.take(), ["704#00", "704#7F"]);
    bench.hear("000#0105");
    assert!(bench.take().is_empty(), "that was for somebody else");
    bench.hear("000#0104");
    assert_eq!(bench.take(), ["184#02"]);
    bench.pass(100);
    assert_eq!(bench.take(), ["704#05", "704#05", "184#02"]);
}

#[test]
fn an_output_drives_and_the_limit_switch_answers() {
    let mut bench = Bench::up();
    bench.hear("204#01");
    bench.pass(200);
    let inputs: Vec<String> = bench.take().into_iter().filter(|f| f.starts_with("184")).collect();
    assert_eq!(inputs.first().unwrap(), "184#00");
    assert_eq!(inputs.last().unwrap(), "184#01");
}

#[test]
fn outputs_are_taken_in_the_operational_state_only_and_go_off_with_it() {
    for order in ["000#0204", "000#8004", "000#8104", "000#8200"] {
        let mut bench = Bench::new();
        bench.pass(20);
        bench.hear("204#01");
        assert_eq!(bench.outputs(), 0);
        bench.hear("000#0104");
        bench.hear("204#01");
        assert_eq!(bench.outputs(), 1);
        bench.hear(order);
        assert_eq!(bench.outputs(), 0, "{order}");
        bench.pass(50);
        bench.hear("000#0104");
        assert_eq!(bench.outputs(), 0, "{order}: starting again restores nothing");
    }
}

#[test]
fn a_device_that_loses_its_manager_lets_go_and_says_so() {
    let mut bench = Bench::up();
    bench.hear("77F#05");
    bench.hear("204#01");
    bench.pass(199);
    assert_eq!(bench.outputs(), 1);
    bench.take();
    bench.pass(1);
    assert_eq!(bench.outputs(), 0);
    assert!(bench.take().contains(&"084#3081110000000000".to_owned()));
    bench.pass(50);
    assert_eq!(bench.take(), ["704#7F"]);
    bench.hear("77F#05");
    assert_eq!(bench.take(), ["084#0000000000000000"]);
}

#[test]
fn a_manager_that_booted_is_a_manager_lost() {
    let mut bench = Bench::up();
    bench.hear("77F#05");
    bench.hear("204#01");
    bench.hear("77F#00");
    assert_eq!(bench.outputs(), 0);
}

#[test]
fn a_watch_that_was_configured_runs_from_then() {
    let mut bench = Bench::up();
    assert_eq!(bench.ask("604#2316100164007F00"), "584#6016100100000000");
    bench.hear("204#01");
    bench.pass(100);
    assert_eq!(bench.outputs(), 0, "100 ms without a heartbeat");
}

#[test]
fn its_objects_can_be_read_and_the_unknown_are_refused() {
    let mut bench = Bench::up();
    bench.hear("204#03");
    let cases = [
        ("604#4000100000000000", "584#4300100091010300"),
        ("604#4017100000000000", "584#4B17100032000000"),
        ("604#4000600000000000", "584#4F00600001000000"),
        ("604#4000600100000000", "584#4F00600102000000"),
        ("604#4000620100000000", "584#4F00620103000000"),
        ("604#2F00620100000000", "584#8000620102000106"),
        ("604#4000600200000000", "584#8000600211000906"),
        ("604#4034120000000000", "584#8034120000000206"),
        ("604#2F00120000000000", "584#8000120000000206"),
        ("604#2F17100032000000", "584#8017100010000706"),
        ("604#40005F0100000000", "584#80005F0101000106"),
        ("604#2F005F0109000000", "584#80005F0130000906"),
        ("604#2F005F0301000000", "584#80005F0311000906"),
    ];
    for (request, answer) in cases {
        assert_eq!(bench.ask(request), answer, "{request}");
    }
}

#[test]
fn faults_and_fingers_come_over_the_bus() {
    let mut bench = Bench::up();
    // The motion of output 0 breaks: its fault input comes on.
    assert_eq!(bench.ask("604#2F005F0103000000"), "584#60005F0100000000");
    bench.hear("204#01");
    bench.pass(100);
    assert!(bench.take().contains(&"184#06".to_owned()));
    // A finger on input 3, taken off again.
    bench.hear("604#2F015F0401000000");
    assert!(bench.take().contains(&"184#0E".to_owned()));
    bench.hear("604#2F015F0402000000");
    assert!(bench.take().contains(&"184#06".to_owned()));
    // Everything cleared: it moves.
    bench.hear("604#2F005F0000000000");
    bench.pass(200);
    assert!(bench.take().contains(&"184#01".to_owned()));
}

#[test]
fn a_silent_device_is_silent_until_it_is_plugged_in_again() {
    let mut bench = Bench::up();
    bench.hear("77F#05");
    bench.hear("204#01");
    assert_eq!(bench.ask("604#2F005F0001000000"), "584#60005F0000000000");
    bench.pass(100);
    bench.hear("77F#05");
    bench.hear("604#4000100000000000");
    assert!(bench.take().is_empty());
    bench.pass(100);
    assert_eq!(bench.outputs(), 0, "it does not hear its manager");
    assert_eq!(bench.ask("604#2F005F0000000000"), "584#60005F0000000000");
    bench.pass(50);
    assert!(bench.take().contains(&"704#7F".to_owned()));
}

#[test]
fn a_reboot_is_a_gap_with_outputs_off() {
    let mut bench = Bench::up();
    bench.hear("204#01");
    bench.hear("604#2F005F0002000000");
    assert_eq!(bench.outputs(), 0);
    bench.take();
    bench.hear("204#01");
    bench.pass(20);
    assert_eq!(bench.take(), ["704#00"]);
    assert_eq!(bench.outputs(), 0);
}

proptest! {
    // No file of failing cases: a case worth keeping becomes a test with a name.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever comes over the bus: no panic, outputs only in the operational state, and none for longer than the
    /// timeout after the manager was last heard. (One that was never heard is not watched, as the standard has it.)
    #[test]
    fn whatever_comes_outputs_are_on_only_when_operational(
        frames in prop::collection::vec((0u16..0x800, prop::collection::vec(any::<u8>(), 0..=8), 0u64..60), 1..100),
        known in prop::collection::vec(prop::sample::select(vec![
            "000#0104", "204#01", "204#03", "77F#05", "000#0204", "604#2F005F0001000000", "604#2F005F0000000000",
        ]), 100),
    ) {
        let mut bench = Bench::up();
        let mut silent = false;
        for ((id, data, millis), known) in frames.into_iter().zip(known) {
            bench.pass(millis);
            bench.rack.handle(bench.now, &Frame::data_frame(id, &data).unwrap(), &mut bench.out);
            bench.hear(known);
            match known {
                "604#2F005F0001000000" => silent = true,
                "604#2F005F0000000000" => silent = false,
                "77F#05" if !silent && millis % 4 == 0 => {
                    bench.pass(200);
                    prop_assert_eq!(bench.outputs(), 0);
                }
                _ => {}
            }
            let device = bench.rack.device(NodeId::new(4).unwrap()).unwrap();
            let operational = device.state() == linewright_canopen::codec::NmtState::Operational;
            prop_assert!(operational || device.outputs() == 0);
        }
    }
}
