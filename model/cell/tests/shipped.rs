//! Contents of the shipped descriptions.

use std::time::Duration;

use linewright_cell::{ActivityKind, DispatchRule, LeftOut, ParameterSource, Prototype, StopOf, Whereabouts};

use linewright_testkit::cells::{ASSEMBLY, C1, C1_LINE, cell};

/// A1, seed 000, L2029-2035: robot 1 loads robot 2: 3, loads the human: 2, unloads robot 2: 3, unloads the human: 2; robot 2
/// works on part 1: 7.5; the human on part 2: 5, on part 3: 4. One time unit is a second here.
#[test]
fn the_times_of_the_assembly_cell_are_the_printed_ones() {
    let cell = cell(ASSEMBLY);
    let times = |activity: &str| -> Vec<(&str, f64)> {
        let moves = &cell.activity(cell.activity_named(activity).expect("it is there")).moves;
        let time = |time: Option<Duration>| time.expect("it takes time").as_secs_f64();
        moves.iter().map(|of| (cell.stages[of.from.index()].name.as_str(), time(of.time))).collect()
    };
    assert_eq!(times("load robot_2"), [("1.new", 3.0)]);
    assert_eq!(times("load human"), [("2.new", 2.0), ("3.new", 2.0)]);
    assert_eq!(times("unload robot_2"), [("1.done", 3.0)]);
    assert_eq!(times("unload human"), [("2.done", 2.0), ("3.done", 2.0)]);
    assert_eq!(times("robot_2.process"), [("1.new", 7.5)]);
    assert_eq!(times("human.process"), [("2.new", 5.0), ("3.new", 4.0)]);
}

/// Seed 000, L1428-1430: robot 1 loads and unloads; each resource has capacity for one part at a time.
#[test]
fn the_resources_of_the_assembly_cell_are_the_printed_ones() {
    let cell = cell(ASSEMBLY);
    let of = |name: &str| cell.resources.iter().find(|r| r.name == name).map(|r| (r.prototype, r.capacity));
    assert_eq!(of("robot_1"), Some((Prototype::Robot, 1)));
    assert_eq!(of("robot_2"), Some((Prototype::Machine, 1)));
    assert_eq!(of("human"), Some((Prototype::Human, 1)));
    assert_eq!(cell.dispatch.rules, [DispatchRule::Schedule, DispatchRule::ShortestProcessingTime, DispatchRule::Fifo]);
}

/// Seed 001, L72-77: M1, M2, M3, ST and R; load and unload actions are synchronised with pick-and-place.
#[test]
fn the_workcell_is_the_described_one() {
    let cell = cell(C1);
    let names: Vec<&str> = cell.resources.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["ST", "M1", "M2", "M3", "R"]);
    let load = cell.activity(cell.activity_named("load M1").expect("it is there"));
    assert_eq!((load.kind, load.uses.len(), load.orders.len()), (ActivityKind::Transport, 3, 2));
    assert_eq!(
        load.orders[0].parameters,
        [("slot".to_owned(), ParameterSource::Position(linewright_cell::ResourceId(0)))]
    );
    // Only what M1 works on is brought there.
    assert_eq!(load.moves.iter().map(|of| cell.stages[of.from.index()].name.as_str()).collect::<Vec<_>>(), ["A.new"]);
    let process = cell.activity(cell.activity_named("M3.process").expect("it is there"));
    let of = &process.moves[0];
    assert_eq!((cell.stages[of.from.index()].name.as_str(), of.program), ("A.turn", Some(2)));
    // Twice the nominal 30 s, since the order gives no limit.
    assert_eq!(cell.limit(&process.orders[0], of), Some(Duration::from_secs(60)));
    let rule = &cell.exceptions[0];
    let meant: Vec<&str> = rule.activities.iter().map(|&id| cell.activity(id).name.as_str()).collect();
    assert_eq!((meant, rule.retries), (vec!["load M1", "load M2", "load M3"], 2));
}

/// Resources left out by a rule are so after each of its answers; one can be named by the role of its part in the
/// activity.
#[test]
fn answers_leave_resources_out() {
    let text = C1.replace("retries = 2", "retries = 2\ndown = [\"M2\", \"carrier\"]");
    let text = text.replacen("then = \"forward\"", "then = \"forward\", down = [\"to\", \"M2\"]", 1);
    let cell = cell(&text);
    let m2 = LeftOut::Resource(linewright_cell::ResourceId::at(2));
    let carrier = LeftOut::As(Whereabouts::Carrier);
    let late = &cell.exceptions[2];
    let down: Vec<_> = late.answers.iter().map(|answer| answer.down.clone()).collect();
    assert_eq!(down, [vec![m2, carrier], vec![LeftOut::As(Whereabouts::To), m2, carrier], vec![m2, carrier]]);
    let renamed = text.replace("\"R\"", "\"carrier\"").replace("\"R.", "\"carrier.");
    let down = &self::cell(&renamed).exceptions[0].answers[0].down;
    assert_eq!(down[1], LeftOut::Resource(linewright_cell::ResourceId::at(4)), "a name comes first");
}

/// Stations go into emergency stop by name, or all of the activity.
#[test]
fn a_rule_stops_stations() {
    let cell = cell(&C1.replacen("retries = 2", "retries = 2\nemergency_stop = [\"*\", \"m2\"]", 1));
    let m2 = cell.controllers.iter().position(|name| name == "m2").expect("it is there");
    let m2 = StopOf::Station(linewright_cell::ControllerId::at(m2));
    assert_eq!(cell.exceptions[0].emergency_stop, [StopOf::Activity, m2]);
}

/// `or` begins where another step begins, `then` leads on to where a later one does.
#[test]
fn a_plan_may_have_alternatives() {
    let text = C1.replace(
        "[[part]]\nname = \"B\"",
        "[[part.step]]\nname = \"mill\"\nor = \"turn\"\nthen = \"polish\"\non = [{ resource = \"M2\", time_s = 9, program = 5 }]\n\
         [[part.step]]\nname = \"polish\"\non = [{ resource = \"M1\", time_s = 8, program = 6 }]\n\n[[part]]\nname = \"B\"",
    );
    let text = text.replacen("name = \"grind\"\n", "name = \"grind\"\nthen = \"polish\"\n", 1);
    let cell = cell(&text);
    let stage = |id: linewright_cell::StageId| cell.stages[id.index()].name.as_str();
    let steps: Vec<_> =
        cell.part_types[0].steps.iter().map(|s| (s.name.as_str(), stage(s.from), stage(s.to))).collect();
    let expected = [
        ("turn", "A.new", "A.turn"),
        ("grind", "A.turn", "A.grind"),
        ("mill", "A.new", "A.grind"),
        ("polish", "A.grind", "A.done"),
    ];
    assert_eq!(steps, expected);
}

/// Steps of a part, and the stages between them.
fn steps_of(cell: &linewright_cell::Cell, part: usize) -> Vec<(&str, &str, &str)> {
    let stage = |id: linewright_cell::StageId| cell.stages[id.index()].name.as_str();
    cell.part_types[part].steps.iter().map(|s| (s.name.as_str(), stage(s.from), stage(s.to))).collect()
}

/// `then = "done"` ends a plan before its last step.
#[test]
fn a_way_may_end_early() {
    let text = C1.replacen(
        "[[part.step]]\nname = \"grind\"",
        "[[part.step]]\nname = \"mill\"\nor = \"turn\"\nthen = \"done\"\non = [{ resource = \"M2\", time_s = 9, program = 5 }]\n\
         [[part.step]]\nname = \"grind\"",
        1,
    );
    let expected = [("turn", "A.new", "A.turn"), ("mill", "A.new", "A.done"), ("grind", "A.turn", "A.done")];
    assert_eq!(steps_of(&cell(&text), 0), expected);
}

/// A variant has the stages that are left, called after the steps that are left.
#[test]
fn a_variant_is_without_steps() {
    let plan = |variant: &str| {
        C1.replace(
            "[[part]]\nname = \"B\"",
            &format!(
                "[[part.step]]\nname = \"mill\"\non = [{{ resource = \"M2\", time_s = 9, program = 5 }}]\n\
                 [[part.step]]\nname = \"saw\"\nor = \"mill\"\non = [{{ resource = \"M1\", time_s = 9, program = 6 }}]\n\
                 [[part.variant]]\nname = \"A0\"\nwithout = {variant}\n\n[[part]]\nname = \"B\""
            ),
        )
    };
    let of = |variant: &str| {
        steps_of(&cell(&plan(variant)), 1).into_iter().map(|(.., to)| to.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(of("[\"turn\"]"), ["A0.grind", "A0.done", "A0.done"]);
    assert_eq!(of("[\"grind\"]"), ["A0.turn", "A0.done", "A0.done"]);
    assert_eq!(of("[\"mill\", \"saw\"]"), ["A0.turn", "A0.done"]);
    let all = cell(&plan("[\"grind\"]"));
    let stages: Vec<_> = all.stages.iter().map(|stage| stage.name.as_str()).collect();
    assert_eq!(stages[..7], ["A.new", "A.turn", "A.grind", "A.done", "A0.new", "A0.turn", "A0.done"]);
    assert_eq!(all.part_types[2].name, "B");
}

/// The example of the documentation is a sound one, with the part of the alternatives beside it.
#[test]
fn the_documented_examples_are_sound() {
    let text = include_str!("../../../docs/cell-description.md");
    let blocks: Vec<&str> = text.split("```toml\n").skip(1).filter_map(|block| block.split("```").next()).collect();
    assert_eq!(blocks.len(), 3);
    let small = linewright_cell::parse("small.toml", blocks[0], None).unwrap_or_else(|problems| panic!("{problems:#}"));
    assert_eq!(small.warnings, []);
    let c1 = C1
        .replace("[[part]]\nname = \"A\"", "[[part]]\nname = \"old A\"")
        .replace("{ program = \"step.program\" }", "{ program = 1 }");
    let alternatives = cell(&format!("{c1}\n{}", blocks[1]));
    let steps = &alternatives.part_types.last().expect("it is there").steps;
    assert_eq!(steps.iter().filter(|step| step.from == steps[0].from).count(), 2);
    let variants = cell(&format!("{c1}\n{}", blocks[2]));
    let names: Vec<_> = variants.part_types.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["old A", "B", "C", "C unmeasured"]);
}

/// A cell and its line are one description to its coordinator; titles and comments are for people.
#[test]
fn the_fingerprint_of_a_cell_is_that_of_both_descriptions() {
    let line = |text: &str| linewright_line::parse("line.toml", text).expect("a line").line;
    let of = |cell_text: &str, line_text: &str| cell(cell_text).fingerprint(&line(line_text));
    let usual = of(C1, C1_LINE);
    assert_eq!(of(&format!("# A remark.\n{C1}"), C1_LINE), usual);
    assert_ne!(of(&C1.replacen("wip_max = ", "wip_max = 1", 1), C1_LINE), usual);
    assert_ne!(of(C1, &format!("{C1_LINE}\n[timing]\nlease_ms = 600\n")), usual);
}

/// A time that is left out is that of the longest of the stations' tasks by their operations; where a program decides it is written. Orders
/// are limited by all of them one after the other: one station may wait for the other.
#[test]
fn a_time_that_is_left_out_is_that_of_the_chart() {
    let line = linewright_line::parse("line.toml", C1_LINE).expect("it is sound").line;
    let text = C1.replacen("time_s = 12 # as planned\n", "", 1).replacen(", max_s = 24 }", " }", 1);
    let parsed = |text: &str| linewright_cell::parse("cell.toml", text, Some(&line));
    let cell = parsed(&text).expect("it is sound").cell;
    let load = cell.activity(cell.activity_named("load M1").expect("it is there"));
    // The robot: 2.5, 1, 3, 1, 3.5; the machine 3, 1.
    assert_eq!(load.moves[0].time, Some(Duration::from_secs(11)));
    assert_eq!(cell.limit(&load.orders[0], &load.moves[0]), Some(Duration::from_secs(30)), "2 times all");
    let programmed = C1.replacen("time_s = 40, program = 1", "program = 1", 1);
    assert!(parsed(&programmed).is_err(), "the time is the program's");
    let worked = programmed.replacen(
        "task = \"machine\", parameters = { program = \"step.program\" }",
        "task = \"machine\", parameters = { program = 1 }",
        1,
    );
    let cell = parsed(&worked).expect("it is sound").cell;
    let process = cell.activity(cell.activity_named("M1.process").expect("it is there"));
    assert_eq!(process.moves[0].time, Some(Duration::from_secs(40)), "3, 35, 2");
}
