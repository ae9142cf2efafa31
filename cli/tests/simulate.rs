//! `linewright simulate`, as a user meets it: the built command, its output, its files and its exit code.

#[path = "support/command.rs"]
mod command;

use std::process::Output;

use command::{Scratch, json, linewright, shipped, text};

fn simulate(args: &[&str]) -> Output {
    linewright(&[&["simulate", shipped().to_str().unwrap()], args].concat())
}

#[test]
fn the_shipped_line_as_a_bar_chart() {
    let output = simulate(&["--cycles", "2"]);
    assert!(output.status.success(), "{output:?}");
    let shown = text(&output.stdout);
    assert!(
        shown.starts_with(
            "Transfer line\n2 of 2 cycles done in 7.118 s\ncycle time 3.558 s simulated, 3.560 s planned\n"
        ),
        "{shown}"
    );
    let row = shown.lines().find(|line| line.contains("feed main slide")).expect("a row for the feed");
    assert!(row.contains("! │") && row.contains("████████████") && row.ends_with("2.260 – 2.959"), "{row}");
    assert!(
        shown.contains("critical path, 3.558 s:") && shown.contains("transfer: 1st lift for clamp_1: return clamp")
    );
}

#[test]
fn the_json_holds_everything_and_follows_from_the_seed() {
    let args = |seed| ["--json", "--cycles", "4", "--jitter", "3", "--variation", "5", "--seed", seed];
    let output = simulate(&args("7"));
    assert!(output.status.success(), "{output:?}");
    let found = json(&output);
    assert_eq!((&found["ok"], &found["cycles"]), (&true.into(), &4.into()));
    assert_eq!(found["operations"].as_array().map(Vec::len), Some(17));
    assert_eq!(found["cycle_ends_s"].as_array().map(Vec::len), Some(4));
    for list in ["critical_path", "waits", "events"] {
        assert!(found[list].as_array().is_some_and(|list| !list.is_empty()), "{list}");
    }
    for list in ["conflicts", "faults"] {
        assert_eq!(found[list].as_array().map(Vec::len), Some(0), "{list}");
    }
    assert_eq!(output.stdout, simulate(&args("7")).stdout);
    assert_ne!(output.stdout, simulate(&args("8")).stdout);
}

#[test]
fn the_shipped_scenario_goes_as_it_expects_and_leaves_its_trace_and_chart() {
    let scenario = shipped().join("scenarios/jammed-clamp.toml");
    let scratch = Scratch::new();
    let (trace, chart) = (scratch.path("trace.txt"), scratch.path("chart.svg"));
    let output = simulate(&["--scenario", scenario.to_str().unwrap(), "--trace", &trace, "--svg", &chart]);
    assert!(output.status.success(), "{output:?}");
    let trace = scratch.read("trace.txt");
    assert!(trace.contains("clamp_1 (cycle 2) stops advance clamp: took too long"), "{trace}");
    let chart = scratch.read("chart.svg");
    assert!(chart.starts_with("<svg") && chart.ends_with("</svg>\n"));
    // Of 17 operations two bars each, and the three of the legend, and the ground.
    assert_eq!(chart.matches("<rect").count(), 17 * 2 + 3 + 1);
    assert_eq!(chart.matches("marker-end").count(), 5, "an arrow of the description each");
}

#[test]
fn a_line_that_cannot_go_on_is_a_failure_with_its_reasons() {
    let scratch = Scratch::new();
    let path = scratch.file("jam.toml", "[[step]]\nwhen = \"cycles >= 1\"\njam = \"transfer: advance transfer\"\n");
    let output = simulate(&["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains("nothing happens any more"), "{said}");
    assert!(said.contains("transfer waits for recovery of advance transfer in manual (took too long)"), "{said}");
}

#[test]
fn mistakes_of_a_scenario_are_shown_in_their_place_all_at_once() {
    let scratch = Scratch::new();
    let path = scratch.file("slip.toml", "[[step]]\njam = \"clmp_1: advance clamp\"\n\n[[step]]\ncomand = \"stop\"\n");
    let output = simulate(&["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    for part in
        ["2 errors", "unknown station `clmp_1`", "did you mean `clamp_1`?", "unknown key `comand`", "slip.toml:2:8"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn a_failed_expectation_is_shown_where_it_stands() {
    let scratch = Scratch::new();
    let path = scratch.file("no.toml", "[[step]]\nwhen = \"cycles >= 1\"\nexpect = \"line is hand\"\n");
    let output = simulate(&["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("expected line is hand, which does not hold"), "{output:?}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let output = simulate(&["--scenario", "nowhere.toml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("nowhere.toml"), "{output:?}");
    assert_eq!(simulate(&["--delay", "-1"]).status.code(), Some(2));
}

#[test]
fn long_names_get_room_in_the_picture() {
    let scratch = Scratch::new();
    let width = |name: &str| {
        let name = format!("name = \"{name}\"");
        let line = scratch.changed("name = \"decel\"", &name);
        let chart = scratch.path("chart.svg");
        let output = linewright(&["simulate", &line, "--cycles", "1", "--svg", &chart]);
        assert!(output.status.success(), "{output:?}");
        let chart = scratch.read("chart.svg");
        let size = chart.split("viewBox=\"0 0 ").nth(1).and_then(|rest| rest.split(' ').next());
        size.and_then(|size| size.parse::<f64>().ok()).unwrap_or_else(|| panic!("{chart}"))
    };
    let (short, long) = (width("forward"), width(&"decelerate ".repeat(6)[..64]));
    assert!(long >= short + 100.0, "{short}, {long}");
}
