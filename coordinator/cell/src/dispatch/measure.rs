//! The value of a dispatch rule for one candidate: compared exactly, written down with a decision, shown to operators.

use std::cmp::Ordering;

use linewright_cell::DispatchRule;
use serde::{Deserialize, Serialize};

use super::super::serial;

/// Value that a dispatching rule assigns to a candidate at the time of the decision; the smaller one goes first. Two that the
/// rule leaves equal have the same class and value, so nothing is in here that is only to be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    #[serde(with = "serial::rule")]
    pub rule: DispatchRule,
    /// First by this: 0 before 1 before 2.
    pub(crate) class: u8,
    /// Then by this, times `1 / over`.
    pub(crate) value: i64,
    pub(crate) over: u64,
}

impl Measure {
    /// Order of two measures by the same rule.
    pub fn compare(&self, other: &Measure) -> Ordering {
        // 64 times 64 bits fit.
        let [ours, theirs] = [(self, other), (other, self)].map(|(a, b)| i128::from(a.value) * i128::from(b.over));
        self.class.cmp(&other.class).then(ours.cmp(&theirs))
    }
}
