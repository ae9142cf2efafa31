//! Taking a count back: only by agreement, and before the motion starts.
//!
//! A command that would take counts back does not fire at once. It opens a request under a fresh number, and fires when
//! every station with an arrow from one of the operations has agreed to *that* number — provided its button is still
//! held, the mode is the same and the token has not moved. The count goes back in the same step in which the recovery
//! motion starts, so no station can start on it while the mechanism is already moving back.
//!
//! Numbers are kept across restarts and never used twice: with reused numbers a stale agreement to a request that
//! was given up could be taken for an agreement to a later one.

use linewright_line::BRANCHES_MAX;
use linewright_line::net::ControlMode;

use crate::controller::Controller;
use crate::event::HappeningKind;
use crate::parts::{AgreementRefusal, PendingAgreement};
use crate::peer_set::PeerSet;
use crate::program::bit;
use crate::report::AgreementRequest;

/// State of a request for agreement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AgreementState {
    Waiting,
    Agreed,
    /// A station has started on a count, or moves: refused.
    NotAgreed(AgreementRefusal),
    /// The command does not stand any more.
    GivenUp,
}

impl Controller {
    /// The peers that could start after one of these operations. A peer of another generation compares with none of them;
    /// where the second barrier stands between the two, it is not asked.
    pub(crate) fn dependents(&self, ops: u64, mode: ControlMode) -> PeerSet {
        let built_on = self.program.dependents.iter().enumerate().filter(|&(op, _)| ops & (1 << op) != 0);
        let all = built_on.fold(PeerSet::EMPTY, |all, (_, &peers)| all | peers);
        all.filtered(|peer| !self.views.positions_stand_in(peer, mode, self.now))
    }

    /// Fires the transitions of these rows, or requests the agreement they need. Neighbours that go back together are
    /// one request: none of them moves before all may.
    pub(crate) fn act(&mut self, rows: &[u16], mode: ControlMode) -> bool {
        let asks = self.rules.ask && self.rules.arrows;
        let needs = if asks { self.to_be_asked(rows, mode) } else { PeerSet::EMPTY };
        let mut entered = PeerSet::EMPTY;
        let mut fired = false;
        let (mut asked, mut count) = ([0; BRANCHES_MAX], 0);
        for &number in rows {
            let row = self.program.rows[number as usize];
            let of_row = self.entered_by(&row, mode);
            if (row.withdraws && !needs.is_empty()) || !of_row.is_empty() {
                entered = entered | of_row;
                asked[count] = number;
                count += 1;
            } else {
                self.fire(row.transition);
                fired = true;
            }
        }
        // One request at a time: a command given while another waits is given too early.
        let may_ask = count != 0 && self.agreement.pending.is_none() && (needs.is_empty() || self.can_agree(needs));
        if may_ask && !self.waits_behind_request(entered) {
            self.ask(&asked[..count], mode, needs, entered);
        }
        fired
    }

    /// The peers that must agree before these rows take counts back.
    fn to_be_asked(&self, rows: &[u16], mode: ControlMode) -> PeerSet {
        let rows = rows.iter().map(|&row| &self.program.rows[row as usize]).filter(|row| row.withdraws);
        rows.fold(PeerSet::EMPTY, |needs, row| {
            needs | self.dependents(self.taken_back(self.program.actions[row.transition as usize].kind), mode)
        })
    }

    /// Whether this station and these peers could compare counts: without a common generation none agrees, or ever will.
    fn can_agree(&self, needs: PeerSet) -> bool {
        if self.rules.generations && self.views.generation == 0 {
            return false;
        }
        needs.iter().all(|peer| {
            self.views.standing(peer, self.counts.cycle, self.now) != crate::views::Comparability::OtherGeneration
        })
    }

    /// Opens a request for these rows. Those of one step (concurrent neighbours) are one request.
    fn ask(&mut self, rows: &[u16], mode: ControlMode, needs: PeerSet, entered: PeerSet) {
        let number = self.agreement.next_request;
        if self.rules.fresh_numbers {
            self.agreement.next_request += 1;
        }
        let mut pending = PendingAgreement {
            request: AgreementRequest { number, ops: 0 },
            rows: [0; BRANCHES_MAX],
            count: 0,
            hold: 0,
            mode,
            needs,
            entered,
        };
        for &number in rows {
            let row = self.program.rows[usize::from(number)];
            pending.rows[pending.count] = number;
            pending.count += 1;
            if row.withdraws {
                pending.request.ops |= self.taken_back(self.program.actions[row.transition as usize].kind);
            }
            pending.hold |= bit::levels(row.need);
        }
        // Under *resume* no panel's *advance* is held; it stands for it.
        if self.levels.now & bit::RESUME != 0 && pending.hold & !self.levels.now == bit::ADVANCE {
            pending.hold ^= bit::ADVANCE | bit::RESUME;
        }
        self.agreement.pending = Some(pending);
        self.agreement.refusal = None;
        self.due.report = true;
        self.note(HappeningKind::Asked(number));
    }

    /// Closes a request that is refused.
    pub(crate) fn reject(&mut self, pending: &PendingAgreement, refusal: AgreementRefusal) {
        if let AgreementRefusal { by, in_the_way: Some(in_the_way), .. } = refusal {
            self.note(HappeningKind::NotAgreed { by, in_the_way });
        }
        self.note(HappeningKind::Refused);
        self.agreement.refusal = Some(refusal);
        self.due.report = true;
        // A refused command is to be given again: held on, it would repeat the request with every message.
        self.commands.disarm(pending.hold);
        self.levels.now &= !pending.hold;
        self.levels.before &= !pending.hold;
    }

    /// State of the open request.
    pub(crate) fn standing(&self, pending: &PendingAgreement, levels: u128, mode: ControlMode) -> AgreementState {
        if mode != pending.mode || levels & pending.hold != pending.hold || !self.image.valid {
            return AgreementState::GivenUp;
        }
        // What a motion relies on may have changed since the request: a station that was not asked may have lost its generation.
        let entered = self.entered_now(pending);
        if let Some(peer) = entered.iter().find(|&peer| !pending.entered.contains(peer)) {
            let by = self.views.peers[peer].station;
            return AgreementState::NotAgreed(AgreementRefusal { by, in_the_way: None, ops: 0 });
        }
        let mut missing = false;
        for (index, view) in self.views.peers.iter().enumerate() {
            // What has another generation since was answered by positions, or not at all.
            let is_by_counts = self.views.shares_generation(index);
            if !pending.needs.contains(index) && !entered.contains(index) {
                continue;
            }
            match view.verdict.filter(|_| is_by_counts != entered.contains(index)) {
                Some((boot, number, None)) if boot == self.boot_id && number == pending.request.number => {
                    // "Unknown" blocks here too, though the answer itself could not have changed.
                    missing |= self.now >= view.known_until;
                }
                Some((boot, number, Some(in_the_way))) if boot == self.boot_id && number == pending.request.number => {
                    let ops = if entered.contains(index) { 0 } else { pending.request.ops };
                    let (by, in_the_way) = (view.station, Some(in_the_way));
                    return AgreementState::NotAgreed(AgreementRefusal { by, in_the_way, ops });
                }
                Some(_) | None => missing = true,
            }
        }
        if missing { AgreementState::Waiting } else { AgreementState::Agreed }
    }
}
