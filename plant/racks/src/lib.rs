//! The simulated plant in real time: racks of devices on the buses of this machine, and Modbus servers at their addresses.
//!
//! Each bus runs by itself: stations share no mechanism, so neither do their devices. A frame is answered when it
//! comes; a switch is reported at its time, up to one millisecond late, the resolution of tokio's timers. The
//! mechanisms themselves have no such grain: a late report changes no later position.

mod modbus;

use std::io;

use linewright_canopen::Frame;
use linewright_canopen::candump::CandumpWriter;
use linewright_fieldbus::bus::{self, BusError};
use linewright_fieldbus::{Bus, Clock};
use linewright_line::{Device, DeviceBus as BusName, Line};
use linewright_plant::{PlantOptions, Rack};
use thiserror::Error;
use tokio::task::JoinSet;

use modbus::{Asked, Servers};
pub use modbus::{fail_device, is_simulated};

/// Why a plant cannot run, or had to end.
#[derive(Debug, Error)]
pub enum PlantError {
    /// A CAN bus is not to be had, or is gone.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// A Modbus device cannot be served at its address.
    #[error(
        "cannot serve the simulated Modbus device at {address}: {error}; a device that is simulated needs an address of this \
         machine, such as 127.0.0.1:1502"
    )]
    Modbus { address: String, error: io::Error },
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
}

/// One bus's devices, connected and ready to run.
pub struct RackRunner {
    /// `None` where no device is on CAN.
    bus: Option<Bus>,
    servers: Servers,
    addresses: Vec<String>,
    rack: Rack,
    clock: Clock,
}

/// Connects every device of `line` to its bus. Must be called within a tokio runtime.
pub fn open_plant(line: &Line, options: &RackOptions) -> Result<Vec<RackRunner>, PlantError> {
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
        let servers = Servers::open(&addresses).map_err(|(address, error)| PlantError::Modbus { address, error })?;
        let rack = Rack::new(options.clock.now(), line, name, options.plant);
        Ok(RackRunner { bus, servers, addresses, rack, clock: options.clock })
    };
    names.into_iter().map(open).collect()
}

/// Runs every device of `line` until it is cancelled. Returns only if a bus cannot be opened or is gone, or there is none.
pub async fn run_plant(line: &Line, options: &RackOptions) -> Result<(), PlantError> {
    let mut running = JoinSet::new();
    for runner in open_plant(line, options)? {
        tracing::info!(bus = runner.describe(), "plant");
        running.spawn(runner.run());
    }
    // Dropping the set, when this is cancelled, ends the runners with it.
    while let Some(ended) = running.join_next().await {
        match ended {
            Ok(gone) => return Err(gone.into()),
            Err(error) if error.is_panic() => std::panic::resume_unwind(error.into_panic()),
            Err(_) => {}
        }
    }
    Ok(())
}

impl RackRunner {
    pub fn describe(&self) -> String {
        let bus = self.bus.iter().map(Bus::describe);
        let modbus = self.addresses.iter().map(|address| format!("Modbus TCP {address}"));
        bus.chain(modbus).collect::<Vec<_>>().join(", ")
    }

    /// Records the bus from here on.
    pub fn record(&mut self, recorder: CandumpWriter) {
        if let Some(bus) = &mut self.bus {
            bus.record(recorder);
        }
    }

    /// Runs until it is cancelled, or its bus is gone.
    pub async fn run(mut self) -> BusError {
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
    pub async fn step(&mut self) -> Result<(), BusError> {
        let mut out: Vec<Frame> = Vec::new();
        tokio::select! {
            biased;
            frame = heard(&mut self.bus) => self.rack.handle(self.clock.now(), &frame?, &mut out),
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
            () = self.clock.sleep_until(self.rack.next_deadline()) => {}
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
        Ok(())
    }
}

async fn heard(bus: &mut Option<Bus>) -> Result<Frame, BusError> {
    match bus {
        Some(bus) => bus.recv().await,
        None => std::future::pending().await,
    }
}
