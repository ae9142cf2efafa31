//! Faults are written to simulated devices alone.

use linewright_canopen::NodeId;
use linewright_canopen::sdo::{ObjectId, TransferError, TransferFailure, TransferMode, TransferOptions};
use linewright_fieldbus::sdo_client::{self, SdoError};
use linewright_fieldbus::{Bus, find_bus};
use linewright_line::{Device, DeviceBus as BusName, Line, Modbus};
use linewright_node_shell::RosArgs;
use linewright_plant::{FAULTS_INDEX, PART_OF_INDEX, SIMULATED, SIMULATED_INDEX, TAKE_INDEX};
use linewright_racks::Served;
use miette::{IntoDiagnostic, miette};

/// A silent device answers segments and no blocks.
fn segments() -> TransferOptions {
    TransferOptions { mode: TransferMode::Segmented, ..TransferOptions::default() }
}

/// A device that has been found to be simulated.
pub enum SimulatedDevice<'d> {
    Canopen(Box<Bus>, NodeId),
    Modbus(&'d Modbus),
}

impl<'d> SimulatedDevice<'d> {
    /// Finds out whether it is simulated and part of this line, without writing to it. `line_bus` is the interface of the line's bus.
    pub async fn reach(line: &Line, line_bus: &str, ros: &RosArgs, device: &'d Device) -> miette::Result<Self> {
        let run = super::run_of(line, ros)?;
        let reached = match (device.modbus(), device.node_id().and_then(NodeId::new)) {
            (Some(modbus), _) => SimulatedDevice::Modbus(modbus),
            (None, Some(node)) => {
                let interface = match &device.bus {
                    BusName::Line => line_bus,
                    BusName::Own(interface) => interface,
                };
                let options = super::options(interface, find_bus(interface, Some(&run)))?;
                SimulatedDevice::Canopen(Box::new(Bus::open(interface, &options).into_diagnostic()?), node)
            }
            (None, None) => {
                return Err(miette!(
                    help = "a plain CAN device takes no faults; faults of motions, inputs and devices are for CANopen and Modbus",
                    "{} cannot be made to fail",
                    device.name
                ));
            }
        };
        reached.checked(device, &line.name, &run).await
    }

    /// `run`: of its line in the ROS domain of this command.
    async fn checked(mut self, device: &Device, line: &str, run: &str) -> miette::Result<Self> {
        let is_simulated = match &mut self {
            SimulatedDevice::Canopen(bus, node) => {
                let object = ObjectId::new(SIMULATED_INDEX, 0);
                match sdo_client::read(bus, *node, object, segments()).await {
                    Ok(bytes) if bytes == SIMULATED.to_le_bytes() => {
                        part_of(bus, *node, device, (line, run)).await?;
                        true
                    }
                    Ok(_) => false,
                    // A device that has no such object.
                    Err(SdoError::Transfer {
                        error: TransferError { cause: TransferFailure::Refused(_), .. }, ..
                    }) => false,
                    Err(error) => {
                        return Err(miette!(
                            "{error} on {}; is the simulated plant running? {}",
                            bus.describe(),
                            ran(run)
                        ));
                    }
                }
            }
            SimulatedDevice::Modbus(modbus) => {
                let served = linewright_racks::served_at((&modbus.address, modbus.unit)).await;
                let served = served.map_err(|error| miette!("{error}"))?;
                if let Some(theirs) = served.other_run(run) {
                    return Err(miette!(
                        help = "give this command the ROS_DOMAIN_ID and namespace of that run",
                        "{} at {} is part of {theirs}, and this command is for {run}; nothing was written",
                        device.name,
                        modbus.address
                    ));
                }
                served != Served::Other
            }
        };
        if is_simulated {
            return Ok(self);
        }
        Err(miette!(
            help = "run the line with the simulated plant, or name a simulated device with --device",
            "{} ({}) is not a simulated device; nothing was written",
            device.name,
            self.place()
        ))
    }

    /// Number of injected faults that hold in it.
    pub async fn faults(&mut self, device: &Device) -> miette::Result<u16> {
        match self {
            SimulatedDevice::Canopen(bus, node) => {
                let read = sdo_client::read(bus, *node, ObjectId::new(FAULTS_INDEX, 0), segments()).await;
                let bytes = read.map_err(|error| miette!("{error} on {}", bus.describe()))?;
                let count = <[u8; 2]>::try_from(bytes).map(u16::from_le_bytes);
                count.map_err(|_| miette!("{} does not count its faults; is it of another version?", device.name))
            }
            SimulatedDevice::Modbus(modbus) => {
                let at = (modbus.address.as_str(), modbus.unit);
                let count = linewright_racks::fail_device(at, &device.name, (FAULTS_INDEX, 0), 0).await;
                count.map_err(|error| miette!("{error}"))
            }
        }
    }

    /// Outcome of the last part that was taken out or put in by it: 0, or the number of a refusal.
    pub async fn part_outcome(&mut self, device: &Device) -> miette::Result<u8> {
        let SimulatedDevice::Canopen(bus, node) = self else { return Ok(0) };
        let read = sdo_client::read(bus, *node, ObjectId::new(TAKE_INDEX, 0), segments()).await;
        let bytes = read.map_err(|error| miette!("{error} on {}", bus.describe()))?;
        let outcome = <[u8; 1]>::try_from(bytes).map(|[code]| code);
        outcome.map_err(|_| miette!("{} does not say what became of it; is it of another version?", device.name))
    }

    /// Writes a number to one of its objects.
    pub async fn write(&mut self, device: &Device, object: (u16, u8), value: u32) -> miette::Result<()> {
        match self {
            SimulatedDevice::Canopen(bus, node) => {
                let (id, data) = (ObjectId::new(object.0, object.1), value.to_le_bytes());
                let written = sdo_client::write(bus, *node, id, &data, TransferOptions::default()).await;
                written.map_err(|error| miette!("{error} on {}", bus.describe()))
            }
            SimulatedDevice::Modbus(modbus) => {
                let at = (modbus.address.as_str(), modbus.unit);
                let failed = linewright_racks::fail_device(at, &device.name, object, value).await;
                failed.map(drop).map_err(|error| miette!("{error}"))
            }
        }
    }

    /// Where it is, for people.
    pub fn place(&self) -> String {
        match self {
            SimulatedDevice::Canopen(_, node) => format!("node {node}"),
            SimulatedDevice::Modbus(modbus) => format!("{} unit {}", modbus.address, modbus.unit),
        }
    }
}

/// Whether a simulated device is part of this run, or of a plant of this line that was started by itself.
///
/// # Errors
/// When it is part of another one.
async fn part_of(bus: &mut Bus, node: NodeId, device: &Device, (line, run): (&str, &str)) -> miette::Result<()> {
    let read = sdo_client::read(bus, node, ObjectId::new(PART_OF_INDEX, 0), segments()).await;
    let bytes = read.map_err(|error| miette!("{error} on {}", bus.describe()))?;
    let theirs = String::from_utf8_lossy(&bytes);
    if theirs == run || theirs == linewright_racks::alone(line) {
        return Ok(());
    }
    Err(miette!(
        help = super::SEPARATE_LINES,
        "{} (node {node}) on {} is part of {theirs}, and this command is for {run}; nothing was written",
        device.name,
        bus.describe()
    ))
}

/// Whether the devices on a virtual bus that no manager drives are of this line, by the first of them that answers.
///
/// # Errors
/// When they are another line's.
pub async fn are_own(bus: &mut Bus, device: &Device, (line, run): (&str, &str)) -> miette::Result<()> {
    let Some(node) = device.node_id().and_then(NodeId::new) else { return Ok(()) };
    let is_asked = sdo_client::read(bus, node, ObjectId::new(PART_OF_INDEX, 0), segments()).await.is_ok();
    if is_asked { part_of(bus, node, device, (line, run)).await } else { Ok(()) }
}

/// Which run is looked for: each has virtual buses of its own.
fn ran(run: &str) -> String {
    format!(
        "this command is for {run}; a run in another domain, or one that was started with another LINEWRIGHT_BUS_DIR, has other buses: \
         set what it has of both"
    )
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use linewright_canopen::codec::CanopenMessage;
    use linewright_fieldbus::{BusOptions, Transport};

    use super::*;

    /// A device that answers every reading with these 4 bytes, or refuses it, and takes all that is written. The requests it got.
    fn real_device(bus: BusOptions, node: NodeId, answer: Option<[u8; 4]>) -> Arc<Mutex<Vec<[u8; 8]>>> {
        let requests = Arc::new(Mutex::new(Vec::new()));
        let got = requests.clone();
        let mut bus = Bus::open("test0", &bus).expect("a virtual bus");
        tokio::spawn(async move {
            while let Ok(frame) = bus.recv().await {
                let Ok(CanopenMessage::SdoRequest { node: to, raw }) = CanopenMessage::decode(&frame) else { continue };
                if to != node {
                    continue;
                }
                got.lock().expect("no panic").push(raw);
                let [_, low, high, sub, ..] = raw;
                let raw = match (raw[0] >> 5, answer) {
                    (1, _) => [0x60, low, high, sub, 0, 0, 0, 0],
                    (_, Some([a, b, c, d])) => [0x43, low, high, sub, a, b, c, d],
                    // The object does not exist.
                    (_, None) => [0x80, low, high, sub, 0, 0, 2, 6],
                };
                bus.send(&CanopenMessage::SdoResponse { node, raw }.encode());
            }
        });
        requests
    }

    fn shipped() -> Line {
        let text = linewright_line::TransferLine::default().text();
        linewright_line::parse("line.toml", &text).expect("it parses").line
    }

    /// The first CANopen device of a line, with its node id.
    fn canopen(line: &Line) -> (&Device, NodeId) {
        let node = |device: &Device| device.node_id().and_then(NodeId::new);
        line.devices.iter().find_map(|device| Some((device, node(device)?))).expect("a CANopen device")
    }

    #[tokio::test]
    async fn nothing_is_written_to_a_device_that_is_not_simulated() {
        let line = shipped();
        let (device, node) = canopen(&line);
        for answer in [None, Some([0; 4])] {
            let dir = tempfile::tempdir().expect("a directory");
            let options = BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) };
            let requests = real_device(options.clone(), node, answer);
            let bus = Bus::open("test0", &options).expect("a virtual bus");
            let refused =
                SimulatedDevice::Canopen(Box::new(bus), node).checked(device, "a", "line /a in ROS domain 3").await;
            let refused = refused.err().expect("it is a real one").to_string();
            assert_eq!(
                refused,
                format!("{} (node {node}) is not a simulated device; nothing was written", device.name)
            );
            let requests = requests.lock().expect("no panic");
            assert_eq!(*requests, [[0x40, 0x05, 0x5F, 0, 0, 0, 0, 0]], "one reading");
        }
    }

    /// A plant with the devices of the shipped line, part of `run`.
    fn plant(line: &Line, bus: BusOptions, run: Option<&str>) -> tokio::task::JoinHandle<()> {
        let options = linewright_racks::RackOptions {
            line_bus: "test0".to_owned(),
            bus,
            plant: linewright_plant::PlantOptions::default(),
            clock: linewright_fieldbus::Clock::start(),
            run: run.map(str::to_owned),
            mishap: None,
        };
        let line = line.clone();
        tokio::spawn(async move {
            let ended = linewright_racks::run_plant(&line, &options, None, std::future::pending()).await;
            ended.expect("it has a bus");
        })
    }

    /// Two lines on one machine may have buses of one name, and devices of one node id on them.
    #[tokio::test]
    async fn nothing_is_written_to_a_device_of_another_line() {
        let line = shipped();
        let (device, node) = canopen(&line);
        let own = format!("line /{} in ROS domain 3", line.name);
        for (theirs, is_ours) in [
            (Some(own.as_str()), true),
            (None, true),
            (Some("line /other in ROS domain 3"), false),
            (Some(&*own.replace("domain 3", "domain 4")), false),
        ] {
            let dir = tempfile::tempdir().expect("a directory");
            let options = BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) };
            let plant = plant(&line, options.clone(), theirs);
            let bus = Bus::open("test0", &options).expect("a virtual bus");
            let reached = SimulatedDevice::Canopen(Box::new(bus), node).checked(device, &line.name, &own).await;
            match (reached, is_ours) {
                (Ok(mut ours), true) => assert_eq!(ours.faults(device).await.expect("it counts them"), 0),
                (Err(refused), false) => {
                    let (text, theirs) = (refused.to_string(), theirs.expect("it has a run"));
                    let both = format!("is part of {theirs}, and this command is for {own}; nothing was written");
                    assert!(text.contains(&both), "{text}");
                    assert!(refused.help().is_some_and(|help| help.to_string().contains("--bus")));
                }
                (reached, _) => panic!("{theirs:?}: {:?}", reached.map(|_| "it is ours")),
            }
            plant.abort();
        }
    }
}
