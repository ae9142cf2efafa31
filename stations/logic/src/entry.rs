//! Motions that rely on measured positions alone: one station at a time, by agreement.
//!
//! In manual, stations without a generation in common are kept apart by measured positions (see `interlock`). Each report of a
//! position is some time old, so two stations whose buttons are pressed together would each see the other outside its state of a
//! conflict, and both start. So such a motion does not start on the press. The station makes a request, as for counts that it
//! takes back (see `withdraw`), and starts when each station concerned has agreed to that very number.
//!
//! A station agrees if none of its motions relies on the position of the other one, and its input image was taken after its outputs
//! went off. Of two requests that cross, that of the station listed first stands: the other station closes its own and agrees.
//! From the moment it sees a request until it sees that it is closed, a station makes none itself.
//!
//! Why two stations never start together by it: the second one needs the agreement of the first. The first gives none while its own
//! request is open, and none while it moves, and both are its own present state, whatever messages are on their way and whatever
//! the second one remembers. What has stopped on its way is measured there in the image that the agreement waits for. A station
//! that is restarted stands, and agrees to a number of its earlier life for nobody: an answer names the life that asked.

use linewright_line::OpId;
use linewright_line::net::{ControlMode, MotionStage, StationPlace, TransitionKind};

use crate::controller::Controller;
use crate::parts::AgreementRefusal;
use crate::peer_set::PeerSet;
use crate::program::{CompiledTransition, ConditionRow};

impl Controller {
    /// The peers that must agree before the motions of this row start.
    pub(crate) fn entered_by(&self, row: &ConditionRow, mode: ControlMode) -> PeerSet {
        if mode != ControlMode::Manual || !row.starts || !self.rules.entry || !self.rules.positions {
            return PeerSet::EMPTY;
        }
        let action = &self.program.actions[usize::from(row.transition)];
        let path = self.path_in(action);
        let places = action.to.iter().map(|&to| self.program.places[usize::from(to)].place);
        places.fold(PeerSet::EMPTY, |all, place| all | self.relied_on(place, path))
    }

    /// The recovery path that a transition's motions belong to.
    pub(crate) fn path_in(&self, action: &CompiledTransition) -> Option<OpId> {
        match action.kind {
            TransitionKind::EnterPath(failed) => Some(failed),
            _ => self.marking.path,
        }
    }

    /// The peers without a common generation on whose position a motion relies.
    fn relied_on(&self, place: StationPlace, path: Option<OpId>) -> PeerSet {
        if place.stage != MotionStage::Operating {
            return PeerSet::EMPTY;
        }
        let guards = self.program.guards(place, path).map(|(guard, _)| guard);
        let relies = guards.filter(|guard| !guard.is_outside(self.positions_known(guard)));
        let peers = relies.map(|guard| usize::from(guard.peer));
        peers.filter(|&peer| !self.views.shares_generation(peer)).collect()
    }

    /// Answers the request of a peer with which no counts are compared.
    pub(crate) fn answer_entry(&mut self, peer: usize) {
        let view = &self.views.peers[peer];
        let (by, Some(request)) = (view.station, view.request) else { return };
        let crosses = self.agreement.pending.filter(|pending| pending.entered.contains(peer));
        if let Some(pending) = crosses.filter(|_| by < self.program.station) {
            // It is closed before the agreement is given: both are in one report.
            self.agreement.pending = None;
            self.reject(&pending, AgreementRefusal { by, in_the_way: None, ops: pending.request.ops });
        }
        let in_the_way = self.moves_against(peer);
        self.views.answer(peer, request, in_the_way);
    }

    /// The operation that keeps a peer from starting by measured positions.
    fn moves_against(&self, peer: usize) -> Option<OpId> {
        let asks = self.agreement.pending.as_ref().filter(|pending| pending.entered.contains(peer));
        let asked = asks.map(|pending| &self.program.rows[usize::from(pending.rows[0])]);
        if let Some(row) = asked {
            let to = self.program.actions[usize::from(row.transition)].to[0];
            return Some(self.program.places[usize::from(to)].place.op);
        }
        let relies = |place: StationPlace| self.relied_on(place, self.marking.path).contains(peer);
        let homed = self.homes().map(StationPlace::operating);
        if let Some(place) = self.marking().chain(homed).find(|&place| relies(place)) {
            return Some(place.op);
        }
        // An image from before a stop may show a switch that the mechanism has left since.
        let is_new = self.image.valid && self.image.under >= self.output.number;
        (!is_new).then(|| self.place(&self.marking.tokens[0]).op)
    }

    /// A station that must agree and has a request open: the own one is not made, and is to be commanded again.
    pub(crate) fn waits_behind_request(&mut self, entered: PeerSet) -> bool {
        let asks = entered.iter().find(|&peer| self.views.peers[peer].request.is_some());
        let by = asks.map(|peer| self.views.peers[peer].station);
        if let Some(by) = by {
            self.agreement.refusal = Some(AgreementRefusal { by, in_the_way: None, ops: 0 });
        }
        by.is_some()
    }
}
