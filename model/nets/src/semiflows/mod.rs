//! Minimal semiflows: sums of tokens that never change, and firings that lead back.
//!
//! A *place semiflow* is a weighting y ≥ 0 of the places, not all zero, with y·C = 0: the weighted sum of tokens is the
//! same in every reachable marking. A *transition semiflow* is a count x ≥ 0 of firings with C·x = 0: a sequence with
//! these counts leads back to where it began. [`crate::structure::Incidence`] checks such claims; this module finds
//! them, all that are *minimal*: none with a smaller support, and no common divisor. Every other semiflow is a sum of
//! positive rational multiples of them. In a strongly connected marked graph the minimal place semiflows are its
//! elementary circuits (Murata, *Petri nets: properties, analysis and applications*, 1989, §VI).
//!
//! There can be exponentially many. The search is bounded by [`SemiflowLimits`] and ends in the complete list or in
//! [`SemiflowsUndecided`], never in a part of the list. Where the list is too long, [`place_flow_basis`] still describes all
//! conserved sums, though with negative weights, from which no bound follows.

mod basis;
mod consequences;
pub(crate) mod rays;
mod row;

use thiserror::Error;

use crate::{Net, PlaceId, TransitionId};
use rays::Matrix;

/// A minimal semiflow: the nodes of its support, in order, each with its weight.
///
/// Weights fit 63 bits, so that a weighted sum of 32-bit counts over all places of a net always fits 128.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Semiflow<I> {
    /// Node and weight, never empty, all weights positive, with greatest common divisor 1.
    pub weights: Vec<(I, u64)>,
}

impl<I: Copy + Ord> Semiflow<I> {
    /// The weight of a node; zero outside the support.
    pub fn weight(&self, node: I) -> u64 {
        self.weights.binary_search_by_key(&node, |&(node, _)| node).map_or(0, |at| self.weights[at].1)
    }

    /// The nodes with a weight, in order.
    pub fn support(&self) -> impl ExactSizeIterator<Item = I> + '_ {
        self.weights.iter().map(|&(node, _)| node)
    }
}

/// A vector that may have negative entries: one element of a basis.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BasisFlow<I> {
    /// Node and entry, never empty, no entry zero, the first one positive.
    pub entries: Vec<(I, i64)>,
}

/// All minimal semiflows of a net, ordered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Semiflows<I> {
    flows: Vec<Semiflow<I>>,
    /// Node and number of a semiflow that has it in its support, ordered.
    through: Vec<(I, u32)>,
}

impl<I: Copy + Ord> Semiflows<I> {
    fn new(flows: Vec<Semiflow<I>>) -> Self {
        let number = |(n, flow): (u32, &Semiflow<I>)| flow.support().map(move |node| (node, n)).collect::<Vec<_>>();
        let mut through: Vec<_> = (0..).zip(&flows).flat_map(number).collect();
        through.sort_unstable();
        Semiflows { flows, through }
    }

    /// The semiflows, ordered by their supports and weights.
    pub fn all(&self) -> &[Semiflow<I>] {
        &self.flows
    }

    /// The semiflows with a node in their support.
    pub fn through(&self, node: I) -> impl Iterator<Item = &Semiflow<I>> {
        let start = self.through.partition_point(|&(other, _)| other < node);
        let of_node = self.through[start..].iter().take_while(move |&&(other, _)| other == node);
        of_node.map(|&(_, n)| &self.flows[n as usize])
    }

    /// Whether a node is in the support of some semiflow.
    pub fn covers(&self, node: I) -> bool {
        self.through(node).next().is_some()
    }
}

/// Largest size of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SemiflowLimits {
    /// The most vectors at a time.
    pub rows: usize,
    /// The most bytes that these may take.
    pub bytes: usize,
    /// The most pairs of vectors that are looked at.
    pub combinations: u64,
    /// The most looks at entries and third vectors that decide whether a pair counts, which is what takes the time.
    pub looks: u64,
}

impl Default for SemiflowLimits {
    /// Limits that take some seconds and a quarter of a gigabyte.
    fn default() -> Self {
        SemiflowLimits { rows: 200_000, bytes: 256 << 20, combinations: 20_000_000, looks: 500_000_000 }
    }
}

/// The search did not come to an end: nothing is known about which semiflows there are.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {eliminated} of {of} equations, with {rows} vectors at hand: {cause}")]
pub struct SemiflowsUndecided {
    /// Number of equations solved: one per transition for place semiflows, one per place for the others.
    pub eliminated: usize,
    /// Number of equations.
    pub of: usize,
    /// Number of vectors that solved them.
    pub rows: usize,
    /// Limit that stopped the search.
    pub cause: SemiflowLimit,
}

/// Limit that stops a search for semiflows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SemiflowLimit {
    /// [`SemiflowLimits::rows`].
    #[error("there are more vectors than allowed")]
    Rows,
    /// [`SemiflowLimits::bytes`].
    #[error("the vectors take more memory than allowed")]
    Bytes,
    /// [`SemiflowLimits::combinations`] or [`SemiflowLimits::looks`].
    #[error("more pairs of vectors had to be combined than allowed")]
    Combinations,
    /// A weight does not fit the numbers used.
    #[error("a weight needs more than 63 bits")]
    Overflow,
}

/// All minimal place semiflows.
pub fn place_semiflows(net: &Net, limits: &SemiflowLimits) -> Result<Semiflows<PlaceId>, SemiflowsUndecided> {
    let found = rays::minimal_solutions(&by_place(net), limits)?;
    Ok(Semiflows::new(found.into_iter().map(|flow| semiflow(flow, PlaceId)).collect()))
}

/// All minimal transition semiflows.
pub fn transition_semiflows(net: &Net, limits: &SemiflowLimits) -> Result<Semiflows<TransitionId>, SemiflowsUndecided> {
    let found = rays::minimal_solutions(&by_transition(net), limits)?;
    Ok(Semiflows::new(found.into_iter().map(|flow| semiflow(flow, TransitionId)).collect()))
}

/// A basis of the integer y with y·C = 0: each of them is a sum of whole multiples of these.
pub fn place_flow_basis(net: &Net) -> Result<Vec<BasisFlow<PlaceId>>, SemiflowsUndecided> {
    let flow =
        |entries: row::SparseVector| BasisFlow { entries: entries.into_iter().map(|(i, n)| (PlaceId(i), n)).collect() };
    Ok(basis::integer_solutions(&by_place(net))?.into_iter().map(flow).collect())
}

/// A basis of the integer x with C·x = 0.
pub fn transition_flow_basis(net: &Net) -> Result<Vec<BasisFlow<TransitionId>>, SemiflowsUndecided> {
    let flow = |entries: row::SparseVector| BasisFlow {
        entries: entries.into_iter().map(|(i, n)| (TransitionId(i), n)).collect(),
    };
    Ok(basis::integer_solutions(&by_transition(net))?.into_iter().map(flow).collect())
}

/// The rank of the incidence matrix.
pub fn rank(net: &Net) -> Result<usize, SemiflowsUndecided> {
    Ok(net.place_count() - basis::integer_solutions(&by_place(net))?.len())
}

fn semiflow<I>(weights: row::SparseVector, id: fn(u32) -> I) -> Semiflow<I> {
    let weight = |(index, weight): (u32, i64)| (id(index), weight.unsigned_abs());
    Semiflow { weights: weights.into_iter().map(weight).collect() }
}

/// C, a row per place.
pub(crate) fn by_place(net: &Net) -> Matrix {
    let incidence = net.incidence();
    let mut rows = vec![Vec::new(); net.place_count()];
    for t in net.transitions() {
        incidence.column(t).iter().for_each(|&(p, change)| rows[p.index()].push((t.0, change)));
    }
    Matrix { rows, columns: net.transition_count() }
}

/// The transpose of C: a row per transition.
pub(crate) fn by_transition(net: &Net) -> Matrix {
    let incidence = net.incidence();
    let row = |t| incidence.column(t).iter().map(|&(p, change)| (p.0, change)).collect();
    Matrix { rows: net.transitions().map(row).collect(), columns: net.place_count() }
}
