//! Contents of a certificate: plain data, no behaviour.
//!
//! Each kind of evidence has here what it proves and why. The reasons are theorems; the data is what makes their
//! conditions easy to check. To verify a claim, this file and [`super::check`] are enough.

use std::fmt;

use crate::{PlaceId, TransitionId};

/// Claim about a marked net, or its negation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NetProperty {
    /// In every reachable marking some transition is enabled.
    DeadlockFree,
    /// From every reachable marking every transition can be enabled again (seed 002 §3.1, Definition 1).
    Live,
    /// For each place there is a number of tokens that it never exceeds.
    Bounded,
    /// No place ever holds more than one token (Definition 1).
    Safe,
    /// From every reachable marking the initial one can be reached (Definition 1).
    Reversible,
}

impl NetProperty {
    /// All properties, in the order of reports.
    pub const ALL: [NetProperty; 5] = [
        NetProperty::DeadlockFree,
        NetProperty::Live,
        NetProperty::Bounded,
        NetProperty::Safe,
        NetProperty::Reversible,
    ];
}

impl fmt::Display for NetProperty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NetProperty::DeadlockFree => "deadlock-free",
            NetProperty::Live => "live",
            NetProperty::Bounded => "bounded",
            NetProperty::Safe => "safe",
            NetProperty::Reversible => "reversible",
        })
    }
}

/// A claim about a net, with its proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Certificate {
    /// Property claimed.
    pub property: NetProperty,
    /// Whether it is claimed to hold, or not to hold.
    pub holds: bool,
    /// Evidence that a checker accepts.
    pub evidence: Evidence,
}

/// Reason why a claim is true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// See [`FiringOrder`].
    Order(FiringOrder),
    /// See [`Component`]. Proves *live* when every transition starts in one of the components and each has a token;
    /// *reversible* when every token is in one; *deadlock-free* when one of them has a token and a transition.
    Components(Vec<Component>),
    /// A marked trap whose places each have a transition that needs nothing else. Proves *deadlock-free*: the trap
    /// always has a token, and that token can move.
    Trap(Vec<PlaceId>),
    /// See [`Sums`]. Proves *bounded*, and *safe* when no bound is above 1.
    Sums(Sums),
    /// See [`WellFormed`]. Proves *live* and *deadlock-free*; and *reversible* when every trap is marked (Desel and
    /// Esparza 1995, chapter 8: in a live and bounded free-choice net the home markings are those that mark all traps).
    WellFormed(WellFormed),
    /// Refutes *reversible*: the net is live by the first part, so a transition that feeds the trap will fire. The trap
    /// has no token initially and always one thereafter.
    UnmarkedTrap(WellFormed, Vec<PlaceId>),
    /// See [`Dead`]. Refutes *live*.
    Dead(Dead),
    /// Refutes *deadlock-free*: a sequence after which nothing is enabled.
    Deadlock(Vec<RepeatedFiring>),
    /// Refutes *safe*: a sequence after which the place holds more than one token.
    Overfull(Vec<RepeatedFiring>, PlaceId),
    /// See [`UnboundedCycle`]. Refutes *bounded*.
    Pump(UnboundedCycle),
    /// See [`NoReturn`]. Refutes *reversible*.
    NoReturn(NoReturn),
}

/// One transition, fired several times in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RepeatedFiring {
    pub transition: TransitionId,
    /// Number of times, at least 1.
    pub times: u64,
}

/// Transitions in an order that rises along every empty place between them.
///
/// Each input place of a listed transition has exactly one producer, listed too, and exactly one consumer, all with
/// weight 1: the listed transitions are a marked graph on which nothing else has any influence. If a circuit in it had
/// no token, the order would rise all the way round and come back to where it began. So every circuit has a token, and
/// a marked graph is live iff that is so (Commoner, Holt, Even and Pnueli, *Marked directed graphs*, 1971, Theorem 1;
/// Murata 1989, §VI). Proves *live* when all transitions are listed, *deadlock-free* when one is.
///
/// Proves *reversible* when the output places of listed transitions have one consumer, listed too, and no other
/// transition is enabled: what is listed and what is not share no place, the rest stands still for ever, and in a live
/// marked graph any firing counts x are completed to the same number k of firings of each by k − x, which can be
/// played (Murata 1989, §VI), and lead back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FiringOrder {
    /// The transitions, first to last.
    pub transitions: Vec<TransitionId>,
}

/// A part of a state machine that can be walked through from everywhere to everywhere, and not left.
///
/// Walking from the root by `out`, each transition starting where the walk has been, gives the places of the part; each
/// of them is led back to the root by `back`, each transition ending where a way to the root is known. Then a token in
/// the part can reach every transition of it, again and again, and return (seed 002 §3.1, Theorems 1 and 2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Any place of the part.
    pub root: PlaceId,
    /// Transitions that lead from the root to all other places.
    pub out: Vec<TransitionId>,
    /// Transitions that lead from all other places to the root, the last steps first.
    pub back: Vec<TransitionId>,
}

/// Weighted sums of tokens that never grow.
///
/// No transition makes a sum larger, except such as take from `dead`, a siphon that is empty initially: these never
/// fire. A place with weight w in a sum that is s initially never holds more than s / w tokens.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    /// An empty siphon, in order; often without places.
    pub dead: Vec<PlaceId>,
    /// The sums: place and weight.
    pub sums: Vec<Vec<(PlaceId, u64)>>,
    /// For each place of the net, in order, the sum that bounds it, and the bound: s / w, rounded down.
    pub bounds: Vec<(usize, u128)>,
}

/// Evidence that a free-choice net is live and bounded, by the rank theorem.
///
/// A connected net of extended free choice, with places and transitions, is live and bounded iff it has a positive
/// conserved sum and a positive repetition, the rank of its incidence matrix is one less than the number of its
/// clusters, and no siphon is empty initially (Desel and Esparza, *Free Choice Petri Nets*, 1995, chapter 6). A cluster
/// is a place with all that take from it, and all that these take from.
///
/// The rank is at most the number of transitions less the number of independent vectors in `flows`. It is at least what
/// it is modulo a prime. The checker computes the second and compares.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WellFormed {
    /// A weight for each place, positive; their sum is conserved.
    pub conserved: Vec<u64>,
    /// A count for each transition, positive; firing so often leads back.
    pub repeated: Vec<u64>,
    /// Independent solutions of C·x = 0.
    pub flows: Vec<Vec<(TransitionId, i64)>>,
}

/// A transition that is dead after a sequence: it takes from a siphon that is empty then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dead {
    /// Firings before.
    pub run: Vec<RepeatedFiring>,
    /// The siphon, empty after that.
    pub siphon: Vec<PlaceId>,
    /// A transition that takes from it.
    pub transition: TransitionId,
}

/// A sequence that can be repeated for ever, and leaves more tokens on a place each time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnboundedCycle {
    /// Firings before.
    pub prefix: Vec<RepeatedFiring>,
    /// Firings that can be repeated: they take away nothing on balance.
    pub cycle: Vec<RepeatedFiring>,
    /// A place that gains.
    pub place: PlaceId,
}

/// A sequence that makes a weighted sum larger which nothing makes smaller.
///
/// No transition makes the sum smaller, except such as take from `dead`, a siphon that is empty initially: these never
/// fire. So the initial marking, where the sum was smaller, is out of reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoReturn {
    /// The sequence.
    pub run: Vec<RepeatedFiring>,
    /// An empty siphon, in order; often without places.
    pub dead: Vec<PlaceId>,
    /// Place and weight, which may be negative.
    pub weights: Vec<(PlaceId, i64)>,
}
