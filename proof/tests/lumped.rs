//! One state kept for all that stations come and go between by themselves: every verdict and every count is the same as
//! when each state is kept for itself.

use linewright_line::net::ControlMode;
use linewright_line::{Arrow, Line};
use linewright_proof::explore::{Grants, LineExploration, LineExplored, Verdict};
use linewright_proof::generate::{self, LineShape, Random, break_it, breakages};
use linewright_testkit::cases::cases;

use crate::common::{HOME, REVERSIBLE, explored, verdict};

/// Few enough for a build to wait for.
const STATES_MAX: usize = 100_000;

/// Of both, where the plain one came to an end: how many states it saw, and how many the other kept. Where it ended
/// with a violation, the test checks only that one is reported: the plain one is run again for the way.
fn same(what: &str, line: &Line, change: fn(&mut LineExploration)) -> Option<(u64, usize)> {
    let mut setting = LineExploration::new(line);
    change(&mut setting);
    let (plain, lumped) = both(what, &setting, STATES_MAX)?;
    Some((plain.states, lumped.kept))
}

fn is_wrong(of: &LineExplored) -> bool {
    of.properties.iter().any(|p| p.verdict == Verdict::Fails)
}

/// Where each is kept for itself, and where not; none if the former came to its limit. A way to a violation among kept states
/// is checked where it is made.
fn both(what: &str, setting: &LineExploration, states: usize) -> Option<(LineExplored, LineExplored)> {
    let mut each = setting.clone();
    each.lumped = false;
    let plain = explored(&each, states);
    if plain.limit.is_some() {
        return None;
    }
    // The nearest wrong one need not be among the first that are kept.
    let lumped = explored(setting, if plain.exhausted { states } else { 1_000_000 });
    let verdicts = |of: &LineExplored| of.properties.iter().map(|p| (p.name.clone(), p.verdict)).collect::<Vec<_>>();
    if !plain.exhausted {
        assert!(is_wrong(&lumped), "{what}: {:?} of {setting:?}", verdicts(&plain));
        return Some((plain, lumped));
    }
    assert!(lumped.exhausted, "{what}: {} states kept of {}", lumped.kept, plain.states);
    assert_eq!((lumped.states, lumped.arcs), (plain.states, plain.arcs), "{what}: {setting:?}");
    assert_eq!(lumped.situations, plain.situations, "{what}: {setting:?}");
    let reasons = |of: &LineExplored| of.properties.iter().map(|p| p.reason.clone()).collect::<Vec<_>>();
    assert_eq!(verdicts(&lumped), verdicts(&plain), "{what}: {setting:?}");
    if plain.holds() {
        assert_eq!(reasons(&lumped), reasons(&plain), "{what}");
    }
    assert_eq!(plain.kept as u64, plain.states, "{what}: plain keeps each");
    assert!(lumped.kept <= plain.kept, "{what}");
    Some((plain, lumped))
}

/// Two stations of two operations each.
fn tiny() -> LineShape {
    LineShape { operations: 2..=2, more_arrows: 1, ..LineShape::small() }
}

fn compare(name: &str, change: fn(&mut LineExploration), wanted: u64) {
    let (mut compared, mut states, mut kept) = (0, 0, 0);
    for seed in 0..cases(16) {
        let line = generate::line(&tiny(), seed);
        if let Some((all, few)) = same(&format!("{name}, line {seed}"), &line, change) {
            (compared, states, kept) = (compared + 1, states + all, kept + few);
        }
    }
    println!("{name}: {compared} lines to the end, {states} states, {kept} kept");
    // Later lines need not be among the small ones.
    assert!(compared >= cases(wanted).min(wanted));
}

#[test]
fn with_lost_memories() {
    compare("lost memories", |setting| *setting = setting.clone().with_lost_memories(), 5);
}

#[test]
fn with_everything_on() {
    compare("everything on", |_| {}, 5);
}

#[test]
fn in_modes_of_no_order() {
    compare("any grants", |setting| setting.grants = Grants::Anyhow, 5);
}

#[test]
fn with_reports_heard_at_once() {
    compare("at once", |setting| setting.lag = 0, 5);
}

#[test]
fn with_two_reports_under_way() {
    compare("two under way", |setting| setting.lag = 2, 3);
}

#[test]
fn with_careless_hands() {
    let careless = |setting: &mut LineExploration| {
        setting.modes.retain(|&mode| mode != ControlMode::Hand);
        (setting.tidy_hands, setting.grants) = (false, Grants::Anyhow);
    };
    compare("careless", careless, 3);
}

#[test]
fn with_rules_off() {
    compare("no agreement", |setting| setting.rules.ask = false, 3);
    compare("flags", |setting| setting.rules.counted = false, 3);
    compare("numbers used twice", |setting| setting.rules.fresh_numbers = false, 3);
    compare("no wait on the way home", |setting| setting.rules.home_waits = false, 3);
}

#[test]
fn of_lines_broken_on_purpose() {
    let mut compared = 0;
    for seed in 0..cases(12) {
        let line = generate::line(&tiny(), seed);
        let mut random = Random::new(seed);
        for _ in 0..3 {
            let breakage = *random.pick(&breakages(&line));
            let Some(broken) = break_it(&line, breakage) else { continue };
            compared += u64::from(same(&format!("line {seed}, {breakage:?}"), &broken, |_| {}).is_some());
        }
    }
    println!("{compared} broken lines to the end");
    assert!(compared >= cases(5));
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
    setting
}

#[test]
fn whatever_is_asked_of_whatever_line() {
    let (mut ended, mut fewer, mut cut_off, mut wrong) = (0, 0, 0, 0);
    for seed in 0..cases(100) {
        let Some((plain, lumped)) = both(&format!("seed {seed}"), &random_setting(seed), 10_000) else { continue };
        if !plain.exhausted {
            wrong += 1;
            continue;
        }
        ended += 1;
        fewer += u32::from(lumped.kept < plain.kept);
        cut_off += u32::from(is_wrong(&plain));
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
    for seed in 0..cases(20).max(20) {
        let Some((_, lumped)) = both(&format!("seed {seed}"), &stands_still_in_manual(seed), 50_000) else { continue };
        let [home, back] = [HOME, REVERSIBLE].map(|name| verdict(&lumped, name));
        by_auto_alone += u32::from((home, back) == (Verdict::Fails, Verdict::Holds));
    }
    println!("{by_auto_alone} lines that auto mode alone brings home");
    assert!(by_auto_alone > 0);
}
