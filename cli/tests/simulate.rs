//! `linewright simulate`, as a user meets it: the built command, its output, its files and its exit code.

use std::process::Output;

use crate::support::command::{Scratch, json, linewright, shipped, text};

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
    assert!(trace.contains("clamp_1 (cycle 2) stopped advance clamp: watchdog"), "{trace}");
    let chart = scratch.read("chart.svg");
    assert!(chart.starts_with("<svg") && chart.ends_with("</svg>\n"));
    // Of 17 operations two bars each, and the three of the legend, and the ground.
    assert_eq!(chart.matches("<rect").count(), 17 * 2 + 3 + 1);
    assert_eq!(chart.matches("marker-end").count(), 5, "an arrow of the description each");
}

#[test]
fn the_shipped_line_on_its_buses_takes_a_little_longer() {
    let cycle_time = |args: &[&str]| {
        let found = json(&simulate(&[&["--json", "--cycles", "4"], args].concat()));
        assert_eq!((&found["ok"], &found["cycles"]), (&true.into(), &4.into()));
        found["cycle_time_s"].as_f64().expect("a number")
    };
    let (at_once, on_buses) = (cycle_time(&[]), cycle_time(&["--frames"]));
    // Sixteen motions in a row, each with a message of a millisecond either way, and frames.
    let longer = on_buses - at_once;
    assert!((0.030..0.045).contains(&longer), "{at_once} {on_buses}");
}

#[test]
fn a_line_that_cannot_go_on_is_a_failure_with_its_reasons() {
    let scratch = Scratch::new();
    let path = scratch.file("jam.toml", "[[step]]\nwhen = \"cycles >= 1\"\nstick = \"transfer: advance transfer\"\n");
    let output = simulate(&["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains("nothing happens any more"), "{said}");
    assert!(
        said.contains(
            "transfer waits for advance (go on) or return (take back) at its panel in manual, for advance transfer (watchdog: motion not complete in time)"
        ),
        "{said}"
    );
}

#[test]
fn mistakes_of_a_scenario_are_shown_in_their_place_all_at_once() {
    let scratch = Scratch::new();
    let path =
        scratch.file("slip.toml", "[[step]]\nstick = \"clmp_1: advance clamp\"\n\n[[step]]\ncomand = \"stop\"\n");
    let output = simulate(&["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    for part in
        ["2 errors", "unknown station `clmp_1`", "did you mean `clamp_1`?", "unknown key `comand`", "slip.toml:2:10"]
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

fn cell(name: &str, args: &[&str]) -> Output {
    let dir = shipped().with_file_name(name);
    linewright(&[&["simulate", dir.to_str().unwrap()], args].concat())
}

/// Seed 000, L2029-2035: a part 1 is loaded for 3, worked on for 7.5 and unloaded for 3 time units, and no other part
/// is there.
#[test]
fn a_part_of_a_cell_takes_as_long_as_its_activities() {
    let output = cell("assembly-cell", &["--parts", "1=1", "--why"]);
    assert!(output.status.success(), "{output:?}");
    let shown = text(&output.stdout);
    assert!(shown.contains("1 of 1 parts done in 13.500 s"), "{shown}");
    let part = shown.lines().find(|line| line.starts_with("part 1 (1)")).expect("its row");
    assert_eq!(part.split_whitespace().collect::<Vec<_>>()[3..], ["0.000", "s", "13.500", "s", "13.500", "s"]);
    // 7.5 of 13.5 s, and twice 3 of them.
    for (resource, worked) in [("robot_2", "55.6 %"), ("robot_1", "44.4 %"), ("human", "0.0 %")] {
        assert!(shown.lines().any(|line| line.starts_with(resource) && line.contains(worked)), "{resource}: {shown}");
    }
    assert!(shown.contains("3.000 s  `robot_2.process` with part 1 starts: no competing candidate"), "{shown}");
}

#[test]
fn the_json_of_a_cell_has_every_part_and_activity_and_follows_from_the_seed() {
    let args = |seed| ["--json", "--why", "--parts", "A=3,B=2", "--variation", "10", "--seed", seed];
    let output = cell("workcell-c1", &args("7"));
    assert!(output.status.success(), "{output:?}");
    let found = json(&output);
    assert_eq!((&found["ok"], &found["cell"]), (&true.into(), &"workcell_c1".into()));
    let parts = found["parts"].as_array().expect("parts");
    let of = |name: &str| parts.iter().filter(|part| part["type"] == name && part["done_s"].is_number()).count();
    assert_eq!((parts.len(), of("A"), of("B")), (5, 3, 2));
    // Each part is loaded, worked on and unloaded twice.
    let activities = found["activities"].as_array().expect("activities");
    assert_eq!(activities.len(), 5 * 2 * 3);
    let ends = activities.iter().filter_map(|one| one["end_s"].as_f64());
    assert_eq!(ends.fold(0.0, f64::max), found["makespan_s"].as_f64().expect("a time"));
    assert!(found["decisions"].as_array().is_some_and(|all| !all.is_empty()));
    assert_eq!(output.stdout, cell("workcell-c1", &args("7")).stdout);
    assert_ne!(output.stdout, cell("workcell-c1", &args("8")).stdout);
}

/// Four slots, and more parts than that let in: sooner or later the store is full, and a machine holds what has to go there.
#[test]
fn a_cell_that_gets_stuck_says_what_its_parts_wait_for() {
    let scratch = Scratch::new();
    let shipped = shipped().with_file_name("workcell-c1").join("cell.toml");
    let text_of = std::fs::read_to_string(shipped).unwrap();
    let tight = text_of
        .replace("capacity = 6", "capacity = 4")
        .replace("rules = [\"schedule\", \"earliest-due-date\", \"fifo\"]", "rules = [\"fifo\"]");
    std::fs::write(scratch.path("cell.toml"), tight).unwrap();
    let path = scratch.path("cell.toml");
    let stuck = (1..30).map(|seed| {
        linewright(&["simulate", &path, "--parts", "A=8,B=8", "--variation", "60", "--seed", &seed.to_string()])
    });
    let stuck: Vec<Output> = stuck.filter(|output| !output.status.success()).collect();
    let [first, ..] = &stuck[..] else { panic!("it never got stuck") };
    let said = text(&first.stderr);
    assert!(said.contains("parts finished; no further event after"), "{said}");
    assert!(!said.contains("3600"), "the end is when the last thing happened: {said}");
    assert!(said.contains(" has been in ") && said.contains("`ST.available-capacity`"), "{said}");
}

#[test]
fn what_is_not_for_a_cell_or_not_for_a_line_is_refused() {
    let refused = |output: Output| {
        assert!(!output.status.success(), "{output:?}");
        text(&output.stderr).to_owned()
    };
    assert!(refused(cell("workcell-c1", &["--cycles", "3"])).contains("--cycles is for lines"));
    assert!(refused(cell("workcell-c1", &["--parts", "C=3"])).contains("no part type 'C'; the cell has A, B"));
    assert!(refused(cell("workcell-c1", &["--parts", "A=0"])).contains("no parts to make"));
    assert!(refused(cell("workcell-c1", &["--parts", "A"])).contains("write TYPE=NUMBER"));
    assert!(refused(simulate(&["--parts", "A=3"])).contains("are for cells; "));
}

/// A planner's day: orders, breakdowns, several replications, and their figures with intervals.
#[test]
fn what_to_expect_of_a_cell_comes_with_its_intervals() {
    let scenario = shipped().join("../workcell-c1/scenarios/production.toml");
    let scenario = scenario.to_str().unwrap();
    let output = cell("workcell-c1", &["--scenario", scenario, "--replications", "4", "--threads", "3", "--json"]);
    assert!(output.status.success(), "{output:?}");
    let found = json(&output);
    assert_eq!((&found["ok"], &found["replications"]), (&true.into(), &4.into()));
    for figure in ["throughput_per_h", "time_in_cell_s", "lead_time_s", "tardiness_s", "in_time"] {
        let of = &found[figure];
        assert!(of["n"] == 4 && of["half_width"].as_f64().is_some_and(|half| half > 0.0), "{figure}: {of}");
    }
    // M2 is down for half an hour of the 23 that count, in each replication.
    let m2 = &found["resources"][2];
    assert_eq!(m2["name"], "M2");
    assert!(m2["down"]["mean"].as_f64().is_some_and(|down| (down - 0.5 / 23.0).abs() < 1e-9), "{m2}");
    let precise =
        json(&cell("workcell-c1", &["--scenario", scenario, "--replications", "2", "--precision", "20%", "--json"]));
    assert!(precise["ok"] == true && precise["replications"].as_u64().is_some_and(|n| n >= 5), "{precise}");
}

#[test]
fn a_cell_that_stands_for_good_is_a_failure_with_its_reason() {
    let scratch = Scratch::new();
    let path = scratch.file("s.toml", "[[order]]\npart = \"A\"\n[[step]]\nat_s = 20\nstick = \"R\"\n");
    let output = cell("workcell-c1", &["--scenario", &path]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains("replication 1: 0 parts finished, 1 are inside; no further event"), "{said}");
    let path = scratch.file("w.toml", "[[breakdown]]\nresource = \"M1\"\n");
    let said = cell("workcell-c1", &["--scenario", &path]);
    assert!(text(&said.stderr).contains("a breakdown needs `repair_s`"), "{said:?}");
    assert!(text(&simulate(&["--replications", "3"]).stderr).contains("are for cells; "));
}

/// Options for several replications need them; the decisions of the only one are in its JSON.
#[test]
fn threads_are_for_several_replications_and_why_is_for_one() {
    let refused = cell("workcell-c1", &["--threads", "2"]);
    assert!(!refused.status.success(), "{refused:?}");
    assert!(text(&refused.stderr).contains("--threads is for several replications"), "{refused:?}");
    let scratch = Scratch::new();
    let path = scratch.file("s.toml", "[[order]]\npart = \"A\"\n");
    let decisions = |options: &[&str]| {
        let output = cell("workcell-c1", &[&["--scenario", &path, "--json"], options].concat());
        json(&output)["runs"][0]["decisions"].as_array().map(|all| all.iter().map(|of| of["why"].to_string()).collect())
    };
    let why: Option<Vec<String>> = decisions(&["--why"]);
    assert!(why.as_ref().is_some_and(|all| all.iter().any(|of| of.contains("load M1"))), "{why:?}");
    assert_eq!(decisions(&[]), None::<Vec<String>>);
}
