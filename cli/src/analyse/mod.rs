//! `linewright analyse`: properties of any place/transition net, read from PNML.
//!
//! Structure comes first, because it answers at once whatever the size and proves its answers; then the markings are
//! played out as far as allowed; and a net that may be unbounded gets a coverability graph. The analyses are those of
//! [`linewright_nets`]: this command chooses among them ([`decide`]), puts their answers together ([`report`]) and
//! shows them. The rest is reported as undecided.

mod decide;
mod export;
mod open;
mod plays;
mod report;
mod show;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use linewright_nets::explicit::ExplorationLimits;
use miette::miette;

use crate::out::{self, say};

/// States explored by default.
const STATES: u64 = 64_000_000;

/// Megabytes for a search by default.
const MEGABYTES: usize = 1024;

/// Analyse a place/transition net: bounded, live, reversible, deadlocks, invariants.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The format of --graph follows from the name: .dot, .json, or .aut (Aldebaran, for model checkers)."
)]
pub struct Args {
    /// The net, a PNML file.
    file: PathBuf,
    /// Id of the net in the file; required if there are several.
    #[arg(long, value_name = "ID")]
    net: Option<String>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Write the reachability graph.
    #[arg(long, value_name = "FILE")]
    graph: Option<PathBuf>,
    /// Write the net as a GraphViz drawing.
    #[arg(long, value_name = "FILE")]
    dot: Option<PathBuf>,
    /// Write a certificate: what structure proves, with the evidence.
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,
    /// Most states to explore [default: 64 million].
    #[arg(long, value_name = "N")]
    states: Option<u64>,
    /// Most memory for states, in MB [default: 1024].
    #[arg(long, value_name = "MB")]
    memory: Option<usize>,
    /// Threads of the search [default: one for each core]. The answers do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

impl Args {
    fn limits(&self) -> ExplorationLimits {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        ExplorationLimits {
            states: self.states.unwrap_or(STATES),
            bytes: self.memory.unwrap_or(MEGABYTES).saturating_mul(1 << 20),
            threads: self.threads.unwrap_or_else(cores).clamp(1, 64),
        }
    }

    /// Whether the user gave limits, so that the search is not cut short.
    fn insists(&self) -> bool {
        self.states.is_some() || self.memory.is_some()
    }
}

/// `linewright analyse`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let start = Instant::now();
    // Before anything is looked at: a search may take long.
    let graph =
        args.graph.as_deref().map(|file| export::GraphFormat::of(file).map(|format| (file, format))).transpose()?;
    let net = match open::net(&args.file, args.net.as_deref()) {
        Ok(net) => net,
        Err(error) if args.json => {
            out::json(&open::problems(&error))?;
            return Ok(ExitCode::FAILURE);
        }
        Err(error) => return Err(error),
    };
    if let Some(file) = &args.dot {
        export::text(file, &linewright_nets::dot(&net))?;
    }
    let findings = decide::decide(&net, &args.limits(), args.insists());
    if let Some(contradiction) = &findings.contradiction {
        return Err(miette!(
            help = "this is a mistake of the program: please report it, with the file",
            "the analyses contradict each other: {contradiction}"
        ));
    }
    let seconds = start.elapsed().as_secs_f64();
    let report = report::report(&net, &findings, seconds);
    if args.json {
        out::json(&report)?;
    } else {
        say!("{}", show::text(&report).trim_end());
    }
    // Written after the answers, so that a failure does not hide them.
    if let Some(file) = &args.certificate {
        export::certificates(file, &net, &findings)?;
    }
    if let Some((file, format)) = graph {
        export::graph(file, format, &net, &args.limits())?;
    }
    Ok(ExitCode::SUCCESS)
}
