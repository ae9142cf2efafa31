//! Causes of a stopped motion, with the signal and where it is wired.

use linewright_line::net::Block;
use linewright_line::{Line, OpId, OperationModule, Owner, StationId, duration_text};

use crate::event::StopCause;

/// A motion that counts as complete by the switch at its other end alone.
pub(crate) fn stuck_text(op: &str, input: &str, behind: Option<&str>) -> String {
    let by = behind.map_or_else(|| "without a switch".to_owned(), |behind| format!("by {behind} off alone"));
    format!("{op}: done {by}; {input} was on from the start: check that switch")
}

/// What has become of a fault signal that came on; it follows the cause.
pub(crate) const fn signal_now_text(is_on: bool) -> &'static str {
    if is_on { ", and is still on" } else { ", and is off now" }
}

/// Whether a switch is still as it was when it stopped a motion.
#[derive(Clone, Copy)]
pub(crate) enum SwitchTense {
    Now,
    Then,
}

impl SwitchTense {
    const fn verb(self) -> &'static str {
        match self {
            SwitchTense::Now => "is",
            SwitchTense::Then => "was",
        }
    }
}

impl StopCause {
    /// The cause without names of the line.
    pub const fn text(self) -> &'static str {
        match self {
            StopCause::Signal => "fault signal",
            StopCause::Watchdog => "watchdog: motion not complete in time",
            StopCause::SwitchStuck => "watchdog: limit switch was on before the motion started",
            StopCause::BothSwitchesOn { .. } => "watchdog: limit switches of both ends are on",
            StopCause::Devices => "I/O devices lost",
            StopCause::Released => "button released",
            StopCause::EStop => "emergency stop",
            StopCause::Ordered => "stop requested by the coordinator",
            StopCause::Restart => "controller restarted",
            StopCause::NotAtHome => "not at home at power-up",
            StopCause::Interlock { .. } => "interlock: other station not clear",
            StopCause::PositionLost { .. } => "position lost",
            StopCause::IndexDoubtful { .. } => "index in doubt",
            StopCause::Ambiguous => "internal error: two exclusive transitions enabled; report this fault",
        }
    }

    /// The cause found by measured positions, with the station, the switch and where it is wired.
    pub fn detail(self, line: &Line, own: StationId) -> String {
        self.detail_at(line, own, SwitchTense::Now)
    }

    fn detail_at(self, line: &Line, own: StationId, tense: SwitchTense) -> String {
        let is = tense.verb();
        match self {
            StopCause::Interlock { station, input: Some(input), is_on: true } => format!(
                "interlock: {} not clear: {} {is} on, and off while it is clear; check mechanism and switch",
                line.station(station).name,
                line.input_text(Owner::Station(station), input)
            ),
            StopCause::Interlock { station, input: Some(input), is_on: false } => format!(
                "interlock: {} not clear: {} {is} off",
                line.station(station).name,
                line.input_text(Owner::Station(station), input)
            ),
            StopCause::Interlock { station, input: None, .. } if !is_measured(line, own, station) => format!(
                "interlock: {} not clear: no switches measure that, and the two did not begin anew together",
                line.station(station).name
            ),
            StopCause::Interlock { station, input: None, .. } => {
                format!(
                    "interlock: position of {} unknown: no valid image of its limit switches",
                    line.station(station).name
                )
            }
            StopCause::PositionLost { op, input } => format!(
                "position lost: {} {is} off, required on at `{}`; check mechanism and switch",
                line.input_text(Owner::Station(own), input),
                line.operation((own, op)).name
            ),
            StopCause::IndexDoubtful { places: Some(places), .. } => format!(
                "index in doubt: measured at or after place {}, last known at place {}; look at the mechanism, then confirm \
                 with rejoin",
                places.measured, places.known
            ),
            StopCause::IndexDoubtful { op, input, places: None } => format!(
                "index in doubt: {} does not tell whether `{}` is done; look at the mechanism, then confirm with rejoin",
                line.input_text(Owner::Station(own), input),
                line.operation((own, op)).name
            ),
            _ => self.text().to_owned(),
        }
    }

    /// The cause of a stop of this operation, e.g. `watchdog: LS_closed (clamp 1 io, node 21h, 6000h:01 bit 1) not on
    /// within 1 s`.
    pub fn text_of(self, line: &Line, station: StationId, op: OpId, block: Block) -> String {
        self.text_at(line, (station, op), block, SwitchTense::Now)
    }

    /// The same, of a stop after which the switch that was looked at may be as it should be again.
    pub(crate) fn text_at(
        self,
        line: &Line,
        (station, op): (StationId, OpId),
        block: Block,
        tense: SwitchTense,
    ) -> String {
        let operation = line.operation((station, op));
        let signals = match (block, &operation.module) {
            (Block::Recovery, OperationModule::Reversible { recovery, .. }) => recovery,
            _ => &operation.normal,
        };
        let input = |input| line.input_text(Owner::Station(station), input);
        match (self, signals.fault) {
            (StopCause::Watchdog, _) => {
                format!("watchdog: {} not on within {}", input(signals.complete), duration_text(operation.watchdog))
            }
            (StopCause::SwitchStuck, _) if line.station(station).index_of(op).is_some() => {
                format!(
                    "watchdog: {} was on all the time for {}; check drive and switch",
                    input(signals.complete),
                    duration_text(operation.watchdog)
                )
            }
            (StopCause::SwitchStuck, _) => {
                format!("watchdog: {} was on before the motion started; check the switch", input(signals.complete))
            }
            (StopCause::BothSwitchesOn { behind }, _) => format!(
                "watchdog: {} and {} are both on, at the two ends of the motion; one of them sticks, or nothing has moved: \
                 check both switches and the mechanism",
                input(signals.complete),
                input(behind)
            ),
            (StopCause::Interlock { .. } | StopCause::PositionLost { .. } | StopCause::IndexDoubtful { .. }, _) => {
                self.detail_at(line, station, tense)
            }
            (StopCause::Signal, Some(fault)) => format!("{}: {} came on", self.text(), input(fault)),
            _ => self.text().to_owned(),
        }
    }
}

/// Whether switches measure any conflict of one station on the other one's side.
fn is_measured(line: &Line, own: StationId, other: StationId) -> bool {
    let of_other = line.conflicts.iter().filter_map(|conflict| match (&conflict.a, &conflict.b) {
        (a, b) if (a.station, b.station) == (own, other) => Some(b),
        (a, b) if (b.station, a.station) == (own, other) => Some(a),
        _ => None,
    });
    of_other.into_iter().any(|side| line.clearance(side).is_ok())
}
