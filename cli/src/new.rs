//! `linewright new`: writes the description of a new line, to be read and changed by hand.
//!
//! The text comes from [`linewright_line::TransferLine`]; this module only decides where it goes, and never writes over
//! a description that somebody may have changed unless told to.

use std::fs::{OpenOptions, create_dir_all};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use linewright_line::TransferLine;
use miette::{IntoDiagnostic, WrapErr, miette};

/// Write the description of a new line.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    kind: NewKind,
}

#[derive(Debug, Subcommand)]
enum NewKind {
    /// A transfer bar with a number of clamp-and-mill pairs along it.
    TransferLine(TransferLineArgs),
}

#[derive(Debug, clap::Args)]
struct TransferLineArgs {
    /// How many clamp-and-mill pairs, 1 to 23.
    #[arg(long, default_value_t = 1, value_parser = machines)]
    machines: usize,
    /// What every duration is multiplied with, 0.01 to 1000; watchdogs stay at one second or above.
    #[arg(long, default_value_t = 1.0, value_parser = time_scale)]
    time_scale: f64,
    /// Where to write `line.toml`; made if it is not there.
    #[arg(long, default_value = "transfer-line")]
    dir: PathBuf,
    /// Write over a description that is there already.
    #[arg(long)]
    force: bool,
}

fn machines(word: &str) -> Result<usize, String> {
    let most = TransferLine::MACHINES_MAX;
    match word.parse() {
        Ok(machines) if (1..=most).contains(&machines) => Ok(machines),
        Ok(_) | Err(_) => Err(format!("a transfer line has 1 to {most} machines")),
    }
}

fn time_scale(word: &str) -> Result<f64, String> {
    let bounds = TransferLine::TIME_SCALE;
    match word.parse() {
        Ok(scale) if bounds.contains(&scale) => Ok(scale),
        Ok(_) | Err(_) => Err(format!("a time scale is a number from {} to {}", bounds.start(), bounds.end())),
    }
}

/// `linewright new`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let NewKind::TransferLine(args) = &args.kind;
    let line = TransferLine { machines: args.machines, time_scale: args.time_scale };
    let file = args.dir.join("line.toml");
    create_dir_all(&args.dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", args.dir.display()))?;
    write(&file, &line.text(), args.force)?;
    let dir = args.dir.display();
    crate::out::say!("wrote {}: {} stations", file.display(), 1 + 2 * args.machines);
    crate::out::say!("next:  linewright check {dir}");
    crate::out::say!("       linewright simulate {dir}");
    crate::out::say!("       linewright run {dir}");
    Ok(ExitCode::SUCCESS)
}

fn write(file: &Path, text: &str, force: bool) -> miette::Result<()> {
    let mut options = OpenOptions::new();
    // `create_new` leaves no moment between looking for the file and making it.
    if force {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    let name = file.display();
    match options.write(true).open(file) {
        Ok(mut open) => {
            open.write_all(text.as_bytes()).into_diagnostic().wrap_err_with(|| format!("cannot write {name}"))
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            Err(miette!(help = "--force writes over it; --dir writes elsewhere", "{name} is there already"))
        }
        Err(error) => Err(error).into_diagnostic().wrap_err_with(|| format!("cannot write {name}")),
    }
}
