//! The one object that `--json` prints of a cell.

use linewright_cell::Cell;
use linewright_coordinator_cell::compile::CompiledCell;
use linewright_coordinator_cell::{Record, RecordKind, texts};
use linewright_line::Tick;
use linewright_simulation::cell::CellSim;
use serde::Serialize;

use super::made::ProductionResult;

/// Everything that came out. Times are seconds.
#[derive(Serialize)]
pub struct CellSimulationJson {
    cell: String,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    makespan_s: f64,
    parts: Vec<JsonPart>,
    resources: Vec<JsonResource>,
    /// Those that take time, in the order in which they started.
    activities: Vec<JsonActivity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    decisions: Option<Vec<Decision>>,
}

#[derive(Serialize)]
struct JsonPart {
    part: u64,
    #[serde(rename = "type")]
    of: String,
    entered_s: f64,
    done_s: Option<f64>,
}

#[derive(Serialize)]
struct JsonResource {
    name: String,
    prototype: String,
    capacity: u32,
    worked: f64,
    taken_mean: f64,
    taken_most: u32,
}

#[derive(Serialize)]
struct JsonActivity {
    activity: String,
    part: Option<u64>,
    start_s: f64,
    end_s: Option<f64>,
}

/// Decision at a moment, and its reason.
#[derive(Serialize)]
pub struct Decision {
    at_s: f64,
    why: Vec<String>,
}

impl Decision {
    /// All of a run.
    pub fn all(sim: &CellSim) -> Vec<Self> {
        let decision = |record: &Record| {
            let RecordKind::Decided { started, held, .. } = &record.fact else { return None };
            Some(Decision { at_s: record.at.as_secs_f64(), why: texts::decision(&sim.table, started, held) })
        };
        sim.log.iter().filter_map(decision).collect()
    }
}

impl CellSimulationJson {
    /// Of a run that has ended; with all decisions if `why`.
    pub fn new(
        cell: &Cell,
        played: &CompiledCell,
        sim: &CellSim,
        made: &ProductionResult,
        error: Option<&str>,
        why: bool,
    ) -> Self {
        let seconds = |tick: Tick| tick.as_secs_f64();
        let parts = made.parts.iter().map(|part| JsonPart {
            part: part.part.0,
            of: part.product.and_then(|of| cell.part_types.get(of)).map(|of| of.name.clone()).unwrap_or_default(),
            entered_s: seconds(part.entered),
            done_s: part.left.map(seconds),
        });
        let resources = made.report.resources.iter().map(|of| JsonResource {
            name: of.name.clone(),
            prototype: of.prototype.clone(),
            capacity: of.capacity,
            worked: of.load(made.report.observed).unwrap_or(0.0),
            taken_mean: of.taken,
            taken_most: of.most,
        });
        let activities = made.activities.iter().map(|done| JsonActivity {
            activity: played.table.mode_name(done.mode).to_owned(),
            part: done.part.map(|part| part.0),
            start_s: seconds(done.began),
            end_s: done.ended.map(seconds),
        });
        CellSimulationJson {
            cell: cell.name.clone(),
            ok: error.is_none(),
            error: error.map(str::to_owned),
            makespan_s: seconds(made.end),
            parts: parts.collect(),
            resources: resources.collect(),
            activities: activities.collect(),
            decisions: why.then(|| Decision::all(sim)),
        }
    }
}
