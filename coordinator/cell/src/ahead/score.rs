//! Measures of a simulated future.
//!
//! Of two futures the one in which parts are less late is better, each counted as often as its order matters; then the one
//! that leaves nothing stuck; then the one in which all is finished first; then the one that leaves less to be done at the end
//! of what was looked at; then the one in which parts are finished earlier in all. What has not left by the end is taken to
//! leave after the work that remains on it, as if it had the cell for itself, and all of it not before machines and carriers
//! can have done what is left for them: so two futures over the same time can be compared, and where all is finished the
//! score is exact.

use std::time::Duration;

use linewright_line::Tick;

use super::super::dispatch::PartPriority;
use super::super::production::DispatchConfiguration;
use super::super::reason::Gain;
use super::super::state::PartPlace;
use super::bounds::{SimulationBasis, entering, is_last, weight};
use super::forward_simulation::{Ending, ForwardSimulation};

/// Result of a future; the smaller one is better. Only scores of futures that began at the same moment are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Score {
    /// By how many microseconds parts are late in all, each counted 1 + priority times.
    pub tardiness: u64,
    /// Work that cannot be done any more, in µs.
    pub stuck: u64,
    /// Time from the beginning until all is finished, in µs.
    pub makespan: u64,
    /// Work that is left, in µs.
    pub work: u64,
    /// After how many microseconds parts are finished, in all.
    pub flow: u64,
}

impl Score {
    /// Score of a simulation that ended so.
    pub fn of(
        simulation: &ForwardSimulation,
        desk: &DispatchConfiguration,
        basis: &SimulationBasis,
        ending: Ending,
    ) -> Self {
        let (mut score, state) = (Score::default(), simulation.state());
        let (table, ways) = (state.table(), desk.rules.ways());
        let tally = ScoreTally { began: simulation.began(), end: simulation.now() };
        simulation.left().iter().for_each(|(job, at)| tally.finish(&mut score, job, *at, 1));
        for part in state.parts() {
            let job = desk.job(part.id);
            let (from, work) = match part.place {
                PartPlace::On { cell, arrival: _ } if is_last(table, cell) => (part.since, Duration::ZERO),
                PartPlace::On { cell, arrival: _ } => (tally.end, ways.remaining(cell)),
                PartPlace::In(firing) => {
                    let Some(firing) = state.firing(firing) else { continue };
                    // What has failed stays as it is in every future.
                    let Some(due) = firing.due(table.activity(firing.mode)) else { continue };
                    let end = due.max(tally.end);
                    let after = table.part_out(firing.mode).map_or(Duration::ZERO, |cell| ways.remaining(cell));
                    (tally.end, end.since(tally.end) + after)
                }
            };
            tally.left(&mut score, &job, from, work, 1, ending);
        }
        for order in desk.production().into_iter().flat_map(|production| production.missing()) {
            let work = entering(desk, table, ways, order.product);
            tally.left(&mut score, &order.job(), tally.end, work, order.missing(), ending);
        }
        if ending != Ending::Still {
            let after = tally.end + basis.bounds().need(simulation, desk);
            score.makespan = score.makespan.max(micros(after.since(tally.began)));
        }
        score
    }

    /// Advantage of this one over another.
    pub fn gain(&self, worse: &Score) -> Gain {
        let by = |ours: u64, theirs: u64| Duration::from_micros(theirs.saturating_sub(ours));
        if self.tardiness != worse.tardiness {
            Gain::Tardiness(by(self.tardiness, worse.tardiness))
        } else if self.stuck != worse.stuck {
            Gain::Work(by(self.stuck, worse.stuck))
        } else if self.makespan != worse.makespan {
            Gain::Makespan(by(self.makespan, worse.makespan))
        } else if self.work != worse.work {
            Gain::Work(by(self.work, worse.work))
        } else if self.flow != worse.flow {
            Gain::Flow(by(self.flow, worse.flow))
        } else {
            Gain::Nothing
        }
    }
}

/// Lateness of what never comes.
const LONG: Duration = Duration::from_secs(1_000_000_000);

fn micros(span: Duration) -> u64 {
    u64::try_from(span.as_micros()).unwrap_or(u64::MAX)
}

struct ScoreTally {
    began: Tick,
    end: Tick,
}

impl ScoreTally {
    fn finish(&self, score: &mut Score, job: &PartPriority, at: Tick, count: u32) {
        let times = |value: u64| value.saturating_mul(u64::from(count));
        let late = job.due.map_or(Duration::ZERO, |due| at.since(due));
        score.tardiness = score.tardiness.saturating_add(times(micros(late).saturating_mul(weight(job))));
        let after = micros(at.since(self.began));
        score.makespan = score.makespan.max(after);
        score.flow = score.flow.saturating_add(times(after));
    }

    fn left(&self, score: &mut Score, job: &PartPriority, from: Tick, work: Duration, count: u32, ending: Ending) {
        let left = micros(work).saturating_mul(u64::from(count));
        match ending {
            // The cell has come to stand still with work undone; it has no end that could be early or late.
            Ending::Still if !work.is_zero() => {
                score.stuck = score.stuck.saturating_add(left);
                let mut late = Score::default();
                self.finish(&mut late, job, from + work + LONG, count);
                score.tardiness = score.tardiness.saturating_add(late.tardiness);
            }
            Ending::Still | Ending::Horizon | Ending::Worn => {
                score.work = score.work.saturating_add(left);
                self.finish(score, job, from + work, count);
            }
        }
    }
}
