//! `linewright check` and `linewright nets` of flexible cells, as a user meets them.

use std::path::Path;

use serde_json::Value;

use crate::support::command::{Scratch, is_quiet, json, linewright, shipped, text};

fn cell_text(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines").join(name).join("cell.toml");
    std::fs::read_to_string(path).expect("the shipped cell is there")
}

/// A directory with the shipped cell, changed.
fn changed(scratch: &Scratch, name: &str, edits: &[(&str, &str)]) -> String {
    let mut text = cell_text(name);
    for (from, to) in edits {
        assert!(text.contains(from), "nothing to replace: {from}");
        text = text.replacen(from, to, 1);
    }
    scratch.file("cell.toml", &text);
    scratch.path("")
}

fn checked(dir: &str, options: &[&str]) -> (Option<i32>, Value) {
    let output = linewright(&[&["check", dir, "--json"], options].concat());
    (output.status.code(), json(&output))
}

fn verdicts(found: &Value) -> Vec<&str> {
    let properties = found["cell"]["properties"].as_array().expect("a list");
    properties.iter().map(|property| property["verdict"].as_str().expect("a word")).collect()
}

#[test]
fn the_shipped_cells_pass() {
    for name in ["workcell-c1", "assembly-cell"] {
        let dir = shipped().join("..").join(name);
        let (code, found) = checked(dir.to_str().unwrap(), &[]);
        assert_eq!((code, &found["ok"], &found["line"]), (Some(0), &true.into(), &found["cell"]["name"]), "{found}");
        // Three of the parts, three of what fails, seven of the order protocol.
        assert_eq!(verdicts(&found), ["holds"; 13], "{found}");
        let groups = found["cell"]["groups"].as_array().unwrap();
        assert_eq!((groups.len(), &groups[0]["exhausted"]), (1, &true.into()));
        assert!(groups[0]["states"].as_u64() > Some(1000), "{found}");

        // Each of its stations is explored, alone.
        let explored = found["explorations"].as_array().expect("a list");
        assert!(explored.len() >= 3 && explored.iter().all(|one| one["exhausted"] == true), "{found}");
    }

    // For people, and of the cell alone.
    let scratch = Scratch::new();
    let plain = linewright(&["check", &changed(&scratch, "workcell-c1", &[])]);
    assert!(plain.status.success() && is_quiet(&plain), "{plain:?}");
    let out = text(&plain.stdout);
    assert!(out.contains("✓ no part gets stuck: in all") && out.contains("6 checks hold"), "{out}");
    assert!(out.contains("not decided here:") && !out.contains("station"), "{out}");
}

#[test]
fn without_the_reservation_either_cell_has_a_story() {
    for name in ["workcell-c1", "assembly-cell"] {
        let scratch = Scratch::new();
        let dir = changed(&scratch, name, &[("reserve = true", "reserve = false")]);
        let (code, found) = checked(&dir, &[]);
        assert_eq!((code, verdicts(&found)), (Some(1), vec!["fails", "fails", "holds"]), "{found}");
        let stuck = &found["cell"]["properties"][0];
        assert!(stuck["help"].as_str().unwrap().contains("`reserve = true`"), "{stuck}");
        let story = &stuck["counterexample"];
        assert!(story["steps"].as_array().unwrap().len() > 3, "{story}");
        // The robot has a part and nowhere to put it; the machine has one and no carrier for it.
        let needs: Vec<&str> = story["resources"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|resource| resource["parts"].as_array().unwrap())
            .flat_map(|part| part["needs"].as_array().unwrap())
            .filter_map(Value::as_str)
            .collect();
        assert!(needs.iter().any(|needs| needs.contains("needs room in")), "{needs:?}");
        assert!(needs.iter().any(|needs| needs.contains(" free")), "{needs:?}");

        let plain = linewright(&["check", &dir]);
        let out = text(&plain.stdout);
        assert_eq!(plain.status.code(), Some(1));
        assert!(out.contains("and so: no activity of this group can start again") && out.contains("  help: "), "{out}");
    }
}

#[test]
fn too_large_a_wip_max_is_found_with_the_largest_that_is_not() {
    let scratch = Scratch::new();
    let edits = [("capacity = 6", "capacity = 4"), ("wip_max = 6", "wip_max = 9")];
    let dir = changed(&scratch, "workcell-c1", &edits);
    let (code, found) = checked(&dir, &[]);
    assert_eq!((code, &found["cell"]["sound_parts"]), (Some(1), &4.into()), "{found}");
    let stuck = &found["cell"]["properties"][0];
    assert!(stuck["help"].as_str().unwrap().starts_with("`wip_max = 4` in `[cell]`"), "{stuck}");
    assert!(found["cell"]["warnings"].to_string().contains("9 parts at once, and stores for 4"), "{found}");

    let dir = changed(&scratch, "workcell-c1", &[edits[0], ("wip_max = 6", "wip_max = 4")]);
    assert_eq!(checked(&dir, &[]).0, Some(0));
    let dir = changed(&scratch, "workcell-c1", &[edits[0], ("wip_max = 6", "wip_max = 5")]);
    assert_eq!(checked(&dir, &[]).0, Some(1));
}

#[test]
fn a_limit_leaves_it_undecided_and_says_how_far_it_came() {
    let dir = shipped().join("../workcell-c1");
    let dir = dir.to_str().unwrap();
    let (code, found) = checked(dir, &["--states", "500"]);
    assert_eq!((code, verdicts(&found)), (Some(1), vec!["undecided", "undecided", "holds"]), "{found}");
    let group = &found["cell"]["groups"][0];
    assert_eq!(group["exhausted"], false);
    let sound = found["cell"]["sound_parts"].as_u64().expect("a number");
    assert!((1..6).contains(&sound), "{found}");
    let reason = found["cell"]["properties"][0]["reason"].as_str().expect("a reason");
    assert!(reason.contains(&format!("with up to {sound} part")) && reason.contains("undecided after"), "{reason}");
    let plain = linewright(&["check", dir, "--states", "3"]);
    assert!(text(&plain.stdout).contains("? workcell_c1: "), "{plain:?}");
}

/// More states than the cell's net has, and fewer than the orders of its largest activity.
#[test]
fn orders_that_are_undecided_are_no_success_and_say_what_looks_further() {
    let dir = shipped().join("../assembly-cell");
    let dir = dir.to_str().unwrap();
    let (code, found) = checked(dir, &["--states", "15000"]);
    let verdicts = verdicts(&found);
    assert_eq!((code, &found["ok"], &found["cell"]["ok"]), (Some(1), &false.into(), &false.into()), "{found}");
    assert_eq!((&verdicts[..6], &verdicts[6..]), (&["holds"; 6][..], &["undecided"; 7][..]), "{found}");
    let property = &found["cell"]["properties"][6];
    assert!(property["reason"].as_str().is_some_and(|r| r.contains("the limit of states was reached")), "{property}");
    let plain = linewright(&["check", dir, "--states", "15000"]);
    let out = text(&plain.stdout);
    assert_eq!((plain.status.code(), out.matches("`--states 30000`").count()), (Some(1), 1), "{out}");
}

#[test]
fn some_parts_only_and_activities_in_progress_can_be_asked_for() {
    let scratch = Scratch::new();
    let dir = changed(&scratch, "assembly-cell", &[]);
    let (code, found) = checked(&dir, &["--parts", "1=2,2=2,3=1", "--expanded"]);
    // An explorer written in Python before counted 1,773 states and 6,516 steps.
    let group = &found["cell"]["groups"][0];
    assert_eq!(
        (code, group["states"].as_u64(), group["arcs"].as_u64()),
        (Some(0), Some(1_773), Some(6_516)),
        "{found}"
    );
    let output = linewright(&["check", &dir, "--parts", "4=1"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("no part type '4'; the cell has 1, 2, 3"), "{output:?}");
    let output = linewright(&["check", &dir, "--parts", "1"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}

#[test]
fn all_problems_of_a_cell_are_reported_with_their_places() {
    let scratch = Scratch::new();
    let edits = [("prototype = \"robot\"", "prototype = \"robt\""), ("capacity = 6", "capacity = 0")];
    let dir = changed(&scratch, "workcell-c1", &edits);
    let (code, found) = checked(&dir, &[]);
    assert_eq!((code, &found["ok"], &found["cell"]["name"]), (Some(1), &false.into(), &Value::Null));
    let problems = found["cell"]["problems"].as_array().unwrap();
    assert!(problems.len() >= 2, "{problems:?}");
    assert!(problems.iter().all(|p| p["line"].as_u64() > Some(1) && p["column"].as_u64() > Some(0)), "{problems:?}");
    let plain = linewright(&["check", &dir]);
    assert_eq!(plain.status.code(), Some(1));
    assert!(text(&plain.stderr).contains("robt") && text(&plain.stdout).contains("problems of the text"), "{plain:?}");
}

/// Workcell C1 beside its line, each with one edit; what `check --structure` prints, and its exit code.
fn beside_its_line(cell: (&str, &str), line: (&str, &str)) -> (Option<i32>, String, String) {
    let scratch = Scratch::new();
    let dir = changed(&scratch, "workcell-c1", &[cell]);
    let text_of_line = include_str!("../../launch-config/lines/workcell-c1/line.toml");
    assert!(text_of_line.contains(line.0), "nothing to replace: {}", line.0);
    scratch.file("line.toml", &text_of_line.replacen(line.0, line.1, 1));
    let output = linewright(&["check", &dir, "--structure"]);
    (output.status.code(), text(&output.stdout).to_owned(), text(&output.stderr).to_owned())
}

const AS_IT_IS: (&str, &str) = ("name = \"workcell_c1\"", "name = \"workcell_c1\"");

/// A time that is left out follows from the line, which is not known.
#[test]
fn errors_of_a_cell_whose_line_has_errors_point_to_the_line() {
    const TIMED: &str = "time_s = 12 # as planned\norders = [ # what stations are told: task, its parameters, and how long it may take\n  \
                         { station = \"robot\", task = \"load m1\", parameters = { slot = \"ST.position\" }, max_s = 24 },";
    let without_time =
        (TIMED, "orders = [\n{ station = \"robot\", task = \"load m1\", parameters = { slot = \"ST.position\" } },");
    let broken = ("[[station]]", "[[statio]]");
    for (cell, line, is_noted) in [(without_time, broken, true), (without_time, AS_IT_IS, false)] {
        let (code, _, errors) = beside_its_line(cell, line);
        assert_eq!((code == Some(1), errors.contains("mend that first")), (is_noted, is_noted), "{errors}");
    }
}

/// Errors in the text of a cell are all that is printed: nothing of the line is praised behind them.
#[test]
fn a_line_beside_a_cell_with_errors_is_not_judged() {
    let never = ("waits = [\"m1_ready\"]", "waits = [\"m1_clamped\"]");
    let unknown = ("task = \"load m1\"", "task = \"lod m1\"");
    for (cell, line, message) in
        [(unknown, AS_IT_IS, "has no task `lod m1`"), (AS_IT_IS, never, "`load M1` never completes")]
    {
        let (code, out, errors) = beside_its_line(cell, line);
        assert_eq!((code, out.trim()), (Some(1), "✗ workcell_c1: 1 problem of the text"), "{errors}");
        assert!(errors.contains(message), "{errors}");
    }
}

#[test]
fn warnings_of_a_text_are_counted_in_the_last_line() {
    let (short, long) = (("time_s = 25", "time_s = 0.1"), ("watchdog_s = 5.0", "watchdog_s = 5000"));
    for (line, number) in [(AS_IT_IS, "1 warning"), (long, "2 warnings")] {
        let (code, out, errors) = beside_its_line(short, line);
        let last = out.lines().last().unwrap_or_default();
        assert!(code == Some(0) && last.starts_with("! workcell_c1: "), "{out}{errors}");
        assert!(last.contains(&format!(" checks hold, {number}; by structure alone")), "{out}{errors}");
    }
    let (code, out, _) = beside_its_line(AS_IT_IS, AS_IT_IS);
    let last = out.lines().last().unwrap_or_default();
    assert!(code == Some(0) && last.starts_with("✓ workcell_c1: ") && last.contains(" checks hold; "), "{out}");
}

/// A line of two stations would do; the shipped one is at hand.
#[test]
fn a_cell_beside_a_line_is_checked_with_it() {
    let scratch = Scratch::new();
    scratch.changed("watchdog_s = 1.0", "watchdog_s = 1.0");
    let cell = cell_text("assembly-cell").replace("name = \"assembly_cell\"", "name = \"transfer_line\"");
    let cell = cell.split("[[exception]]").next().expect("the text before it");
    let without: Vec<&str> =
        cell.lines().filter(|line| !["station =", "presence ="].iter().any(|key| line.starts_with(key))).collect();
    let without = without.join("\n");
    // Orders stand in one line, or in one line each between brackets.
    let is_order = |line: &str| line.starts_with("orders =") || line.starts_with("  { station") || line == "]";
    let orders = without.lines().filter(|line| !is_order(line) && !line.starts_with("[[action]]"));
    let text_without: String =
        orders.filter(|line| !line.starts_with("of =")).map(|line| format!("{line}\n")).collect();
    scratch.file("cell.toml", &text_without);
    let dir = scratch.path("");
    let (code, found) = checked(&dir, &["--structure"]);
    assert_eq!((code, &found["line"]), (Some(0), &"transfer_line".into()), "{found}");
    assert_eq!((&found["cell"]["name"], verdicts(&found)), (&"transfer_line".into(), vec![]), "{found}");
    assert_eq!(found["cell"]["sound_parts"], Value::Null);

    // A station that the line does not have, and a line with an error: both are reported.
    scratch.file(
        "cell.toml",
        &text_without.replacen("prototype = \"robot\"", "prototype = \"robot\"\nstation = \"r\"", 1),
    );
    scratch.changed("watchdog_s = 1.0", "watchdogs = 1.0");
    let (code, found) = checked(&dir, &["--structure"]);
    assert_eq!((code, &found["ok"]), (Some(1), &false.into()));
    assert!(found["problems"].to_string().contains("watchdogs"), "{found}");
    scratch.changed("watchdog_s = 1.0", "watchdog_s = 1.0");
    let (code, found) = checked(&dir, &["--structure"]);
    assert_eq!((code, &found["problems"]), (Some(1), &Value::Array(vec![])), "{found}");
    assert!(found["cell"]["problems"].to_string().contains("the line has no station `r`"), "{found}");
}

#[test]
fn what_is_not_there_cannot_be_asked_about() {
    let scratch = Scratch::new();
    let cell = changed(&scratch, "workcell-c1", &[]);
    let output = linewright(&["check", &cell, "--flags"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("`--flags` needs the stations of a line"), "{output:?}");
    let output = linewright(&["check", shipped().to_str().unwrap(), "--structure", "--expanded"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let output = linewright(&["check", &cell, "--structure"]);
    assert!(output.status.success() && text(&output.stdout).contains("without --structure"), "{output:?}");
}

/// A task of a station.
type NamedTask<'n> = (&'n str, &'n str);

/// The shipped workcell, with conflicts of tasks at the end of its line.
fn in_conflict(scratch: &Scratch, conflicts: &[(&str, NamedTask<'_>, NamedTask<'_>)]) -> String {
    let dir = shipped().join("../workcell-c1");
    let text = |file: &str| std::fs::read_to_string(dir.join(file)).expect("it is there");
    let side = |(station, task): NamedTask<'_>| format!("{{ station = \"{station}\", task = \"{task}\" }}");
    let conflict = |&(why, a, b): &(&str, NamedTask<'_>, NamedTask<'_>)| {
        format!("\n[[conflict]]\nwhy = \"{why}\"\na = {}\nb = {}\n", side(a), side(b))
    };
    let added: String = conflicts.iter().map(conflict).collect();
    scratch.file("line.toml", &(text("line.toml") + &added));
    scratch.file("cell.toml", &text("cell.toml"));
    scratch.path("")
}

#[test]
fn tasks_in_conflict_are_kept_apart_by_the_cell_or_it_is_told_how_they_are_not() {
    let scratch = Scratch::new();
    let conflicts = [
        ("they never meet", ("robot", "load m1"), ("m1", "machine")),
        ("they would meet", ("robot", "load m3"), ("m2", "machine")),
    ];
    let dir = in_conflict(&scratch, &conflicts);
    let plain = linewright(&["check", &dir]);
    let out = text(&plain.stdout);
    assert_eq!(plain.status.code(), Some(1), "{out}");
    assert!(out.contains("✓ tasks in conflict are never under way at once: they never meet: no activities"), "{out}");
    assert!(out.contains("orders, and one way measured positions (LS_0 of m1): every axis of robot"), "{out}");
    assert!(out.contains("✗ tasks in conflict are never under way at once: they would meet: after 3 steps"), "{out}");
    assert!(out.contains("2. load M2: R brings A #1 from ST to M2"), "{out}");
    assert!(out.contains("and so: `load M3` and `M2.process` can both start here"), "{out}");
    // For a line alone the orders are unknown.
    std::fs::remove_file(Path::new(&dir).join("cell.toml")).expect("it was there");
    let plain = linewright(&["check", &dir, "--structure"]);
    assert!(text(&plain.stdout).contains("- whether tasks in conflict are ordered at once"), "{plain:?}");
}

/// The written nets are those that were checked: as many states, and no deadlock.
#[test]
fn the_nets_of_a_cell_are_written_and_are_those_that_were_checked() {
    let scratch = Scratch::new();
    let dir = shipped().join("../assembly-cell");
    let dir = dir.to_str().unwrap();
    // Without its line, whose stations take most of a check.
    let alone = changed(&scratch, "assembly-cell", &[]);
    let out = scratch.path("out");
    let output = linewright(&["nets", dir, "--out", &out]);
    assert!(output.status.success(), "{output:?}");
    for (name, options) in [("cell-coordination", &[][..]), ("cell-expanded", &["--expanded"])] {
        let analysed = linewright(&["analyse", &format!("{out}/{name}.pnml"), "--json"]);
        assert!(analysed.status.success(), "{analysed:?}");
        let analysed = json(&analysed);
        let (_, found) = checked(&alone, options);
        let group = &found["cell"]["groups"][0];
        assert_eq!((&analysed["states"], &analysed["arcs"]), (&group["states"], &group["arcs"]), "{name}");
        assert_eq!((&analysed["reversible"], &analysed["deadlock_free"]), (&true.into(), &true.into()), "{name}");
    }
    let recovery = linewright(&["analyse", &format!("{out}/cell-recovery.pnml"), "--json"]);
    let recovery = json(&recovery);
    assert_eq!((&recovery["reversible"], &recovery["deadlock_free"]), (&true.into(), &true.into()), "{recovery}");
    let text = scratch.read("out/cell-recovery.pnml");
    assert!(text.contains("load robot_2&lt;1.new>.diagnosis") || text.contains("load robot_2&lt;1.new&gt;.diagnosis"));
    let output = linewright(&["nets", dir, "--out", &out, "--format", "dot"]);
    assert!(output.status.success() && scratch.read("out/cell-expanded.dot").starts_with("digraph"), "{output:?}");
    let output = linewright(&["nets", dir, "--out", &out, "--format", "svg"]);
    assert!(
        output.status.code() == Some(1) && crate::support::command::text(&output.stderr).contains("--format dot"),
        "{output:?}"
    );
    assert!(scratch.read("out/robot_2.svg").ends_with("</svg>\n"), "those of the line are drawn");
}
