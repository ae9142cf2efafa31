//! States of a running line as JSON objects, for `mode`, `watch` and `press`.

use linewright_msgs::{LineState, StationState};
use serde::Serialize;

use crate::client::OperatorClient;
use crate::watch::cell::CellWatchJson;

/// The name of a mode as operators read it.
pub fn mode_name(code: u8) -> &'static str {
    linewright_node_line::mode_from_code(code).map_or("unknown", |mode| mode.name())
}

/// The line's mode.
#[derive(Serialize)]
pub struct ModeJson {
    mode: &'static str,
    /// Every station has acknowledged the mode.
    enabled: bool,
    /// The mode with what keeps it, as operators read it.
    text: String,
    /// Why the last command was refused.
    refusal: Option<String>,
    /// How long ago that was, in ms.
    refusal_age_ms: Option<u32>,
    waiting_for: Vec<String>,
}

impl ModeJson {
    pub fn of(state: &LineState) -> Self {
        ModeJson {
            mode: mode_name(state.mode),
            enabled: state.enabled,
            text: state.text.clone(),
            refusal: Some(state.refusal.clone()).filter(|text| !text.is_empty()),
            refusal_age_ms: Some(state.refusal_age_ms).filter(|_| !state.refusal.is_empty()),
            waiting_for: state.waiting_for.to_vec(),
        }
    }
}

/// A station; without a state all but its name is null.
#[derive(Serialize)]
pub struct StationJson {
    station: String,
    mode: Option<&'static str>,
    cycle: Option<i32>,
    operation: Option<String>,
    stopped: Option<bool>,
    fault: Option<String>,
    waits_for: Vec<String>,
}

impl StationJson {
    pub fn of(name: &str, state: Option<&StationState>) -> Self {
        StationJson {
            station: name.to_owned(),
            mode: state.map(|state| mode_name(state.mode)),
            cycle: state.map(|state| state.cycle),
            operation: state.map(|state| state.operation.clone()),
            stopped: state.map(|state| state.stopped),
            fault: state.map(|state| state.fault.clone()).filter(|text| !text.is_empty()),
            waits_for: state.map(|state| state.blocked_by.to_vec()).unwrap_or_default(),
        }
    }
}

/// A line with its stations.
#[derive(Serialize)]
pub struct LineJson {
    line: String,
    mode: Option<ModeJson>,
    /// What was started with another description than this one.
    other_descriptions: Vec<String>,
    stations: Vec<StationJson>,
    /// Of a flexible cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    cell: Option<CellWatchJson>,
}

impl LineJson {
    pub fn of(client: &OperatorClient, cell: Option<CellWatchJson>) -> Self {
        let line = client.line();
        LineJson {
            line: line.name.clone(),
            mode: client.coordinator().map(ModeJson::of),
            other_descriptions: client.other_descriptions(),
            stations: line
                .station_ids()
                .map(|id| StationJson::of(&line.station(id).name, client.station(id)))
                .collect(),
            cell,
        }
    }
}
