//! A scenario of a cell as it is written: every key it may have. From these tables follow its reader and the schema.

use linewright_text::{
    Fields, KeyKind, Keys, Located, LocatedName, Problem, Report, Shape, keys, one_of, positive, tables, text, texts,
    whole, within, word,
};

use super::super::distribution::{Distribution, LONGEST_S};
use crate::scenario::faults::{FaultOf, faults};

/// The shortest time that anything random takes in the mean, in seconds: a shorter one is none.
const SHORTEST_S: f64 = 1e-3;
/// At most so many orders, steps and others of a kind.
const LIST_MAX: usize = 10_000;
/// At most so many patterns of activities, or orders to be after.
const NAMES_MAX: usize = 1000;
/// The most replications.
pub const REPLICATIONS_MAX: i64 = 10_000;
/// Bounds of a required precision, in percent: best and worst.
pub const PRECISION_PERCENT: (f64, f64) = (0.1, 50.0);
/// Default confidence, in percent.
pub(super) const CONFIDENCE: f64 = 95.0;
/// The highest and the lowest priority.
const PRIORITY_MAX: i64 = 1_000_000;

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawCellScenario> {
    let document = linewright_text::document(text, report)?;
    Some(RawCellScenario::read_all(Fields::new(document.as_table(), 0..0, RawCellScenario::WHAT), report))
}

/// The distributions, by their names.
const KINDS: &[(&str, DistributionKind)] = &[
    ("constant", DistributionKind::Constant),
    ("exponential", DistributionKind::Exponential),
    ("uniform", DistributionKind::Uniform),
    ("triangular", DistributionKind::Triangular),
    ("truncated-normal", DistributionKind::TruncatedNormal),
    ("lognormal", DistributionKind::Lognormal),
    ("weibull", DistributionKind::Weibull),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DistributionKind {
    Constant,
    Exponential,
    Uniform,
    Triangular,
    TruncatedNormal,
    Lognormal,
    Weibull,
}

/// Clock of the time between two failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureClock {
    /// All time in which it is not down.
    Calendar,
    /// The time in which its station has a task order.
    Operating,
}

const CLOCKS: &[(&str, FailureClock)] = &[("calendar", FailureClock::Calendar), ("operating", FailureClock::Operating)];

keys! {
    /// A scenario of a cell: its production orders, and what happens in the simulation.
    pub(super) struct RawCellScenario is "a scenario" {
        /// Title for people.
        title: Option<LocatedName> = text(),
        /// Length of a replication, in seconds, 1 to 1e9; until all orders are done if left out.
        duration as "duration_s": Option<Located<f64>> = within(1.0, LONGEST_S),
        /// Warm-up: time at the beginning, while the cell fills, that counts in no figure, in seconds.
        warm_up as "warm_up_s": Option<Located<f64>> = within(0.0, LONGEST_S).usually(0.0),
        /// Number of replications, each with random numbers of its own, 1 to 10000; with `precision_percent` the least
        /// number.
        replications: Option<Located<i64>> = whole(1, REPLICATIONS_MAX),
        /// Wanted half width of the confidence intervals of throughput and time in the cell, in percent of their means,
        /// 0.1 to 50; as many replications are made as it takes.
        precision as "precision_percent": Option<Located<f64>> = within(PRECISION_PERCENT.0, PRECISION_PERCENT.1),
        /// Level of the confidence intervals, in percent, 50 to 99.9.
        confidence as "confidence_percent": f64 = within(50.0, 99.9).or(CONFIDENCE),
        /// Production orders that are known from the beginning, at most 10000.
        orders as "order": Vec<RawScenarioOrder> = tables(LIST_MAX),
        /// Series of production orders that arrive one after the other.
        arrivals: Vec<RawArrivals> = tables(LIST_MAX),
        /// Random times of activities.
        times as "time": Vec<RawTime> = tables(LIST_MAX),
        /// Random breakdowns of resources.
        breakdowns as "breakdown": Vec<RawBreakdown> = tables(LIST_MAX),
        /// Faults at certain times, in their order.
        steps as "step": Vec<RawScenarioStep> = tables(LIST_MAX),
    }

    /// A production order, as `linewright order` submits it.
    pub(super) struct RawScenarioOrder is "an order" {
        /// Its name; `order 1` and so on if left out.
        name: Option<LocatedName> = text(),
        /// The part type.
        part: Option<LocatedName> = text().required(),
        /// Number of parts, 1 to 1000000.
        quantity: i64 = whole(1, 1_000_000).or(1),
        /// Release: time before which no part of it enters, in seconds from the beginning.
        release as "release_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Due date of the whole order, in seconds from the beginning.
        due as "due_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Priority; the greater number comes first.
        priority: i64 = whole(-PRIORITY_MAX, PRIORITY_MAX).or(0),
        /// Orders of this list that have to be over before it starts.
        after: Option<Located<Vec<LocatedName>>> = texts(NAMES_MAX),
    }

    /// A series of production orders that arrive one after the other.
    pub(super) struct RawArrivals is "`arrivals`" {
        /// Name of its orders, to which a number is added; the part type if left out.
        name: Option<LocatedName> = text(),
        /// The part type.
        part: Option<LocatedName> = text().required(),
        /// Number of parts of each order, 1 to 1000000.
        quantity: i64 = whole(1, 1_000_000).or(1),
        /// Time from one order to the next, in seconds: a number, or a distribution.
        every as "every_s": Option<Located<Distribution>> = distribution().required(),
        /// Arrival of the first one, in seconds from the beginning; after a time of `every_s` if left out.
        first as "first_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Latest arrival, in seconds from the beginning.
        until as "until_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Number of orders, 1 to 1000000.
        count: Option<Located<i64>> = whole(1, 1_000_000),
        /// Due date of an order, in seconds from its arrival: a number, or a distribution.
        due_after as "due_after_s": Option<Located<Distribution>> = distribution(),
        /// Priority; the greater number comes first.
        priority: i64 = whole(-PRIORITY_MAX, PRIORITY_MAX).or(0),
    }

    /// Activities with random times: the described time multiplied by a random number.
    pub(super) struct RawTime is "`time`" {
        /// Synchronisations and actions, by name; `*` stands for any text. The first table that fits counts.
        of: Option<Located<Vec<LocatedName>>> = texts(NAMES_MAX).required(),
        /// Factor on the described time: a number, or a distribution.
        factor: Option<Located<Distribution>> = distribution().required(),
    }

    /// A resource that breaks down.
    pub(super) struct RawBreakdown is "a breakdown" {
        /// The resource.
        resource: Option<LocatedName> = text().required(),
        /// Name of the breakdown, where one resource has several.
        name: Option<LocatedName> = text(),
        /// Time from a repair to the next failure, in seconds: a number, or a distribution. Its mean is the MTBF.
        between as "between_failures_s": Option<Located<Distribution>> = distribution().required(),
        /// Time from a failure to the end of its repair, in seconds: a number, or a distribution. Its mean is the MTTR.
        repair as "repair_s": Option<Located<Distribution>> = distribution().required(),
        /// Time in which the time between failures is counted: `calendar`, all time, or `operating`, the time in which
        /// its station has a task order.
        clock: FailureClock = word(CLOCKS),
    }

    /// A step of the scenario: a time, and the faults that happen then.
    pub(super) struct RawScenarioStep is "a step" {
        /// Earliest time of the step, in seconds from the beginning.
        at_s as "at_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Further delay, in seconds.
        after as "after_s": Option<Located<f64>> = within(0.0, LONGEST_S),
        /// Faults of resources.
        faults: Vec<FaultOf> = faults(),
    }

    /// A distribution, by its name in the literature.
    pub(super) struct RawDistribution is "a distribution" {
        /// Kind of the distribution.
        distribution: Option<Located<DistributionKind>> = one_of(KINDS).required(),
        /// Mean; the value of `constant`.
        mean: Option<Located<f64>> = positive(),
        /// The standard deviation of `lognormal` and, before it is cut at 0, `truncated-normal`.
        deviation: Option<Located<f64>> = positive(),
        /// The least value of `uniform` and `triangular`.
        low: Option<Located<f64>> = within(0.0, LONGEST_S),
        /// The most frequent value of `triangular`.
        mode: Option<Located<f64>> = within(0.0, LONGEST_S),
        /// The greatest value of `uniform` and `triangular`.
        high: Option<Located<f64>> = positive(),
        /// Shape of `weibull`, 0.1 to 100: below 1 failures become rarer with age, above 1 more frequent.
        shape: Option<Located<f64>> = within(0.1, 100.0),
        /// Scale of `weibull`: the value that 63 % of all values do not exceed.
        scale: Option<Located<f64>> = positive(),
    }
}

/// A number that is always the same, or a distribution.
fn distribution() -> KeyKind<Option<Located<Distribution>>> {
    KeyKind::new(
        |fields, report, key| {
            if fields.is_table(key) {
                let table = fields.table(report, key, RawDistribution::WHAT)?;
                let written = PARAMETERS.map(|key| table.has(key));
                return RawDistribution::read_all(table, report).checked(&written, report);
            }
            let number = fields.within(report, key, SHORTEST_S, LONGEST_S)?;
            Some(number.map(Distribution::Constant))
        },
        || Shape::Either(vec![Shape::Number(SHORTEST_S, LONGEST_S), RawDistribution::shape()]),
    )
}

/// The parameters of all distributions.
const PARAMETERS: [&str; 7] = ["mean", "deviation", "low", "mode", "high", "shape", "scale"];

impl RawDistribution {
    /// The distribution, if it has the parameters it needs and no others. What is written and could not be read has been
    /// reported.
    fn checked(self, written: &[bool; 7], report: &mut Report) -> Option<Located<Distribution>> {
        let kind = self.distribution.as_ref()?;
        let needs: &[&str] = match kind.value {
            DistributionKind::Constant | DistributionKind::Exponential => &["mean"],
            DistributionKind::Uniform => &["low", "high"],
            DistributionKind::Triangular => &["low", "mode", "high"],
            DistributionKind::TruncatedNormal | DistributionKind::Lognormal => &["mean", "deviation"],
            DistributionKind::Weibull => &["shape", "scale"],
        };
        let name = KINDS.iter().find(|(_, known)| *known == kind.value).map_or("?", |(name, _)| *name);
        let values = [&self.mean, &self.deviation, &self.low, &self.mode, &self.high, &self.shape, &self.scale];
        let has = needs.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        let mut is_sound = true;
        for ((key, value), written) in PARAMETERS.into_iter().zip(values).zip(written) {
            match value {
                Some(value) if !needs.contains(&key) => {
                    let problem = Problem::error(value.at.clone(), format!("`{name}` has no `{key}`"));
                    report.add(problem.hint(format!("it has {has}")));
                }
                None if needs.contains(&key) => {
                    if !written {
                        let problem = Problem::error(self.at.clone(), format!("`{name}` needs `{key}`"));
                        report.add(problem.hint(format!("it has {has}")));
                    }
                    is_sound = false;
                }
                Some(_) | None => (),
            }
        }
        if !is_sound {
            return None;
        }
        let number = |value: &Option<Located<f64>>| value.as_ref().map_or(0.0, |value| value.value);
        let (mean, deviation) = (number(&self.mean), number(&self.deviation));
        let (low, mode, high) = (number(&self.low), number(&self.mode), number(&self.high));
        let in_order = match kind.value {
            DistributionKind::Uniform => low < high,
            DistributionKind::Triangular => low <= mode && mode <= high && low < high,
            _ => true,
        };
        if !in_order {
            let order = if kind.value == DistributionKind::Uniform {
                "low < high"
            } else {
                "low ≤ mode ≤ high, low < high"
            };
            report.add(Problem::error(self.at.clone(), format!("no such `{name}`")).hint(order));
            return None;
        }
        let distribution = match kind.value {
            DistributionKind::Constant => Distribution::Constant(mean),
            DistributionKind::Exponential => Distribution::Exponential { mean },
            DistributionKind::Uniform => Distribution::Uniform { low, high },
            DistributionKind::Triangular => Distribution::Triangular { low, mode, high },
            DistributionKind::TruncatedNormal => Distribution::TruncatedNormal { mean, deviation },
            DistributionKind::Lognormal => Distribution::Lognormal { mean, deviation },
            DistributionKind::Weibull => {
                Distribution::Weibull { shape: number(&self.shape), scale: number(&self.scale) }
            }
        };
        Some(Located::new(distribution, self.at))
    }
}
