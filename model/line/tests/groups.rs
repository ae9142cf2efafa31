//! What operations side by side mean for the rules of a description: a group starts together, and has no order.

use linewright_line::parse;

const CELL: &str = include_str!("descriptions/cell.toml");

/// The messages after some edits of `descriptions/cell.toml`, first occurrence each.
fn messages(edits: &[(&str, &str)]) -> Vec<String> {
    let mut text = CELL.to_owned();
    for (old, new) in edits {
        assert!(text.contains(old), "the base has no {old:?}");
        text = text.replacen(old, new, 1);
    }
    let problems = parse("cell.toml", &text).expect_err("the edit is a mistake");
    problems.iter().map(|problem| problem.message.clone()).collect()
}

#[test]
fn what_one_of_a_group_waits_for_all_of_it_waits_for() {
    let found = messages(&[
        ("to = \"press: approach\"", "to = \"lifter: grip\""),
        ("from = \"press: raise\"", "from = \"lifter: turn\""),
        ("lag = 1", "lag = 0"),
    ]);
    let circle = "feeder: push → lifter: grip → lifter: turn → feeder: push";
    assert!(found.iter().any(|message| message.ends_with(circle)), "{found:?}");
}

#[test]
fn a_state_from_one_of_a_group_to_another_is_none() {
    let found = messages(&[(
        "a = { station = \"feeder\", from = \"push\", until = \"pull back\" }",
        "a = { station = \"lifter\", from = \"grip\", until = \"turn\" }",
    )]);
    assert!(found.contains(&"`from` and `until` run side by side".to_owned()), "{found:?}");
}
