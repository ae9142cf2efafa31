//! Spots where parts can come and still be finished: reachability of (stage, spot), forwards and backwards.
//!
//! A spot is where a part can stand: outside before or after, in a store, in a machine before or after its work.
//! Activities are for the ways from *new, outside* to *done, outside*; the rest is left out of the nets and reported
//! where a plan needs it. Capacities play no part here. The search is linear in spots × stages × ways.

use crate::prototype::ResourceAction;
use crate::{ResourceId, StageId, Staying};

/// Place where a part can stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PartSpot(usize);

impl PartSpot {
    /// Outside, before.
    pub const BEFORE: PartSpot = PartSpot(0);
    /// Outside, afterwards.
    pub const AFTER: PartSpot = PartSpot(1);

    /// The spot that an action takes the part from or puts it to; none for a carrier.
    pub fn of(resource: Option<ResourceId>, action: ResourceAction) -> Option<PartSpot> {
        let first = resource.map(|id| 2 + 2 * id.index());
        match action {
            ResourceAction::In => Some(PartSpot::BEFORE),
            ResourceAction::Out => Some(PartSpot::AFTER),
            ResourceAction::Load | ResourceAction::Store | ResourceAction::Retrieve | ResourceAction::Process => {
                first.map(PartSpot)
            }
            ResourceAction::Unload => first.map(|first| PartSpot(first + 1)),
            ResourceAction::PickAndPlace => None,
        }
    }

    /// Spots of a part when work on it begins.
    pub fn work_from(resource: ResourceId, stays: Staying) -> impl Iterator<Item = PartSpot> {
        let [loaded, ready] = PartSpot::work(resource);
        let spots = [(loaded, stays.allows_loaded()), (ready, stays.allows_ready())];
        spots.into_iter().filter(|(_, can_be)| *can_be).map(|(spot, _)| spot)
    }

    /// Spots of a machine's parts before and after its work.
    pub fn work(resource: ResourceId) -> [PartSpot; 2] {
        [PartSpot(2 + 2 * resource.index()), PartSpot(3 + 2 * resource.index())]
    }
}

/// Moves of parts, and changes of their stages.
#[derive(Clone, Debug, Default)]
pub struct RouteTable {
    /// Start and end, whatever the stage.
    pub transports: Vec<(PartSpot, PartSpot)>,
    pub works: Vec<(ResourceId, StageId, StageId, Staying)>,
    /// The first and the last stage of each part type.
    pub ends: Vec<(StageId, StageId)>,
    /// Number of stages.
    pub stages: usize,
    /// Number of resources.
    pub resources: usize,
}

/// Spots that can be reached.
#[derive(Clone, Debug)]
pub struct Routes {
    stages: usize,
    /// From the beginning of the part's type.
    reached: Vec<bool>,
    /// From here its end can be reached.
    finishes: Vec<bool>,
}

impl Routes {
    /// Plays all ways.
    pub fn new(ways: &RouteTable) -> Routes {
        let spots = 2 + 2 * ways.resources;
        let mut forwards = vec![(Vec::new(), Vec::new()); spots];
        let mut backwards = forwards.clone();
        for &(source, target) in &ways.transports {
            forwards[source.0].0.push(target.0);
            backwards[target.0].0.push(source.0);
        }
        for &(resource, from, to, stays) in &ways.works {
            let after = PartSpot::work(resource)[1];
            for before in PartSpot::work_from(resource, stays) {
                forwards[before.0].1.push((from.index(), after.0, to.index()));
                backwards[after.0].1.push((to.index(), before.0, from.index()));
            }
        }
        let starts = ways.ends.iter().map(|(new, _)| (PartSpot::BEFORE.0, new.index()));
        let goals = ways.ends.iter().map(|(_, done)| (PartSpot::AFTER.0, done.index()));
        Routes {
            stages: ways.stages,
            reached: spread(&forwards, ways.stages, starts),
            finishes: spread(&backwards, ways.stages, goals),
        }
    }

    /// Whether a part of this stage can come there.
    pub fn is_reached(&self, spot: PartSpot, stage: StageId) -> bool {
        self.reached.get(spot.0 * self.stages + stage.index()).copied().unwrap_or(false)
    }

    /// Whether a part of this stage that is there can still be finished and leave.
    pub fn finishes(&self, spot: PartSpot, stage: StageId) -> bool {
        self.finishes.get(spot.0 * self.stages + stage.index()).copied().unwrap_or(false)
    }

    /// Whether this transport of this stage is part of a way from the beginning to the end.
    pub fn is_of_use(&self, (source, target): (PartSpot, PartSpot), stage: StageId) -> bool {
        self.is_reached(source, stage) && self.finishes(target, stage)
    }
}

/// The ways from one spot: to which others, and from which stage to which spot and stage.
type From = (Vec<usize>, Vec<(usize, usize, usize)>);

fn spread(ways: &[From], stages: usize, starts: impl Iterator<Item = (usize, usize)>) -> Vec<bool> {
    let mut seen = vec![false; ways.len() * stages];
    let mut open: Vec<(usize, usize)> = Vec::new();
    let mut visit = |spot: usize, stage: usize, open: &mut Vec<_>| {
        if !std::mem::replace(&mut seen[spot * stages + stage], true) {
            open.push((spot, stage));
        }
    };
    starts.for_each(|(spot, stage)| visit(spot, stage, &mut open));
    while let Some((spot, stage)) = open.pop() {
        let (transports, works) = &ways[spot];
        transports.iter().for_each(|&target| visit(target, stage, &mut open));
        let works = works.iter().filter(|work| work.0 == stage);
        works.for_each(|&(_, target, to)| visit(target, to, &mut open));
    }
    seen
}
