//! The cycle time of the line.
//!
//! The line has completed a cycle when each of its stations has come home from it. The cycle took the time since the end of
//! the one before, as in the report of `linewright run`; if the line stood at home since, the time since motion was enabled
//! there. Faults and stops on the way are part of it. Task-driven stations have no cycles and do not count.
//!
//! Times are those of the arrival of reports. Where a beginning or an end may have passed unreported (after a start of
//! the coordinator, or of a station that was stale) the cycle has no time: it is counted, and not published.

use std::time::Duration;

use linewright_line::Tick;

use super::{Coordinator, StationEntry};

/// A cycle that all stations of the line have completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompletedCycle {
    /// Number of times each station has come home since the line first started: the least of their rounds.
    pub number: i32,
    /// From the end of the cycle before, or from when motion was enabled at home; none where its beginning or its end may have
    /// passed unreported.
    pub took: Option<Duration>,
}

/// The cycle that the line is in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OpenCycle {
    /// Number of the last completed cycle, as of the last time all rounds were known; `None` before the first.
    completed: Option<i32>,
    /// Beginning; `None` if that was not received.
    began: Option<Tick>,
}

impl Coordinator {
    fn cyclic(&self) -> impl Iterator<Item = &StationEntry> {
        self.stations.iter().filter(|station| !station.task_driven)
    }

    /// Whether the rounds of all stations are known and may be compared.
    pub(super) fn knows_rounds(&self) -> bool {
        self.is_of_one_generation() && self.cyclic().all(|station| self.is_known(station))
    }

    /// Motion has been enabled. Where all stations stand at home, at the end of the same round, a cycle begins now.
    pub(super) fn begin_cycle(&mut self) {
        let completed = self.latest_round();
        let at_end = |station: &StationEntry| station.heard.at_home && station.heard.round == completed;
        if self.knows_rounds() && self.cyclic().all(at_end) {
            self.cycle = OpenCycle { completed: Some(completed), began: Some(self.now) };
        }
    }

    /// A report has been taken in. `knew_rounds`: as it was before it; if they were not known, an end may have passed
    /// unheard.
    pub(super) fn follow_cycle(&mut self, knew_rounds: bool) {
        let ended = |station: &StationEntry| station.heard.round.saturating_sub(i32::from(!station.heard.at_home));
        let Some(number) = self.cyclic().map(ended).min() else { return };
        let OpenCycle { completed, began } = self.cycle;
        if completed == Some(number) || !self.knows_rounds() {
            return;
        }
        let is_next = completed.and_then(|completed| completed.checked_add(1)) == Some(number);
        let is_end_heard = is_next && knew_rounds;
        self.cycle = OpenCycle { completed: Some(number), began: is_end_heard.then_some(self.now) };
        if is_next {
            let took = began.filter(|_| is_end_heard).map(|began| self.now.since(began));
            self.cycles.push(CompletedCycle { number, took });
        }
    }
}
