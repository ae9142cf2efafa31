//! `linewright interface`, as a user meets it.

use crate::support::command::{json, linewright, text};

#[test]
fn interfaces_are_listed_and_shown_by_any_end_of_their_names() {
    let all = linewright(&["interface"]);
    let listed = text(&all.stdout)
        .lines()
        .find(|line| line.starts_with("linewright_msgs/msg/StationState "))
        .expect("it is listed");
    let hash = listed.split_whitespace().nth(1).expect("a hash");
    assert!(hash.starts_with("RIHS01_") && hash.len() == 71, "{listed}");
    for name in ["StationState", "msg/StationState", "linewright_msgs/StationState", "linewright_msgs/msg/StationState"]
    {
        let output = linewright(&["interface", name]);
        let shown = text(&output.stdout);
        let begin = format!("# linewright_msgs/msg/StationState\n# {hash}\n\n");
        assert!(shown.starts_with(&begin) && shown.contains("\nuint64 "), "{name}: {shown}");
    }
    let shown = json(&linewright(&["interface", "std_msgs/String", "--json"]));
    assert_eq!(shown["name"], "std_msgs/msg/String");
    assert!(shown["definition"].as_str().unwrap().contains("string data"), "{shown}");
}

#[test]
fn a_name_that_is_none_has_what_was_meant() {
    let output = linewright(&["interface", "StationStat"]);
    assert_eq!(output.status.code(), Some(1));
    let error = text(&output.stderr);
    assert!(error.contains("no interface of a line is named `StationStat`"), "{error}");
    assert!(error.contains("did you mean `StationState`?"), "{error}");
}
