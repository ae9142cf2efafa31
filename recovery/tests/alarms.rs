//! Alarms of a cell in a plan: what they ask to be led is led, and they are answered.

use linewright_coordinator_cell::texts::{AnswerFit, AnswerRemark, ListedAnswer};
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{InputId, Line, OpId, StationId, Tick};
use linewright_recovery::{
    InterruptedTask, LineSituation, Need, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, StandingAlarm, plan,
};
use linewright_station_logic::{Controller, NO_DELAY, RejoinAt, Restore, StationInput, StationOutbox, StationSnapshot};

use crate::cells::{half_way, shipped};
use crate::holding::reported;

/// An alarm of an activity whose stations are held between two rests.
fn alarm(lead: &[StationId], reset: &[StationId]) -> StandingAlarm {
    let meaning = "not done, part at M1".to_owned();
    let as_before = ListedAnswer { meaning, ..ListedAnswer::from("as-before") };
    StandingAlarm {
        id: 3,
        text: "M1.process failed. Answer where the part is.".to_owned(),
        answers: vec![as_before, ListedAnswer::from("gone")],
        lead: lead.to_vec(),
        reset: reset.to_vec(),
        at_order: Vec::new(),
        end: None,
        bring: None,
    }
}

/// Two stations of the workcell stand half-way, and are left out of the mode; the others stand at rests.
fn two_are_left_out(mode: ControlMode) -> (Line, LineSituation) {
    let [(_, line), _] = shipped();
    let mut seen = half_way(&line);
    let stopped = |id: &StationId| seen.stations[id.index()].as_ref().is_some_and(|of| !of.incomplete.is_empty());
    let held: Vec<StationId> = line.station_ids().filter(stopped).take(2).collect();
    for id in line.station_ids().filter(|id| !held.contains(id)) {
        let mut controller = Controller::new(&line, id, 7, Restore::Fresh).expect("a shipped station compiles");
        let bits = at_home(&line, id);
        let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
        controller.handle(now, StationInput::Inputs { bits, valid: true, until, under });
        controller.step(now, &mut StationOutbox::default());
        seen.stations[id.index()] = Some(controller.report());
    }
    seen.alarms = vec![alarm(&held, &[])];
    seen.left_out = held;
    seen.mode = mode;
    (line, seen)
}

/// Its switches at home.
fn at_home(line: &Line, id: StationId) -> u128 {
    let station = line.station(id);
    let home = StationPlace::completed(station.home);
    station.rest_inputs(home) | station.operations[station.home.index()].normal.complete.bit()
}

fn place_of(steps: &[RecoveryStep], is_it: impl Fn(&RecoveryAction) -> bool) -> Option<usize> {
    steps.iter().position(|step| is_it(&step.action))
}

fn commands(plan: &RecoveryPlan) -> Vec<ModeCommand> {
    let command = |step: &RecoveryStep| match step.action {
        RecoveryAction::Command(command) => Some(command),
        _ => None,
    };
    plan.steps.iter().filter_map(command).collect()
}

#[test]
fn stations_that_an_alarm_asks_about_are_led_to_a_rest_before_its_answer() {
    for mode in [ControlMode::StandBy, ControlMode::Auto] {
        let (line, seen) = two_are_left_out(mode);
        let found = plan(&line, &seen);
        let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
        let manual = place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Manual));
        let answer = place_of(&found.steps, |of| matches!(of, RecoveryAction::First(Need::Answer(_))));
        let stop = place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Stop));
        assert_eq!(stop, (mode == ControlMode::Auto).then_some(0), "{texts:#?}");
        assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
        assert_eq!(answer, Some(found.steps.len() - 2), "the last but auto: {texts:#?}");
        for &held in &seen.left_out {
            let led: Vec<usize> = (0..found.steps.len())
                .filter(|&at| matches!(found.steps[at].action, RecoveryAction::Press(station, _) if station == held))
                .collect();
            assert!(led.iter().all(|&at| Some(at) > manual && Some(at) < answer), "{texts:#?}");
            let last = led.last().and_then(|&at| found.steps[at].after.as_ref());
            assert!(last.is_some_and(|after| after.at_home && after.is_in_order), "{texts:#?}");
        }
    }
}

/// Beside auto nothing is stopped for it, and no answer is taken before it is in auto again.
#[test]
fn a_station_in_manual_by_itself_is_led_and_given_auto_before_the_answer() {
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    let alone = seen.left_out.clone();
    for &id in &alone {
        let report = seen.stations[id.index()].as_mut().expect("heard");
        report.mode = Some(ControlMode::Manual);
    }
    let found = plan(&line, &seen);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    let is_command = |of: &RecoveryAction| matches!(of, RecoveryAction::Command(_));
    assert_eq!((place_of(&found.steps, is_command), &found.end), (None, &RecoveryEnd::Auto), "{texts:#?}");
    let answer = place_of(&found.steps, |of| matches!(of, RecoveryAction::First(Need::Answer(_))));
    assert_eq!(answer, Some(found.steps.len() - 1), "{texts:#?}");
    for &id in &alone {
        let pressed = place_of(&found.steps, |of| matches!(of, RecoveryAction::Press(station, _) if *station == id));
        let again = place_of(&found.steps, |of| *of == RecoveryAction::AutoAgain(id));
        assert!(pressed.is_some() && pressed < again && again < answer, "{texts:#?}");
        let name = &line.station(id).name;
        let command = found.steps[again.expect("a step")].commands(&line);
        assert_eq!(command, [["mode", "LINE", "auto", "--station", name]]);
    }
    // At a rest already: auto alone.
    for &id in &alone {
        let report = seen.stations[id.index()].as_mut().expect("heard");
        (report.at_home, report.position_lost) = (true, None);
        report.incomplete.clear();
    }
    let found = plan(&line, &seen);
    assert_eq!(found.steps.len(), alone.len() + 1);
}

/// One station alone half-way takes two commands, and the others go on. What manual by itself does not lead, or is not granted, is led in
/// manual of the line.
#[test]
fn a_single_station_that_stands_half_way_is_led_beside_auto() {
    let whole = |line: &Line, seen: &LineSituation| {
        let found = plan(line, seen);
        let texts: Vec<String> = found.steps.iter().map(|step| step.text(line)).collect();
        let stop = place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Stop));
        assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
        (stop.is_some(), found, texts)
    };
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    let [one, other] = seen.left_out[..] else { panic!("two") };
    let at_rest = seen.stations.iter().flatten().find(|report| report.at_home).cloned().expect("one stands at a rest");
    seen.left_out = vec![one];
    seen.alarms = vec![alarm(&[one], &[])];
    let stands = seen.stations[other.index()].as_mut().expect("heard");
    (stands.at_home, stands.position_lost, stands.mode) = (true, None, at_rest.mode);
    stands.incomplete.clear();
    let (is_whole, found, texts) = whole(&line, &seen);
    assert!(!is_whole, "{texts:#?}");
    let name = &line.station(one).name;
    assert_eq!(found.steps[0].action, RecoveryAction::ManualAlone(one), "{texts:#?}");
    assert_eq!(found.steps[0].commands(&line), [["mode", "LINE", "manual", "--station", name]]);
    let [presses @ .., again, answer] = &found.steps[1..] else { panic!("{texts:#?}") };
    assert!(!presses.is_empty(), "{texts:#?}");
    assert!(presses.iter().all(|step| matches!(step.action, RecoveryAction::Press(id, _) if id == one)), "{texts:#?}");
    assert_eq!(again.action, RecoveryAction::AutoAgain(one), "{texts:#?}");
    assert!(matches!(answer.action, RecoveryAction::First(Need::Answer(_))), "{texts:#?}");
    // It is reset before.
    seen.alarms[0].reset = vec![one];
    let (is_whole, found, texts) = whole(&line, &seen);
    assert_eq!((is_whole, &found.steps[0].action), (false, &RecoveryAction::First(Need::Reset(one))), "{texts:#?}");
    seen.alarms[0].reset.clear();

    let mut moves = seen.clone();
    moves.alarms[0].at_order = vec![other];
    assert!(whole(&line, &moves).0, "a station of its activity still has an order");
    let mut stops = seen.clone();
    stops.is_stopping = true;
    assert!(plan(&line, &stops).steps.iter().all(|step| step.action != RecoveryAction::ManualAlone(one)));
    let mut takes_part = seen.clone();
    takes_part.left_out.clear();
    assert!(whole(&line, &takes_part).0, "it takes part in auto");
    // Its mechanism stands at no switch of where it was stopped, but at those of a rest.
    let mut lost = seen.clone();
    let report = lost.stations[one.index()].as_mut().expect("heard");
    (report.measured, report.position_lost) = (at_home(&line, one), Some((OpId(0), InputId(0))));
    let (is_whole, found, texts) = whole(&line, &lost);
    assert!(place_of(&found.steps, |of| matches!(of, RecoveryAction::Rejoin { .. })).is_some(), "{texts:#?}");
    assert!(is_whole, "its place is to be confirmed, which is not done in manual by itself: {texts:#?}");
}

#[test]
fn an_alarm_in_auto_is_a_step() {
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    // Out of service, at rests.
    for report in seen.stations.iter_mut().flatten() {
        (report.at_home, report.position_lost) = (true, None);
        report.incomplete.clear();
    }
    seen.alarms = vec![alarm(&[], &[])];
    let found = plan(&line, &seen);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert!(
        texts.len() == 1
            && texts[0].ends_with("Then answer what you find at the machine: as-before (not done, part at M1) or gone"),
        "{texts:#?}"
    );
    assert!(found.has_alarms());
}

/// What sensors contradict would not be taken. Where that is so of every answer, something has to be put right first.
#[test]
fn an_answer_that_sensors_contradict_is_no_command() {
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    for report in seen.stations.iter_mut().flatten() {
        (report.at_home, report.position_lost) = (true, None);
        report.incomplete.clear();
    }
    let listed = |seen: &LineSituation| {
        let found = plan(&line, seen);
        let [step] = &found.steps[..] else { panic!("{:#?}", found.steps) };
        (step.text(&line), step.commands(&line))
    };
    let contradicted = |answer: &mut ListedAnswer| {
        let (fit, why) = (AnswerFit::Contradicts, "M1: part expected, sensor off".to_owned());
        answer.remark = Some(AnswerRemark { fit, why });
    };
    seen.alarms = vec![alarm(&[], &[])];
    let (before, commands) = listed(&seen);
    assert_eq!(commands.len(), 2);
    contradicted(&mut seen.alarms[0].answers[0]);
    let (text, commands) = listed(&seen);
    assert!(
        text.contains("contradicts the sensors: M1: part expected") && !text.contains("No answer agrees"),
        "{text}"
    );
    assert_eq!(commands, [["answer", "LINE", &seen.alarms[0].id.to_string(), "gone"]], "{before}");
    contradicted(&mut seen.alarms[0].answers[1]);
    let (text, commands) = listed(&seen);
    assert!(commands.is_empty() && text.contains("No answer agrees with the sensors: see where the part is"), "{text}");
}

/// Its answers say that a station is not received, and what to do where it stays away.
#[test]
fn an_alarm_is_listed_while_a_station_is_away() {
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    let away = seen.left_out[0];
    seen.stations[away.index()] = None;
    let found = plan(&line, &seen);
    let [heard, answer] = &found.steps[..] else { panic!("{:#?}", found.steps) };
    assert_eq!(heard.action, RecoveryAction::First(Need::Heard(away)));
    assert!(matches!(answer.action, RecoveryAction::First(Need::Answer(_))));
    assert_eq!(found.end, RecoveryEnd::LookAgain);
}

#[test]
fn a_station_in_emergency_stop_by_itself_is_reset_before_it_is_led() {
    let (line, mut seen) = two_are_left_out(ControlMode::StandBy);
    let name = line.station(seen.left_out[0]).name.clone();
    seen.alarms = vec![alarm(&seen.left_out, &seen.left_out[..1])];
    let found = plan(&line, &seen);
    let first = &found.steps[0];
    assert_eq!(first.text(&line), format!("{name}: in emergency stop by itself: reset it with `linewright resource`"));
    assert_eq!(first.commands(&line), [["resource", "LINE", &name, "reset"]]);
    assert_eq!(found.end, RecoveryEnd::Auto);
}

/// The others end their tasks, and the line is at home then: hand mode is given after start.
#[test]
fn from_auto_the_start_is_listed_that_leads_from_home_to_hand() {
    let (line, mut seen) = two_are_left_out(ControlMode::Auto);
    let named = |name| line.station_named(name).expect("it is one");
    let (m1, robot) = (named("m1"), named("robot"));
    let at_rest = |id: StationId, last: &str| {
        let station = line.station(id);
        let fresh = Controller::new(&line, id, 7, Restore::Fresh).expect("a shipped station compiles");
        let last = StationPlace::completed(station.operation_named(last).expect("it is one"));
        reported(&line, id, StationSnapshot { placed: true, marking: vec![last], ..fresh.snapshot() }, 0)
    };
    for id in line.station_ids().filter(|id| *id != m1) {
        let home = &line.operation((id, line.station(id).home)).name;
        seen.stations[id.index()] = Some(at_rest(id, home));
    }
    seen.stations[m1.index()] = Some(at_rest(m1, "clamp-close"));
    // The robot works on its order.
    let carry = line.station(robot).operation_named("carry to m2").expect("it is one");
    let working = seen.stations[robot.index()].as_mut().expect("it is heard");
    working.places.fill(0);
    working.places[carry.index()] = StationPlace::operating(carry).number();
    (working.at_home, working.stopped, working.order) = (false, false, None);
    let open = line.station(m1).rest_named("open").expect("it is one");
    seen.left_out = vec![m1];
    seen.alarms = vec![StandingAlarm { bring: Some((m1, open)), ..alarm(&[], &[]) }];
    let found = plan(&line, &seen);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    let commands = commands(&found);
    let way = [ModeCommand::Stop, ModeCommand::Start, ModeCommand::Hand, ModeCommand::Auto];
    assert_eq!(commands, way, "{texts:#?}");
    assert!(place_of(&found.steps, |of| matches!(of, RecoveryAction::Hold { .. })).is_some(), "{texts:#?}");
}

/// It has ended auto before it was left out.
#[test]
fn a_station_that_was_restarted_and_is_left_out_since_is_led_in_manual() {
    let (line, mut seen) = two_are_left_out(ControlMode::StandBy);
    seen.restarted = vec![seen.left_out[0]];
    let found = plan(&line, &seen);
    let texts: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
    assert!(place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Manual)).is_some(), "{texts:#?}");
    assert_eq!(found.end, RecoveryEnd::Auto, "{texts:#?}");
}

/// A station that the line's leaving auto has stopped on its way back goes on in auto, and no answer is taken before.
#[test]
fn an_alarm_whose_station_still_has_an_order_is_answered_in_auto() {
    let (line, mut seen) = two_are_left_out(ControlMode::StandBy);
    let held = std::mem::take(&mut seen.alarms[0].lead);
    seen.alarms[0].at_order = held[..1].to_vec();
    let place = |seen: &LineSituation| {
        let found = plan(&line, seen);
        let auto = place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Auto));
        let answer = place_of(&found.steps, |of| matches!(of, RecoveryAction::First(Need::Answer(_))));
        (auto.expect("auto is given"), answer.expect("it is answered"))
    };
    let (auto, answer) = place(&seen);
    assert!(auto < answer);
    seen.alarms[0].at_order.clear();
    let (auto, answer) = place(&seen);
    assert!(answer < auto);
}

/// In the seconds before its alarm a failed activity is not over, whatever the mode is.
#[test]
fn what_has_failed_and_has_no_alarm_yet_is_waited_for() {
    for mode in [ControlMode::Auto, ControlMode::StandBy] {
        let (line, mut seen) = two_are_left_out(mode);
        seen.alarms.clear();
        assert!(plan(&line, &seen).leads_to_auto());
        seen.unsettled = vec!["`load M1` failed, waits for its stations to come to rest".to_owned()];
        let found = plan(&line, &seen);
        let names: Vec<&str> = seen.left_out.iter().map(|id| line.station(*id).name.as_str()).collect();
        let text = format!("wait: {} (left out: {})", seen.unsettled[0], names.join(" and "));
        // In stand-by nothing comes to rest: auto is given before.
        let at = if mode == ControlMode::Auto { 0 } else { found.steps.len() - 1 };
        assert_eq!(found.steps[at].text(&line), text);
        assert_eq!(place_of(&found.steps, |of| *of == RecoveryAction::Command(ModeCommand::Auto)).is_some(), at > 0);
        assert_eq!((found.end.clone(), found.leads_to_auto()), (RecoveryEnd::LookAgain, false));
        assert_eq!(found.end_text(&line), ["not finished: what follows shows with the alarm of what has failed"]);
    }
}

/// Manual is not given out of hand mode.
#[test]
fn from_hand_mode_a_station_is_led_after_stop() {
    let (line, mut seen) = two_are_left_out(ControlMode::Hand);
    // Between two operations of a task, where hand mode is given all the same.
    let robot = line.station_named("robot").expect("it is one");
    let (station, fresh) =
        (line.station(robot), Controller::new(&line, robot, 7, Restore::Fresh).expect("it compiles"));
    let fetched = StationPlace::completed(station.operation_named("fetch for m2").expect("it is one"));
    let snapshot = StationSnapshot { placed: true, marking: vec![fetched], ..fresh.snapshot() };
    for id in line.station_ids() {
        let home = &line.operation((id, line.station(id).home)).name;
        let done = StationPlace::completed(line.station(id).operation_named(home).expect("it is one"));
        let fresh = Controller::new(&line, id, 7, Restore::Fresh).expect("it compiles");
        let at_home = StationSnapshot { placed: true, marking: vec![done], ..fresh.snapshot() };
        seen.stations[id.index()] = Some(reported(&line, id, at_home, 0));
    }
    seen.stations[robot.index()] = Some(reported(&line, robot, snapshot, 0));
    (seen.left_out, seen.alarms) = (vec![robot], vec![alarm(&[robot], &[])]);
    let found = plan(&line, &seen);
    let commands = commands(&found);
    assert_eq!(commands[..2], [ModeCommand::Stop, ModeCommand::Manual]);
    assert_eq!(found.end, RecoveryEnd::Auto);
}

/// It lost its journal at a rest, at no activity: no alarm asks about it, and nothing begins there. Where it stands is confirmed first;
/// one that is left out otherwise may be in repair.
#[test]
fn a_station_that_lost_its_journal_is_led_though_no_alarm_asks() {
    for mode in [ControlMode::Auto, ControlMode::StandBy] {
        let (line, mut seen) = two_are_left_out(mode);
        seen.alarms.clear();
        let is_led = |seen: &LineSituation| {
            let found = plan(&line, seen);
            let leads = |of: &RecoveryAction| matches!(of, RecoveryAction::Press(station, _) | RecoveryAction::Rejoin { station, .. } if seen.left_out.contains(station));
            let text = found.end_text(&line).join("; ");
            assert_eq!(
                found.end == RecoveryEnd::LookAgain && seen.unsettled.is_empty(),
                text.contains("confirmed"),
                "{text}"
            );
            for step in found.steps.iter().filter(|step| matches!(step.action, RecoveryAction::Rejoin { .. })) {
                // It stands within a task: which slot that was for is confirmed with the place.
                let (text, commands) = (step.text(&line), step.commands(&line));
                let asks = |command: &Vec<String>| command.ends_with(&["--with".to_owned(), "slot=N".to_owned()]);
                assert!(text.contains(", --with slot=N (0 to 7). Its `slot` is lost with its journal"), "{text}");
                assert!(!commands.is_empty() && commands.iter().all(asks), "{commands:?}");
            }
            (found.steps.iter().any(|step| leads(&step.action)), found.end)
        };
        assert_eq!(is_led(&seen), (false, RecoveryEnd::Auto), "out of service");
        let first = seen.left_out[0];
        let mut fresh = Controller::new(&line, first, 9, Restore::Fresh).expect("it compiles");
        let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
        let bits = seen.stations[first.index()].as_ref().expect("heard").measured;
        fresh.handle(now, StationInput::Inputs { bits, valid: true, until, under });
        fresh.step(now, &mut StationOutbox::default());
        seen.stations[first.index()] = Some(fresh.report());
        assert_eq!(is_led(&seen), (true, RecoveryEnd::LookAgain), "what follows is known after the confirmation");
        seen.unsettled = vec!["`load M1` failed".to_owned()];
        assert!(!is_led(&seen).0, "with its activity, later");
    }
}

/// Its switch has failed, and it has its journal: the list asked for the number of its slot, and a guess replaced the right one.
#[test]
fn a_number_that_the_journal_has_is_not_asked_for() {
    let [(_, line), _] = shipped();
    let robot = line.station_named("robot").expect("it is one");
    let station = line.station(robot);
    let op = station.operation_named("grasp for m2").expect("it is one");
    let fresh = Controller::new(&line, robot, 7, Restore::Fresh).expect("it compiles");
    let snapshot = StationSnapshot { placed: true, marking: vec![StationPlace::undone(op)], ..fresh.snapshot() };
    let mut controller = Controller::new(&line, robot, 7, Restore::From(snapshot)).expect("it compiles");
    let at_store = station.inputs.iter().position(|input| input == "at_store").expect("it is one");
    let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
    controller.handle(now, StationInput::Inputs { bits: 1 << at_store, valid: true, until, under });
    controller.step(now, &mut StationOutbox::default());
    let (_, mut seen) = two_are_left_out(ControlMode::StandBy);
    seen.alarms.clear();
    for id in line.station_ids() {
        let mut controller = Controller::new(&line, id, 7, Restore::Fresh).expect("it compiles");
        controller.handle(now, StationInput::Inputs { bits: at_home(&line, id), valid: true, until, under });
        controller.step(now, &mut StationOutbox::default());
        seen.stations[id.index()] = Some(controller.report());
    }
    seen.stations[robot.index()] = Some(controller.report());
    seen.left_out = Vec::new();
    let found = plan(&line, &seen);
    let is_rejoin = |step: &&RecoveryStep| matches!(step.action, RecoveryAction::Rejoin { .. });
    let step = found.steps.iter().find(is_rejoin).unwrap_or_else(|| panic!("{found:?}"));
    let (text, commands) = (step.text(&line), step.commands(&line));
    assert!(commands[0].contains(&"grasp for m2".to_owned()), "where it is marked to stand goes first: {commands:?}");
    assert!(!commands[0].contains(&"--with".to_owned()), "{text}: {commands:?}");
}

/// Of a station without its journal several places fit the switches. Each is listed with the positions of its axes, and the number of the
/// slot is that of its order; positions were missing, and the number was asked for.
#[test]
fn places_that_may_be_confirmed_are_told_apart_and_have_the_numbers_of_their_order() {
    let (line, mut seen) = two_are_left_out(ControlMode::StandBy);
    seen.alarms.clear();
    let id = seen.left_out[0];
    let station = line.station(id);
    let mut fresh = Controller::new(&line, id, 9, Restore::Fresh).expect("it compiles");
    let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
    let bits = seen.stations[id.index()].as_ref().expect("heard").measured;
    fresh.handle(now, StationInput::Inputs { bits, valid: true, until, under });
    fresh.step(now, &mut StationOutbox::default());
    seen.stations[id.index()] = Some(fresh.report());
    let confirm = |seen: &LineSituation| {
        let steps = plan(&line, seen).steps;
        steps.into_iter().find(|step| step.action.choices().next().is_some()).expect("a confirmation")
    };
    let before = confirm(&seen);
    let (stands, commands) = (before.stands(&line), before.commands(&line));
    assert!(commands.len() > 1 && stands.len() == commands.len(), "{commands:?}: {stands:#?}");
    let axes = |text: &String| station.axes.iter().all(|axis| text.contains(&format!("{} ", axis.name)));
    assert!(stands.iter().all(|text| axes(text) && text.contains(" on")), "{stands:#?}");
    let mut apart = stands.clone();
    apart.sort();
    apart.dedup();
    assert_eq!(apart.len(), stands.len(), "{stands:#?}");
    // The coordinator has an order for the task of the choice that was named last.
    let last = before.action.choices().last().expect("several");
    let RejoinAt::Within(op) = last.at else { panic!("{last:?}") };
    let task = station.task_of(op).expect("a task");
    let numbers = station.task(task).parameters.iter().map(|of| (of.name.clone(), 2)).collect();
    seen.interrupted = vec![InterruptedTask { station: id, task, activity: "`load M2` of part 7".to_owned(), numbers }];
    let step = confirm(&seen);
    let first = step.action.choices().next().and_then(|choice| choice.places.first().copied()).expect("a place");
    assert_eq!(station.task_of(first.op), Some(task), "a place of that task goes first");
    let (text, stands, commands) = (step.text(&line), step.stands(&line), step.commands(&line));
    assert!(commands[0].ends_with(&["--with".to_owned(), "slot=2".to_owned()]), "{commands:?}");
    assert!(
        stands.first().is_some_and(|of| of.contains("an order of this task, for `load M2` of part 7")),
        "{stands:#?}"
    );
    assert!(text.contains("`linewright recover` lists the numbers with it") && !text.contains("slot=2"), "{text}");
    // Another activity has ordered the same with another number: which of them it was is not known.
    let mut other = seen.interrupted[0].clone();
    other.numbers.iter_mut().for_each(|(_, number)| *number += 1);
    seen.interrupted.push(other);
    let step = confirm(&seen);
    assert!(step.action.choices().flat_map(|of| &of.numbers).all(|of| of.known.is_none()), "{step:?}");
}
