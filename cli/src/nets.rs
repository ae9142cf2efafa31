//! `linewright nets`: the nets that follow from a description, for other tools.
//!
//! One file per station and one for the mode decision. They are the bare nets: a controller fires a transition only if
//! its condition holds as well, and conditions have no place in PNML.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use linewright_coordinator_logic::decision;
use linewright_line::net::StationNet;
use linewright_nets::{Net, dot};
use miette::{IntoDiagnostic, WrapErr};

use crate::load;

/// Write the nets of a line: one of each station, and the mode decision's.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Where to write them; made if it is not there. Files of the same names are written over.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How to write them.
    #[arg(long, value_enum, default_value_t = Format::Pnml)]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Nets for analysis, by `linewright analyse` or another tool.
    Pnml,
    /// Drawings for GraphViz.
    Dot,
}

impl Format {
    fn of(self, net: &Net) -> (&'static str, String) {
        match self {
            Format::Pnml => ("pnml", linewright_pnml::write(net)),
            Format::Dot => ("dot", dot(net)),
        }
    }
}

/// `linewright nets`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, false)?;
    let dir = &args.out;
    std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
    for id in line.station_ids() {
        write(args, &line.station(id).name, StationNet::of(&line, id).net())?;
    }
    // A station's name has no dash in it, so this is none of theirs.
    write(args, "mode-decision", &decision::net())?;
    Ok(ExitCode::SUCCESS)
}

fn write(args: &Args, name: &str, net: &Net) -> miette::Result<()> {
    let (extension, text) = args.format.of(net);
    let file: &Path = &args.out.join(format!("{name}.{extension}"));
    std::fs::write(file, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", file.display()))?;
    crate::out::say!("wrote {}: {} places, {} transitions", file.display(), net.place_count(), net.transition_count());
    Ok(())
}
