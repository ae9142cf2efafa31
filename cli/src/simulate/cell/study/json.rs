//! The one object that `--json` prints of a study.

use linewright_line::Tick;
use linewright_simulation::cell::{CellStudy, Estimate, ReplicationFigures, ResourceFigures};
use serde::Serialize;

use super::super::json::Decision;

/// Everything that came out. Times are seconds, shares are of 1.
#[derive(Serialize)]
pub struct StudyJson {
    cell: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    scenario: Option<String>,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    replications: usize,
    confidence: f64,
    warm_up_s: f64,
    throughput_per_h: Option<JsonEstimate>,
    inside: Option<JsonEstimate>,
    time_in_cell_s: Option<JsonEstimate>,
    waited_s: Option<JsonEstimate>,
    lead_time_s: Option<JsonEstimate>,
    open_orders: Option<JsonEstimate>,
    overdue_orders: Option<JsonEstimate>,
    in_time: Option<JsonEstimate>,
    tardiness_s: Option<JsonEstimate>,
    tardiness_sum_s: Option<JsonEstimate>,
    tardiness_max_s: Option<JsonEstimate>,
    resources: Vec<JsonResourceEstimates>,
    /// One for each replication.
    runs: Vec<JsonRun>,
}

/// A mean over replications; the half width of its confidence interval is null for one alone.
#[derive(Serialize)]
struct JsonEstimate {
    mean: f64,
    half_width: Option<f64>,
    n: usize,
}

#[derive(Serialize)]
struct JsonResourceEstimates {
    name: String,
    worked: Option<JsonEstimate>,
    down: Option<JsonEstimate>,
    taken: Option<JsonEstimate>,
}

#[derive(Serialize)]
struct JsonRun {
    observed_s: f64,
    parts: usize,
    orders: usize,
    throughput_per_h: f64,
    time_in_cell_s: Option<f64>,
    tardiness_s: Option<f64>,
    /// Of one replication alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    each: Option<Vec<JsonOrder>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    decisions: Option<Vec<Decision>>,
}

#[derive(Serialize)]
struct JsonOrder {
    order: String,
    part: String,
    quantity: u32,
    released_s: f64,
    due_s: Option<f64>,
    done_s: Option<f64>,
    tardiness_s: Option<f64>,
}

impl StudyJson {
    /// Of replications that were played; with all decisions of the only one, if requested.
    pub fn new(
        study: &CellStudy,
        figures: &[ReplicationFigures],
        mut decisions: Option<Vec<Decision>>,
        error: Option<&str>,
    ) -> Self {
        let of =
            |value: &dyn Fn(&ReplicationFigures) -> Option<f64>| study.estimate(figures, value).map(JsonEstimate::from);
        let resource = |(index, name): (usize, &str)| {
            let of = |value: &dyn Fn(&ResourceFigures) -> f64| of(&|figures| figures.resources.get(index).map(value));
            JsonResourceEstimates {
                name: name.to_owned(),
                worked: of(&|of| of.worked),
                down: of(&|of| of.down),
                taken: of(&|of| of.taken),
            }
        };
        let names = study.cell().resources.iter().map(|resource| resource.name.as_str());
        StudyJson {
            cell: study.cell().name.clone(),
            scenario: study.scenario().title.clone(),
            ok: error.is_none(),
            error: error.map(str::to_owned),
            replications: figures.len(),
            confidence: study.scenario().confidence,
            warm_up_s: study.scenario().warm_up.as_secs_f64(),
            throughput_per_h: of(&|of| Some(of.throughput)),
            inside: of(&|of| Some(of.inside)),
            time_in_cell_s: of(&|of| of.in_cell),
            waited_s: of(&|of| of.waited),
            lead_time_s: of(&|of| of.lead),
            open_orders: of(&|of| Some(of.open as f64)),
            overdue_orders: of(&|of| Some(of.overdue as f64)),
            in_time: of(&|of| of.in_time),
            tardiness_s: of(&|of| of.tardiness),
            tardiness_sum_s: of(&|of| of.tardiness_sum),
            tardiness_max_s: of(&|of| of.tardiness_max),
            resources: names.enumerate().map(resource).collect(),
            runs: figures.iter().map(|of| JsonRun::new(of, figures.len() == 1, decisions.take())).collect(),
        }
    }
}

impl From<Estimate> for JsonEstimate {
    fn from(Estimate { mean, half_width, n }: Estimate) -> Self {
        JsonEstimate { mean, half_width, n }
    }
}

impl JsonRun {
    fn new(of: &ReplicationFigures, with_orders: bool, decisions: Option<Vec<Decision>>) -> Self {
        let seconds = |tick: Tick| tick.as_secs_f64();
        let each = of.each.iter().map(|order| JsonOrder {
            order: order.name.clone(),
            part: order.product.clone(),
            quantity: order.quantity,
            released_s: seconds(order.released),
            due_s: order.due.map(seconds),
            done_s: order.done.map(seconds),
            tardiness_s: order.done.and_then(|done| order.tardiness(done)).map(|late| late.as_secs_f64()),
        });
        JsonRun {
            observed_s: of.observed.as_secs_f64(),
            parts: of.parts,
            orders: of.orders,
            throughput_per_h: of.throughput,
            time_in_cell_s: of.in_cell,
            tardiness_s: of.tardiness,
            each: with_orders.then(|| each.collect()),
            decisions,
        }
    }
}
