//! The first seconds of a run as lines of progress: that it starts, and the mode when everything is there. What is missing on the way
//! changes many times within a second; it is named if it is still missing after a while.

use std::time::{Duration, Instant};

use linewright_line::Line;
use linewright_msgs::{LineState, StationEvent, StationState};

use super::auto_once::AutoStep;
use super::{RunPhase, Session};

/// Time for stations and devices to come up before what is missing is named.
const NAMED_AFTER: Duration = Duration::from_secs(5);
/// Before the other virtual buses of a run.
const BESIDE: &str = "; beside it ";

/// Whether a run is still coming up.
#[derive(Debug, Default)]
pub struct StartUp {
    is_over: bool,
}

impl StartUp {
    /// The first line.
    pub fn text(line: &Line) -> String {
        let number = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        format!("starting {}, {}", number(line.stations.len(), "station"), number(line.devices.len(), "device"))
    }

    /// Notes what is there this long after the beginning; whether the mode is to be shown, with what is missing.
    pub fn look(&mut self, elapsed: Duration, is_complete: bool) -> bool {
        self.is_over |= is_complete || elapsed >= NAMED_AFTER;
        self.is_over
    }

    /// Whether an event is part of coming up.
    pub fn leaves_out(&self, event: &StationEvent) -> bool {
        !self.is_over && event.kind == StationEvent::KIND_DEVICES
    }
}

/// Whether the coordinator receives every station, and all devices are operational.
pub fn is_complete<'s>(
    coordinator: Option<&LineState>,
    mut stations: impl Iterator<Item = Option<&'s StationState>>,
) -> bool {
    let hears_all = |state: &LineState| {
        !state.console_lost && state.station_heard.iter().all(|heard| *heard == LineState::HEARD_FRESH)
    };
    coordinator.is_some_and(hears_all) && stations.all(|state| state.is_some_and(|state| state.devices_valid))
}

/// The buses, by name and description, each with whether it is virtual: the virtual ones of a run are in one directory, which is named once.
pub fn buses(buses: &[(String, String, bool)]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut first_virtual: Option<usize> = None;
    for (name, description, is_virtual) in buses {
        match first_virtual.filter(|_| *is_virtual) {
            Some(first) if lines[first].contains(BESIDE) => lines[first].push_str(&format!(", {name}")),
            Some(first) => lines[first].push_str(&format!("{BESIDE}{name}")),
            None => {
                first_virtual = first_virtual.or(is_virtual.then_some(lines.len()));
                lines.push(format!("CAN: {description}"));
            }
        }
    }
    lines
}

impl Session {
    /// Brings the line to auto, once.
    pub(super) fn begin(&mut self, state: &LineState) {
        // What a person has to end, as a node that is not active, must not be followed by auto when it ends.
        let is_held = !state.obstacles.is_empty()
            || self.states().flatten().any(|state| state.lifecycle != StationState::LIFECYCLE_ACTIVE);
        if is_held && self.auto_once.hand_over() {
            self.note(format!("gives no start and no auto any more: {}", state.text));
        }
        let ready = self.all_ready();
        match self.auto_once.next(state, ready) {
            AutoStep::Give(command) if self.say(command) => {
                let given = match state.refusal.as_str() {
                    "" => format!("gives {command}"),
                    refusal => {
                        format!("gives {command} until it is taken: {refusal}; `linewright recover` lists the way")
                    }
                };
                // Once, however often it is given.
                if given != self.given {
                    self.note(given.clone());
                    self.given = given;
                }
            }
            AutoStep::Give(_) | AutoStep::Wait => {}
            AutoStep::InAuto => {
                self.tally.begin(&state.header);
                self.progress.since = Instant::now();
                self.phase = RunPhase::Running;
            }
            AutoStep::Restarted => self.note(format!(
                "the coordinator was started again before auto was in force, and is now in {}: give start and auto when \
                 everything is in order",
                state.text
            )),
            AutoStep::HandsOver => {
                self.note(format!(
                    "not in auto yet, and now {}: another has changed the mode, who gives auto then",
                    state.text
                ));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn devices(kind: u8) -> StationEvent {
        StationEvent { kind, ..StationEvent::default() }
    }

    #[test]
    fn what_is_missing_is_shown_once_it_is_missing_for_long() {
        let mut startup = StartUp::default();
        assert!(!startup.look(Duration::from_millis(900), false));
        assert!(startup.leaves_out(&devices(StationEvent::KIND_DEVICES)));
        assert!(!startup.leaves_out(&devices(StationEvent::KIND_FAULT)), "a fault is never left out");
        assert!(startup.look(NAMED_AFTER, false));
        assert!(!startup.leaves_out(&devices(StationEvent::KIND_DEVICES)));
        let mut startup = StartUp::default();
        assert!(startup.look(Duration::from_millis(1100), true));
        assert!(startup.look(Duration::from_millis(1200), false), "a device that is lost later is shown at once");
    }

    #[test]
    fn the_directory_of_virtual_buses_is_named_once() {
        let bus = |name: &str, is_virtual| (name.to_owned(), format!("{name} in /run/{name}"), is_virtual);
        assert_eq!(
            buses(&[bus("can0", false), bus("can1", false)]),
            ["CAN: can0 in /run/can0", "CAN: can1 in /run/can1"]
        );
        let virtual_ones = buses(&[bus("can0", false), bus("v0", true), bus("v1", true), bus("v2", true)]);
        assert_eq!(virtual_ones, ["CAN: can0 in /run/can0", "CAN: v0 in /run/v0; beside it v1, v2"]);
    }

    #[test]
    fn everything_is_there_when_the_coordinator_receives_it_and_its_devices_are() {
        let line =
            |console_lost, heard| LineState { console_lost, station_heard: vec![heard; 2], ..LineState::default() };
        let station = |devices_valid| StationState { devices_valid, ..StationState::default() };
        let (there, lost) = (station(true), station(false));
        let fresh = line(false, LineState::HEARD_FRESH);
        assert!(is_complete(Some(&fresh), [Some(&there), Some(&there)].into_iter()));
        for (state, stations) in [
            (None, [Some(&there), Some(&there)]),
            (Some(&fresh), [Some(&there), Some(&lost)]),
            (Some(&fresh), [Some(&there), None]),
            (Some(&line(true, LineState::HEARD_FRESH)), [Some(&there), Some(&there)]),
            (Some(&line(false, LineState::HEARD_UNKNOWN)), [Some(&there), Some(&there)]),
        ] {
            assert!(!is_complete(state, stations.into_iter()));
        }
    }
}
