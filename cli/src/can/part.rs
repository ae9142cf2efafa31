//! `part`: takes a part out of the simulated plant, or puts one in, over CAN.
//!
//! The request is written to a simulated I/O device of the bus that the place is on. All simulated devices of a bus share one plant, so that any of
//! them will do. The outcome is read from the same device.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use linewright_line::{Device, DeviceBus, DeviceKind, Line};
use linewright_node_shell::RosArgs;
use linewright_plant::{NestPosition, PartByHand, PartRefusal, station_of};
use miette::miette;

use super::simulated::SimulatedDevice;
use crate::load;

/// Take a part out of the simulated plant, or put one in.
#[derive(Debug, Args)]
#[command(
    after_help = "A place is a holder of the description: `station.holder`, or one of the line. What an alarm asks people to do is \
                        done so: `part LINE take --at m1.clamp`. A part can be pulled out of a closed gripper, and not out of a closed \
                        clamp. Of the cell's own account of its parts nothing is changed: answer the alarm."
)]
pub struct PartArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// What is done.
    what: PartDeed,
    /// Place of the part: the name of a holder.
    #[arg(long, value_name = "PLACE")]
    at: String,
    /// The position there, from 1; needed where there are several.
    #[arg(long)]
    position: Option<u16>,
    /// The CAN interface of the line's bus [default: the one that its coordinator has on this machine, if it runs, else vcan0].
    #[arg(long)]
    bus: Option<String>,
}

/// What is done with a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PartDeed(PartByHand);

impl ValueEnum for PartDeed {
    fn value_variants<'a>() -> &'a [Self] {
        &[PartDeed(PartByHand::Take), PartDeed(PartByHand::Put)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.about().trim_end_matches('.')))
    }
}

/// `linewright part`
pub async fn part(args: PartArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let place = place(&line, &args.at, args.position)?;
    let PartDeed(what) = args.what;
    let refused = |why: PartRefusal| miette!("{}", why.text(&line, place));
    let (object, value) = what.order(place).map_err(refused)?;
    let device = device(&line, place)?;
    let bus = super::line_bus(args.bus.as_deref(), Some(&line), ros);
    let mut reached = SimulatedDevice::reach(&line, &bus, ros, device).await?;
    reached.write(device, object, value).await?;
    match reached.part_outcome(device).await? {
        0 => crate::out::say!("{}", what.done(&line, place)),
        code => return Err(PartRefusal::from_code(code).map_or_else(|| miette!("refused, with code {code}"), refused)),
    }
    for text in super::started_with_another(&line, &args.line, ros).await {
        crate::out::complain!("{text}");
    }
    Ok(ExitCode::SUCCESS)
}

/// The place that is meant.
fn place(line: &Line, name: &str, position: Option<u16>) -> miette::Result<NestPosition> {
    let names = || line.handling.holders.iter().map(|holder| holder.name.as_str());
    let Some(nest) = line.handling.holder_named(name) else {
        let known = super::fail::quoted(names());
        if known.is_empty() {
            return Err(miette!(
                help = "parts lie in holders: `[[holder]]` and `[[station.holder]]`",
                "{} describes no place for parts",
                line.name
            ));
        }
        return Err(load::or_meant(miette!("no place for parts is called `{name}`; there are {known}"), name, names()));
    };
    let places = line.handling.holder(nest).places;
    match position {
        None if places > 1 => {
            Err(miette!(help = format!("--position 1 to {places}"), "`{name}` has {places} positions: which one?"))
        }
        position => Ok(NestPosition { nest, position: position.unwrap_or(1) }),
    }
}

/// A device of the bus on whose plant the place is.
fn device(line: &Line, place: NestPosition) -> miette::Result<&Device> {
    let bus = station_of(line, place.nest).map_or(&DeviceBus::Line, |station| &line.station(station).bus);
    let is_io = |device: &&Device| matches!(device.kind, DeviceKind::Io(..)) && device.bus == *bus;
    line.devices.iter().find(is_io).ok_or_else(|| {
        miette!(
            help = "parts are taken and put by a CANopen I/O device of the bus of their station",
            "no such device is on the bus of `{}`",
            line.handling.holder(place.nest).name
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::fail::C1;
    use super::*;

    #[test]
    fn a_place_is_named_and_each_has_a_device_of_its_bus() {
        let line = linewright_line::parse("line.toml", C1).expect("it parses").line;
        let error = |name: &str, position| place(&line, name, position).expect_err("it is refused");
        let help = |error: &miette::Report| error.help().map(|help| help.to_string()).unwrap_or_default();
        let unknown = error("m1.clmp", None);
        assert_eq!(help(&unknown), "did you mean `m1.clamp`?");
        assert!(
            unknown.to_string().ends_with("there are `robot.hand`, `m1.clamp`, `m2.clamp`, `m3.clamp`, `ST`"),
            "{unknown}"
        );
        let several = error("ST", None);
        assert_eq!(
            (several.to_string().as_str(), help(&several).as_str()),
            ("`ST` has 6 positions: which one?", "--position 1 to 6")
        );
        for name in ["ST", "robot.hand", "m1.clamp"] {
            let place = place(&line, name, Some(1)).expect("it is there");
            assert!(device(&line, place).is_ok_and(|device| device.node_id().is_some()), "{name}");
        }
        let transfer = linewright_line::TransferLine::default().text();
        let transfer = linewright_line::parse("line.toml", &transfer).expect("it parses").line;
        let none = place(&transfer, "ST", None).expect_err("it has no holders").to_string();
        assert_eq!(none, "transfer_line describes no place for parts");
    }
}
