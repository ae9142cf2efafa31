//! Generated lines: well formed, the same for the same seed, sound by structure, and exploration confirms it.

use linewright_line::{Line, OperationModule, parse};
use linewright_proof::explore::{Grants, LineExploration, Verdict};
use linewright_proof::generate::{self, LineShape, text};
use linewright_proof::structure::{judge_line, judge_stations};
use linewright_testkit::cases::cases;

use crate::common::{
    APART, CONFLICT, DEADLOCK, HOME, REVERSIBLE, explored, in_auto, keeps_together, undisturbed, verdict,
};

fn shapes() -> [(LineShape, u64); 3] {
    [(LineShape::default(), 150), (LineShape::small(), 100), (LineShape::row(20), 3)]
}

fn all() -> impl Iterator<Item = (u64, Line)> {
    shapes()
        .into_iter()
        .flat_map(|(shape, count)| (0..cases(count)).map(move |seed| (seed, generate::line(&shape, seed))))
}

#[test]
fn a_generated_line_is_a_description_that_reads_back_the_same() {
    for (seed, line) in all() {
        let text = text(&line);
        let read = parse("generated.toml", &text).unwrap_or_else(|problems| panic!("seed {seed}: {problems}\n{text}"));
        assert_eq!(read.line, line, "seed {seed}");
    }
}

#[test]
fn the_shipped_line_can_be_written_too() {
    let shipped = parse("line.toml", &linewright_line::TransferLine::default().text()).expect("it is sound").line;
    let again = parse("again.toml", &text(&shipped)).unwrap_or_else(|problems| panic!("{problems}")).line;
    assert_eq!(again, shipped);
    let table = include_str!("../../examples/rotary-table.toml");
    let table = parse("rotary-table.toml", table).unwrap_or_else(|problems| panic!("{problems}")).line;
    let again = parse("again.toml", &text(&table)).unwrap_or_else(|problems| panic!("{problems}")).line;
    assert_eq!(again, table);
}

#[test]
fn the_same_seed_gives_the_same_line_and_another_seed_another() {
    let line = |seed| generate::line(&LineShape::default(), seed);
    assert_eq!(line(7), line(7));
    assert_ne!(line(7).stations, line(8).stations);
}

#[test]
fn everything_a_line_may_have_is_generated() {
    let mut hands = [0; 6];
    let (mut irreversible, mut groups, mut crossing, mut home_within, mut one_mode, mut lags) = (0, 0, 0, 0, 0, [0; 3]);
    for (_, line) in all() {
        for station in &line.stations {
            station.operations.iter().for_each(|op| hands[usize::from(op.hand.number()) - 1] += 1);
            irreversible += station
                .operations
                .iter()
                .filter(|op| matches!(op.module, OperationModule::Irreversible { .. }))
                .count();
            groups += station.steps.iter().filter(|step| step.len() > 1).count();
            home_within += usize::from(station.initial_round() == 1);
        }
        crossing += line.conflicts.iter().flat_map(|c| [c.a, c.b]).filter(|span| span.until < span.from).count();
        one_mode += line.arrows.iter().filter(|arrow| !arrow.auto || !arrow.manual).count();
        line.arrows.iter().for_each(|arrow| lags[arrow.lag as usize] += 1);
    }
    println!(
        "hand types {hands:?}, {irreversible} irreversible, {groups} groups, {crossing} stretches across the \
         boundary, {home_within} homes within the list, {one_mode} arrows of one mode, lags {lags:?}"
    );
    let found = [irreversible, groups, crossing, home_within, one_mode].into_iter().chain(hands).chain(lags);
    assert!(found.into_iter().all(|count| count >= 10));
}

#[test]
fn structure_finds_a_generated_line_sound() {
    for (seed, line) in all() {
        for station in judge_stations(&line) {
            let wrong: Vec<_> = station.checks.iter().filter(|check| !check.ok).collect();
            assert!(wrong.is_empty(), "seed {seed}: {}: {wrong:?}", station.name);
        }
        let wrong: Vec<_> = judge_line(&line).into_iter().filter(|check| !check.ok).collect();
        assert!(wrong.is_empty(), "seed {seed}: {wrong:?}");
    }
}

/// Nothing that must not be was met.
fn nothing_wrong(seed: u64, line: &Line, what: &str, setting: &LineExploration, states: usize) -> bool {
    let explored = explored(setting, states);
    for property in &explored.properties {
        if property.verdict == Verdict::Fails {
            let story = property.counterexample.as_ref().map(ToString::to_string).unwrap_or_default();
            panic!("seed {seed}, {what}: {}: {}\n{story}\n{}", property.name, property.reason, text(line));
        }
    }
    explored.exhausted
}

#[test]
fn in_auto_undisturbed_a_generated_line_never_meets_a_conflict_and_never_stops() {
    let (mut seen, mut open) = (0, 0);
    for (shape, count) in [(LineShape::default(), 60), (LineShape::small(), 60)] {
        for seed in 0..cases(count) {
            // Reports that only arrows of manual mode read may be received at any time, or never: of those there is no
            // end.
            let line = in_auto(&generate::line(&shape, seed));
            if !keeps_together(&line) {
                open += 1;
                continue;
            }
            // With nothing but auto, a station that may start does; where stand-by comes between, it may also wait.
            let mut with_stand_by = undisturbed(&line);
            with_stand_by.grants = Grants::InEpochs;
            let asked: [(LineExploration, &[&str]); 2] =
                [(undisturbed(&line), &[APART, DEADLOCK]), (with_stand_by, &[APART, HOME, REVERSIBLE])];
            for (setting, names) in asked {
                let explored = explored(&setting, 1_000_000);
                assert!(explored.exhausted, "seed {seed}: {} states, {:?}", explored.states, explored.properties);
                for name in line.conflicts.iter().map(|_| CONFLICT).chain(names.iter().copied()) {
                    assert_eq!(verdict(&explored, name), Verdict::Holds, "seed {seed}: {name}\n{}", text(&line));
                }
            }
            seen += 1;
        }
    }
    println!("{seen} lines seen to the end, {open} with stations that may run away");
    assert!(seen >= 10 * open);
}

#[test]
fn with_everything_on_a_generated_line_meets_nothing_wrong() {
    let mut exhausted = 0;
    for (shape, count, states) in [(LineShape::default(), 16, 10_000), (LineShape::small(), 16, 20_000)] {
        for seed in 0..cases(count) {
            let line = generate::line(&shape, seed);
            if keeps_together(&line) {
                exhausted +=
                    u64::from(nothing_wrong(seed, &line, "everything on", &LineExploration::new(&line), states));
            }
        }
    }
    println!("{exhausted} lines were seen to the end");
}
