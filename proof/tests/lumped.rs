//! One state kept for all that stations come and go between by themselves: every verdict and every count is the same as
//! when each state is kept for itself.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::explore::{Grants, LineExploration, LineExplored, Verdict};
use linewright_proof::generate::{self, LineShape, Random, break_it, breakages};

use crate::common::{explored, lines};

/// Few enough for a build to wait for.
const STATES_MAX: usize = 100_000;

/// Of both, where the plain one came to an end: how many states it saw, and how many the other kept. Where it ended
/// with a violation, the test checks only that one is reported: the plain one is run again for the way.
fn same(what: &str, line: &Line, change: fn(&mut LineExploration)) -> Option<(u64, usize)> {
    let mut setting = LineExploration::new(line);
    change(&mut setting);
    let lumped = explored(&setting, STATES_MAX);
    setting.lumped = false;
    let plain = explored(&setting, STATES_MAX);
    let verdicts = |of: &LineExplored| of.properties.iter().map(|p| (p.name.clone(), p.verdict)).collect::<Vec<_>>();
    if !plain.exhausted {
        let wrong = |of: &LineExplored| of.properties.iter().any(|p| p.verdict == Verdict::Fails);
        assert!(!wrong(&plain) || wrong(&lumped), "{what}: {:?}", verdicts(&plain));
        return wrong(&plain).then_some((plain.states, lumped.kept));
    }
    assert!(lumped.exhausted, "{what}: {} states kept of {}", lumped.kept, plain.states);
    assert_eq!((lumped.states, lumped.arcs), (plain.states, plain.arcs), "{what}");
    assert_eq!(lumped.situations, plain.situations, "{what}");
    let reasons = |of: &LineExplored| of.properties.iter().map(|p| p.reason.clone()).collect::<Vec<_>>();
    assert_eq!(verdicts(&lumped), verdicts(&plain), "{what}");
    if plain.holds() {
        assert_eq!(reasons(&lumped), reasons(&plain), "{what}");
    }
    assert_eq!(plain.kept as u64, plain.states, "{what}: plain keeps each");
    assert!(lumped.kept <= plain.kept, "{what}");
    Some((plain.states, lumped.kept))
}

/// Two stations of two operations each.
fn tiny() -> LineShape {
    LineShape { operations: 2..=2, more_arrows: 1, ..LineShape::small() }
}

fn compare(name: &str, change: fn(&mut LineExploration), wanted: u64) {
    let (mut compared, mut states, mut kept) = (0, 0, 0);
    for seed in 0..lines(16) {
        let line = generate::line(&tiny(), seed);
        if let Some((all, few)) = same(&format!("{name}, line {seed}"), &line, change) {
            (compared, states, kept) = (compared + 1, states + all, kept + few);
        }
    }
    println!("{name}: {compared} lines to the end, {states} states, {kept} kept");
    assert!(compared >= lines(wanted));
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
    for seed in 0..lines(12) {
        let line = generate::line(&tiny(), seed);
        let mut random = Random::new(seed);
        for _ in 0..3 {
            let breakage = *random.pick(&breakages(&line));
            let Some(broken) = break_it(&line, breakage) else { continue };
            compared += u64::from(same(&format!("line {seed}, {breakage:?}"), &broken, |_| {}).is_some());
        }
    }
    println!("{compared} broken lines to the end");
    assert!(compared >= lines(5));
}
