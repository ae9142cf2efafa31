//! The cause of a loss of devices, put where people look: the fault, what the station waits for, its events.
//!
//! The controller has only that its devices are invalid; which one and why comes from their manager.

use linewright_msgs::{cut, fitting};
use linewright_node_line::devices::{TROUBLE_BYTES_MAX, cause};
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
            self.first = cause(&self.now);
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
