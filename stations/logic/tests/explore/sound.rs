//! With all rules on nothing goes wrong.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_station_logic::Rules;

use super::generated::generated;
use super::lines;
use super::search::{Found, breadth_first, limit, random_walk};
use super::world::Setting;

fn nothing_is_wrong(what: &str, found: Found) -> Found {
    println!("{what}: {} states, exhausted: {}", found.states, found.exhausted);
    if let Some(counterexample) = &found.counterexample {
        panic!("{what}:\n{counterexample}");
    }
    found
}

/// Every mode, restarts, reports piling up, and operators who hold on to their buttons.
fn freely(line: Line) -> Setting {
    let mut setting = Setting::new(line, Rules::COUNTS);
    setting.modes =
        vec![ControlMode::StandBy, ControlMode::Auto, ControlMode::Hand, ControlMode::Manual, ControlMode::EStop];
    setting.reports_max = 4;
    setting.restarts = true;
    setting.tidy_hands = false;
    setting
}

/// Nothing wrong, nothing left unseen, and home in reach from everywhere.
fn holds_everywhere(what: &str, setting: &Setting) {
    let found = nothing_is_wrong(what, breadth_first(setting, limit("EXPLORE_STATES", 400_000)));
    assert!(found.exhausted, "{what}: more than {} states", found.states);
    assert_eq!(found.home_from_everywhere, Some(true), "{what}: a state from which there is no way home");
}

/// The two-station lines, each with more freedom of one kind than the others.
fn kinds_of_freedom(line: Line) -> [(&'static str, Setting); 4] {
    let plain = Setting::new(line, Rules::COUNTS);
    let with = |change: &dyn Fn(&mut Setting)| {
        let mut setting = plain.clone();
        change(&mut setting);
        setting
    };
    [
        ("reports piling up", with(&|s| s.reports_max = 2)),
        ("restarts", with(&|s| s.restarts = true)),
        (
            "stand-by and careless hands",
            with(&|s| {
                s.modes.push(ControlMode::StandBy);
                s.tidy_hands = false;
            }),
        ),
        ("hand mode", with(&|s| s.modes = vec![ControlMode::Auto, ControlMode::Hand])),
    ]
}

#[test]
fn every_state_of_bar_and_clamp_is_sound_and_leads_home() {
    for (freedom, setting) in kinds_of_freedom(lines::bar_and_clamp()) {
        if freedom == "hand mode" {
            // Hand mode has no recovery: a stopped motion waits for manual.
            nothing_is_wrong(freedom, breadth_first(&setting, limit("EXPLORE_STATES", 400_000)));
        } else {
            holds_everywhere(freedom, &setting);
        }
    }
}

#[test]
fn every_state_of_clamp_and_mill_is_sound_and_leads_home() {
    holds_everywhere("clamp and mill", &Setting::new(lines::clamp_and_mill(), Rules::COUNTS));
}

#[test]
fn every_state_of_a_clamp_with_two_jaws_is_sound_and_leads_home() {
    holds_everywhere("two jaws", &Setting::new(lines::two_jaws(), Rules::COUNTS));
}

#[test]
fn every_state_of_a_station_whose_home_motion_is_in_the_way_is_sound_and_leads_home() {
    holds_everywhere("home in the way", &Setting::new(lines::home_in_the_way(), Rules::COUNTS));
}

/// Searched to its end it has 441 002 states: `EXPLORE_STATES=500000`, best in an optimised build.
#[test]
fn the_small_line_is_sound_as_far_as_it_is_searched() {
    as_far_as_it_is_searched("small line", lines::small());
}

/// Searched to its end it has 2 156 730 states: `EXPLORE_STATES=2500000`, some minutes of an optimised build.
#[test]
fn the_shipped_line_is_sound_as_far_as_it_is_searched() {
    as_far_as_it_is_searched("transfer line", lines::shipped());
}

fn as_far_as_it_is_searched(what: &str, line: Line) {
    let setting = Setting::new(line, Rules::COUNTS);
    let found = nothing_is_wrong(what, breadth_first(&setting, limit("EXPLORE_STATES", 150_000)));
    assert_ne!(found.home_from_everywhere, Some(false), "{what}: a state from which there is no way home");
}

#[test]
fn long_walks_with_every_mode_restarts_and_careless_hands_meet_nothing_wrong() {
    let steps = limit("EXPLORE_STEPS", 100_000);
    let lines = [lines::shipped(), lines::small(), lines::bar_and_clamp(), lines::clamp_and_mill(), lines::two_jaws()];
    for (seed, line) in lines.into_iter().enumerate() {
        nothing_is_wrong("walk", random_walk(&freely(line), seed as u64, steps));
    }
}

#[test]
fn generated_lines_are_sound_as_far_as_they_are_searched_and_walked() {
    let lines = (0..).filter_map(|seed| Some((seed, generated(seed)?)));
    for (seed, line) in lines.take(limit("EXPLORE_LINES", 40)) {
        let setting = Setting::new(line.clone(), Rules::COUNTS);
        nothing_is_wrong(&format!("line {seed}"), breadth_first(&setting, 3_000));
        nothing_is_wrong(&format!("walk in line {seed}"), random_walk(&freely(line), seed, 5_000));
    }
}
