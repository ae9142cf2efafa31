//! Every rule, broken once: edits of the shipped cells, and the problems they raise, in `problems/*.cases`.

use linewright_cell::{fits, parse};
use linewright_text::Problem;

use linewright_testkit::cells::{ASSEMBLY, ASSEMBLY_LINE, C1, C1_LINE, edited};

fn base(name: &str) -> String {
    match name {
        "workcell-c1" => C1.to_owned(),
        "assembly-cell" => ASSEMBLY.to_owned(),
        other => panic!("no base is called `{other}`"),
    }
}

/// All problems of a cell, by itself or beside its line.
fn problems(text: &str, line: Option<&linewright_line::Line>) -> Vec<Problem> {
    match parse("cell.toml", text, line) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec(),
    }
}

const PROBLEMS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems");

#[test]
fn rules_of_a_cell() {
    linewright_cases::check(PROBLEMS, "cell.cases", base, |text| problems(text, None));
}

#[test]
fn orders_fit_the_tasks_of_the_line() {
    let line = line_of(C1_LINE);
    linewright_cases::check(PROBLEMS, "beside_its_line.cases", base, |text| problems(text, Some(&line)));
}

#[test]
fn the_shipped_cells_are_sound() {
    assert_eq!((problems(C1, None), problems(ASSEMBLY, None)), (Vec::new(), Vec::new()));
}

/// A line with stations of other names.
#[test]
fn stations_are_looked_up_in_the_line() {
    let line = linewright_line::TransferLine::default().text();
    let line = linewright_line::parse("line.toml", &line).expect("the shipped line is sound").line;
    let text = edited(C1, &[("station = \"m1\"", "station = \"clamp_1\"")]);
    let problems = parse("cell.toml", &text, Some(&line)).expect_err("it is another line");
    let has = |message: &str| problems.iter().any(|p| p.message.starts_with(message));
    assert!(has("the cell is called `workcell_c1`, its line `transfer_line`"), "{problems:#}");
    assert!(
        has("station `clamp_1` has no input `part_in_clamp`") && has("the line has no station `m2`"),
        "{problems:#}"
    );
    assert!(has("the line has no station `robot`") && !has("the line has no station `clamp_1`"), "{problems:#}");
}

fn line_of(text: &str) -> linewright_line::Line {
    linewright_line::parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn the_shipped_cells_are_sound_beside_their_lines() {
    for (cell, line) in [(C1, C1_LINE), (ASSEMBLY, ASSEMBLY_LINE)] {
        let line = linewright_line::parse("line.toml", line).unwrap_or_else(|problems| panic!("{problems:#}"));
        assert_eq!(line.warnings, []);
        let parsed = parse("cell.toml", cell, Some(&line.line)).unwrap_or_else(|problems| panic!("{problems:#}"));
        assert_eq!(parsed.warnings, []);
    }
}

/// A part that is missing there would be noticed by what does not come later. A sensor that an operation reads is looked at, and of a hand the
/// line's own check warns.
#[test]
fn a_part_sensor_that_nothing_reads_is_reported() {
    let (assembly, c1) = (line_of(ASSEMBLY_LINE), line_of(C1_LINE));
    let of = |cell: &str, line| problems(cell, Some(line)).into_iter().map(|of| of.message).collect::<Vec<_>>();
    let without = |text: &str, key: &str| {
        assert!(text.contains(key), "{key}");
        text.lines().filter(|line| !line.contains(key)).collect::<Vec<_>>().join("\n")
    };
    let fixture = "`part_in_fixture` of `robot_2` sees a part in `robot_2.fixture`, and nothing looks at it";
    assert_eq!(of(&without(ASSEMBLY, "presence = \"part_in_fixture\""), &assembly), [fixture]);
    assert_eq!(of(&without(C1, "presence = \"part_in_clamp\""), &c1).len(), 3, "each machine");
    assert!(of(&without(C1, "presence = \"part_in_hand\""), &c1).is_empty());
}

/// As a written time is.
#[test]
fn a_time_that_is_left_out_is_compared_with_patience_and_the_limits_of_tasks() {
    let (before, after) = C1_LINE.split_at(C1_LINE.find("name = \"carry to m1\"").expect("it is there"));
    let after = after.replacen("duration_s = 3.0\nwatchdog_s = 6.0", "duration_s = 50\nwatchdog_s = 55", 1);
    let clamp = (
        "name = \"clamp\", from = \"open\", to = \"clamped\", limit_s = 60",
        "name = \"clamp\", from = \"open\", to = \"clamped\", limit_s = 20",
    );
    let line = line_of(&edited(&format!("{before}{after}"), &[clamp]));
    let without = [
        ("time_s = 12 # as planned", ""),
        (", max_s = 24", ""),
        (", max_s = 26", ""),
        ("patience_s = 600", "patience_s = 56"),
    ];
    let found = problems(&edited(C1, &without), Some(&line));
    let of = |message: &str| {
        let of = found.iter().find(|of| of.is_warning && of.message == message).unwrap_or_else(|| panic!("{found:#?}"));
        of.hint.clone().unwrap_or_default()
    };
    assert!(of("`patience_s` is 56").starts_with("a single activity takes 58 s"), "{found:#?}");
    of("`load M1` takes 58 s by the operations of its tasks, but task `clamp` has `limit_s = 20`");
}

/// Of a machine the time stands with a step of a part, far from the order.
#[test]
fn a_limit_that_is_too_short_shows_the_time_that_is_longer() {
    let order = "orders = [{ station = \"m1\", task = \"machine\", parameters = { program = \"step.program\" } }]";
    let short = order.replace("program\" } }", "program\" }, max_s = 30 }");
    let text = edited(C1, &[(order, &short)]);
    let found = problems(&text, None);
    let [problem] = &found[..] else { panic!("{found:#?}") };
    assert_eq!((problem.message.as_str(), &text[problem.span.clone()]), ("`max_s` is 30 s", "30"));
    let also: Vec<&str> = problem.also.iter().map(|(at, _)| &text[at.clone()]).collect();
    assert_eq!(also, ["40"], "{problem:#?}");
}

/// A task is added, and reaches where others do that a conflict keeps apart from what the machine does.
#[test]
fn a_task_that_reaches_where_others_are_kept_apart_is_reported() {
    let [cell, line] = [
        include_str!("../../../cli/src/new/washing-cell/cell.toml"),
        include_str!("../../../cli/src/new/washing-cell/line.toml"),
    ];
    assert_eq!(problems(cell, Some(&line_of(line))), []);
    let of_load = "a = { station = \"robot\", task = \"{load}\" }";
    assert!(line.contains(of_load));
    let line = line_of(&line.replace(of_load, "a = { station = \"robot\", task = \"{unload}\" }"));
    let found: Vec<String> = problems(cell, Some(&line)).into_iter().map(|of| of.message).collect();
    let missing = |task: &str, machine: &str| {
        format!(
            "`{task}` of `robot` reaches into `{machine}`, and no `[[conflict]]` keeps it apart from `run` of `{machine}`"
        )
    };
    assert_eq!(found, [missing("load washer", "washer"), missing("washer to dryer", "dryer")]);
}

/// C1 as it was: the fixture of a machine whose part was taken away opens only for a part.
#[test]
fn a_machine_that_nothing_opens_without_a_part_is_reported() {
    let begin = C1_LINE.find("name = \"clamp-open empty\"").expect("it is there");
    let (before, after) = C1_LINE.split_at(begin);
    let waits = "waits = [\"part_present\"]\nwaits_code = 14\nhand = { type = 3, forward = \"PB_clear_1\"";
    let line = line_of(&format!("{before}{}", after.replacen("hand = { type = 3, forward = \"PB_clear_1\"", waits, 1)));
    let found = problems(C1, Some(&line));
    let message = "`M1` cannot be made ready from rest `clamped` without a part";
    assert_eq!(
        found.iter().map(|problem| (problem.message.as_str(), problem.is_warning)).collect::<Vec<_>>(),
        [(message, true)]
    );
    let help = found[0].hint.as_deref().unwrap_or_default();
    assert!(help.contains("nothing leads `m1` from `clamped` to `open`"), "{help}");
    assert_eq!(&C1[found[0].span.clone()], "\"M1\"");
    assert_eq!(problems(C1, None), [], "without a line nothing is known of rests");
}

/// Workcell C1 with errors put into its handshakes: each edit of the line's text, and the problems of the activities that have
/// them.
#[test]
fn a_handshake_that_never_completes_is_reported() {
    const SWAPPED: (&str, &str) = ("the two sensors", "are swapped");
    const LETS_GO: (&str, &str) = ("waits = [\"m1_clamped\"]", "waits = [\"m1_open\"]");
    const CARRIES_AWAY: (&str, &str) = ("waits = [\"m1_open\"]", "waits = [\"m1_clamped\"]");
    const COMES: (&str, &str) = ("waits = [\"m1_ready\"]", "waits = [\"m1_clamped\"]");
    const CLAMPS: (&str, &str) = ("waits = [\"part_present\"]\nwaits_code = 12\n", "");
    const OPENS: (&str, &str) = ("waits = [\"part_present\"]\nwaits_code = 13\n", "");
    const SEEN_AT_CLAMP: &str = "when = [{ part = \"robot.hand\" }, { axis = \"robot.arm\", at = 200 }]";
    let seen_open = "when = [{ axis = \"robot.gripper\", at = 0 }]";
    let let_go_first = (SEEN_AT_CLAMP, seen_open);
    let reported: String = [
        ("lets go of what is not clamped", LETS_GO),
        ("carries away what is clamped", CARRIES_AWAY),
        ("comes when it is closed", COMES),
        ("sensors of each other", SWAPPED),
        ("each waits for the other to be first", let_go_first),
        ("lets go without waiting", ("waits = [\"m1_clamped\"]\nwaits_code = 22\n", "")),
        ("lets go when another machine holds its part", ("waits = [\"m1_clamped\"]", "waits = [\"m2_clamped\"]")),
        ("carries away without waiting", ("waits = [\"m1_open\"]\nwaits_code = 23\n", "")),
        ("clamps without waiting", CLAMPS),
        (
            "clamps as soon as the hand has a part, wherever that is",
            (SEEN_AT_CLAMP, "when = [{ part = \"robot.hand\" }]"),
        ),
        ("opens without waiting", OPENS),
    ]
    .into_iter()
    .map(|(title, edit)| {
        let line = if edit == SWAPPED {
            C1_LINE
                .replace("m1_clamped\"\nwhen", "kept\"\nwhen")
                .replace("m1_open\"\nwhen", "m1_clamped\"\nwhen")
                .replace("kept\"\nwhen", "m1_open\"\nwhen")
        } else {
            edited(C1_LINE, &[edit])
        };
        format!("{title}\n{}", listed(C1, &line))
    })
    .collect();
    assert_eq!(reported, include_str!("problems/handshakes.txt"));
}

/// The problems of a cell beside a line: where, what, what to do.
fn listed(cell: &str, line: &str) -> String {
    let one = |problem: &Problem| {
        let (place, hint) = (&cell[problem.span.clone()], problem.hint.as_deref().unwrap_or_default());
        let warning = if problem.is_warning { "warning: " } else { "" };
        format!("> {place}: {warning}{}\n  ({hint})\n", problem.message)
    };
    problems(cell, Some(&line_of(line))).iter().map(one).collect()
}

/// What a hand takes and puts down where the cell does not count it: edits of the line's text, and of the cell's.
#[test]
fn a_part_taken_or_put_down_elsewhere_is_reported() {
    const SAME: (&str, &str) = ("title", "title");
    let reach = "[[station.reach]]\nhand = \"hand\"\nto = \"m1.clamp\"\nwhen = { arm = 200 }\n";
    let other = reach.replace("m1.clamp", "m3.clamp");
    let begin = C1_LINE.find("[[station.reach]]").expect("it is there");
    let store = &C1_LINE[begin..C1_LINE.find(reach).expect("it is there")];
    let reversed =
        ("position = [\"slot_1\", \"slot_2\", \"slot_4\"]", "position = [\"slot_4\", \"slot_2\", \"slot_1\"]");
    let from_machine = reach.replace("m1.clamp", "m2.clamp").replace("200", "100");
    let robot = |task: &str| {
        format!("task = \"{task}\", parameters = {{ slot = \"ST.position\" }}, max_s = 24 }},\n  {{ station = \"m1\"")
    };
    let (loads, unloads) = (robot("load m1"), robot("unload m1"));
    let reported: String = [
        ("puts down at another machine", (reach, other.as_str()), SAME),
        ("opens where it reaches nothing", (reach, ""), SAME),
        ("unloads with the task that loads", SAME, (unloads.as_str(), loads.as_str())),
        ("a position on outputs in another order", (reversed.0, reversed.1), SAME),
        (
            "always the same position",
            SAME,
            (
                "task = \"load m1\", parameters = { slot = \"ST.position\" }",
                "task = \"load m1\", parameters = { slot = 3 }",
            ),
        ),
        ("takes from a machine", (store, from_machine.as_str()), SAME),
    ]
    .into_iter()
    .map(|(title, line, cell)| format!("{title}\n{}", listed(&edited(C1, &[cell]), &edited(C1_LINE, &[line]))))
    .collect();
    assert_eq!(reported, include_str!("problems/handed_elsewhere.txt"));
}

/// A part may be laid into a clamp that is open, and be clamped when the hand has left.
#[test]
fn a_handshake_that_can_complete_is_not_reported() {
    let laid_down = [
        ("waits = [\"m1_clamped\"]", "waits = [\"m1_open\"]"),
        ("waits = [\"part_present\"]\nwaits_code = 12", "waits = [\"part_in_clamp\"]\nwaits_code = 12"),
    ];
    assert_eq!(problems(C1, Some(&line_of(&edited(C1_LINE, &laid_down)))), []);
    // When the machine clamps is not known: perhaps when the hand has left.
    let unknown = [
        ("waits = [\"m1_clamped\"]\nwaits_code = 22\n", ""),
        (
            "[[sensor]]\nstation = \"m1\"\ninput = \"part_present\"\n\
             when = [{ part = \"robot.hand\" }, { axis = \"robot.arm\", at = 200 }]\n",
            "",
        ),
    ];
    assert_eq!(problems(C1, Some(&line_of(&edited(C1_LINE, &unknown)))), []);
}

#[test]
fn a_station_that_is_not_task_driven_gets_none_and_one_that_is_should() {
    let line = include_str!("../../../launch-config/lines/transfer-line/line.toml").replacen(
        "transfer_line",
        "workcell_c1",
        1,
    );
    let text = edited(C1, &[("station = \"robot\", task = \"load m1\"", "station = \"clamp_1\", task = \"load m1\"")]);
    let problems = parse("cell.toml", &text, Some(&line_of(&line))).expect_err("it is another line");
    let has = |words: &str| problems.iter().any(|problem| problem.message.contains(words));
    assert!(has("station `clamp_1` is not task-driven"), "{problems:#}");

    let line = C1_LINE
        .replacen("name = \"robot\"", "name = \"other\"", 1)
        .replace("station = \"robot\"", "station = \"other\"");
    let line = line_of(&line.replace("\"robot.", "\"other."));
    let problems = parse("cell.toml", C1, Some(&line)).expect_err("there is no robot");
    let has = |words: &str| problems.iter().any(|problem| problem.message.contains(words));
    assert!(has("nothing is ordered of station `other`") && has("the line has no station `robot`"), "{problems:#}");
}

#[test]
fn a_star_stands_for_anything() {
    let fitting = ["load M*", "*", "load M1", "l*M*1", "load M1*"];
    assert!(fitting.iter().all(|pattern| fits(pattern, "load M1")));
    assert!(!["load", "load M", "*2", "M*", "", "load M1?", "*1*1"].iter().any(|no| fits(no, "load M1")));
}
