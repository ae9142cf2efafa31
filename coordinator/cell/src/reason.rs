//! Reason why something does not start: part of every decision that is written down.
//!
//! A reason is data and has numbers for names, so that it can be compared, kept for years and queried by machines;
//! [`super::texts`] has it in words. What was started has no reason of its own: that it was started before others
//! stands with these.

use std::time::Duration;

use linewright_line::Tick;
use serde::{Deserialize, Serialize};

use super::dispatch::{DispatchRule, Measure};
use super::ids::{ModeId, PartId};
use super::serial;

/// Reason why something does not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum HoldReason {
    /// Its tokens go to another.
    LostTo(LostDecision),
    /// It is too early; it is not before this.
    NotYet(#[serde(with = "serial::micros")] Tick),
    /// Its tokens are kept for a part that has waited too long.
    ReservedFor {
        /// The part that has; none if it waits outside.
        part: Option<PartId>,
        /// Mode they are kept for: the part's own, or one that clears its way.
        mode: ModeId,
    },
    /// No production order has such a part enter now.
    NotOrdered,
    /// The schedule has the part do this next.
    PlannedOtherwise(ModeId),
    /// It was simulated, and something else leads further.
    LooksWorse(ProgressComparison),
}

/// The better alternative, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgressComparison {
    /// Mode that starts instead, and with which part; none if it is better to wait for what happens next.
    pub instead: Option<(ModeId, Option<PartId>)>,
    /// Its advantage.
    pub gain: Gain,
}

/// Advantage of one future over another, by the first measure in which they differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Gain {
    /// Parts are less late, by so much in all, each counted as often as it matters.
    Tardiness(Duration),
    /// Work less at the end of the simulation.
    Work(Duration),
    /// All is finished earlier by so much.
    Makespan(Duration),
    /// Parts are finished earlier, by so much in all.
    Flow(Duration),
    /// It is as good.
    Nothing,
}

impl HoldReason {
    /// The modes it names.
    pub(super) fn modes(&self) -> impl Iterator<Item = ModeId> {
        match self {
            HoldReason::LostTo(lost) => Some(lost.to),
            HoldReason::NotYet(_) | HoldReason::NotOrdered => None,
            HoldReason::ReservedFor { mode, .. } | HoldReason::PlannedOtherwise(mode) => Some(*mode),
            HoldReason::LooksWorse(outlook) => outlook.instead.map(|(mode, _)| mode),
        }
        .into_iter()
    }
}

/// The winner of the tokens, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LostDecision {
    /// Mode that starts instead.
    pub to: ModeId,
    /// Its part; none if it takes none.
    pub with: Option<PartId>,
    /// The part that would have been next here.
    pub own: Option<PartId>,
    /// Reason why the other comes first.
    pub by: DecidingRule,
}

/// Reason why one comes before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum DecidingRule {
    /// It has waited longer than parts should, or longer than the other that has.
    Waited,
    /// It makes way for one that has waited longer than parts should.
    Helps {
        /// The part; none if it waits outside.
        part: Option<PartId>,
    },
    /// It is inside, and the other is not.
    Inside,
    /// By this rule; all rules before it have both as equal.
    Rule {
        #[serde(with = "serial::rule")]
        rule: DispatchRule,
        /// Measure of the other.
        theirs: Measure,
        /// Measure of this one.
        ours: Measure,
    },
    /// By no rule: it has waited longer, or as long and has the smaller number.
    Order,
}
