//! The second barrier: measured positions.
//!
//! Counts keep two stations from starting together, as long as every memory is intact. Positions need no memory. Two things
//! are measured here, and held in auto, hand and manual mode and on recovery paths alike:
//!
//! * **Clearances.** For each conflict of the description a motion starts and goes on only while the other station is measured
//!   outside its state of the conflict: in the other's image, as its report carries it, the limit switches that prove it are on,
//!   and those at the other places of the same axes are off ([`Line::clearance`]): a switch that sticks is contradicted by
//!   the one that the axis has come to. A motion outside this station's own state of the conflict may instead rely on this station's own
//!   switches. An image that is not received, not valid or too old measures nothing, and blocks.
//! * **Rests.** An axis that stands still by the chart is measured there ([`Station::rest_inputs`]). While one is not, nothing
//!   new starts in auto and hand, and nothing that relies on the axis starts in manual: its position is lost.
//!
//! Two tasks of task-driven stations are kept apart by orders: the one is not ordered while the other is under way. Where
//! switches measure a task, the other station checks them all the same; where none do, there is no second barrier.
//!
//! What this does not exclude by itself: two stations that start within the time a report takes see each other outside still.
//! Against that stand the counts, and in manual, where there are none in common, an agreement before the start (see `entry`).

use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace};
use linewright_line::{InputId, OpId};

use crate::controller::Controller;
use crate::event::StopCause;
use crate::parts::Token;
use crate::position_guard::{PositionGuard, PositionsKnown};
use crate::program::{CompiledTransition, Program, path_index};
use crate::views::Comparability;

impl Program {
    /// The guards of a motion, which on a recovery path is a motion of that path, and for each whether the motion leads out
    /// of the state of this station that the guard is about.
    pub fn guards(&self, place: StationPlace, path: Option<OpId>) -> impl Iterator<Item = (PositionGuard, bool)> {
        let interlocks = &self.interlocks;
        let of_path = path.map_or(&[][..], |failed| interlocks.of_path(path_index(&self.paths, failed)));
        let all = interlocks.of_operation(place.op).iter().chain(of_path);
        all.map(move |guard| {
            // A recovery path leads out of every state that it begins in, and may lead into others.
            let leaves = match path {
                None => guard.leaves == Some(place.block),
                Some(_) => of_path.iter().any(|begins| begins.conflict == guard.conflict),
            };
            (*guard, leaves)
        })
    }

    /// The inputs that are off in this image and would have to be on while this place is marked, but for a recovery path.
    pub fn off_at_rest(&self, place: StationPlace, image: u128) -> u128 {
        self.places[usize::from(self.index_of(place))].off_at_rest(image)
    }
}

impl Controller {
    /// The first guard of a motion that does not hold now.
    pub(crate) fn violated(&self, place: StationPlace, path: Option<OpId>) -> Option<PositionGuard> {
        self.violated_leaving(place, path).map(|(guard, _)| guard)
    }

    /// The same, and whether the motion leads out of the state.
    fn violated_leaving(&self, place: StationPlace, path: Option<OpId>) -> Option<(PositionGuard, bool)> {
        if !self.rules.positions {
            return None;
        }
        let allows = |(guard, leaves): &(PositionGuard, bool)| {
            guard.holds(self.positions_known(guard)) || (*leaves && self.stands(guard))
        };
        self.program.guards(place, path).find(|guard| !allows(guard))
    }

    pub(crate) fn positions_known(&self, guard: &PositionGuard) -> PositionsKnown {
        let peer = usize::from(guard.peer);
        let known = PositionsKnown {
            own: self.image.valid.then_some(self.image.bits),
            is_placed: self.is_placed(),
            other: self.views.measured(peer, self.now),
            counts: self.views.standing(peer, self.counts.cycle, self.now) == Comparability::Comparable,
        };
        if self.rules.contradicted { known } else { guard.uncontradicted(known) }
    }

    /// Whether its axes stand by the chart.
    pub(crate) fn is_placed(&self) -> bool {
        !self.marking.unconfirmed && self.marking.placed && self.position_lost().is_none()
    }

    /// Whether this station may leave its state although the other is in the way: in manual mode, while the other is
    /// received and stands. Both are where they must not be together then; to lead one of them out is the only way back, and
    /// the person who holds the button sees both.
    fn stands(&self, guard: &PositionGuard) -> bool {
        let peer = usize::from(guard.peer);
        self.commands.mode() == ControlMode::Manual && self.views.stands(peer, self.now)
    }

    /// Reason why a guard does not hold.
    pub(crate) fn interlock(&self, guard: &PositionGuard) -> StopCause {
        let view = &self.views.peers[usize::from(guard.peer)];
        let station = view.station;
        let measured = self.now < view.measured_until;
        let wrong = guard.clear.filter(|_| measured).map_or(0, |clear| clear.wrong(view.measured));
        let (on, off) = (wrong & view.measured, wrong & !view.measured);
        // Where it has just left, both are wrong: what it waits for comes first.
        let first = if off != 0 { off } else { on };
        let input = (first != 0).then(|| InputId(first.trailing_zeros() as u16));
        let is_on = input.is_some() && off == 0;
        StopCause::Interlock { station, input, is_on }
    }

    /// An axis that stands still by the chart and is not measured there: the operation at whose place, and the switch.
    pub fn position_lost(&self) -> Option<(OpId, InputId)> {
        // A doubt is one without devices too.
        let doubtful = self.doubtful_index().filter(|_| self.rules.positions);
        doubtful.or_else(|| {
            let missing = |token: &Token| first_missing(self.place(token).op, self.rest_off(token));
            self.tokens().iter().find_map(missing)
        })
    }

    /// The switches of axes that stand still while this token stands where it does, and that are off.
    pub(crate) fn rest_off(&self, token: &Token) -> u128 {
        if self.claims_rest(token) {
            self.program.places[usize::from(token.place)].off_at_rest(self.image.bits)
        } else {
            0
        }
    }

    /// Whether the axes that stand still by the chart are to be measured where it has them.
    pub(crate) fn claims_rest(&self, token: &Token) -> bool {
        let place = self.place(token);
        // A station that is not at home claims nothing of its axes until it is led there.
        let claims = !place.is_incomplete() || self.marking.causes_of_stop[place.op.index()] != StopCause::NotAtHome;
        let is_judged = self.judges_rests() && self.image.valid && self.marking.path.is_none() && claims;
        is_judged && !self.marking.unconfirmed
    }

    /// Whether axes that stand still are compared with the chart.
    pub(crate) fn judges_rests(&self) -> bool {
        self.rules.positions && self.rules.rests
    }

    fn rest_missing(&self, place: u16) -> Option<(OpId, InputId)> {
        let table = &self.program.places[usize::from(place)];
        first_missing(table.place.op, table.off_at_rest(self.image.bits) & !self.disregarded(place))
    }

    /// Reason why the motions that a transition starts may not start; none where they may, or where it starts none.
    pub(crate) fn unsafe_start(&self, action: &CompiledTransition, mode: ControlMode) -> Option<StopCause> {
        let leads_to = action.to.iter().map(|&to| self.program.places[usize::from(to)].place);
        let mut back = leads_to.filter(|place| place.is_operating() && place.block == Block::Recovery);
        if back.any(|place| self.is_not_taken_back(place)) {
            return Some(StopCause::NotAtHome);
        }
        if !self.rules.positions {
            return None;
        }
        if let Some(cause) = self.unsafe_index(action) {
            return Some(cause);
        }
        let path = self.path_in(action);
        for &to in &action.to {
            let place = self.program.places[usize::from(to)].place;
            if place.stage != MotionStage::Operating {
                continue;
            }
            if let Some(guard) = self.violated(place, path) {
                return Some(self.interlock(&guard));
            }
            if path.is_none()
                && self.judges_rests()
                && let Some((op, input)) = self.rest_missing(to)
            {
                return Some(StopCause::PositionLost { op, input });
            }
        }
        let alone = matches!(mode, ControlMode::Auto | ControlMode::Hand);
        let lost = self.position_lost().filter(|_| alone);
        lost.map(|(op, input)| StopCause::PositionLost { op, input })
    }

    /// Reason why a motion under way may not go on.
    pub(crate) fn unsafe_motion(&self, index: usize) -> Option<StopCause> {
        let token = &self.marking.tokens[index];
        // A measurement that is not clear stops the motion. A missing measurement keeps the next one from starting: the mode
        // decision has the line finish what runs, and a cut that is broken off for a lost message would spoil the part. A
        // motion that leads out, in manual mode, may have started only because the other station stood: it stops as soon as
        // that is not known.
        if let Some((guard, leaves)) = self.violated_leaving(self.place(token), self.marking.path) {
            let cause = self.interlock(&guard);
            let is_measured = matches!(cause, StopCause::Interlock { input: Some(_), .. });
            if is_measured || (leaves && self.commands.mode() == ControlMode::Manual) {
                return Some(cause);
            }
        }
        let checked = self.judges_rests() && self.image.valid && self.marking.path.is_none();
        let lost = if checked { self.rest_missing(token.place) } else { None };
        lost.map(|(op, input)| StopCause::PositionLost { op, input })
    }
}

fn first_missing(op: OpId, off: u128) -> Option<(OpId, InputId)> {
    (off != 0).then(|| (op, InputId(off.trailing_zeros() as u16)))
}
