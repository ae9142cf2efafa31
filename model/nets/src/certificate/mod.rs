//! Proofs by structure, with the evidence, and a small checker of the evidence alone.
//!
//! [`decide_by_structure`] looks at the arcs and the initial marking and answers five questions about a net: whether it
//! is free of deadlocks, live, bounded, safe and reversible. Every "yes" and every "no" is a [`Certificate`]: the claim
//! together with data from which [`check`] can see that it is true, without trusting a line of the analyses. A
//! certificate can be written down as text and read back ([`Certificate::parse`]).
//!
//! Marked graphs and state machines are decided completely, in time about linear in the net for the usual ones; of those
//! with thousands of nodes some bounds may stay open. Connected free-choice nets are decided when they are live and
//! bounded, and often when they are not. For every other net the answers are those that conserved sums and empty siphons
//! give, and [`Unknown`] gives the reason why there are no more. Nothing is explored, except for a few thousand markings
//! where a counterexample exists by theory.

mod check;
mod evidence;
mod free_choice;
mod marked_graph;
mod play;
mod state_machine;
mod text;

use std::fmt;

use thiserror::Error;

use crate::{Net, PlaceId, semiflows, siphons};

pub use check::{CertificateRule, Rejected, check};
pub use evidence::{
    Certificate, Component, Dead, Evidence, FiringOrder, NetProperty, NoReturn, RepeatedFiring, Sums, UnboundedCycle,
    WellFormed,
};
pub use text::ParseError;

/// Verdict on a marked net by structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructuralVerdict {
    /// The class by which it was decided.
    pub class: NetClass,
    /// In every reachable marking some transition is enabled.
    pub deadlock_free: CertificateAnswer,
    /// From every reachable marking every transition can be enabled again.
    pub live: CertificateAnswer,
    /// Every place has a bound.
    pub bounded: CertificateAnswer,
    /// Every place has the bound 1.
    pub safe: CertificateAnswer,
    /// From every reachable marking the initial one can be reached.
    pub reversible: CertificateAnswer,
    /// Per place, in order, the most tokens it ever holds. That it holds no more is certified where `bounded` is; that
    /// an exact bound is reached follows from the theorem named in the module that decides the class.
    pub bounds: Vec<TokenBound>,
}

impl StructuralVerdict {
    /// The answer to one of the questions.
    pub fn answer(&self, property: NetProperty) -> &CertificateAnswer {
        match property {
            NetProperty::DeadlockFree => &self.deadlock_free,
            NetProperty::Live => &self.live,
            NetProperty::Bounded => &self.bounded,
            NetProperty::Safe => &self.safe,
            NetProperty::Reversible => &self.reversible,
        }
    }

    /// All certificates.
    pub fn certificates(&self) -> impl Iterator<Item = &Certificate> {
        NetProperty::ALL.into_iter().filter_map(|property| self.answer(property).certificate())
    }
}

impl fmt::Display for StructuralVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "class: {}", self.class)?;
        for property in NetProperty::ALL {
            write!(f, "\n{property}: {}", self.answer(property))?;
        }
        Ok(())
    }
}

/// The class of nets, on which the extent of the answers depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NetClass {
    /// Every place has one producer and one consumer.
    MarkedGraph,
    /// Every transition has one input and one output place.
    StateMachine,
    /// Transitions that share an input place share all: extended free choice.
    FreeChoice,
    /// None of these.
    Other,
}

impl fmt::Display for NetClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NetClass::MarkedGraph => "marked graph",
            NetClass::StateMachine => "state machine",
            NetClass::FreeChoice => "free-choice net",
            NetClass::Other => "none that structure decides",
        })
    }
}

/// The most tokens that a place ever holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenBound {
    /// It can hold so many, and no more.
    Exactly(u128),
    /// It never holds more.
    AtMost(u128),
    /// There is no most.
    Unbounded,
    /// Not decided by structure.
    Unknown,
}

/// The answer to one question.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CertificateAnswer {
    /// It holds, and this is why.
    Yes(Certificate),
    /// It does not hold, and this is why.
    No(Certificate),
    /// Nothing is claimed.
    Unknown(Unknown),
}

impl CertificateAnswer {
    fn yes(property: NetProperty, evidence: Evidence) -> CertificateAnswer {
        CertificateAnswer::Yes(Certificate { property, holds: true, evidence })
    }

    fn no(property: NetProperty, evidence: Evidence) -> CertificateAnswer {
        CertificateAnswer::No(Certificate { property, holds: false, evidence })
    }

    /// Yes or no, if that is known.
    pub fn holds(&self) -> Option<bool> {
        match self {
            CertificateAnswer::Yes(_) => Some(true),
            CertificateAnswer::No(_) => Some(false),
            CertificateAnswer::Unknown(_) => None,
        }
    }

    /// The certificate, if there is an answer.
    pub fn certificate(&self) -> Option<&Certificate> {
        match self {
            CertificateAnswer::Yes(certificate) | CertificateAnswer::No(certificate) => Some(certificate),
            CertificateAnswer::Unknown(_) => None,
        }
    }
}

impl fmt::Display for CertificateAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CertificateAnswer::Yes(_) => f.write_str("yes"),
            CertificateAnswer::No(_) => f.write_str("no"),
            CertificateAnswer::Unknown(why) => write!(f, "unknown: {why}"),
        }
    }
}

/// Reason why nothing is claimed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Unknown {
    /// The class of the net does not allow it.
    #[error("structure alone does not decide this for nets of this class ({0})")]
    Class(NetClass),
    /// There are too many semiflows.
    #[error("the search for conserved sums and repetitions: {0}")]
    Semiflows(semiflows::SemiflowsUndecided),
    /// There are too many siphons.
    #[error("the search for siphons: {0}")]
    Siphons(siphons::SiphonsUndecided),
    /// The conditions of the rank theorem do not hold for a free-choice net.
    #[error("the rank theorem does not apply: the net is not connected")]
    NotWellFormed,
    /// Live by Commoner's theorem, but its list of siphons is no certificate.
    #[error(
        "every siphon found contains a marked trap, so the net is live; but that all were found cannot be certified"
    )]
    Uncertified,
    /// Not live by Commoner's theorem, and no sequence was found that shows it.
    #[error("a siphon of {} places has no marked trap, so the net is not live; but none of the first {markings} markings shows it", siphon.len())]
    NotFound {
        siphon: Vec<PlaceId>,
        /// Number of markings visited.
        markings: usize,
    },
    /// A place in no conserved sum.
    #[error("a place is in no conserved sum; whether it is bounded depends on the marking")]
    Uncovered,
    /// The conserved sums allow more than one token somewhere, and no marking with them was found.
    #[error("conserved sums do not exclude a second token, and no marking with one was found")]
    Loose,
    /// The sequence that shows it is too long to write down.
    #[error("the evidence would take more than {} steps", play::LONGEST)]
    TooLong,
    /// A bound for each place would take too long to find.
    #[error("the net is too large for a bound of each place to be worked out")]
    TooLarge,
}

/// Decides by structure what it can, and certifies every answer.
pub fn decide_by_structure(net: &Net) -> StructuralVerdict {
    if net.is_marked_graph().is_ok() {
        marked_graph::decide(net)
    } else if net.is_state_machine().is_ok() {
        state_machine::decide(net)
    } else {
        free_choice::decide(net)
    }
}
