//! With any one rule off something goes wrong, and the explorer finds it: first the shortest way, in words.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_station_logic::Rules;

use super::lines;
use super::search::{breadth_first, limit};
use super::world::Setting;

/// The shortest way to something wrong without the rule.
fn missed(line: Line, rules: Rules) -> String {
    let setting = Setting::new(line, rules);
    let found = breadth_first(&setting, limit("EXPLORE_STATES", 400_000));
    let story = found.counterexample.unwrap_or_else(|| panic!("nothing wrong in {} states", found.states));
    println!("{} states\n{story}\n", found.states);
    story
}

#[test]
fn flags_instead_of_counts_let_the_bar_lift_under_a_closing_clamp() {
    let story = missed(lines::shipped(), Rules { counted: false, ..Rules::COUNTS });
    assert!(story.ends_with("the bar is off its rest while clamp 1 is not open"));
}

#[test]
fn a_count_withdrawn_late_lets_another_station_start_on_it() {
    let story = missed(lines::shipped(), Rules { withdraw_first: false, ..Rules::COUNTS });
    assert!(story.ends_with("the bar is off its rest while clamp 1 is not open"));
}

#[test]
fn a_count_withdrawn_without_agreement_closes_the_clamp_under_the_bar() {
    let story = missed(lines::shipped(), Rules { ask: false, ..Rules::COUNTS });
    assert!(story.ends_with("the bar is off its rest while clamp 1 is not open"));
}

#[test]
fn a_request_number_used_twice_makes_an_old_agreement_good_again() {
    let story = missed(lines::bar_and_clamp(), Rules { fresh_numbers: false, ..Rules::COUNTS });
    assert!(story.ends_with("the bar is off its rest while the clamp is not open"));
}

#[test]
fn going_home_without_withdrawing_the_round_counts_a_part_that_was_never_machined() {
    let story = missed(lines::clamp_and_mill(), Rules { redo_round: false, ..Rules::COUNTS });
    assert!(story.contains("are of no cycle"), "{story}");
}

#[test]
fn going_home_without_waiting_for_its_arrows_runs_into_a_neighbour() {
    let story = missed(lines::home_in_the_way(), Rules { home_waits: false, ..Rules::COUNTS });
    assert!(story.ends_with("x and y meet"));
}

/// Auto and hand mode: in manual mode a person may lead home a station that has lost its memory, and only measured
/// positions keep it from others then.
fn that_forgets(line: Line, rules: Rules) -> Setting {
    let mut setting = Setting::new(line, rules);
    setting.modes = vec![ControlMode::Auto, ControlMode::Hand];
    setting.forgets = true;
    setting
}

#[test]
fn a_station_that_loses_its_memory_meets_nobody_in_auto_and_hand() {
    for (name, line) in [("bar and clamp", lines::bar_and_clamp()), ("clamp and mill", lines::clamp_and_mill())] {
        let setting = that_forgets(line, Rules { generations: true, ..Rules::COUNTS });
        let found = breadth_first(&setting, limit("EXPLORE_STATES", 2_000_000));
        println!("{name}: {} states", found.states);
        assert_eq!(found.counterexample, None, "{name}");
        assert!(found.exhausted, "{name}: more than {} states", found.states);
    }
}

#[test]
fn counts_compared_across_a_lost_memory_close_the_clamp_under_the_bar() {
    let setting = that_forgets(lines::bar_and_clamp(), Rules::COUNTS);
    let story = breadth_first(&setting, limit("EXPLORE_STATES", 2_000_000)).counterexample.expect("something wrong");
    println!("{story}");
    assert!(story.contains("loses its memory"), "{story}");
    assert!(story.ends_with("the bar is off its rest while the clamp is not open"), "{story}");
}
