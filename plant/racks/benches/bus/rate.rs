//! Cost of a frame for a manager of 126 devices: all of them send inputs, changed, and heartbeats, as fast as they are
//! received. Processor time of the listening thread, of which a core has a second each second.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use linewright_canopen::Manager;
use linewright_fieldbus::{Bus, Clock, Driver};
use linewright_line::Timing;

use linewright_testkit::crowd;

use super::{Place, block_on};

const DEVICES: u8 = 126;
const REPEATS: usize = 5;
const LONG: Duration = Duration::from_secs(1);
/// Frames under way at most.
const WINDOW: u64 = 200;

#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    heard: AtomicU64,
}

/// The devices' frames. Boots are answered first, until there has been no request for a while.
fn devices(place: &Place, shared: &Shared) {
    block_on(async {
        let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
        let mut sent = shared.heard.load(Ordering::Relaxed);
        let mut quiet = Instant::now();
        let mut beat = Instant::now();
        while quiet.elapsed() < Duration::from_millis(600) {
            if let Ok(Ok(frame)) = tokio::time::timeout(Duration::from_millis(5), bus.recv()).await
                && let Some(answer) = crowd::answer(&frame)
            {
                quiet = Instant::now();
                bus.send(&answer);
            }
            if beat.elapsed() > Duration::from_millis(100) {
                beat = Instant::now();
                (1..=DEVICES).for_each(|id| _ = bus.send(&crowd::heartbeat(id)));
            }
        }
        sent = sent.max(shared.heard.load(Ordering::Relaxed));
        let mut id = 0;
        let mut last = Instant::now();
        while !shared.stop.load(Ordering::Relaxed) {
            // Lost frames are not waited for.
            if sent >= shared.heard.load(Ordering::Relaxed) + WINDOW && last.elapsed() < Duration::from_millis(50) {
                thread::yield_now();
                continue;
            }
            last = Instant::now();
            sent = sent.min(shared.heard.load(Ordering::Relaxed) + WINDOW);
            for _ in 0..16 {
                id = id % DEVICES + 1;
                // Two of three frames are heartbeats, as on a quiet bus.
                let frame = if sent.is_multiple_of(3) { crowd::inputs(id, sent / 126) } else { crowd::heartbeat(id) };
                bus.send(&frame);
                sent += 1;
            }
        }
    });
}

pub fn run(place: &Place) {
    for managed in [false, true] {
        let shared = Arc::new(Shared::default());
        let devices = thread::spawn({
            let (place, shared) = (place.clone(), shared.clone());
            move || devices(&place, &shared)
        });
        let costs =
            block_on(async { if managed { manager(place, &shared).await } else { listener(place, &shared).await } });
        shared.stop.store(true, Ordering::Relaxed);
        devices.join().expect("the devices end");
        let who = if managed { "manager of 126 devices" } else { "bare listener" };
        let mut nanos: Vec<f64> = costs.iter().map(|(nanos, _)| *nanos).collect();
        nanos.sort_by(f64::total_cmp);
        let frames = costs.iter().map(|(_, frames)| frames).sum::<u64>() / costs.len() as u64;
        println!(
            "  {who}: median {:.0} ns, best {:.0} ns of a core for a frame, {:.0} frames a second at one core; {frames} \
             came in each of {} seconds",
            nanos[nanos.len() / 2],
            nanos[0],
            1e9 / nanos[nanos.len() / 2],
            costs.len()
        );
    }
}

async fn listener(place: &Place, shared: &Shared) -> Vec<(f64, u64)> {
    let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let mut meter = Meter::new();
    while meter.costs.len() < REPEATS {
        _ = tokio::time::timeout(Duration::from_millis(5), async {
            for _ in 0..50 {
                bus.recv().await.expect("the bus is there");
            }
        })
        .await;
        meter.look(bus.stats().received, shared);
    }
    meter.costs
}

async fn manager(place: &Place, shared: &Shared) -> Vec<(f64, u64)> {
    let timing = Timing { heartbeat_timeout: Duration::from_secs(5), ..Timing::default() };
    let manager = Manager::new(&crowd::devices(DEVICES), timing).expect("their ids are right");
    let bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let mut driver = Driver::new(bus, manager, Clock::start());
    let mut meter = Meter::new();
    while meter.costs.len() < REPEATS {
        _ = tokio::time::timeout(Duration::from_millis(5), async {
            for _ in 0..50 {
                driver.next().await.expect("nobody else is there");
            }
        })
        .await;
        let up = driver.manager().devices().filter(|(_, _, operational)| *operational).count();
        if up == usize::from(DEVICES) {
            meter.look(driver.bus().stats().received, shared);
        } else {
            meter = Meter::new();
            shared.heard.store(driver.bus().stats().received, Ordering::Relaxed);
        }
    }
    meter.costs
}

/// Frames, and what they cost this thread.
struct Meter {
    began: Instant,
    start: Option<(Duration, u64)>,
    costs: Vec<(f64, u64)>,
}

impl Meter {
    fn new() -> Self {
        Meter { began: Instant::now(), start: None, costs: Vec::new() }
    }

    fn look(&mut self, received: u64, shared: &Shared) {
        shared.heard.store(received, Ordering::Relaxed);
        let Some((cpu, before)) = self.start else {
            // The devices send at full rate only after they have been quiet.
            if self.began.elapsed() > Duration::from_millis(1500) {
                (self.began, self.start) = (Instant::now(), Some((processor_time(), received)));
            }
            return;
        };
        if self.began.elapsed() >= LONG && received > before {
            let frames = received - before;
            let spent = processor_time().saturating_sub(cpu);
            self.costs.push((spent.as_nanos() as f64 / frames as f64, frames));
            (self.began, self.start) = (Instant::now(), Some((processor_time(), received)));
        }
    }
}

/// Processor time of this thread so far.
fn processor_time() -> Duration {
    // Nanoseconds, where the kernel keeps them; else ticks of ten milliseconds.
    let exact = fs::read_to_string("/proc/thread-self/schedstat").ok();
    if let Some(nanos) = exact.and_then(|text| text.split(' ').next()?.parse().ok()).filter(|nanos| *nanos > 0) {
        return Duration::from_nanos(nanos);
    }
    let text = fs::read_to_string("/proc/thread-self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: u64 = fields.skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    Duration::from_millis(ticks * 10)
}
