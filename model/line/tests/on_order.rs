//! Stations on order: what the base description says, and every rule broken once.
//!
//! `«` in a replacement marks where the problem must point; the mark is taken out before parsing.

use linewright_line::{AxisId, Grip, Line, OpId, Problem, RestId, Sign, Stand, StationId, TaskId, parse};

const BASE: &str = include_str!("descriptions/on_order.toml");

fn base() -> Line {
    let parsed = parse("on_order.toml", BASE).unwrap_or_else(|problems| panic!("{problems:#}"));
    assert_eq!(parsed.warnings, []);
    parsed.line
}

#[test]
fn the_base_is_sound_and_says_what_it_says() {
    let line = base();
    let m1 = line.station(StationId(0));
    let named = |rest: RestId| m1.rests[rest.index()].name.as_str();
    let tasks: Vec<_> =
        m1.tasks.iter().map(|t| (t.name.as_str(), t.steps.clone(), named(t.from), named(t.to))).collect();
    assert_eq!(
        tasks,
        [
            ("clamp", 0..1, "open", "clamped"),
            ("machine", 1..4, "clamped", "clamped"),
            ("release", 4..5, "clamped", "open"),
        ]
    );
    assert_eq!(m1.rests.iter().map(|rest| rest.at.clone()).collect::<Vec<_>>(), [[0.0, 0.0], [60.0, 0.0]]);
    assert_eq!(m1.home, OpId(4), "the last operation of the first task that ends at the first rest");
    assert_eq!(m1.arrival_at(RestId(1)), Some(OpId(0)));
    assert_eq!(m1.tasks_from(RestId(1)).collect::<Vec<_>>(), [TaskId(1), TaskId(2)]);
    assert_eq!((m1.rest_after(OpId(3)), m1.rest_after(OpId(2))), (Some(RestId(1)), None));
    assert_eq!((m1.rest_before(OpId(1)), m1.rest_before(OpId(2))), (Some(RestId(1)), None));
    assert_eq!(m1.path_end(OpId(2)), OpId(3));
    let close = &m1.operations[0];
    assert_eq!((m1.inputs[close.waits[0].index()].as_str(), close.waits_code), ("part_present", 12));
    assert_eq!(m1.operations[1].waits_code, 0);
    let run = line.buttons.iter().position(|name| name == "PB_run");
    assert_eq!(close.hand.next().map(|button| button.index()), run, "what is begun first where the task ends");
}

#[test]
fn a_parameter_stands_on_its_outputs_the_lowest_bit_first() {
    let line = base();
    let m1 = line.station(StationId(0));
    let program = &m1.task(TaskId(1)).parameters[0];
    let bit = |name: &str| 1u128 << m1.outputs.iter().position(|output| output == name).expect("it is there");
    assert_eq!(program.most(), 7);
    assert_eq!(program.image(0), Some(0));
    assert_eq!(program.image(5), Some(bit("prog_1") | bit("prog_4")));
    assert_eq!(program.image(6), Some(bit("prog_2") | bit("prog_4")));
    assert_eq!((program.image(8), program.image(-1)), (None, None));
}

/// What to replace by what, first occurrence each; the beginning of the message; some words of the hint.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a str);

fn edited(edits: &[(&str, &str)]) -> (Vec<Problem>, (usize, usize)) {
    let mut text = BASE.to_owned();
    for (old, new) in edits {
        assert!(text.contains(old), "the base has no {old:?}");
        text = text.replacen(old, new, 1);
    }
    let mark = text.find('«').expect("a case marks a place");
    let before = &text[..mark];
    let place = (before.matches('\n').count() + 1, before.chars().rev().take_while(|&c| c != '\n').count() + 1);
    let text = text.replace('«', "");
    let problems = match parse("on_order.toml", &text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec(),
    };
    (problems, place)
}

#[track_caller]
fn errors(cases: &[Case<'_>]) {
    let mut failures = Vec::new();
    for (edits, message, hint) in cases {
        let (problems, mark) = edited(edits);
        let is_it = |p: &&Problem| p.message.starts_with(message) && (p.line, p.column) == mark && !p.is_warning;
        if !problems.iter().filter(is_it).any(|p| p.hint.as_deref().unwrap_or_default().contains(hint)) {
            let list = problems.iter().map(|p| format!("  {}:{}: {} ({:?})", p.line, p.column, p.message, p.hint));
            let list: Vec<String> = list.collect();
            failures.push(format!("{edits:?}\n wanted {mark:?} {message} ({hint})\n{}", list.join("\n")));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn tasks_and_rests() {
    errors(&[
        (
            &[("name = \"m1\"\n", "name = \"m1\"\nhome = «\"clamp open\"\n")],
            "station `m1` has tasks, and so no `home`",
            "first rest",
        ),
        (&[("to = \"clamped\"", "to = «\"clampd\"")], "unknown rest `clampd`", "did you mean `clamped`?"),
        (&[("at = { clamp = 60 }", "at = { «clmp = 60 }")], "unknown axis `clmp`", "`clamp`"),
        (&[("{ name = \"clamped\"", "{ name = «\"open\"")], "a second rest of this station named `open`", ""),
        (&[("name = \"machine\"", "name = «\"clamp\"")], "a second task of this station named `clamp`", ""),
        (
            &[("{ name = \"open\" }", "{ name = \"open\", at = { «clamp = 5 } }")],
            "at home `clamp` stands at 0",
            "first rest",
        ),
        (
            &[(
                "limit_s = 26\n",
                "limit_s = 26\n\n[[station.task]]\nname = «\"nothing\"\nfrom = \"open\"\nto = \"open\"\nlimit_s = 9\n",
            )],
            "task `nothing` has no operation",
            "`task = ",
        ),
        (
            &[("at = { clamp = 60 } }]", "at = { clamp = 60 } }, { name = «\"half\", at = { clamp = 30 } }]")],
            "no tasks lead from home to `half`",
            "add a task",
        ),
        (
            &[("name = \"clamped\"", "name = «\"clamped\""), ("to = \"open\"", "to = \"clamped\"")],
            "no tasks lead from `clamped` back home",
            "",
        ),
        (
            &[("name = \"open\"", "name = «\"open\""), ("to = \"open\"", "to = \"clamped\"")],
            "no task ends at `open`",
            "some task",
        ),
        (&[("limit_s = 120", "limit_s = «3")], "the limit of task `machine` is 3 s, but its motions take 3 s", "twice"),
        (
            &[("from = \"open\"\nto = \"clamped\"", "from = \"open\"\nto = «\"open\"")],
            "task `clamp` leaves `clamp` at 60, but in `open`",
            "",
        ),
        (
            &[("axis = \"slide\", from = 0, to = 80", "axis = \"slide\", from = «10, to = 80")],
            "`slide in` starts at 10, but where the task begins",
            "",
        ),
        (&[("[\"prog_1\", \"prog_2\", \"prog_4\"]", "«[]")], "parameter `program` has no outputs", "lowest bit first"),
        (&[("\"prog_1\", \"prog_2\"", "\"prog_1\", «\"prog_1\"")], "`prog_1` is two bits of one parameter", ""),
        (&[("\"prog_1\", \"prog_2\"", "«\"Y_close\", \"prog_2\"")], "`Y_close` means two things", "one thing"),
        (
            &[("\"prog_1\", \"prog_2\"", "«\"progg\", \"prog_2\"")],
            "no device of station `m1` has an output `progg`",
            "",
        ),
        (
            &[("{ program = [\"prog_1\", \"prog_2\", \"prog_4\"] }", "{ program = «3 }")],
            "`program` must be a list of texts",
            "",
        ),
    ]);
}

#[test]
fn operations_of_tasks() {
    errors(&[
        (&[("task = \"machine\"\nname = \"mill\"", "name = «\"mill\"")], "`mill` belongs to no task", "`task = "),
        (
            &[("task = \"machine\"\nname = \"mill\"", "task = «\"machin\"\nname = \"mill\"")],
            "unknown task `machin`",
            "`machine`",
        ),
        (
            &[
                ("task = \"machine\"\nname = \"mill\"", "task = \"clamp\"\nname = \"mill\""),
                ("task = \"machine\"\nname = \"slide out\"", "task = «\"machine\"\nname = \"slide out\""),
            ],
            "`slide out` stands apart from the rest of its task",
            "stand together",
        ),
        (
            &[("name = \"mill\"", "name = \"mill\"\nwith = «\"slide in\"")],
            "operations side by side in a station on order",
            "one by one",
        ),
        (
            &[
                ("to = \"clamped\"\nlimit_s = 120", "to = \"open\"\nlimit_s = 120"),
                ("name = \"mill\"", "name = «\"mill\""),
            ],
            "irreversible operation `mill` in a task that ends elsewhere",
            "of its own",
        ),
        (&[("[\"slide in\"]", "[«\"clamp close\"]")], "`clamp close` does not come before `mill` in its task", ""),
        (
            &[("[\"slide in\"]", "[«\"slide out\"]")],
            "the recovery path of `mill` names the last operation of its task",
            "leave it out",
        ),
        (&[("waits = [\"part_present\"]", "waits = [«\"part\"]")], "no device of station `m1` has an input `part`", ""),
        (
            &[("waits = [\"part_present\"]\nwaits_code = 12", "waits_code = «12")],
            "`clamp close` waits for nothing",
            "`waits`",
        ),
        (&[("waits_code = 12", "waits_code = «1000")], "`waits_code` is 1000", "between 1 and 999"),
    ]);
}

#[test]
fn hand_mode() {
    errors(&[
        (
            &[("forward = \"PB_open\"", "forward = \"PB_open\", next = «\"PB_close\"")],
            "`next` where a task ends",
            "leave it out",
        ),
        (
            &[
                ("type = 2, forward = \"PB_run\"", "type = 1, forward = \"PB_run\""),
                ("slide out\"", "slide out\""),
                (
                    "hand = { type = 1, forward = \"PB_run\" }\n\n[[station.operation]]\ntask = \"release\"",
                    "hand = «{ type = 1, forward = \"PB_run\" }\n\n[[station.operation]]\ntask = \"release\"",
                ),
            ],
            "`slide out` ends task `machine`, but has hand type 1",
            "2, 5 or 6",
        ),
        (
            &[
                ("type = 3, forward = \"PB_load\"", "type = 4, forward = \"PB_load\""),
                ("hand = { type = 4, forward = \"PB_load\"", "hand = «{ type = 4, forward = \"PB_load\""),
            ],
            "`to the store` begins task `load m1`, but has hand type 4",
            "1, 2, 3 or 6",
        ),
        (
            &[("forward = \"PB_open\"", "forward = «\"PB_run\"")],
            "tasks `machine` and `release` begin at one rest by one button",
            "of its own",
        ),
        (
            &[("back = \"PB_back\"", "back = \"PB_open\""), ("forward = \"PB_open\"", "forward = «\"PB_open\"")],
            "one button begins task `release` and takes back `clamp close`",
            "type 2",
        ),
    ]);
}

#[test]
fn nothing_of_it_in_a_station_that_goes_round_and_no_arrows_to_one_on_order() {
    let cyclic = include_str!("descriptions/cell.toml");
    for (old, new, message) in [
        ("name = \"push\"", "name = \"push\"\ntask = \"x\"", "`task` in a station without tasks"),
        ("name = \"push\"", "name = \"push\"\nwaits = [\"X_0\"]", "`waits` in a station without tasks"),
        (
            "home = \"pull back\"",
            "home = \"pull back\"\nrest = [{ name = \"home\" }]",
            "a rest of a station without tasks",
        ),
    ] {
        let problems = parse("cell.toml", &cyclic.replacen(old, new, 1)).expect_err(message).into_vec();
        assert!(problems.iter().any(|p| p.message == message), "{message}: {problems:?}");
    }
    errors(&[(
        &[("[console]", "[[arrow]]\nfrom = \"«m1: mill\"\nto = \"robot: grasp\"\n\n[console]")],
        "an arrow of a station on order",
        "ordered",
    )]);
}

const MACHINE: &str = "{ station = \"m1\", task = \"machine\" }";
const LOAD: &str = "{ station = \"robot\", task = \"load m1\" }";

/// A conflict of these two, in front of the console.
fn conflict(a: &str, b: &str) -> String {
    format!("[[conflict]]\nwhy = \"the arm is in the way\"\na = {a}\nb = {b}\n\n[console]")
}

#[test]
fn two_tasks_may_be_in_conflict() {
    let text = BASE.replacen("[console]", &conflict(MACHINE, LOAD), 1);
    let line = parse("on_order.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let [conflict] = &line.conflicts[..] else { panic!("{:?}", line.conflicts) };
    assert!(line.is_of_tasks(conflict));
    let (m1, robot) = (line.station(conflict.a.station), line.station(conflict.b.station));
    assert_eq!((m1.task_of(conflict.a.from), m1.steps_of_span(&conflict.a)), (Some(TaskId(1)), vec![1, 2, 3]));
    assert_eq!(
        (robot.task_of(conflict.b.from), robot.steps_of_span(&conflict.b)),
        (Some(TaskId(0)), vec![0, 1, 2, 3, 4])
    );
    let slide = 1 << m1.inputs.iter().position(|input| input == "L_0").expect("it has it");
    assert_eq!(line.clearance(&conflict.a), Ok(slide), "no other task moves the slide");
    assert!(line.clearance(&conflict.b).is_err(), "the arm moves in the other task too");
    assert_eq!(line.without_conflicts_of_tasks().conflicts, []);
    assert_eq!(line.without_conflicts_of_tasks().stations, line.stations);
}

#[test]
fn what_a_conflict_of_tasks_cannot_say() {
    let cases = [
        (
            conflict("{ station = \"m1\", task = «\"mashine\" }", LOAD),
            "unknown task of this station `mashine`",
            "machine",
        ),
        (conflict(MACHINE, "{ station = «\"rowbot\", task = \"load m1\" }"), "unknown station `rowbot`", "robot"),
        (
            conflict(MACHINE, "«{ station = \"m1\", task = \"clamp\" }"),
            "a conflict of a station with itself",
            "two stations",
        ),
        (
            conflict("«{ station = \"m1\", from = \"mill\", until = \"mill\" }", LOAD),
            "a stretch of a cycle of `m1`, which works on order",
            "one of its tasks",
        ),
        (
            conflict("{ station = \"m1\", task = \"machine\", from = «\"mill\" }", LOAD),
            "a stretch of a cycle beside `task`",
            "leave `from` and `until` out",
        ),
        (
            conflict("«{ station = \"m1\" }", LOAD),
            "a state of a conflict needs `from` and `until`, or `task`",
            "on order",
        ),
    ];
    for (text, message, hint) in &cases {
        errors(&[(&[("[console]", text)], message, hint)]);
    }
    let mixed = include_str!("descriptions/cell.toml");
    let named = |task: &str| {
        let from = "{ station = \"press\", from = \"approach\", until = \"retract\" }";
        parse("cell.toml", &mixed.replacen(from, task, 1)).expect_err(task).into_vec()
    };
    let found = named("{ station = \"press\", task = \"press\" }");
    assert!(found.iter().any(|of| of.message == "station `press` has no tasks"), "{found:?}");
}

#[test]
fn a_task_and_a_stretch_of_a_cycle_are_in_no_conflict() {
    // The feeder of the cyclic cell beside the machine on order.
    let cyclic = include_str!("descriptions/cell.toml");
    let (begin, end) =
        (BASE.find("[[station]]").expect("there"), BASE.find("[[station]]\nname = \"robot\"").expect("there"));
    let device = BASE.find("[[device]]\nname = \"m1").map(|at| &BASE[at..]).expect("there");
    let device = &device[..device[2..].find("\n[[").map_or(device.len(), |at| at + 3)];
    let pair =
        "a = { station = \"feeder\", from = \"push\", until = \"push\" }\nb = { station = \"m1\", task = \"machine\" }";
    let text = format!("{cyclic}\n{}\n{device}\n[[conflict]]\nwhy = \"x\"\n{pair}\n", &BASE[begin..end]);
    let problems = parse("mixed.toml", &text).expect_err("it has one").into_vec();
    assert!(problems.iter().any(|of| of.message == "a conflict of a task with a stretch of a cycle"), "{problems:?}");
}

#[test]
fn what_can_have_parts_and_who_reaches_it() {
    let line = base();
    let handling = &line.handling;
    let names: Vec<&str> = handling.holders.iter().map(|holder| holder.name.as_str()).collect();
    assert_eq!(names, ["m1.clamp", "robot.hand", "ST"], "those of stations first");
    let [clamp, hand, store] = ["m1.clamp", "robot.hand", "ST"].map(|name| handling.holder_named(name).expect("there"));
    assert_eq!(handling.holder(store).places, 6);
    let stand = |station: u16, axis: u16, at: f64| Stand { station: StationId(station), axis: AxisId(axis), at };
    assert_eq!(handling.holder(clamp).grip, Grip::Clamp(stand(0, 0, 60.0)));
    assert_eq!(handling.holder(hand).grip, Grip::Hand(stand(1, 1, 1.0)));
    let to_store = &handling.reaches[0];
    assert_eq!((to_store.hand, to_store.to, &to_store.when[..]), (hand, store, &[stand(1, 0, 50.0)][..]));
    let robot = line.station(StationId(1));
    let bits: Vec<&str> = to_store.position.iter().map(|bit| robot.outputs[bit.index()].as_str()).collect();
    assert_eq!(bits, ["slot_1", "slot_2", "slot_4"]);
    let seen: Vec<_> = handling.sensors.iter().map(|sensor| (sensor.station.0, &sensor.when[..])).collect();
    assert_eq!(seen, [(0, &[Sign::Part(clamp)][..]), (1, &[Sign::Stands(stand(0, 0, 60.0))][..])]);
}

#[test]
fn holders_reaches_and_sensors() {
    errors(&[
        (&[("name = \"ST\"", "name = «\"S.T\"")], "`S.T` cannot name this holder", "full stop"),
        (&[("name = \"ST\"", "name = \"ST\"\n\n[[holder]]\nname = «\"ST\"")], "a second holder named `ST`", ""),
        (&[("places = 6", "places = «0")], "`places` is 0", "between 1 and 10000"),
        (&[("axis = \"grip\", at", "axis = «\"gripp\", at")], "unknown axis `gripp`", "did you mean `grip`?"),
        (&[("axis = \"grip\", at = 1", "axis = \"grip\", at = «2")], "`grip` never stands at 2", "end at 0, 1"),
        (&[("when = { arm = 50 }", "when = { «arm = 51 }")], "`arm` never stands at 51", "0, 50, 100"),
        (
            &[("name = \"hand\"", "name = «\"hand\""), ("closes = { axis = \"grip\", at = 1 }\n", "")],
            "nothing closes the hand `robot.hand`",
            "closes",
        ),
        (&[("kind = \"hand\"", "kind = «\"hnad\"")], "unknown kind `hnad`", "did you mean `hand`?"),
        (&[("hand = \"hand\"", "hand = «\"hnd\"")], "unknown holder `hnd` of this station", "did you mean `hand`?"),
        (
            &[("kind = \"hand\"\n", ""), ("hand = \"hand\"", "hand = «\"hand\"")],
            "`robot.hand` is no hand",
            "kind = \"hand\"",
        ),
        (&[("to = \"ST\"", "to = «\"SP\"")], "unknown holder `SP`", "did you mean `ST`?"),
        (&[("to = \"m1.clamp\"", "to = «\"robot.hand\"")], "`robot.hand` is a hand", "puts down in one"),
        (
            &[("position = [\"slot_1\", \"slot_2\", \"slot_4\"]\n", ""), ("to = \"ST\"", "to = «\"ST\"")],
            "`ST` has 6",
            "",
        ),
        (&[("position = [\"slot_1\", \"slot_2\", \"slot_4\"]", "position = «[\"slot_1\"]")], "1 outputs cannot", ""),
        (
            &[
                ("position = [\"slot_1\"", "position = [\"slot_2\""),
                ("\"slot_2\", \"slot_4\"]\n\n", "«\"slot_2\", \"slot_4\"]\n\n"),
            ],
            "`slot_2` is two bits",
            "",
        ),
        (&[("position = [\"slot_1\"", "position = [«\"slot_8\"")], "no device of station `robot` has an output", ""),
        (&[("places = 6\n", ""), ("position = [", "position = «[")], "`ST` has one position", "leave `position` out"),
        (
            &[
                ("when = { arm = 100 }", "when = { grip = 0 }"),
                ("[[station.reach]]\nhand = \"hand\"\nto = \"m1", "«[[station.reach]]\nhand = \"hand\"\nto = \"m1"),
            ],
            "the hand would reach two nests at once",
            "stand elsewhere",
        ),
        (&[("station = \"m1\"\ninput", "station = «\"m3\"\ninput")], "unknown station `m3`", "did you mean `m1`?"),
        (
            &[("input = \"part_present\"", "input = «\"part_presnt\"")],
            "no device of station `m1` has an input",
            "did you",
        ),
        (&[("input = \"part_present\"", "input = «\"C_60\"")], "`C_60` means two things", "one thing"),
        (&[("input = \"part_present\"", "input = «\"S0\"")], "`S0` means two things", "one thing"),
        (&[("when = [{ part = \"m1.clamp\" }]", "when = []"), ("[[sensor]]", "«[[sensor]]")], "a sensor that sees", ""),
        (&[("{ part = \"m1.clamp\" }", "«{ part = \"m1.clamp\", at = 3 }")], "this says nothing", "robot.hand"),
        (&[("{ part = \"m1.clamp\" }", "{ part = «\"m1.clmp\" }")], "unknown holder `m1.clmp`", "did you mean"),
        (&[("axis = \"m1.clamp\"", "axis = «\"clamp\"")], "`clamp` names no axis", "station.axis"),
        (&[("axis = \"m1.clamp\"", "axis = «\"m9.clamp\"")], "unknown station `m9`", ""),
        (
            &[("axis = \"m1.clamp\"", "axis = «\"m1.clmp\"")],
            "unknown axis of this station `clmp`",
            "did you mean `clamp`?",
        ),
        (&[("axis = \"m1.clamp\", at = 60", "axis = \"m1.clamp\", at = «61")], "`clamp` never stands at 61", "0, 60"),
    ]);
}

#[test]
fn a_hand_that_reaches_nothing_is_worth_a_warning() {
    let text = BASE.replacen("kind = \"hand\"\n", "kind = \"hand\"\ncloses = { axis = \"grip\", at = 1 }\n\n[[station.holder]]\nname = \"other\"\nkind = \"hand\"\n", 1);
    let warnings = parse("on_order.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).warnings;
    let said: Vec<&str> = warnings.iter().map(|problem| problem.message.as_str()).collect();
    assert_eq!(said, ["`robot.other` reaches nothing"]);
}
