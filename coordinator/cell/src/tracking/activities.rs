//! Activities of the past, one by one: for charts, tables, and other sums.

use std::collections::BTreeMap;

use linewright_line::Tick;

use super::super::ids::{FiringId, ModeId, PartId};
use super::super::record::{ActivityStep, Record};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FinishedActivity {
    /// Number of the activity.
    pub firing: FiringId,
    pub mode: ModeId,
    /// Its part; none if it takes none.
    pub part: Option<PartId>,
    /// Start.
    pub began: Tick,
    /// Failure with its time and reason, if there was one.
    pub failed: Option<ActivityFailed>,
    /// End; none while it is in progress, or waits for an operator's answer.
    pub ended: Option<Tick>,
}

/// Failure of an activity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActivityFailed {
    /// Time of the event, in µs of the caller's clock.
    pub at: Tick,
    /// Reason, in words.
    pub cause: String,
}

/// All activities that take time, in the order in which they started. Memory: some words for each.
#[derive(Clone, Debug, Default)]
pub struct Activities {
    done: Vec<FinishedActivity>,
    open: BTreeMap<FiringId, usize>,
}

impl Activities {
    /// The next record, in the order in which they were written. One of an activity whose start is unknown changes nothing.
    pub fn take(&mut self, record: &Record) {
        match record.fact.activity_step() {
            Some(ActivityStep::Started { firing, mode, part, orders: _ }) => {
                self.open.insert(firing, self.done.len());
                self.done.push(FinishedActivity { firing, mode, part, began: record.at, failed: None, ended: None });
            }
            Some(ActivityStep::Raised { firing, cause }) => {
                if let Some(done) = self.open.get(&firing).map(|&at| &mut self.done[at]) {
                    done.failed = Some(ActivityFailed { at: record.at, cause: cause.summary() });
                }
            }
            Some(ActivityStep::Ended { firing } | ActivityStep::Closed { firing, .. }) => {
                if let Some(done) = self.open.remove(&firing).map(|at| &mut self.done[at]) {
                    done.ended = Some(record.at);
                }
            }
            Some(ActivityStep::Fired { .. }) | None => (),
        }
    }

    /// Finished activities, by start.
    pub fn all(&self) -> &[FinishedActivity] {
        &self.done
    }
}
