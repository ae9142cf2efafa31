//! Report of a cell, as numbers and as text.
//!
//! Availability, performance and quality as factors of OEE (ISO 22400-2), each from 0 to 1: the part of the time in which a
//! resource was not down; how long its work should have taken beside how long it took; the part of what left that was good.
//! A part that took less time than described counts as described: the planned run time per item is the shorter of the two.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use super::orders::OrdersReport;
use super::spread::Spread;

/// Causes of down time: how often, and for how long.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Causes(BTreeMap<String, (u64, Duration)>);

impl Causes {
    /// Once more, for so long.
    pub(super) fn add(&mut self, cause: &str, down: Duration) {
        self.count(cause, 1, down);
    }

    /// More time down by a cause. One that began before anything counted counts once.
    pub(super) fn go_on(&mut self, cause: &str, down: Duration) {
        self.count(cause, 0, down);
    }

    /// Time goes by in small steps: words that are known are not copied.
    fn count(&mut self, cause: &str, more: u64, down: Duration) {
        match self.0.get_mut(cause) {
            Some((times, total)) => (*times, *total) = (*times + more, *total + down),
            None => _ = self.0.insert(cause.to_owned(), (1, down)),
        }
    }

    /// Each of them, by its words: how often, and for how long altogether.
    pub fn iter(&self) -> impl Iterator<Item = (&str, u64, Duration)> {
        self.0.iter().map(|(cause, (times, total))| (cause.as_str(), *times, *total))
    }
}

/// One resource.
#[derive(Clone, Debug, PartialEq)]
pub struct ResourceReport {
    pub name: String,
    pub prototype: String,
    /// Most parts that it holds, or carries at a time.
    pub capacity: u32,
    /// Time worked or carried, simultaneous activities added up.
    pub work: Duration,
    /// Mean number of positions taken, by parts that were there or on their way.
    pub taken: f64,
    pub most: u32,
    /// Time in activities, none of which had failed.
    pub busy: Duration,
    /// Time with a failed one.
    pub down: Duration,
    /// Down time by cause, in µs.
    pub causes: Causes,
    /// Number of parts it has worked on; one of which it does several steps counts once.
    pub worked: u64,
    /// Nominal time of that, each part at most as long as it took.
    pub nominal: Duration,
    /// Actual time of that.
    pub actual: Duration,
}

/// A cell, from its first record on, or from the beginning of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSummary {
    /// Time observed.
    pub observed: Duration,
    /// Each resource.
    pub resources: Vec<ResourceReport>,
    /// Parts that are inside.
    pub inside: usize,
    /// Parts that have left.
    pub left: usize,
    /// Parts that were lost on the way, or came to be of no use; with those that are missing now by a sensor.
    pub lost: u64,
    /// Activities that have failed.
    pub failures: u64,
    /// Production orders.
    pub orders: OrdersReport,
    /// Of the parts that have left: from entering to leaving.
    pub lead: Spread,
    /// Of these: how long each was worked on.
    pub worked: Spread,
    /// Time each was moved, entering and leaving included.
    pub moved: Spread,
    /// Time each waited.
    pub waited: Spread,
}

/// A part of something, or nothing where there is nothing to be part of.
/// How often, in words.
fn often(times: u64) -> String {
    if times == 1 { "once".to_owned() } else { format!("{times} times") }
}

fn share(part: Duration, whole: Duration) -> Option<f64> {
    (!whole.is_zero()).then(|| part.as_secs_f64() / whole.as_secs_f64())
}

impl ResourceReport {
    /// The part of the observed time in which it was busy.
    pub fn utilisation(&self, observed: Duration) -> Option<f64> {
        share(self.busy, observed)
    }

    /// Share of its capacity that it worked or carried.
    pub fn load(&self, observed: Duration) -> Option<f64> {
        share(self.work, observed * self.capacity.max(1))
    }

    /// The part of the observed time in which it was not down.
    pub fn availability(&self, observed: Duration) -> Option<f64> {
        share(observed.saturating_sub(self.down), observed)
    }

    /// Nominal time of its work beside the actual; nothing if it has worked on nothing.
    pub fn performance(&self) -> Option<f64> {
        share(self.nominal, self.actual)
    }
}

impl CellSummary {
    /// The parts that have left and were good, of all that have left or were lost on the way.
    pub fn quality(&self) -> Option<f64> {
        let all = self.left as u64 + self.lost;
        (all > 0).then(|| self.left as f64 / all as f64)
    }
}

/// Overall equipment effectiveness: the product of the three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effectiveness {
    /// Share of the time in which the resources that work were not down.
    pub availability: f64,
    /// Nominal time of their work beside the actual.
    pub performance: f64,
    /// Share of the parts that left, or were lost on the way, that was good.
    pub quality: f64,
}

impl Effectiveness {
    /// Share of the possible work that was done, and well.
    pub fn product(&self) -> f64 {
        self.availability * self.performance * self.quality
    }
}

impl CellSummary {
    /// Of all resources that have worked on parts; none if none has, or nothing has left.
    pub fn effectiveness(&self) -> Option<Effectiveness> {
        let workers = || self.resources.iter().filter(|resource| !resource.actual.is_zero());
        let count = u32::try_from(workers().count()).ok()?;
        let down: Duration = workers().map(|resource| resource.down).sum();
        let planned = self.observed * count;
        Some(Effectiveness {
            availability: share(planned.saturating_sub(down), planned)?,
            performance: share(workers().map(|of| of.nominal).sum(), workers().map(|of| of.actual).sum())?,
            quality: self.quality()?,
        })
    }
}

/// A share for people.
struct Percent(Option<f64>);

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(share) => f.pad(&format!("{:.1} %", share * 100.0)),
            None => f.pad("-"),
        }
    }
}

impl fmt::Display for CellSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |time: Duration| format!("{:.1}", time.as_secs_f64());
        let CellSummary { observed, inside, left, lost, failures, .. } = self;
        writeln!(
            f,
            "{} s observed; {left} parts have left, {inside} are inside, {lost} were lost; {failures} activities have \
             failed",
            seconds(*observed)
        )?;
        if let Some(of) = self.effectiveness() {
            let [a, p, q, all] =
                [of.availability, of.performance, of.quality, of.product()].map(|share| Percent(Some(share)));
            writeln!(f, "availability {a}, performance {p}, quality {q}: together {all}")?;
        }
        if self.lead.count > 0 {
            writeln!(
                f,
                "\n{:<12} {:>9} {:>9} {:>9} {:>9} {:>9}",
                "a part, in s", "least", "median", "90 %", "99 %", "most"
            )?;
            let rows =
                [("lead time", self.lead), ("worked on", self.worked), ("moved", self.moved), ("waited", self.waited)];
            for (name, spread) in rows {
                let times = [spread.least, spread.median, spread.p90, spread.p99, spread.most].map(seconds);
                let [least, median, p90, p99, most] = &times;
                writeln!(f, "{name:<12} {least:>9} {median:>9} {p90:>9} {p99:>9} {most:>9}")?;
            }
        }
        self.orders.fmt(f)?;
        writeln!(
            f,
            "\n{:<16} {:>8} {:>8} {:>12} {:>12} {:>6}",
            "resource", "busy", "down", "available", "performance", "parts"
        )?;
        for resource in &self.resources {
            let down = share(resource.down, *observed);
            writeln!(
                f,
                "{:<16} {:>8} {:>8} {:>12} {:>12} {:>6}",
                resource.name,
                Percent(resource.utilisation(*observed)),
                Percent(down),
                Percent(resource.availability(*observed)),
                Percent(resource.performance()),
                resource.worked,
            )?;
            for (cause, times, down) in resource.causes.iter() {
                writeln!(f, "{:<16} {} {cause}: {} s", "", often(times), seconds(down))?;
            }
        }
        Ok(())
    }
}
