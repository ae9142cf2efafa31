//! `fail`: a simulated mechanism or device goes wrong, told over its own bus.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use linewright_fieldbus::sdo::{ObjectId, Options};
use linewright_fieldbus::{Bus, NodeId, Options as BusOptions, sdo_client};
use linewright_line::{Bus as BusName, Device, Line, Module, Owner};
use linewright_plant::FAULT_INDEX;
use miette::{IntoDiagnostic, miette};

use crate::load;
use crate::nodes::DEFAULT_BUS;

/// What goes wrong.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Wrong {
    /// The mechanism does not move.
    Stick,
    /// It moves at a quarter of its speed.
    Slip,
    /// It does not move, and its fault signal comes on.
    Break,
    /// It moves the wrong way.
    SlipBack,
    /// The device falls silent.
    Silent,
    /// The device boots.
    Reboot,
    /// All is well again.
    Clear,
}

impl Wrong {
    /// Its number in the plant's fault object, for a motion or for a whole device.
    fn code(self, whole_device: bool) -> miette::Result<u32> {
        match (self, whole_device) {
            (Wrong::Clear, _) => Ok(0),
            (Wrong::Stick, false) | (Wrong::Silent, true) => Ok(1),
            (Wrong::Slip, false) | (Wrong::Reboot, true) => Ok(2),
            (Wrong::Break, false) => Ok(3),
            (Wrong::SlipBack, false) => Ok(4),
            (Wrong::Stick | Wrong::Slip | Wrong::Break | Wrong::SlipBack, true) => {
                Err(miette!("{self:?} happens to a motion: say which with --operation"))
            }
            (Wrong::Silent | Wrong::Reboot, false) => {
                Err(miette!("{self:?} happens to a whole device: leave --operation away"))
            }
        }
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
    what: Wrong,
    /// With which operation's motion; needed for stick, slip, slip-back and break.
    #[arg(long)]
    operation: Option<String>,
    /// Its recovery motion instead of the normal one.
    #[arg(long, requires = "operation")]
    recovery: bool,
    /// The CAN interface of the line's bus.
    #[arg(long, default_value = DEFAULT_BUS)]
    bus: String,
}

/// `linewright fail`
pub async fn fail(args: FailArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let (device, sub) = target(&line, &args)?;
    let code = args.what.code(sub == 0)?;
    let interface = match &device.bus {
        BusName::Line => &args.bus,
        BusName::Own(interface) => interface,
    };
    let mut bus = Bus::open(interface, &BusOptions::default()).into_diagnostic()?;
    let node = NodeId::new(device.node_id).ok_or_else(|| miette!("node id {} is out of range", device.node_id))?;
    let object = ObjectId::new(FAULT_INDEX, sub);
    sdo_client::write(&mut bus, node, object, &code.to_le_bytes(), Options::default())
        .await
        .map_err(|error| miette!("{error} on {}; is the simulated plant running?", bus.describe()))?;
    crate::out::say!("{} (node {node}, object {object}): {:?}", device.name, args.what);
    Ok(ExitCode::SUCCESS)
}

/// The device, and the subindex of its fault object: 0 for the whole device, else output bit + 1.
fn target<'a>(line: &'a Line, args: &FailArgs) -> miette::Result<(&'a Device, u8)> {
    let id = load::station(line, &args.station)?;
    let station = line.station(id);
    let mut devices = line.devices_of(Owner::Station(id));
    let Some(name) = &args.operation else {
        let device = devices.next().ok_or_else(|| miette!("{} has no device", args.station))?;
        return Ok((device, 0));
    };
    let op = station.operation_named(name).ok_or_else(|| {
        let known: Vec<&str> = station.operations.iter().map(|o| o.name.as_str()).collect();
        miette!("{} has no operation '{name}'; it has {}", args.station, known.join(", "))
    })?;
    let operation = &station.operations[op.index()];
    let output = match (&operation.module, args.recovery) {
        (_, false) => operation.normal.actuator,
        (Module::Reversible { recovery, .. }, true) => recovery.actuator,
        (Module::Irreversible { .. }, true) => {
            return Err(miette!("{name} is irreversible: it has no recovery motion"));
        }
    };
    for device in devices {
        if let Some(bit) = device.outputs.iter().position(|bound| *bound == Some(output)) {
            return Ok((device, u8::try_from(bit + 1).into_diagnostic()?));
        }
        // A drive has one axis, whichever target it is sent to.
        if device.drive.is_some() && device.carried_outputs().any(|carried| carried == output) {
            return Ok((device, 1));
        }
    }
    Err(miette!("no device of {} drives {name}", args.station))
}
