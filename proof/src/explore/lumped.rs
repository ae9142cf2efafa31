//! Tests of the search that keeps one state for many, by itself: without the plain search that repeats it after a
//! violation.

use linewright_line::net::ControlMode;
use linewright_line::{Arrow, Line};

use super::path::tests::check_way;
use super::properties::StateTally;
use super::search::{LimitReached, LineSearch, SearchEnd, SearchLimits, search};
use super::setting::{Grants, LineExploration};
use super::state::Widths;
use super::system::System;
use crate::generate::{self, LineShape, Random, break_it, breakages};

fn searched(setting: &LineExploration, states: usize) -> LineSearch<8> {
    let (mut system, mut start) = System::new(setting).expect("a generated line compiles");
    let mut widths = Widths::FIRST;
    loop {
        match search(system, start, widths, SearchLimits { states, ..SearchLimits::default() }) {
            Ok(search) => return search,
            Err(unfit) => (system, start, widths) = (unfit.0, unfit.1, widths.wider(unfit.2)),
        }
    }
}

/// A small line with or without a mistake in it, and a property to check.
fn random_setting(seed: u64) -> LineExploration {
    let mut random = Random::new(seed);
    let stations = *random.pick(&[1, 2, 2, 2, 3]);
    let (groups, irreversible) = (*random.pick(&[0, 60]), *random.pick(&[0, 50]));
    let shape =
        LineShape { stations: stations..=stations, operations: 2..=2, groups, irreversible, ..LineShape::small() };
    let line: Line = generate::line(&shape, seed);
    let all = breakages(&line);
    let broken = if all.is_empty() || random.chance(50) { None } else { break_it(&line, *random.pick(&all)) };
    let mut setting = LineExploration::new(&broken.unwrap_or(line));
    setting.lag = random.below(4);
    (setting.faults, setting.tidy_hands) = (random.chance(70), random.chance(70));
    setting.grants = *random.pick(&[Grants::InEpochs, Grants::Anyhow]);
    let (auto, hand, manual) = (ControlMode::Auto, ControlMode::Hand, ControlMode::Manual);
    let modes: [&[ControlMode]; 8] =
        [&[auto, hand, manual], &[manual, auto], &[hand, manual], &[auto, hand], &[auto], &[hand], &[manual], &[]];
    setting.modes = random.pick(&modes).to_vec();
    let rules = &mut setting.rules;
    let switches = [&mut rules.counted, &mut rules.withdraw_first, &mut rules.ask, &mut rules.fresh_numbers];
    switches.into_iter().for_each(|rule| *rule = random.chance(85));
    setting.together_max = *random.pick(&[1, 2, 5, 4096]);
    setting
}

/// So many random settings: what a build can wait for. Some thousands of others have been compared by hand.
const SETTINGS: u64 = 100;

/// Results for all states, once all have been seen.
fn of_all(search: &LineSearch<8>) -> (StateTally, bool, bool) {
    let asked = search.system.setting.asks_for_ways();
    (search.tally, asked && search.stranded().is_some(), asked && search.no_return().is_some())
}

#[test]
fn whatever_is_asked_of_whatever_line_both_say_the_same() {
    let (mut ended, mut fewer, mut cut_off, mut wrong) = (0, 0, 0, 0);
    for seed in 0..SETTINGS {
        let setting = random_setting(seed);
        let plain = searched(&LineExploration { lumped: false, ..setting.clone() }, 10_000);
        let kept = match plain.end {
            SearchEnd::Limit(_) => continue,
            SearchEnd::Exhausted => 10_000,
            // The nearest wrong one need not be among the first that are kept.
            SearchEnd::Wrong(_) => 1_000_000,
        };
        let mut lumped = searched(&setting, kept);
        if let SearchEnd::Wrong(_) = plain.end {
            assert!(matches!(lumped.end, SearchEnd::Wrong(_)), "seed {seed}: {:?} of {setting:?}", lumped.end);
            check_way(&mut lumped);
            wrong += 1;
            continue;
        }
        assert_eq!(lumped.end, SearchEnd::Exhausted, "seed {seed}: {setting:?}");
        assert_eq!(of_all(&lumped), of_all(&plain), "seed {seed}: {setting:?}");
        let situations = |of: &LineSearch<8>| of.system.stations.iter().map(|s| s.all.len()).collect::<Vec<_>>();
        assert_eq!(situations(&lumped), situations(&plain), "seed {seed}: {setting:?}");
        ended += 1;
        fewer += u32::from(lumped.kept() < plain.kept());
        cut_off += u32::from(of_all(&plain).1 || of_all(&plain).2);
    }
    println!("{ended} seen to the end, {fewer} of them with fewer kept, {cut_off} with states cut off; {wrong} wrong");
    assert!(fewer > 0 && fewer < ended && cut_off > 0 && cut_off < ended && wrong > 0);
}

/// Two stations that wait for each other in manual mode, for ever: what auto mode has brought past an operation that
/// cannot be undone comes home by auto mode alone.
fn stands_still_in_manual(seed: u64) -> LineExploration {
    let shape = LineShape { operations: 2..=3, irreversible: 100, groups: 0, more_arrows: 0, ..LineShape::small() };
    let mut line = generate::line(&shape, seed);
    line.arrows.retain(|arrow| arrow.auto);
    line.arrows.iter_mut().for_each(|arrow| arrow.manual = false);
    let homes: Vec<_> = line.station_ids().map(|id| (id, line.station(id).home)).collect();
    for (from, to) in [(homes[0], homes[1]), (homes[1], homes[0])] {
        line.arrows.push(Arrow { from, to, lag: 0, auto: false, manual: true });
    }
    line.conflicts.clear();
    let mut setting = LineExploration::new(&line);
    setting.modes.retain(|&mode| mode != ControlMode::Hand);
    setting
}

#[test]
fn home_by_manual_alone_is_not_home_by_another_mode() {
    let mut by_auto_alone = 0;
    for seed in 0..40 {
        let setting = stands_still_in_manual(seed);
        let plain = searched(&LineExploration { lumped: false, ..setting.clone() }, 50_000);
        if plain.end != SearchEnd::Exhausted {
            continue;
        }
        let lumped = searched(&setting, 50_000);
        assert_eq!(lumped.end, SearchEnd::Exhausted, "seed {seed}");
        assert_eq!(of_all(&lumped), of_all(&plain), "seed {seed}");
        by_auto_alone += u32::from(lumped.stranded().is_some() && lumped.no_return().is_none());
    }
    println!("{by_auto_alone} lines that auto mode alone brings home");
    assert!(by_auto_alone > 0);
}

#[test]
fn a_limit_of_states_ends_a_search_at_the_same_state_each_time() {
    let setting = LineExploration::new(&generate::line(&LineShape::small(), 1));
    let first = searched(&setting, 5_000);
    assert_eq!((&first.end, first.looked_at), (&SearchEnd::Limit(LimitReached::States), 5_000));
    for _ in 0..5 {
        assert_eq!(searched(&setting, 5_000).tally, first.tally);
    }
}

#[test]
fn a_limit_that_is_just_enough_is_enough() {
    let mut setting = LineExploration::new(&generate::line(&LineShape::small(), 1));
    (setting.modes, setting.faults) = (vec![ControlMode::Auto], false);
    let all = searched(&setting, 1_000_000);
    assert_eq!(all.end, SearchEnd::Exhausted);
    assert_eq!(searched(&setting, all.kept()).end, SearchEnd::Exhausted);
    assert_eq!(searched(&setting, all.kept() - 1).end, SearchEnd::Limit(LimitReached::States));
}
