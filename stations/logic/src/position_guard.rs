//! Measurements required for a motion, compiled from the conflicts of the line (see [`crate::PositionGuard`]).

use linewright_line::net::Block;
use linewright_line::{ClearanceInputs, Line, OpId, StateSpan, Station, StationId};

/// Measurements required for a motion to start and to go on, for one conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionGuard {
    /// The conflict, as an index into the line's.
    pub conflict: u16,
    /// The other station, as an index into the program's peers.
    pub peer: u16,
    /// Its inputs while it is outside its state. None where no switches measure that: then there are the counts alone, which
    /// must be of one generation.
    pub clear: Option<ClearanceInputs>,
    /// Place of the motion relative to this station's own state.
    pub own: OwnSide,
    /// By a motion of this block of the operation this station leaves its state.
    pub(crate) leaves: Option<Block>,
}

/// Place of a motion relative to this station's own state of a conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnSide {
    Inside,
    /// Outside, while these own inputs hold.
    Outside(ClearanceInputs),
    /// Outside by the chart; no own switches measure it.
    OutsideByChart,
}

/// Knowledge of a station about one conflict at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionsKnown {
    /// Its own image; none where its devices do not vouch for it.
    pub own: Option<u128>,
    /// Its axes stand by the chart.
    pub is_placed: bool,
    /// The other station's image; none where it is not received, not valid, or too old.
    pub other: Option<u128>,
    /// Both stations' counts may be compared.
    pub counts: bool,
}

impl PositionGuard {
    /// Whether the motion may start and go on.
    pub fn holds(&self, known: PositionsKnown) -> bool {
        self.is_outside(known) || self.clear.map_or(known.counts, |clear| measures(known.other, clear))
    }

    /// The images without the switches that contradict, for callers that break this rule.
    pub(crate) fn uncontradicted(&self, known: PositionsKnown) -> PositionsKnown {
        let own = if let OwnSide::Outside(clear) = self.own { clear.off } else { 0 };
        let other = self.clear.map_or(0, |clear| clear.off);
        let without = |image: Option<u128>, bits: u128| image.map(|image| image & !bits);
        PositionsKnown { own: without(known.own, own), other: without(known.other, other), ..known }
    }

    /// Whether the motion is outside this station's own state, so that it does not rely on the other station.
    pub(crate) fn is_outside(&self, known: PositionsKnown) -> bool {
        match self.own {
            OwnSide::Inside => false,
            OwnSide::Outside(clear) => measures(known.own, clear),
            OwnSide::OutsideByChart => known.is_placed,
        }
    }
}

fn measures(image: Option<u128>, clear: ClearanceInputs) -> bool {
    image.is_some_and(|image| clear.hold(image))
}

/// The guards of a station's motions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interlocks {
    guards: Vec<PositionGuard>,
    /// Range of the guards of each operation.
    of_operation: Vec<(u16, u16)>,
    /// Range of those of all motions of each recovery path.
    of_path: Vec<(u16, u16)>,
    /// Own inputs that another station's guards read: a change of one is reported at once.
    pub read_by_others: u128,
    /// Whether switches on both sides measure every conflict of this station.
    pub covers: bool,
}

/// The other stations that share a conflict with this one.
pub(crate) fn partners(line: &Line, station: StationId) -> impl Iterator<Item = StationId> + '_ {
    line.conflicts.iter().filter_map(move |conflict| match (conflict.a.station, conflict.b.station) {
        (a, b) if a == station => Some(b),
        (a, b) if b == station => Some(a),
        _ => None,
    })
}

impl Interlocks {
    pub fn of(line: &Line, station: StationId, peers: &[StationId], paths: &[OpId]) -> Self {
        let described = line.station(station);
        let mut interlocks = Interlocks { covers: true, ..Interlocks::default() };
        let mut sides = Vec::new();
        for (nth, conflict) in line.conflicts.iter().enumerate() {
            let (own, other) = match (&conflict.a, &conflict.b) {
                (a, b) if a.station == station => (a, b),
                (a, b) if b.station == station => (b, a),
                _ => continue,
            };
            let Some(peer) = peers.iter().position(|&peer| peer == other.station) else { continue };
            let own_clear = line.clearance(own).ok();
            interlocks.read_by_others |= own_clear.map_or(0, ClearanceInputs::all);
            let clear = line.clearance(other).ok();
            // No counts keep tasks apart: where no switches measure the other one, there is nothing to check.
            if clear.is_none() && described.is_task_driven() {
                continue;
            }
            interlocks.covers &= clear.is_some() && own_clear.is_some();
            sides.push(ConflictSide { conflict: nth as u16, peer: peer as u16, clear, own, own_clear });
        }
        for op in described.op_ids() {
            let range = interlocks.add(sides.iter().map(|side| side.guard(described, op)));
            interlocks.of_operation.push(range);
        }
        // On a recovery path axes may be anywhere on their way, so a path that begins inside a state stays inside to its end.
        for &failed in paths {
            let range = interlocks.add(sides.iter().filter_map(|side| side.guard_of_path(described, failed)));
            interlocks.of_path.push(range);
        }
        interlocks
    }

    fn add(&mut self, guards: impl Iterator<Item = PositionGuard>) -> (u16, u16) {
        let start = self.guards.len() as u16;
        self.guards.extend(guards);
        (start, self.guards.len() as u16)
    }

    fn range(&self, (start, end): (u16, u16)) -> &[PositionGuard] {
        &self.guards[usize::from(start)..usize::from(end)]
    }

    pub fn of_operation(&self, op: OpId) -> &[PositionGuard] {
        self.range(self.of_operation[op.index()])
    }

    /// The inputs of a peer that any guard reads.
    pub fn read_of(&self, peer: usize) -> u128 {
        let of_peer = self.guards.iter().filter(|guard| usize::from(guard.peer) == peer);
        of_peer.filter_map(|guard| guard.clear).fold(0, |bits, clear| bits | clear.all())
    }

    pub fn of_path(&self, path: usize) -> &[PositionGuard] {
        self.range(self.of_path[path])
    }
}

/// One conflict as this station sees it.
struct ConflictSide<'a> {
    conflict: u16,
    peer: u16,
    clear: Option<ClearanceInputs>,
    own: &'a StateSpan,
    own_clear: Option<ClearanceInputs>,
}

impl ConflictSide<'_> {
    fn guard(&self, station: &Station, op: OpId) -> PositionGuard {
        let inside = station.steps_of_span(self.own);
        let step = station.step_of(op);
        let own = match self.own_clear {
            _ if inside.contains(&step) => OwnSide::Inside,
            Some(clear) => OwnSide::Outside(clear),
            None => OwnSide::OutsideByChart,
        };
        // In a state of one step the same motion may lead in as well as out.
        let leaves = match (&inside[..], station.step_of(op)) {
            (&[first, .., _], step) if step == first => Some(Block::Recovery),
            (&[_, .., last], step) if step == last => Some(Block::Normal),
            _ => None,
        };
        PositionGuard { conflict: self.conflict, peer: self.peer, clear: self.clear, own, leaves }
    }

    fn guard_of_path(&self, station: &Station, failed: OpId) -> Option<PositionGuard> {
        let inside = station.steps_of_span(self.own).contains(&station.step_of(failed));
        let (conflict, peer, clear) = (self.conflict, self.peer, self.clear);
        inside.then_some(PositionGuard { conflict, peer, clear, own: OwnSide::Inside, leaves: None })
    }
}
