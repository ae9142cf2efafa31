//! People and faults: the course of an order when a person moves the station, and how it gets back to a rest.

use linewright_line::net::ControlMode;
use linewright_line::net::StationPlace;
use linewright_line::{OpId, StationId};
use linewright_station_logic::PanelCommand::{Advance, Retract};
use linewright_station_logic::{Restore, TaskFailure, TaskOutcome, TaskReply};

use super::bench::{MEMORY, OrderBench, ended, key, order};

#[test]
fn a_fault_ends_the_order_with_its_code_and_leaves_the_station_where_it_is() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    m1.wait(std::time::Duration::from_secs(3));
    assert_eq!(m1.doing(), "clamp close (stopped)");
    assert_eq!(m1.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Fault)));
    assert_eq!(TaskFailure::Fault.code(), 1001);
    assert_eq!(m1.secure(key(1, 1)), ended(TaskFailure::Fault));
    assert_eq!(m1.outputs, 0, "it waits for a person, as every station does");
}

#[test]
fn in_every_mode_in_which_people_move_it_an_order_is_over() {
    for mode in [ControlMode::Hand, ControlMode::Manual, ControlMode::EStop] {
        let mut m1 = OrderBench::machining();
        m1.mode(mode);
        assert_eq!(m1.result(key(1, 2)), Some(TaskOutcome::Failed(TaskFailure::Interrupted)), "{mode}");
        let has_number = m1.on().iter().any(|output| output.starts_with("prog"));
        assert_eq!(has_number, mode != ControlMode::EStop, "{mode}: where it leads to on the way is as before");
        m1.mode(ControlMode::Auto);
        assert_eq!(m1.slot(), None);
    }
}

#[test]
fn led_to_the_end_by_hand_the_order_has_failed_all_the_same() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    m1.mode(ControlMode::Manual);
    m1.through(Advance(true));
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.run(&order(1, "clamp")), ended(TaskFailure::Interrupted));
    m1.done(&order(2, "machine"));
}

/// The wait of a station at the rest where its task was taken back to.
fn taken_back(op: &str) -> String {
    format!(
        "a task: its order in auto, or advance at its panel to begin {op} again; it is at rest, its task taken back"
    )
}

#[test]
fn taken_back_at_the_panel_it_stands_where_the_task_began_and_any_task_can_begin() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.hold(&[Retract(true)]);
    m1.hold(&[]);
    assert_eq!(
        (m1.doing().as_str(), m1.rest().as_deref()),
        ("at rest \"clamped\"", Some("clamped")),
        "it had hardly moved"
    );
    assert_eq!(m1.blocked_by(), [taken_back("slide in")], "nothing is amiss");
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.doing(), "at rest \"clamped\"");
    m1.done(&order(3, "release"));
}

#[test]
fn where_it_was_left_between_two_operations_it_can_be_told_to_go_back() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.through(Advance(true));
    assert_eq!(m1.doing(), "slide in (done)");
    m1.mode(ControlMode::Auto);
    assert_eq!((m1.outputs, m1.rest()), (0, None));
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    assert_eq!(m1.on(), ["Y_out", "prog_1", "prog_4"]);
    m1.arrive();
    assert_eq!((m1.rest().as_deref(), m1.slot()), (Some("clamped"), None));
    assert_eq!(m1.result(key(1, 2)), Some(TaskOutcome::Failed(TaskFailure::Interrupted)));
}

#[test]
fn told_to_go_back_while_people_move_it_it_does_not_go_back_later_on_a_copy_of_that() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.through(Advance(true));
    let interrupted = ended(TaskFailure::Interrupted);
    assert_eq!(m1.secure(key(1, 2)), interrupted, "not while people move it");
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.secure(key(1, 2)), interrupted, "whoever told it knows that it stands");
    assert_eq!((m1.outputs, m1.slot()), (0, None));
}

#[test]
fn once_it_has_rested_after_its_order_it_does_not_go_back_from_where_people_lead_it_since() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.hold(&[Retract(true)]);
    m1.hold(&[]);
    assert_eq!(m1.rest().as_deref(), Some("clamped"), "heard here, it need not be told to come to rest");
    m1.through(Advance(true));
    m1.mode(ControlMode::Auto);
    assert_eq!((m1.slot(), m1.rest()), (None, None));
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Interrupted));
    assert_eq!((m1.outputs, m1.slot()), (0, None));
}

#[test]
fn from_an_order_that_it_never_had_it_does_not_go_back() {
    let mut m1 = OrderBench::clamped();
    m1.mode(ControlMode::Hand);
    m1.press("PB_run");
    m1.release();
    m1.mode(ControlMode::Manual);
    m1.through(Advance(true));
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.rest(), None, "a person has left it there");
    let cancelled = ended(TaskFailure::Cancelled);
    assert_eq!(m1.secure(key(1, 2)), cancelled);
    assert_eq!(m1.secure(key(1, 2)), cancelled, "a copy");
    assert_eq!((m1.outputs, m1.slot()), (0, None));
}

#[test]
fn left_on_a_recovery_path_it_has_nothing_to_go_back_by_and_is_not_at_its_order_for_ever() {
    let mut m1 = OrderBench::machining();
    m1.arrive();
    m1.mode(ControlMode::Manual);
    m1.through(Retract(true));
    assert_eq!((m1.doing().as_str(), m1.rest()), ("slide in (undone)", None), "the end of the task would follow");
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Interrupted));
    assert_eq!((m1.outputs, m1.slot()), (0, None));
}

#[test]
fn a_fault_of_an_irreversible_operation_is_left_along_its_path_to_the_rest_of_its_task() {
    let mut m1 = OrderBench::machining();
    m1.arrive();
    m1.set("F_mill", true);
    m1.set("F_mill", false);
    m1.mode(ControlMode::Manual);
    m1.events();
    m1.through(Retract(true));
    assert_eq!(m1.doing(), "slide in (undone)");
    // The last operation of the task follows, and finds its axis there already.
    m1.hold(&[Retract(true)]);
    m1.hold(&[]);
    assert_eq!((m1.marking(), m1.rest().as_deref()), (StationPlace::completed(OpId(3)), Some("clamped")));
    let report = m1.controller.report();
    assert_eq!((report.done, report.started), (vec![1, 0, 0, 0, 0], vec![1, 0, 0, 0, 0]), "nothing of the task counts");
    assert_eq!(m1.events().last().map(String::as_str), Some("returned to the rest where the task began"));
    m1.mode(ControlMode::Auto);
    m1.done(&order(3, "machine"));
}

#[test]
fn in_hand_mode_each_task_has_its_button() {
    let mut m1 = OrderBench::new();
    m1.mode(ControlMode::Hand);
    assert_eq!(m1.blocked_by(), ["a button: PB_close for clamp"]);
    m1.press("PB_close");
    m1.arrive();
    m1.release();
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    assert_eq!(m1.blocked_by(), ["a button: PB_run for machine, PB_open for release"]);
    m1.press("PB_run");
    for doing in ["slide in", "mill", "slide out"] {
        assert_eq!(m1.doing(), doing);
        m1.arrive();
    }
    assert_eq!((m1.rest().as_deref(), m1.outputs), (Some("clamped"), 0), "held on it begins nothing");
    m1.release();
    m1.press("PB_back");
    assert_eq!(m1.doing(), "at rest \"clamped\"", "a sequence that is never reversed");
    m1.release();
    m1.press("PB_open");
    assert_eq!(m1.on(), ["Y_open"]);
}

#[test]
fn in_hand_mode_nothing_starts_before_what_it_waits_for_is_there() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    m1.mode(ControlMode::Hand);
    m1.press("PB_close");
    assert_eq!(m1.outputs, 0);
    m1.release();
    m1.set("part_present", true);
    m1.press("PB_close");
    assert_eq!(m1.on(), ["Y_close"]);
}

/// Advance is held once too often easily: it ends what was begun, and out of a rest a task is chosen.
#[test]
fn the_panel_leads_a_task_to_its_rest_and_begins_none() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    for doing in ["slide in", "mill", "slide out"] {
        m1.hold(&[Advance(true)]);
        assert_eq!(m1.doing(), doing);
        m1.arrive();
        m1.hold(&[]);
    }
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    m1.events();
    for _ in 0..3 {
        m1.hold(&[Advance(true)]);
        assert_eq!((m1.doing().as_str(), m1.outputs), ("at rest \"clamped\"", 0));
        m1.hold(&[]);
    }
    assert_eq!(m1.events()[0], "rejected the command");
    let chosen = "a task: its order in auto, or its button in hand mode; at a rest its panel moves nothing";
    assert_eq!(m1.blocked_by(), [chosen]);
}

#[test]
fn the_panel_takes_a_task_back_to_its_rest_and_none_that_is_done() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.through(Advance(true));
    assert_eq!(m1.doing(), "slide in (done)");
    m1.through(Retract(true));
    assert_eq!(m1.doing(), "at rest \"clamped\"");
    assert_eq!(m1.blocked_by(), [taken_back("slide in")]);
    m1.hold(&[Retract(true)]);
    assert_eq!((m1.doing().as_str(), m1.outputs), ("at rest \"clamped\"", 0), "a rest is a stop");
    m1.hold(&[]);
    m1.events();
    for _ in 0..3 {
        m1.hold(&[Retract(true)]);
        assert_eq!((m1.doing().as_str(), m1.outputs), ("at rest \"clamped\"", 0));
        m1.hold(&[]);
    }
    assert_eq!(m1.events()[0], "rejected the command");
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    // In hand mode it is chosen.
    m1.mode(ControlMode::Hand);
    m1.press("PB_open");
    m1.arrive();
    assert_eq!(m1.rest().as_deref(), Some("open"));
}

/// What a motion waits for is named first, with where it is wired, at the panel and by hand button alike.
#[test]
fn an_input_that_holds_a_motion_is_named_in_hand_and_in_manual() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    m1.mode(ControlMode::Manual);
    m1.hold(&[Retract(true)]);
    m1.hold(&[]);
    m1.set("part_present", false);
    m1.hold(&[Advance(true)]);
    assert_eq!((m1.doing().as_str(), m1.outputs), ("at rest \"open\"", 0));
    let missing = "part_present (m1 io, node 02h, 6000h:01 bit 6) to be on, for clamp close";
    assert_eq!(m1.blocked_by(), [missing, &taken_back("clamp close")]);
    m1.hold(&[]);
    m1.mode(ControlMode::Auto);
    m1.mode(ControlMode::Hand);
    assert_eq!(m1.blocked_by(), [missing, "a button: PB_close for clamp"]);
}

/// A sequence is taken back from its end, and a task that was taken back is led on to the rest: what waits for a button says so.
#[test]
fn what_a_button_does_not_do_within_a_sequence_is_named() {
    let mut robot = OrderBench::standing(StationId(1), Restore::Fresh, MEMORY, &["A_0", "G_0"]);
    robot.mode(ControlMode::Hand);
    robot.press("PB_load");
    robot.release();
    robot.mode(ControlMode::Manual);
    robot.through(Advance(true));
    robot.mode(ControlMode::Hand);
    assert_eq!(robot.doing(), "to the store (done)");
    robot.press("PB_back");
    assert_eq!((robot.doing().as_str(), robot.outputs), ("to the store (done)", 0), "t4 is the last operation's alone");
    robot.release();
    let midway = "a button: PB_load to go on; PB_back takes back only from the end of the sequence (from here: return at \
                  its panel in manual)";
    assert_eq!(robot.blocked_by(), [midway]);

    let mut m1 = OrderBench::new();
    m1.mode(ControlMode::Hand);
    m1.press("PB_close");
    m1.arrive();
    m1.release();
    m1.press("PB_back");
    m1.arrive();
    m1.release();
    assert_eq!((m1.doing().as_str(), m1.rest().as_deref()), ("at rest \"open\"", Some("open")));
    let undone = "a button: PB_close to do it again; for another task, return at its panel in manual, or auto";
    assert_eq!(m1.blocked_by(), [undone]);
    m1.mode(ControlMode::Manual);
    m1.hold(&[Retract(true)]);
    m1.hold(&[]);
    m1.mode(ControlMode::Hand);
    assert_eq!(m1.blocked_by(), ["a button: PB_close for clamp"], "as it says");
}
