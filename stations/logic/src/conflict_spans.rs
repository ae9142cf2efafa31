//! The two states of each conflict of a station, by markings.
//!
//! A second look at what the counts keep apart: whether this station is in its state of a conflict, and whether the other one is,
//! by what it reports of its marking. Measured positions are a third (see `interlock`).

use linewright_line::net::{Block, MotionStage, StationPlace};
use linewright_line::{Line, OpId, StateSpan, StationId};

use crate::views::PeerView;

/// One conflict of a station.
#[derive(Clone, Debug)]
pub(crate) struct ConflictSpans {
    pub conflict: u16,
    /// The other station, as an index into the program's peers.
    pub peer: u16,
    /// Own operations in this station's state, a bit each.
    pub own: u64,
    /// The other's operations in its state, a bit each; those it begins with; those it ends with.
    inside: u64,
    first: u64,
    last: u64,
}

impl ConflictSpans {
    pub fn of(line: &Line, station: StationId, peers: &[StationId]) -> Vec<Self> {
        let sides = line.conflicts.iter().enumerate().filter_map(|(nth, conflict)| {
            let (own, other) = match (&conflict.a, &conflict.b) {
                (a, b) if a.station == station => (a, b),
                (a, b) if b.station == station => (b, a),
                _ => return None,
            };
            let peer = peers.iter().position(|&peer| peer == other.station)?;
            let [inside, first, last] = operations_of(line, other);
            let own = operations_of(line, own)[0];
            Some(ConflictSpans { conflict: nth as u16, peer: peer as u16, own, inside, first, last })
        });
        sides.collect()
    }

    /// Whether the other's marking is outside its state. One that is not known is not, nor is one on a recovery path.
    pub fn is_left_by(&self, view: &PeerView) -> bool {
        let mut marked = view.places.iter().enumerate().filter(|&(_, &number)| number != 0).peekable();
        let is_outside = |(op, &number): (usize, &u8)| {
            let has = |ops: u64| ops & (1 << op) != 0;
            StationPlace::from_number(OpId::at(op), number).is_some_and(|place| match (place.stage, place.block) {
                _ if !has(self.inside) => true,
                (MotionStage::Completed, Block::Normal) => has(self.last),
                (MotionStage::Completed, Block::Recovery) => has(self.first),
                (MotionStage::Operating | MotionStage::Incomplete, _) => false,
            })
        };
        !view.recovering_home && marked.peek().is_some() && marked.all(is_outside)
    }
}

/// The operations of a state, those it begins with and those it ends with, a bit each.
fn operations_of(line: &Line, span: &StateSpan) -> [u64; 3] {
    let station = line.station(span.station);
    let steps = station.steps_of_span(span);
    let ops = |within: &dyn Fn(usize) -> bool| {
        let ops = station.op_ids().filter(|&op| within(station.step_of(op)));
        ops.fold(0, |bits, op| bits | 1u64 << op.0)
    };
    [
        ops(&|step| steps.contains(&step)),
        ops(&|step| steps.first() == Some(&step)),
        ops(&|step| steps.last() == Some(&step)),
    ]
}
