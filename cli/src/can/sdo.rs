//! `can sdo`: one object of one node, read or written.
//!
//! Beside a manager this is safe as long as it is not just configuring that node: a device has one SDO channel, and two
//! clients on it disturb each other. Both sides notice, and report it.

use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, Subcommand};
use linewright_canopen::NodeId;
use linewright_canopen::sdo::{ObjectId, TransferOptions};
use linewright_fieldbus::{Bus, sdo_client};
use miette::{IntoDiagnostic, miette};

use super::node;
use super::value::{ValueKind, guess};

#[derive(Debug, Subcommand)]
pub enum SdoCommand {
    /// Read an object.
    Read(ReadArgs),
    /// Write an object.
    Write(WriteArgs),
}

#[derive(Debug, Args)]
struct SdoTarget {
    /// The node id.
    #[arg(value_parser = node)]
    node: NodeId,
    /// The object in hexadecimal, as in 1018:01 or 1008.
    object: ObjectId,
    /// Time limit of each answer, in ms.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(10..=60_000))]
    timeout: u64,
}

impl SdoTarget {
    fn options(&self) -> TransferOptions {
        TransferOptions { timeout: Duration::from_millis(self.timeout), ..TransferOptions::default() }
    }
}

#[derive(Debug, Args)]
pub struct ReadArgs {
    #[command(flatten)]
    whose: SdoTarget,
    /// Type of the value [default: shown as every likely type].
    #[arg(long = "type", value_enum)]
    kind: Option<ValueKind>,
}

#[derive(Debug, Args)]
pub struct WriteArgs {
    #[command(flatten)]
    whose: SdoTarget,
    /// The value.
    #[arg(allow_hyphen_values = true)]
    value: String,
    /// Type of the value. Required: a device refuses a number of another length.
    #[arg(long = "type", value_enum)]
    kind: ValueKind,
}

pub async fn run(bus: &mut Bus, command: &SdoCommand) -> miette::Result<ExitCode> {
    match command {
        SdoCommand::Read(args) => {
            let bytes = read(bus, &args.whose).await?;
            let shown = match args.kind {
                Some(kind) => kind.text(&bytes).map_err(|why| miette!("object {}: {why}", args.whose.object))?,
                None => guess(&bytes),
            };
            crate::out::say!("{shown}");
        }
        SdoCommand::Write(args) => {
            let bytes = args.kind.bytes(&args.value).map_err(|why| miette!("{why}"))?;
            write(bus, &args.whose, &bytes).await?;
            crate::out::say!("node {}: {} written", args.whose.node, args.whose.object);
        }
    }
    Ok(ExitCode::SUCCESS)
}

async fn read(bus: &mut Bus, whose: &SdoTarget) -> miette::Result<Vec<u8>> {
    sdo_client::read(bus, whose.node, whose.object, whose.options()).await.into_diagnostic()
}

async fn write(bus: &mut Bus, whose: &SdoTarget, bytes: &[u8]) -> miette::Result<()> {
    sdo_client::write(bus, whose.node, whose.object, bytes, whose.options()).await.into_diagnostic()
}
