//! The value of a dispatch rule for one candidate: compared exactly, written down with a decision, shown to operators.

use std::cmp::Ordering;
use std::fmt;

use linewright_cell::DispatchRule;
use serde::{Deserialize, Serialize};

use super::super::serial;

/// What a rule says of a candidate, at the time of the decision. Of two by one rule the smaller comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    #[serde(with = "serial::rule")]
    pub rule: DispatchRule,
    /// First by this: 0 before 1 before 2.
    pub(super) class: u8,
    /// Then by this, times `1 / over`.
    pub(super) value: i64,
    pub(super) over: u64,
}

impl Measure {
    /// Which of two by the same rule comes first.
    pub fn compare(&self, other: &Measure) -> Ordering {
        // 64 times 64 bits fit.
        let [ours, theirs] = [(self, other), (other, self)].map(|(a, b)| i128::from(a.value) * i128::from(b.over));
        self.class.cmp(&other.class).then(ours.cmp(&theirs))
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.value as f64 / 1e6;
        let when = |f: &mut fmt::Formatter<'_>, what: &str| match self.value {
            0.. => write!(f, "{what} in {seconds} s"),
            _ => write!(f, "{what} {} s ago", -seconds),
        };
        match (self.rule, self.class) {
            (DispatchRule::Fifo, 0) => write!(f, "has waited {} s", 0.0 - seconds),
            (DispatchRule::Fifo, _) => f.write_str("has not come yet"),
            (DispatchRule::ShortestProcessingTime, _) => write!(f, "takes {seconds} s"),
            (DispatchRule::EarliestDueDate, 0) => when(f, "due"),
            (DispatchRule::LeastSlack, 0) => write!(f, "slack {seconds} s"),
            (DispatchRule::CriticalRatio, 0) => write!(f, "ratio {:.2}", self.value as f64 / self.over as f64),
            (DispatchRule::EarliestDueDate | DispatchRule::LeastSlack | DispatchRule::CriticalRatio, _) => {
                f.write_str("never due")
            }
            (DispatchRule::Priority, _) => write!(f, "priority {}", self.value.saturating_neg()),
            (DispatchRule::Schedule, 0) => when(f, "late: planned"),
            (DispatchRule::Schedule, 1) => when(f, "planned"),
            (DispatchRule::Schedule, _) => f.write_str("not planned"),
        }
    }
}
