//! From an emergency stop to the frame that turns the outputs off, with the line's processes as in production.
//!
//! A person holds *advance* at the bar in manual mode, on a line so slow that the motion does not end. Then the emergency
//! stop is given, once as a command on `mode_cmd` and once as a frame of the console's device in which the mushroom button
//! is in. The time runs until the frame on the bus that leaves no actuator of the bar energised; the button is held on.
//! With devices on buses of the stations' own there are two DDS hops for the command, behind the gateway the coordinator turns
//! the outputs off itself. Each arrangement is measured with a quiet machine, with processes that keep every processor busy,
//! and with processes that write to the same disk as the journals and wait for it, and with journals of which every write takes a
//! second.
//!
//! `cargo bench -p linewright --bench estop [-- SAMPLES]`; 60 of each kind by default. A bare frame is sent there and back
//! beside it, as the floor of what the virtual bus takes.

use std::fs::{self, File};
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use linewright_canopen::{CanopenMessage, Frame};
use linewright_fieldbus::{Bus as CanBus, BusOptions};
use linewright_line::{DeviceBus, Owner, StationId};
use linewright_msgs::{Flag, Text};
use linewright_node_shell::{Participant, Publisher, RosArgs, RosNode, qos};

#[path = "../tests/support/gate.rs"]
#[allow(dead_code, reason = "tests close gates, this opens them late")]
mod gate;
#[path = "common/running.rs"]
mod running;

use gate::{Gate, Gates};
use running::{LINE_BUS, Running, print_samples};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// So slow that few samples meet the end of a motion.
const TIME_SCALE: f64 = 100.0;
const BAR: StationId = StationId(0);
const JOURNALS: &[&str] = &["coordinator.journal", "transfer.journal", "clamp_1.journal", "mill_1.journal"];
/// A held button is sent over and over.
const REFRESH: Duration = Duration::from_millis(20);
const PATIENCE: Duration = Duration::from_secs(20);

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let samples = words.first().map_or(Ok(60), |word| word.parse())?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    for own in [true, false] {
        println!("== {}", if own { "devices on the stations' own buses" } else { "devices behind the gateway" });
        runtime.block_on(arrangement(own, samples))?;
    }
    Ok(())
}

async fn arrangement(own: bool, samples: usize) -> Result<()> {
    let gates = std::cell::OnceCell::new();
    let running = Running::start("estop", own, TIME_SCALE, |dir| {
        let gates = gates.get_or_init(|| Gates::build(&dir.join("gates")));
        gates.environment().map(|(name, value)| (name, value.to_owned())).to_vec()
    })?;
    let mut bench = EStopBench::open(&running)?;
    running.mode_until("start", "stand-by")?;
    for load in [Load::None, Load::Processors, Load::Disk, Load::SlowRecords] {
        let loaded = Loaded::begin(load, &running.dir.join("state"))?;
        let slow = if load == Load::SlowRecords { JOURNALS } else { [].as_slice() };
        let gates = gates.get().ok_or("the processes have gates")?;
        let slow = || slow.iter().map(|name| gates.delay(name, 1000)).collect();
        for by_frame in [false, true] {
            let mut all = Vec::new();
            for nth in 0..samples {
                all.push(bench.sample(by_frame, nth, slow).await?);
            }
            let what = if by_frame { "console's frame" } else { "command" };
            print_samples(&format!("{}: {what} to outputs off", load.text()), &mut all);
        }
        drop(loaded);
    }
    Ok(())
}

/// An operator with a button of the bar's panel and the console, and an eye on the bus.
struct EStopBench {
    commands: Publisher<Text>,
    advance: Publisher<Flag>,
    /// The bus of the bar's devices.
    bar_bus: CanBus,
    console: CanBus,
    console_node: u8,
    console_inputs: usize,
    pressed_bit: u16,
    bar_nodes: Vec<u8>,
    outputs: u64,
    _node: RosNode,
}

impl EStopBench {
    fn open(running: &Running) -> Result<Self> {
        let line = &running.line;
        let args = RosArgs { domain_id: running.domain, ..RosArgs::default() };
        let mut node = Participant::open(&args)?.node(&format!("/{}", line.name), "bench")?;
        let options = BusOptions { dir: Some(running.buses_dir.clone()), ..BusOptions::default() };
        let of_bar = || line.devices.iter().filter(|device| device.owner == Owner::Station(BAR));
        let bar_bus = match &of_bar().next().ok_or("the bar has a device")?.bus {
            DeviceBus::Line => LINE_BUS.to_owned(),
            DeviceBus::Own(interface) => interface.clone(),
        };
        let console = line.devices.iter().find(|device| device.owner == Owner::Console).ok_or("there is a console")?;
        let pressed = line.console.inputs.iter().position(|name| name == "ES_pressed").ok_or("it has the button")?;
        let pressed_bit =
            console.input_bits().iter().position(|input| input.is_some_and(|input| input.index() == pressed));
        Ok(EStopBench {
            commands: node.publisher("mode_cmd", qos::command())?,
            advance: node.publisher("transfer/advance", qos::command())?,
            bar_bus: CanBus::open(&bar_bus, &options)?,
            console: CanBus::open(LINE_BUS, &options)?,
            console_node: console.node_id().ok_or("it speaks CANopen")?,
            console_inputs: console.input_bits().len(),
            pressed_bit: pressed_bit.ok_or("the button is wired")? as u16,
            bar_nodes: of_bar().filter_map(linewright_line::Device::node_id).collect(),
            outputs: 0,
            _node: node,
        })
    }

    /// The bar moves in manual mode, is stopped, and everything is reset again.
    /// With `slow` the disk is so from shortly before the stop until the outputs are off: a line whose every record takes longer
    /// than its ages does not move at all.
    async fn sample(&mut self, by_frame: bool, nth: usize, slow: impl Fn() -> Vec<Gate>) -> Result<Duration> {
        let end = Instant::now() + PATIENCE;
        let mut due = Instant::now();
        while self.outputs == 0 {
            if Instant::now() > end {
                return Err("the bar does not start to move".into());
            }
            // A command that comes too early is refused, and nothing comes of it.
            if Instant::now() >= due {
                due = Instant::now() + Duration::from_millis(400);
                for command in ["reset", "start", "manual"] {
                    self.commands.send(Text::from(command));
                    self.watch(Duration::from_millis(30), None).await;
                }
                self.advance.send(Flag { data: false });
                self.watch(Duration::from_millis(60), None).await;
            }
            self.advance.send(Flag { data: true });
            self.watch(REFRESH, None).await;
        }
        // Not in step with anything that is repeated.
        for _ in 0..3 + nth % 3 {
            self.advance.send(Flag { data: true });
            self.watch(REFRESH + Duration::from_micros(500 * (nth as u64 % 7)), None).await;
        }
        let slow = slow();
        let given = Instant::now();
        if by_frame {
            self.press(true)?;
        } else {
            self.commands.send(Text::from("estop"));
        }
        let mut off = None;
        while off.is_none() {
            if Instant::now() > end {
                return Err("the outputs stay on".into());
            }
            off = self.watch(REFRESH, Some(0)).await;
            self.advance.send(Flag { data: true });
        }
        drop(slow);
        self.advance.send(Flag { data: false });
        self.watch(Duration::from_millis(200), None).await;
        self.press(false)?;
        self.watch(Duration::from_millis(100), None).await;
        Ok(off.unwrap_or(given) - given)
    }

    /// The first transmit PDO of the console's device (CiA 301: 180h and its node id).
    fn press(&mut self, is_in: bool) -> Result<()> {
        let bits = u64::from(is_in) << self.pressed_bit;
        let data = &bits.to_le_bytes()[..self.console_inputs.div_ceil(8)];
        let frame = Frame::data_frame(0x180 + u16::from(self.console_node), data).ok_or("a frame of a device")?;
        self.console.send(&frame);
        Ok(())
    }

    /// Follows the bar's outputs for a while, or until they are `wanted`; gives when.
    async fn watch(&mut self, long: Duration, wanted: Option<u64>) -> Option<Instant> {
        let until = tokio::time::Instant::now() + long;
        loop {
            let Ok(Ok(frame)) = tokio::time::timeout_at(until, self.bar_bus.recv()).await else { return None };
            let at = Instant::now();
            if let Ok(CanopenMessage::Rpdo1 { node, payload }) = CanopenMessage::decode(&frame)
                && self.bar_nodes.contains(&node.get())
            {
                self.outputs = payload.bits() & ACTUATORS;
                if wanted == Some(self.outputs) {
                    return Some(at);
                }
            }
        }
    }
}

/// The bar's actuators are its first ten outputs; a lamp comes on with the emergency stop.
const ACTUATORS: u64 = 0x3FF;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Load {
    None,
    Processors,
    Disk,
    /// Every write of a record takes a second.
    SlowRecords,
}

impl Load {
    fn text(self) -> &'static str {
        match self {
            Load::None => "quiet",
            Load::Processors => "processors busy",
            Load::Disk => "disk busy",
            Load::SlowRecords => "a second for each record",
        }
    }
}

/// Threads that load the machine until it is dropped.
struct Loaded {
    ends: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Loaded {
    fn begin(load: Load, dir: &std::path::Path) -> Result<Self> {
        let ends = Arc::new(AtomicBool::new(false));
        let threads = std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
        let mut all = Vec::new();
        for nth in 0..if matches!(load, Load::None | Load::SlowRecords) { 0 } else { threads } {
            let (ends, path) = (Arc::clone(&ends), dir.join(format!("load-{nth}")));
            all.push(std::thread::spawn(move || {
                let block = vec![nth as u8; 8 << 20];
                while !ends.load(Ordering::Relaxed) {
                    if load == Load::Disk {
                        // A failed write is no load, and the benchmark goes on.
                        let written = File::create(&path).and_then(|mut file| {
                            file.write_all(&block)?;
                            file.sync_all()
                        });
                        drop(written);
                    } else {
                        std::hint::black_box((0..100_000u64).fold(0, u64::wrapping_add));
                    }
                }
                drop(fs::remove_file(&path));
            }));
        }
        Ok(Loaded { ends, threads: all })
    }
}

impl Drop for Loaded {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            drop(thread.join());
        }
    }
}
