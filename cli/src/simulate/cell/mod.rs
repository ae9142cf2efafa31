//! `linewright simulate` for a flexible cell: so many parts, made by the cell's own token player and dispatcher, with
//! stations whose times are those of the description.
//!
//! [`linewright_simulation::cell`] plays; this reads the description, shows the result and decides the exit code: 0 if
//! all parts were finished and have left, 1 otherwise, with what each of the others waits for. With a scenario or
//! several replications, [`study`] does it.

mod json;
mod made;
mod record;
mod show;
mod study;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{CompiledCell, compile_cell, dispatcher, planner};
use linewright_coordinator_cell::dispatch::Reasons;
use linewright_coordinator_cell::dispatch::why_not;
use linewright_coordinator_cell::{ActivityPhase, PlayerState};
use linewright_line::{Line, Tick};
use linewright_simulation::cell::{CellSim, CellSimOptions, StudyProblem, UNCHANGED, UNDISTURBED};
use miette::miette;

use super::Args;
use crate::load;
use crate::out::{self, say};
use crate::parts::{PARTS_MAX, PartList};
use made::ProductionResult;

/// Most unfinished parts for which the reason is printed.
const STUCK_MAX: usize = 10;

/// Runs the command for the cell in `file`.
pub fn run(args: &Args, file: &Path) -> miette::Result<ExitCode> {
    let of_lines = [
        ("--cycles", args.cycles.is_some()),
        ("--frames", args.frames),
        ("--svg", args.svg.is_some()),
        ("--trace", args.trace.is_some()),
    ];
    if let Some((option, _)) = of_lines.iter().find(|(_, given)| *given) {
        return Err(miette!("{option} is for lines; {} describes a cell", file.display()));
    }
    let is_study = args.scenario.is_some() || args.replications.is_some() || args.precision.is_some();
    if args.threads.is_some() && !is_study {
        return Err(miette!("--threads is for several replications: add --replications, --precision or --scenario"));
    }
    let line = beside(file, args.json)?;
    let parsed = load::cell(file, line.as_ref())?;
    if !args.json {
        load::warn(file, &parsed.warnings);
    }
    let cell = parsed.cell;
    if is_study {
        return study::run(args, &cell, line.as_ref());
    }
    let batch = batch(&cell, &args.parts)?;
    let played =
        compile_cell(&cell, line.as_ref(), Supply::Batch(&batch), UNDISTURBED).map_err(|error| miette!("{error}"))?;
    let delay = args.delay.unwrap_or_default();
    let options = CellSimOptions {
        seed: args.seed,
        pace: linewright_simulation::cell::StationSpeed::Nominal { spread: args.variation.unwrap_or(0.0) },
        delay: (delay, delay + args.jitter.unwrap_or_default()),
        period: UNCHANGED,
        ..CellSimOptions::default()
    };
    let stations = line.as_ref().map_or(cell.controllers.len(), |line| line.stations.len());
    // Faults of the file are reported before anything is played.
    let begin = |path: &PathBuf| record::begin(path, &cell, line.as_ref(), &played);
    let mut history = args.record.as_ref().map(begin).transpose()?;
    let table = Arc::new(played.table.clone());
    let mut by_rules = dispatcher(&cell, &table);
    let mut plan = args.planned.then(|| planner(&cell, &played));
    let mut sim = CellSim::new(table, stations, options);
    match &mut plan {
        Some(plan) => sim.run(plan, Tick::NEVER),
        None => sim.run(&mut by_rules, Tick::NEVER),
    }
    let made = ProductionResult::new(&cell, &played, &sim.log);
    if let Some(history) = &mut history {
        record::write(history, &sim.log, plan.as_ref(), &made.activities)?;
    }
    let asked: u32 = batch.iter().sum();
    let error = error(&sim, &played, asked, made.end);
    if args.json {
        out::json(&json::CellSimulationJson::new(&cell, &played, &sim, &made, error.as_deref(), args.why))?;
    } else {
        if args.why {
            say!("{}", show::decisions(&sim));
        }
        say!("{}", show::text(&cell, &made, asked).trim_end());
        if let Some(error) = &error {
            crate::out::complain!("linewright: {error}");
        }
    }
    Ok(if error.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The line beside a cell, if it has one.
fn beside(file: &Path, quiet: bool) -> miette::Result<Option<Line>> {
    let line = file.with_file_name("line.toml");
    if line.exists() { load::line(&line, quiet).map(Some) } else { Ok(None) }
}

/// Number of parts of each type, in the order of the description.
fn batch(cell: &Cell, asked: &[PartList]) -> miette::Result<Vec<u32>> {
    if asked.is_empty() {
        return Ok(vec![1; cell.part_types.len()]);
    }
    let mut batch = vec![0_u32; cell.part_types.len()];
    for (name, count) in PartList::sum(asked) {
        let Some(of) = cell.part_type_named(&name) else {
            let known: Vec<&str> = cell.part_types.iter().map(|of| of.name.as_str()).collect();
            return Err(miette!("no part type '{name}'; the cell has {}", known.join(", ")));
        };
        batch[of.index()] += count;
    }
    match batch.iter().fold(0, |sum: u32, &count| sum.saturating_add(count)) {
        0 => Err(miette!("no parts to make")),
        1..=PARTS_MAX => Ok(batch),
        more => Err(miette!("{more} parts are more than {PARTS_MAX}")),
    }
}

/// Why not all parts were finished until the last thing happened; none if they were.
fn error(sim: &CellSim, played: &CompiledCell, asked: u32, end: Tick) -> Option<String> {
    let state: &PlayerState = sim.state();
    let left = u32::try_from(state.left()).unwrap_or(u32::MAX);
    if left >= asked {
        return None;
    }
    let end_s = end.as_secs_f64();
    let mut lines = vec![match sim.spins() {
        None => {
            format!("{left} of {asked} parts finished; no further event after {end_s:.3} s")
        }
        Some(mode) => {
            let activity = state.table().mode_name(mode).to_owned();
            format!("{left} of {asked} parts finished; {}", StudyProblem::Spins { activity, at_s: end_s })
        }
    }];
    let failed = state.firings().filter_map(|firing| match firing.phase {
        ActivityPhase::Failed(cause) => Some((firing, cause)),
        ActivityPhase::Running => None,
    });
    for (firing, cause) in failed.take(STUCK_MAX) {
        let what = linewright_coordinator_cell::texts::named(state.table(), firing.mode, firing.part);
        lines.push(format!("  {what} has failed: {}", show::cause(&cause)));
    }
    let mut reasons = Reasons::default();
    sim.log.iter().for_each(|record| reasons.note(record));
    let ways = linewright_coordinator_cell::dispatch::ShortestRoutes::new(&played.table);
    for part in state.parts().take(STUCK_MAX) {
        let why = why_not(&ways, &reasons, &sim.coordination, end, part.id);
        lines.extend(why.into_iter().map(|line| format!("  {line}")));
    }
    Some(lines.join("\n"))
}
