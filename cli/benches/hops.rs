//! From a switch at one station to an actuator at another, in frames on the bus; and what the processes cost.
//!
//! A whole line runs as it would in production — plant, coordinator and every station a process of its own — and this
//! program only listens to the CAN frames. For each causal arrow it takes the time from the frame in which the
//! completing switch comes on to the frame that energises the actuator of the operation that waited for it. With
//! devices on buses of the stations' own there is one DDS hop in between, behind the coordinator's gateway there are
//! three. Beside it, in the same run, goes a bare one-way ping over the same client library. A ratio to that ping is a
//! result; a number of microseconds on a shared machine is not.
//!
//! `cargo bench -p linewright --bench hops [-- SECONDS]`; 20 seconds of auto per arrangement by default.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use linewright_canopen::CanopenMessage;
use linewright_fieldbus::{Bus as CanBus, BusOptions};
use linewright_line::{DeviceBus, InputId, Line, OutputId, Owner, StationId};

#[path = "common/running.rs"]
mod running;

use running::{LINE_BUS, Running, print_samples};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Fast, so that many arrows are followed in little time; the controllers are unaffected.
const TIME_SCALE: f64 = 0.1;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let seconds = words.first().map_or(Ok(20.0), |word| word.parse())?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    ping("before")?;
    for own in [true, false] {
        runtime.block_on(arrangement(own, Duration::from_secs_f64(seconds)))?;
        ping("after")?;
    }
    Ok(())
}

/// The peer: a message there and back between two processes, over the client library alone.
///
/// Once as fast as it goes, and once at the rhythm of a line, in which every thread it wakes has been asleep: that is
/// the reference for a hop.
fn ping(when: &str) -> Result<()> {
    ping_every(when, "1000", "1000")?;
    ping_every(when, "150", "50000")
}

fn ping_every(when: &str, count: &str, period_us: &str) -> Result<()> {
    let mut cargo = Command::new(option_env!("CARGO").unwrap_or("cargo"));
    cargo.args(["run", "--release", "--quiet", "--package", "linewright-node-shell", "--example", "oneway", "--"]);
    let output = cargo.args([count, period_us, "reliable", "bare"]).env("ROS_DOMAIN_ID", "91").output()?;
    println!("bare ping every {period_us} µs, {when}:\n{}", String::from_utf8_lossy(&output.stdout));
    Ok(())
}

async fn arrangement(own: bool, long: Duration) -> Result<()> {
    let name = if own { "devices on the stations' own buses (one hop)" } else { "behind the gateway (three hops)" };
    println!("== {name}");
    let running = Running::start("hops", own, TIME_SCALE, |_| Vec::new())?;
    let mut listener = Listener::open(&running.line, &running.buses_dir)?;
    running.mode_until("start", "stand-by")?;
    // Standing still, with every lease and image refreshed.
    let before = usage(&running)?;
    tokio::time::sleep(Duration::from_secs(5)).await;
    print_usage("idle", &before, &usage(&running)?, Duration::from_secs(5));
    running.mode_until("auto", "auto")?;
    let before = usage(&running)?;
    let begun = Instant::now();
    listener.listen(long).await;
    print_usage("cycling", &before, &usage(&running)?, begun.elapsed());
    listener.print();
    Ok(())
}

/// For each process: clock ticks of processor time, and resident memory in KiB.
fn usage(running: &Running) -> Result<Vec<(String, u64, u64)>> {
    running
        .children
        .iter()
        .map(|(name, child)| {
            let stat = fs::read_to_string(format!("/proc/{}/stat", child.id()))?;
            // Fields after the command's name, which may contain anything.
            let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
            let number = |at: usize| fields.get(at).and_then(|field| field.parse::<u64>().ok()).unwrap_or(0);
            Ok((name.clone(), number(11) + number(12), number(21) * 4))
        })
        .collect()
}

fn print_usage(what: &str, before: &[(String, u64, u64)], after: &[(String, u64, u64)], long: Duration) {
    // The kernel counts processor time in hundredths of a second.
    for ((name, ticks, _), (_, later, memory)) in before.iter().zip(after) {
        let percent = (later - ticks) as f64 / long.as_secs_f64();
        println!("{what:8} {name:12} {percent:5.1} % of a core, {:5.1} MiB", *memory as f64 / 1024.0);
    }
}

/// One arrow: the switch that ends its first operation, the actuator of its second.
struct Arrow {
    name: String,
    switch: (StationId, InputId),
    actuator: (StationId, OutputId),
    risen: Option<Instant>,
    samples: Vec<Duration>,
}

struct Listener {
    line: Line,
    buses: Vec<(DeviceBus, CanBus)>,
    arrows: Vec<Arrow>,
    inputs: HashMap<StationId, u128>,
    outputs: HashMap<StationId, u128>,
}

impl Listener {
    fn open(line: &Line, dir: &Path) -> Result<Self> {
        let mut buses: Vec<(DeviceBus, CanBus)> = Vec::new();
        for device in &line.devices {
            if buses.iter().all(|(bus, _)| *bus != device.bus) {
                let interface = match &device.bus {
                    DeviceBus::Line => LINE_BUS,
                    DeviceBus::Own(interface) => interface,
                };
                let options = BusOptions { dir: Some(dir.to_owned()), ..BusOptions::default() };
                buses.push((device.bus.clone(), CanBus::open(interface, &options)?));
            }
        }
        let arrows = line.arrows.iter().map(|arrow| Arrow {
            name: format!("{} -> {}", line.operation(arrow.from).name, line.operation(arrow.to).name),
            switch: (arrow.from.0, line.operation(arrow.from).normal.complete),
            actuator: (arrow.to.0, line.operation(arrow.to).normal.actuator),
            risen: None,
            samples: Vec::new(),
        });
        Ok(Listener {
            arrows: arrows.collect(),
            line: line.clone(),
            buses,
            inputs: HashMap::new(),
            outputs: HashMap::new(),
        })
    }

    async fn listen(&mut self, long: Duration) {
        let until = tokio::time::Instant::now() + long;
        loop {
            let receivers =
                self.buses.iter_mut().map(|(bus, can)| Box::pin(async move { (bus.clone(), can.recv().await) }));
            let next = futures::future::select_all(receivers);
            let Ok(((bus, Ok(frame)), _, _)) = tokio::time::timeout_at(until, next).await else { return };
            let at = Instant::now();
            match CanopenMessage::decode(&frame) {
                Ok(CanopenMessage::Tpdo1 { node, payload }) => self.switches(&bus, node.get(), payload.bits(), at),
                Ok(CanopenMessage::Rpdo1 { node, payload }) => self.actuators(&bus, node.get(), payload.bits(), at),
                _ => {}
            }
        }
    }

    fn switches(&mut self, bus: &DeviceBus, node: u8, bits: u64, at: Instant) {
        let Some((station, image)) = self.image(bus, node, bits, true) else { return };
        let risen = image & !self.inputs.insert(station, image).unwrap_or(!0);
        for arrow in self.arrows.iter_mut().filter(|arrow| arrow.switch.0 == station) {
            if risen & (1 << arrow.switch.1.0) != 0 {
                arrow.risen = Some(at);
            }
        }
    }

    fn actuators(&mut self, bus: &DeviceBus, node: u8, bits: u64, at: Instant) {
        let Some((station, image)) = self.image(bus, node, bits, false) else { return };
        let risen = image & !self.outputs.insert(station, image).unwrap_or(!0);
        for arrow in self.arrows.iter_mut().filter(|arrow| arrow.actuator.0 == station) {
            if risen & (1 << arrow.actuator.1.0) != 0
                && let Some(since) = arrow.risen.take()
            {
                arrow.samples.push(at - since);
            }
        }
    }

    /// The station a node belongs to, and its image from the bits of the frame. Every station of this line has one.
    fn image(&self, bus: &DeviceBus, node: u8, bits: u64, inputs: bool) -> Option<(StationId, u128)> {
        let device = self.line.devices.iter().find(|d| d.bus == *bus && d.node_id() == Some(node))?;
        let Owner::Station(station) = device.owner else { return None };
        let places: Vec<Option<u16>> = if inputs {
            device.input_bits().iter().map(|i| i.map(|i| i.0)).collect()
        } else {
            device.output_bits().iter().map(|o| o.map(|o| o.0)).collect()
        };
        let set = places.iter().enumerate().filter(|&(bit, _)| bits & (1 << bit) != 0);
        Some((station, set.filter_map(|(_, place)| *place).fold(0, |image, place| image | 1 << place)))
    }

    fn print(&mut self) {
        let mut all = Vec::new();
        for arrow in &mut self.arrows {
            all.extend(arrow.samples.iter().copied());
            print_samples(&arrow.name, &mut arrow.samples);
        }
        print_samples("all arrows", &mut all);
    }
}
