//! A bus that others fill to nine tenths: every change of an input reaches the image, every output its device.
//!
//! The bus has 500 kbit/s and is a bus: one frame at a time, the lowest identifier first, each as long as it is with
//! every stuff bit it can have. The manager and the devices are the real ones, behind an interface that queues ten
//! frames. Each device's inputs count up one by one, and so do its outputs, so a state that never arrived shows.

use std::time::Duration;

use crate::wire::{Foreign, Wire};

/// So long each load is looked at, after the devices have booted under it.
const LONG: Duration = Duration::from_secs(60);

/// Others' identifiers, by how they stand against those of process data (181h to 27Fh).
fn loads() -> [(&'static str, Foreign); 4] {
    let above = || (0x001..0x080).step_by(3);
    let below = || (0x681..0x6E0).step_by(2);
    [
        ("higher priority", Foreign::steady(above().collect())),
        ("lower priority", Foreign::steady(below().collect())),
        ("both, in steady streams", Foreign::steady(above().chain(below()).collect())),
        ("both, in bursts", Foreign::bursts(above().chain(below()).collect())),
    ]
}

#[test]
fn nothing_is_lost_under_nine_tenths_of_foreign_traffic() {
    for (name, foreign) in loads() {
        let mut wire = Wire::new(foreign);
        wire.boot();
        wire.exchange(LONG);
        let report = wire.report();
        println!("{name}\n{report}");
        assert!(report.foreign_share > 0.895, "{name}: {report}");
        assert!(report.inputs.len() > 2000 && report.outputs.len() > 2000, "{name}: {report}");
        assert_eq!(report.lost_devices, 0, "{name}");
        // Far less than the 50 ms and 100 ms after which outputs and inputs are repeated anyway.
        for latencies in [&report.inputs, &report.outputs] {
            assert!(latencies.within(0.99) < Duration::from_millis(15), "{name}: {report}");
            assert!(latencies.worst() < Duration::from_millis(40), "{name}: {report}");
        }
    }
}

/// The instrument itself: without others it measures next to nothing, and it notices a state that is skipped.
#[test]
fn a_bus_without_others_is_quick() {
    let mut wire = Wire::new(Foreign::none());
    wire.boot();
    wire.exchange(Duration::from_secs(5));
    let report = wire.report();
    println!("no others\n{report}");
    assert!(report.inputs.worst() < Duration::from_millis(3), "{report}");
}

#[test]
#[should_panic(expected = "a state of the ")]
fn a_frame_that_is_swallowed_is_noticed() {
    let mut wire = Wire::new(Foreign::none());
    wire.boot();
    wire.swallow_one_in(10);
    wire.exchange(Duration::from_secs(20));
}
