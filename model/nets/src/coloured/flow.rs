//! Coloured flows: sums that firing does not change, and firings that change nothing.
//!
//! A place-flow gives every place a function into one common domain; the sum of the functions of a marking is the same
//! in all reachable markings (seed 000, definitions 29 to 31). Weights are functions and may be negative, so a flow can
//! express "the position after the last one stored is the one that is offered". A transition-flow is a bag of modes
//! that, fired in any order that is possible, lead back.
//!
//! A coloured flow is *checked* here, not found: first as an equation between functions, which decides most transitions
//! for all their modes at once; where that leaves something over, mode by mode. Guards count: what a guard excludes
//! cannot break a place-flow. What can be found are the flows of the unfolding, by [`crate::semiflows`].

use std::collections::BTreeMap;

use thiserror::Error;

use super::domain::{BasicDomain, BasicId, Domain, DomainShape, show_domain};
use super::function::Function;
use super::linear::{ComponentPick, FunctionError, LinearFunction, LinearTerm, compile, turn};
use super::marking::ColouredMarking;
use super::net::{ColouredNet, ColouredTransition, NetMode};
use super::unfold::Unfolding;
use crate::semiflows::{self, Semiflow};
use crate::{NamedId, PlaceId, TransitionId};

/// Error in a flow as it is written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]

pub enum FlowError {
    /// The common domain does not exist, is empty of colours, or has too many.
    #[error("the flow leads to a domain that the net does not have, or that has too many colours")]
    Target,
    /// A place that does not exist.
    #[error("the flow weighs place #{place}, but the net has {places} places")]
    UnknownPlace { place: u32, places: usize },
    /// A place with two weights.
    #[error("the flow weighs {place} twice; add the functions up")]
    Twice { place: NamedId<PlaceId> },
    /// A weight that has no meaning for the colours of its place.
    #[error("the flow weighs {place} by `{function}`: {error}")]
    Function { place: NamedId<PlaceId>, function: String, error: FunctionError },
    /// A weight that leads elsewhere than the others.
    #[error("the flow weighs {place} by `{function}`, which leads to {found}, and not to {expected}")]
    Elsewhere { place: NamedId<PlaceId>, function: String, found: String, expected: String },
}

/// Reason why a flow is none, or is not known to be one.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotFlow {
    /// A mode changes the sum.
    #[error("{mode} changes the sum by {change} at {colour}")]
    Changed {
        /// The name of the mode.
        mode: String,
        id: NetMode,
        /// The colour of the sum that changes.
        colour: String,
        /// Change of the weighted sum, in tokens.
        change: i128,
    },
    /// More modes would have to be looked at than allowed.
    #[error("undecided after {modes} modes")]
    Undecided {
        /// Number of modes checked.
        modes: usize,
    },
}

/// A weighting of places by functions into one domain. It need not be a flow; see [`PlaceFlow::check`].
#[derive(Clone, Debug)]
pub struct PlaceFlow {
    target: DomainShape,
    weights: BTreeMap<PlaceId, Vec<LinearTerm>>,
}

impl PlaceFlow {
    /// A weighting into `target`, or all its errors. Places that are not listed do not count.
    pub fn new(
        net: &ColouredNet,
        target: impl Into<Domain>,
        weights: impl IntoIterator<Item = (PlaceId, Function)>,
    ) -> Result<PlaceFlow, Vec<FlowError>> {
        let basics: Vec<BasicId> = match target.into() {
            Domain::Uncoloured => Vec::new(),
            Domain::Product(basics) => basics,
            Domain::Universal => (0..net.basics.len() as u32).map(BasicId).collect(),
        };
        let known = basics.iter().all(|basic| basic.index() < net.basics.len());
        let Some(target) = known.then(|| DomainShape::new(&basics, &net.basics)).flatten() else {
            return Err(vec![FlowError::Target]);
        };
        let (mut problems, mut found) = (Vec::new(), BTreeMap::new());
        for (id, function) in weights {
            match weight(net, id, &function, &basics) {
                Ok(linear) => {
                    if found.insert(id, linear.terms).is_some() {
                        problems.push(FlowError::Twice { place: net.place(id) });
                    }
                }
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() { Ok(PlaceFlow { target, weights: found }) } else { Err(problems) }
    }

    /// Whether no mode changes the sum. Looks at up to `most_modes` single modes where functions alone do not decide.
    pub fn check(&self, net: &ColouredNet, most_modes: usize) -> Result<(), NotFlow> {
        let mut looked = 0;
        for transition in net.transitions() {
            if self.is_neutral(&net.transitions[transition.index()]) {
                continue;
            }
            for mode in net.modes(transition) {
                if looked == most_modes {
                    return Err(NotFlow::Undecided { modes: looked });
                }
                looked += 1;
                let changes = self.change(net, mode);
                if let Some((&colour, &change)) = changes.iter().find(|&(_, &change)| change != 0) {
                    let colour = show_colour(&self.target, colour, &net.basics);
                    return Err(NotFlow::Changed { mode: net.mode_name(mode), id: mode, colour, change });
                }
            }
        }
        Ok(())
    }

    /// The sum for a marking: the colours of the common domain whose weight is not zero, with tones from 1.
    pub fn value(&self, net: &ColouredNet, marking: &ColouredMarking) -> Vec<(Vec<u32>, i128)> {
        let mut sums = BTreeMap::new();
        for &(number, count) in marking.entries() {
            let cell = net.cell(number);
            self.add(net, cell.place, cell.colour, count.into(), &mut sums);
        }
        let colours = sums.into_iter().filter(|&(_, sum)| sum != 0);
        colours.map(|(colour, sum)| (self.target.tones(colour), sum)).collect()
    }

    /// Change of the sum by a mode, by colour of the common domain.
    fn change(&self, net: &ColouredNet, mode: NetMode) -> BTreeMap<u32, i128> {
        let mut sums = BTreeMap::new();
        let (mut takes, mut gives) = (Vec::new(), Vec::new());
        net.demand(&[mode], &mut takes).expect("the builder bounds what a mode takes");
        net.append_outputs(mode, &mut gives);
        let takes = takes.into_iter().map(|(cell, count)| (cell, -i128::from(count)));
        for (number, count) in takes.chain(gives.into_iter().map(|(cell, count)| (cell, i128::from(count)))) {
            let cell = net.cell(number);
            self.add(net, cell.place, cell.colour, count, &mut sums);
        }
        sums
    }

    fn add(&self, net: &ColouredNet, place: PlaceId, colour: u32, count: i128, sums: &mut BTreeMap<u32, i128>) {
        let Some(terms) = self.weights.get(&place) else { return };
        let shape = &net.places[place.index()].shape;
        let mut tones = vec![0; shape.sizes.len()];
        shape.decode(colour, &mut tones);
        for term in terms {
            *sums.entry(term.apply(&tones, &self.target)).or_default() += count * i128::from(term.weight);
        }
    }

    /// Whether the functions cancel out, whatever the mode. What they leave over may still be zero for every mode.
    fn is_neutral(&self, transition: &ColouredTransition) -> bool {
        let mut sums: BTreeMap<Vec<ComponentPick>, i128> = BTreeMap::new();
        for (sides, sign) in [(&transition.inputs, -1), (&transition.outputs, 1)] {
            for side in sides {
                for weight in self.weights.get(&side.place).into_iter().flatten() {
                    for term in &side.terms {
                        let moved = sign * i128::from(weight.weight) * i128::from(term.weight);
                        *sums.entry(after(weight, term, &self.target)).or_default() += moved;
                    }
                }
            }
        }
        sums.values().all(|&sum| sum == 0)
    }
}

/// `last`∘`first`, as picks from what `first` is applied to.
fn after(last: &LinearTerm, first: &LinearTerm, target: &DomainShape) -> Vec<ComponentPick> {
    let pick = |(pick, &size): (&ComponentPick, &u32)| {
        let inner = first.picks[pick.from as usize];
        ComponentPick { from: inner.from, shift: turn(inner.shift, pick.shift, size) }
    };
    last.picks.iter().zip(&target.sizes).map(pick).collect()
}

fn weight(
    net: &ColouredNet,
    id: PlaceId,
    function: &Function,
    target: &[BasicId],
) -> Result<LinearFunction, FlowError> {
    if id.index() >= net.place_count() {
        return Err(FlowError::UnknownPlace { place: id.0, places: net.place_count() });
    }
    let place = net.place(id);
    match compile(function, net.place_domain(id), &net.basics) {
        Err(error) => Err(FlowError::Function { place, function: function.to_string(), error }),
        Ok(linear) if linear.target != target => {
            let (found, expected) = (net.show_domain(&linear.target), net.show_domain(target));
            Err(FlowError::Elsewhere { place, function: function.to_string(), found, expected })
        }
        Ok(linear) => Ok(linear),
    }
}

fn show_colour(shape: &DomainShape, colour: u32, all: &[BasicDomain]) -> String {
    if shape.basics.is_empty() { show_domain(&[], all) } else { shape.show(colour, all) }
}

/// A bag of modes. It need not be a flow; see [`TransitionFlow::check`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TransitionFlow {
    modes: BTreeMap<NetMode, u64>,
}

/// Change by the modes of a bag together.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the modes together change `{cell}` by {change}")]
pub struct NotCycle {
    /// The place and colour.
    pub cell: String,
    /// Change of the marking, in tokens.
    pub change: i128,
}

impl TransitionFlow {
    /// Each mode so many times; a mode that is listed again adds up.
    pub fn new(modes: impl IntoIterator<Item = (NetMode, u32)>) -> TransitionFlow {
        let mut flow = TransitionFlow::default();
        for (mode, times) in modes {
            // A sum of 32-bit numbers leaves 64 bits only after 2³² of them.
            *flow.modes.entry(mode).or_default() += u64::from(times);
        }
        flow.modes.retain(|_, times| *times > 0);
        flow
    }

    /// The minimal transition semiflows of an unfolding, as bags of modes. Guards are obeyed, as the unfolding has no
    /// mode that they exclude.
    pub fn minimal(
        unfolding: &Unfolding,
        limits: &semiflows::SemiflowLimits,
    ) -> Result<Vec<TransitionFlow>, semiflows::SemiflowsUndecided> {
        let found = semiflows::transition_semiflows(unfolding.net(), limits)?;
        let mode = |&(transition, times): &(TransitionId, u64)| (unfolding.mode(transition), times);
        let flow = |flow: &Semiflow<_>| TransitionFlow { modes: flow.weights.iter().map(mode).collect() };
        Ok(found.all().iter().map(flow).collect())
    }

    /// The transitions that have a mode in the bag: the t-support, seen without colours.
    pub fn transitions(&self) -> Vec<TransitionId> {
        let mut found: Vec<_> = self.modes.keys().map(|mode| mode.transition).collect();
        found.dedup();
        found
    }

    /// The modes with their counts, ordered.
    pub fn modes(&self) -> impl Iterator<Item = (NetMode, u64)> + '_ {
        self.modes.iter().map(|(&mode, &times)| (mode, times))
    }

    /// Whether the modes together change nothing: I·Θ = 0. Guards play no part in that; see
    /// [`TransitionFlow::forbidden`].
    pub fn check(&self, net: &ColouredNet) -> Result<(), NotCycle> {
        let mut sums: BTreeMap<u32, i128> = BTreeMap::new();
        for (&mode, &times) in &self.modes {
            let (mut takes, mut gives) = (Vec::new(), Vec::new());
            net.demand(&[mode], &mut takes).expect("the builder bounds what a mode takes");
            net.append_outputs(mode, &mut gives);
            let mut add = |cell, count: i128| *sums.entry(cell).or_default() += count * i128::from(times);
            takes.into_iter().for_each(|(cell, count)| add(cell, -i128::from(count)));
            gives.into_iter().for_each(|(cell, count)| add(cell, i128::from(count)));
        }
        match sums.into_iter().find(|&(_, change)| change != 0) {
            None => Ok(()),
            Some((cell, change)) => Err(NotCycle { cell: net.cell_name(cell), change }),
        }
    }

    /// The modes that a guard excludes. A flow with such a mode is one of the arcs, but cannot be fired.
    pub fn forbidden(&self, net: &ColouredNet) -> Vec<NetMode> {
        self.modes.keys().copied().filter(|&mode| !net.guard_allows(mode)).collect()
    }
}
