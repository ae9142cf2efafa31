//! With all rules on nothing goes wrong.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_station_logic::Rules;

use crate::lines;
use crate::search::{Found, breadth_first, limit, random_walk};
use crate::world::Setting;

fn nothing_is_wrong(what: &str, found: Found) -> Found {
    println!("{what}: {} states, exhausted: {}", found.states, found.exhausted);
    if let Some(counterexample) = &found.counterexample {
        panic!("{what}:\n{counterexample}");
    }
    found
}

/// Every mode, restarts, reports piling up, and operators who hold on to their buttons.
fn freely(line: Line) -> Setting {
    let mut setting = Setting::new(line, Rules::default());
    setting.modes =
        vec![ControlMode::StandBy, ControlMode::Auto, ControlMode::Hand, ControlMode::Manual, ControlMode::EStop];
    setting.reports_max = 4;
    setting.restarts = true;
    setting.tidy_hands = false;
    setting
}

#[test]
fn every_state_of_bar_and_clamp_is_sound_and_leads_home() {
    let setting = Setting::new(lines::bar_and_clamp(), Rules::default());
    let found = nothing_is_wrong("bar and clamp", breadth_first(&setting, limit("EXPLORE_STATES", 400_000)));
    if found.exhausted {
        assert_eq!(found.home_from_everywhere, Some(true));
    }
}

#[test]
fn every_state_of_clamp_and_mill_is_sound_and_leads_home() {
    let setting = Setting::new(lines::clamp_and_mill(), Rules::default());
    let found = nothing_is_wrong("clamp and mill", breadth_first(&setting, limit("EXPLORE_STATES", 400_000)));
    if found.exhausted {
        assert_eq!(found.home_from_everywhere, Some(true));
    }
}

#[test]
fn the_small_line_is_sound_as_far_as_it_is_searched() {
    let setting = Setting::new(lines::small(), Rules::default());
    nothing_is_wrong("small line", breadth_first(&setting, limit("EXPLORE_STATES", 150_000)));
}

#[test]
fn the_shipped_line_is_sound_as_far_as_it_is_searched() {
    let setting = Setting::new(lines::shipped(), Rules::default());
    nothing_is_wrong("transfer line", breadth_first(&setting, limit("EXPLORE_STATES", 150_000)));
}

#[test]
fn long_walks_with_every_mode_restarts_and_careless_hands_meet_nothing_wrong() {
    let steps = limit("EXPLORE_STEPS", 200_000);
    for (seed, line) in
        [lines::shipped(), lines::small(), lines::bar_and_clamp(), lines::clamp_and_mill(), lines::two_jaws()]
            .into_iter()
            .enumerate()
    {
        nothing_is_wrong("walk", random_walk(&freely(line), 0x5EED + seed as u64, steps));
    }
}

#[test]
#[ignore = "probe"]
fn probe() {
    let max = limit("EXPLORE_STATES", 2_000_000);
    for (name, line) in [
        ("bar and clamp", lines::bar_and_clamp()),
        ("clamp and mill", lines::clamp_and_mill()),
        ("jaws", lines::two_jaws()),
    ] {
        let mut s = Setting::new(line.clone(), Rules::default());
        s.reports_max = 2;
        nothing_is_wrong(&format!("{name} 2 reports"), breadth_first(&s, max));
        let mut s = Setting::new(line.clone(), Rules::default());
        s.restarts = true;
        nothing_is_wrong(&format!("{name} restarts"), breadth_first(&s, max));
        let mut s = Setting::new(line.clone(), Rules::default());
        s.modes.push(ControlMode::StandBy);
        s.tidy_hands = false;
        nothing_is_wrong(&format!("{name} standby untidy"), breadth_first(&s, max));
        let mut s = Setting::new(line.clone(), Rules::default());
        s.modes = vec![ControlMode::Auto, ControlMode::Hand];
        nothing_is_wrong(&format!("{name} hand"), breadth_first(&s, max));
        nothing_is_wrong(&format!("{name} freely"), breadth_first(&freely(line), max));
    }
}

#[test]
#[ignore = "probe"]
fn probe_small() {
    let max = limit("EXPLORE_STATES", 2_000_000);
    let f = nothing_is_wrong("small", breadth_first(&Setting::new(lines::small(), Rules::default()), max));
    println!("home {:?}", f.home_from_everywhere);
}
