//! Whether a net is bounded, by the coverability graph.
//!
//! The construction of Karp and Miller (*Parallel program schemata*, 1969): play the net out, and where a marking comes
//! to lie strictly above one that led to it, the places that gained tokens can gain them again and again; their count
//! becomes ω, "as many as you like". The result is finite for every net, and decides boundedness, the bound of each
//! place, which markings can be covered, and which transitions can ever fire. It does not decide liveness or
//! reachability: ω has no number of tokens.
//!
//! Two things keep it small. A label that is already there is not expanded again, nor one that lies below a label with
//! ω; labels are never taken away again, where quicker variants have failed. And where conserved sums cover all places,
//! nothing can grow and no label is compared with those before it. The graph can still be larger than any memory, so
//! there is a limit, and beyond it the answer is [`CoverabilityUndecided`].

mod label;
mod search;

use thiserror::Error;

use crate::{FireError, Marking, NamedId, Net, PlaceId, TransitionId};
use label::MarkingLabel;

pub use search::coverability;

/// Largest size of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoverabilityLimits {
    /// The most labels.
    pub labels: usize,
    /// The most bytes that they may take.
    pub bytes: usize,
    /// The most comparisons of two labels, which is what takes the time: a label is compared with those that led to it,
    /// and with those that have ω.
    pub comparisons: u64,
}

impl Default for CoverabilityLimits {
    /// Limits that take some seconds and a quarter of a gigabyte.
    fn default() -> Self {
        CoverabilityLimits { labels: 1_000_000, bytes: 256 << 20, comparisons: 1 << 29 }
    }
}

/// The graph was not finished: nothing is known about the net as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {labels} generalised markings: {cause}")]
pub struct CoverabilityUndecided {
    /// The labels found until then.
    pub labels: usize,
    pub cause: CoverabilityLimit,
}

/// Limit that stops the construction of the graph.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CoverabilityLimit {
    /// [`CoverabilityLimits::labels`].
    #[error("there are more than allowed")]
    Labels,
    /// [`CoverabilityLimits::bytes`].
    #[error("they take more memory than allowed")]
    Bytes,
    /// [`CoverabilityLimits::comparisons`].
    #[error("more of them had to be compared than allowed")]
    Comparisons,
    /// A place gets more tokens than can be counted.
    #[error("{0}")]
    Overflow(FireError),
    /// A place holds the one count that stands for ω here.
    #[error("{0} has 4294967295 tokens, and at most 4294967294 can be told from infinitely many")]
    TooMany(NamedId<PlaceId>),
}

/// Growth of a net without end: after `prefix` it can play `cycle`, and again, and again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GrowthWitness {
    /// Firings before, from the initial marking.
    pub prefix: Vec<TransitionId>,
    /// Firings that can be repeated for ever; they take away nothing on balance.
    pub cycle: Vec<TransitionId>,
    /// The places that have more tokens after each round.
    pub grows: Vec<PlaceId>,
}

/// Results of the coverability graph of a net.
#[derive(Clone, Debug)]
pub struct Coverability {
    labels: Vec<MarkingLabel>,
    /// Per place, the most tokens; none if there is no most.
    bounds: Vec<Option<u32>>,
    dead: Vec<TransitionId>,
    pump: Option<GrowthWitness>,
}

impl Coverability {
    /// The labels of the graph, for a bounded net its reachable markings: tokens per place, none for ω. In the order of discovery, the initial marking first.
    pub fn labels(&self) -> impl Iterator<Item = impl Iterator<Item = Option<u32>> + '_> + '_ {
        self.labels.iter().map(|label| label.counts())
    }

    /// Whether there is a bound for every place, or a way to grow without end.
    pub fn is_bounded(&self) -> Result<(), &GrowthWitness> {
        self.pump.as_ref().map_or(Ok(()), Err)
    }

    /// The most tokens that a place ever holds; none if it is unbounded.
    pub fn bound_of(&self, place: PlaceId) -> Option<u32> {
        self.bounds[place.index()]
    }

    /// The places that have no bound, in order.
    pub fn unbounded(&self) -> impl Iterator<Item = PlaceId> + '_ {
        (0..).map(PlaceId).zip(&self.bounds).filter(|(_, bound)| bound.is_none()).map(|(place, _)| place)
    }

    /// Whether a marking can be reached that has at least these tokens on every place.
    pub fn is_coverable(&self, marking: &Marking) -> bool {
        self.labels.iter().any(|label| label.covers(marking.as_slice()))
    }

    /// The transitions that never fire, in order.
    pub fn dead_transitions(&self) -> &[TransitionId] {
        &self.dead
    }
}

impl GrowthWitness {
    /// Plays the pump once; whether it is one.
    pub fn is_valid(&self, net: &Net) -> bool {
        let mut marking = net.initial_marking();
        let mut play = |sequence: &[TransitionId]| {
            sequence.iter().all(|&t| net.fire(&mut marking, t).is_ok()).then(|| marking.clone())
        };
        let (Some(before), Some(after)) = (play(&self.prefix), play(&self.cycle)) else { return false };
        let rises = |place: PlaceId| after.tokens(place) > before.tokens(place);
        let keeps = |place: PlaceId| after.tokens(place) >= before.tokens(place);
        !self.grows.is_empty() && net.places().all(keeps) && self.grows.iter().all(|&place| rises(place))
    }
}
