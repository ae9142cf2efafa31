//! The simulated plant in real time: racks of devices on the buses of this machine, and Modbus servers at their addresses.
//!
//! Each bus runs by itself: stations share no mechanism, so neither do their devices. A frame is answered when it
//! comes; a switch is reported at its time, up to one millisecond late, the resolution of tokio's timers. The
//! mechanisms themselves have no such grain: a late report changes no later position.

mod kept;
mod modbus;
pub mod texts;

use std::collections::BTreeMap;
use std::future::Future;
use std::io;
use std::path::Path;
use std::time::Duration;

use linewright_canopen::Frame;
use linewright_fieldbus::bus::{self, BusError};
use linewright_fieldbus::{Bus, Clock};
use linewright_line::{Device, DeviceBus as BusName, Line, Tick};
use linewright_plant::{PlantOptions, PositionsWatch, Rack};
use tokio::task::JoinSet;

pub use kept::{KEPT_IN, Keeper, KeeperThread, KeptPositions, kept_positions};
use modbus::{Asked, Servers, cannot_serve};
pub use modbus::{Served, are_served, can_be_served, fail_device, served_at};
use texts::PlantNews;

/// Positions are kept no more often than this.
const KEEP_EVERY: Duration = Duration::from_millis(200);

/// Why a plant cannot run, or had to end.
#[derive(Debug)]
pub enum PlantError {
    /// A CAN bus is not to be had, or is gone.
    Bus(BusError),
    /// A Modbus device cannot be served at its address.
    Modbus { address: String, error: io::Error },
    /// Something is served at the address of a Modbus device.
    ModbusTaken { address: String, by: Option<Served> },
}

impl From<BusError> for PlantError {
    fn from(error: BusError) -> Self {
        PlantError::Bus(error)
    }
}

/// Options of a plant.
#[derive(Clone, Debug)]
pub struct RackOptions {
    /// The interface that serves as the coordinator's bus; stations' own buses have their names in the description.
    pub line_bus: String,
    /// Transport and place of the buses.
    pub bus: bus::BusOptions,
    /// Deviations of the mechanisms from their description.
    pub plant: PlantOptions,
    /// The clock shared with the rest of the process.
    pub clock: Clock,
    /// The run of a line that the devices are part of; `None` for a plant that is started by itself, which is part of the line.
    pub run: Option<String>,
    /// Called with each mishap of a part, as text, beside the log.
    pub mishap: Option<fn(&str)>,
}

/// One bus's devices, connected and ready to run.
struct RackRunner {
    /// Name of the bus in the description.
    name: String,
    /// `None` where no device is on CAN.
    bus: Option<Bus>,
    servers: Servers,
    addresses: Vec<String>,
    rack: Rack,
    clock: Clock,
    /// Where its positions are kept, if they are.
    kept: Option<KeptRack>,
    line: Line,
    /// Number of mishaps of parts that were reported.
    reported: usize,
    mishap: Option<fn(&str)>,
}

/// Keeps the positions of one rack.
struct KeptRack {
    bus: String,
    watch: PositionsWatch,
    keeper: Keeper,
}

/// What devices are part of in a plant of this line that was started by itself; it has no ROS domain.
pub fn alone(line: &str) -> String {
    format!("line {line}")
}

/// Opens every bus; its rack is taken from `racks`, or new.
fn open_racks(
    line: &Line,
    options: &RackOptions,
    mut racks: BTreeMap<String, Rack>,
) -> Result<Vec<RackRunner>, PlantError> {
    let mut names: Vec<&BusName> = Vec::new();
    for device in &line.devices {
        if !names.contains(&&device.bus) {
            names.push(&device.bus);
        }
    }
    let open = |name: &BusName| {
        let interface = match name {
            BusName::Line => &options.line_bus,
            BusName::Own(interface) => interface,
        };
        let devices = || line.devices.iter().filter(|device| device.bus == *name);
        let bus = devices().any(Device::is_on_can).then(|| Bus::open(interface, &options.bus)).transpose()?;
        let mut addresses: Vec<String> =
            devices().filter_map(|device| Some(device.modbus()?.address.clone())).collect();
        addresses.sort();
        addresses.dedup();
        let servers = Servers::open(&addresses, options.run.as_deref());
        let servers = servers.map_err(|(address, error)| cannot_serve(&address, error, None))?;
        let rack = racks.remove(&name.to_string());
        let mut rack = rack.unwrap_or_else(|| Rack::new(options.clock.now(), line, name, options.plant));
        rack.be_part_of(&options.run.clone().unwrap_or_else(|| alone(&line.name)));
        Ok(RackRunner {
            name: name.to_string(),
            bus,
            servers,
            addresses,
            rack,
            clock: options.clock,
            kept: None,
            line: line.clone(),
            reported: 0,
            mishap: options.mishap,
        })
    };
    names.into_iter().map(open).collect()
}

/// Runs every device of `line` until `stop`; must be called within a tokio runtime. With `keep`, mechanisms and parts begin
/// where they were when a plant last kept its positions in that directory, and are kept there.
///
/// # Errors
/// A bus cannot be opened or is gone, or a Modbus device cannot be served.
pub async fn run_plant(
    line: &Line,
    options: &RackOptions,
    keep: Option<&Path>,
    stop: impl Future<Output = ()>,
) -> Result<(), PlantError> {
    let Some(dir) = keep else { return run_racks(open_racks(line, options, BTreeMap::new())?, stop).await };
    let now = options.clock.now();
    let mut runners = open_racks(line, options, kept_racks(dir, line, options, now))?;
    let (keeper, writer) = Keeper::begin(dir, line);
    for runner in &mut runners {
        let (bus, watch) = (runner.name.clone(), PositionsWatch::new(now, KEEP_EVERY));
        runner.kept = Some(KeptRack { bus, watch, keeper: keeper.clone() });
    }
    let ended = run_racks(runners, stop).await;
    drop(keeper);
    // Its last write; it has ended when every rack and this have let go of it.
    writer.end();
    ended
}

/// The racks with the positions kept in `dir`. Where these cannot be used, that is logged and everything begins at home.
fn kept_racks(dir: &Path, line: &Line, options: &RackOptions, now: Tick) -> BTreeMap<String, Rack> {
    match kept_positions(dir, line, now, options.plant) {
        Ok(KeptPositions::Nothing) => BTreeMap::new(),
        Ok(KeptPositions::Racks(racks)) => {
            tracing::info!("{}", PlantNews::Resumed { path: &dir.join(KEPT_IN) });
            racks
        }
        Err(why) => {
            tracing::warn!("{why}");
            kept::set_aside(dir);
            BTreeMap::new()
        }
    }
}

async fn run_racks(runners: Vec<RackRunner>, stop: impl Future<Output = ()>) -> Result<(), PlantError> {
    let mut running = JoinSet::new();
    for runner in runners {
        tracing::info!(bus = runner.describe(), "plant");
        running.spawn(runner.run());
    }
    // Dropping the set, when this is cancelled, ends the runners with it.
    let mut stop = std::pin::pin!(stop);
    loop {
        let ended = tokio::select! {
            ended = running.join_next() => ended,
            () = &mut stop => {
                running.shutdown().await;
                return Ok(());
            }
        };
        match ended {
            None => return Ok(()),
            Some(Ok(gone)) => {
                running.shutdown().await;
                return Err(gone.into());
            }
            Some(Err(error)) if error.is_panic() => std::panic::resume_unwind(error.into_panic()),
            Some(Err(_)) => {}
        }
    }
}

impl Drop for RackRunner {
    /// The last positions are kept.
    fn drop(&mut self) {
        let now = self.clock.now();
        if let Some(kept) = &mut self.kept {
            kept.keep(now, &self.line, &mut self.rack);
        }
    }
}

impl KeptRack {
    fn keep(&mut self, now: Tick, line: &Line, rack: &mut Rack) {
        if let Some(positions) = self.watch.look(now, rack.positions(now, line)) {
            self.keeper.keep(&self.bus, positions);
        }
    }
}

impl RackRunner {
    fn describe(&self) -> String {
        let bus = self.bus.iter().map(Bus::describe);
        let modbus = self.addresses.iter().map(|address| format!("Modbus TCP {address}"));
        bus.chain(modbus).collect::<Vec<_>>().join(", ")
    }

    /// Runs until it is cancelled, or its bus is gone.
    async fn run(mut self) -> BusError {
        loop {
            if let Err(gone) = self.step().await {
                return gone;
            }
        }
    }

    /// Waits for one frame or deadline and does what follows from it. Cancel safe.
    ///
    /// # Errors
    /// When the bus is gone.
    async fn step(&mut self) -> Result<(), BusError> {
        let mut out: Vec<Frame> = Vec::new();
        let deadline = self.next_deadline();
        tokio::select! {
            biased;
            frame = received(&mut self.bus) => self.rack.handle(self.clock.now(), &frame?, &mut out),
            // The queue is this one's own: it never ends. The clients may be gone.
            Some(asked) = self.servers.next() => match asked {
                Asked::Request { at: (address, unit), request, reply } => {
                    let _ = reply.send(self.rack.ask(self.clock.now(), (&address, unit), &request, &mut out));
                }
                Asked::Fault { at: (address, unit), device, fault, reply } => {
                    let now = self.clock.now();
                    let _ = reply.send(self.rack.fail_modbus(now, (&address, unit), &device, fault, &mut out));
                }
            },
            () = self.clock.sleep_until(deadline) => {}
        }
        // Also after a frame: a busy bus must not keep the devices from what is due.
        let now = self.clock.now();
        if self.rack.next_deadline().is_some_and(|due| due <= now) {
            self.rack.poll(now, &mut out);
        }
        if let Some(bus) = &mut self.bus {
            for frame in &out {
                bus.send(frame);
            }
        }
        if let Some(kept) = &mut self.kept
            && kept.watch.stir(now)
        {
            kept.keep(now, &self.line, &mut self.rack);
        }
        self.report_mishaps();
        Ok(())
    }

    /// Parts that have fallen down, or were lost to a clamp.
    fn report_mishaps(&mut self) {
        let plant = self.rack.plant();
        let (mishaps, _) = plant.mishaps();
        for (_, mishap) in mishaps.iter().skip(self.reported).filter(|(_, mishap)| mishap.is_certain(&self.line)) {
            let news = PlantNews::Mishap { what: mishap.text(&self.line, plant) }.to_string();
            tracing::warn!("{news}");
            self.mishap.into_iter().for_each(|report| report(&news));
        }
        self.reported = mishaps.len();
    }

    fn next_deadline(&self) -> Option<Tick> {
        let look = self.kept.as_ref().and_then(|kept| kept.watch.due());
        self.rack.next_deadline().into_iter().chain(look).min()
    }
}

async fn received(bus: &mut Option<Bus>) -> Result<Frame, BusError> {
    match bus {
        Some(bus) => bus.recv().await,
        None => std::future::pending().await,
    }
}
