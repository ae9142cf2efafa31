//! The index of an endless axis: it begins at the switch that it ends at.
//!
//! An ordinary motion ends at another switch than it began at. An index leaves its switch and comes on to it again at the next
//! place, so it is complete when the switch went off and on again, and what the switch shows at a moment does not say
//! whether the index of this cycle is done. What it has shown is followed while the index is under way, stopped or not:
//!
//! ```text
//!   begin ──▶ AtStart ──off──▶ Away ──on──▶ Arrived: complete
//!                │ devices lost  ▲             │ off
//!                ▼               │             ▼
//!   restart ─▶ Unseen ───off─────┘   ┌───▶ Doubtful ◀─── on again in less than half its time
//!                └──────on───────────┘
//! ```
//!
//! A doubt ends by a person who looks, and confirms with [`Controller::rejoin`]. Until then the station's position is lost, and
//! the index does not go on: from where it began it would have to, and from the next place it must not.

use std::time::Duration;

use linewright_line::net::TransitionKind;
use linewright_line::{InputId, OpId};

use crate::controller::{Controller, NO_DELAY};
use crate::event::StopCause;
use crate::parts::{Token, Turn};
use crate::program::CompiledTransition;

impl Controller {
    /// Follows the switch of an index under way. An image from before the motion says nothing about it.
    pub(crate) fn follow_turn(&mut self, index: usize) {
        let token = self.marking.tokens[index];
        let table = &self.program.places[usize::from(token.place)];
        let (valid, on) = (self.image.valid, self.image.bits & table.turns != 0);
        let is_begun = token.driven_since != 0 || !table.place.is_operating();
        let own = self.image.under == NO_DELAY || (is_begun && self.image.under >= token.driven_since);
        let turn = match token.turn {
            Turn::AtStart if !valid => Turn::Unseen,
            turn if !valid || !own => turn,
            Turn::AtStart | Turn::Unseen | Turn::Away if !on => Turn::Away,
            Turn::Unseen => Turn::Doubtful,
            Turn::Away if self.rules.timely && self.time_driven(&token) < table.least => Turn::Doubtful,
            Turn::Away => Turn::Arrived,
            Turn::Arrived if !on => Turn::Doubtful,
            turn @ (Turn::AtStart | Turn::Arrived | Turn::Doubtful) => turn,
        };
        let is_new = turn != token.turn;
        let token = &mut self.marking.tokens[index];
        // What was not seen from its beginning may be nearly done: only the switch counts then.
        if is_new && turn == Turn::Unseen {
            token.turned = Duration::MAX;
        }
        token.turn = turn;
        self.due.report |= is_new && turn == Turn::Doubtful;
    }

    /// How long an index was driven, over all stops.
    pub(crate) fn time_driven(&self, token: &Token) -> Duration {
        let table = &self.program.places[usize::from(token.place)];
        if !table.place.is_operating() {
            return token.turned;
        }
        let left = if token.driven { token.deadline.since(self.now) } else { token.remaining };
        token.turned.saturating_add(table.watchdog.saturating_sub(left))
    }

    /// The index of which it is not known whether it is done, and its switch.
    pub(crate) fn doubtful_index(&self) -> Option<(OpId, InputId)> {
        self.tokens().iter().find_map(|token| {
            let table = &self.program.places[usize::from(token.place)];
            let is_doubtful = table.turns != 0 && token.turn == Turn::Doubtful;
            is_doubtful.then(|| (table.place.op, InputId(table.turns.trailing_zeros() as u16)))
        })
    }

    /// Why an index may not begin or go on: it is in doubt, or it is to begin where its switch is off, and would end at it
    /// without a place between. Unlike an axis that was missed at one of two switches, it is led nowhere by that.
    pub(crate) fn unsafe_index(&self, action: &CompiledTransition) -> Option<StopCause> {
        if let Some((op, input)) = self.doubtful_index() {
            return Some(StopCause::IndexDoubtful { op, input });
        }
        let begins = !matches!(action.kind, TransitionKind::Resume(..));
        let tables = action.to.iter().map(|&place| &self.program.places[usize::from(place)]);
        let missed = tables.filter(|_| begins).find(|table| table.turns & !self.image.bits != 0)?;
        let input = InputId(missed.turns.trailing_zeros() as u16);
        Some(StopCause::PositionLost { op: missed.place.op, input })
    }
}
