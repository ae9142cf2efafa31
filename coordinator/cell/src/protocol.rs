//! The rules of the order protocol, to be switched off by a checker.
//!
//! The rules exist for the checker, like `linewright_station_logic::OrderRules`: an exploration without findings is
//! credible only if it has findings as soon as one rule is off.

/// Rules of the order protocol. The default is all of them, and the only choice for a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProtocolRules {
    /// The order in a station's slot is in progress, whatever its results report. Off: an order has ended as soon as a
    /// result reports it.
    pub slot_counts: bool,
    /// The alarm is raised, and an answer taken, only when the stations stand. Off: at once.
    pub stands_first: bool,
    /// After an alarm given by hand stations are ordered to stop. Off: to go back, as after any other failure.
    pub stops: bool,
    /// A station is ordered back only while no other one of the activity is in a handshake or has completed its order. Off: always.
    pub goes_back_alone: bool,
}

impl Default for ProtocolRules {
    fn default() -> Self {
        ProtocolRules { slot_counts: true, stands_first: true, stops: true, goes_back_alone: true }
    }
}
