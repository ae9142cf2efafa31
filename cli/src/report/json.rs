//! The one object that `--json` prints of a report. Times are RFC 3339, or seconds of a simulation; durations are seconds.

use std::time::Duration;

use linewright_coordinator_cell::production::ProductionOrder;
use linewright_coordinator_cell::tracking::{Effectiveness, OrdersReport, ResourceReport, Spread};
use linewright_line::Tick;
use serde::Serialize;

use super::rows::in_seconds;
use super::story::ReportSource;

/// Everything that is reported.
#[derive(Serialize)]
pub struct ReportJson {
    cell: String,
    title: String,
    from: String,
    to: String,
    observed_s: f64,
    /// Records of the log that are not in the database, each from and to.
    missing: Vec<(u64, u64)>,
    /// Spans of notes that could not be written.
    gaps: Vec<JsonGap>,
    parts: JsonParts,
    failures: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    effectiveness: Option<Shares>,
    resources: Vec<JsonResourceReport>,
    orders: JsonOrders,
}

#[derive(Serialize)]
struct JsonParts {
    left: usize,
    inside: usize,
    lost: u64,
    lead_s: Times,
    worked_s: Times,
    moved_s: Times,
    waited_s: Times,
}

#[derive(Serialize)]
struct Times {
    count: usize,
    least: f64,
    median: f64,
    p90: f64,
    p99: f64,
    most: f64,
    mean: Option<f64>,
}

#[derive(Serialize)]
struct Shares {
    availability: f64,
    performance: f64,
    quality: f64,
    product: f64,
}

#[derive(Serialize)]
struct JsonResourceReport {
    name: String,
    prototype: String,
    capacity: u32,
    busy_s: f64,
    down_s: f64,
    work_s: f64,
    utilisation: Option<f64>,
    availability: Option<f64>,
    performance: Option<f64>,
    parts: u64,
    nominal_s: f64,
    actual_s: f64,
    taken_mean: f64,
    taken_most: u32,
    causes: Vec<JsonCause>,
}

#[derive(Serialize)]
struct JsonCause {
    cause: String,
    times: u64,
    down_s: f64,
}

#[derive(Serialize)]
struct JsonOrders {
    done: usize,
    open: usize,
    cancelled: usize,
    withdrawn: usize,
    due: usize,
    in_time: usize,
    late_s: Times,
    list: Vec<JsonProductionOrder>,
}

/// A production order.
#[derive(Default, Serialize)]
pub struct JsonProductionOrder {
    /// Number, unique in its cell and rising.
    pub id: u64,
    /// Name, as in the description.
    pub name: String,
    /// Its product.
    pub product: String,
    /// Number of parts, from 1.
    pub quantity: u32,
    /// Its state, in a word.
    pub state: &'static str,
    /// When it was accepted.
    pub accepted: String,
    /// When it is due.
    pub due: Option<String>,
    /// When its first part entered.
    pub begun: Option<String>,
    /// When it was over.
    pub ended: Option<String>,
    /// Number of its parts that have entered.
    pub entered: u32,
    /// Number of those that have left.
    pub done: u32,
    /// Number of those that were lost.
    pub lost: u32,
    /// By how much it was late, negative if it was early.
    pub lateness_s: Option<f64>,
}

/// Notes that could not be written, from the first to the last.
#[derive(Serialize)]
pub struct JsonGap {
    pub from: String,
    pub to: String,
    pub lost: u64,
}

impl From<Spread> for Times {
    fn from(of: Spread) -> Self {
        let [least, median, p90, p99, most] = [of.least, of.median, of.p90, of.p99, of.most].map(in_seconds);
        let mean = (of.count > 0).then(|| in_seconds(of.total) / of.count as f64);
        Times { count: of.count, least, median, p90, p99, most, mean }
    }
}

impl From<Effectiveness> for Shares {
    fn from(of: Effectiveness) -> Self {
        let Effectiveness { availability, performance, quality } = of;
        Shares { availability, performance, quality, product: of.product() }
    }
}

/// An order as it is written in tables.
pub fn production_order(story: &ReportSource, order: &ProductionOrder) -> JsonProductionOrder {
    let show = |tick: Option<Tick>| tick.map(|tick| story.show(tick));
    JsonProductionOrder {
        id: order.id.0,
        name: order.request.name.clone(),
        product: order.request.product.clone(),
        quantity: order.request.quantity,
        state: match (order.withdrawn, order.cancelled, order.ended, order.begun) {
            (true, ..) => "withdrawn",
            (false, Some(_), ..) => "cancelled",
            (false, None, Some(_), _) => "done",
            (false, None, None, Some(_)) => "in work",
            (false, None, None, None) => "waiting",
        },
        accepted: story.show(order.accepted),
        due: show(order.request.due),
        begun: show(order.begun),
        ended: show(order.ended),
        entered: order.entered,
        done: order.done,
        lost: order.lost,
        lateness_s: order.lateness().map(|micros| micros as f64 / 1e6),
    }
}

impl ReportJson {
    /// Of what was read.
    pub fn new(story: &ReportSource) -> Self {
        let report = &story.report;
        ReportJson {
            cell: story.about.cell.clone(),
            title: story.about.title.clone(),
            from: story.show(story.from),
            to: story.show(story.to),
            observed_s: in_seconds(report.observed),
            missing: story.missing.clone(),
            gaps: story
                .gaps
                .iter()
                .map(|&(from, to, lost)| JsonGap { from: story.show(from), to: story.show(to), lost })
                .collect(),
            parts: JsonParts {
                left: report.left,
                inside: report.inside,
                lost: report.lost,
                lead_s: report.lead.into(),
                worked_s: report.worked.into(),
                moved_s: report.moved.into(),
                waited_s: report.waited.into(),
            },
            failures: report.failures,
            effectiveness: report.effectiveness().map(Shares::from),
            resources: report.resources.iter().map(|of| resource(of, report.observed)).collect(),
            orders: orders(story, &report.orders),
        }
    }
}

fn resource(of: &ResourceReport, observed: Duration) -> JsonResourceReport {
    let cause = |(cause, times, down): (&str, u64, Duration)| JsonCause {
        cause: cause.to_owned(),
        times,
        down_s: in_seconds(down),
    };
    JsonResourceReport {
        name: of.name.clone(),
        prototype: of.prototype.clone(),
        capacity: of.capacity,
        busy_s: in_seconds(of.busy),
        down_s: in_seconds(of.down),
        work_s: in_seconds(of.work),
        utilisation: of.utilisation(observed),
        availability: of.availability(observed),
        performance: of.performance(),
        parts: of.worked,
        nominal_s: in_seconds(of.nominal),
        actual_s: in_seconds(of.actual),
        taken_mean: of.taken,
        taken_most: of.most,
        causes: of.causes.iter().map(cause).collect(),
    }
}

fn orders(story: &ReportSource, of: &OrdersReport) -> JsonOrders {
    let &OrdersReport { open, done, cancelled, withdrawn, due, in_time, late } = of;
    let list = story.orders().map(|order| production_order(story, order)).collect();
    JsonOrders { done, open, cancelled, withdrawn, due, in_time, late_s: late.into(), list }
}
