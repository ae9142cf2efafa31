//! The player for a checker: with rules switched off, and all that decides what it will do.

use std::fmt::Write;

use super::player::Coordination;
use super::protocol::ProtocolRules;

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
