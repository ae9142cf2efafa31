//! The cause of a loss of devices, put where people look: the fault, what the station waits for, its events.
//!
//! The controller has only that its devices are invalid; which one and why comes from their manager.

use linewright_msgs::{cut, fitting};
use linewright_node_line::devices::TROUBLE_BYTES_MAX;
use linewright_station_logic::{DEVICES_INVALID, HappeningKind, StationHappening, StopCause};

/// Texts of the devices' faults.
#[derive(Debug, Default)]
pub struct DeviceTexts {
    /// Present faults; empty if none is known.
    now: String,
    /// First fault when they were last lost: the cause, before its consequences.
    first: String,
}

impl DeviceTexts {
    /// Takes the text of the devices' manager, or any text on its topic: no more of it than there is room for.
    pub fn trouble(&mut self, text: &str) {
        self.now = cut(text.to_owned(), TROUBLE_BYTES_MAX);
        if self.first.is_empty() {
            self.now.clone_into(&mut self.first);
        }
    }

    /// Completes a state's fault and reasons. `valid`: the devices are. The fault fits a message afterwards: it has the
    /// cause once per stopped operation, and a state that does not fit is not sent.
    pub fn complete(&mut self, valid: bool, fault: &mut String, blocked_by: &mut [String]) {
        let lost = StopCause::Devices.text();
        if fault.contains(lost) {
            if !self.first.is_empty() {
                *fault = fault.replace(lost, &format!("{lost} ({})", self.first));
            }
        } else if valid && self.now.is_empty() {
            self.first.clear();
        }
        if !self.now.is_empty() {
            for reason in blocked_by.iter_mut().filter(|reason| *reason == DEVICES_INVALID) {
                *reason = format!("its I/O devices: {}", self.now);
            }
        }
        for text in blocked_by.iter_mut().chain([fault]) {
            *text = fitting(std::mem::take(text));
        }
    }

    /// Completes an event's text.
    pub fn event(&self, event: &StationHappening, text: String) -> String {
        match event.what {
            HappeningKind::Devices(false) if !self.now.is_empty() => format!("{text}: {}", self.now),
            HappeningKind::Stopped(_, _, StopCause::Devices) if !self.first.is_empty() => {
                format!("{text} ({})", self.first)
            }
            _ => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use linewright_msgs::{RosMessage as _, StationState};

    use super::*;

    #[test]
    fn a_state_with_a_fault_fits_a_message_whatever_is_said_of_the_devices() {
        let mut words = DeviceTexts::default();
        words.trouble(&"x".repeat(4096));
        let mut state = StationState { station: "press".to_owned(), boot_id: 1, ..StationState::default() };
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
        // Recovered; the next loss has a cause of its own.
        state(&mut words, true, "");
        words.trouble("io: booted");
        assert_eq!(state(&mut words, false, "close: I/O devices lost").0, "close: I/O devices lost (io: booted)");
    }
}
