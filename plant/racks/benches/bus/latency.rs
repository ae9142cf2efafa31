//! From an image to the frame at the device, and back: a device on another thread returns its outputs as inputs, and
//! notes when they came.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use linewright_canopen::{BusEvent, CanopenMessage, Frame, Manager};
use linewright_fieldbus::{Bus, Clock, Driver};
use linewright_line::Timing;

use linewright_testkit::crowd;

use super::{Place, block_on, of};

const ROUNDS: u16 = 500;
/// A line is mostly idle, and so are all threads here between two frames.
const PAUSE: Duration = Duration::from_millis(3);

struct Shared {
    stop: AtomicBool,
    began: Instant,
    /// When the device last took outputs, in nanoseconds.
    taken: AtomicU64,
}

/// The device, and a bare frame's echo.
fn device(place: &Place, shared: &Shared) {
    block_on(async {
        let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
        let mut last = u64::MAX;
        let mut beat = tokio::time::interval(Duration::from_millis(50));
        while !shared.stop.load(Ordering::Relaxed) {
            let frame = tokio::select! {
                frame = bus.recv() => frame.expect("the bus is there"),
                _ = beat.tick() => {
                    bus.send(&crowd::heartbeat(1));
                    continue;
                }
            };
            let taken = shared.began.elapsed().as_nanos() as u64;
            let answer = match CanopenMessage::decode(&frame) {
                // The bare frame.
                _ if frame.cob_id() == Some(0x010) => Frame::data_frame(0x011, frame.data()),
                Ok(CanopenMessage::Rpdo1 { payload, .. }) if payload.bits() != last => {
                    last = payload.bits();
                    Some(crowd::inputs(1, last))
                }
                _ => crowd::answer(&frame),
            };
            if let Some(answer) = answer {
                shared.taken.store(taken, Ordering::SeqCst);
                bus.send(&answer);
            }
        }
    });
}

pub fn run(place: &Place) {
    let shared = Arc::new(Shared { stop: AtomicBool::new(false), began: Instant::now(), taken: AtomicU64::new(0) });
    let device = thread::spawn({
        let (place, shared) = (place.clone(), shared.clone());
        move || device(&place, &shared)
    });
    thread::sleep(Duration::from_millis(100));
    block_on(bare(place, &shared));
    block_on(managed(place, &shared));
    shared.stop.store(true, Ordering::Relaxed);
    device.join().expect("the device ends");
}

/// A frame there and back with nothing behind it.
async fn bare(place: &Place, shared: &Shared) {
    let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let mut ways = [Vec::new(), Vec::new()];
    for number in 0..ROUNDS {
        let sent = shared.began.elapsed();
        bus.send(&Frame::data_frame(0x010, &number.to_le_bytes()).expect("a frame"));
        while bus.recv().await.expect("the bus is there").cob_id() != Some(0x011) {}
        note(&mut ways, shared, sent);
        thread::sleep(PAUSE);
    }
    let [there, back] = &mut ways;
    println!("  bare frame, there: {}\n  bare frame, back:  {}", of(there), of(back));
}

async fn managed(place: &Place, shared: &Shared) {
    let manager = Manager::new(&crowd::devices(1), Timing::default()).expect("its id is right");
    let bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let mut driver = Driver::new(bus, manager, Clock::start());
    while !driver
        .next()
        .await
        .expect("nobody else is there")
        .iter()
        .any(|event| matches!(event, BusEvent::DeviceUp { .. }))
    {}
    let owner = crowd::owner(1);
    let mut ways = [Vec::new(), Vec::new()];
    for number in 1..=ROUNDS {
        // The manager's own rest, in which it does what is due.
        let pause = tokio::time::sleep(PAUSE);
        tokio::pin!(pause);
        loop {
            tokio::select! {
                () = &mut pause => break,
                _ = driver.next() => {}
            }
        }
        let set = shared.began.elapsed();
        driver.set_outputs(owner, number.into());
        while driver.inputs(owner).bits != number.into() {
            driver.next().await.expect("nobody else is there");
        }
        note(&mut ways, shared, set);
    }
    let [there, back] = &mut ways;
    println!("  image to frame:    {}\n  frame to image:    {}", of(there), of(back));
}

fn note(ways: &mut [Vec<Duration>; 2], shared: &Shared, sent: Duration) {
    let (taken, back) = (Duration::from_nanos(shared.taken.load(Ordering::SeqCst)), shared.began.elapsed());
    ways[0].push(taken.saturating_sub(sent));
    ways[1].push(back.saturating_sub(taken));
}
