//! Figures of one replication of a cell, from its records, without what was over before the warm-up's end.
//!
//! Times of resources are those of ISO 22400-2. *Worked* is the actual unit processing time (AUPT): the time in which the
//! resource worked on or carried a part, without the time in which it stood meanwhile. *Down* is the actual unit down time
//! (ADOT). Both are parts of the observed time, which is the planned busy time (PBT) here: a simulation plans no pauses.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::Record;
use linewright_coordinator_cell::compile::sheet;
use linewright_coordinator_cell::production::ProductionOrder;
use linewright_coordinator_cell::tracking::{Activities, CellSummary, Tracking};
use linewright_line::Tick;

use super::{CellStudy, PlayedReplication, Standstill, StudyProblem};

/// The figures of one replication. Figures without values, such as the lateness where nothing is due, are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicationFigures {
    /// Time observed, without the warm-up.
    pub observed: Duration,
    /// Parts that left.
    pub parts: usize,
    /// Parts that left, in an hour.
    pub throughput: f64,
    /// Parts inside, in the mean over time.
    pub inside: f64,
    /// Seconds from entering to leaving, in the mean over parts that left.
    pub in_cell: Option<f64>,
    /// Of these seconds those in which a part was neither worked on nor moved.
    pub waited: Option<f64>,
    /// Orders that were done.
    pub orders: usize,
    /// Orders that were open at the end.
    pub open: usize,
    /// Of these, those that were due by then.
    pub overdue: usize,
    /// Seconds from the release of an order to its end, in the mean over orders that were done.
    pub lead: Option<f64>,
    /// Of the orders that were done and due: the part that was not late.
    pub in_time: Option<f64>,
    /// Of these, by how many seconds they were late, in the mean; those in time by 0.
    pub tardiness: Option<f64>,
    /// By how many seconds they were late, in sum.
    pub tardiness_sum: Option<f64>,
    /// The most seconds by which one was late.
    pub tardiness_max: Option<f64>,
    /// In the order of the description.
    pub resources: Vec<ResourceFigures>,
    /// Figures of each order, in the order of their numbers.
    pub each: Vec<OrderFigures>,
    /// Reason why it ended before its time, if it did.
    pub problem: Option<StudyProblem>,
}

/// A resource in one replication.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResourceFigures {
    /// Share of the time in which it worked or carried; of several at once, of its capacity.
    pub worked: f64,
    /// The part of the time in which it stood.
    pub down: f64,
    /// Mean number of positions taken.
    pub taken: f64,
}

/// An order in one replication.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderFigures {
    pub name: String,
    pub product: String,
    pub quantity: u32,
    pub released: Tick,
    pub due: Option<Tick>,
    /// Time at which its last part left; none if it is open.
    pub done: Option<Tick>,
}

impl OrderFigures {
    /// Lateness when it was done, or at `now`; zero if it is not late. None if it is not due.
    pub fn tardiness(&self, now: Tick) -> Option<Duration> {
        Some(self.done.unwrap_or(now).since(self.due?))
    }
}

/// Mean; none of no items.
fn mean(total: Duration, count: usize) -> Option<f64> {
    (count > 0).then(|| total.as_secs_f64() / count as f64)
}

impl CellStudy {
    /// The figures of a replication that was played.
    pub fn figures(&self, played: &PlayedReplication) -> ReplicationFigures {
        let from = (Tick::ZERO + self.scenario.warm_up).min(played.end);
        let mut tracking = Tracking::since(sheet(&self.cell, &self.played), from);
        played.sim.log.iter().take_while(|record| record.at <= played.end).for_each(|record| tracking.take(record));
        let summary = tracking.report(played.end);
        let observed = played.end.since(from);
        let all: Vec<&ProductionOrder> = tracking.production().orders().collect();
        let done = || all.iter().filter_map(|order| Some((order, order.ended.filter(|end| *end >= from)?)));
        let lead = done().map(|(order, end)| end.since(released(order))).sum();
        let late = summary.orders.late;
        let due = summary.orders.due;
        let is_due = |order: &&&ProductionOrder| order.request.due.is_some_and(|due| due < played.end);
        let hours = observed.as_secs_f64() / 3600.0;
        let inside: f64 = tracking.passages().map(|part| within(part.entered, part.left, from, played.end)).sum();
        ReplicationFigures {
            observed,
            parts: summary.left,
            throughput: if hours > 0.0 { summary.left as f64 / hours } else { 0.0 },
            inside: if hours > 0.0 { inside / observed.as_secs_f64() } else { 0.0 },
            in_cell: mean(summary.lead.total, summary.lead.count),
            waited: mean(summary.waited.total, summary.waited.count),
            orders: done().count(),
            open: all.iter().filter(|order| order.ended.is_none()).count(),
            overdue: all.iter().filter(|order| order.ended.is_none()).filter(is_due).count(),
            lead: mean(lead, done().count()),
            in_time: (due > 0).then(|| summary.orders.in_time as f64 / due as f64),
            tardiness: mean(late.total, due),
            tardiness_sum: (due > 0).then_some(late.total.as_secs_f64()),
            tardiness_max: (due > 0).then_some(late.most.as_secs_f64()),
            resources: self.resources(&summary, played, from),
            each: all.iter().map(|order| each(order)).collect(),
            problem: played.problem.clone(),
        }
    }

    fn resources(&self, summary: &CellSummary, played: &PlayedReplication, from: Tick) -> Vec<ResourceFigures> {
        let observed = played.end.since(from).as_secs_f64();
        let share = |seconds: f64| if observed > 0.0 { seconds / observed } else { 0.0 };
        let stood = self.stood_at_work(&played.sim.log, &played.stood, from, played.end);
        let resource = |(index, of): (usize, &linewright_coordinator_cell::tracking::ResourceReport)| {
            let down = played.stood.iter().filter(|stood| stood.resource.index() == index);
            let down: f64 = down.map(|stood| within(stood.from, Some(stood.to), from, played.end)).sum();
            let work = of.work.as_secs_f64() - stood.get(&index).copied().unwrap_or(0.0);
            ResourceFigures { worked: share(work) / f64::from(of.capacity.max(1)), down: share(down), taken: of.taken }
        };
        summary.resources.iter().enumerate().map(resource).collect()
    }

    /// Seconds for which resources stood while they worked or carried.
    fn stood_at_work(&self, log: &[Record], stood: &[Standstill], from: Tick, end: Tick) -> BTreeMap<usize, f64> {
        let mut sums = BTreeMap::new();
        if stood.is_empty() {
            return sums;
        }
        let (mut activities, sheet) = (Activities::default(), sheet(&self.cell, &self.played));
        log.iter().for_each(|record| activities.take(record));
        let mut of: BTreeMap<usize, Vec<&Standstill>> = BTreeMap::new();
        stood.iter().for_each(|stood| of.entry(stood.resource.index()).or_default().push(stood));
        for activity in activities.all() {
            let Some(entry) = sheet.entry(activity.mode) else { continue };
            for resource in [entry.worker, entry.carrier].into_iter().flatten() {
                // In the order of their ends.
                let all = of.get(&resource).map(Vec::as_slice).unwrap_or_default();
                let first = all.partition_point(|stood| stood.to <= activity.began);
                let ended = activity.ended.unwrap_or(end).min(end);
                for stood in all[first..].iter().take_while(|stood| stood.from < ended) {
                    let (low, high) = (stood.from.max(activity.began), stood.to.min(ended));
                    *sums.entry(resource).or_insert(0.0) += within(low, Some(high), from, end);
                }
            }
        }
        sums
    }
}

fn released(order: &ProductionOrder) -> Tick {
    order.request.release.unwrap_or(Tick::ZERO).max(order.accepted)
}

fn each(order: &ProductionOrder) -> OrderFigures {
    OrderFigures {
        name: order.request.name.clone(),
        product: order.request.product.clone(),
        quantity: order.request.quantity,
        released: released(order),
        due: order.request.due,
        done: order.ended,
    }
}

/// Seconds of a span between two moments.
fn within(from: Tick, to: Option<Tick>, low: Tick, high: Tick) -> f64 {
    to.unwrap_or(high).min(high).since(from.max(low)).as_secs_f64()
}
