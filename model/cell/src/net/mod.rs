//! The nets that follow from a cell (seed 001 §3; seed 000 §3.2.3).
//!
//! Each resource is a small coloured net of its own, an instance of its prototype; what several do together is a fused
//! transition, named as the synchronisation: `load M1<A.new>`. Which resource a part is at is the place, how far it is
//! the colour; so there is one basic domain, `S`, with a tone for each stage, and a thousand resources cost a thousand
//! small place sets instead of a product. Parts are counted, not distinguished.
//!
//! There are two levels of detail. In *coordination* an activity is one transition, which a player fires in three phases:
//! take, run, put. In *expanded* it is a start, a place for what is in progress, and an end; that is the same by plain
//! interleaving. What takes no time stays one transition in both. Where nothing is in progress, both have the same
//! markings: what has started can always end, and its end takes nothing from others.
//!
//! With `reserve = false` a carrier grasps a part before there is room for it: two activities instead of one. It is there
//! to be found wrong.

mod instance;
mod meaning;
mod pieces;

use linewright_nets::coloured::{ColouredError, ColouredNet, Fusion, NetMode, fuse};
use linewright_nets::{PlaceId, TransitionId};

use crate::{Activity, ActivityId, Cell, StageId, StageMove};
pub use meaning::{PlaceMeaning, ResourcePosition};
use pieces::pieces;

/// The basic domain of stages.
pub const STAGES: &str = "S";
/// Name of the outside among the instances.
pub const OUTSIDE: &str = "outside";
/// Name of the activities in progress among the instances.
pub const RUNNING: &str = "running";

/// Level of detail of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Detail {
    /// A transition for each.
    Coordination,
    /// Start and end apart, and a place between them.
    Expanded,
}

/// Source and destination of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Supply<'a> {
    /// Number of parts of each type that wait outside, in their order, none by default; a part that leaves may come again.
    /// This can be explored.
    Closed(&'a [u32]),
    /// Number of parts of each type that may still enter, none by default; a part that leaves is gone. They are counted,
    /// and are parts only once they have entered. This is a production that comes to its end.
    Batch(&'a [u32]),
    /// Parts are made as they enter and are gone when they leave. This is played.
    Open,
}

impl<'a> From<&'a [u32]> for Supply<'a> {
    fn from(waiting: &'a [u32]) -> Self {
        Supply::Closed(waiting)
    }
}

impl<'a, const N: usize> From<&'a [u32; N]> for Supply<'a> {
    fn from(waiting: &'a [u32; N]) -> Self {
        Supply::Closed(waiting)
    }
}

/// Part of an activity that a transition is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransitionPhase {
    /// Start and end in one transition.
    Whole,
    /// Its beginning: its tokens are taken.
    Start,
    /// Its end: its tokens are given.
    End,
    /// The carrier takes the part, all of it, without a reservation.
    Grasp,
    /// The carrier puts the part, all of it.
    Put,
    /// The beginning of the grasp.
    GraspStart,
    GraspEnd,
    /// The beginning of putting.
    PutStart,
    /// The end of putting.
    PutEnd,
}

impl TransitionPhase {
    /// Whether the activity has ended with it.
    pub const fn ends(self) -> bool {
        match self {
            TransitionPhase::Whole | TransitionPhase::End | TransitionPhase::Put | TransitionPhase::PutEnd => true,
            TransitionPhase::Start
            | TransitionPhase::Grasp
            | TransitionPhase::GraspStart
            | TransitionPhase::GraspEnd
            | TransitionPhase::PutStart => false,
        }
    }
}

/// Meaning of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A part of an activity.
    Activity {
        /// Activity of the transition.
        id: ActivityId,
        /// Part of it.
        phase: TransitionPhase,
        /// Distance to the stage afterwards, in tones around the ring of all stages.
        shift: u32,
    },
    /// A part moves up in a buffer, by itself and at once.
    Shift,
}

/// The instances of a cell and what joins them.
#[derive(Clone, Debug)]
pub struct CellInstances {
    /// Each with its name: the resources in their order, the outside, and activities in progress.
    pub instances: Vec<(String, ColouredNet)>,
    /// The transitions that are one.
    pub fusions: Vec<Fusion>,
    /// Meaning of each fusion.
    origins: Vec<Origin>,
    /// Meaning of the places of all instances, in their order.
    meanings: Vec<PlaceMeaning>,
}

/// The net of a cell, with the way back to it.
#[derive(Clone, Debug)]
pub struct CellNet {
    net: ColouredNet,
    /// By transition.
    origins: Vec<Origin>,
    meanings: Vec<PlaceMeaning>,
    /// Parts outside are counted, and are no parts yet.
    counts_waiting: bool,
    stages: usize,
}

/// The instances of a cell.
///
/// # Errors
/// Refusals of the builder of nets, which are about sizes: all else is made to fit.
pub fn parts<'a>(
    cell: &Cell,
    detail: Detail,
    supply: impl Into<Supply<'a>>,
) -> Result<CellInstances, Vec<ColouredError>> {
    let pieces = pieces(cell, detail);
    let mut instances = Vec::with_capacity(cell.resources.len() + 2);
    let mut meanings = Vec::new();
    let mut add = |name: &str, (net, mut of): (ColouredNet, Vec<PlaceMeaning>)| {
        instances.push((name.to_owned(), net));
        meanings.append(&mut of);
    };
    for id in cell.resource_ids() {
        add(&cell.resource(id).name, instance::resource(cell, id, &pieces)?);
    }
    add(OUTSIDE, instance::outside(cell, supply.into(), &pieces)?);
    if let Some(running) = instance::running(cell, &pieces) {
        add(RUNNING, running?);
    }
    let fusion = |piece: &pieces::PlannedTransition| {
        let having = instances.iter().enumerate();
        let having = having.filter(|(_, (_, net))| net.transition_named(&piece.name).is_some());
        Fusion::new(&*piece.name, having.map(|(at, _)| (at, &*piece.name)))
    };
    let fusions = pieces.iter().map(fusion).collect();
    let origins =
        pieces.iter().map(|piece| Origin::Activity { id: piece.activity, phase: piece.phase, shift: piece.shift });
    Ok(CellInstances { instances, fusions, origins: origins.collect(), meanings })
}

/// The net of a cell.
///
/// # Errors
/// As [`parts`].
pub fn net<'a>(cell: &Cell, detail: Detail, supply: impl Into<Supply<'a>>) -> Result<CellNet, Vec<ColouredError>> {
    let supply = supply.into();
    let CellInstances { instances, fusions, mut origins, meanings } = parts(cell, detail, supply)?;
    let nets: Vec<(&str, &ColouredNet)> = instances.iter().map(|(name, net)| (name.as_str(), net)).collect();
    let net = fuse(&cell.name, &nets, &fusions)?;
    // Fused transitions come first, in their order; what is left are the shifts of buffers.
    origins.resize(net.transition_count(), Origin::Shift);
    let counts_waiting = match supply {
        Supply::Batch(_) => true,
        Supply::Closed(_) | Supply::Open => false,
    };
    Ok(CellNet { net, origins, meanings, counts_waiting, stages: cell.stages.len() })
}

impl CellNet {
    pub fn net(&self) -> &ColouredNet {
        &self.net
    }

    /// Meaning of a transition.
    pub fn origin(&self, transition: TransitionId) -> Origin {
        self.origins[transition.index()]
    }

    /// Whether the tokens of a place are parts; otherwise they are capacities.
    pub fn holds_parts(&self, place: PlaceId) -> bool {
        let meaning = self.meaning(place);
        meaning.holds_parts_inside() || meaning == PlaceMeaning::Waiting && !self.counts_waiting
    }

    /// Meaning of the tokens of a place.
    pub fn meaning(&self, place: PlaceId) -> PlaceMeaning {
        self.meanings[place.index()]
    }

    /// Stage change of a mode; none for a shift in a buffer.
    pub fn move_of<'c>(&self, cell: &'c Cell, mode: NetMode) -> Option<(&'c Activity, &'c StageMove)> {
        let Origin::Activity { id, shift, .. } = self.origin(mode.transition) else { return None };
        let domain = self.net.transition_domain(mode.transition);
        let at = domain.iter().position(|basic| self.net.basics()[basic.index()].name() == STAGES)?;
        let from = *self.net.mode_tones(mode).get(at)? as usize - 1;
        let to = (from + shift as usize) % self.stages;
        let activity = cell.activity(id);
        Some((activity, activity.move_of(StageId::at(from), StageId::at(to))?))
    }
}
