//! The commands on a CAN bus: `can …`, `fail`, `part` and `candump`.
//!
//! On a kernel with CAN the stock tools do some of this as well, and work beside it; these work on the virtual bus too,
//! and use CANopen and the line's description. None of them is a manager: a manager's orders meanwhile stand.

mod fail;
mod injected;
mod log;
mod nmt;
mod part;
mod scan;
mod sdo;
mod simulated;
mod status;
mod value;

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::{Args, Subcommand};
use linewright_canopen::NodeId;
use linewright_fieldbus::{Bus, BusDirectory, BusOptions, find_bus, place};
use linewright_line::Line;
use linewright_node_shell::{RosArgs, RunName, bus_managed_by, lines_managing, names};
use miette::{IntoDiagnostic, miette};

use crate::client::OperatorClient;
use crate::nodes::DEFAULT_BUS;

pub use fail::{FailArgs, fail};
pub use log::{DumpArgs, dump};
pub use part::{PartArgs, part};

/// What keeps a command from another line's bus.
const SEPARATE_LINES: &str = "is this line running? --bus names its bus, as at its start. Lines on one machine have buses of their own if \
     each is started without LINEWRIGHT_BUS_DIR, or with a directory of its own in it, which its commands need too; runs of one line \
     are told apart by ROS_DOMAIN_ID";

/// Look at a CAN bus and its CANopen nodes, and talk to them.
#[derive(Debug, Args)]
pub struct CanArgs {
    /// The CAN interface, or the virtual bus of that name where the kernel has none [default: vcan0; with a line the one that its
    /// coordinator has on this machine, if it runs].
    #[arg(long, global = true)]
    bus: Option<String>,
    #[command(subcommand)]
    command: CanCommand,
}

#[derive(Debug, Subcommand)]
enum CanCommand {
    /// List the nodes of the bus: profile, identity, name, state.
    Scan(scan::ScanArgs),
    /// Listen, and show the state of each device of a line.
    Status(status::StatusArgs),
    /// Send an NMT command to a node, or to all, and show the state that follows.
    Nmt(nmt::NmtArgs),
    /// Read or write an object of a node.
    #[command(subcommand)]
    Sdo(sdo::SdoCommand),
    /// Show every frame with its description.
    Monitor(log::MonitorArgs),
    /// Record the bus in the form of `candump -L`.
    Record(log::RecordArgs),
    /// Send a record at its own pace.
    Replay(log::ReplayArgs),
}

/// `linewright can`
pub async fn run(args: CanArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let bus = args.bus.as_deref();
    let open = || open(bus.unwrap_or(DEFAULT_BUS), None);
    match &args.command {
        CanCommand::Scan(args) => scan::run(&mut open()?, args).await,
        // The line has its buses.
        CanCommand::Status(status) => status::run(bus, status, ros).await,
        CanCommand::Nmt(args) => nmt::run(&mut open()?, args).await,
        CanCommand::Sdo(command) => sdo::run(&mut open()?, command).await,
        CanCommand::Monitor(monitor) => {
            let line = monitor.line()?;
            let interface = line_bus(bus, line.as_ref(), ros);
            let of_run = line.as_ref().map(|line| run_of(line, ros)).transpose()?;
            let mut bus = self::open(&interface, of_run.as_deref())?;
            log::monitor(&mut bus, &interface, line.as_ref(), monitor).await
        }
        CanCommand::Record(args) => log::record(&mut open()?, args).await,
        CanCommand::Replay(args) => log::replay(&mut open()?, args).await,
    }
}

/// The interface of a line's bus: the one that was named, or that its coordinator manages on this machine.
fn line_bus(named: Option<&str>, line: Option<&Line>, ros: &RosArgs) -> String {
    let managed = || bus_managed_by(ros, &format!("/{}", line?.name), "coordinator");
    named.map(str::to_owned).or_else(managed).unwrap_or_else(|| DEFAULT_BUS.to_owned())
}

/// Opens a bus and prints on standard error which it is: virtual buses of one name may exist in several directories. Of
/// these the one of run `run`, if there is one; never that of another line.
fn open(name: &str, run: Option<&str>) -> miette::Result<Bus> {
    let mut found = find_bus(name, None);
    if let Some(run) = run {
        let own = find_bus(name, Some(run));
        let of_line =
            |found: &BusDirectory| found.about.as_deref().is_none_or(|about| RunName::is_same_line(about, run));
        let (own, others) = if own.is_empty() { found.into_iter().partition(of_line) } else { (own, Vec::new()) };
        if let Some(about) = others.first().and_then(|other| other.about.as_deref()).filter(|_| own.is_empty()) {
            return Err(other_line(name, about, run));
        }
        found = own;
    }
    let options = options(name, found)?;
    if let Some(run) = run {
        let managing = lines_managing(name, &place(name, &options));
        if let Some(other) = managing.first().filter(|_| !managing.iter().any(|line| RunName::is_same_line(line, run)))
        {
            return Err(other_line(name, other, run));
        }
    }
    let bus = Bus::open(name, &options).into_diagnostic()?;
    crate::out::complain!("{}", bus.describe());
    Ok(bus)
}

/// The bus of this name is another line's.
fn other_line(bus: &str, theirs: &str, run: &str) -> miette::Report {
    miette!(help = SEPARATE_LINES, "bus {bus} is that of {theirs}, and this command is for {run}")
}

/// Options for the virtual bus `name`, which was found in these directories.
fn options(name: &str, found: Vec<BusDirectory>) -> miette::Result<BusOptions> {
    if let [first, _, ..] = &*found {
        let line = |found: &BusDirectory| {
            format!(
                "  LINEWRIGHT_BUS_DIR={}  {}",
                found.dir.display(),
                found.about.as_deref().unwrap_or("shared by all")
            )
        };
        let lines: Vec<String> = found.iter().map(line).collect();
        return Err(miette!(
            "there are {} virtual buses '{name}'; say which by the environment, e.g. LINEWRIGHT_BUS_DIR={}:\n{}",
            found.len(),
            first.dir.display(),
            lines.join("\n")
        ));
    }
    Ok(BusOptions { dir: found.into_iter().next().map(|found| found.dir), ..BusOptions::default() })
}

/// Name of a run of a line in its bus directory.
pub fn run_of(line: &Line, ros: &RosArgs) -> miette::Result<String> {
    let namespace = names::identify(&ros.remaps, &format!("/{}", line.name), "coordinator").into_diagnostic()?.0;
    Ok(RunName::of(&namespace, ros.domain_id))
}

/// What of a line that runs on this machine was started with another description than the one that was read. Nothing where that
/// is not heard: the command itself is done.
async fn started_with_another(line: &Line, path: &Path, ros: &RosArgs) -> Vec<String> {
    const HEARD_WITHIN: Duration = Duration::from_secs(2);
    if bus_managed_by(ros, &format!("/{}", line.name), "coordinator").is_none() {
        return Vec::new();
    }
    let Ok(mut client) = OperatorClient::open(line, path, ros, "fail") else { return Vec::new() };
    match client.until_all_heard(HEARD_WITHIN).await {
        Ok(_) => client.other_descriptions(),
        Err(_) => Vec::new(),
    }
}

fn since_epoch() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// A node id as it is written: `4`, `0x04` or `04h`.
fn node(text: &str) -> Result<NodeId, String> {
    let number = match text.strip_prefix("0x").or_else(|| text.strip_suffix('h')) {
        Some(hex) => u8::from_str_radix(hex, 16).ok(),
        None => text.parse().ok(),
    };
    number.and_then(NodeId::new).ok_or_else(|| format!("'{text}' is no node id; they run from 1 to 127"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_ids_are_read_in_each_form() {
        assert_eq!(node("4").map(NodeId::get), Ok(4));
        assert_eq!(node("0x7F").map(NodeId::get), Ok(127));
        assert_eq!(node("11h").map(NodeId::get), Ok(17));
        for text in ["0", "128", "-1", "x", "0x80", "80h", "h", "0x11h", ""] {
            assert!(node(text).is_err(), "{text}");
        }
    }
}
