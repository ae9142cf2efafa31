//! *Resume*: one button at a console under which every operation that was stopped before its end goes on.
//!
//! It acts in manual only, on stations whose panel is the console's: manual was commanded, the selector of the station stands at
//! auto, and no button of its panel is down. There it is *advance* held at the panel, for a stopped motion forward and for nothing
//! else. Nothing begins by it, nothing turns round, and on a recovery path nothing moves: a station ends what it was stopped in.
//!
//! Why outputs may be energised by it: each transition it fires is one that *advance* would fire in the same state, behind the
//! same fault signals, interlocks and rests. A person holds it; let go, late or lost it ends like any button, and the motion with
//! it. Since one finger starts several stations at once, more is asked than at a panel, where a person sees the one mechanism:
//!
//! * The station knows its place: confirmed, read off the switches or following from such, and no position is lost.
//! * Inside its state of a conflict it moves only while the other station is received, has its position, and is outside its own
//!   state by its marking. A station does not enter a state by *resume*, as no operation begins by it. So two stations that both
//!   stand inside do not start on the same message.
//! * Positions are measured clear. That the other stands is not enough, as it is for *advance* out of a state.
//! * An operation goes on once while it is held. What a fault stops then stays stopped.

use linewright_line::OpId;
use linewright_line::net::{Block, MotionStage, StationPlace};

use crate::controller::Controller;
use crate::program::bit;

impl Controller {
    /// The levels change.
    pub(crate) fn follow_resume(&mut self, levels: u128) {
        if levels & bit::RESUME == 0 {
            self.resumed = 0;
        }
    }

    /// An operation goes on, by whichever button.
    pub(crate) fn note_resumed(&mut self, op: OpId) {
        if self.levels.now & bit::RESUME != 0 {
            self.resumed |= 1 << op.0;
        }
    }

    /// *Advance* as a token sees it while resume is held: pressed where its operation may go on, held while it does.
    pub(crate) fn resume_bits(&self, index: usize) -> u128 {
        let place = self.place(&self.marking.tokens[index]);
        let has_gone_on = self.resumed & (1 << place.op.0) != 0;
        match (place.block, place.stage) {
            (Block::Normal, MotionStage::Operating) if has_gone_on => bit::ADVANCE,
            (Block::Normal, MotionStage::Incomplete) if !has_gone_on && self.may_be_resumed(place.op) => {
                bit::ADVANCE | bit::edges(bit::ADVANCE)
            }
            _ => 0,
        }
    }

    pub(crate) fn may_be_resumed(&self, op: OpId) -> bool {
        self.marking.path.is_none() && self.is_placed() && self.others_are_outside(op) && self.is_measured_clear(op)
    }

    /// Whether of each conflict in whose state an operation is the other station is outside, by its marking.
    fn others_are_outside(&self, op: OpId) -> bool {
        let mut spans = self.program.spans.iter().filter(|spans| spans.own & (1 << op.0) != 0);
        spans.all(|spans| {
            let peer = usize::from(spans.peer);
            let view = &self.views.peers[peer];
            self.views.is_heard(peer, self.now) && !view.position_lost && spans.is_left_by(view)
        })
    }

    fn is_measured_clear(&self, op: OpId) -> bool {
        let mut guards = self.program.guards(StationPlace::operating(op), None);
        !self.rules.positions || guards.all(|(guard, _)| guard.holds(self.positions_known(&guard)))
    }
}
