//! The cause of a loss of devices in faults, reasons and events.

use linewright_msgs::{RosMessage as _, StationState};
use linewright_station_logic::{DEVICES_INVALID, HappeningKind, StationHappening};
use linewright_station_node::DeviceTexts;

fn active() -> StationState {
    StationState { lifecycle: StationState::LIFECYCLE_ACTIVE, ..StationState::default() }
}

#[test]
fn a_state_with_a_fault_fits_a_message_whatever_is_said_of_the_devices() {
    let mut words = DeviceTexts::default();
    words.trouble(&"x".repeat(4096));
    let mut state = StationState { station: "press".to_owned(), boot_id: 1, ..active() };
    state.fault = vec!["close: I/O devices lost"; 40].join("; ");
    state.blocked_by = vec![DEVICES_INVALID.to_owned(), "y".repeat(5000)];
    words.complete(false, &mut state.fault, &mut state.blocked_by);
    assert_eq!(state.validate(), Ok(()));
    assert!(state.fault.starts_with("close: I/O devices lost (xxx"), "{}", state.fault);
    let event = StationHappening { cycle: 0, what: HappeningKind::Devices(false) };
    assert!(words.event(&event, "I/O devices lost".to_owned()).len() < 4096);
}

#[test]
fn the_first_cause_stays_with_the_fault_and_the_present_one_is_what_is_waited_for() {
    let mut words = DeviceTexts::default();
    let state = |words: &mut DeviceTexts, valid, fault: &str| {
        let mut fault = fault.to_owned();
        let mut reasons = [DEVICES_INVALID.to_owned(), "a mode".to_owned()];
        words.complete(valid, &mut fault, &mut reasons);
        (fault, reasons[0].clone())
    };
    let none = state(&mut words, false, "close: I/O devices lost");
    assert_eq!(none, ("close: I/O devices lost".to_owned(), DEVICES_INVALID.to_owned()));
    words.trouble("io: silent");
    words.trouble("io: being identified");
    let (fault, reason) = state(&mut words, false, "close: I/O devices lost");
    assert_eq!(
        (fault.as_str(), reason.as_str()),
        ("close: I/O devices lost (io: silent)", "its I/O devices: io: being identified")
    );
    words.trouble("");
    assert_eq!(state(&mut words, true, "close: I/O devices lost").0, "close: I/O devices lost (io: silent)");
    // Recovered; the next loss has a cause of its own: that the manager was started, and not each device that it does not hear yet.
    state(&mut words, true, "");
    words.trouble("coordinator was started, since then never heard: io (node 04h), drive (node 05h)");
    let (fault, reason) = state(&mut words, false, "close: I/O devices lost");
    assert_eq!(fault, "close: I/O devices lost (coordinator was started)");
    assert!(reason.ends_with("was started, since then never heard: io (node 04h), drive (node 05h)"), "{reason}");
    words.trouble("");
    state(&mut words, true, "");
    words.trouble("io: booted");
    assert_eq!(state(&mut words, false, "close: I/O devices lost").0, "close: I/O devices lost (io: booted)");
}
