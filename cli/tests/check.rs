//! `linewright check` and `linewright new`, as a user meets them: the built command, its output and its exit code.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::support::command::{Scratch, into_full_disk, json, linewright, shipped, text, unread};
use crate::support::turn::beside_no_rig;

#[test]
fn the_shipped_line_passes_every_check() {
    let output = linewright(&["check", shipped().to_str().unwrap(), "--json"]);
    assert!(output.status.success(), "{output:?}");
    let found = json(&output);
    assert_eq!((&found["line"], &found["ok"]), (&"transfer_line".into(), &true.into()));
    let explorations = found["explorations"].as_array().unwrap();
    assert_eq!(explorations.len(), 4, "auto undisturbed, everything, and memories that get lost, in two parts");
    for exploration in explorations {
        assert_eq!(exploration["exhausted"], true, "{exploration}");
        let properties = exploration["properties"].as_array().unwrap();
        assert!(properties.len() >= 3 && properties.iter().all(|p| p["verdict"] == "holds"), "{exploration}");
        assert!(exploration["arcs"].as_u64() > exploration["states"].as_u64(), "{exploration}");
    }
    assert!(explorations[1]["states"].as_u64().unwrap() > 1_000_000, "{}", explorations[1]["states"]);
    let parts: Vec<&str> = explorations[2..].iter().map(|part| part["scope"].as_str().unwrap()).collect();
    assert!(parts[0].starts_with("part: transfer, clamp_1, restarted"), "{parts:?}");
    assert!(parts[1].starts_with("part: clamp_1, mill_1, restarted"), "{parts:?}");
    let last = explorations[1]["properties"].as_array().unwrap().last().unwrap();
    assert_eq!(last["name"], "every transition fires");
    let station = |index: usize| {
        let station = &found["stations"][index];
        let count = |key: &str| station[key].as_u64().unwrap();
        (station["name"].as_str().unwrap(), count("reversible"), count("irreversible"), count("places"))
    };
    assert_eq!(station(0), ("transfer", 10, 0, 60));
    assert_eq!(station(1), ("clamp_1", 2, 0, 12));
    assert_eq!(station(2), ("mill_1", 4, 1, 27));
    for station in found["stations"].as_array().unwrap() {
        let checks = station["checks"].as_array().unwrap();
        assert_eq!(checks.len(), 10);
        assert!(checks.iter().all(|check| check["ok"] == true && check["reason"] != ""), "{station}");
    }
    let line_checks = found["line_checks"].as_array().unwrap();
    assert_eq!(line_checks.len(), 7, "home, causality, three of the modes, two conflicts");
    assert!(line_checks.iter().all(|check| check["ok"] == true), "{line_checks:?}");
    let barriers = found["barriers"].as_array().unwrap();
    let bar = serde_json::json!([
        {"station": "transfer", "inputs": ["LS_vertical_0"]}, {"station": "clamp_1", "inputs": ["LS_open"]}
    ]);
    assert_eq!((barriers.len(), &barriers[0]["measured"]), (2, &bar), "{barriers:?}");
    assert!(barriers.iter().all(|barrier| barrier["by_themselves"]["verdict"] == "holds"), "{barriers:?}");
    assert_eq!((&found["warnings"], &found["problems"]), (&Value::Array(vec![]), &Value::Array(vec![])));
}

#[test]
fn the_table_names_every_station_and_what_is_not_decided() {
    let output = linewright(&["check", shipped().join("line.toml").to_str().unwrap(), "--structure"]);
    assert!(output.status.success(), "{output:?}");
    let out = text(&output.stdout);
    for part in [
        "transfer ",
        "clamp_1 ",
        "mill_1 ",
        "✓ operation causality",
        "not decided here:",
        "without --structure",
        "checks hold; by structure alone: nothing was explored",
    ] {
        assert!(out.contains(part), "no '{part}' in:\n{out}");
    }
    assert!(!out.contains('✗'), "{out}");
    assert!(output.stderr.is_empty(), "no warnings: {output:?}");
}

/// The shipped line is explored for far longer than its structure takes.
#[test]
fn what_needs_no_exploration_is_printed_before_it() {
    use std::io::{BufRead, BufReader};
    let _no_rig = beside_no_rig();
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    let command = command.args(["check", shipped().to_str().unwrap()]);
    let mut check = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("the command starts");
    let mut lines = BufReader::new(check.stdout.take().expect("a pipe")).lines().map(|line| line.expect("text"));
    let found = lines.by_ref().find(|line| line.starts_with("✓ separated: the tool of mill 1"));
    let goes_on = check.try_wait().expect("it is our child").is_none();
    check.kill().and_then(|()| check.wait()).expect("it is our child");
    assert!(found.is_some() && goes_on, "{found:?}");
    assert!(!lines.any(|line| line.contains("the whole line")), "it was explored by then");
}

#[test]
fn an_arrow_that_is_the_wrong_way_round_is_named_with_its_line() {
    let scratch = Scratch::new();
    let file = scratch.changed(
        "from = \"mill_1: reset main slide\"\nto = \"clamp_1: return clamp\"",
        "from = \"clamp_1: return clamp\"\nto = \"mill_1: reset main slide\"",
    );
    let output = linewright(&["check", &file, "--structure", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found = json(&output);
    let failed = found["line_checks"].as_array().unwrap().iter().find(|check| check["ok"] == false).unwrap();
    let reason = failed["reason"].as_str().unwrap();
    assert!(reason.contains("may be the wrong way round"), "{reason}");
    // Of the arrow the header, which stands before `from` and `to`.
    let text = scratch.read("line.toml");
    let to = text.lines().position(|line| line == "to = \"mill_1: reset main slide\"").unwrap();
    assert!(reason.ends_with(&format!("({file}:{})", to - 1)), "{reason}");
}

#[test]
fn a_conflict_that_no_arrow_prevents_is_a_failed_check() {
    let scratch = Scratch::new();
    let file = scratch.changed("lag = 0\nmodes = [\"auto\", \"manual\"]", "lag = 0\nmodes = [\"auto\"]");
    let output = linewright(&["check", &file, "--structure", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found = json(&output);
    assert_eq!((&found["ok"], &found["problems"]), (&false.into(), &Value::Array(vec![])));
    let failed: Vec<&Value> = found["line_checks"].as_array().unwrap().iter().filter(|c| c["ok"] == false).collect();
    assert_eq!(failed.len(), 1, "{failed:?}");
    let reason = failed[0]["reason"].as_str().unwrap();
    assert!(reason.contains("\"transfer: 1st lift\"") && reason.contains("manual gets round"), "{reason}");

    // It is simulated all the same, with a warning.
    let simulated = linewright(&["simulate", &file, "--json"]);
    assert!(simulated.status.success() && json(&simulated)["ok"] == true, "{simulated:?}");
    let warning = format!("warning: `linewright check {file}` refuses this line");
    let told = text(&simulated.stderr);
    assert!(told.contains(&warning) && told.contains("separated: the bar is off its rest"), "{told}");
    let shipped = linewright(&["simulate", shipped().to_str().unwrap(), "--json"]);
    assert!(shipped.stderr.is_empty(), "{shipped:?}");

    // It is run only if that is asked for.
    let run = linewright(&["run", &file, "--cycles", "1", "--patience", "5"]);
    let told = text(&run.stderr);
    assert_eq!(run.status.code(), Some(1), "{told}");
    assert!(
        told.contains("refuses this line") && told.contains("separated: the bar") && told.contains("--unchecked"),
        "{told}"
    );

    // Exploring finds it as well, with a path.
    let plain = linewright(&["check", &file]);
    assert_eq!(plain.status.code(), Some(1));
    let out = text(&plain.stdout);
    assert!(out.contains("✗ separated: the bar is off its rest"), "{out}");
    assert!(out.contains("✗ never: the bar is off its rest") && out.contains("clamp_1: "), "{out}");
    assert!(out.contains("and so: the bar is off its rest"), "{out}");
}

/// Explores the shipped line with something switched off; gives the one property that fails, with its counterexample.
fn missed(options: &[&str]) -> Value {
    let dir = shipped();
    let output = linewright(&[&["check", dir.to_str().unwrap(), "--json"], options].concat());
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found = json(&output);
    let explorations = found["explorations"].as_array().unwrap();
    let properties = explorations.iter().flat_map(|exploration| exploration["properties"].as_array().unwrap());
    let failed: Vec<&Value> = properties.filter(|property| property["verdict"] == "fails").collect();
    let last = *failed.last().expect("something fails");
    assert!(!last["counterexample"]["steps"].as_array().unwrap().is_empty(), "{last}");
    assert!(!last["counterexample"]["chart"].as_array().unwrap().is_empty(), "{last}");
    last.clone()
}

/// The effect of each rule is tested with the explorer; here, that each option reaches its rule.
#[test]
fn a_rule_switched_off_has_a_counterexample() {
    let bar = "never: the bar is off its rest while clamp 1 is not open";
    let sound = "stations sound: one token in each branch, counts of one cycle, no output without a motion";
    for (options, name) in [
        (&["--flags", "--views", "stale"][..], bar),
        (&["--flags", "--views", "fresh"], bar),
        (&["--without", "withdraw-first"], bar),
        (&["--without", "agreement"], bar),
        (&["--without", "fresh-numbers"], bar),
        (&["--without", "redo-round"], sound),
    ] {
        assert_eq!(missed(options)["name"], name, "{options:?}");
    }
    let dir = shipped();
    for rule in ["measured", "measured-stop"] {
        let options = ["--json", "--mode", "auto", "--no-faults", "--without", rule];
        let output = linewright(&[&["check", dir.to_str().unwrap()], &options[..]].concat());
        assert_eq!(output.status.code(), Some(1), "{rule}");
        let found = &json(&output)["barriers"][0]["by_themselves"];
        let steps = found["counterexample"].as_array().unwrap().len();
        assert_eq!((&found["verdict"], steps), (&"fails".into(), 4), "{rule}: {found}");
    }
}

#[test]
fn a_limit_leaves_it_undecided_and_is_no_yes() {
    let output = linewright(&["check", shipped().to_str().unwrap(), "--states", "1000"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let out = text(&output.stdout);
    assert!(out.contains("undecided after") && out.contains("? transfer_line:") && !out.contains('✗'), "{out}");
    assert!(out.contains("the limit of states was reached") && out.contains("help: 1000 states are kept"), "{out}");
    assert!(out.contains("`--states 2000`"), "{out}");
    // A station that can do much is in memory before the first state is looked at.
    let output = linewright(&["check", shipped().to_str().unwrap(), "--memory", "1"]);
    let out = text(&output.stdout);
    assert!(out.contains("the limit of memory was reached") && out.contains("`--memory 2`"), "{out}");
}

#[test]
fn all_problems_of_a_text_are_reported_with_their_places() {
    let scratch = Scratch::new();
    let file = scratch.changed("watchdog_s = 1.0", "watchdog_s = 0.1\nwatchdogs = 2");
    let output = linewright(&["check", &file, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found = json(&output);
    assert_eq!((&found["line"], &found["ok"]), (&Value::Null, &false.into()));
    let problems = found["problems"].as_array().unwrap();
    assert!(problems.len() >= 2, "{problems:?}");
    assert!(problems.iter().all(|p| p["line"].as_u64() > Some(1) && p["column"].as_u64() > Some(0)), "{problems:?}");

    let plain = linewright(&["check", &file]);
    assert_eq!(plain.status.code(), Some(1));
    assert!(plain.stdout.is_empty() && text(&plain.stderr).contains("watchdog"), "{plain:?}");
}

/// An error that only the DBC file shows is a problem of the description all the same, at its place.
#[test]
fn names_that_a_dbc_file_does_not_have_are_problems_of_the_text() {
    let scratch = Scratch::new();
    let frames = r#"
[[device]]
name = "gauge"
station = "clamp_1"

[device.dbc]
file = "gauge.dbc"
receive = [{ message = "GaugeStatus", timeout_ms = 100 }]
"#;
    let head = "[console]\n";
    let file = scratch.changed(head, &format!("{frames}\n{head}"));
    let database = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Gauge\n\nBO_ 291 GaugeState: 8 Gauge\n";
    scratch.file("gauge.dbc", database);
    let output = linewright(&["check", &file, "--structure", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found = json(&output);
    assert_eq!((&found["ok"], found["problems"].as_array().map(Vec::len)), (&false.into(), Some(1)), "{found}");
    let problem = &found["problems"][0];
    assert_eq!(problem["message"], "gauge.dbc has no message `GaugeStatus`", "{problem}");
    let text = scratch.read("line.toml");
    let line = text.lines().nth(problem["line"].as_u64().expect("a line") as usize - 1).expect("of the text");
    assert!(
        line[problem["column"].as_u64().expect("a column") as usize - 1..].starts_with("\"GaugeStatus\""),
        "{line}"
    );

    // A file that is no database has a line of its own, not one of the description's.
    scratch.file("gauge.dbc", &database.replace("291", "x"));
    let output = linewright(&["check", &file, "--structure", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let message = json(&output)["problems"][0]["message"].as_str().expect("a message").to_owned();
    assert!(message.contains("device `gauge`") && message.contains("gauge.dbc: line "), "{message}");

    // What leads out of the description's directory is not read, whatever it is.
    for elsewhere in ["../gauge.dbc", "/etc/passwd", "sub/../../gauge.dbc"] {
        let file = scratch.changed(head, &format!("{}\n{head}", frames.replace("gauge.dbc", elsewhere)));
        let found = json(&linewright(&["check", &file, "--structure", "--json"]));
        assert!(found["problems"].to_string().contains("is not in the directory of the description"), "{found}");
    }
}

#[test]
fn a_warning_is_shown_and_does_not_fail() {
    let scratch = Scratch::new();
    let file = scratch.changed("buttons = [\"PB_1\"", "buttons = [\"PB_9\", \"PB_1\"");
    let output = linewright(&["check", &file, "--structure", "--json"]);
    assert!(output.status.success(), "{output:?}");
    assert!(json(&output)["warnings"].to_string().contains("PB_9"), "{output:?}");

    let plain = linewright(&["check", &file, "--structure"]);
    assert!(plain.status.success() && text(&plain.stderr).contains("PB_9"), "{plain:?}");
}

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let (line, scratch) = (shipped(), Scratch::new());
    let net = "<pnml><net id=\"n\"><place id=\"p\"/><transition id=\"t\"/></net></pnml>";
    let (line, net) = (line.to_str().unwrap(), scratch.file("net.pnml", net));
    for (command, of) in [("check --structure", line), ("simulate", line), ("analyse", &net)] {
        for json in [&[][..], &["--json"]] {
            let words: Vec<&str> = command.split(' ').chain([of]).chain(json.iter().copied()).collect();
            let output = unread(&words);
            assert!(output.status.success() && output.stderr.is_empty(), "{words:?}: {output:?}");
        }
    }
}

#[test]
fn an_output_that_cannot_be_written_is_an_error() {
    let (line, scratch) = (shipped(), Scratch::new());
    let net = scratch.file("net.pnml", "<pnml><net id=\"n\"><place id=\"p\"/></net></pnml>");
    let line = line.to_str().unwrap();
    for words in [
        &["check", "--structure", line][..],
        &["check", "--structure", "--json", line],
        &["simulate", line],
        &["simulate", "--json", line],
        &["analyse", "--json", &net],
        &["schema", "line"],
        &["completions", "bash"],
        &["--help"],
    ] {
        let output = into_full_disk(words);
        assert_eq!(output.status.code(), Some(1), "{words:?}: {output:?}");
        assert!(
            text(&output.stderr).contains("cannot write to standard output: No space left"),
            "{words:?}: {output:?}"
        );
    }
}

#[test]
fn what_is_not_explored_cannot_be_explored_otherwise() {
    for option in [&["--flags"][..], &["--whole"], &["--states", "5"], &["--without", "agreement"], &["--mode", "auto"]]
    {
        let output = linewright(&[&["check", shipped().to_str().unwrap(), "--structure"], option].concat());
        assert_eq!(output.status.code(), Some(2), "{option:?}");
        assert!(text(&output.stderr).contains("cannot be used with"), "{output:?}");
    }
}

#[test]
fn a_file_that_is_not_there_fails_and_says_so() {
    let output = linewright(&["check", "no/such/line"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("no/such/line"), "{output:?}");
    let output = linewright(&["check", "no/such/line", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(json(&output)["problems"][0]["message"].as_str().unwrap().contains("no/such/line"), "{output:?}");
}

#[test]
fn a_new_line_can_be_checked_and_is_not_overwritten() {
    let scratch = Scratch::new();
    let dir = scratch.path("fast");
    let new = ["new", "transfer-line", "--dir", &dir];
    let output = linewright(&[&new[..], &["--machines", "3", "--time-scale", "0.1"]].concat());
    assert!(output.status.success(), "{output:?}");
    let written = std::fs::read_to_string(format!("{dir}/line.toml")).unwrap();
    assert!(written.contains("mill_3") && written.contains("duration_s = 0.07"));

    let checked = linewright(&["check", &dir, "--structure", "--json"]);
    assert!(checked.status.success(), "{checked:?}");
    assert_eq!(json(&checked)["stations"].as_array().unwrap().len(), 7);

    let again = linewright(&new);
    assert_eq!(again.status.code(), Some(1));
    assert!(text(&again.stderr).contains("--force"), "{again:?}");
    assert_eq!(std::fs::read_to_string(format!("{dir}/line.toml")).unwrap(), written, "left as it was");

    let forced = linewright(&[&new[..], &["--force"]].concat());
    assert!(forced.status.success(), "{forced:?}");
    let shipped = std::fs::read_to_string(shipped().join("line.toml")).unwrap();
    let (schema, shipped) = shipped.split_once('\n').expect("several lines");
    assert!(schema.starts_with("#:schema "), "a path from where the shipped file is: {schema}");
    assert_eq!(std::fs::read_to_string(format!("{dir}/line.toml")).unwrap(), shipped);
}

#[test]
fn a_new_line_keeps_to_its_bounds() {
    let scratch = Scratch::new();
    let dir = scratch.path("line");
    for (option, values) in [("--machines", ["0", "24"]), ("--time-scale", ["0.001", "nan"])] {
        for value in values {
            let output = linewright(&["new", "transfer-line", "--dir", &dir, option, value]);
            assert_eq!(output.status.code(), Some(2), "{option} {value}");
            let told = text(&output.stderr);
            assert!(told.contains("1 to 23 machines") || told.contains("from 0.01 to 1000"), "{told}");
        }
    }
    assert!(!Path::new(&dir).exists(), "nothing was made");
}

#[test]
fn a_devices_file_that_cannot_be_read_is_told_in_json_too() {
    let scratch = Scratch::new();
    let path = scratch.changed("node = 0x21\n", "node = 0x21\nfile = \"nobody.eds\"\n");
    let output = linewright(&["check", &path, "--json", "--structure"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found = json(&output);
    assert_eq!(found["ok"], false);
    assert!(found.to_string().contains("nobody.eds"), "{found}");
}

/// Where no arrow leads back, `check` warns of the stations that may run ahead, by name; it is no passed check.
#[test]
fn stations_that_may_run_ahead_are_a_warning_with_the_arrow_that_is_missing() {
    let scratch = Scratch::new();
    // Of the two arrows back from the clamp none holds in auto.
    let mut line = std::fs::read_to_string(shipped().join("line.toml")).expect("the shipped line is there");
    for (to, modes) in [("1st lift", "\"auto\", \"manual\""), ("return transfer", "\"auto\"")] {
        let back = format!("to = \"transfer: {to}\"\nlag = 0\nmodes = [{modes}]");
        assert!(line.contains(&back), "the shipped line has changed");
        line = line.replacen(&back, &back.replace(modes, "\"manual\""), 1);
    }
    let file = scratch.file("line.toml", &line);
    let output = linewright(&["check", &file, "--structure", "--json"]);
    let warnings = &json(&output)["warnings"];
    let message = warnings[0]["message"].as_str().unwrap_or_else(|| panic!("{output:?}"));
    assert!(message.starts_with("transfer may run ahead of clamp_1, mill_1 in auto without limit"), "{message}");
    let help = warnings[0]["help"].as_str().expect("it says what to do");
    assert!(help.contains("from = \"clamp_1: return clamp\", to = \"transfer: 1st lift\". "), "{help}");
    assert_eq!(warnings[0]["line"], Value::Null, "an arrow that is not there has no place");
    let shown = linewright(&["check", &file, "--structure"]);
    assert!(text(&shown.stdout).contains(&format!("\n! {message}\n  help: {help}\n")), "{shown:?}");
}
