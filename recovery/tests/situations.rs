//! Situations of the shipped line, each with its plan.

use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, ModeStanding};
use linewright_line::net::{ControlMode, MotionStage, StationPlace};
use linewright_line::{Line, StationId};
use linewright_plant::MotionFault;
use linewright_recovery::{LineSituation, Need, RecoveryAction, RecoveryEnd, RecoveryStep, RejoinChoice, plan};
use linewright_simulation::{LineSim, MotionSelection, NodeProcess, OperatorAction};
use linewright_station_logic::{RejoinAt, StopCause};
use linewright_testkit::built::transfer_line;

use crate::operator::{command, in_auto, recover, run_for, situation, switched_on, works_on};

fn op(line: &Line, station: usize, name: &str) -> (StationId, linewright_line::OpId) {
    (StationId::at(station), line.stations[station].operation_named(name).expect("it has it"))
}

fn act(sim: &mut LineSim, action: OperatorAction) {
    sim.act(action).expect("it is done");
}

fn texts(sim: &LineSim) -> Vec<String> {
    plan(sim.line(), &situation(sim)).steps.iter().map(|step| step.text(sim.line())).collect()
}

/// The line in auto, with an operation that jams in the first cycle, and works again after its watchdog.
fn after_a_jam(station: usize, name: &str) -> LineSim {
    let line = transfer_line();
    let mut sim = in_auto(&line, 1, Duration::ZERO);
    let op = op(&line, station, name);
    act(&mut sim, OperatorAction::Fail(op, MotionSelection::Normal, Some(MotionFault::Stick)));
    while sim.mode() == ControlMode::Auto {
        run_for(&mut sim, Duration::from_millis(100));
    }
    act(&mut sim, OperatorAction::Fail(op, MotionSelection::Normal, None));
    run_for(&mut sim, Duration::from_secs(10));
    sim
}

#[test]
fn a_line_at_home_is_started_by_two_commands() {
    let sim = switched_on(&transfer_line(), 1);
    assert_eq!(texts(&sim), ["command start", "command auto"]);
}

#[test]
fn the_age_of_an_image_makes_no_other_situation() {
    let line = transfer_line();
    let sim = switched_on(&line, 1);
    let aged = |ms| {
        let mut stations = situation(&sim).stations;
        stations.iter_mut().flatten().for_each(|report| report.measured_age = Duration::from_millis(ms));
        LineSituation::read(&line, sim.mode(), true, ModeStanding::default(), stations)
    };
    assert_eq!(aged(3), aged(20));
}

#[test]
fn in_auto_there_is_nothing_to_do() {
    let sim = in_auto(&transfer_line(), 1, Duration::from_secs(1));
    let plan = plan(sim.line(), &situation(&sim));
    assert_eq!((plan.steps.len(), plan.end), (0, RecoveryEnd::Auto));
}

/// While a button is held, the plan says to hold it on: there is nothing to wait for.
#[test]
fn what_is_held_is_held_on_until_its_motion_has_ended() {
    let mut sim = after_a_jam(0, "advance transfer");
    command(&mut sim, ModeCommand::Manual);
    let before = texts(&sim);
    assert!(before[0].starts_with("transfer: hold advance until `advance transfer` is done"), "{before:#?}");
    act(&mut sim, OperatorAction::Panel { station: StationId(0), advance: true, down: true });
    run_for(&mut sim, Duration::from_millis(200));
    assert!(!sim.controller(StationId(0)).expect("it is up").report().stopped);
    assert_eq!(texts(&sim), before);
    run_for(&mut sim, Duration::from_secs(2));
    act(&mut sim, OperatorAction::Panel { station: StationId(0), advance: true, down: false });
    run_for(&mut sim, Duration::from_secs(1));
    assert_eq!(texts(&sim), before[1..]);
}

#[test]
fn an_operation_that_jammed_half_way_is_led_on_in_manual() {
    let mut sim = after_a_jam(0, "advance transfer");
    assert_eq!(
        texts(&sim),
        [
            "command manual",
            "transfer: hold advance until `advance transfer` is done: horizontal to 500, LS_horizontal_500 on, 0.5 s",
            "command auto",
        ]
    );
    recover(&mut sim);
    works_on(&mut sim);
}

#[test]
fn an_irreversible_operation_that_was_stopped_is_led_on_and_not_undone() {
    let mut sim = after_a_jam(2, "feed main slide");
    let plan = recover(&mut sim);
    assert_eq!(plan.presses(), 1);
    works_on(&mut sim);
}

#[test]
fn after_an_emergency_stop_reset_and_manual_come_first() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(1500));
    command(&mut sim, ModeCommand::EStop);
    let all = texts(&sim);
    assert_eq!(all[..2], ["command reset", "command manual"]);
    assert_eq!(all.last().map(String::as_str), Some("command auto"));
    let plan = recover(&mut sim);
    assert!(plan.is_shortest);
    works_on(&mut sim);
}

#[test]
fn after_a_reset_it_is_not_given_again() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(1500));
    command(&mut sim, ModeCommand::EStop);
    command(&mut sim, ModeCommand::Reset);
    assert_eq!(texts(&sim)[0], "command manual");
}

#[test]
fn a_station_that_is_not_heard_comes_first_and_then_the_plan_is_made_anew() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(1500));
    act(&mut sim, OperatorAction::Kill(NodeProcess::Station(StationId(1))));
    run_for(&mut sim, Duration::from_secs(5));
    let now = plan(sim.line(), &situation(&sim));
    assert_eq!(
        now.steps.iter().map(|step| &step.action).collect::<Vec<_>>(),
        [&RecoveryAction::First(Need::Heard(StationId(1)))]
    );
    assert_eq!(now.end, RecoveryEnd::LookAgain);
    act(&mut sim, OperatorAction::Restart(NodeProcess::Station(StationId(1))));
    run_for(&mut sim, Duration::from_secs(2));
    recover(&mut sim);
    works_on(&mut sim);
}

#[test]
fn a_station_that_was_restarted_between_two_motions_needs_a_start_alone() {
    let mut sim = after_a_jam(0, "advance transfer");
    recover(&mut sim);
    // The clamp waits for the bar, which moves.
    run_for(&mut sim, Duration::from_millis(200));
    let clamp = StationId(1);
    let moving = |sim: &LineSim| sim.controller(clamp).is_some_and(|c| !c.report().stopped);
    while moving(&sim) {
        run_for(&mut sim, Duration::from_millis(50));
    }
    act(&mut sim, OperatorAction::Kill(NodeProcess::Station(clamp)));
    run_for(&mut sim, Duration::from_millis(100));
    act(&mut sim, OperatorAction::Restart(NodeProcess::Station(clamp)));
    run_for(&mut sim, Duration::from_secs(5));
    assert_eq!(texts(&sim), ["command start", "command auto"]);
    recover(&mut sim);
    works_on(&mut sim);
}

#[test]
fn a_lost_memory_away_from_home_leads_all_home() {
    for long in [900, 2_300, 4_100] {
        let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(long));
        act(&mut sim, OperatorAction::Kill(NodeProcess::Station(StationId(1))));
        run_for(&mut sim, Duration::from_secs(3));
        act(&mut sim, OperatorAction::RestartEmpty(NodeProcess::Station(StationId(1))));
        run_for(&mut sim, Duration::from_secs(2));
        recover(&mut sim);
        works_on(&mut sim);
    }
}

#[test]
fn selectors_that_stand_at_manual_are_turned_back() {
    let mut sim = after_a_jam(0, "advance transfer");
    act(&mut sim, OperatorAction::Selector(StationId(1), true));
    run_for(&mut sim, Duration::from_secs(1));
    let all = texts(&sim);
    assert_eq!(all[0], "transfer: selector to manual");
    assert_eq!(all[2..], ["clamp_1: selector to auto", "transfer: selector to auto", "command auto"]);
    recover(&mut sim);
    works_on(&mut sim);
}

/// The selector is an input of the station: what stands at its panel no message turns.
#[test]
fn a_wired_selector_is_turned_at_its_panel() {
    for jams in [false, true] {
        let mut sim =
            if jams { after_a_jam(0, "advance transfer") } else { in_auto(&transfer_line(), 1, Duration::ZERO) };
        let clamp = &sim.line().stations[1];
        let selector = clamp.panel.manual.expect("it is wired");
        act(&mut sim, OperatorAction::Force(Some(StationId(1)), selector, Some(true)));
        run_for(&mut sim, Duration::from_secs(10));
        assert_eq!(sim.mode(), ControlMode::Manual);
        let found = plan(sim.line(), &situation(&sim));
        let turn = "clamp_1: turn the selector at its panel to auto: SS_manual";
        assert!(found.steps.iter().any(|step| step.text(sim.line()).starts_with(turn)), "{:?}", texts(&sim));
        assert_eq!((&found.end, found.presses()), (&RecoveryEnd::Auto, usize::from(jams)), "{:?}", texts(&sim));
        recover(&mut sim);
        works_on(&mut sim);
    }
}

#[test]
fn a_lost_device_and_a_fault_signal_are_named_first() {
    let mut sim = after_a_jam(0, "advance transfer");
    let mut seen = situation(&sim);
    let report = seen.stations[1].as_mut().expect("it is heard");
    report.devices_valid = false;
    let plan = plan(sim.line(), &seen);
    assert_eq!(plan.steps[0].action, RecoveryAction::First(Need::Devices(StationId(1))));
    assert_eq!(plan.end, RecoveryEnd::Auto);
    recover(&mut sim);
}

#[test]
fn a_fault_signal_is_off_where_it_has_stopped_something_and_is_not_on() {
    let (sim, line) = (after_a_jam(0, "advance transfer"), transfer_line());
    let mut seen = situation(&sim);
    let stopped =
        line.station_ids().find(|id| !seen.stations[id.index()].as_ref().expect("it is heard").incomplete.is_empty());
    let stopped = stopped.expect("one has jammed");
    assert_eq!(seen.signals_off(&line), []);
    let with = |seen: &mut LineSituation, cause, valid| {
        let report = seen.stations[stopped.index()].as_mut().expect("it is heard");
        (report.incomplete[0].1, report.devices_valid) = (cause, valid);
        seen.signals_off(&line)
    };
    assert_eq!(with(&mut seen, StopCause::Signal, true), [stopped]);
    assert_eq!(with(&mut seen, StopCause::Signal, false), [], "nothing is known of it");
    assert_eq!(with(&mut seen, StopCause::Watchdog, true), []);
}

/// A switch of clamp 1 is held on, or nothing is.
fn force(sim: &mut LineSim, input: &str, on: Option<bool>) {
    let clamp = &sim.line().stations[1];
    let at = clamp.inputs.iter().position(|name| name == input).expect("it has it");
    act(sim, OperatorAction::Force(Some(StationId(1)), linewright_line::InputId(at as u16), on));
}

/// A switch of clamp 1 sticks until auto ends; return is held while it still does, and let go before the watchdog has run out.
fn led_back_onto_a_switch_that_was_on() -> LineSim {
    let input = "LS_open";
    let mut sim = in_auto(&transfer_line(), 1, Duration::ZERO);
    force(&mut sim, input, Some(true));
    while sim.mode() == ControlMode::Auto {
        run_for(&mut sim, Duration::from_millis(100));
    }
    run_for(&mut sim, Duration::from_secs(10));
    command(&mut sim, ModeCommand::Manual);
    let hold = |down| OperatorAction::Panel { station: StationId(1), advance: false, down };
    act(&mut sim, hold(true));
    run_for(&mut sim, Duration::from_millis(800));
    act(&mut sim, hold(false));
    run_for(&mut sim, Duration::from_millis(300));
    force(&mut sim, input, None);
    run_for(&mut sim, Duration::from_secs(1));
    let report = sim.controller(StationId(1)).expect("it is up").report();
    assert_eq!(report.incomplete.len(), 1, "it was not taken for the arrival");
    sim
}

#[test]
fn a_switch_that_was_on_before_the_motion_is_left_by_the_other_button() {
    let mut sim = led_back_onto_a_switch_that_was_on();
    let all = texts(&sim);
    assert!(all[0].starts_with("clamp_1: hold advance until"), "{all:?}");
    recover(&mut sim);
    works_on(&mut sim);
}

/// The clamp is open, and its switch for closed is on as well.
#[test]
fn a_switch_that_contradicts_where_a_station_stands_stops_the_one_that_relies_on_it() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(500));
    force(&mut sim, "LS_closed", Some(true));
    run_for(&mut sim, Duration::from_secs(20));
    assert_eq!(sim.mode(), ControlMode::StandBy);
    let bar = sim.controller(StationId(0)).expect("it is up").report();
    let stopped = bar.incomplete.first().expect("it was on its way").1;
    assert!(
        matches!(stopped, StopCause::Interlock { station: StationId(1), input: Some(_), is_on: true }),
        "{stopped:?}"
    );
    force(&mut sim, "LS_closed", None);
    run_for(&mut sim, Duration::from_secs(1));
    recover(&mut sim);
    works_on(&mut sim);
}

/// Somebody has moved clamp 1 by hand, from open to closed; its controller has it open.
#[test]
fn where_a_position_is_to_be_confirmed_that_comes_before_a_press() {
    let line = transfer_line();
    let (bar, lower) = op(&line, 0, "4th lower");
    let stopped = |milliseconds: u64| {
        let mut sim = in_auto(&line, 1, Duration::from_millis(milliseconds));
        command(&mut sim, ModeCommand::EStop);
        situation(&sim)
    };
    let is_lowering = |seen: &LineSituation| {
        let report = seen.stations[bar.index()].as_ref().expect("it is heard");
        report.incomplete.iter().any(|&(op, _)| op == lower)
    };
    let mut seen = (0..200).map(|nth| stopped(nth * 40)).find(is_lowering).expect("the bar is stopped on its way down");
    let clamp = &line.stations[1];
    let bit = |name: &str| 1u128 << clamp.inputs.iter().position(|input| input == name).expect("it has it");
    let report = seen.stations[1].as_mut().expect("it is heard");
    assert!(report.incomplete.is_empty() && report.measured & bit("LS_open") != 0, "{report:?}");
    report.measured = report.measured & !bit("LS_open") | bit("LS_closed");
    report.position_lost = Some((linewright_line::OpId(0), linewright_line::InputId(0)));
    let found = plan(&line, &seen);
    let all: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    let of_clamp = all.iter().find(|text| text.starts_with("clamp_1"));
    assert_eq!(
        of_clamp.map(String::as_str),
        Some("clamp_1: look, and if it stands so (advance clamp done: stroke at 60, LS_closed on): rejoin")
    );
    assert_eq!(found.end, RecoveryEnd::Auto, "{all:?}");
}

/// The only way is to believe the switch: it is held until the watchdog would have reported it.
#[test]
fn where_nothing_is_to_move_the_button_is_held_longer_than_the_watchdog() {
    let mut sim = after_a_jam(2, "feed main slide");
    let mut seen = situation(&sim);
    let line = sim.line().clone();
    let mill = &line.stations[2];
    let feed = &mill.operations[mill.operation_named("feed main slide").expect("it has it").index()];
    seen.stations[2].as_mut().expect("it is heard").measured |= feed.normal.complete.bit();
    let found = plan(&line, &seen);
    let believed = found.steps.iter().find(|step| step.is_doubtful);
    let held: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert!(believed.is_none_or(|step| step.hold(&line) > feed.watchdog), "{held:?}");
    assert!(believed.is_some(), "{held:?}");
    recover(&mut sim);
}

/// A person compares with what is seen at the machine.
#[test]
fn a_station_that_is_to_be_confirmed_is_named_with_where_it_stands() {
    let line = transfer_line();
    let (station, op) = op(&line, 1, "advance clamp");
    let place = StationPlace { stage: MotionStage::Completed, ..StationPlace::operating(op) };
    let on = line.station(station).rest_inputs(place);
    let at = RejoinChoice { at: RejoinAt::Measured, places: vec![place], on, numbers: Vec::new(), activity: None };
    let action = RecoveryAction::Rejoin { station, at, or: Vec::new() };
    let step = RecoveryStep { action, moves: Vec::new(), mode: ControlMode::Manual, after: None, is_doubtful: false };
    let expected = "clamp_1: look, and if it stands so (advance clamp done: stroke at 60, LS_closed on): rejoin";
    assert_eq!(step.text(&line), expected);
}

#[test]
fn a_station_with_another_description_ends_the_list_at_once() {
    let line = transfer_line();
    let stations = line.station_ids().map(|_| None).collect();
    let seen = LineSituation { misfit: Some(StationId(1)), ..LineSituation::of(&line, ControlMode::StandBy, stations) };
    let found = plan(&line, &seen);
    assert!(found.steps.is_empty());
    let text = found.end_text(&line).concat();
    assert_eq!(
        text,
        format!("{}: its report does not fit this description; give the one that it runs with", line.stations[1].name)
    );
}

/// A station with two axes was started without its journal while both stood between switches: no operation fits.
#[test]
fn two_axes_between_switches_are_put_onto_them_by_hand() {
    use linewright_station_logic::{Controller, NO_DELAY, Restore, StationInput, StationOutbox};
    let sim = after_a_jam(2, "feed main slide");
    let (line, id) = (sim.line().clone(), StationId(2));
    let mut seen = situation(&sim);
    let station = line.station(id);
    let before = seen.stations[id.index()].as_ref().expect("it is heard").measured;
    let ends = (0..station.axes.len()).flat_map(|axis| {
        let axis = linewright_line::AxisId::at(axis);
        let motions = station.operations.iter().map(|of| of.motion).filter(move |motion| motion.axis == axis);
        motions.flat_map(move |motion| [motion.from, motion.to]).map(move |at| (axis, at))
    });
    let bits = ends.fold(before, |bits, (axis, at)| bits & !station.switches_at(axis, at));
    let mut controller = Controller::new(&line, id, 99, Restore::Fresh).expect("it compiles");
    let (now, until, under) = (sim.now(), linewright_line::Tick::NEVER, NO_DELAY);
    controller.handle(now, StationInput::Inputs { bits, valid: true, until, under });
    controller.step(now, &mut StationOutbox::default());
    seen.stations[id.index()] = Some(linewright_recovery::as_received(controller.report()));
    let found = plan(&line, &seen);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
    let by_hand = texts.iter().filter(|text| text.contains("by hand, with its drive off, onto")).count();
    assert_eq!(by_hand, 1, "the other axis is led on then: {texts:#?}");
    let slide = "mill_1: bring `positioning_slide` by hand, with its drive off, onto LS_positioning_0";
    assert!(texts[0].starts_with(slide) && !texts[0].contains("in its way"), "{texts:#?}");
    // The way back to where it meets nothing leads past where it may: with the clamp's switches not read, a person looks first.
    let mut unread = seen.clone();
    unread.stations[1].as_mut().expect("it is heard").devices_valid = false;
    let by_hand = plan(&line, &unread).steps.into_iter().map(|step| step.text(&line));
    let by_hand = by_hand.filter(|text| text.contains("`positioning_slide` by hand")).collect::<Vec<_>>().concat();
    assert!(by_hand.contains("look first whether clamp_1 is in its way, there or on the way there"), "{by_hand}");
    // Where clamp 1 is not measured closed, the slide may meet it anywhere but at home.
    let need = Need::Axis {
        station: id,
        op: linewright_line::OpId(0),
        input: linewright_line::InputId(0),
        conflicts: vec![1],
    };
    let action = RecoveryAction::First(need);
    let step = RecoveryStep { action, moves: Vec::new(), mode: ControlMode::Manual, after: None, is_doubtful: false };
    let look = "; look first whether clamp_1 is in its way, there or on the way there (the tool of mill 1 is forward while clamp 1 is not closed)";
    assert!(step.text(&line).ends_with(look), "{}", step.text(&line));
}
