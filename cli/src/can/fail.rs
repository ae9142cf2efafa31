//! `fail`: injects faults into simulated mechanisms, inputs and devices, over CAN or Modbus.

mod cleared;
mod motions;
mod refusals;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use linewright_line::{Device, DeviceKind, InputId, Line, Owner};
use linewright_node_shell::RosArgs;
use linewright_plant::{CLEAR, FAULT_INDEX, InputFault, MotionFault, ObjectWrites};
use miette::{IntoDiagnostic, miette};

use super::injected::InjectedFault;
use super::simulated::SimulatedDevice;
use crate::load;
use cleared::Cleared;
use motions::{closes_a_gripper, has_fault_signal, motion};
use refusals::{needs, no_fault_signal, no_gripper, wrong_option};

/// Make a simulated mechanism, switch or device fail.
#[derive(Debug, Args)]
#[command(
    after_help = "A fault lasts until it is cleared: `clear` with the same --operation, --input or --device ends that one, and without any of them every fault of all devices of the station."
)]
pub struct FailArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// The station, or `console`.
    station: String,
    /// Fault, or `clear`.
    what: InjectedFault,
    /// Operation whose motion has the fault; required for a fault of a motion. It is one of the output that moves it: other motions
    /// by that output, which are named, have it as well, each time until it is cleared. For `miss` and `drop` it is the operation that
    /// closes the gripper, also where the part is lost on the way.
    #[arg(long)]
    operation: Option<String>,
    /// The fault is one of the operation's recovery motion instead of the normal one.
    #[arg(long, requires = "operation")]
    recovery: bool,
    /// Input that has the fault; required for a fault of an input.
    #[arg(long, conflicts_with = "operation")]
    input: Option<String>,
    /// Name of the station's device; an operation and an input have theirs already [default: the first one; for `clear` all of them].
    #[arg(long)]
    device: Option<String>,
    /// The CAN interface of the line's bus [default: the one that its coordinator has on this machine, if it runs, else vcan0].
    #[arg(long)]
    bus: Option<String>,
}

/// `linewright fail`
pub async fn fail(args: FailArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let what = args.what.name();
    let bus = super::line_bus(args.bus.as_deref(), Some(&line), ros);
    // All of them first: nothing is written if one is not simulated, or another line's.
    let mut simulated = Vec::new();
    for (device, orders) in orders(&line, &args)? {
        simulated.push((SimulatedDevice::reach(&line, &bus, ros, device).await?, device, orders));
    }
    let mut cleared = Cleared::default();
    for (mut reached, device, orders) in simulated {
        let is_clear = args.what == InjectedFault::Clear;
        let before = if is_clear { reached.faults(device).await? } else { 0 };
        let is_whole = orders.contains(&CLEAR);
        for (object, value) in orders {
            reached.write(device, object, value).await?;
        }
        if is_clear {
            // A device that was cleared as a whole has none left, and may just boot.
            let after = if is_whole { 0 } else { reached.faults(device).await? };
            cleared.note(&device.name, before, after);
            if before == after {
                continue;
            }
        }
        let at = reached.place();
        let named = args.input.clone().or_else(|| motions::named(&args));
        let named = named.map_or_else(String::new, |name| format!(" {name}"));
        crate::out::say!("{} ({at}):{named} {what}", device.name);
        let others = if args.operation.is_some() { motions::others(&line, &args)? } else { None };
        others.into_iter().chain(effect(&line, device, args.what)).for_each(|text| crate::out::say!("{text}"));
    }
    for text in super::started_with_another(&line, &args.line, ros).await {
        crate::out::complain!("{text}");
    }
    match cleared.nothing(&args) {
        Some(nothing) => Err(nothing),
        None => Ok(ExitCode::SUCCESS),
    }
}

/// What a drive does with a fault of its motion, and the signal that shows it: at rest nothing else is seen of it.
fn effect(line: &Line, device: &Device, what: InjectedFault) -> Option<String> {
    let (drive, InjectedFault::Motion(fault)) = (device.drive()?, what) else { return None };
    let about = fault.about_drive()?;
    Some(match drive.fault {
        Some(signal) => format!("{about} Then {} is on.", line.input_text(device.owner, signal)),
        None => {
            format!("{about} It has no fault signal in the description: its station loses it then, as a lost device.")
        }
    })
}

/// Names as they are read apart, whatever is in them.
pub(super) fn quoted<'n>(names: impl Iterator<Item = &'n str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Each device, and what is written to it.
fn orders<'a>(line: &'a Line, args: &FailArgs) -> miette::Result<Vec<(&'a Device, ObjectWrites)>> {
    let what = args.what;
    if args.operation.is_some() {
        let fault = what.of_a_motion().ok_or_else(|| wrong_option(args))?;
        let (device, sub) = moving(line, args)?;
        is_meant(device, args)?;
        if let Some(fault) = fault.filter(|fault| device.drive().is_some() && !MotionFault::OF_DRIVE.contains(fault)) {
            let can = MotionFault::OF_DRIVE.map(MotionFault::name).join(" or ");
            return Err(miette!(
                "a motion of drive {} can {can}, not {}: a drive moves to a position of its own, not along a simulated mechanism",
                device.name,
                fault.name()
            ));
        }
        if fault == Some(MotionFault::Break) && device.drive().is_none() && !has_fault_signal(line, args)? {
            return Err(no_fault_signal(line, args));
        }
        if let Some(fault @ (MotionFault::Miss | MotionFault::Drop)) = fault
            && !closes_a_gripper(line, args)?
        {
            return Err(no_gripper(line, args, fault));
        }
        return Ok(vec![(device, vec![((FAULT_INDEX, sub), fault.map_or(0, MotionFault::code))])]);
    }
    let owner = owner(line, args)?;
    if let Some(name) = &args.input {
        let fault = what.of_an_input().ok_or_else(|| wrong_option(args))?;
        let (device, bit) = input(line, owner, &args.station, name)?;
        is_meant(device, args)?;
        return Ok(vec![(device, InputFault::orders(bit, fault))]);
    }
    let orders = what.of_a_device().ok_or_else(|| needs(line, owner, args))?;
    let named = |device: &&Device| args.device.as_ref().is_none_or(|name| device.name == *name);
    let mut devices: Vec<&Device> = line.devices_of(owner).filter(named).collect();
    if devices.is_empty() {
        let known = quoted(line.devices_of(owner).map(|device| device.name.as_str()));
        let name = args.device.as_deref().unwrap_or_default();
        let error = miette!("{} has no device `{name}`; it has {known}", args.station);
        return Err(load::or_meant(error, name, line.devices_of(owner).map(|device| device.name.as_str())));
    }
    match what {
        // What takes no faults has none.
        InjectedFault::Clear if args.device.is_none() => {
            devices.retain(|device| device.modbus().is_some() || device.node_id().is_some());
        }
        _ => devices.truncate(1),
    }
    Ok(devices.into_iter().map(|device| (device, orders.clone())).collect())
}

/// An operation or an input is of one device: another one cannot be asked for.
fn is_meant(device: &Device, args: &FailArgs) -> miette::Result<()> {
    match args.device.as_deref().filter(|named| *named != device.name) {
        None => Ok(()),
        Some(named) => {
            let of = match (&args.operation, &args.input) {
                (Some(operation), _) => format!("the output that moves `{operation}`"),
                (None, input) => format!("the input `{}`", input.as_deref().unwrap_or_default()),
            };
            Err(miette!(
                help = "leave --device out; without --operation and --input a fault is one of the whole device",
                "{of} of {} is on device `{}`, not on `{named}`",
                args.station,
                device.name
            ))
        }
    }
}

fn owner(line: &Line, args: &FailArgs) -> miette::Result<Owner> {
    match args.station.as_str() {
        "console" => Ok(Owner::Console),
        name => load::station(line, name).map(Owner::Station),
    }
}

/// The device that an input is wired to, and its bit there.
fn input<'a>(line: &'a Line, owner: Owner, of: &str, name: &str) -> miette::Result<(&'a Device, u8)> {
    let inputs = match owner {
        Owner::Station(id) => &line.station(id).inputs,
        Owner::Console => &line.console.inputs,
    };
    let known = || quoted(inputs.iter().map(String::as_str));
    let at = inputs.iter().position(|input| input == name);
    let at = InputId::at(at.ok_or_else(|| {
        load::or_meant(
            miette!("{of} has no input `{name}`; it has {}", known()),
            name,
            inputs.iter().map(String::as_str),
        )
    })?);
    for device in line.devices_of(owner) {
        if let Some(bit) = device.input_bits().iter().position(|bound| *bound == Some(at)) {
            return Ok((device, u8::try_from(bit).into_diagnostic()?));
        }
        if device.carried_inputs().contains(&at) {
            let (device, kind) = (&device.name, &device.kind);
            return Err(match kind {
                // Each of its inputs is a bit.
                DeviceKind::Modbus(_) => continue,
                DeviceKind::Drive(..) => {
                    miette!(
                        "`{name}` follows from the position of drive {device}: make a motion fail, with --operation"
                    )
                }
                DeviceKind::Io(..) => {
                    miette!("`{name}` is a limit of an analogue input of {device}: hold its number, object 5F04h")
                }
                DeviceKind::Frames(_) => {
                    miette!("`{name}` comes in a frame of {device}, which takes no faults")
                }
            });
        }
    }
    Err(miette!(
        help = "an input is bound to a device by its name, in `inputs` of a [[device]]",
        "no device has the input `{name}` of {of}"
    ))
}

/// The device that drives an operation, and the subindex of its fault object: output bit + 1.
fn moving<'a>(line: &'a Line, args: &FailArgs) -> miette::Result<(&'a Device, u8)> {
    let (id, output) = motion(line, args)?;
    let name = args.operation.as_deref().unwrap_or_default();
    for device in line.devices_of(Owner::Station(id)) {
        if let Some(bit) = device.output_bits().iter().position(|bound| *bound == Some(output)) {
            return Ok((device, u8::try_from(bit + 1).into_diagnostic()?));
        }
        // The motions of a drive are counted as the outputs that move it.
        if let Some(motion) = device.drive().and_then(|drive| drive.motions().position(|own| own == output)) {
            return Ok((device, u8::try_from(motion + 1).into_diagnostic()?));
        }
    }
    Err(miette!(
        help = "faults can be given to motions of devices with simulated outputs: CANopen and Modbus I/O, and drives",
        "no device of {} that takes faults drives `{name}`",
        args.station
    ))
}

#[cfg(test)]
pub(super) const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/line.toml");

#[cfg(test)]
mod tests {
    use linewright_line::{Operation, OperationModule};
    use linewright_plant::PRESS_INDEX;

    use super::*;

    pub(in crate::can) use super::C1;
    const DRIVES: &str = include_str!("../../../model/line/tests/descriptions/drives.toml");

    pub fn args(station: &str, what: InjectedFault) -> FailArgs {
        FailArgs {
            line: PathBuf::new(),
            station: station.to_owned(),
            what,
            operation: None,
            recovery: false,
            input: None,
            device: None,
            bus: None,
        }
    }

    #[test]
    fn an_input_is_stuck_by_its_name_and_clear_without_a_name_is_for_every_device() {
        let text = linewright_line::TransferLine::default().text();
        let inputs = "\"LS_closed\", \"low_pressure\"";
        assert!(text.contains(inputs), "the shipped line has changed");
        let text = text.replace(inputs, "\"LS_closed\", \"\"");
        let second =
            "\n[[device]]\nname = \"clamp 1 more\"\nstation = \"clamp_1\"\nnode = 0x2F\ninputs = [\"low_pressure\"]\n";
        let line = linewright_line::parse("line.toml", &(text + second)).expect("it parses").line;
        let at = |station: &str, name: &str, what| {
            let args = FailArgs { input: Some(name.to_owned()), ..args(station, what) };
            orders(&line, &args).map(|found| found.into_iter().map(|(d, o)| (d.name.clone(), o)).collect::<Vec<_>>())
        };
        let stuck = InjectedFault::Input(InputFault::StuckOff);
        let first = |wanted: ObjectWrites, device: &str| vec![(device.to_owned(), wanted)];
        let closed = at("clamp_1", "LS_closed", stuck).expect("a switch");
        assert_eq!(closed, first(vec![((PRESS_INDEX, 2), 0)], "clamp 1 io"));
        let freed = at("clamp_1", "low_pressure", InjectedFault::Clear).expect("a switch of the second device");
        assert_eq!(freed, first(vec![((PRESS_INDEX, 1), 2)], "clamp 1 more"));
        let console = line.console.inputs[0].clone();
        assert_eq!(at("console", &console, stuck).expect("an input of the console").len(), 1);
        let unknown = at("clamp_1", "LS_shut", stuck).expect_err("there is none").to_string();
        assert!(unknown.starts_with("clamp_1 has no input `LS_shut`; it has `LS_open`, "), "{unknown}");
        assert!(unknown.contains("`low_pressure`"), "{unknown}");
        let all = orders(&line, &args("clamp_1", InjectedFault::Clear)).expect("all of them");
        let names: Vec<&str> = all.iter().map(|(device, _)| device.name.as_str()).collect();
        assert_eq!(names, ["clamp 1 io", "clamp 1 more"]);
        assert!(all.iter().all(|(_, orders)| *orders == [CLEAR]));
        let error = |args: &FailArgs| orders(&line, args).expect_err("it is refused");
        let help = |error: &miette::Report| error.help().map(|help| help.to_string()).unwrap_or_default();
        let bare = error(&args("clamp_1", stuck));
        assert_eq!(bare.to_string(), "stuck-off needs --input, with the name of an input of clamp_1");
        assert!(help(&bare).contains("`LS_open`, `LS_closed`, "), "{bare:?}");
        let operation = Some("advancex clamp".to_owned());
        let meant = FailArgs { operation, ..args("clamp_1", InjectedFault::Motion(MotionFault::Stick)) };
        assert_eq!(help(&error(&meant)), "did you mean `advance clamp`?");
    }

    #[test]
    fn each_motion_of_a_drive_has_a_fault_of_its_own() {
        let line = linewright_line::parse("drives.toml", DRIVES).expect("it parses").line;
        let station = line.stations[0].name.clone();
        let drive = line.devices.iter().find(|device| device.drive().is_some()).expect("a drive");
        let outputs: Vec<_> = drive.drive().expect("a drive").motions().collect();
        let driven = line.stations[0].operations.iter().filter(|op| outputs.contains(&op.normal.actuator));
        let mut subs = Vec::new();
        for operation in driven {
            let stick = InjectedFault::Motion(MotionFault::Stick);
            let args = FailArgs { operation: Some(operation.name.clone()), ..args(&station, stick) };
            let (device, orders) = orders(&line, &args).expect("it can stick").remove(0);
            let [((FAULT_INDEX, sub), 1)] = orders[..] else { panic!("{orders:X?}") };
            assert_eq!((&device.name, outputs[usize::from(sub) - 1]), (&drive.name, operation.normal.actuator));
            subs.push(sub);
        }
        subs.dedup();
        assert!(subs.len() > 1, "{subs:?}");
        let driven = |operation: &&Operation| outputs.contains(&operation.normal.actuator);
        let first = line.stations[0].operations.iter().find(driven).expect("one").name.clone();
        let slips = InjectedFault::Motion(MotionFault::SlipBack);
        let args = FailArgs { operation: Some(first), ..args(&station, slips) };
        let refused = orders(&line, &args).expect_err("a drive has no such fault").to_string();
        assert!(refused.contains("can stick or break, not slip-back: "), "{refused}");
    }

    #[test]
    fn a_fault_of_a_drive_says_what_it_does_and_which_signal_shows_it() {
        let text = include_str!("../../../examples/driven-table.toml");
        let line = linewright_line::parse("driven-table.toml", text).expect("it parses").line;
        let drive = line.devices.iter().find(|device| device.drive().is_some()).expect("one");
        let broken = effect(&line, drive, InjectedFault::Motion(MotionFault::Break)).expect("a drive breaks");
        assert!(broken.contains("at rest as well") && broken.contains("Then drive_fault ("), "{broken}");
        assert_eq!(effect(&line, drive, InjectedFault::Clear), None);
        let other = line.devices.iter().find(|device| device.drive().is_none()).expect("one");
        assert_eq!(effect(&line, other, InjectedFault::Motion(MotionFault::Break)), None);
    }

    /// It would act as stick, and be called something else.
    #[test]
    fn a_motion_without_a_fault_signal_does_not_break() {
        let text = linewright_line::TransferLine::default().text();
        let mut line = linewright_line::parse("line.toml", &text).expect("it parses").line;
        for operation in &mut line.stations[1].operations {
            operation.normal.fault = None;
            if let OperationModule::Reversible { recovery, .. } = &mut operation.module {
                recovery.fault = None;
            }
        }
        let broken = |operation: &Operation, station: &str| {
            let what = InjectedFault::Motion(MotionFault::Break);
            orders(&line, &FailArgs { operation: Some(operation.name.clone()), ..args(station, what) }).map(drop)
        };
        let all = || line.stations.iter().flat_map(|station| station.operations.iter().map(move |op| (station, op)));
        let mut refused = 0;
        for (station, operation) in all() {
            let outcome = broken(operation, &station.name);
            if operation.normal.fault.is_some() {
                outcome.expect("its signal comes on");
            } else if let Err(why) = outcome {
                assert!(why.to_string().ends_with("has no fault signal that could come on: it cannot break"), "{why}");
                assert!(why.help().is_some_and(|help| help.to_string().starts_with("`stick`")));
                refused += 1;
            }
        }
        assert!(refused > 0);
    }
}
