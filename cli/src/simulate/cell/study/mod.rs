//! `linewright simulate` of a cell with a scenario, or with replications: what is to be expected of the cell.
//!
//! [`linewright_simulation::cell::CellStudy`] plays; this reads the scenario, shows the figures and decides the exit code: 0
//! if all replications came to their end, 1 otherwise, with the reason.

mod json;
mod show;

use std::num::NonZero;
use std::path::Path;
use std::process::ExitCode;
use std::thread;

use linewright_cell::Cell;
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_line::Line;
use linewright_simulation::cell::{CellScenario, CellStudy, PlayedReplication, ReplicationGoal, StudyOptions};
use miette::miette;

use super::super::{Args, SCENARIO_BYTES_MAX};
use super::json::Decision;
use super::made::ProductionResult;
use super::{batch, record};
use crate::files;
use crate::out::{self, say};

/// With a precision there are no more replications than this.
const PRECISE_MAX: usize = 1000;

/// Runs the command for a cell that was read.
pub fn run(args: &Args, cell: &Cell, line: Option<&Line>) -> miette::Result<ExitCode> {
    let mut scenario = match &args.scenario {
        Some(path) => read(path, cell)?,
        None => CellScenario::default(),
    };
    if !scenario.has_orders() {
        scenario.orders = orders(cell, &batch(cell, &args.parts)?);
    } else if !args.parts.is_empty() {
        return Err(miette!(
            "--parts and a scenario with orders exclude each other: write the parts as an `[[order]]`"
        ));
    }
    let precision = args.precision.or(scenario.precision);
    let replications = args.replications.map(|count| count as usize).or(scenario.replications).unwrap_or(1);
    let is_one = replications == 1 && precision.is_none();
    if !is_one && (args.why || args.record.is_some()) {
        return Err(miette!("--why and --record are about one run: add --replications 1, without --precision"));
    }
    let delay = args.delay.unwrap_or_default();
    let options = StudyOptions {
        seed: args.seed,
        delay: (delay, delay + args.jitter.unwrap_or_default()),
        spread: args.variation.unwrap_or(0.0),
        planned: args.planned,
    };
    let study = CellStudy::new(cell, line, scenario, options).map_err(|error| miette!("{error}"))?;
    let mut decisions = None;
    let figures = if is_one {
        let played = one(args, &study, line)?;
        decisions = (args.why && args.json).then(|| Decision::all(&played.sim));
        vec![study.figures(&played)]
    } else {
        let goal = ReplicationGoal { replications, precision, most: PRECISE_MAX.max(replications) };
        let threads = args
            .threads
            .map(|threads| usize::from(threads.get()))
            .unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get));
        study.replicate(&goal, threads)
    };
    let problem = figures.iter().find_map(|of| of.problem.clone());
    let missed = precision.filter(|precision| problem.is_none() && !study.is_precise(&figures, *precision));
    let error = match (problem, missed) {
        (Some(problem), _) => Some(format!("replication {}: {problem}", figures.len())),
        (None, Some(precision)) => {
            Some(format!("no precision of {} % after {} replications", precision * 100.0, figures.len()))
        }
        (None, None) => None,
    };
    if args.json {
        out::json(&json::StudyJson::new(&study, &figures, decisions, error.as_deref()))?;
    } else {
        say!("{}", show::text(&study, &figures).trim_end());
        if let Some(error) = &error {
            crate::out::complain!("linewright: {error}");
        }
    }
    Ok(if error.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The only replication, with the output requested beside its figures.
fn one(args: &Args, study: &CellStudy, line: Option<&Line>) -> miette::Result<PlayedReplication> {
    let begin = |path| record::begin(path, study.cell(), line, study.played());
    let mut history = args.record.as_deref().map(begin).transpose()?;
    let played = study.play(0);
    if let Some(history) = &mut history {
        let made = ProductionResult::new(study.cell(), study.played(), &played.sim.log);
        record::write(history, &played.sim.log, played.plan.as_ref(), &made.activities)?;
    }
    if args.why && !args.json {
        say!("{}", super::show::decisions(&played.sim));
    }
    Ok(played)
}

fn read(path: &Path, cell: &Cell) -> miette::Result<CellScenario> {
    let text = files::text(path, SCENARIO_BYTES_MAX, "a scenario")?;
    CellScenario::parse(cell, &path.display().to_string(), &text).map_err(miette::Report::new)
}

/// An order of each part type for the number of parts requested.
fn orders(cell: &Cell, batch: &[u32]) -> Vec<ProductionOrderRequest> {
    let asked = (1_u128..).zip(&cell.part_types).zip(batch).filter(|(_, count)| **count > 0);
    let order = |((key, of), &quantity): ((u128, &linewright_cell::PartType), &u32)| ProductionOrderRequest {
        key,
        name: of.name.clone(),
        product: of.name.clone(),
        quantity,
        ..ProductionOrderRequest::default()
    };
    asked.map(order).collect()
}
