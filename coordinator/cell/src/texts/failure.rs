//! Reasons why orders and activities failed.

use std::fmt;

use linewright_orders::TaskFailure;

use crate::record::{ActivityFailure, OrderFailure};

/// Without the station.
impl fmt::Display for OrderFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OrderFailure::Code(code) => f.write_str(&TaskFailure::from_code(*code).text()),
            OrderFailure::Refused(refusal) => f.write_str(refusal.text()),
            OrderFailure::TimedOut => f.write_str("time limit exceeded"),
            OrderFailure::Forgotten => f.write_str("order lost, the station has lost its memory of orders"),
            OrderFailure::Lost => f.write_str("no state received from the station"),
            OrderFailure::DevicesLost => f.write_str("I/O devices of the station lost"),
        }
    }
}

impl OrderFailure {
    /// With the station's name.
    pub fn text_of(self, station: &str) -> String {
        match self {
            OrderFailure::Code(_) | OrderFailure::TimedOut => format!("{station}: {self}"),
            OrderFailure::Refused(refusal) => format!("{station}: order {}", refusal.text()),
            OrderFailure::Forgotten => format!("{station}: order lost, with its memory of orders"),
            OrderFailure::Lost => format!("{station}: no state received"),
            OrderFailure::DevicesLost => format!("{station}: I/O devices lost"),
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
