//! The parts of a cell's net that have nothing in common but the number of parts let in.
//!
//! Each is an ordinary net of its own, with any number of parts let in. A place that counts the parts inside is added;
//! it follows from the others and blocks nothing.

use linewright_cell::ResourceId;
use linewright_cell::net::PlaceMeaning;
use linewright_nets::explicit::MarkingView;
use linewright_nets::{Net, NetBuilder, PlaceId, TransitionId};
use petgraph::unionfind::UnionFind;
use rustc_hash::FxHashMap;

use super::Nets;

/// Places and transitions that hang together without what all have in common.
#[derive(Debug)]
pub(super) struct ResourceGroup {
    /// Places of the long net; those of the group's own net are in the same order, with two more behind them.
    pub places: Vec<PlaceId>,
    /// Transitions of the long net, in the same order.
    pub transitions: Vec<TransitionId>,
    /// Tokens that each transition takes and gives, in places of the group's own net.
    sides: Vec<[Vec<(PlaceId, u32)>; 2]>,
    names: Vec<String>,
    tokens: Vec<u32>,
    transition_names: Vec<String>,
    pub resources: Vec<ResourceId>,
}

/// The groups of a net, by their first place. What takes part in nothing is in none.
pub(super) fn groups(nets: &Nets<'_>) -> Vec<ResourceGroup> {
    let long = nets.long.net();
    let is_common = |place: PlaceId| nets.meaning(place) == PlaceMeaning::Admission;
    let mut together = UnionFind::<usize>::new(long.place_count());
    for t in long.transitions() {
        let mut own = around(long, t).filter(|&place| !is_common(place));
        if let Some(first) = own.next() {
            own.for_each(|place| _ = together.union(first.index(), place.index()));
        }
    }
    let mut groups: FxHashMap<usize, ResourceGroup> = FxHashMap::default();
    for t in long.transitions() {
        let Some(first) = around(long, t).find(|&place| !is_common(place)) else { continue };
        let root = together.find(first.index());
        groups.entry(root).or_insert_with(ResourceGroup::nothing).transitions.push(t);
    }
    for place in long.places().filter(|&place| !is_common(place)) {
        if let Some(group) = groups.get_mut(&together.find(place.index())) {
            group.places.push(place);
        }
    }
    let mut groups: Vec<ResourceGroup> = groups.into_values().collect();
    groups.iter_mut().for_each(|group| group.complete(nets));
    groups.sort_by_key(|group| group.places.first().copied());
    groups
}

fn around(net: &Net, t: TransitionId) -> impl Iterator<Item = PlaceId> + '_ {
    net.preset(t).iter().chain(net.postset(t)).map(|&(place, _)| place)
}

impl ResourceGroup {
    fn nothing() -> ResourceGroup {
        ResourceGroup {
            places: Vec::new(),
            transitions: Vec::new(),
            sides: Vec::new(),
            names: Vec::new(),
            tokens: Vec::new(),
            transition_names: Vec::new(),
            resources: Vec::new(),
        }
    }

    /// Place of admission: number of parts that may still come in, in the group's own net.
    fn admission(&self) -> PlaceId {
        PlaceId(self.places.len() as u32)
    }

    /// Place that counts the parts inside, in the group's own net.
    pub fn inside(&self) -> PlaceId {
        PlaceId(self.places.len() as u32 + 1)
    }

    fn complete(&mut self, nets: &Nets<'_>) {
        let (long, initial) = (nets.long.net(), nets.long.net().initial_marking());
        self.names = self.places.iter().map(|&place| long.place_name(place).to_owned()).collect();
        self.tokens = self.places.iter().map(|&place| initial.tokens(place)).collect();
        let (admission, inside) = (self.admission(), self.inside());
        let own = |place: PlaceId| match self.places.binary_search(&place) {
            Ok(at) => PlaceId(at as u32),
            Err(_) => admission,
        };
        for &t in &self.transitions {
            let side = |arcs: &[(PlaceId, u32)]| arcs.iter().map(|&(place, n)| (own(place), n)).collect::<Vec<_>>();
            let [mut takes, mut gives] = [side(long.preset(t)), side(long.postset(t))];
            // An admitted part is inside, until another may come instead.
            let counted = |arcs: &[(PlaceId, u32)]| arcs.iter().find(|(place, _)| *place == admission).map(|&(_, n)| n);
            let (coming, leaving) = (counted(&takes), counted(&gives));
            gives.extend(coming.map(|n| (inside, n)));
            takes.extend(leaving.map(|n| (inside, n)));
            self.sides.push([takes, gives]);
            self.transition_names.push(long.transition_name(t).to_owned());
        }
        let mut resources: Vec<ResourceId> =
            self.places.iter().filter_map(|&place| nets.meaning(place).resource()).collect();
        resources.sort_unstable();
        resources.dedup();
        self.resources = resources;
    }

    /// The group's own net with so many parts let in at a time; none if that has no form, which only sizes can cause.
    pub fn net(&self, parts: u32) -> Option<Net> {
        let mut b = NetBuilder::new("group");
        for (name, &tokens) in self.names.iter().zip(&self.tokens) {
            b.place(name.as_str(), tokens);
        }
        // No place of a cell is called so: theirs have a dot.
        b.place("admission", parts);
        b.place("inside", 0);
        for (name, [takes, gives]) in self.transition_names.iter().zip(&self.sides) {
            let t = b.transition(name.as_str());
            takes.iter().for_each(|&(place, weight)| _ = b.input(t, place, weight));
            gives.iter().for_each(|&(place, weight)| _ = b.output(t, place, weight));
        }
        b.build().ok()
    }

    /// Tokens that a transition takes, by its place in [`ResourceGroup::transitions`].
    pub fn takes(&self, transition: usize) -> &[(PlaceId, u32)] {
        &self.sides[transition][0]
    }

    /// Whether parts are inside and the only enabled transitions let others in: then those inside stay for good.
    pub fn is_stuck(&self, view: MarkingView<'_>) -> bool {
        let enabled = |takes: &[(PlaceId, u32)]| takes.iter().all(|&(place, weight)| view.tokens(place) >= weight);
        let comes = |takes: &[(PlaceId, u32)]| takes.iter().any(|&(place, _)| place == self.admission());
        view.tokens(self.inside()) > 0 && !self.sides.iter().any(|[takes, _]| !comes(takes) && enabled(takes))
    }
}

impl Nets<'_> {
    /// Meaning of a place of the long net.
    pub(super) fn meaning(&self, place: PlaceId) -> PlaceMeaning {
        self.net.meaning(self.long.cell(self.net.net(), place).place)
    }
}
