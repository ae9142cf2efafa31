//! Conversions between the token player's input and output and messages.
//!
//! Times are the player's own: microseconds since 1970, as messages have them in seconds and nanoseconds.

use linewright_cell::Cell;
use linewright_coordinator_cell::exception::{Presence, ResourceRequest, StationUnavailable};
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::{OrderMessage, PlayerState, TaskReport};
use linewright_line::{InputId, Line, RestId, Station, Tick, suggestion};
use linewright_msgs::{
    OrderEnd, OrderState, ProductionRequest, RunTaskGoal, RunTaskResult, SetResourceRequest, StationState, Time,
};
use linewright_orders::{LeaveWay, OrderKey, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};

/// Reason in a station's state why it can do nothing now.
pub fn unable(state: &StationState) -> Option<StationUnavailable> {
    let by_hand = [StationState::MODE_HAND, StationState::MODE_MANUAL].contains(&state.mode);
    if state.lifecycle != StationState::LIFECYCLE_ACTIVE {
        Some(StationUnavailable::Inactive)
    } else if !state.devices_valid {
        Some(StationUnavailable::Devices)
    } else if !state.incomplete.is_empty() {
        Some(StationUnavailable::Incomplete)
    } else if by_hand || state.selector_manual {
        Some(StationUnavailable::ByHand)
    } else {
        None
    }
}

/// The inputs of stations that see the part of their resource.
pub fn sensors(cell: &Cell, line: &Line) -> Vec<Option<InputId>> {
    let mut sensors = vec![None; line.stations.len()];
    for resource in &cell.resources {
        let name = resource.controller.map(|id| cell.controllers[id.index()].as_str());
        if let (Some(id), Some(input)) = (name.and_then(|name| line.station_named(name)), &resource.presence) {
            let inputs = &line.station(id).inputs;
            sensors[id.index()] = inputs.iter().position(|of| of == input).map(InputId::at);
        }
    }
    sensors
}

/// What a sensor says that is this input of its station; it is not read while the station's inputs are not known.
fn presence(message: &OrderState, sensor: Option<InputId>) -> Presence {
    let byte = |input: InputId| Some((message.inputs.as_slice().get(usize::from(input.0) / 8)?, input.0 % 8));
    match sensor.and_then(byte) {
        Some((byte, bit)) if byte & (1 << bit) != 0 => Presence::On,
        Some(_) => Presence::Off,
        None if sensor.is_some() => Presence::Unread,
        None => Presence::NoSensor,
    }
}

/// Of the inputs that operations of a station wait for, those that are off; none while its inputs are not known.
fn off(message: &OrderState, station: &Station) -> u128 {
    let is_off = |input: &InputId| presence(message, Some(*input)) == Presence::Off;
    station.awaited_inputs().filter(is_off).fold(0, |bits, input| bits | input.bit())
}

/// A station's reports on its orders, with why it can do nothing now; and its final refusals. The input is that of the sensor which
/// sees its part. What is wrong with the station is in another message, and not set here.
pub fn heard(
    message: &OrderState,
    station: &Station,
    unable: Option<StationUnavailable>,
    sensor: Option<InputId>,
) -> (TaskReport, Vec<(OrderKey, TaskReply)>) {
    let doing = OrderKey { epoch: message.doing_epoch, id: message.doing_id };
    let heard = TaskReport {
        memory: message.memory,
        epoch: message.epoch,
        slot: (doing.id != 0).then_some(doing),
        results: message.ended.as_slice().iter().map(|end| (key(end), outcome(end))).collect(),
        is_held: doing.id == 0 && message.rest.is_empty(),
        rest: station.rests.iter().position(|rest| rest.name == message.rest).map(RestId::at),
        is_in_handshake: message.in_handshake,
        unable,
        presence: presence(message, sensor),
        off: off(message, station),
        fault: String::new(),
    };
    let refused = message
        .refused
        .as_slice()
        .iter()
        .filter_map(|end| Some((key(end), TaskReply::Refused(TaskRefusal::from_code(end.code)?))));
    (heard, refused.collect())
}

/// A station's reply to the order to leave an order: whether it is still at it.
pub fn secured(message: &OrderState, heard: &TaskReport) -> Option<(OrderKey, LeaveWay, TaskReply)> {
    let key = OrderKey { epoch: message.secured_epoch, id: message.secured_id };
    (key.id != 0).then(|| (key, LeaveWay::from_number(message.secured_way), heard.secured(key)))
}

fn key(end: &OrderEnd) -> OrderKey {
    OrderKey { epoch: end.epoch, id: end.id }
}

fn outcome(end: &OrderEnd) -> TaskOutcome {
    if end.end == RunTaskResult::END_DONE {
        TaskOutcome::Done
    } else {
        TaskOutcome::Failed(TaskFailure::from_code(end.code))
    }
}

/// An order, as its station's action takes it.
pub fn goal(message: &OrderMessage) -> RunTaskGoal {
    let OrderMessage { part, order, .. } = message;
    RunTaskGoal {
        memory: order.memory,
        epoch: order.key.epoch,
        id: order.key.id,
        task: order.task.to_string(),
        parameter_names: order.parameters.iter().map(|(name, _)| name.to_string()).collect(),
        parameters: order.parameters.iter().map(|(_, value)| *value).collect(),
        part: part.map(|part| part.to_string()).unwrap_or_default(),
        limit_ms: u32::try_from(order.limit.as_millis()).unwrap_or(u32::MAX),
    }
}

/// A request, under this key if it has none of its own. The production orders check the rest of it.
///
/// # Errors
/// Error in its key.
pub fn request(message: &ProductionRequest, drawn: u128) -> Result<ProductionOrderRequest, String> {
    let key = match message.key.as_slice() {
        [] => drawn,
        bytes => {
            let wrong = |_| format!("`{}` has a key of {} bytes; give 16, or none", message.name, bytes.len());
            u128::from_be_bytes(bytes.try_into().map_err(wrong)?)
        }
    };
    Ok(ProductionOrderRequest {
        key,
        name: message.name.clone(),
        product: message.product.clone(),
        quantity: message.quantity,
        release: moment(&message.release),
        due: moment(&message.due),
        priority: message.priority,
        after: message.after.clone(),
    })
}

/// An operator's request about a resource; a station is reset by its own name as well.
///
/// # Errors
/// There is no such resource, or no such request.
pub fn said(state: &PlayerState, resource: &str, what: u8) -> Result<ResourceRequest, String> {
    let handling = state.table().handling();
    if what == SetResourceRequest::RESET {
        let own = handling.resource_named(resource).map(|id| handling.resource(id).and_then(|of| of.station));
        let named = || handling.stations.iter().find(|(_, name)| **name == *resource).map(|(id, _)| *id);
        match own.or_else(|| Some(Some(named()?))) {
            Some(Some(station)) => return Ok(ResourceRequest::Reset(station)),
            Some(None) => return Err(format!("`{resource}` has no station")),
            None => (),
        }
    }
    let id = handling.resource_or_station_named(resource).map_err(|several| {
        if !several.is_empty() {
            let names: Vec<&str> = several.iter().map(|&id| handling.resource_name(id)).collect();
            return format!("station `{resource}` has several resources; name one of them: {}", names.join(", "));
        }
        let names = || handling.resources.iter().map(|resource| resource.name.as_ref());
        let all = || format!("resources: {}", names().collect::<Vec<_>>().join(", "));
        // One of the two lists names where they are few.
        format!("no resource `{resource}`; {}", suggestion(resource, names()).unwrap_or_else(all))
    })?;
    match what {
        SetResourceRequest::ALARM => Ok(ResourceRequest::Alarm(id)),
        SetResourceRequest::DOWN => Ok(ResourceRequest::Down(id)),
        SetResourceRequest::UP => Ok(ResourceRequest::Up(id)),
        other => Err(format!("{other}: not a command of SetResource.srv")),
    }
}

/// Time of a message; none if it is 0, or before 1970.
pub fn moment(time: &Time) -> Option<Tick> {
    let micros = u64::try_from(time.sec).ok()? * 1_000_000 + u64::from(time.nanosec / 1000);
    (micros > 0).then_some(Tick::from_micros(micros))
}

/// Time as in messages. Their seconds end in 2038.
pub fn time(tick: Tick) -> Time {
    let (sec, micros) = (tick.as_micros() / 1_000_000, tick.as_micros() % 1_000_000);
    // 1 µs is 1000 ns, and there are fewer than a million of them.
    Time { sec: i32::try_from(sec).unwrap_or(i32::MAX), nanosec: u32::try_from(micros * 1000).unwrap_or(0) }
}
