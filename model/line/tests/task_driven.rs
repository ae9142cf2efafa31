//! Task-driven stations: contents of the base description.

use linewright_line::{AxisId, ClearanceInputs, Grip, Line, OpId, RestId, Sign, Stand, StationId, TaskId, parse};

const BASE: &str = include_str!("descriptions/task_driven.toml");

fn base() -> Line {
    let parsed = parse("task_driven.toml", BASE).unwrap_or_else(|problems| panic!("{problems:#}"));
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

const MACHINE: &str = "{ station = \"m1\", task = \"machine\" }";
const LOAD: &str = "{ station = \"robot\", task = \"load m1\" }";

/// A conflict of these two, in front of the console.
fn conflict(a: &str, b: &str) -> String {
    format!("[[conflict]]\nwhy = \"the arm is in the way\"\na = {a}\nb = {b}\n\n[console]")
}

#[test]
fn two_tasks_may_be_in_conflict() {
    let text = BASE.replacen("[console]", &conflict(MACHINE, LOAD), 1);
    let line = parse("task_driven.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let [conflict] = &line.conflicts[..] else { panic!("{:?}", line.conflicts) };
    assert!(line.is_of_tasks(conflict));
    let (m1, robot) = (line.station(conflict.a.station), line.station(conflict.b.station));
    assert_eq!((m1.task_of(conflict.a.from), m1.steps_of_span(&conflict.a)), (Some(TaskId(1)), vec![1, 2, 3]));
    assert_eq!(
        (robot.task_of(conflict.b.from), robot.steps_of_span(&conflict.b)),
        (Some(TaskId(0)), vec![0, 1, 2, 3, 4])
    );
    let slide = |at: &str| 1 << m1.inputs.iter().position(|input| input == at).expect("it has it");
    let clear = ClearanceInputs { on: slide("L_0"), off: slide("L_80") | slide("L_100") };
    assert_eq!(line.clearance(&conflict.a), Ok(clear), "no other task moves the slide");
    assert!(line.clearance(&conflict.b).is_err(), "the arm moves in the other task too");
    assert_eq!(line.without_conflicts_of_tasks().conflicts, []);
    assert_eq!(line.without_conflicts_of_tasks().stations, line.stations);
}

#[test]
fn a_task_and_a_stretch_of_a_cycle_are_in_no_conflict() {
    // The feeder of the cyclic cell beside the task-driven machine.
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
fn a_hand_that_reaches_nothing_is_worth_a_warning() {
    let text = BASE.replacen("kind = \"hand\"\n", "kind = \"hand\"\ncloses = { axis = \"grip\", at = 1 }\n\n[[station.holder]]\nname = \"other\"\nkind = \"hand\"\n", 1);
    let warnings = parse("task_driven.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).warnings;
    let said: Vec<&str> = warnings.iter().map(|problem| problem.message.as_str()).collect();
    assert_eq!(said, ["`robot.other` reaches nothing"]);
}

#[test]
fn a_hand_with_a_sensor_that_nothing_looks_at_is_worth_a_warning() {
    let wired = |text: String| text.replacen("\"m1_closed\", \"S0\"", "\"m1_closed\", \"part_in_hand\", \"S0\"", 1);
    let seen =
        "[[sensor]]\nstation = \"robot\"\ninput = \"part_in_hand\"\nwhen = [{ part = \"robot.hand\" }]\n\n[console]";
    let text = wired(BASE.replacen("[console]", seen, 1));
    let warnings = |text: &str| {
        let parsed = parse("task_driven.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
        parsed.warnings.into_iter().map(|problem| problem.message).collect::<Vec<_>>()
    };
    let blind = |name: &str| {
        format!("`{name}` closes `robot.hand`, and nothing in its task looks whether there is a part in it")
    };
    assert_eq!(warnings(&text), [blind("grasp"), blind("grasp at m1")]);
    let result = "result = { input = \"part_in_hand\", within_s = 0.5, code = 24 }\n";
    let text = text.replacen("name = \"grasp\"\n", &format!("name = \"grasp\"\n{result}"), 1);
    assert_eq!(warnings(&text), [blind("grasp at m1")]);
    let waits = "name = \"carry to the store\"\nwaits = [\"part_in_hand\"]\n";
    assert_eq!(warnings(&text.replacen("name = \"carry to the store\"\n", waits, 1)), [] as [String; 0]);

    let line = parse("task_driven.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let robot = line.station(StationId(1));
    let result = robot.operations[1].result.expect("it has one");
    assert_eq!((robot.inputs[result.input.index()].as_str(), result.code), ("part_in_hand", 24));
    assert_eq!(robot.result_before(2), Some((OpId(1), result)), "the carrying waits for it");
    assert_eq!((robot.result_before(1), robot.result_before(5)), (None, None), "and nothing else, in no other task");
    assert_eq!(robot.awaited_by(OpId(2)).collect::<Vec<_>>(), [result.input]);
}
