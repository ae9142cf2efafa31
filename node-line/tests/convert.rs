//! Messages to what controllers take, and back.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId, Tick, TransferLine, parse};
use linewright_msgs::{ModeOrder, StationState};
use linewright_node_line::{
    ConvertError, cause_from_code, cause_to_code, mode_to_code, order_from_message, report_from_message,
    report_to_message,
};
use linewright_station_logic::{Controller, Restore, StationInput, StationOutbox};

#[test]
fn a_station_that_is_named_is_in_emergency_stop() {
    let mode = mode_to_code(ControlMode::Auto);
    let message = ModeOrder { boot_id: 1, epoch: 2, mode, stopped: vec!["robot".into()], ..ModeOrder::default() };
    let order = |name| order_from_message(&message, (StationId(0), name)).map(|order| (order.epoch, order.mode));
    assert_eq!(order("robot"), Ok((2, ControlMode::EStop)));
    assert_eq!(order("robo"), Ok((2, ControlMode::Auto)));
    let unknown = ModeOrder { mode: 200, ..message.clone() };
    assert_eq!(order_from_message(&unknown, (StationId(0), "robot")), Err(ConvertError::Mode(200)));
}

#[test]
fn every_cause_of_a_stop_is_sent_and_received() {
    let of = (StationId(0), OpId(1));
    for code in StationState::CAUSE_SIGNAL..=StationState::CAUSE_AMBIGUOUS {
        assert_eq!(cause_from_code(code, of).map(cause_to_code), Ok(code));
    }
    assert_eq!(cause_from_code(0, of), Err(ConvertError::Cause(0)));
    assert_eq!(cause_from_code(200, of), Err(ConvertError::Cause(200)));
}

#[test]
fn a_station_that_is_named_is_in_manual_while_the_others_are_in_auto() {
    let mode = mode_to_code(ControlMode::Auto);
    let manual = vec!["robot".into()];
    let message = ModeOrder { boot_id: 1, epoch: 2, mode, enabled: true, manual, ..ModeOrder::default() };
    let order = |message: &ModeOrder, name| {
        let order = order_from_message(message, (StationId(0), name)).expect("a mode");
        (order.mode, order.manual_all, order.single)
    };
    assert_eq!(order(&message, "robot"), (ControlMode::Manual, true, true));
    assert_eq!(order(&message, "robo"), (ControlMode::Auto, false, false));
    let waits = ModeOrder { standing_by: vec!["robot".into()], ..message.clone() };
    assert_eq!(order(&waits, "robot"), (ControlMode::StandBy, false, true));
    let stopped = ModeOrder { stopped: vec!["robot".into()], ..message.clone() };
    assert_eq!(order(&stopped, "robot").0, ControlMode::EStop);
    // In any other mode it is in that.
    let estop = ModeOrder { mode: mode_to_code(ControlMode::EStop), ..message.clone() };
    assert_eq!(order(&estop, "robot").0, ControlMode::EStop);
    let stands_by = ModeOrder { mode: mode_to_code(ControlMode::StandBy), ..message };
    assert_eq!(order(&stands_by, "robot"), (ControlMode::StandBy, false, true));
}

/// As many operations of the same names, and another condition: its counts mean something else.
#[test]
fn the_state_of_a_station_with_another_description_is_not_taken() {
    let text = TransferLine::default().text();
    let line = |text: &str| parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let (own, other) = (line(&text), line(&text.replacen("lag = 1", "lag = 2", 1)));
    let controller = Controller::new(&own, StationId(0), 7, Restore::Fresh).expect("it compiles");
    let mut message = StationState { description: own.fingerprint(), boot_id: 7, ..StationState::default() };
    report_to_message(&own, &controller, Tick::from_millis(1000), &mut message);
    let taken = |line: &Line| report_from_message((line, line.fingerprint()), &message).map(|(station, _)| station);
    assert_eq!(taken(&own), Ok(StationId(0)));
    let (is, expected) = (own.fingerprint(), other.fingerprint());
    assert_eq!(taken(&other), Err(ConvertError::Description { station: own.stations[0].name.clone(), is, expected }));
}

#[test]
fn the_age_of_an_image_counts_the_time_since_the_step() {
    let line = parse("line.toml", include_str!("../../model/line/tests/descriptions/cell.toml"));
    let line = line.unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let mut controller = Controller::new(&line, StationId(0), 7, Restore::Fresh).expect("it compiles");
    let (now, mut message) = (Tick::from_millis(1000), StationState::default());
    let (until, under) = (now + line.timing.stale, 0);
    controller.handle(now, StationInput::Inputs { bits: 0, valid: true, until, under });
    controller.step(now, &mut StationOutbox::default());
    for waited in [0, 400] {
        report_to_message(&line, &controller, now + Duration::from_millis(waited), &mut message);
        assert_eq!(u64::from(message.measured_age_ms), waited);
    }
}
