//! Steady process data allocate nothing: frames in, images, frames out, heartbeats and refreshes.

use linewright_canopen::{Frame, IgnoreReason};
use linewright_testkit::crowd::Crowd;

#[test]
fn a_second_of_126_devices_after_the_first_allocates_nothing() {
    let mut crowd = Crowd::up(126);
    for round in 0..10 {
        crowd.tenth(126, round);
    }
    let mut frames = 0;
    let counted = allocation_counter::measure(|| {
        for round in 10..20 {
            frames += crowd.tenth(126, round);
        }
    });
    assert!(frames > 3_000, "{frames}");
    assert_eq!(counted.count_total, 0, "in {frames} frames");
    assert!(crowd.manager.devices().all(|(_, _, operational)| operational));
}

#[test]
fn frames_of_others_allocate_nothing_and_leave_nothing_behind() {
    let mut crowd = Crowd::up(4);
    let foreign: Vec<Frame> = [
        "123#1122334455667788",
        "18A#00",
        "70A#05",
        "70A#00",
        "08A#1023010000000000",
        "5FF#01",
        "7E5#00",
        "00000123#01",
        "181#R",
        "60A#4000100000000000",
        "58A#4300100091010300",
        "701#0505",
        "204#0000",
    ]
    .map(|text| text.parse().unwrap())
    .into();
    foreign.iter().for_each(|frame| crowd.hear(frame));
    crowd.forget();
    let counted = allocation_counter::measure(|| {
        for _ in 0..10_000 {
            for frame in &foreign {
                crowd.hear(frame);
                assert!(crowd.out.events.len() <= 1 && crowd.out.frames.is_empty(), "{:?}", crowd.out);
                crowd.forget();
            }
        }
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(crowd.manager.ignored(IgnoreReason::Extended), 10_001);
}
