//! With any one rule off there is a violation on the shipped line or on another, and it is found: this shows that the
//! explorer would see it.

use linewright_line::Line;
use linewright_proof::explore::{LineExploration, LineExplored, SearchLimits, Verdict, explore};
use linewright_station_logic::Rules;
use linewright_testkit::built::transfer_line as shipped;

fn without(line: &Line, rules: Rules) -> LineExplored {
    let mut setting = LineExploration::new(line);
    setting.rules = rules;
    explore(&setting, SearchLimits { states: 1_000_000, ..SearchLimits::default() }).expect("it can be explored")
}

/// The end of the counterexample that the missing rule leads to.
fn goes_wrong(rules: Rules) -> String {
    wrong_in(&shipped(), rules)
}

fn wrong_in(line: &Line, rules: Rules) -> String {
    let explored = without(line, rules);
    let story = explored.counterexample().unwrap_or_else(|| panic!("nothing wrong in {} states", explored.states));
    assert_eq!(explored.properties.iter().filter(|p| p.verdict == Verdict::Fails).count(), 1, "the first thing wrong");
    println!("{story}");
    story.end.clone()
}

const BAR: &str = "the bar is off its rest while clamp 1 is not open";

#[test]
fn flags_instead_of_counts_let_the_bar_lift_under_a_closing_clamp() {
    assert_eq!(goes_wrong(Rules { counted: false, ..Rules::COUNTS }), BAR);
}

#[test]
fn a_count_withdrawn_late_lets_another_station_start_on_it() {
    assert_eq!(goes_wrong(Rules { withdraw_first: false, ..Rules::COUNTS }), BAR);
}

#[test]
fn a_count_withdrawn_without_agreement_closes_the_clamp_under_the_bar() {
    assert_eq!(goes_wrong(Rules { ask: false, ..Rules::COUNTS }), BAR);
}

#[test]
fn a_request_number_used_twice_makes_an_old_agreement_good_again() {
    assert_eq!(goes_wrong(Rules { fresh_numbers: false, ..Rules::COUNTS }), BAR);
}

#[test]
fn going_home_without_withdrawing_the_round_counts_a_part_that_was_never_machined() {
    assert!(goes_wrong(Rules { redo_round: false, ..Rules::COUNTS }).contains("are of no cycle"));
}

#[test]
fn going_home_without_waiting_for_its_arrows_runs_into_a_neighbour() {
    let rules = Rules { home_waits: false, ..Rules::COUNTS };
    assert_eq!(wrong_in(&crate::agreement::lines::home_in_the_way(), rules), "x and y meet");
}
