//! Every rule, broken once: edits of a sound cell, and the problems they raise, in `problems/*.cases`.

use crate::files::{FIXTURE, problems};

const PROBLEMS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems");

fn base(name: &str) -> String {
    match name {
        "fixture" => FIXTURE.to_owned(),
        "two-robot-cell" => crate::round_trip::two_robot_cell(),
        other => panic!("no base is called `{other}`"),
    }
}

#[test]
fn tables_that_cannot_be_read() {
    linewright_cases::check(PROBLEMS, "tables.cases", base, problems);
}

#[test]
fn applicability_rules() {
    linewright_cases::check(PROBLEMS, "applicability.cases", base, problems);
}

#[test]
fn tables_that_contradict_each_other() {
    linewright_cases::check(PROBLEMS, "cross_checks.cases", base, problems);
}

#[test]
fn sound_cells_have_no_problem() {
    assert_eq!(problems(FIXTURE), Vec::new());
    assert_eq!(problems(&base("two-robot-cell")), Vec::new());
}
