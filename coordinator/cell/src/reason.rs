//! Why something does not start: part of every decision that is written down.
//!
//! A reason is data and names what it is about by number, so that it can be compared, kept for years and asked for by
//! machines; [`super::texts`] says it to people. What was started is not given a reason of its own: that it was
//! started before others stands with these.

use std::time::Duration;

use linewright_line::Tick;
use serde::{Deserialize, Serialize};

use super::dispatch::{DispatchRule, Measure};
use super::ids::{ModeId, PartId};
use super::serial;

/// Why something does not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum HoldReason {
    /// What it needs goes to another.
    LostTo(LostDecision),
    /// It is too early; it is not before this.
    NotYet(#[serde(with = "serial::micros")] Tick),
    /// What it needs is kept for one that has waited too long.
    ReservedFor {
        /// The part that has; none if it waits outside.
        part: Option<PartId>,
        /// What is kept for: something this part will do, or that something else does which is in its way.
        mode: ModeId,
    },
    /// No production order wants such a part to enter now.
    NotOrdered,
    /// The schedule has the part do this next.
    PlannedOtherwise(ModeId),
    /// It was tried out what comes of it, and something else leads further.
    LooksWorse(ProgressComparison),
}

/// What leads further, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgressComparison {
    /// What starts instead, and with which part; none if it is better to wait for what happens next.
    pub instead: Option<(ModeId, Option<PartId>)>,
    /// By how much it is better.
    pub gain: Gain,
}

/// How much better one future is than another, by the first measure in which they differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Gain {
    /// Parts are less late, by so much in all, each counted as often as it matters.
    Tardiness(Duration),
    /// So much less work is left at the end of what was looked at.
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

/// To whom something is lost, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LostDecision {
    /// What starts instead.
    pub to: ModeId,
    /// With which part; none if it takes none.
    pub with: Option<PartId>,
    /// The part that would have been next here.
    pub own: Option<PartId>,
    /// Why the other comes first.
    pub by: DecidingRule,
}

/// Why one comes before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum DecidingRule {
    /// It has waited longer than parts should, or longer than the other that has.
    Waited,
    /// It makes way for one that has waited longer than parts should.
    Helps {
        /// Which; none if it waits outside.
        part: Option<PartId>,
    },
    /// It is inside, and the other is not.
    Inside,
    /// A rule says so, and all rules before it say that both are equal.
    Rule {
        #[serde(with = "serial::rule")]
        rule: DispatchRule,
        /// What it says of the other.
        theirs: Measure,
        /// What it says of this one.
        ours: Measure,
    },
    /// No rule says anything: it has waited longer, or as long and has the smaller number.
    Order,
}
