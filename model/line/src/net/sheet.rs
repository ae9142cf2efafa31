//! Where the nodes and arcs of a station's net are drawn.
//!
//! A column for each step of the cycle, a row for each operation of a step; in it the modules of the published figures (seed 002,
//! Figures 12, 13 and 20), N above F:
//!
//! ```text
//!        p2                 t1, t2 between p1 and p2, t3 between p1 and p3, t4 between p3 and p4, t5 between p2 and p4,
//!   p1        p3            t6, t7 between p4 and p5, t8 between p4 and p6, t9 between p6 and p1, t10 between p5 and p1
//!   p6        p4
//!        p5
//! ```
//!
//! What joins two neighbouring columns (t11, t12) stands between them. What joins others has a lane of its own: t11 above the
//! columns, everything else below them. Only geometry: units are those of a drawing, x to the right, y downwards.

use std::collections::BTreeSet;

use linewright_nets::Net;

use crate::net::connect::{StationTransition, TransitionKind};
use crate::net::module::{Block, MotionStage, StationPlace};
use crate::net::station::StationNet;
use crate::{Line, Station, StationId};

/// Radius of a place, and half the larger side of a transition.
pub const NODE_RADIUS: f64 = 9.0;

/// A point of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetPoint {
    pub x: f64,
    pub y: f64,
}

/// An arc from node to node; straight between the points.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetArc {
    /// Index of the place.
    pub place: usize,
    /// Index of the transition.
    pub transition: usize,
    /// From the transition to the place.
    pub is_output: bool,
    /// Bends, from the place to the transition.
    pub bends: Vec<SheetPoint>,
}

/// A station's net with a point for every node.
#[derive(Clone, Debug, PartialEq)]
pub struct NetSheet {
    /// Width and height; everything is within.
    pub size: SheetPoint,
    /// Of each place of the net.
    pub places: Vec<SheetPoint>,
    /// Of each transition of the net.
    pub transitions: Vec<SheetPoint>,
    pub arcs: Vec<SheetArc>,
    /// The upper left corner of each operation's module.
    pub modules: Vec<SheetPoint>,
}

/// Of a ring: room of a place on it; distances of a transition from its chord that are tried, and how many places along it.
const RING_PLACE: f64 = 260.0;
const RING_BESIDE: [f64; 5] = [14.0, 24.0, 34.0, 46.0, 60.0];
const RING_SHARES: u32 = 16;
/// From one column to the next.
const COLUMN: f64 = 320.0;
/// From one row to the next.
const ROW: f64 = 280.0;
/// Between the edge and the modules.
const MARGIN: f64 = 60.0;
/// Height of a lane.
const LANE: f64 = 26.0;
/// Room above a row for the name of its operation.
const NAME: f64 = 30.0;
/// From the left edge of a column to the transitions between it and the next one.
const GUTTER: f64 = 275.0;
/// From the left edge of a column to its modules.
const INDENT: f64 = 40.0;
/// From the places at a side to the verticals of the lanes, and the room that these have.
const SIDE: (f64, f64) = (16.0, 44.0);

impl NetSheet {
    /// Draws the net of a station.
    pub fn of(line: &Line, station: StationId, net: &StationNet) -> Self {
        let described = line.station(station);
        let lanes = Lanes::of(described, net.transitions());
        let modules: Vec<SheetPoint> = described.op_ids().map(|op| module(described, op, lanes.above())).collect();
        let columns = described.steps.len() as f64;
        let rows = described.steps.iter().map(Vec::len).max().unwrap_or(1) as f64;
        let bottom = MARGIN + lanes.above() + rows * ROW;
        let places: Vec<SheetPoint> =
            net.places().iter().map(|&place| modules[place.op.index()] + within_module(place)).collect();
        let mut sheet = NetSheet {
            size: SheetPoint { x: 2.0 * MARGIN + columns * COLUMN - INDENT, y: bottom + lanes.below() + MARGIN },
            places,
            transitions: Vec::with_capacity(net.transitions().len()),
            arcs: Vec::new(),
            modules,
        };
        for (number, transition) in net.transitions().iter().enumerate() {
            let ends: Vec<(usize, bool)> = [(&transition.from, false), (&transition.to, true)]
                .into_iter()
                .flat_map(|(places, is_output)| places.iter().map(move |&place| (place, is_output)))
                .filter_map(|(place, is_output)| Some((net.place_index(place)?, is_output)))
                .collect();
            let lane = lanes.of[number].map(|lane| match lane {
                Lane::Above(nth) => (MARGIN + LANE * nth as f64, nth),
                Lane::Below(nth) => (bottom + LANE * (nth as f64 + 0.5), nth + lanes.counts.0),
            });
            match lane {
                Some((y, nth)) => sheet.in_lane(net, (number, y), nth as f64 / lanes.count() as f64, &ends),
                None => sheet.between(described, transition, number, &ends),
            }
        }
        sheet
    }

    /// Draws a net in which every transition leads from one place to another one: the places in a ring, the transitions on its
    /// chords. Of up to six places nothing touches. `None` for another net.
    pub fn ring(net: &Net) -> Option<Self> {
        let count = net.place_count() as f64;
        let radius = (RING_PLACE * count / std::f64::consts::TAU).max(RING_PLACE);
        let edge = 2.0 * MARGIN + 2.0 * radius;
        let places: Vec<SheetPoint> = (0..net.place_count())
            .map(|number| {
                let angle = std::f64::consts::TAU * (number as f64 / count - 0.25);
                SheetPoint { x: edge / 2.0 + radius * angle.cos(), y: edge / 2.0 + radius * angle.sin() }
            })
            .collect();
        let mut sheet = NetSheet {
            size: SheetPoint { x: edge, y: edge },
            places,
            transitions: Vec::with_capacity(net.transition_count()),
            arcs: Vec::new(),
            modules: Vec::new(),
        };
        for (number, t) in net.transitions().enumerate() {
            let ([(from, _)], [(to, _)]) = (net.preset(t), net.postset(t)) else { return None };
            let (from, to) = (from.index(), to.index());
            let (a, b) = (sheet.places[from], sheet.places[to]);
            if from == to {
                return None;
            }
            let at = sheet.on_chord((from, a), (to, b));
            sheet.transitions.push(at);
            let arc = |place, is_output| SheetArc { place, transition: number, is_output, bends: Vec::new() };
            sheet.arcs.extend([arc(from, false), arc(to, true)]);
        }
        Some(sheet)
    }

    /// A point beside a chord at which neither the transition nor its arcs touch what is drawn already, if there is one. It is to the
    /// right of the way, so that a transition and its opposite stand beside each other.
    fn on_chord(&self, (from, a): (usize, SheetPoint), (to, b): (usize, SheetPoint)) -> SheetPoint {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let long = dx.hypot(dy);
        let candidate = |beside: f64, share: f64| {
            a + SheetPoint { x: dx * share - dy / long * beside, y: dy * share + dx / long * beside }
        };
        let is_free = |at: &SheetPoint| {
            let others = self.places.iter().enumerate().filter(|&(place, _)| place != from && place != to);
            let others = others.map(|(_, other)| other).chain(&self.transitions);
            let mut arcs = self.arcs.iter().map(|arc| (self.places[arc.place], self.transitions[arc.transition]));
            let clear = |other: &SheetPoint| [a, b].iter().all(|&end| other.distance((end, *at)) > NODE_RADIUS + 1.0);
            let apart = |other: &SheetPoint| other.distance((*at, *at)) > 2.0 * NODE_RADIUS + 1.0;
            others.clone().all(|other| clear(other) && apart(other))
                && [a, b].iter().all(apart)
                && arcs.all(|arc| at.distance(arc) > NODE_RADIUS + 1.0)
        };
        let shares = || (0..=RING_SHARES).map(|nth| 0.3 + 0.4 * f64::from(nth) / f64::from(RING_SHARES));
        let mut candidates = RING_BESIDE.iter().flat_map(|&beside| shares().map(move |share| candidate(beside, share)));
        candidates.find(is_free).unwrap_or_else(|| candidate(RING_BESIDE[0], 0.3))
    }

    fn between(&mut self, station: &Station, transition: &StationTransition, number: usize, ends: &[(usize, bool)]) {
        let at = match within(transition.kind) {
            Some((op, at)) => (self.modules[op.index()] + at, false),
            None => {
                let count = ends.len() as f64;
                let y = ends.iter().map(|&(place, _)| self.places[place].y).sum::<f64>() / count;
                let columns = transition.from.iter().chain(&transition.to).map(|place| station.step_of(place.op));
                let left = columns.min().unwrap_or_default() as f64;
                (SheetPoint { x: MARGIN + left * COLUMN + GUTTER, y }, true)
            }
        };
        let (at, is_in_gutter) = at;
        self.transitions.push(at);
        // Out of its module first, where rows are at other heights.
        let bends = |place: SheetPoint| {
            let x = if place.x < at.x { place.x + SIDE.0 } else { place.x - SIDE.0 };
            (is_in_gutter && place.y != at.y).then_some(SheetPoint { x, y: place.y }).into_iter().collect()
        };
        self.arcs.extend(ends.iter().map(|&(place, is_output)| SheetArc {
            place,
            transition: number,
            is_output,
            bends: bends(self.places[place]),
        }));
    }

    /// Verticals beside the columns lead to the lane. `share` of the room beside a column, 0 to 1, is this lane's.
    fn in_lane(&mut self, net: &StationNet, (number, y): (usize, f64), share: f64, ends: &[(usize, bool)]) {
        let beside = |place: usize| {
            let out = SIDE.0 + SIDE.1 * share;
            let at = self.places[place];
            let module = self.modules[net.places()[place].op.index()];
            let x = if at.x <= module.x { module.x - out } else { module.x + RIGHT + out };
            SheetPoint { x, y: at.y }
        };
        let verticals: Vec<SheetPoint> = ends.iter().map(|&(place, _)| beside(place)).collect();
        let x = beside_verticals(verticals.iter().map(|at| at.x).sum::<f64>() / verticals.len() as f64);
        self.arcs.extend(ends.iter().zip(verticals).map(|(&(place, is_output), corner)| SheetArc {
            place,
            transition: number,
            is_output,
            bends: vec![corner, SheetPoint { x: corner.x, y }],
        }));
        self.transitions.push(SheetPoint { x, y });
    }
}

/// x of the right places of a module.
const RIGHT: f64 = 150.0;

/// The x next to `x` at which no vertical of any lane runs: these are within [`SIDE`] of a module, so its middle and the gutter
/// between two columns are free.
fn beside_verticals(x: f64) -> f64 {
    let middle = |free: f64| MARGIN + free + ((x - MARGIN - free) / COLUMN).round().max(0.0) * COLUMN;
    let (module, gutter) = (middle(INDENT + RIGHT / 2.0), middle(GUTTER));
    if (x - module).abs() <= (x - gutter).abs() { module } else { gutter }
}

/// The upper left corner of an operation's module, at the height of p2.
fn module(station: &Station, op: crate::OpId, above: f64) -> SheetPoint {
    let step = station.step_of(op);
    let row = station.steps[step].iter().position(|&of| of == op).unwrap_or_default();
    SheetPoint { x: MARGIN + step as f64 * COLUMN + INDENT, y: MARGIN + above + NAME + row as f64 * ROW }
}

fn within_module(place: StationPlace) -> SheetPoint {
    let (x, y) = match (place.block, place.stage) {
        (Block::Normal, MotionStage::Operating) => (0.0, 60.0),
        (Block::Normal, MotionStage::Incomplete) => (75.0, 0.0),
        (Block::Normal, MotionStage::Completed) => (RIGHT, 60.0),
        (Block::Recovery, MotionStage::Completed) => (0.0, 150.0),
        (Block::Recovery, MotionStage::Operating) => (RIGHT, 150.0),
        (Block::Recovery, MotionStage::Incomplete) => (75.0, 210.0),
    };
    SheetPoint { x, y }
}

/// The place in its module of a transition of one operation.
fn within(kind: TransitionKind) -> Option<(crate::OpId, SheetPoint)> {
    let (op, x, y) = match kind {
        TransitionKind::Stop(op, Block::Normal) => (op, 25.0, 15.0),
        TransitionKind::Resume(op, Block::Normal) => (op, 48.0, 42.0),
        TransitionKind::Complete(op, Block::Normal) => (op, 84.0, 66.0),
        TransitionKind::Undo(op) => (op, RIGHT, 105.0),
        TransitionKind::Retract(op) => (op, 118.0, 90.0),
        TransitionKind::Stop(op, Block::Recovery) => (op, 125.0, 195.0),
        TransitionKind::Resume(op, Block::Recovery) => (op, 102.0, 168.0),
        TransitionKind::Complete(op, Block::Recovery) => (op, 66.0, 144.0),
        TransitionKind::Restart(op) => (op, 0.0, 105.0),
        TransitionKind::Again(op) => (op, 32.0, 120.0),
        TransitionKind::Next { .. }
        | TransitionKind::Back { .. }
        | TransitionKind::GiveUp(_)
        | TransitionKind::EnterPath(_)
        | TransitionKind::FollowPath { .. } => return None,
    };
    Some((op, SheetPoint { x, y }))
}

#[derive(Clone, Copy, Debug)]
enum Lane {
    Above(usize),
    Below(usize),
}

/// The lanes of the transitions that join columns which are no neighbours.
struct Lanes {
    of: Vec<Option<Lane>>,
    /// Lanes above and below.
    counts: (usize, usize),
}

impl Lanes {
    fn of(station: &Station, transitions: &[StationTransition]) -> Self {
        let mut counts = (0, 0);
        let mut taken = BTreeSet::new();
        let mut lane = |transition: &StationTransition| {
            let is_next = matches!(transition.kind, TransitionKind::Next { .. });
            let neighbours = match transition.kind {
                TransitionKind::Next { from, to } => (to == from + 1).then_some((from, true)),
                TransitionKind::Back { from, to } => (from == to + 1).then_some((to, false)),
                kind if within(kind).is_some() => return None,
                _ => None,
            };
            // Where two tasks leave one rest, or lead to it, one of them alone stands between the columns.
            if neighbours.is_some_and(|gap| taken.insert(gap)) {
                return None;
            }
            let count = if is_next { &mut counts.0 } else { &mut counts.1 };
            *count += 1;
            Some(if is_next { Lane::Above(*count - 1) } else { Lane::Below(*count - 1) })
        };
        let of = transitions.iter().map(&mut lane).collect();
        debug_assert_eq!(station.steps.is_empty(), transitions.is_empty());
        Lanes { of, counts }
    }

    fn above(&self) -> f64 {
        LANE * self.counts.0 as f64
    }

    fn below(&self) -> f64 {
        LANE * self.counts.1 as f64
    }

    fn count(&self) -> usize {
        (self.counts.0 + self.counts.1).max(1)
    }
}

impl SheetPoint {
    /// Distance from a straight line between two points.
    fn distance(self, (a, b): (SheetPoint, SheetPoint)) -> f64 {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let square = dx * dx + dy * dy;
        let along = ((self.x - a.x) * dx + (self.y - a.y) * dy) / square;
        let along = if square == 0.0 { 0.0 } else { along.clamp(0.0, 1.0) };
        (self.x - a.x - along * dx).hypot(self.y - a.y - along * dy)
    }
}

impl std::ops::Add for SheetPoint {
    type Output = SheetPoint;

    fn add(self, other: SheetPoint) -> SheetPoint {
        SheetPoint { x: self.x + other.x, y: self.y + other.y }
    }
}
