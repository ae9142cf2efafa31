//! Motions that rely on measured positions alone: one station at a time, by agreement.
//!
//! In manual, stations without a generation in common are kept apart by measured positions (see `interlock`). Each report of a
//! position is some time old, so two stations whose buttons are pressed together would each see the other outside its state of a
//! conflict, and both start. So such a motion does not start on the press. The station makes a request, as for counts that it
//! takes back (see `withdraw`), and starts when each station concerned has agreed to that very number.
//!
//! A station agrees if none of its motions relies on the position of the other one, once it has stood for as long as an image is
//! valid and its input image was taken after its outputs went off. Of two requests that cross, that of the station listed first stands: the other station closes its own and agrees.
//! From the moment it sees a request until it sees that it is closed, a station makes none itself.
//!
//! Why two stations never start together by it: the second one needs the agreement of the first. The first gives none while its own
//! request is open, and none while it moves, and both are its own present state, whatever messages are on their way and whatever
//! the second one remembers. What has stopped on its way is measured there in the image that the agreement waits for. A station
//! that is restarted has no request, an answer names the life that made the request, and an image under the outputs of an earlier
//! life, which a gateway may still put out, is none to agree by.
//!
//! A motion by order, beside a station in manual by itself, asks for no agreement: there the tokens of the activity keep the two apart.

use linewright_line::OpId;
use linewright_line::net::{ControlMode, MotionStage, StationPlace, TransitionKind};

use crate::controller::Controller;
use crate::parts::{AgreementRefusal, PendingAgreement};
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

    /// Answers requests of peers with which no counts are compared. One that this station can agree to only when it is measured at
    /// its standstill is answered then.
    pub(crate) fn answer_entries(&mut self) {
        for peer in self.views.unanswered().iter() {
            let view = &self.views.peers[peer];
            let (by, Some(request)) = (view.station, view.request) else { continue };
            let crosses = self.agreement.pending.filter(|pending| self.enters_beside(pending, peer));
            if let Some(pending) = crosses.filter(|_| by < self.program.station) {
                // It is closed before the agreement is given: both are in one report.
                self.agreement.pending = None;
                self.reject(&pending, AgreementRefusal { by, in_the_way: None, ops: 0 });
            }
            let in_the_way = self.moves_against(peer);
            if in_the_way.is_some() || self.is_measured_at_rest() {
                self.views.answer(peer, request, in_the_way);
                self.due.report = true;
            }
        }
    }

    /// Whether the motions that a request is for rely on the position of a peer: as it was made, or now.
    fn enters_beside(&self, pending: &PendingAgreement, peer: usize) -> bool {
        pending.entered.contains(peer) || self.entered_now(pending).contains(peer)
    }

    /// The peers that must agree before the motions start which a request is for.
    pub(crate) fn entered_now(&self, pending: &PendingAgreement) -> PeerSet {
        let rows = pending.rows().iter().map(|&row| &self.program.rows[usize::from(row)]);
        rows.fold(PeerSet::EMPTY, |all, row| all | self.entered_by(row, pending.mode))
    }

    /// The operation that keeps a peer from starting by measured positions: one that moves, or that a request is open for.
    fn moves_against(&self, peer: usize) -> Option<OpId> {
        if let Some(pending) = self.agreement.pending.filter(|pending| self.enters_beside(pending, peer)) {
            let row = &self.program.rows[usize::from(pending.rows[0])];
            let to = self.program.actions[usize::from(row.transition)].to[0];
            return Some(self.program.places[usize::from(to)].place.op);
        }
        let relies = |place: &StationPlace| self.relied_on(*place, self.marking.path).contains(peer);
        let homed = self.homes().map(StationPlace::operating);
        self.marking().chain(homed).find(relies).map(|place| place.op)
    }

    /// Whether it stands, and its input image shows where. An image from before a stop may show a switch that the mechanism has left
    /// since; on a bus of its own, and of a drive that coasts, it may for as long as an image is valid. One under the outputs of an
    /// earlier life may be under motions of that.
    fn is_measured_at_rest(&self) -> bool {
        let has_stood = !self.rules.timely || self.now >= self.output.stood_at + self.stale;
        self.image.valid && self.image.under >= self.output.number && !self.output.moves && has_stood
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
