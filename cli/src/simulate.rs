//! `linewright simulate`: the bar chart that the line's own controllers produce, in virtual time; and of a flexible cell
//! ([`cell`]) when each part is done.
//!
//! The real station controllers and the real mode controller run against the simulated plant; [`linewright_simulation`]
//! plays them, and this command reads the files, shows what came out and decides the exit code: 0 if the cycles are
//! done, the scenario went as it expected and no conflict happened; 1 otherwise, with the reason.

mod cell;
mod chart;
mod json;
mod report;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use linewright_line::Line;
use linewright_simulation::cell::{PRECISION_PERCENT, REPLICATIONS_MAX};
use linewright_simulation::{LineSim, Network, RunEnd, RunGoal, Scenario, SimOptions};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::out::{self, say};
use crate::parts::PartList;
use crate::{files, load};
use report::SimulationReport;

/// A scenario may be this large.
const SCENARIO_BYTES_MAX: usize = 1 << 20;
/// Cycles that are run where no number is given.
const CYCLES: usize = 3;
/// More are no more informative.
const CYCLES_MAX: usize = 10_000_000;
/// Least and greatest variation of durations, in percent.
const VARIATION_PERCENT: (f64, f64) = (0.0, 90.0);

/// Options of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Directory of a line or a cell, or its description file.
    line: PathBuf,
    /// Of a cell: how many parts of which types to make, as A=3,B=2; may be repeated [default: one of each].
    #[arg(long, value_name = "TYPE=N", value_parser = PartList::read)]
    parts: Vec<PartList>,
    /// Of a cell: print everything that is decided, and why.
    #[arg(long)]
    why: bool,
    /// Of a cell: use look-ahead and schedule as described, instead of the dispatching rules alone.
    #[arg(long)]
    planned: bool,
    /// Of a cell: new database to record to, for `linewright report`.
    #[arg(long, value_name = "DB")]
    record: Option<PathBuf>,
    /// Of a cell: number of replications, each with random numbers of its own [default: that of the scenario, or 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=REPLICATIONS_MAX))]
    replications: Option<u32>,
    /// Of a cell: wanted half width of the confidence intervals of throughput and time in the cell, as 5%; as many
    /// replications are made as it takes.
    #[arg(long, value_name = "PERCENT", value_parser = precision)]
    precision: Option<f64>,
    /// Of a cell: number of replications simulated at once [default: one for each processor]. The result does not
    /// depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZero<u16>>,
    /// Of a line: number of cycles [default: that of the scenario, or 3].
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=CYCLES_MAX as u64))]
    cycles: Option<u64>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Scenario, a TOML file: orders, operators' actions and faults; see docs/simulate.md.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Delay of a message between nodes, in ms [default: of a line that of the scenario, or 1; of a cell 0].
    #[arg(long, value_name = "MS", value_parser = millis)]
    delay: Option<Duration>,
    /// Greatest additional delay, random for each message, in ms [default: of a line that of the scenario, or 0; of a
    /// cell 0].
    #[arg(long, value_name = "MS", value_parser = millis)]
    jitter: Option<Duration>,
    /// Greatest random deviation of the duration of a motion, or of a station's task, from the description, in percent
    /// [default: of a line that of the scenario, or 0; of a cell 0].
    #[arg(long, value_name = "PERCENT", value_parser = variation)]
    variation: Option<f64>,
    /// Of a line: simulate CAN frames and messages through managers, devices and gateway, as on the machine. Slower.
    #[arg(long)]
    frames: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Of a line: write the bar chart as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Of a line: write all events, one in each line of text.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
}

fn millis(text: &str) -> Result<Duration, String> {
    let millis: f64 = text.parse().map_err(|_| "not a number of milliseconds".to_owned())?;
    if (0.0..=10_000.0).contains(&millis) {
        Ok(Duration::from_secs_f64(millis / 1e3))
    } else {
        Err("between 0 and 10000 ms".to_owned())
    }
}

fn variation(text: &str) -> Result<f64, String> {
    percent(text, VARIATION_PERCENT)
}

fn precision(text: &str) -> Result<f64, String> {
    percent(text, PRECISION_PERCENT)
}

/// A share, written in percent within limits.
fn percent(text: &str, (least, most): (f64, f64)) -> Result<f64, String> {
    let percent = text.strip_suffix('%').unwrap_or(text).trim_end();
    let percent: f64 = percent.parse().map_err(|_| "not a number of percent".to_owned())?;
    if (least..=most).contains(&percent) {
        Ok(percent / 100.0)
    } else {
        Err(format!("between {least} and {most} percent"))
    }
}

/// Runs the command.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let several = args.replications.is_some() || args.precision.is_some() || args.threads.is_some();
    let asked = args.why || args.planned || args.record.is_some() || !args.parts.is_empty() || several;
    if let Some(file) = load::cell_file(&args.line) {
        return cell::run(args, &file);
    }
    if asked {
        return Err(miette!(
            "--parts, --planned, --record, --why, --replications, --precision and --threads are for cells; {} has no \
             cell.toml",
            args.line.display()
        ));
    }
    let line = load::line(&args.line, args.json)?;
    if let Some(why) = crate::check::refusals(&line).next() {
        let path = out::shell_word(&args.line.display().to_string());
        out::complain!(
            "warning: `linewright check {path}` refuses this line, and the simulation shows one course of many: {why}"
        );
    }
    let scenario = match &args.scenario {
        Some(path) => Some(read_scenario(path, &line)?),
        None => None,
    };
    let (goal, options) = told(args, scenario.as_ref());
    let (sim, end) = linewright_simulation::run(&line, options, &goal).map_err(|error| miette!("{error}"))?;
    let report = SimulationReport::new(&sim, &end, &goal, scenario.as_ref());
    if let Some(path) = &args.trace {
        write(path, &sim.log().text(&line))?;
    }
    if let Some(path) = &args.svg {
        write(path, &chart::svg(&line, &report))?;
    }
    if args.json {
        out::json(&json::SimulationJson::new(&line, &sim, &report))?;
    } else {
        say!("{}", report.text(&line, &chart::text(&line, &report.rows)).trim_end());
        print_end(&sim, &end, scenario.as_ref());
    }
    Ok(if end == RunEnd::Done { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The command line overrides the scenario.
fn told(args: &Args, scenario: Option<&Scenario>) -> (RunGoal, SimOptions) {
    let default = Network::default();
    let network = scenario.map_or(default, |scenario| scenario.network);
    let network = Network {
        delay: args.delay.unwrap_or(network.delay),
        jitter: args.jitter.unwrap_or(network.jitter),
        ..network
    };
    let options = SimOptions {
        seed: args.seed,
        network,
        frames: args.frames,
        images: network,
        variation: args.variation.unwrap_or(scenario.map_or(0.0, |scenario| scenario.variation)),
        keeps_log: args.trace.is_some() || args.json,
        ..SimOptions::default()
    };
    let asked = args.cycles.map(|cycles| cycles as usize).or(scenario.and_then(|scenario| scenario.cycles));
    let goal = RunGoal {
        cycles: asked.unwrap_or(CYCLES),
        starts: scenario.is_none_or(|scenario| scenario.starts),
        script: scenario.map(|scenario| scenario.script.clone()).unwrap_or_default(),
    };
    (goal, options)
}

fn read_scenario(path: &Path, line: &Line) -> miette::Result<Scenario> {
    let text = files::text(path, SCENARIO_BYTES_MAX, "a scenario")?;
    Scenario::parse(line, &path.display().to_string(), &text).map_err(miette::Report::new)
}

fn write(path: &Path, text: &str) -> miette::Result<()> {
    std::fs::write(path, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", path.display()))
}

/// A failed step of a scenario is shown in its file, everything else in words.
fn print_end(sim: &LineSim, end: &RunEnd, scenario: Option<&Scenario>) {
    if let (RunEnd::Failed { step: Some(step), why }, Some(scenario)) = (end, scenario)
        && let Some(problem) = scenario.failed_at(*step, why)
    {
        crate::out::complain!("{:?}", miette::Report::new(problem));
        return;
    }
    if let Some(text) = report::end_text(sim, end) {
        crate::out::complain!("linewright: {text}");
    }
}
