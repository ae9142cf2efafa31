//! A timed net condition/event system: the tables beside the net, in the form in which they are read.
//!
//! A [`Tnces`] exists only in sound form (see [`super::TncesBuilder`]) and never changes. Bounds are kept as written;
//! exploration divides them by their common unit first.

use super::chain::Chain;
use super::{ArcClock, Deadline, FiringPolicy, Interval, Semantics};
use crate::{Net, PlaceId, TransitionId};

/// A timed net condition/event system ⟨P, T, F, m₀, ψ, CN, EN, DC⟩ (seed 003 §3.2.2, L372), without the ports ψ, which
/// are a matter of composition.
///
/// # Panics
/// Methods that take an id panic when it is not an id of the net.
#[derive(Clone, Debug)]
pub struct Tnces {
    pub(super) net: Net,
    pub(super) semantics: Semantics,
    /// Per transition.
    pub(super) rows: Vec<TransitionRow>,
    /// D₀, per place.
    pub(super) ages: Vec<u32>,
    /// Per transition: what it forces. Empty for those that are forced themselves.
    pub(super) chains: Vec<Chain>,
}

/// Table row of one transition.
#[derive(Clone, Debug, Default)]
pub(super) struct TransitionRow {
    /// CN: each place must have so many tokens.
    pub(super) conditions: Box<[(PlaceId, u32)]>,
    /// EN: of each group, one must fire in the same step. No group: spontaneous.
    pub(super) groups: Box<[Box<[TransitionId]>]>,
    /// [DR, DL], in the order of the preset.
    pub(super) intervals: Box<[Interval]>,
    /// Whether only the environment decides when it fires.
    pub(super) external: bool,
}

impl Tnces {
    /// The net underneath.
    pub fn net(&self) -> &Net {
        &self.net
    }

    /// The reading of time.
    pub fn semantics(&self) -> Semantics {
        self.semantics
    }

    /// The system with other semantics.
    pub fn with_semantics(mut self, semantics: Semantics) -> Tnces {
        self.semantics = semantics;
        self
    }

    /// CN: the places a transition reads, and how many tokens each must have; ordered by place.
    pub fn conditions(&self, transition: TransitionId) -> &[(PlaceId, u32)] {
        &self.rows[transition.index()].conditions
    }

    /// EN: the sources of a transition, in groups. It is called when of each group at least one fires. Several arcs in
    /// mode *any* are one group, in mode *all* one group each.
    pub fn sources(&self, transition: TransitionId) -> impl ExactSizeIterator<Item = &[TransitionId]> {
        self.rows[transition.index()].groups.iter().map(AsRef::as_ref)
    }

    /// [DR, DL] of the input arcs, in the order of [`Net::preset`].
    pub fn intervals(&self, transition: TransitionId) -> &[Interval] {
        &self.rows[transition.index()].intervals
    }

    /// Whether event arcs lead to the transition, so that it never fires of itself.
    pub fn is_forced(&self, transition: TransitionId) -> bool {
        !self.rows[transition.index()].groups.is_empty()
    }

    /// Whether the environment decides when the transition fires: it may wait for ever.
    pub fn is_external(&self, transition: TransitionId) -> bool {
        self.rows[transition.index()].external
    }

    /// D₀: the age of the tokens that are on a place at the beginning.
    pub fn initial_age(&self, place: PlaceId) -> u32 {
        self.ages[place.index()]
    }

    /// The transitions that fire of themselves, in order.
    pub fn spontaneous(&self) -> impl Iterator<Item = TransitionId> + '_ {
        self.net.transitions().filter(|&t| !self.is_forced(t))
    }

    /// Whether what is decided in whole numbers of time also holds for time as a continuum, as far as reachable
    /// markings, deadlocks, and shortest and longest times go.
    ///
    /// It does where all conditions on time are of the form "at least" or "at most", both ends included: then every run
    /// can be shifted to whole numbers (T. Henzinger, Z. Manna and A. Pnueli, *What good are digital clocks?*, 1992; for
    /// time Petri nets L. Popova-Zeugmann, *Time and Petri Nets*, 2013). It may not where "too old" or "not old enough
    /// yet" lets something else go on: a forced transition with an interval, or an expired token under
    /// [`FiringPolicy::Earliest`]. There the system in whole numbers is the system.
    pub fn covers_continuous_time(&self) -> bool {
        let bounded = |row: &TransitionRow| row.intervals.iter().any(|interval| interval.latest.is_some());
        let timed = |row: &TransitionRow| row.intervals.iter().any(|&interval| interval != Interval::ANY);
        let expires = self.semantics.firing == FiringPolicy::Earliest && self.semantics.deadline == Deadline::Expires;
        self.rows.iter().all(|row| !(expires && bounded(row)) && (row.groups.is_empty() || !timed(row)))
    }

    /// The largest unit of time in which the state space is the same: the common divisor of all bounds and initial
    /// ages. It is 1 where a transition may fire at any time and whole numbers are not the continuum.
    pub fn unit(&self) -> u32 {
        let waits = self.semantics.firing == FiringPolicy::Window || self.rows.iter().any(|row| row.external);
        if waits && !self.covers_continuous_time() {
            return 1;
        }
        let bounds = self.rows.iter().flat_map(|row| row.intervals.iter());
        let bounds = bounds.flat_map(|interval| [interval.earliest, interval.latest.unwrap_or(0)]);
        bounds.chain(self.ages.iter().copied()).fold(0, gcd).max(1)
    }

    /// Whether the clock of a reading belongs to the tokens.
    pub(super) fn counts_tokens(&self) -> bool {
        self.semantics.clock == ArcClock::TokenAge
    }
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}
