//! Several replications, a given number or as many as a precision takes, played side by side.

use std::ops::Range;
use std::thread;

use super::super::estimate::Estimate;
use super::{CellStudy, ReplicationFigures};

/// Least number of replications where a precision is given: an interval of fewer is wide.
const LEAST: usize = 5;

/// Number of replications.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplicationGoal {
    /// That number; at least, where a precision is given.
    pub replications: usize,
    /// Precision of throughput and time in the cell to be reached, as a fraction.
    pub precision: Option<f64>,
    /// At most so often.
    pub most: usize,
}

impl CellStudy {
    /// Plays replications 0 and up, in so many threads, and gives their figures in order. What comes out does not depend on
    /// the number of threads: each replication follows from its number alone, and how many there are from those before.
    ///
    /// It ends with the first one that has a problem.
    pub fn replicate(&self, goal: &ReplicationGoal, threads: usize) -> Vec<ReplicationFigures> {
        let least = if goal.precision.is_some() { goal.replications.max(LEAST) } else { goal.replications };
        let least = least.min(goal.most);
        let mut all = self.side_by_side(0..least, threads);
        if let Some(problem) = all.iter().position(|figures| figures.problem.is_some()) {
            all.truncate(problem + 1);
            return all;
        }
        let Some(precision) = goal.precision else { return all };
        let mut enough = least;
        while !self.is_precise(&all[..enough], precision) && enough < goal.most {
            enough += 1;
            if all.len() < enough {
                let next = all.len()..(all.len() + threads.max(1)).min(goal.most);
                all.extend(self.side_by_side(next, threads));
            }
            if all[enough - 1].problem.is_some() {
                break;
            }
        }
        all.truncate(enough);
        all
    }

    /// Whether throughput and time in the cell are known so precisely.
    pub fn is_precise(&self, figures: &[ReplicationFigures], precision: f64) -> bool {
        let is_within = |estimate: Option<Estimate>| estimate.is_some_and(|estimate| estimate.is_within(precision));
        is_within(self.estimate(figures, |of| Some(of.throughput)))
            && is_within(self.estimate(figures, |of| of.in_cell))
    }

    /// A figure over several replications, with the scenario's confidence; none if no replication has it.
    pub fn estimate(
        &self,
        figures: &[ReplicationFigures],
        value: impl Fn(&ReplicationFigures) -> Option<f64>,
    ) -> Option<Estimate> {
        let values: Vec<f64> = figures.iter().filter_map(value).collect();
        Estimate::of(values.into_iter(), self.scenario.confidence)
    }

    fn side_by_side(&self, numbers: Range<usize>, threads: usize) -> Vec<ReplicationFigures> {
        let threads = threads.clamp(1, numbers.len().max(1));
        let figures = |number| self.figures(&self.play(number));
        if threads == 1 {
            return numbers.map(figures).collect();
        }
        let mut all: Vec<Option<ReplicationFigures>> = numbers.clone().map(|_| None).collect();
        thread::scope(|scope| {
            let each = (0..threads).map(|first| {
                let mine = numbers.clone().skip(first).step_by(threads);
                scope.spawn(move || mine.map(|number| (number, figures(number))).collect::<Vec<_>>())
            });
            for played in each.collect::<Vec<_>>() {
                // A panic of one replication is one of all.
                for (number, figures) in played.join().expect("a replication panicked") {
                    all[number - numbers.start] = Some(figures);
                }
            }
        });
        all.into_iter().flatten().collect()
    }
}
