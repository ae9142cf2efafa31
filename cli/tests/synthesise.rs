//! `linewright synthesise`, as a user meets it: the built command, its output and its exit code.

use crate::support::command::{Scratch, json as printed, linewright, text};

fn two_robots() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../launch-config/lines/two-robot-cell").to_owned()
}

/// The shipped cell with an edit of its relations, in a directory of its own.
fn edited(scratch: &Scratch, old: &str, new: &str) -> String {
    let dir = scratch.path("cell");
    std::fs::create_dir_all(&dir).expect("a directory");
    for file in ["relations.toml", "operations.csv", "relations.csv"] {
        let text = std::fs::read_to_string(format!("{}/{file}", two_robots())).expect("it is shipped");
        let text = if file == "relations.csv" { text.replacen(old, new, 1) } else { text };
        std::fs::write(format!("{dir}/{file}"), text).expect("a file");
    }
    dir
}

#[test]
fn the_added_predecessor_has_its_reason_in_every_form() {
    let output = linewright(&["synthesise", &two_robots()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let shown = text(&output.stdout);
    assert!(shown.contains("    21(P2) get gripper: 56(P1) finished\n"), "{shown}");
    assert!(shown.contains("R2 cannot start 52(P1) get gripper: it waits for zone gripper, which R1 has"), "{shown}");
    let object = printed(&linewright(&["synthesise", &two_robots(), "--json"]));
    assert_eq!(object["supervisors"][1]["added"][0]["operation"], "21(P2)");
    assert_eq!(object["supervisors"][1]["added"][0]["condition"], "56(P1) finished");
    assert_eq!(object["supervisors"][0]["added"].as_array().map(Vec::len), Some(0));
    let table = linewright(&["synthesise", &two_robots(), "--csv", "--products", "A,A"]);
    assert!(text(&table.stdout).contains("\nA A,P2,R1,21,get gripper,,56(P1) finished\n"), "{table:?}");
}

#[test]
fn a_contradiction_is_named_and_fails() {
    let scratch = Scratch::new();
    // R1 waits for R2 while it has the gripper that R2 needs for it.
    let cell = edited(&scratch, "R1,25,,", "R1,25,52,");
    let output = linewright(&["synthesise", &cell, "--products", "A"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let shown = text(&output.stdout);
    assert!(shown.contains("the tables contradict each other") && shown.contains("25 after 52"), "{shown}");
}

#[test]
fn errors_of_tables_and_arguments_are_explained() {
    let scratch = Scratch::new();
    let cell = edited(&scratch, "F1,33,53", "F1,33,5x");
    let output = linewright(&["synthesise", &cell]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(text(&output.stderr).contains("unknown operation `5x`"), "{output:?}");
    for (args, message) in [
        (vec!["synthesise", "no/such"], "no/such has no relations of operations"),
        (vec!["synthesise", &cell, "--products"], "a value is required"),
    ] {
        let output = linewright(&args);
        assert_ne!(output.status.code(), Some(0), "{output:?}");
        assert!(text(&output.stderr).contains(message), "{output:?}");
    }
    let good = two_robots();
    for (products, message) in [("B", "unknown condition `B`"), ("A,A,A", "`products_max` is 2")] {
        let output = linewright(&["synthesise", &good, "--products", products]);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(text(&output.stderr).contains(message), "{output:?}");
    }
}
