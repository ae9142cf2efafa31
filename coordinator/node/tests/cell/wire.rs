//! Orders, requests and moments in messages.

use linewright_coordinator_cell::exception::Presence;
use linewright_coordinator_node::cell::by_whom;
use linewright_coordinator_node::cell::wire::{heard, moment, request, secured, time};
use linewright_line::{InputId, Station, Tick};
use linewright_msgs::{Bounded, OrderEnd, OrderState, ProductionRequest, RosMessage, RunTaskResult, Time};
use linewright_orders::{LeaveWay, OrderKey, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};
use linewright_testkit::built::transfer_line;

fn station() -> Station {
    transfer_line().stations.remove(0)
}

/// Without a valid input image the presence of a part is reported as unread; a station without a sensor reports that it has none.
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

/// Of the inputs that operations wait for those are reported that are off; none of an image that is not there.
#[test]
fn awaited_inputs_that_are_off_are_heard() {
    let mut station = station();
    station.operations[0].waits = vec![InputId(0), InputId(1)];
    let off = |inputs: &[u8]| {
        let inputs = Bounded::new(inputs.to_vec()).expect("a few");
        heard(&OrderState { inputs, ..OrderState::default() }, &station, None, None).0.off
    };
    assert_eq!([off(&[0]), off(&[1]), off(&[3]), off(&[])], [3, 2, 0, 0]);
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
    (message.secured_epoch, message.secured_id, message.secured_way) = (2, 5, LeaveWay::Hold.number());
    assert_eq!(
        secured(&message, &heard(&message, &station(), None, None).0),
        Some((key(5), LeaveWay::Hold, TaskReply::Running))
    );
    (message.doing_epoch, message.doing_id, message.phase) = (0, 0, 0);
    let end = OrderEnd { epoch: 2, id: 5, end: RunTaskResult::END_FAILED, code: 1005 };
    message.ended = Bounded::new(vec![end]).expect("one");
    assert_eq!(
        secured(&message, &heard(&message, &station(), None, None).0),
        Some((key(5), LeaveWay::Hold, TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Held))))
    );
    (message.doing_epoch, message.doing_id, message.phase) = (2, 5, 2);
    assert_eq!(
        secured(&message, &heard(&message, &station(), None, None).0),
        Some((key(5), LeaveWay::Hold, TaskReply::Running)),
        "in the slot it has not ended, whatever its results are"
    );
    (message.ended, message.doing_epoch, message.doing_id, message.phase) = (Bounded::default(), 0, 0, 0);
    assert_eq!(
        secured(&message, &heard(&message, &station(), None, None).0),
        Some((key(5), LeaveWay::Hold, TaskReply::Refused(TaskRefusal::Old)))
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

#[test]
fn a_request_without_a_sender_names_none() {
    assert_eq!([by_whom(""), by_whom(" "), by_whom("Ann\n")], ["", "", " by Ann"]);
}
