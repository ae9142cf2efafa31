//! Seeds of the fault simulation that every change has to pass.

use std::collections::BTreeSet;

use linewright_faults::{
    CELL_MUTANTS, FLOOR_MUTANTS, FaultPlan, MUTANTS, Mutant, play, play_cell, play_floor, play_plan, shrink,
};
use linewright_testkit::cases::cases;

/// Seeds played; `cargo xtask faults` plays as many as are asked for.
fn seeds() -> u64 {
    cases(200)
}

#[test]
fn a_seed_is_the_same_run_every_time() {
    for seed in [3, 4, 5] {
        let [first, second] = [play(seed, None), play(seed, None)];
        assert_eq!((first.hash, first.events, first.end), (second.hash, second.events, second.end), "seed {seed}");
        assert_eq!(first.story, second.story, "seed {seed}");
    }
    assert_ne!(play(3, None).hash, play(4, None).hash);
}

#[test]
fn whatever_happens_around_a_line_nothing_collides_and_it_comes_back() {
    for seed in 0..seeds() {
        if let Some(finding) = play(seed, None).finding {
            panic!("seed {seed}, at {:.4} s: {}; see docs/faults.md", finding.at.as_secs_f64(), finding.text);
        }
    }
}

/// Each broken rule is found at the seed stated for it. With the rule in force that seed has no finding: most of these seeds are among
/// those played by the tests above.
#[test]
fn every_rule_that_is_broken_is_found() {
    let found = || MUTANTS.iter().filter_map(|rule| Some((rule.name, rule.mutant, rule.seed?)));
    assert!(found().count() + CELL_MUTANTS.len() >= 67, "{}", found().count());
    for (name, mutant, seed) in found() {
        assert!(play(seed, Some(mutant)).finding.is_some(), "{name}, seed {seed}");
    }
    for seed in found().map(|(.., seed)| seed).filter(|seed| *seed >= seeds()).collect::<BTreeSet<_>>() {
        assert_eq!(play(seed, None).finding, None, "seed {seed}");
    }
}

#[test]
fn a_plan_that_fails_is_shrunk_and_still_fails() {
    let mut plan = FaultPlan::of(3);
    let all = plan.faults.len();
    shrink(&mut plan, Some(Mutant::PositionsOff));
    let finding = play_plan(&plan, Some(Mutant::PositionsOff)).finding.expect("it still fails");
    assert!(plan.faults.len() < all && finding.text.starts_with("conflict"), "{all}: {finding:?}");
}

#[test]
fn whatever_happens_around_a_cell_every_part_is_made_once() {
    for seed in 0..cases(60) {
        let played = play_cell(seed, None);
        assert_eq!(played.finding, None, "seed {seed}, {} lives; see docs/faults.md", played.lives);
    }
}

#[test]
fn every_broken_rule_of_a_cell_is_found() {
    for &(mutant, seed) in CELL_MUTANTS {
        assert!(play_cell(seed, Some(mutant)).finding.is_some(), "{mutant:?}, seed {seed}");
    }
}

#[test]
fn whatever_happens_around_a_cell_with_real_stations_every_part_is_made_once() {
    let (seeds, mut left_standing) = (cases(50), 0);
    for seed in 0..seeds {
        let played = play_floor(seed, None);
        left_standing += u64::from(played.is_left_standing);
        assert_eq!(played.finding, None, "seed {seed}, {} lives; see docs/faults.md", played.lives);
    }
    assert!(left_standing * 50 <= seeds, "{left_standing}");
    assert_eq!(play_floor(3, None).story, play_floor(3, None).story);
}

#[test]
fn every_broken_rule_of_orders_is_found_with_real_stations() {
    for &(mutant, seed) in FLOOR_MUTANTS {
        assert!(play_floor(seed, Some(mutant)).finding.is_some(), "{mutant:?}, seed {seed}");
        assert_eq!(play_floor(seed, None).finding, None, "seed {seed}");
    }
}
