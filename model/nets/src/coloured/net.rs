//! A coloured net: places and transitions with domains, functions on the arcs, guards, and a marking.
//!
//! Like [`crate::Net`] it never changes and exists only in sound form (see [`super::ColouredBuilder`]). A transition
//! fires in *modes*, one for each colour of its domain (seed 000, definition 13: the occurrence-colours). What an arc
//! takes or gives depends on the mode alone, so a mode of a transition is a transition of an ordinary net, and a colour
//! of a place is a place of it; [`super::unfold`] writes that net down.

use std::collections::HashMap;
use std::sync::Arc;

use super::domain::{BasicDomain, BasicId, DomainShape, show_domain};
use super::guard::Case;
use super::linear::LinearTerm;
use super::marking::{ColouredMarking, TokenElement, count_in};
use crate::{NamedId, PlaceId, TransitionId};

/// A transition with one colour of its domain: what fires.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NetMode {
    pub transition: TransitionId,
    /// The position of the colour among those of the transition, in lexical order.
    pub colour: u32,
}

/// ⟨P, T, C, I⁺, I⁻, G, M₀⟩ (seed 000, definition 13).
///
/// # Panics
/// Methods that take an id, a mode, a cell or a marking panic when it is not one of this net.
#[derive(Clone, Debug)]
pub struct ColouredNet {
    pub(super) name: String,
    pub(super) basics: Vec<BasicDomain>,
    pub(super) places: Vec<ColouredPlace>,
    pub(super) transitions: Vec<ColouredTransition>,
    pub(super) place_by_name: HashMap<Arc<str>, PlaceId>,
    pub(super) transition_by_name: HashMap<Arc<str>, TransitionId>,
    pub(super) initial: ColouredMarking,
}

#[derive(Clone, Debug)]
pub(super) struct ColouredPlace {
    pub(super) name: Arc<str>,
    pub(super) shape: DomainShape,
    /// The number of its first cell.
    pub(super) offset: u32,
    /// Declared number of tokens that it holds at most.
    pub(super) max_tokens: Option<u32>,
}

#[derive(Clone, Debug)]
pub(super) struct ColouredTransition {
    pub(super) name: Arc<str>,
    pub(super) shape: DomainShape,
    pub(super) inputs: Vec<ColouredArc>,
    pub(super) outputs: Vec<ColouredArc>,
    /// The clauses of its guard, or none if it has no guard.
    pub(super) guard: Option<Vec<Case>>,
    pub(super) plan: super::bind::BindingOrder,
}

/// One arc, seen from its transition. All weights are from 1 to `u32::MAX`, and so are their sums.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ColouredArc {
    pub(super) place: PlaceId,
    pub(super) terms: Vec<LinearTerm>,
}

impl ColouredTransition {
    /// Whether the guard allows a mode, given as tones from 0. Scheduled clauses count as if decided for.
    pub(super) fn allows(&self, mode: &[u32]) -> bool {
        self.guard.as_ref().is_none_or(|cases| cases.iter().any(|case| case.holds(mode)))
    }
}

impl ColouredNet {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The basic domains, in the order of declaration.
    pub fn basics(&self) -> &[BasicDomain] {
        &self.basics
    }

    /// Number of places.
    pub fn place_count(&self) -> usize {
        self.places.len()
    }

    /// Number of transitions.
    pub fn transition_count(&self) -> usize {
        self.transitions.len()
    }

    /// All places, in the order of declaration.
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> + Clone + use<> {
        // The builder bounds the count far below 32 bits.
        (0..self.places.len() as u32).map(PlaceId)
    }

    /// All transitions, in the order of declaration.
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = TransitionId> + Clone + use<> {
        (0..self.transitions.len() as u32).map(TransitionId)
    }

    pub fn place(&self, place: PlaceId) -> NamedId<PlaceId> {
        NamedId { id: place, name: self.places[place.index()].name.clone() }
    }

    pub fn transition(&self, transition: TransitionId) -> NamedId<TransitionId> {
        NamedId { id: transition, name: self.transitions[transition.index()].name.clone() }
    }

    pub fn place_named(&self, name: &str) -> Option<PlaceId> {
        self.place_by_name.get(name).copied()
    }

    pub fn transition_named(&self, name: &str) -> Option<TransitionId> {
        self.transition_by_name.get(name).copied()
    }

    /// C(p): the components of a place's domain; empty for the uncoloured.
    pub fn place_domain(&self, place: PlaceId) -> &[BasicId] {
        &self.places[place.index()].shape.basics
    }

    /// C(t): the components of a transition's domain; empty for the uncoloured. Of the universal domain, those in use.
    pub fn transition_domain(&self, transition: TransitionId) -> &[BasicId] {
        &self.transitions[transition.index()].shape.basics
    }

    /// Declared number of tokens that a place holds at most. It is a claim about the net and restricts no firing.
    pub fn max_tokens(&self, place: PlaceId) -> Option<u32> {
        self.places[place.index()].max_tokens
    }

    /// M₀.
    pub fn initial_marking(&self) -> ColouredMarking {
        self.initial.clone()
    }

    /// Number of cells: one for each colour of each place.
    pub fn cell_count(&self) -> u32 {
        self.places.last().map_or(0, |place| place.offset + place.shape.count)
    }

    /// The place and the colour of a cell, as markings number them.
    pub fn cell(&self, number: u32) -> TokenElement {
        let place = self.places.partition_point(|place| place.offset <= number) - 1;
        TokenElement { place: PlaceId(place as u32), colour: number - self.places[place].offset }
    }

    /// The cell of a colour on a place, with tones from 1; none if the place has no such colour.
    pub fn cell_of(&self, place: PlaceId, tones: &[u32]) -> Option<u32> {
        let place = &self.places[place.index()];
        place.shape.position(tones).map(|colour| place.offset + colour)
    }

    /// Name of a cell: `p3<2,1>`, or the place's name if it is uncoloured.
    pub fn cell_name(&self, number: u32) -> String {
        let cell = self.cell(number);
        let place = &self.places[cell.place.index()];
        format!("{}{}", place.name, place.shape.show(cell.colour, &self.basics))
    }

    /// The tones of a mode, from 1.
    pub fn mode_tones(&self, mode: NetMode) -> Vec<u32> {
        self.transitions[mode.transition.index()].shape.tones(mode.colour)
    }

    /// The mode of a transition with these tones (from 1); none if it has no such colour.
    pub fn mode(&self, transition: TransitionId, tones: &[u32]) -> Option<NetMode> {
        let colour = self.transitions[transition.index()].shape.position(tones)?;
        Some(NetMode { transition, colour })
    }

    /// Name of a mode: `t1<m2,r1,p3>`, or the transition's name if it is uncoloured.
    pub fn mode_name(&self, mode: NetMode) -> String {
        let transition = &self.transitions[mode.transition.index()];
        format!("{}{}", transition.name, transition.shape.show(mode.colour, &self.basics))
    }

    pub fn mode_named(&self, name: &str) -> Option<NetMode> {
        let Some((transition, tones)) = name.strip_suffix('>').and_then(|name| name.rsplit_once('<')) else {
            return self.mode(self.transition_named(name)?, &[]);
        };
        let transition = self.transition_named(transition)?;
        let domain = self.transition_domain(transition);
        let tones: Vec<&str> = tones.split(',').collect();
        if tones.len() != domain.len() {
            return None;
        }
        let named = domain.iter().zip(tones).map(|(basic, tone)| self.basics[basic.index()].tone_named(tone));
        self.mode(transition, &named.collect::<Option<Vec<u32>>>()?)
    }

    /// The modes of a transition that its guard allows, in order. Scheduled clauses count as if decided for.
    pub fn modes(&self, transition: TransitionId) -> impl Iterator<Item = NetMode> + '_ {
        let of = &self.transitions[transition.index()];
        let mut tones = vec![0; of.shape.sizes.len()];
        let allowed = move |&colour: &u32| {
            of.shape.decode(colour, &mut tones);
            of.allows(&tones)
        };
        (0..of.shape.count).filter(allowed).map(move |colour| NetMode { transition, colour })
    }

    /// Whether the guard of its transition allows a mode. Scheduled clauses count as if decided for.
    pub fn guard_allows(&self, mode: NetMode) -> bool {
        let transition = &self.transitions[mode.transition.index()];
        let mut tones = vec![0; transition.shape.sizes.len()];
        transition.shape.decode(mode.colour, &mut tones);
        transition.allows(&tones)
    }

    /// The tokens of one colour on a place, with tones from 1; none if it has no such colour.
    pub fn count(&self, marking: &ColouredMarking, place: PlaceId, tones: &[u32]) -> Option<u32> {
        self.cell_of(place, tones).map(|cell| count_in(&marking.entries, cell))
    }

    /// The tokens on a place: each colour that is there, with tones from 1, and how many of it.
    pub fn tokens_on<'a>(
        &'a self,
        marking: &'a ColouredMarking,
        place: PlaceId,
    ) -> impl Iterator<Item = (Vec<u32>, u32)> + 'a {
        let place = &self.places[place.index()];
        super::bind::on_place(&marking.entries, place)
            .iter()
            .map(|&(cell, count)| (place.shape.tones(cell - place.offset), count))
    }

    /// A marking in words: the cells that have tokens, each with its count if there is more than one.
    pub fn describe(&self, marking: &ColouredMarking) -> String {
        let show = |&(cell, count): &(u32, u32)| match count {
            1 => self.cell_name(cell),
            _ => format!("{} ×{count}", self.cell_name(cell)),
        };
        let cells: Vec<_> = marking.entries.iter().map(show).collect();
        if cells.is_empty() { "no tokens".to_owned() } else { cells.join(", ") }
    }

    pub(super) fn show_domain(&self, basics: &[BasicId]) -> String {
        show_domain(basics, &self.basics)
    }
}
