//! Builder of coloured nets, and their one check.
//!
//! As with [`crate::NetBuilder`], everything is accepted while writing and all problems are reported together at the
//! end. A declaration that depends on a broken one is not checked: an arc at a place whose domain does not exist has no
//! right or wrong function.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::check::{self, Resolved};
use super::domain::{BasicDomain, BasicId, Domain};
use super::error::ColouredError;
use super::function::Function;
use super::guard::Guard;
use super::marking::{ColouredMarking, collect};
use super::net::{ColouredNet, ColouredPlace, ColouredTransition};
use crate::{ArcDirection, MAX_NODES, NamedId, Net, NetNode, PlaceId, TransitionId};

/// An arc as declared.
pub(super) struct DeclaredColouredArc {
    pub(super) direction: ArcDirection,
    pub(super) place: PlaceId,
    pub(super) transition: TransitionId,
    pub(super) function: Function,
}

/// A coloured net under construction.
///
/// ```
/// use linewright_nets::coloured::{ColouredBuilder, Domain, Guard, colour, id, proj};
///
/// // Two machines; part 1 goes to machine 1, part 2 to machine 2.
/// let mut b = ColouredBuilder::new("loading");
/// let machine = b.basic("M", 2);
/// let part = b.named_basic("P", ["gear", "shaft"]);
/// let free = b.place("free", machine);
/// let waiting = b.place("waiting", part);
/// let loaded = b.place("loaded", [machine, part]);
/// b.tokens(free, &[1], 1).tokens(free, &[2], 1).tokens(waiting, &[2], 3);
/// let load = b.transition("load", Domain::Universal);
/// b.input(load, free, proj([1])).input(load, waiting, proj([2])).output(load, loaded, id());
/// b.guard(load, Guard::any([[colour(1, 1), colour(2, 1)], [colour(1, 2), colour(2, 2)]]));
/// let net = b.build().expect("the net is written down correctly");
///
/// let mut marking = net.initial_marking();
/// let enabled = net.enabled(&marking);
/// assert_eq!(enabled.iter().map(|&mode| net.mode_name(mode)).collect::<Vec<_>>(), ["load<2,shaft>"]);
/// net.fire(&mut marking, enabled[0])?;
/// assert_eq!(net.describe(&marking), "free<1>, waiting<shaft> ×2, loaded<2,shaft>");
/// # Ok::<(), linewright_nets::coloured::ColouredFireError>(())
/// ```
pub struct ColouredBuilder {
    pub(super) name: String,
    pub(super) basics: Vec<BasicDomain>,
    pub(super) places: Vec<(Arc<str>, Domain, Option<u32>)>,
    pub(super) transitions: Vec<(Arc<str>, Domain)>,
    pub(super) arcs: Vec<DeclaredColouredArc>,
    pub(super) guards: Vec<(TransitionId, Guard)>,
    pub(super) tokens: Vec<(PlaceId, Vec<u32>, u32)>,
}

impl ColouredBuilder {
    /// A net with nothing in it yet.
    pub fn new(name: impl Into<String>) -> Self {
        ColouredBuilder {
            name: name.into(),
            basics: Vec::new(),
            places: Vec::new(),
            transitions: Vec::new(),
            arcs: Vec::new(),
            guards: Vec::new(),
            tokens: Vec::new(),
        }
    }

    /// An ordinary net as a coloured one, all of whose tokens are uncoloured.
    pub fn from_net(net: &Net) -> Self {
        let mut b = ColouredBuilder::new(net.name());
        let initial = net.initial_marking();
        for place in net.places() {
            b.place(net.place_name(place), Domain::Uncoloured);
            if initial.tokens(place) > 0 {
                b.tokens(place, &[], initial.tokens(place));
            }
        }
        for transition in net.transitions() {
            b.transition(net.transition_name(transition), Domain::Uncoloured);
            for &(place, weight) in net.preset(transition) {
                b.input(transition, place, i64::from(weight) * super::id());
            }
            for &(place, weight) in net.postset(transition) {
                b.output(transition, place, i64::from(weight) * super::id());
            }
        }
        b
    }

    /// Declares a basic domain with the tones 1 to `size`.
    pub fn basic(&mut self, name: impl Into<String>, size: u32) -> BasicId {
        self.basics.push(BasicDomain { name: name.into().into(), size, tones: Vec::new() });
        BasicId(dense(self.basics.len()))
    }

    /// Declares a basic domain whose tones have names. They are still numbered, from 1 and in this order.
    pub fn named_basic<N: Into<String>>(
        &mut self,
        name: impl Into<String>,
        tones: impl IntoIterator<Item = N>,
    ) -> BasicId {
        let tones: Vec<Arc<str>> = tones.into_iter().map(|tone| tone.into().into()).collect();
        let size = u32::try_from(tones.len()).unwrap_or(u32::MAX);
        self.basics.push(BasicDomain { name: name.into().into(), size, tones });
        BasicId(dense(self.basics.len()))
    }

    /// Declares a place.
    pub fn place(&mut self, name: impl Into<String>, domain: impl Into<Domain>) -> PlaceId {
        self.places.push((name.into().into(), domain.into(), None));
        PlaceId(dense(self.places.len()))
    }

    /// Declares how many tokens a place holds at most (`maxtoken` in the grammar of seed 000, §7.2.1). The claim is
    /// checked for the initial marking here, and for all others by [`super::ColouredReachability::over_capacity`].
    pub fn max_tokens(&mut self, place: PlaceId, most: u32) -> &mut Self {
        if let Some(place) = self.places.get_mut(place.index()) {
            place.2 = Some(most);
        }
        self
    }

    /// Puts tokens of one colour on a place in the initial marking, with tones from 1. Several calls add up.
    pub fn tokens(&mut self, place: PlaceId, tones: &[u32], count: u32) -> &mut Self {
        self.tokens.push((place, tones.to_vec(), count));
        self
    }

    /// Declares a transition.
    pub fn transition(&mut self, name: impl Into<String>, domain: impl Into<Domain>) -> TransitionId {
        self.transitions.push((name.into().into(), domain.into()));
        TransitionId(dense(self.transitions.len()))
    }

    /// Declares what firing `transition` takes from `place`.
    pub fn input(&mut self, transition: TransitionId, place: PlaceId, function: Function) -> &mut Self {
        self.arcs.push(DeclaredColouredArc { direction: ArcDirection::Input, place, transition, function });
        self
    }

    /// Declares what firing `transition` gives to `place`.
    pub fn output(&mut self, transition: TransitionId, place: PlaceId, function: Function) -> &mut Self {
        self.arcs.push(DeclaredColouredArc { direction: ArcDirection::Output, place, transition, function });
        self
    }

    /// Declares which modes of `transition` there are. Without a guard there are all.
    pub fn guard(&mut self, transition: TransitionId, guard: Guard) -> &mut Self {
        self.guards.push((transition, guard));
        self
    }

    /// The net, or all its errors: domains first, then names, places, transitions and tokens.
    pub fn build(self) -> Result<ColouredNet, Vec<ColouredError>> {
        let mut problems = Vec::new();
        self.check_sizes(&mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        check::basics(&self.basics, &mut problems);
        self.check_names(&mut problems);
        let resolved = Resolved::new(&self, &mut problems);
        let transitions = check::transitions(&self, &resolved, &mut problems);
        let initial = self.check_tokens(&resolved.places, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let places: Vec<ColouredPlace> = resolved.places.into_iter().flatten().collect();
        let transitions: Vec<ColouredTransition> = transitions.into_iter().flatten().collect();
        Ok(ColouredNet::assemble(self.name, self.basics, places, transitions, initial))
    }

    fn check_sizes(&self, problems: &mut Vec<ColouredError>) {
        if self.places.is_empty() && self.transitions.is_empty() {
            problems.push(ColouredError::Empty);
        }
        let sizes = [
            ("places", self.places.len()),
            ("transitions", self.transitions.len()),
            ("colour domains", self.basics.len()),
            ("arcs", self.arcs.len()),
        ];
        for (what, count) in sizes.into_iter().filter(|&(_, count)| count > MAX_NODES) {
            problems.push(ColouredError::TooMany { what, count });
        }
    }

    fn check_names(&self, problems: &mut Vec<ColouredError>) {
        let places = self.places.iter().map(|(name, ..)| name);
        let transitions = self.transitions.iter().map(|(name, _)| name);
        for name in repeated(places.clone()) {
            problems.push(ColouredError::DuplicateName { what: "places", name });
        }
        for name in repeated(transitions.clone()) {
            problems.push(ColouredError::DuplicateName { what: "transitions", name });
        }
        let places = places.zip(0..).map(|(name, id)| (name, NetNode::Place(PlaceId(id))));
        let transitions = transitions.zip(0..).map(|(name, id)| (name, NetNode::Transition(TransitionId(id))));
        for (name, id) in places.chain(transitions).filter(|(name, _)| name.ends_with('>')) {
            problems.push(ColouredError::NameLikeColour { node: NamedId { id, name: name.clone() } });
        }
    }

    /// The initial marking, as far as its tokens are what their places hold.
    fn check_tokens(&self, places: &[Option<ColouredPlace>], problems: &mut Vec<ColouredError>) -> ColouredMarking {
        let mut entries = Vec::new();
        for (id, tones, count) in &self.tokens {
            let Some(resolved) = places.get(id.index()) else {
                let what = format!("a token {}", show(tones));
                problems.push(ColouredError::UnknownPlace { what, place: id.0, places: places.len() });
                continue;
            };
            let Some(place) = resolved else { continue };
            match place.shape.position(tones) {
                Some(colour) => entries.extend((*count > 0).then_some((place.offset + colour, *count))),
                None => problems.push(check::misfit(*id, place, tones, &self.basics)),
            }
        }
        let named = |place: usize, of: &ColouredPlace| NamedId { id: PlaceId(place as u32), name: of.name.clone() };
        if let Err(cell) = collect(&mut entries) {
            let known = places.iter().flatten().enumerate().filter(|(_, place)| place.offset <= cell).last();
            problems.extend(known.map(|(at, of)| ColouredError::TooManyTokens { place: named(at, of) }));
            return ColouredMarking::default();
        }
        for (at, place) in places.iter().enumerate() {
            let Some((place, most)) = place.as_ref().and_then(|place| Some((place, place.max_tokens?))) else {
                continue;
            };
            let tokens = super::bind::on_place(&entries, place).iter().map(|&(_, count)| u64::from(count)).sum();
            if tokens > u64::from(most) {
                problems.push(ColouredError::OverCapacity { place: named(at, place), tokens, most });
            }
        }
        ColouredMarking { entries }
    }
}

impl ColouredNet {
    /// From parts that have been checked.
    pub(super) fn assemble(
        name: String,
        basics: Vec<BasicDomain>,
        places: Vec<ColouredPlace>,
        transitions: Vec<ColouredTransition>,
        initial: ColouredMarking,
    ) -> ColouredNet {
        let place_by_name: HashMap<_, _> = places.iter().map(|p| p.name.clone()).zip((0..).map(PlaceId)).collect();
        let transition_by_name = transitions.iter().map(|t| t.name.clone()).zip((0..).map(TransitionId)).collect();
        ColouredNet { name, basics, places, transitions, place_by_name, transition_by_name, initial }
    }
}

/// The id of what was declared last. Beyond 32 bits all share one; the net is refused for its size by then.
fn dense(declared: usize) -> u32 {
    u32::try_from(declared - 1).unwrap_or(u32::MAX)
}

/// The names that occur more than once, each once, in the order of their second occurrence.
pub(super) fn repeated<'a>(names: impl Iterator<Item = &'a Arc<str>>) -> Vec<Arc<str>> {
    let (mut seen, mut found) = (HashSet::new(), Vec::new());
    for name in names {
        if !seen.insert(name) && !found.contains(name) {
            found.push(name.clone());
        }
    }
    found
}

/// A token in words.
pub(super) fn show(tones: &[u32]) -> String {
    if tones.is_empty() {
        return "<•>".to_owned();
    }
    format!("<{}>", tones.iter().map(u32::to_string).collect::<Vec<_>>().join(","))
}
