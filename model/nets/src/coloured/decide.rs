//! Conflicts, and guards that wait for a decision.
//!
//! A coordinated cell has states in which the net leaves a choice: which part next, load or unload first. The source
//! keeps the choice out of the net (seed 000, §5.2). A clause of a guard can be *scheduled*; it then holds only if the
//! dispatcher has set its decision variable (the dispatcher-guard DF = ∨ [bdvᵢ ∧ G&ᵢ], definition 40). The net reports
//! which scheduled clauses are in conflict now (the variables vc of definition 51), takes the choice, and plays on. The
//! choice is made elsewhere.

use std::collections::BTreeSet;

use super::marking::ColouredMarking;
use super::net::{ColouredNet, NetMode};
use crate::TransitionId;

/// One clause of a guard, numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClauseId {
    /// The transition with the guard.
    pub transition: TransitionId,
    /// Number of the clause: i − 1 for G&ᵢ.
    pub clause: usize,
}

/// The decision variables bdvᵢ that are true. A clause that is not scheduled needs none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Decisions(BTreeSet<ClauseId>);

impl Decisions {
    /// No decision.
    pub fn none() -> Decisions {
        Decisions::default()
    }

    /// Exactly these.
    pub fn these(clauses: impl IntoIterator<Item = ClauseId>) -> Decisions {
        Decisions(clauses.into_iter().collect())
    }

    /// Whether a decision variable is true.
    pub fn contains(&self, clause: ClauseId) -> bool {
        self.0.contains(&clause)
    }
}

/// Two enabled modes of which the first, when it fires, disables the second (seed 000, L2777-2782).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ModeConflict {
    /// Mode that fires.
    pub winner: NetMode,
    /// Mode that can no longer fire then.
    pub loser: NetMode,
}

impl ColouredNet {
    /// The structural conflicts of a marking, ordered. A mode that disables itself is none.
    pub fn conflicts(&self, marking: &ColouredMarking) -> Vec<ModeConflict> {
        let enabled = self.enabled(marking);
        let mut found = Vec::new();
        for &winner in &enabled {
            let mut after = marking.clone();
            // What would overflow cannot fire, and wins nothing.
            if self.fire(&mut after, winner).is_err() {
                continue;
            }
            let losers = enabled.iter().filter(|&&loser| loser != winner && !self.is_enabled(&after, loser));
            found.extend(losers.map(|&loser| ModeConflict { winner, loser }));
        }
        found
    }

    /// The scheduled clauses with an enabled mode that is in conflict with another: vc is true.
    pub fn requests(&self, marking: &ColouredMarking) -> Vec<ClauseId> {
        let conflicts = self.conflicts(marking);
        let torn: BTreeSet<NetMode> = conflicts.iter().flat_map(|conflict| [conflict.winner, conflict.loser]).collect();
        let clauses: BTreeSet<ClauseId> = torn
            .into_iter()
            .flat_map(|mode| self.clauses_of(mode))
            .filter(|&clause| self.is_scheduled(clause))
            .collect();
        clauses.into_iter().collect()
    }

    /// The clauses G&ᵢ of its guard that a mode satisfies.
    pub fn clauses_of(&self, mode: NetMode) -> Vec<ClauseId> {
        let tones = self.tones_of(mode);
        let cases = self.transitions[mode.transition.index()].guard.iter().flatten().enumerate();
        let holding = cases.filter(|(_, case)| case.holds(&tones));
        holding.map(|(clause, _)| ClauseId { transition: mode.transition, clause }).collect()
    }

    /// Whether a clause waits for the dispatcher.
    pub fn is_scheduled(&self, clause: ClauseId) -> bool {
        let guard = &self.transitions[clause.transition.index()].guard;
        guard.as_ref().and_then(|cases| cases.get(clause.clause)).is_some_and(|case| case.scheduled)
    }

    /// DF: whether the guard allows a mode under these decisions.
    pub fn permits(&self, mode: NetMode, decisions: &Decisions) -> bool {
        let guarded = self.transitions[mode.transition.index()].guard.is_some();
        let clears = |&clause: &ClauseId| !self.is_scheduled(clause) || decisions.contains(clause);
        !guarded || self.clauses_of(mode).iter().any(clears)
    }

    /// The modes that are effectively enabled: by tokens, guard and decisions (seed 000, definition 43 without sensors).
    pub fn enabled_under(&self, marking: &ColouredMarking, decisions: &Decisions) -> Vec<NetMode> {
        self.enabled(marking).into_iter().filter(|&mode| self.permits(mode, decisions)).collect()
    }
}
