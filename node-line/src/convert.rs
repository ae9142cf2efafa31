//! Between the controller's report and the message that carries it.
//!
//! The two are kept apart on purpose: the wire format can grow without touching the core. A message that does not
//! fit the description is an error with the field that does not, never a guess.

use std::time::Duration;

use linewright_line::net::{Block, ControlMode};
use linewright_line::{InputId, Line, OpId, StationId};
use linewright_msgs::{Answer as AnswerMessage, ModeOrder, StationEvent, StationState};
use linewright_station_logic::{
    AgreementAnswer, AgreementRequest, Controller, HappeningKind, ModeOrder as Order, StationHappening, StationReport,
    StopCause,
};
use thiserror::Error;

use crate::foreign::quoted;

/// Why a message does not fit the description.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ConvertError {
    #[error("station '{}' is not in the description", quoted(.0))]
    Station(String),
    /// The node was started with another description: its numbers have other meanings.
    #[error("{station} runs with another description ({is:016x}) than this node ({expected:016x})")]
    Description { station: String, is: u64, expected: u64 },
    /// A list has another length than the station has operations.
    #[error("{field} has {has} entries; {station} has {needs} operations")]
    Length { field: &'static str, station: String, has: usize, needs: usize },
    /// A stopped operation without its cause, or the reverse.
    #[error("stop_causes has {has} entries; {station} reports {needs} stopped operations")]
    Causes { station: String, has: usize, needs: usize },
    #[error("{field} names operation {index}; {station} has {needs}")]
    Operation { field: &'static str, station: String, index: u16, needs: usize },
    #[error("mode {0} is not known")]
    Mode(u8),
    #[error("the cause {0} of a stop is not known")]
    Cause(u8),
}

/// The number of a mode on the wire (1 to 3 as in seed 002 §5.4).
pub const fn mode_to_code(mode: ControlMode) -> u8 {
    match mode {
        ControlMode::Home => StationState::MODE_HOME,
        ControlMode::StandBy => StationState::MODE_STANDBY,
        ControlMode::Auto => StationState::MODE_AUTO,
        ControlMode::Hand => StationState::MODE_HAND,
        ControlMode::Manual => StationState::MODE_MANUAL,
        ControlMode::EStop => StationState::MODE_ESTOP,
    }
}

/// The mode with this number on the wire.
///
/// # Errors
/// When the number is not one of the six.
pub fn mode_from_code(code: u8) -> Result<ControlMode, ConvertError> {
    ControlMode::ALL.into_iter().find(|mode| mode_to_code(*mode) == code).ok_or(ConvertError::Mode(code))
}

/// The number of the cause of a stop on the wire. Stations and switches that take part are in the text of the fault.
pub const fn cause_to_code(cause: StopCause) -> u8 {
    match cause {
        StopCause::Signal => StationState::CAUSE_SIGNAL,
        StopCause::Watchdog => StationState::CAUSE_WATCHDOG,
        StopCause::SwitchStuck => StationState::CAUSE_SWITCH_STUCK,
        StopCause::BothSwitchesOn { .. } => StationState::CAUSE_BOTH_SWITCHES_ON,
        StopCause::Devices => StationState::CAUSE_DEVICES,
        StopCause::Released => StationState::CAUSE_RELEASED,
        StopCause::EStop => StationState::CAUSE_ESTOP,
        StopCause::Ordered => StationState::CAUSE_ORDERED,
        StopCause::Restart => StationState::CAUSE_RESTART,
        StopCause::NotAtHome => StationState::CAUSE_NOT_AT_HOME,
        StopCause::Interlock { .. } => StationState::CAUSE_INTERLOCK,
        StopCause::PositionLost { .. } => StationState::CAUSE_POSITION_LOST,
        StopCause::IndexDoubtful { .. } => StationState::CAUSE_INDEX_DOUBTFUL,
        StopCause::Ambiguous => StationState::CAUSE_AMBIGUOUS,
    }
}

/// The cause with this number on the wire, of an operation of this station.
///
/// # Errors
/// When the number is none of a cause.
pub fn cause_from_code(code: u8, (station, op): (StationId, OpId)) -> Result<StopCause, ConvertError> {
    // Which switch it was is not in the message; here it matters only that one was.
    let input = InputId(0);
    let all = [
        StopCause::Signal,
        StopCause::Watchdog,
        StopCause::SwitchStuck,
        StopCause::BothSwitchesOn { behind: input },
        StopCause::Devices,
        StopCause::Released,
        StopCause::EStop,
        StopCause::Ordered,
        StopCause::Restart,
        StopCause::NotAtHome,
        StopCause::Interlock { station, input: None, is_on: false },
        StopCause::PositionLost { op, input },
        StopCause::IndexDoubtful { op, input, places: None },
        StopCause::Ambiguous,
    ];
    all.into_iter().find(|cause| cause_to_code(*cause) == code).ok_or(ConvertError::Cause(code))
}

/// Writes the controller's state into a message, all but header, boot id, sequence and description.
pub fn report_to_message(line: &Line, controller: &Controller, now: linewright_line::Tick, message: &mut StationState) {
    let report = controller.report();
    let station = controller.station();
    let described = line.station(station);
    message.station.clone_from(&described.name);
    message.mode_epoch = report.mode_epoch;
    message.coordinator_boot_id = controller.followed();
    message.mode = report.mode.map_or(StationState::MODE_STANDBY, mode_to_code);
    message.generation = report.generation;
    message.set_measured(report.measured);
    // A slow record may lie between the step and this.
    let age = report.measured_age + now.since(controller.stepped());
    message.measured_age_ms = u32::try_from(age.as_micros().div_ceil(1000)).unwrap_or(u32::MAX);
    message.position_lost = report.position_lost.is_some();
    message.placed = report.placed;
    message.place = report.place;
    message.cycle = report.cycle;
    message.done = report.done;
    message.started = report.started;
    message.places = report.places;
    message.recovering_home = report.recovering_home;
    message.at_home = report.at_home;
    message.round = report.round;
    message.stopped = report.stopped;
    message.selector_manual = report.selector_manual;
    message.devices_valid = report.devices_valid;
    message.incomplete = report.incomplete.iter().map(|(op, _)| op.0).collect();
    message.stop_causes = report.incomplete.iter().map(|&(_, cause)| cause_to_code(cause)).collect();
    message.operation = controller.operation_text(line);
    message.fault = controller.fault_text(line);
    message.blocked_by = controller.blocked_by(line, now);
    message.request_number = report.request.map_or(0, |request| request.number);
    message.request_operations = report.request.map_or(Vec::new(), |request| operations_of(request.ops));
    message.answers = report.answers.iter().map(|answer| answer_to_message(line, station, answer)).collect();
}

fn operations_of(ops: u64) -> Vec<u16> {
    (0..64).filter(|op| ops & (1 << op) != 0).collect()
}

fn answer_to_message(line: &Line, own: StationId, answer: &AgreementAnswer) -> AnswerMessage {
    AnswerMessage {
        station: line.station(answer.to).name.clone(),
        boot_id: answer.boot_id,
        request_number: answer.number,
        agreed: answer.in_the_way.is_none(),
        in_the_way: answer.in_the_way.map(|op| line.operation((own, op)).name.clone()).unwrap_or_default(),
    }
}

/// Whether a message of `node` has this fingerprint of the description.
///
/// # Errors
/// When it has another one: bits and numbers mean something else there.
pub fn of_this_description(node: &str, is: u64, expected: u64) -> Result<(), ConvertError> {
    let differs = || ConvertError::Description { station: node.to_owned(), is, expected };
    (is == expected).then_some(()).ok_or_else(differs)
}

/// Converts one station's message into the form of the controller and the coordinator, whose line has the fingerprint
/// `expected`.
///
/// # Errors
/// When the message does not fit the description, or is from a node with another one. The station then counts as not received:
/// nothing relies on its counts and positions, and no order names its start.
pub fn report_from_message(
    (line, expected): (&Line, u64),
    message: &StationState,
) -> Result<(StationId, StationReport), ConvertError> {
    let station = line.station_named(&message.station).ok_or_else(|| ConvertError::Station(message.station.clone()))?;
    let described = line.station(station);
    of_this_description(&described.name, message.description, expected)?;
    let needs = described.operations.len();
    for (field, has) in
        [("done", message.done.len()), ("started", message.started.len()), ("places", message.places.len())]
    {
        if has != needs {
            return Err(ConvertError::Length { field, station: described.name.clone(), has, needs });
        }
    }
    let operation = |field: &'static str, index: u16| {
        let error = || ConvertError::Operation { field, station: described.name.clone(), index, needs };
        if usize::from(index) < needs { Ok(OpId(index)) } else { Err(error()) }
    };
    let mut ops = 0u64;
    for &index in &message.request_operations {
        ops |= 1 << operation("request_operations", index)?.0;
    }
    let mut incomplete = Vec::with_capacity(message.incomplete.len());
    let (has, needs_causes) = (message.stop_causes.len(), message.incomplete.len());
    if has != needs_causes {
        return Err(ConvertError::Causes { station: described.name.clone(), has, needs: needs_causes });
    }
    for (&index, &code) in message.incomplete.iter().zip(&message.stop_causes) {
        let op = operation("incomplete", index)?;
        incomplete.push((op, cause_from_code(code, (station, op))?));
    }
    let answers = message.answers.iter().filter_map(|a| answer_from_message(line, station, a)).collect();
    let report = StationReport {
        boot_id: message.boot_id,
        mode_epoch: message.mode_epoch,
        mode: Some(mode_from_code(message.mode)?),
        generation: message.generation,
        measured: message.measured_word(),
        measured_age: Duration::from_millis(message.measured_age_ms.into()),
        // Which of its switches is off is in its own fault text; here it matters only that one is.
        position_lost: message.position_lost.then_some((OpId(0), InputId(0))),
        placed: message.placed,
        place: message.place,
        cycle: message.cycle,
        done: message.done.clone(),
        started: message.started.clone(),
        places: message.places.clone(),
        recovering_home: message.recovering_home,
        at_home: message.at_home,
        round: message.round,
        stopped: message.stopped,
        selector_manual: message.selector_manual,
        devices_valid: message.devices_valid,
        incomplete,
        request: (message.request_number != 0).then_some(AgreementRequest { number: message.request_number, ops }),
        answers,
        // The state of its task order is not in this message.
        order: None,
    };
    Ok((station, report))
}

/// An answer about a station or an operation that is not described counts as none: it can only delay.
fn answer_from_message(line: &Line, from: StationId, message: &AnswerMessage) -> Option<AgreementAnswer> {
    let in_the_way = if message.agreed { None } else { Some(line.station(from).operation_named(&message.in_the_way)?) };
    Some(AgreementAnswer {
        to: line.station_named(&message.station)?,
        boot_id: message.boot_id,
        number: message.request_number,
        in_the_way,
    })
}

/// Kind of an event in a message, and its operation.
pub fn kind_of(event: &StationHappening) -> (u8, Option<OpId>) {
    match event.what {
        HappeningKind::Started(op, Block::Normal) => (StationEvent::KIND_STARTED, Some(op)),
        HappeningKind::Started(op, Block::Recovery) => (StationEvent::KIND_UNDO_STARTED, Some(op)),
        HappeningKind::Completed(op, Block::Normal) => (StationEvent::KIND_COMPLETED, Some(op)),
        HappeningKind::Completed(op, Block::Recovery) => (StationEvent::KIND_UNDONE, Some(op)),
        HappeningKind::Stopped(op, _, cause) if cause.is_fault() => (StationEvent::KIND_FAULT, Some(op)),
        HappeningKind::Stopped(op, _, _) => (StationEvent::KIND_STOPPED, Some(op)),
        HappeningKind::Withdrawn(_) | HappeningKind::HomeAgain | HappeningKind::Asked(_) => {
            (StationEvent::KIND_WITHDRAWN, None)
        }
        HappeningKind::NotAgreed { .. } | HappeningKind::Refused => (StationEvent::KIND_REFUSED, None),
        HappeningKind::Founded | HappeningKind::Rejoined | HappeningKind::PositionFound => {
            (StationEvent::KIND_COMPLETED, None)
        }
        HappeningKind::PositionLost(op, _) | HappeningKind::IndexDoubtful(op, ..) => {
            (StationEvent::KIND_FAULT, Some(op))
        }
        HappeningKind::Mode(_) => (StationEvent::KIND_MODE, None),
        HappeningKind::Devices(_) => (StationEvent::KIND_DEVICES, None),
        HappeningKind::Ordered(_) | HappeningKind::Securing(_) => (StationEvent::KIND_STARTED, None),
        HappeningKind::OrderDone(_) => (StationEvent::KIND_COMPLETED, None),
        HappeningKind::OrderFailed(..) | HappeningKind::OrderLeft(..) => (StationEvent::KIND_STOPPED, None),
        HappeningKind::OrderRefused(_) => (StationEvent::KIND_REFUSED, None),
    }
}

/// The coordinator's order, as it is for a station of this name.
///
/// # Errors
/// When its mode is none.
pub fn order_from_message(message: &ModeOrder, (own, name): (StationId, &str)) -> Result<Order, ConvertError> {
    let named = |all: &[String]| all.iter().any(|of| of == name);
    let (is_stopped, is_led, stands_by) =
        (named(&message.stopped), named(&message.manual), named(&message.standing_by));
    // The others' mode is known to the receiver as well: an order that contradicts itself starts nothing.
    let mode = match mode_from_code(message.mode)? {
        _ if is_stopped => ControlMode::EStop,
        ControlMode::Auto if stands_by => ControlMode::StandBy,
        ControlMode::Auto if is_led => ControlMode::Manual,
        mode => mode,
    };
    let single = is_led || stands_by;
    Ok(Order {
        boot_id: message.boot_id,
        epoch: message.epoch,
        mode,
        enabled: message.enabled,
        master_stop: message.master_stop.then_some(message.stop_round),
        manual_all: message.manual_all || (is_led && mode == ControlMode::Manual),
        buttons: message.buttons,
        resume: message.resume,
        lease: Duration::from_millis(message.lease_ms.into()),
        found: (message.found_generation != 0).then_some(message.found_generation),
        station_life: message.lives.get(own.index()).copied().unwrap_or(0),
        single,
    })
}
