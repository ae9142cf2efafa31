//! Why orders and activities failed.

use std::fmt;

use crate::record::{ActivityFailure, Failure, Refusal};

impl Refusal {
    /// That the order was rejected, and the reason; it may follow `order`.
    pub const fn text(self) -> &'static str {
        match self {
            Refusal::Busy => "rejected: another task order is in progress",
            Refusal::Mode => "rejected: station not in auto, or master stop given",
            Refusal::OtherMemory => "rejected: addressed to an order store that was reset",
            Refusal::OldEpoch => "rejected: a newer coordinator epoch is active",
            Refusal::Old => "rejected: order already received",
            Refusal::Late => "rejected: time limit exceeded before the start",
            Refusal::NotThere => "rejected: station not at the rest where the task begins",
            Refusal::Devices => "rejected: I/O devices not operational",
            Refusal::Unknown => "rejected: task or parameters not in the description",
            Refusal::Incomplete => "rejected: an operation is incomplete; complete or undo it in manual",
            Refusal::Isolated => "rejected: station isolated; clear its fault, then return it to service",
        }
    }
}

/// Without the station.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Code(code) if self.is_expiry() => write!(f, "awaited input not on in time (code {code})"),
            Failure::Code(code) => write!(f, "ended with code {code}"),
            Failure::Refused(refusal) => f.write_str(refusal.text()),
            Failure::TimedOut => f.write_str("time limit exceeded"),
            Failure::Forgotten => f.write_str("order lost, order store of the station was reset"),
            Failure::Lost => f.write_str("no state received from the station"),
            Failure::DevicesLost => f.write_str("I/O devices of the station lost"),
        }
    }
}

impl Failure {
    /// With the station's name.
    pub fn text_of(self, station: &str) -> String {
        match self {
            Failure::Code(_) | Failure::TimedOut => format!("{station}: {self}"),
            Failure::Refused(refusal) => format!("{station}: order {}", refusal.text()),
            Failure::Forgotten => format!("{station}: order lost, its order store was reset"),
            Failure::Lost => format!("{station}: no state received"),
            Failure::DevicesLost => format!("{station}: I/O devices lost"),
        }
    }
}

impl ActivityFailure {
    /// The cause without what differs from time to time, for reports.
    pub fn summary(&self) -> String {
        match self {
            ActivityFailure::TimedOut => "time limit of the activity exceeded".to_owned(),
            ActivityFailure::Order { failure, .. } => failure.to_string(),
            ActivityFailure::ByHand { .. } => "alarm raised by hand".to_owned(),
        }
    }

    /// The cause, with the names of the station of its order and of the resource.
    pub fn text_of(&self, station: &str, resource: &str) -> String {
        match self {
            ActivityFailure::TimedOut => self.summary(),
            ActivityFailure::ByHand { .. } => format!("alarm raised by hand for {resource}"),
            ActivityFailure::Order { failure, .. } => failure.text_of(station),
        }
    }
}
