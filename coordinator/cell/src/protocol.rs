//! The player for a checker: which rules of the order protocol hold, and what decides what it will do.
//!
//! The rules exist for the checker, like `linewright_station_logic::OrderRules`: an exploration that
//! finds nothing wrong is worth believing only if it finds something as soon as one rule is off.

use std::fmt::Write;

use super::player::Coordination;

/// Which rules of the order protocol hold. The default is all of them, and the only choice for a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProtocolRules {
    /// What is in a station's slot moves, whatever its results say. Off: an order has ended as soon as a result says so.
    pub slot_counts: bool,
    /// Somebody is asked, and an answer taken, only when the stations stand. Off: at once.
    pub stands_first: bool,
    /// After an alarm given by hand stations are told to stop. Off: to go back, as after any other failure.
    pub stops: bool,
}

impl Default for ProtocolRules {
    fn default() -> Self {
        ProtocolRules { slot_counts: true, stands_first: true, stops: true }
    }
}

impl Coordination {
    /// The same life with some rules switched off.
    #[must_use]
    pub fn with_rules(mut self, rules: ProtocolRules) -> Self {
        self.rules = rules;
        self
    }

    /// Writes all that decides what it will do, but for numbers that only count: of records and of questions. Two lives that
    /// write the same go on alike.
    pub fn situation(&self, out: &mut String) {
        let state = &self.state;
        // Writing to a string does not fail.
        let _ = write!(
            out,
            "{} {:?} {:?} {:?} {:?} {:?} {:?}|{:?} {} {:?} {:?} {} {:?}",
            state.epoch(),
            state.firings().collect::<Vec<_>>(),
            state.exceptions(),
            state.marking().counts(),
            state.parts().collect::<Vec<_>>(),
            state.unheard,
            state.memory,
            self.watch,
            self.starts,
            self.heard,
            self.sent,
            self.superseded,
            state.last_order,
        );
    }
}
