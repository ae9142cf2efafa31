//! Seeds of the fault simulation that every change has to pass.

use linewright_faults::{FaultPlan, Mutant, play, play_plan, shrink};

/// Twenty seconds of a core, at most, in a test build.
const SEEDS: u64 = 500;

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
    for seed in 0..SEEDS {
        if let Some(finding) = play(seed, None).finding {
            panic!("seed {seed}, at {:.4} s: {}; see docs/faults.md", finding.at.as_secs_f64(), finding.text);
        }
    }
}

#[test]
fn a_rule_that_is_broken_is_found() {
    let found = [
        (Mutant::RecordAfterEffects, 0, "sent before its record"),
        (Mutant::AcknowledgedBeforeWritten, 2, "its record does not have"),
        (Mutant::StopNotRecorded, 43, "starts in the emergency stop"),
        (Mutant::ForeignStopIgnored, 17, "starts in the emergency stop"),
        (Mutant::CountsOff, 0, "starts in cycle"),
        (Mutant::PositionsOff, 1, "conflict"),
    ];
    for (mutant, seed, text) in found {
        let finding = play(seed, Some(mutant)).finding.map(|finding| finding.text).unwrap_or_default();
        assert!(finding.contains(text), "{mutant:?}, seed {seed}: {finding}");
    }
}

#[test]
fn a_plan_that_fails_is_shrunk_and_still_fails() {
    let mut plan = FaultPlan::of(1);
    let all = plan.faults.len();
    shrink(&mut plan, Some(Mutant::PositionsOff));
    let finding = play_plan(&plan, Some(Mutant::PositionsOff)).finding.expect("it still fails");
    assert!(plan.faults.len() < all && finding.text.starts_with("conflict"), "{all}: {finding:?}");
}
