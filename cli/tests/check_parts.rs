//! `linewright check` of lines that are explored in parts.

use linewright_proof::generate::{self, LineShape};

use crate::support::command::{Scratch, json, linewright, shipped, text};

#[test]
fn a_line_of_many_stations_is_explored_in_parts_and_like_parts_once() {
    let scratch = Scratch::new();
    let dir = scratch.path("long");
    assert!(linewright(&["new", "transfer-line", "--dir", &dir, "--machines", "4"]).status.success());
    // Flags in every part: the first part has a counterexample, and the others are not taken for sound because of it.
    let output = linewright(&["check", &dir, "--flags", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found = json(&output);
    let explorations = found["explorations"].as_array().unwrap();
    assert_eq!(explorations.len(), 4);
    assert_eq!(explorations[0]["scope"].as_str().unwrap().split(':').nth(1), Some(" transfer, clamp_1, mill_1"));
    assert!(explorations[0]["properties"].to_string().contains("counterexample"));
    assert!(explorations[1..].iter().all(|part| part["properties"].to_string().contains("undecided")), "{found}");
    let outside = ["clamp_2", "clamp_3", "clamp_4", "mill_2", "mill_3", "mill_4"];
    assert_eq!(explorations[0]["left_out"], serde_json::json!(outside));
    // A failure in a part says what was not in it, and what looks further.
    let output = linewright(&["check", &dir, "--flags"]);
    let out = text(&output.stdout);
    let help = format!("  help: this part leaves out {}, with arrows", outside.join(", "));
    assert_eq!(out.matches(&help).count(), 1, "{out}");
    assert!(out.contains("`--whole` explores all of it"), "{out}");
    assert!(out.contains(": undecided: in this part after ") && !out.contains('✗'), "{out}");
}

/// The limit of states suffices for the parts and not for the whole line: conflicts are decided. Whether home can be reached is listed as not
/// decided, as for lines of more stations.
#[test]
fn conflicts_are_decided_in_parts_where_the_whole_line_is_too_much() {
    let output = linewright(&["check", shipped().to_str().unwrap(), "--states", "100000", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found = json(&output);
    let explorations = found["explorations"].as_array().unwrap();
    let properties = || explorations.iter().flat_map(|exploration| exploration["properties"].as_array().unwrap());
    let with = |verdict: &str| {
        let of_it = properties().filter(|property| property["verdict"] == verdict);
        of_it.map(|property| property["name"].as_str().unwrap()).collect::<Vec<_>>()
    };
    let conflicts = found["line_checks"].to_string().matches("separated: ").count();
    let (undecided, holds) = (with("undecided"), with("holds"));
    assert_eq!(undecided, [""; 0]);
    let of_whole = explorations[1]["properties"].to_string();
    assert!(!of_whole.contains("home can be reached"), "{of_whole}");
    assert!(
        found["not_decided"].to_string().contains("between which there is no [[conflict]]: transfer and mill_1"),
        "{found}"
    );
    assert!(
        found["not_decided"].to_string().contains("home can be reached, from every state of the whole line"),
        "{found}"
    );
    let mut never: Vec<&str> = holds.into_iter().filter(|name| name.starts_with("never: ")).collect();
    never.sort_unstable();
    never.dedup();
    assert_eq!((conflicts, never.len(), with("fails").len()), (2, 2, 0));
    let help = explorations[1]["help"].as_str().unwrap();
    assert!(help.contains("decided by the parts below") && help.contains("`--whole --states "), "{help}");
}

/// Of three stations in a ring the parts are few states, and the whole is expected to have far more than the limit: only the first of it are
/// looked at, and the conflicts are decided.
#[test]
fn of_a_whole_line_that_is_far_too_large_only_the_first_states_are_looked_at() {
    let scratch = Scratch::new();
    let shape = LineShape { stations: 3..=3, operations: 2..=3, more_arrows: 0, ..LineShape::default() };
    let ring = scratch.file("ring.toml", &generate::text(&generate::line(&shape, 27)));
    let output = linewright(&["check", &ring, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found = json(&output);
    let explorations = found["explorations"].as_array().unwrap();
    let parts = explorations.iter().filter(|of| of["scope"].as_str().unwrap().starts_with("part: ")).count();
    assert_eq!((explorations[1]["kept"].as_u64(), parts), (Some(500_000), 6), "each pair, with restarts and without");
    let help = explorations[1]["help"].as_str().unwrap();
    assert!(help.contains("000000 kept states are expected of the whole"), "{help}");
}

/// The stations of a ring that are kept apart by way of the third alone: the arrows to be written stand below the part, and decide it.
#[test]
fn in_a_ring_the_arrows_that_decide_a_part_are_written_out() {
    let scratch = Scratch::new();
    let row = include_str!("../../proof/tests/row.toml");
    let check = |text: &str| linewright(&["check", &scratch.file("ring.toml", text), "--states", "100000"]);
    let output = check(row);
    let out = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let (_, help) = out.split_once("they delay nothing:\n").unwrap_or_else(|| panic!("{out}"));
    let arrow = help.lines().next().unwrap().trim();
    assert!(!out.contains("and so: s2 is in the way"), "a way that the line does not have: {out}");
    assert!(out.contains("; arrows named below the parts decide some of them\n"), "{out}");
    let (from, to) = arrow.split_once(", ").unwrap();
    let mended = format!("{row}\n[[arrow]]\n{from}\n{}\n", to.replace(", ", "\n"));
    let out = text(&check(&mended).stdout).to_owned();
    assert!(!out.contains("? never: s2 is in the way"), "{arrow}: {out}");
}

/// The first and the third of a row meet where nothing joins them; the second one between keeps them apart.
#[test]
fn a_conflict_that_a_part_meets_is_looked_at_with_the_stations_between() {
    let scratch = Scratch::new();
    let row = scratch.file("row.toml", include_str!("../../proof/tests/row.toml"));
    let output = linewright(&["check", &row, "--mode", "auto"]);
    let out = text(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    assert!(out.contains("✓ never: s2 is in the way: in the larger part of s0, s1, s2"), "{out}");
    assert!(
        out.ends_with(
            " checks hold, 6 warnings; by parts: conflicts and each station are decided, the whole line is left open\n"
        ),
        "{out}"
    );
    assert!(
        out.contains("no [[conflict]], joined by arrows: s0 and s1, s0 and s3, s1 and s2; others: s1 and s3,"),
        "{out}"
    );
    // Without the rule of the second one they meet there, too.
    let broken = include_str!("../../proof/tests/row.toml").replace("from = \"s1: back\"", "from = \"s1: forth\"");
    let broken =
        broken.replacen("from = \"s0: back\"\nto = \"s1: forth\"", "from = \"s0: forth\"\nto = \"s1: forth\"", 1);
    let output = linewright(&["check", &scratch.file("broken.toml", &broken), "--mode", "auto"]);
    let out = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(out.contains("? never: s2 is in the way: undecided: in this part after "), "{out}");
}
