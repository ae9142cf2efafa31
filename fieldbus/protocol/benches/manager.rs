//! Cost of the manager itself, without any bus: frames in and out of it, with few devices and with all a bus has.
//!
//! `frame_to_image`: a device's inputs have changed; until its owner's image shows it. `image_to_frame`: an owner sets
//! an output; until the frame is there. `traffic`: a tenth of a second of a busy line, by frames received and sent.
//! `foreign`: a frame for no device. `cargo bench -p linewright-fieldbus --bench manager`.

use std::hint::black_box;
use std::time::Duration;

use divan::Bencher;
use divan::counter::ItemsCount;
use linewright_testkit::crowd::{self, Crowd, inputs, owner};

#[global_allocator]
static ALLOCATOR: divan::AllocProfiler = divan::AllocProfiler::system();

/// Frames between two looks at the clock.
const FRAMES: u64 = 1000;
const CROWDS: [u8; 3] = [4, 32, 126];

fn main() {
    divan::main();
}

#[divan::bench(args = CROWDS)]
fn frame_to_image(bencher: Bencher, count: u8) {
    let mut crowd = Crowd::up(count);
    let changes = [inputs(count, 0), inputs(count, 1)];
    let owner = owner(count);
    bencher.counter(ItemsCount::new(FRAMES)).bench_local(|| {
        for nth in 0..FRAMES {
            crowd.hear(black_box(&changes[nth as usize % 2]));
            assert!(crowd.manager.inputs(crowd.now, owner).valid);
            crowd.forget();
        }
    });
}

#[divan::bench(args = CROWDS)]
fn image_to_frame(bencher: Bencher, count: u8) {
    let mut crowd = Crowd::up(count);
    let bit = 1u128 << crowd::shift(count);
    bencher.counter(ItemsCount::new(FRAMES)).bench_local(|| {
        for nth in 0..FRAMES {
            // The next frame is due when the last one is through: the manager sends no faster than that.
            crowd.now = crowd.now + Duration::from_micros(250);
            let image = if nth % 2 == 0 { bit } else { 0 };
            crowd.manager.set_outputs(crowd.now, owner(count), black_box(image), &mut crowd.out);
            assert!(!crowd.out.frames.is_empty());
            crowd.forget();
        }
    });
}

#[divan::bench(args = CROWDS)]
fn traffic(bencher: Bencher, count: u8) {
    let mut crowd = Crowd::up(count);
    let frames = crowd.tenth(count, 0);
    let mut round = 0;
    bencher.counter(ItemsCount::new(frames)).bench_local(|| {
        round += 1;
        crowd.tenth(count, round)
    });
}

#[divan::bench(args = CROWDS)]
fn foreign(bencher: Bencher, count: u8) {
    let mut crowd = Crowd::up(count);
    let frame = "123#1122334455667788".parse().expect("a frame");
    bencher.counter(ItemsCount::new(FRAMES)).bench_local(|| {
        for _ in 0..FRAMES {
            crowd.hear(black_box(&frame));
            crowd.forget();
        }
    });
}
