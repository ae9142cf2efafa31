//! The index of an endless axis: it begins at the switch that it ends at.
//!
//! An ordinary motion ends at another switch than it began at. An index leaves its switch and comes on to it again at the next
//! place, so it is complete when the switch went off and on again, and the switch's state at a moment does not show whether
//! the index of this cycle is done. What it has shown is followed while the index is under way, stopped or not:
//!
//! ```text
//!   begin ──▶ AtStart ──off──▶ Away ──on, believed──▶ Arrived: complete
//!                │ devices lost  ▲ │ on, not believed     │ off
//!                ▼               │ │                      │
//!   restart ─▶ Unseen ───off─────┘ ▼                      │
//!                └───on─────────▶ in doubt ◀──────────────┘
//!                                  ▲ ▲
//!            watchdog, at any time ┘ └ off its place while it stands
//! ```
//!
//! An arrival counts that comes by driving, or by coasting shortly after it, in about the time of an index. It is in doubt
//! unless its switch's history has one explanation.
//!
//! Where a drive turns the axis it is measured at which place it stands: see [`crate::axis_place`].
//!
//! A doubt is of the station, and is kept over a restart. It ends by a person who looks, and confirms with
//! [`Controller::rejoin`]. Until then the station's position is lost, and nothing of it moves: from where the index began it
//! would have to, and from the next place it must not.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace, TransitionKind};
use linewright_line::{InputId, OpId};

use crate::controller::{Controller, NO_DELAY};
use crate::event::StopCause;
use crate::parts::{IndexProgress, Token};
use crate::program::{CompiledTransition, Program};

/// An index that is driven for so many times the least it needs may have passed a place between two images.
const LEAST_TIMES_MAX: u32 = 3;

impl Program {
    /// The switch of an operation that is an index; 0 for any other.
    pub(crate) fn index_switch(&self, op: OpId) -> u128 {
        self.places[usize::from(self.index_of(StationPlace::incomplete(op)))].turns
    }
}

impl Controller {
    /// Follows the switch of an index under way, and of an endless axis that stands.
    pub(crate) fn follow_index(&mut self, index: usize) {
        if self.program.index_switches == 0 {
            return;
        }
        let token = self.marking.tokens[index];
        let table = &self.program.places[usize::from(token.place)];
        if table.turns == 0 {
            if !self.claims_rest(&token) {
                return;
            }
            // A drive that is not homed says nothing; once it is, it is compared with the place that is known.
            let off = table.rest & !self.image.bits & self.program.index_switches & !self.unreferenced();
            if off != 0
                && let Some(left) = self.program.places.iter().find(|place| place.turns & off != 0)
            {
                self.doubt(left.place.op);
            }
            self.follow_place();
            return;
        }
        let (op, credit) = (table.place.op, table.least.saturating_sub(self.stale));
        let next = if table.is_measured { self.measured_progress(&token) } else { self.progress(&token) };
        self.due.outputs |= token.driven && self.orders_another_place(index);
        let token = &mut self.marking.tokens[index];
        if token.driven {
            token.last_driven = self.now;
        }
        match next {
            Some(next) => {
                // A motion not seen from its beginning may be nearly done. Driven for less than an image may be old, its switch
                // may also have flickered at the edge.
                if (token.progress, next) == (IndexProgress::Unseen, IndexProgress::Away) {
                    token.turned = credit;
                }
                token.progress = next;
            }
            None => self.doubt(op),
        }
    }

    /// What this image makes of an index; none for a doubt. An image from before the motion says nothing about it.
    pub(crate) fn progress(&self, token: &Token) -> Option<IndexProgress> {
        let table = &self.program.places[usize::from(token.place)];
        let (valid, on) = (self.image.valid, self.image.bits & table.turns != 0);
        let is_begun = token.driven_since != 0 || !table.place.is_operating();
        let own = self.image.under == NO_DELAY || (is_begun && self.image.under >= token.driven_since);
        match token.progress {
            IndexProgress::AtStart if !valid => Some(IndexProgress::Unseen),
            progress if !valid || !own => Some(progress),
            IndexProgress::AtStart | IndexProgress::Unseen | IndexProgress::Away if !on => Some(IndexProgress::Away),
            IndexProgress::AtStart => Some(IndexProgress::AtStart),
            IndexProgress::Unseen => None,
            IndexProgress::Away => self.is_believed(token).then_some(IndexProgress::Arrived),
            IndexProgress::Arrived => on.then_some(IndexProgress::Arrived),
        }
    }

    /// Whether an index that is seen to arrive now has made its way by its drive, and one way only.
    fn is_believed(&self, token: &Token) -> bool {
        let least = self.program.places[usize::from(token.place)].least;
        let in_time = (least..=least * LEAST_TIMES_MAX).contains(&self.time_driven(token));
        !self.rules.timely || (self.is_by_itself(token) && in_time)
    }

    /// Whether its drive moves it, or it coasts: for as long as an image may be old. What comes later was turned by something
    /// else, either way.
    pub(crate) fn is_by_itself(&self, token: &Token) -> bool {
        token.driven || self.now <= token.last_driven + self.stale
    }

    pub(crate) fn doubt(&mut self, op: OpId) {
        if self.marking.doubtful.is_none() {
            self.marking.doubtful = Some(op);
            self.due.report = true;
        }
    }

    /// An index is stopped. One whose watchdog has run out may have passed its place with its switch stuck.
    pub(crate) fn index_stops(&mut self, index: usize) {
        let token = self.marking.tokens[index];
        let table = &self.program.places[usize::from(token.place)];
        if table.turns == 0 {
            return;
        }
        let op = table.place.op;
        self.marking.tokens[index].turned = self.time_driven(&token);
        // Where a drive measures its place it passes none unseen.
        if self.rules.timely && self.is_late(&token) && !table.is_measured {
            self.doubt(op);
        }
    }

    /// Time that an index was driven, over all stops.
    fn time_driven(&self, token: &Token) -> Duration {
        let table = &self.program.places[usize::from(token.place)];
        if !table.place.is_operating() {
            return token.turned;
        }
        let left = if token.driven { token.deadline.since(self.now) } else { token.remaining };
        token.turned.saturating_add(table.watchdog.saturating_sub(left))
    }

    /// The index of which it is not known whether it is done, and its switch.
    pub(crate) fn doubtful_index(&self) -> Option<(OpId, InputId)> {
        let input = |op| InputId(self.program.index_switch(op).trailing_zeros() as u16);
        self.marking.doubtful.map(|op| (op, input(op)))
    }

    /// Reason why an index may not begin or go on: it is in doubt, or it is to begin where its switch is off, and would
    /// end at it without a place between. Unlike for an axis that was missed at one of two switches, no motion clears
    /// that.
    pub(crate) fn unsafe_index(&self, action: &CompiledTransition) -> Option<StopCause> {
        if let Some((op, input)) = self.doubtful_index() {
            return Some(StopCause::IndexDoubtful { op, input, places: self.places_apart() });
        }
        let begins = !matches!(action.kind, TransitionKind::Resume(..));
        let tables = action.to.iter().map(|&place| &self.program.places[usize::from(place)]);
        // A person who holds an index has its drive homed first: at a rest of a station with a cycle by itself (see `homing`).
        let is_led = self.commands.mode() == ControlMode::Manual && self.program.tasks.is_some();
        let unknown = if is_led { self.unreferenced() } else { 0 };
        let missed = tables.filter(|_| begins).find(|table| table.turns & !self.image.bits & !unknown != 0)?;
        let input = InputId(missed.turns.trailing_zeros() as u16);
        Some(StopCause::PositionLost { op: missed.place.op, input })
    }
}
