//! Stations that are restarted at any moment, with their memories and without. What comes of it in manual mode is for measured
//! positions, and explored in `positions.rs`.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::explore::{Grants, LineExploration, LineExplored, SearchLimits, explore};
use linewright_proof::generate::{self, LineShape};
use linewright_testkit::built::transfer_line as shipped;
use linewright_testkit::cases::cases;

use crate::common::explored;

fn found(setting: &LineExploration) -> LineExplored {
    explore(setting, SearchLimits::default()).expect("the shipped line can be explored")
}

#[test]
fn no_restart_in_auto_leads_two_stations_into_each_other() {
    let mut setting = LineExploration::new(&shipped()).with_lost_memories();
    setting.modes = vec![ControlMode::Auto];
    let explored = found(&setting);
    println!("{} states, {} kept", explored.states, explored.kept);
    assert!(explored.exhausted && explored.holds(), "{:?}", explored.properties);
    setting.forgets = false;
    let remembered = found(&setting);
    assert!(remembered.exhausted && remembered.holds() && remembered.states < explored.states);
}

#[test]
fn counts_compared_across_a_lost_memory_close_the_clamp_under_the_bar() {
    let mut setting = LineExploration::new(&shipped()).with_lost_memories();
    setting.rules.generations = false;
    let explored = found(&setting);
    let story = explored.counterexample().expect("the rule is needed");
    println!("{story}");
    assert!(story.steps.iter().any(|step| step.contains("restarts without its journal")), "{story}");
    assert_eq!(story.end, "the bar is off its rest while clamp 1 is not open");
}

#[test]
fn a_restart_with_its_memory_changes_no_verdict() {
    let mut setting = LineExploration::new(&shipped());
    (setting.modes, setting.restarts) = (vec![ControlMode::Auto, ControlMode::Manual], true);
    setting.faults = false;
    let explored = found(&setting);
    println!("{} states, {} kept", explored.states, explored.kept);
    assert!(explored.exhausted && explored.holds(), "{:?}", explored.properties);
}

/// Lines of all kinds. A station without its memory takes nothing back, and requests no agreement to that.
#[test]
fn without_its_memory_a_station_asks_for_nothing() {
    for seed in 0..cases(10) {
        let line = generate::line(&LineShape { operations: 2..=3, ..LineShape::small() }, seed);
        let explored = explored(&LineExploration::new(&line).with_lost_memories(), 30_000);
        let asks = explored.properties.iter().find(|property| property.reason.contains("of no generation"));
        assert_eq!(asks.map(|property| &property.counterexample), None, "line {seed}");
    }
}

/// With a rule off counts can contradict each other. That is what is found; a station does not come up from such a record.
#[test]
fn without_the_rule_of_the_round_and_with_restarts_the_wrong_counts_are_found() {
    let without = |line: &Line| {
        let mut setting = LineExploration::new(line);
        (setting.rules.redo_round, setting.restarts) = (false, true);
        setting
    };
    let line_explored = found(&without(&shipped()));
    let story = line_explored.counterexample().expect("the rule is needed");
    assert!(!line_explored.holds() && story.end.contains("are of no cycle"), "{story}");
    // Explored on, as situations of a class are, until a record contradicts itself.
    for seed in 0..cases(4) {
        let line = generate::line(&LineShape::small(), seed);
        for grants in [Grants::InEpochs, Grants::Anyhow] {
            for lost in [false, true] {
                let mut setting = without(&line);
                setting.grants = grants;
                explored(&if lost { setting.with_lost_memories() } else { setting }, 10_000);
            }
        }
    }
}
