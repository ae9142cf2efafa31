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
use linewright_orders::{OrderKey, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};

/// Reason in a station's state why it can do nothing now.
pub fn unable(state: &StationState) -> Option<StationUnavailable> {
    let by_hand = [StationState::MODE_HAND, StationState::MODE_MANUAL].contains(&state.mode);
    if !state.devices_valid {
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

/// A station's reports on its orders, with its other state; and its final refusals. The input is that of the sensor which
/// sees its part.
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
        unable,
        presence: presence(message, sensor),
    };
    let refused = message
        .refused
        .as_slice()
        .iter()
        .filter_map(|end| Some((key(end), TaskReply::Refused(TaskRefusal::from_code(end.code)?))));
    (heard, refused.collect())
}

/// A station's reply to the order to leave an order: whether it is still at it.
pub fn secured(message: &OrderState, heard: &TaskReport) -> Option<(OrderKey, TaskReply)> {
    let key = OrderKey { epoch: message.secured_epoch, id: message.secured_id };
    (key.id != 0).then(|| (key, heard.secured(key)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_msgs::{Bounded, RosMessage};

    fn station() -> Station {
        let text = linewright_line::TransferLine { machines: 1, time_scale: 1.0 }.text();
        linewright_line::parse("line.toml", &text).expect("it is sound").line.stations.remove(0)
    }

    /// Without an image a sensor says nothing, which is not the same as no sensor.
    #[test]
    fn a_sensor_without_an_image_is_unread() {
        let presence = |inputs: &[u8], sensor| {
            let inputs = Bounded::new(inputs.to_vec()).expect("a few");
            heard(&OrderState { inputs, ..OrderState::default() }, &station(), None, sensor).0.presence
        };
        let sensor = Some(InputId(1));
        assert_eq!([presence(&[2], sensor), presence(&[1], sensor)], [Presence::On, Presence::Off]);
        assert_eq!([presence(&[], sensor), presence(&[], None)], [Presence::Unread, Presence::NoSensor]);
    }

    #[test]
    fn what_a_station_says_is_heard() {
        let end = |id, end, code| OrderEnd { epoch: 2, id, end, code };
        let mut message = OrderState {
            boot_id: 1,
            station: "m1".into(),
            memory: 9,
            epoch: 2,
            doing_epoch: 2,
            doing_id: 5,
            phase: 1,
            ended: Bounded::new(vec![end(3, RunTaskResult::END_DONE, 0), end(4, RunTaskResult::END_SECURED, 1004)])
                .expect("two"),
            refused: Bounded::new(vec![end(1, RunTaskResult::END_REFUSED, 6), end(2, RunTaskResult::END_REFUSED, 999)])
                .expect("two"),
            ..OrderState::default()
        };
        message.validate().expect("it is valid");
        let key = |id| OrderKey { epoch: 2, id };
        let (state, refused) = heard(&message, &station(), None, None);
        assert_eq!((state.memory, state.epoch, state.slot), (9, 2, Some(key(5))));
        assert_eq!(state.results, [(key(3), TaskOutcome::Done), (key(4), TaskOutcome::Failed(TaskFailure::Cancelled))]);
        assert_eq!(refused, [(key(1), TaskReply::Refused(TaskRefusal::Late))], "what is not known is not believed");
        (message.doing_epoch, message.doing_id, message.phase) = (0, 0, 0);
        assert_eq!(heard(&message, &station(), None, None).0.slot, None);
    }

    #[test]
    fn who_was_told_to_leave_an_order_says_so() {
        let key = |id| OrderKey { epoch: 2, id };
        let mut message = OrderState { doing_epoch: 2, doing_id: 5, phase: 2, ..OrderState::default() };
        assert_eq!(secured(&message, &heard(&message, &station(), None, None).0), None, "it was told nothing");
        (message.secured_epoch, message.secured_id) = (2, 5);
        assert_eq!(secured(&message, &heard(&message, &station(), None, None).0), Some((key(5), TaskReply::Running)));
        (message.doing_epoch, message.doing_id, message.phase) = (0, 0, 0);
        let end = OrderEnd { epoch: 2, id: 5, end: RunTaskResult::END_FAILED, code: 1005 };
        message.ended = Bounded::new(vec![end]).expect("one");
        assert_eq!(
            secured(&message, &heard(&message, &station(), None, None).0),
            Some((key(5), TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Held))))
        );
        (message.doing_epoch, message.doing_id, message.phase) = (2, 5, 2);
        assert_eq!(
            secured(&message, &heard(&message, &station(), None, None).0),
            Some((key(5), TaskReply::Running)),
            "in the slot it has not ended, whatever its results are"
        );
        (message.ended, message.doing_epoch, message.doing_id, message.phase) = (Bounded::default(), 0, 0, 0);
        assert_eq!(
            secured(&message, &heard(&message, &station(), None, None).0),
            Some((key(5), TaskReply::Refused(TaskRefusal::Old)))
        );
    }

    #[test]
    fn moments_go_there_and_back() {
        for micros in [1, 999_999, 1_000_000, 1_763_791_234_567_890] {
            let tick = Tick::from_micros(micros);
            assert_eq!(moment(&time(tick)), Some(tick));
        }
        assert_eq!(moment(&Time::default()), None);
        assert_eq!(moment(&Time { sec: -5, nanosec: 0 }), None);
        assert_eq!(time(Tick::NEVER).sec, i32::MAX);
    }

    #[test]
    fn a_key_is_its_bytes() {
        let key = Bounded::new((1..=16).collect()).expect("sixteen");
        let message = ProductionRequest { key, name: "x".into(), ..ProductionRequest::default() };
        assert_eq!(request(&message, 5).map(|of| of.key), Ok(0x0102_0304_0506_0708_090a_0b0c_0d0e_0f10));
        let message = ProductionRequest { key: Bounded::default(), ..message };
        assert_eq!(request(&message, 5).map(|of| of.key), Ok(5));
        let message = ProductionRequest { key: Bounded::new(vec![1, 2]).expect("two"), ..message };
        assert_eq!(request(&message, 5), Err("`x` has a key of 2 bytes; give 16, or none".to_owned()));
    }
}
