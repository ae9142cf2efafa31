//! `linewright nets`: the nets that follow from a description, for other tools.
//!
//! One file per station and one for the mode decision. They are the bare nets: a controller fires a transition only if
//! its condition holds as well, and conditions have no place in PNML. Of a flexible cell two: the net that is played, and
//! the same with starts and ends apart; both written out, with a place for each stage that parts can be in. Of one that can
//! be played a third: with error places, diagnosis and recoveries.

mod svg;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::ValueEnum;
use linewright_cell::net::{Detail, Supply};
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell, recovery_net};
use linewright_coordinator_logic::decision;
use linewright_line::net::{NetSheet, StationNet};
use linewright_line::{Line, Station};
use linewright_nets::coloured::{Colours, unfold};
use linewright_nets::{Net, dot};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::load;

/// At most so many places and transitions of a cell's net.
const NODES_MAX: usize = 1_000_000;

/// Write the nets of a line: one of each station, and the mode decision's; and of a flexible cell.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The directory of a line or a cell, or its description file.
    line: PathBuf,
    /// Directory to write to; created if missing. Files of the same names are overwritten.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Format of the files.
    #[arg(long, value_enum, default_value_t = NetFormat::Pnml)]
    format: NetFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NetFormat {
    /// Nets for analysis, by `linewright analyse` or another tool.
    Pnml,
    /// Drawings for GraphViz.
    Dot,
    /// Finished drawings, of a line's nets.
    Svg,
}

/// A net, and how it is drawn.
enum DrawnNet<'a> {
    /// A station's.
    Station(&'a Station, StationNet, NetSheet),
    /// One with its places in a ring.
    Ring(Net),
    /// By other tools.
    Plain(&'a Net),
}

impl DrawnNet<'_> {
    fn net(&self) -> &Net {
        match self {
            DrawnNet::Station(_, net, _) => net.net(),
            DrawnNet::Ring(net) => net,
            DrawnNet::Plain(net) => net,
        }
    }

    /// The file's extension and content.
    fn content(&self, format: NetFormat) -> miette::Result<(&'static str, String)> {
        let no_drawing =
            || miette!("net '{}' has no drawing: give --format dot, and draw it with GraphViz", self.net().name());
        Ok(match (format, self) {
            (NetFormat::Pnml, _) => ("pnml", linewright_pnml::write(self.net())),
            (NetFormat::Dot, _) => ("dot", dot(self.net())),
            (NetFormat::Svg, DrawnNet::Station(station, net, sheet)) => ("svg", svg::of_station(station, net, sheet)),
            (NetFormat::Svg, DrawnNet::Ring(net)) => {
                ("svg", svg::of_ring(net, &NetSheet::ring(net).ok_or_else(no_drawing)?))
            }
            (NetFormat::Svg, DrawnNet::Plain(_)) => return Err(no_drawing()),
        })
    }
}

/// `linewright nets`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let files = load::files_of(&args.line);
    let line = files.line.as_ref().map(|file| load::line(file, false)).transpose()?;
    let cell = files.cell.as_ref().map(|file| load::cell(file, line.as_ref())).transpose()?;
    let dir = &args.out;
    std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
    line.iter().try_for_each(|line| of_line(args, line))?;
    cell.iter().try_for_each(|parsed| of_cell(args, &parsed.cell))?;
    Ok(ExitCode::SUCCESS)
}

fn of_line(args: &Args, line: &Line) -> miette::Result<()> {
    for id in line.station_ids() {
        let net = StationNet::of(line, id);
        let sheet = NetSheet::of(line, id, &net);
        write(args, &line.station(id).name, &DrawnNet::Station(line.station(id), net, sheet))?;
    }
    // A station's name has no dash in it, so this is none of theirs, nor are the cell's.
    write(args, "mode-decision", &DrawnNet::Ring(decision::net()))
}

fn of_cell(args: &Args, cell: &linewright_cell::Cell) -> miette::Result<()> {
    for (name, detail) in [("cell-coordination", Detail::Coordination), ("cell-expanded", Detail::Expanded)] {
        let net = linewright_cell::net::net(cell, detail, Supply::Open).map_err(|errors| {
            let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
            miette!("the cell has no net: {}", errors.join("; "))
        })?;
        let long = unfold(net.net(), Colours::Reachable, NODES_MAX).into_diagnostic()?;
        write(args, name, &DrawnNet::Plain(long.net()))?;
    }
    // Without reservations the cell is not played, and needs no recovery net.
    let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
    let Ok(made) = compile_cell(cell, None, Supply::Open, pace) else { return Ok(()) };
    let recovery = recovery_net(&format!("{} with what fails", cell.name), &made.table).map_err(|errors| {
        let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
        miette!("the cell has no net with what fails: {}", errors.join("; "))
    })?;
    write(args, "cell-recovery", &DrawnNet::Plain(&recovery.net))
}

fn write(args: &Args, name: &str, drawn: &DrawnNet) -> miette::Result<()> {
    let (extension, text) = drawn.content(args.format)?;
    let net = drawn.net();
    let file: &Path = &args.out.join(format!("{name}.{extension}"));
    std::fs::write(file, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", file.display()))?;
    crate::out::say!("wrote {}: {} places, {} transitions", file.display(), net.place_count(), net.transition_count());
    Ok(())
}
