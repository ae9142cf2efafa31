//! Any frames from the bus: no output of a device changes by them, nothing grows, nothing panics.

use std::cell::Cell;

use linewright_testkit::device_frames::DeviceBench;
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

#[test]
fn any_frames_change_no_output() {
    let steps = prop_oneof![
        // Started, and given outputs.
        1 => any::<[u8; 2]>().prop_map(|data| [&[0x00, 0x10, 0x02, 0x23][..], &data].concat()),
        2 => prop::collection::vec(any::<u8>(), 1..16),
    ];
    let script = prop::collection::vec(steps, 1..40).prop_map(|steps| steps.concat());
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let config = ProptestConfig { cases: 10_000, failure_persistence: None, ..ProptestConfig::default() };
    let energised = Cell::new(0);
    let result = TestRunner::new_with_rng(config, rng).run(&script, |script| {
        let mut bench = DeviceBench::set_up();
        bench.play(&script);
        energised.set(energised.get() + bench.energised);
        Ok(())
    });
    println!("outputs were on in {} moments", energised.get());
    result.unwrap();
    assert!(energised.get() > 100_000, "it came to process data");
}
