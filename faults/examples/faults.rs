//! `cargo xtask faults`: plays seeds, and prints the story of each that fails.

use std::process::ExitCode;
use std::time::Instant;

use linewright_faults::{
    CELL_MUTANTS, FLOOR_MUTANTS, FaultPlan, MUTANTS, Mutant, PlayedSeed, play, play_cell, play_floor, play_plan, shrink,
};
use linewright_line::Tick;
use linewright_proof::generate;

/// Entries of a story that are printed.
const STORY: usize = 60;

#[derive(Default)]
struct FaultArguments {
    seeds: u64,
    from: u64,
    shard: (u64, u64),
    shrinks: bool,
    mutants: bool,
    cells: bool,
    floors: bool,
    mutant: Option<Mutant>,
}

fn arguments() -> Option<FaultArguments> {
    let mut found = FaultArguments { seeds: 1000, shard: (0, 1), ..FaultArguments::default() };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--seeds" => found.seeds = args.next()?.parse().ok()?,
            "--from" => found.from = args.next()?.parse().ok()?,
            "--shard" => {
                let text = args.next()?;
                let (at, of) = text.split_once('/')?;
                found.shard = (at.parse().ok()?, of.parse().ok().filter(|of| *of > 0)?);
            }
            "--shrink" => found.shrinks = true,
            "--mutants" => found.mutants = true,
            "--cells" => found.cells = true,
            "--floors" => found.floors = true,
            "--mutant" => {
                let name = args.next()?;
                found.mutant = Some(Mutant::named(&name)?);
            }
            _ => return None,
        }
    }
    Some(found)
}

fn main() -> ExitCode {
    let Some(arguments) = arguments() else {
        eprintln!(
            "options: [--seeds N] [--from S] [--shard I/N] [--shrink] [--cells] [--floors] [--mutants | --mutant NAME]"
        );
        return ExitCode::from(2);
    };
    if arguments.floors {
        let good = if arguments.mutants { floor_mutants(&arguments) } else { floors(&arguments) };
        return if good { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    let good = match (arguments.cells, arguments.mutants) {
        (false, false) => seeds(&arguments),
        (false, true) => mutants(&arguments),
        (true, false) => cells(&arguments),
        (true, true) => cell_mutants(&arguments),
    };
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn numbers(arguments: &FaultArguments) -> impl Iterator<Item = u64> + use<> {
    let (at, of) = arguments.shard;
    (arguments.from..arguments.from + arguments.seeds).filter(move |seed| seed % of == at % of)
}

fn seeds(arguments: &FaultArguments) -> bool {
    let start = Instant::now();
    let (mut count, mut failed, mut left, mut events, mut time) = (0_u64, 0_u64, 0_u64, 0, 0.0);
    for seed in numbers(arguments) {
        let played = play(seed, arguments.mutant);
        count += 1;
        left += u64::from(played.is_left_standing);
        events += played.events;
        time += played.end.as_secs_f64();
        // Every hundredth once more: a seed that is not the same twice explains nothing.
        if seed % 100 == 0 && play(seed, arguments.mutant).hash != played.hash {
            println!("seed {seed}: not the same run twice");
            failed += 1;
        }
        if played.finding.is_some() {
            failed += 1;
            let mut plan = FaultPlan::of(seed);
            let played = if arguments.shrinks {
                shrink(&mut plan, arguments.mutant);
                play_plan(&plan, arguments.mutant)
            } else {
                played
            };
            tell(seed, &plan, &played);
            if arguments.shrinks {
                println!("\n{}", generate::text(&plan.line));
            }
        }
    }
    let took = start.elapsed().as_secs_f64();
    println!(
        "{count} seeds, {failed} with findings, {left} generated lines left standing; {events} events in {time:.0} s of the lines' time; {took:.1} s, {:.1} seeds per second",
        count as f64 / took
    );
    failed == 0
}

fn tell(seed: u64, plan: &FaultPlan, played: &PlayedSeed) {
    println!("\nseed {seed}: {}", plan.line.title);
    let finding = played.finding.as_ref().map(|finding| (finding.at, finding.text.as_str()));
    tell_story(&played.story, finding);
}

/// The end of a story, and what was found.
fn tell_story(story: &[(Tick, String)], finding: Option<(Tick, &str)>) {
    let skipped = story.len().saturating_sub(STORY);
    if skipped > 0 {
        println!("   … {skipped} before");
    }
    for (at, text) in story.iter().skip(skipped) {
        println!("{:>10.4} s  {text}", at.as_secs_f64());
    }
    if let Some((at, text)) = finding {
        println!("{:>10.4} s  FOUND {text}", at.as_secs_f64());
    }
}

fn cells(arguments: &FaultArguments) -> bool {
    let start = Instant::now();
    let (mut count, mut failed, mut steps, mut lives, mut time) = (0_u64, 0_u64, 0, 0, 0.0);
    for seed in numbers(arguments) {
        let played = play_cell(seed, None);
        count += 1;
        steps += played.steps;
        lives += played.lives;
        time += played.end.as_secs_f64();
        if let Some(finding) = played.finding {
            failed += 1;
            println!("seed {seed}, {} lives, at {:.1} s: {finding}", played.lives, played.end.as_secs_f64());
        }
    }
    let took = start.elapsed().as_secs_f64();
    println!(
        "{count} seeds of cells, {failed} with findings; {steps} steps of {lives} lives of coordinators in {time:.0} s of the cells' time; {took:.1} s, {:.1} seeds per second",
        count as f64 / took
    );
    failed == 0
}

fn floors(arguments: &FaultArguments) -> bool {
    let start = Instant::now();
    let (mut count, mut failed, mut left, mut lives, mut time) = (0_u64, 0_u64, 0_u64, 0, 0.0);
    for seed in numbers(arguments) {
        let played = play_floor(seed, None);
        count += 1;
        left += u64::from(played.is_left_standing);
        lives += played.lives;
        time += played.end.as_secs_f64();
        let again = (seed % 100 == 0).then(|| play_floor(seed, None));
        if again.is_some_and(|again| again.story != played.story) {
            println!("seed {seed}: not the same run twice");
            failed += 1;
        }
        if let Some(finding) = played.finding {
            failed += 1;
            println!("\nseed {seed}");
            tell_story(&played.story, Some((played.end, &finding)));
        }
    }
    let took = start.elapsed().as_secs_f64();
    println!(
        "{count} seeds of cells with real stations, {failed} with findings, {left} left standing; {lives} lives of coordinators in {time:.0} s of the cells' time; {took:.1} s, {:.1} seeds per second",
        count as f64 / took
    );
    failed == 0
}

fn floor_mutants(arguments: &FaultArguments) -> bool {
    let mut all = true;
    for &(mutant, _) in FLOOR_MUTANTS {
        let found = numbers(arguments).find_map(|seed| {
            let finding = play_floor(seed, Some(mutant)).finding?;
            play_floor(seed, None).finding.is_none().then_some((seed, finding))
        });
        match found {
            Some((seed, finding)) => {
                println!("{mutant:?}: seed {seed}: {}", finding.chars().take(200).collect::<String>());
            }
            None => {
                println!("{mutant:?}: NOT FOUND in {} seeds", numbers(arguments).count());
                all = false;
            }
        }
    }
    all
}

fn cell_mutants(arguments: &FaultArguments) -> bool {
    let mut all = true;
    for &(mutant, _) in CELL_MUTANTS {
        let found = numbers(arguments).find_map(|seed| {
            let finding = play_cell(seed, Some(mutant)).finding.filter(|_| play_cell(seed, None).finding.is_none())?;
            Some((seed, finding))
        });
        match found {
            Some((seed, finding)) => println!("{mutant:?}: seed {seed}: {finding}"),
            None => {
                println!("{mutant:?}: NOT FOUND in {} seeds", numbers(arguments).count());
                all = false;
            }
        }
    }
    all
}

/// Gives whether each mutant was found.
fn mutants(arguments: &FaultArguments) -> bool {
    let mut all = true;
    for (mutant, name) in MUTANTS.iter().map(|rule| (rule.mutant, rule.name)) {
        if arguments.mutant.is_some_and(|only| only != mutant) {
            continue;
        }
        let found = numbers(arguments).zip(1_u64..).find_map(|(seed, count)| {
            // Without the mutant it must pass, or it says nothing.
            let finding = play(seed, Some(mutant)).finding.filter(|_| play(seed, None).finding.is_none())?;
            Some((seed, count, finding))
        });
        match found {
            Some((seed, count, finding)) => {
                println!("{name}: found after {count} seeds (seed {seed}): {}", finding.text);
            }
            None => {
                println!("{name}: NOT FOUND in {} seeds", numbers(arguments).count());
                all = false;
            }
        }
    }
    all
}
