//! Measured positions by themselves: they exclude the conflicts whatever is commanded, and each part of the barrier is needed.

use linewright_line::{Line, parse};
use linewright_proof::positions::{PositionRules, PositionsExplored, explore_positions};
use linewright_testkit::built::transfer_line as shipped;

const STATES: usize = 2_000_000;

fn explored(line: &Line, nth: usize, rules: PositionRules) -> PositionsExplored {
    explore_positions(line, &line.conflicts[nth], rules, STATES).expect("its stations compile")
}

#[test]
fn whatever_is_commanded_the_conflicts_of_the_shipped_line_are_excluded() {
    let line = shipped();
    for nth in 0..line.conflicts.len() {
        let found = explored(&line, nth, PositionRules::ALL);
        println!("{}: {} states", line.conflicts[nth].why, found.states);
        assert_eq!(found.counterexample, None);
        assert!(found.exhausted && found.states > 500, "{}", found.states);
    }
}

/// The table begins and ends at one switch, and is under way in between.
#[test]
fn a_table_turns_under_nothing_whatever_is_commanded_and_each_part_of_the_barrier_is_needed() {
    let text = include_str!("../../examples/rotary-table.toml");
    let line = parse("rotary-table.toml", text).expect("the example is sound").line;
    for nth in 0..line.conflicts.len() {
        let found = explored(&line, nth, PositionRules::ALL);
        println!("{}: {} states", line.conflicts[nth].why, found.states);
        assert_eq!(found.counterexample, None);
        assert!(found.exhausted && found.states > 20, "{}", found.states);
        for rules in
            [PositionRules { starts: false, stops: false }, PositionRules { stops: false, ..PositionRules::ALL }]
        {
            let way = explored(&line, nth, rules).counterexample.expect("the table turns under it");
            println!("{way:#?}");
            assert!(way.iter().any(|step| step == "table started index"), "{way:?}");
        }
    }
}

#[test]
fn without_measured_positions_both_stations_enter() {
    let line = shipped();
    for nth in 0..line.conflicts.len() {
        let found = explored(&line, nth, PositionRules { starts: false, stops: false });
        let way = found.counterexample.expect("nothing keeps them apart");
        println!("{way:#?}");
        assert!(way.len() <= 4, "{way:?}");
    }
}

#[test]
fn two_that_start_before_either_has_left_its_switch_are_kept_apart_by_the_stop_alone() {
    let line = shipped();
    let found = explored(&line, 0, PositionRules { stops: false, ..PositionRules::ALL });
    let way = found.counterexample.expect("both have started");
    println!("{way:#?}");
    assert_eq!(way.iter().filter(|step| step.contains(" started ")).count(), 2, "{way:?}");
}

/// The arm goes away while the wrist turns; the wrist goes back later, when the arm is away. Outside the state is what the
/// operation named has left, whatever moves beside it; named the other way about, the arm's switch does not prove it.
#[test]
fn of_a_group_the_operation_named_alone_ends_the_state() {
    let operation = |name: &str, with: &str, from: u32, to: u32| {
        let (there, here) = (from / 10, to / 10);
        format!(
            "[[station.operation]]\nname = \"{name}\"\n{with}module = \"R\"\nmoves = {{ axis = \"wrist\", from = {from}, to = {to} }}\n\
             duration_s = 0.4\nwatchdog_s = 1.5\n\
             normal = {{ actuator = \"to_{here}\", complete = \"LS_{here}\" }}\n\
             recovery = {{ actuator = \"to_{there}\", complete = \"LS_{there}\" }}\n\
             hand = {{ type = 6, forward = \"PB_unload\", back = \"PB_back\", next = \"PB_unload\" }}\n\n"
        )
    };
    let wrist =
        [operation("turn wrist", "with = \"swing back\"\n", 0, 180), operation("turn back", "", 180, 0)].concat();
    let begins = "# Each station works on what";
    let text = include_str!("../../examples/rotary-table.toml")
        .replacen(begins, &format!("{wrist}{begins}"), 1)
        .replacen("home = \"swing back\"", "home = \"turn back\"", 1)
        .replacen("axes = { gripper = 0.0 }", "axes = { gripper = 0.0, wrist = 0.0 }", 1)
        .replacen("\"LS_away\", ", "\"LS_away\", \"LS_0\", \"LS_18\", ", 1)
        .replacen("\"away\", \"over\"]", "\"away\", \"over\", \"to_0\", \"to_18\"]", 1);
    let of = |until: &str| {
        let text = text.replacen("until = \"swing back\"", &format!("until = \"{until}\""), 1);
        let line = parse("rotary-table.toml", &text).expect("a group at its end").line;
        explored(&line, 2, PositionRules::ALL)
    };
    let found = of("swing back");
    assert_eq!((found.counterexample, found.exhausted), (None, true));
    assert!(of("turn wrist").counterexample.is_some());
}
