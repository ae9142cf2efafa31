//! `fail`: a fault of a simulated mechanism or device, injected over its own bus.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::LazyLock;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use linewright_canopen::NodeId;
use linewright_canopen::sdo::{ObjectId, TransferOptions};
use linewright_fieldbus::{Bus, sdo_client};
use linewright_line::{Device, DeviceBus as BusName, Line, OperationModule, Owner};
use linewright_node_shell::RosArgs;
use linewright_plant::{CLEAR, CLEAR_WORD, DeviceFault, FAULT_INDEX, FrameFaults, MotionFault, ObjectWrites};
use miette::{IntoDiagnostic, miette};

use crate::load;
use crate::nodes::DEFAULT_BUS;

/// Fault to inject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InjectedFault {
    /// With one motion.
    Motion(MotionFault),
    /// With a whole device.
    Device(DeviceTrouble),
    /// All is well again.
    Clear,
}

/// Fault of a whole device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DeviceTrouble {
    /// The device falls silent
    Silent,
    /// The device boots
    Reboot,
    /// It boots and does not come up
    NoBoot,
    /// Its heartbeats cease, all else goes on
    NoHeartbeat,
    /// It says to be another product (object 1018h:02) and boots
    Identity,
    /// It refuses its heartbeat time (object 1017h) and boots
    Refuse,
    /// It reports an overload of its outputs (emergency 2310h)
    Emergency,
    /// It is off the bus for a second
    BusOff,
    /// A twentieth of the frames to and from it is lost, a twentieth doubled
    Lossy,
}

/// Every fault, in the order of the help.
static VARIANTS: LazyLock<Vec<InjectedFault>> = LazyLock::new(|| {
    let motions = MotionFault::ALL.into_iter().map(InjectedFault::Motion);
    let devices = DeviceTrouble::value_variants().iter().copied().map(InjectedFault::Device);
    motions.chain(devices).chain([InjectedFault::Clear]).collect()
});

impl ValueEnum for InjectedFault {
    fn value_variants<'a>() -> &'a [Self] {
        &VARIANTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            InjectedFault::Motion(fault) => {
                Some(PossibleValue::new(fault.name()).help(fault.about().first()?.trim_end_matches('.')))
            }
            InjectedFault::Device(trouble) => trouble.to_possible_value(),
            InjectedFault::Clear => Some(PossibleValue::new(CLEAR_WORD).help("All is well again")),
        }
    }
}

impl InjectedFault {
    /// Its name on the command line.
    fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Fault of a motion (`Some(None)`: cleared), if it concerns one.
    fn of_a_motion(self) -> Option<Option<MotionFault>> {
        match self {
            InjectedFault::Clear => Some(None),
            InjectedFault::Motion(fault) => Some(Some(fault)),
            InjectedFault::Device(_) => None,
        }
    }

    /// Writes to the device, if it concerns a whole device. Those that take effect in a boot end with one.
    fn of_a_device(self) -> Option<ObjectWrites> {
        const HARDWARE: u32 = 0x0606_0000;
        let trouble = match self {
            InjectedFault::Clear => return Some(vec![CLEAR]),
            InjectedFault::Motion(_) => return None,
            InjectedFault::Device(trouble) => trouble,
        };
        let faults = match trouble {
            DeviceTrouble::Silent => vec![DeviceFault::Silent],
            DeviceTrouble::Reboot => vec![DeviceFault::Reboot],
            DeviceTrouble::NoBoot => vec![DeviceFault::NoBoot],
            DeviceTrouble::NoHeartbeat => vec![DeviceFault::NoHeartbeat],
            DeviceTrouble::Identity => {
                vec![DeviceFault::Identity { object: (0x1018, 2), value: 0xFFFF }, DeviceFault::Reboot]
            }
            DeviceTrouble::Refuse => {
                let object = (0x1017, 0);
                let refusal = DeviceFault::Abort { object, code: HARDWARE, reading: false, writing: true };
                vec![refusal, DeviceFault::Reboot]
            }
            DeviceTrouble::Emergency => vec![DeviceFault::Emergency { code: 0x2310, register: 5 }],
            DeviceTrouble::BusOff => vec![DeviceFault::BusOff { millis: 1000 }],
            DeviceTrouble::Lossy => {
                let faults = FrameFaults { lost_to: 50, lost_from: 50, doubled: 50, ..FrameFaults::default() };
                return Some(faults.orders());
            }
        };
        Some(faults.into_iter().flat_map(DeviceFault::orders).collect())
    }
}

/// Make a simulated mechanism or device fail.
#[derive(Debug, Args)]
pub struct FailArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// The station.
    station: String,
    /// What goes wrong.
    what: InjectedFault,
    /// With which operation's motion; needed for what goes wrong with a motion.
    #[arg(long)]
    operation: Option<String>,
    /// Its recovery motion instead of the normal one.
    #[arg(long, requires = "operation")]
    recovery: bool,
    /// Which of the station's devices, by its name; the first one without this.
    #[arg(long, conflicts_with = "operation")]
    device: Option<String>,
    /// The CAN interface of the line's bus.
    #[arg(long, default_value = DEFAULT_BUS)]
    bus: String,
}

/// `linewright fail`
pub async fn fail(args: FailArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let (device, orders) = orders(&line, &args)?;
    let interface = match &device.bus {
        BusName::Line => &args.bus,
        BusName::Own(interface) => interface,
    };
    let mut bus =
        Bus::open(interface, &super::options(interface, Some(&super::run_of(&line, ros)?))?).into_diagnostic()?;
    let node = device
        .node_id()
        .and_then(NodeId::new)
        .ok_or_else(|| miette!("{}: not a CANopen device; faults cannot be injected", device.name))?;
    for ((index, sub), value) in orders {
        sdo_client::write(&mut bus, node, ObjectId::new(index, sub), &value.to_le_bytes(), TransferOptions::default())
            .await
            .map_err(|error| miette!("{error} on {}; is the simulated plant running?", bus.describe()))?;
    }
    crate::out::say!("{} (node {node}): {}", device.name, args.what.name());
    Ok(ExitCode::SUCCESS)
}

/// The device, and what is written to it.
fn orders<'a>(line: &'a Line, args: &FailArgs) -> miette::Result<(&'a Device, ObjectWrites)> {
    let what = args.what;
    if args.operation.is_some() {
        let fault = what
            .of_a_motion()
            .ok_or_else(|| miette!("{} is a fault of a whole device; omit --operation", what.name()))?;
        let (device, sub) = moving(line, args)?;
        return Ok((device, vec![((FAULT_INDEX, sub), fault.map_or(0, MotionFault::code))]));
    }
    let orders = what.of_a_device().ok_or_else(|| miette!("{} needs --operation", what.name()))?;
    let id = load::station(line, &args.station)?;
    let devices: Vec<&Device> = line.devices_of(Owner::Station(id)).collect();
    let named = |device: &&&Device| args.device.as_ref().is_none_or(|name| device.name == *name);
    let device = devices.iter().find(named).ok_or_else(|| {
        let known: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        miette!("{} has no such device; it has {}", args.station, known.join(", "))
    })?;
    Ok((device, orders))
}

/// The device that drives an operation, and the subindex of its fault object: output bit + 1.
fn moving<'a>(line: &'a Line, args: &FailArgs) -> miette::Result<(&'a Device, u8)> {
    let id = load::station(line, &args.station)?;
    let station = line.station(id);
    let devices = line.devices_of(Owner::Station(id));
    let name = args.operation.as_deref().unwrap_or_default();
    let op = station.operation_named(name).ok_or_else(|| {
        let known: Vec<&str> = station.operations.iter().map(|o| o.name.as_str()).collect();
        miette!("{} has no operation '{name}'; it has {}", args.station, known.join(", "))
    })?;
    let operation = &station.operations[op.index()];
    let output = match (&operation.module, args.recovery) {
        (_, false) => operation.normal.actuator,
        (OperationModule::Reversible { recovery, .. }, true) => recovery.actuator,
        (OperationModule::Irreversible { .. }, true) => {
            return Err(miette!("{name} is irreversible: it has no recovery motion"));
        }
    };
    for device in devices {
        if let Some(bit) = device.output_bits().iter().position(|bound| *bound == Some(output)) {
            return Ok((device, u8::try_from(bit + 1).into_diagnostic()?));
        }
        // The motions of a drive are counted as the outputs that move it.
        if let Some(motion) = device.drive().and_then(|drive| drive.motions().position(|own| own == output)) {
            return Ok((device, u8::try_from(motion + 1).into_diagnostic()?));
        }
    }
    Err(miette!("no device of {} drives {name}", args.station))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVES: &str = include_str!("../../../model/line/tests/descriptions/drives.toml");

    #[test]
    fn each_motion_of_a_drive_has_a_fault_of_its_own() {
        let line = linewright_line::parse("drives.toml", DRIVES).expect("it parses").line;
        let station = line.stations[0].name.clone();
        let drive = line.devices.iter().find(|device| device.drive().is_some()).expect("a drive");
        let outputs: Vec<_> = drive.drive().expect("a drive").motions().collect();
        let driven = line.stations[0].operations.iter().filter(|op| outputs.contains(&op.normal.actuator));
        let mut subs = Vec::new();
        for operation in driven {
            let args = FailArgs {
                line: PathBuf::new(),
                station: station.clone(),
                what: InjectedFault::Motion(MotionFault::Stick),
                operation: Some(operation.name.clone()),
                recovery: false,
                device: None,
                bus: String::new(),
            };
            let (device, orders) = orders(&line, &args).expect("it can stick");
            let [((FAULT_INDEX, sub), 1)] = orders[..] else { panic!("{orders:X?}") };
            assert_eq!((&device.name, outputs[usize::from(sub) - 1]), (&drive.name, operation.normal.actuator));
            subs.push(sub);
        }
        subs.dedup();
        assert!(subs.len() > 1, "{subs:?}");
    }
}
