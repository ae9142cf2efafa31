//! All texts of the mode decision in one list. A new reason without a text, or without a place in the list, does not
//! compile.

use linewright_coordinator_logic::{
    ApartCause, EStopButton, EStopCause, ModeCommand, ModeRefusal, ModeText, OperatorCommand, RefusedCommand,
};
use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{Owner, StationId};
use linewright_testkit::built::transfer_line;
use linewright_testkit::samples::{listed, samples};

fn reasons() -> Vec<ModeRefusal> {
    let station = StationId(1);
    samples!(ModeRefusal {
        ModeRefusal::BetweenRests(_) => ModeRefusal::BetweenRests(StationId(1));
        ModeRefusal::WrongMode { .. } => ModeRefusal::WrongMode {
            takes: vec![ModeCommand::Start, ModeCommand::Manual],
            way: vec![ModeCommand::Start, ModeCommand::Auto],
        };
        ModeRefusal::NothingToReset => ModeRefusal::NothingToReset;
        ModeRefusal::Already => ModeRefusal::Already;
        ModeRefusal::Stopping => ModeRefusal::Stopping;
        ModeRefusal::EStop => ModeRefusal::EStop;
        ModeRefusal::EStopPressed => ModeRefusal::EStopPressed;
        ModeRefusal::ConsoleLost => ModeRefusal::ConsoleLost;
        ModeRefusal::JournalLost => ModeRefusal::JournalLost;
        ModeRefusal::OtherCoordinator(_) => ModeRefusal::OtherCoordinator(23);
        ModeRefusal::ConsoleNeverHeard => ModeRefusal::ConsoleNeverHeard;
        ModeRefusal::NotHeard(_) => ModeRefusal::NotHeard(station);
        ModeRefusal::Inactive(..) => ModeRefusal::Inactive(station, LifecycleState::Inactive),
            ModeRefusal::Inactive(station, LifecycleState::Finalized);
        ModeRefusal::CoordinatorInactive(_) => ModeRefusal::CoordinatorInactive(LifecycleState::Unconfigured);
        ModeRefusal::DevicesLost(_) => ModeRefusal::DevicesLost(station);
        ModeRefusal::DevicesAwaited(_) => ModeRefusal::DevicesAwaited(station);
        ModeRefusal::Incomplete(..) => ModeRefusal::Incomplete(station, None);
        ModeRefusal::PositionLost(_) => ModeRefusal::PositionLost(station);
        ModeRefusal::NoCommonStart(..) => ModeRefusal::NoCommonStart(station, ApartCause::NoMemory),
            ModeRefusal::NoCommonStart(station, ApartCause::OtherStart);
        ModeRefusal::NotFounded(..) => ModeRefusal::NotFounded(station, ApartCause::NoMemory);
        ModeRefusal::Restarted(_) => ModeRefusal::Restarted(station);
        ModeRefusal::SelectorManual(_) => ModeRefusal::SelectorManual(station);
        ModeRefusal::Moving(_) => ModeRefusal::Moving(station);
        ModeRefusal::Unaware(_) => ModeRefusal::Unaware(station);
        ModeRefusal::NotAtHome(_) => ModeRefusal::NotAtHome(station);
        ModeRefusal::NotInAuto(_) => ModeRefusal::NotInAuto(station);
        ModeRefusal::NotSingle(_) => ModeRefusal::NotSingle(station);
        ModeRefusal::NoSingleManual(_) => ModeRefusal::NoSingleManual(station);
        ModeRefusal::InService(_) => ModeRefusal::InService(station);
        ModeRefusal::Securing(_) => ModeRefusal::Securing(station);
        ModeRefusal::Unattended(_) => ModeRefusal::Unattended(station);
        ModeRefusal::OutsideTask(_) => ModeRefusal::OutsideTask(station);
        ModeRefusal::Turns(_) => ModeRefusal::Turns(station);
        ModeRefusal::SelectorUnclear(_) => ModeRefusal::SelectorUnclear(station);
        ModeRefusal::ManualUnaware(_) => ModeRefusal::ManualUnaware(station);
        ModeRefusal::CellUnaware(_) => ModeRefusal::CellUnaware(station);
        ModeRefusal::StoppedByCell(_) => ModeRefusal::StoppedByCell(station);
        ModeRefusal::Behind(_) => ModeRefusal::Behind(station);
        ModeRefusal::NotManual => ModeRefusal::NotManual;
        ModeRefusal::ManualBySelectors => ModeRefusal::ManualBySelectors;
        ModeRefusal::TwoConsoles => ModeRefusal::TwoConsoles;
        ModeRefusal::Unreleased => ModeRefusal::Unreleased;
        ModeRefusal::GivenUp(_) => ModeRefusal::GivenUp(std::time::Duration::from_secs(30));
    })
}

fn causes() -> Vec<EStopCause> {
    samples!(EStopCause {
        EStopCause::Pressed(_) => EStopCause::Pressed(linewright_line::InputId(0));
        EStopCause::ConsoleLost => EStopCause::ConsoleLost;
        EStopCause::Commanded => EStopCause::Commanded;
        EStopCause::JournalLost => EStopCause::JournalLost;
        EStopCause::Station(_) => EStopCause::Station(StationId(1));
        EStopCause::Restarted => EStopCause::Restarted;
    })
}

#[test]
fn all_texts_of_the_mode_decision() {
    let line = transfer_line();
    let refusal = RefusedCommand {
        command: OperatorCommand::Mode(ModeCommand::Auto),
        mode: ControlMode::StandBy,
        reasons: vec![ModeRefusal::Moving(StationId(0)), ModeRefusal::EStopPressed],
    };
    let resume = RefusedCommand {
        command: OperatorCommand::Resume,
        mode: ControlMode::Auto,
        reasons: vec![ModeRefusal::NotManual],
    };
    let buttons = RefusedCommand {
        command: OperatorCommand::Buttons,
        mode: ControlMode::Hand,
        reasons: vec![ModeRefusal::TwoConsoles],
    };
    let single = RefusedCommand {
        command: OperatorCommand::Single(StationId(1), true),
        mode: ControlMode::Auto,
        reasons: vec![ModeRefusal::InService(StationId(1))],
    };
    let reason = ModeRefusal::Securing(StationId(1)).text(&line);
    let modes = [
        ModeText { stopping: true, ..ModeText::default() },
        ModeText { found_away: true, ..ModeText::default() },
        ModeText { waiting: vec!["clamp_1", "mill_1"], ..ModeText::default() },
        ModeText { manual: vec![("m1", vec![]), ("m2", vec![reason.clone()])], ..ModeText::default() },
        ModeText { selectors: vec![("m1", vec![reason])], ..ModeText::default() },
        ModeText { without: vec!["m1"], stopped: vec!["m2", "m3"], ..ModeText::default() },
        ModeText {
            ended: Some((ControlMode::Auto, vec!["clamp_1: I/O devices lost".to_owned()])),
            ..ModeText::default()
        },
        ModeText { troubles: vec![ModeRefusal::NotHeard(StationId(1)).text(&line)], ..ModeText::default() },
    ];
    let causes = causes();
    let texts = causes.iter().map(|cause| Some(cause.text(&line)));
    let mut stops: Vec<ModeText<'_>> = texts.map(|stop| ModeText { stop, ..ModeText::default() }).collect();
    stops[0].stopped_at = "2026-11-23 20:06:29 UTC";
    let pressed = stops[0].clone();
    stops.push(ModeText { button: EStopButton::Pressed, ..pressed.clone() });
    stops.push(ModeText { button: EStopButton::Released, ..pressed });
    stops.push(ModeText::default());
    let lists = [
        listed("why a command is refused", &reasons(), |reason| reason.text(&line)),
        listed("a refusal", &[refusal, buttons, resume, single], |refusal| refusal.text(&line)),
        listed("the mode", &modes, |mode| mode.text(ControlMode::Auto)),
        listed("the emergency stop", &stops, |mode| mode.text(ControlMode::EStop)),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}

#[test]
fn a_loss_is_refused_with_the_device_and_its_trouble_where_it_is_known() {
    let line = transfer_line();
    let reasons =
        vec![ModeRefusal::DevicesLost(StationId(1)), ModeRefusal::ConsoleLost, ModeRefusal::Moving(StationId(0))];
    let refusal =
        RefusedCommand { command: OperatorCommand::Mode(ModeCommand::Auto), mode: ControlMode::StandBy, reasons };
    let known = |owner| match owner {
        Owner::Station(_) => "clamp 1 io (node 21h): no heartbeat (1017h) for 230 ms".to_owned(),
        Owner::Console => String::new(),
    };
    let expected = "auto refused in stand-by: clamp_1: I/O devices lost: clamp 1 io (node 21h): no heartbeat \
                    (1017h) for 230 ms; console: I/O devices not operational; transfer: motion in progress";
    assert_eq!(refusal.text_with(&line, known), expected);
}

/// A station that was restarted is looked at in manual, where its reasons lead there; *start* is enough where all stand at home.
#[test]
fn a_restart_is_named_where_start_leads_on() {
    let line = transfer_line();
    let restarted =
        [ModeRefusal::NoCommonStart(StationId(1), ApartCause::NoMemory), ModeRefusal::Restarted(StationId(1))];
    let names_it = |reasons: &[ModeRefusal]| {
        let (command, mode) = (OperatorCommand::Mode(ModeCommand::Auto), ControlMode::StandBy);
        let text = RefusedCommand { command, mode, reasons: reasons.to_vec() }.text(&line);
        text.contains("clamp_1: restarted; give start")
    };
    assert!(names_it(&restarted));
    let [apart, again] = restarted;
    assert!(!names_it(&[apart, again, ModeRefusal::NotAtHome(StationId(2))]));
}

#[test]
fn what_several_stations_lack_is_said_once_and_the_one_away_is_named() {
    let line = transfer_line();
    let apart = line.station_ids().map(|id| ModeRefusal::NoCommonStart(id, ApartCause::NoMemory));
    let reasons = apart.chain([ModeRefusal::NotAtHome(StationId(1))]).collect();
    let refusal =
        RefusedCommand { command: OperatorCommand::Mode(ModeCommand::Auto), mode: ControlMode::StandBy, reasons };
    let text = refusal.text(&line);
    assert_eq!(text.matches("lead all stations home").count(), 1, "{text}");
    assert!(text.starts_with("auto refused in stand-by: clamp_1: not at home; transfer, clamp_1, "), "{text}");
}
