//! Two explorers, written apart from each other, come to the same states and verdicts.
//!
//! The plain one, in this folder, plays each state with real controllers from end to end, without situations, packed
//! states or classes: motions complete, fail or stay at any moment; operators press, hold and release at every panel at
//! once; a station receives a change of mode at any time; every reader holds any report between its last one and the
//! newest; stations restart from what they kept. It is slow. Where both see every state they must see equally many.

mod actions;
pub mod lines;
mod oracle;
mod search;
mod world;

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::explore::{Grants, LineExplored, Verdict};
use linewright_proof::generate::{self, Breakage, LineShape, Random, break_it, breakages};
use linewright_testkit::cases::cases;

use crate::common::{HOME, auto_and_manual, explored, verdict};

/// Freedom given to both.
#[derive(Clone, Copy, Debug)]
struct Freedom {
    lag: usize,
    hand: bool,
    tidy: bool,
}

const PLAIN: Freedom = Freedom { lag: 1, hand: false, tidy: true };

/// Result of one of them; `home` only where every state was seen.
#[derive(Debug, PartialEq, Eq)]
enum Said {
    Wrong,
    Open,
    All { states: u64, home: bool },
}

fn older(line: &Line, freedom: Freedom, states: usize) -> Said {
    let mut setting = world::Setting::new(lines::without_haste(line.clone()));
    (setting.reports_max, setting.tidy_hands) = (freedom.lag, freedom.tidy);
    if freedom.hand {
        setting.modes = vec![ControlMode::Auto, ControlMode::Hand];
    }
    let found = search::breadth_first(&setting, states);
    match (&found.counterexample, found.home_from_everywhere) {
        (Some(_), _) => Said::Wrong,
        (None, Some(home)) => Said::All { states: found.states as u64, home },
        (None, None) => Said::Open,
    }
}

fn newer(line: &Line, freedom: Freedom, states: usize) -> (Said, LineExplored) {
    let mut setting = auto_and_manual(line);
    (setting.lag, setting.tidy_hands, setting.grants) = (freedom.lag, freedom.tidy, Grants::Anyhow);
    if freedom.hand {
        setting.modes = vec![ControlMode::Auto, ControlMode::Hand];
    }
    let explored = explored(&setting, states);
    let never = explored.properties.iter().filter(|p| p.name.starts_with("never") || p.name.starts_with("stations"));
    let said = if never.into_iter().any(|p| p.verdict == Verdict::Fails) {
        Said::Wrong
    } else if explored.exhausted {
        // Without manual mode, home is not decided.
        let home = !freedom.hand && verdict(&explored, HOME) == Verdict::Holds;
        Said::All { states: explored.states, home }
    } else {
        Said::Open
    };
    (said, explored)
}

/// The verdict of both, which must be the same; `None` if one of them came to no end.
fn agree(what: &str, line: &Line, freedom: Freedom, states: usize) -> Option<Said> {
    let (new, explored) = newer(line, freedom, states);
    let old = match (&new, freedom.hand) {
        // The slow one is not made to look where the fast one has not come to the end.
        (Said::Open, _) => return None,
        (Said::All { states: all, .. }, _) if *all > states as u64 => return None,
        (Said::Wrong, _) => older(line, freedom, 4 * states.max(explored.states as usize)),
        (Said::All { .. }, _) => older(line, freedom, states),
    };
    if freedom.hand {
        // Which buttons may be held when the mode changes is decided in another way there, so only verdicts are
        // compared.
        assert_eq!(old == Said::Wrong, new == Said::Wrong, "{what}, {freedom:?}\n{}", generate::text(line));
        return (old != Said::Open).then_some(new);
    }
    assert_eq!(old, new, "{what}, {freedom:?}\n{}", generate::text(line));
    Some(new)
}

#[test]
fn small_lines_are_sound_and_both_see_equally_many_states() {
    let fixed = [
        ("bar and clamp", lines::bar_and_clamp()),
        ("clamp and mill", lines::clamp_and_mill()),
        ("two jaws", lines::two_jaws()),
        ("home in the way", lines::home_in_the_way()),
        ("table and drill", lines::table_and_drill()),
    ];
    let sound = |name: &str, line: &Line, freedom| {
        let said = agree(name, line, freedom, 60_000);
        assert!(matches!(said, Some(Said::All { home: true, .. })), "{name}, {freedom:?}: {said:?}");
    };
    for (name, line) in &fixed {
        sound(name, line, PLAIN);
    }
    for (name, line) in [&fixed[0], &fixed[1], &fixed[4]] {
        sound(name, line, Freedom { lag: 2, ..PLAIN });
        sound(name, line, Freedom { tidy: false, ..PLAIN });
    }
}

/// Every mode, restarts, four reports on their way, and operators who hold on to their buttons.
#[test]
fn long_walks_with_every_mode_restarts_and_careless_hands_meet_nothing_wrong() {
    let fixed = [lines::shipped(), lines::small(), lines::bar_and_clamp(), lines::clamp_and_mill(), lines::two_jaws()];
    let fixed = fixed.into_iter().chain([lines::table_and_drill()]);
    let generated = (0..cases(8)).map(|seed| generate::line(&LineShape::small(), seed));
    let walks = fixed.map(|line| (line, cases(40_000) as usize)).chain(generated.map(|line| (line, 5_000)));
    for (seed, (line, steps)) in walks.enumerate() {
        let mut setting = world::Setting::new(lines::without_haste(line));
        setting.modes = ControlMode::ALL.into_iter().filter(|mode| *mode != ControlMode::Home).collect();
        (setting.reports_max, setting.restarts, setting.tidy_hands) = (4, true, false);
        assert_eq!(search::random_walk(&setting, seed as u64, steps), None, "walk {seed}");
    }
}

#[test]
#[ignore = "takes the older one some minutes, even optimised"]
fn of_the_small_line_both_see_equally_many_states() {
    assert!(agree("small", &lines::small(), PLAIN, 600_000).is_some());
}

/// Two stations of two operations each: few enough states for the older one.
fn tiny() -> LineShape {
    LineShape { operations: 2..=2, more_arrows: 1, ..LineShape::small() }
}

/// Generated lines are compared until so many were seen to the end by both.
fn generated_lines_agree(freedom: Freedom, wanted: u64, states: usize) {
    let (wanted, mut compared, mut seed) = (cases(wanted), 0, 0);
    while compared < wanted && seed < 20 * wanted {
        let line = generate::line(&tiny(), seed);
        compared += u64::from(agree(&format!("line {seed}"), &line, freedom, states).is_some());
        seed += 1;
    }
    println!("{compared} of {seed} lines compared with {freedom:?}");
    assert!(2 * compared >= wanted, "too few of them are small enough");
}

#[test]
fn of_generated_lines_both_see_equally_many_states() {
    generated_lines_agree(PLAIN, 8, 9_000);
}

#[test]
fn of_generated_lines_both_see_equally_many_states_when_reports_pile_up() {
    generated_lines_agree(Freedom { lag: 2, ..PLAIN }, 2, 20_000);
}

#[test]
fn of_generated_lines_both_see_equally_many_states_when_hands_are_careless() {
    generated_lines_agree(Freedom { tidy: false, ..PLAIN }, 2, 20_000);
}

#[test]
fn of_generated_lines_in_hand_mode_both_say_the_same() {
    generated_lines_agree(Freedom { hand: true, ..PLAIN }, 4, 9_000);
}

#[test]
fn of_broken_lines_both_say_the_same() {
    let mut random = Random::new(1);
    let (mut wrong, mut compared) = (0, 0);
    for seed in 0..cases(40) {
        let line = generate::line(&tiny(), seed);
        let all: Vec<Breakage> = breakages(&line);
        let breakage = *random.pick(&all);
        let Some(broken) = break_it(&line, breakage) else { continue };
        let what = format!("line {seed} with {breakage:?}");
        if let Some(said) = agree(&what, &broken, PLAIN, 6_000) {
            compared += 1;
            wrong += u64::from(said == Said::Wrong);
        }
    }
    println!("{compared} broken lines compared, {wrong} of them wrong");
    assert!(wrong > 0 && compared > wrong);
}
