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
use crate::parts::PendingWithdrawal;
use crate::peer_set::PeerSet;
use crate::report::WithdrawalRequest;

/// State of a withdrawal request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WithdrawalState {
    Waiting,
    Agreed,
    /// A station has started on a count: refused.
    NotAgreed,
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

    /// Opens a request for the rows that take counts back. Those of one step (concurrent neighbours) are one request.
    pub(crate) fn ask(&mut self, rows: &[u16], mode: ControlMode) {
        let number = self.agreement.next_request;
        if self.rules.fresh_numbers {
            self.agreement.next_request += 1;
        }
        let mut pending = PendingWithdrawal {
            request: WithdrawalRequest { number, ops: 0 },
            rows: [0; BRANCHES_MAX],
            count: 0,
            hold: 0,
            mode,
            needs: PeerSet::EMPTY,
        };
        for &number in rows {
            let row = self.program.rows[usize::from(number)];
            if row.withdraws {
                pending.rows[pending.count] = number;
                pending.count += 1;
                pending.request.ops |= self.taken_back(self.program.actions[row.transition as usize].kind);
                pending.hold |= crate::program::bit::levels(row.need);
            }
        }
        pending.needs = self.dependents(pending.request.ops, mode);
        self.agreement.pending = Some(pending);
        self.due.report = true;
        self.note(HappeningKind::Asked(number));
    }

    /// State of the open request. A refusal closes it and names the station in the way.
    pub(crate) fn standing(&mut self, pending: &PendingWithdrawal, levels: u128, mode: ControlMode) -> WithdrawalState {
        if mode != pending.mode || levels & pending.hold != pending.hold || !self.image.valid {
            return WithdrawalState::GivenUp;
        }
        let mut missing = false;
        for (index, view) in self.views.peers.iter().enumerate() {
            if !pending.needs.contains(index) {
                continue;
            }
            match view.verdict {
                Some((boot, number, None)) if boot == self.boot_id && number == pending.request.number => {
                    // "Unknown" blocks here too, though the answer itself could not have changed.
                    missing |= self.now >= view.known_until;
                }
                Some((boot, number, Some(in_the_way))) if boot == self.boot_id && number == pending.request.number => {
                    let by = view.station;
                    self.note(HappeningKind::NotAgreed { by, in_the_way });
                    self.note(HappeningKind::Refused);
                    self.agreement.refusal = Some((by, in_the_way, pending.request.ops));
                    return WithdrawalState::NotAgreed;
                }
                Some(_) | None => missing = true,
            }
        }
        if missing { WithdrawalState::Waiting } else { WithdrawalState::Agreed }
    }
}
