//! Cost of a step: the transfer bar, ten reversible operations, in auto.
//!
//! `quiet` is a step in which nothing fires, which is nearly every step; `firing` is one in which an operation
//! completes and the next one starts. Each without and with taking the input image first. For scale: dispatching one
//! event in 4diac FORTE takes about 18 ns on such a machine; the aim is a third of that for a quiet step.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use linewright_station_logic::{Controller, StationInput, StationOutbox};

#[path = "../tests/transfer_bar/mod.rs"]
mod transfer_bar;
use transfer_bar::{NOW, TransferBar};

#[global_allocator]
static ALLOCATOR: divan::AllocProfiler = divan::AllocProfiler::system();

/// Steps between two looks at the clock: one alone is shorter than looking.
const STEPS: usize = 1000;

fn main() {
    divan::main();
}

#[divan::bench]
fn quiet(bencher: Bencher) {
    let mut bar = TransferBar::lifting();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for _ in 0..STEPS {
            bar.step();
        }
    });
}

#[divan::bench]
fn quiet_with_the_same_image(bencher: Bencher) {
    let mut bar = TransferBar::lifting();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for _ in 0..STEPS {
            bar.image(black_box(0));
            bar.step();
        }
    });
}

#[divan::bench]
fn quiet_with_another_switch_changing(bencher: Bencher) {
    let mut bar = TransferBar::lifting();
    let switch = bar.unused_input();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for n in 0..STEPS {
            bar.image(if n % 2 == 0 { switch } else { 0 });
            bar.step();
        }
    });
}

/// A round of ten operations: ten steps in which two transitions fire, ten in which the switch goes off again.
#[divan::bench]
fn firing_with_its_images_round_of_ten(bencher: Bencher) {
    let mut bar = TransferBar::lifting();
    bencher.counter(ItemsCount::new(10usize)).bench_local(|| bar.round());
}

/// The step alone: a controller that has just received that its motion arrived.
#[divan::bench(sample_size = 256)]
fn firing(bencher: Bencher) {
    let bar = TransferBar::lifting();
    let arrived = bar.completion();
    bencher
        .with_inputs(|| {
            let mut controller: Controller = bar.controller.clone();
            controller.handle(
                NOW,
                StationInput::Inputs {
                    bits: arrived,
                    valid: true,
                    until: linewright_line::Tick::NEVER,
                    under: linewright_station_logic::NO_DELAY,
                },
            );
            (controller, StationOutbox { events: Vec::with_capacity(16), ..StationOutbox::default() })
        })
        .bench_local_refs(|(controller, out)| controller.step(NOW, out));
}
