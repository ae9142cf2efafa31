//! An activity between its start and its end, and the progress of its orders.
//!
//! ```text
//!  Started ──all orders ended, or its time is over──▶ Ended (the firing is gone)
//!     │
//!     └──an order failed, or the limit ran out──▶ failed: it keeps tokens and part until an answer
//!
//!  an order:  written ──taken on──▶ running ──▶ ended
//!                │                     │          ▲ the end of a failed activity's order may still be received
//!                └──────────▶ failed ◀─┘──────────┘
//! ```

use linewright_line::{StationId, Tick};
use serde::{Deserialize, Serialize};

use super::ids::{FiringId, ModeId, OrderKey, PartId};
use super::plan::{ActivityTiming, PlayedActivity};
use super::record::{ActivityFailure, OrderFailure};
use super::serial;

/// An activity in progress.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OngoingActivity {
    /// Number of the activity, unique in its cell.
    pub id: FiringId,
    /// Its mode; the table has the tokens it has taken and will give.
    pub mode: ModeId,
    /// The part it holds.
    pub part: Option<PartId>,
    /// Start. All limits count from here.
    #[serde(with = "serial::micros")]
    pub began: Tick,
    /// Its orders to stations, as the activity lists them.
    pub orders: Vec<OngoingOrder>,
    /// Current phase.
    pub phase: ActivityPhase,
    /// Before this no limit runs out.
    #[serde(with = "serial::micros")]
    pub(super) spared_until: Tick,
}

/// Phase of an activity in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ActivityPhase {
    /// On its way to its end.
    Running,
    /// It will not end by itself.
    Failed(ActivityFailure),
}

/// One order of an activity in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OngoingOrder {
    /// Key of the order.
    pub key: OrderKey,
    #[serde(with = "serial::station")]
    pub station: StationId,
    /// Its progress.
    pub state: OrderProgress,
    /// Time by which it should have ended.
    #[serde(with = "serial::micros")]
    pub limit: Tick,
}

/// Progress of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum OrderProgress {
    /// No report. It may have been sent or not; [`super::Coordination::sending`] has that for this life.
    Written,
    /// The station has taken it on.
    Running,
    /// It is done.
    Ended,
    /// It will not be done, as far as is known.
    Failed(OrderFailure),
}

/// Record that a firing needs next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PendingRecord {
    /// Nothing yet.
    Wait,
    End,
    Fail(ActivityFailure),
}

impl OngoingActivity {
    /// Result of its orders.
    pub(super) fn next(&self) -> PendingRecord {
        match self.phase {
            ActivityPhase::Failed(_) => return PendingRecord::Wait,
            ActivityPhase::Running => (),
        }
        for order in &self.orders {
            match order.state {
                OrderProgress::Failed(failure) => {
                    return PendingRecord::Fail(ActivityFailure::Order { key: order.key, failure });
                }
                OrderProgress::Written | OrderProgress::Running | OrderProgress::Ended => (),
            }
        }
        let done = !self.orders.is_empty() && self.orders.iter().all(|order| order.state == OrderProgress::Ended);
        if done { PendingRecord::End } else { PendingRecord::Wait }
    }

    /// Time of the next step without an arrival: its end, or its first limit.
    pub(super) fn due(&self, activity: &PlayedActivity) -> Option<Tick> {
        match self.phase {
            ActivityPhase::Failed(_) => return None,
            ActivityPhase::Running => (),
        }
        let ActivityTiming::Decided { time, limit } = activity.kind else { return None };
        if self.orders.is_empty() {
            return Some(self.began + time);
        }
        let open = self.orders.iter().filter(|order| order.is_open()).map(|order| order.limit);
        let first = open.chain(limit.map(|limit| self.began + limit)).min()?;
        Some(first.max(self.spared_until))
    }
}

impl OngoingOrder {
    /// Whether its end is waited for.
    pub fn is_open(&self) -> bool {
        match self.state {
            OrderProgress::Written | OrderProgress::Running => true,
            OrderProgress::Ended | OrderProgress::Failed(_) => false,
        }
    }
}
