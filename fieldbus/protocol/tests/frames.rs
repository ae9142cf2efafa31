//! Any frames from the bus: no output changes by them, nothing grows, nothing panics.

use std::cell::Cell;
use std::time::Duration;

use linewright_canopen::Frame;
use proptest::prelude::*;

use linewright_testkit::manager_frames::ManagerFramesBench;

/// A script in which devices are brought up and looked after now and then, so that it comes to process data.
fn script() -> impl Strategy<Value = Vec<u8>> {
    let lives = prop_oneof![Just(vec![0x72u8]), Just(vec![0xF0]), Just(vec![0x22])];
    // The drive is homed, and sent somewhere.
    let drives = (1u8..3).prop_map(|target| vec![0xF2, 0xF2, 0x29, 4, 0xF2, 0x29, target, 0x22]);
    let sets = (0u8..16, any::<u8>()).prop_map(|(arg, image)| vec![arg << 4 | 9, image]);
    let any = prop::collection::vec(any::<u8>(), 1..12);
    let steps = prop::collection::vec(prop_oneof![3 => lives, 3 => sets, 1 => drives, 4 => any], 1..40);
    steps.prop_map(|steps| steps.concat())
}

#[test]
fn any_frames_change_no_output() {
    // Seeded: what is found is found again.
    let rng = proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha);
    let config = ProptestConfig { cases: 6_000, failure_persistence: None, ..ProptestConfig::default() };
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(config, rng);
    let [energised, driven, outputs] = [const { Cell::new(0) }; 3];
    let result = runner.run(&script(), |script| {
        let mut bench = ManagerFramesBench::set_up();
        bench.play(&script);
        energised.set(energised.get() + bench.energised);
        driven.set(driven.get() + bench.driven);
        outputs.set(outputs.get() + bench.outputs);
        Ok(())
    });
    println!("{} frames of outputs, {} on, {} that drive", outputs.get(), energised.get(), driven.get());
    result.unwrap();
    assert!(energised.get() > 100_000 && driven.get() > 5_000, "it came to process data");
}

/// Every kind of frame there is, again and again, from every device and from none, without any intervention.
#[test]
fn floods_leave_nothing_behind() {
    let mut bench = ManagerFramesBench::set_up();
    bench.play(&[0x72, 0x09, 0xFF, 0x19, 0xFF]);
    let mut number = 0u64;
    let mut flood = |bench: &mut ManagerFramesBench, frames: usize| {
        for _ in 0..frames {
            number += 1;
            let random = number.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let mut bytes = [0; 16];
            bytes[8..].copy_from_slice(&random.to_le_bytes());
            // Mostly identifiers of the devices, and of all kinds.
            let group = [0x080, 0x180, 0x580, 0x700, 0x600, 0x000][(random >> 40) as usize % 6];
            let id = if random >> 60 < 12 { group + 4 + (random >> 50 & 3) as u32 } else { (random >> 20) as u32 };
            bytes[..4].copy_from_slice(&id.to_ne_bytes());
            bytes[4] = (random >> 33) as u8 % 9;
            if let Ok(frame) = Frame::from_bytes(&bytes) {
                bench.hear_frame(&frame);
            }
            bench.pass(Duration::from_micros(130));
        }
    };
    flood(&mut bench, 50_000);
    let counted = allocation_counter::measure(|| flood(&mut bench, 200_000));
    println!("{counted:?}");
    assert!(counted.bytes_current < 16 * 1024, "{} bytes more than before", counted.bytes_current);
    assert!(counted.bytes_max < 256 * 1024, "{} bytes at once", counted.bytes_max);
}
