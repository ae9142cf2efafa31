//! A flexible cell: parts, what is in progress, orders, and what is out of service.
//!
//! Ages are computed with the stamps of its coordinator alone, so that the clocks of two hosts are not compared.

use linewright_msgs::{ActivityState, CellState, PartState, ProductionState};
use serde::Serialize;

use crate::aged::Aged;
use crate::bounds::{LIST_MAX, text, texts};
use crate::texts::{ReasonsByResource, due, is_over, left_out, of_order, of_part, seconds, span};

/// What operators name of a cell, by its description.
#[derive(Clone, Debug, Default)]
pub struct CellChoices {
    /// Part types that can be ordered.
    pub products: Vec<String>,
    pub resources: Vec<String>,
}

/// A cell. Lists have 100 entries at most; the counts are of all.
#[derive(Debug, Serialize)]
pub struct CellPart {
    /// Activities may start.
    pub starting: bool,
    pub parts_inside: u32,
    pub parts_left: u64,
    pub orders_open: u32,
    pub parts: Vec<ShownPart>,
    pub activities: Vec<ShownActivity>,
    pub orders: Vec<ShownOrder>,
    pub out_of_service: Vec<ShownOutage>,
    /// Part types that can be ordered.
    pub products: Vec<String>,
    pub resources: Vec<String>,
}

/// A part in a cell.
#[derive(Debug, Serialize)]
pub struct ShownPart {
    pub part: u64,
    /// How far it is.
    pub stage: String,
    pub place: String,
    /// For how long it is there.
    pub age: String,
    /// Name of its production order.
    pub order: Option<String>,
}

/// What is in progress.
#[derive(Debug, Serialize)]
pub struct ShownActivity {
    pub id: u64,
    pub name: String,
    pub part: Option<u64>,
    pub age: String,
    /// False when it has failed.
    pub running: bool,
    /// What it waits for.
    pub text: String,
}

/// A production order.
#[derive(Debug, Serialize)]
pub struct ShownOrder {
    pub id: u64,
    pub name: String,
    /// How far it is.
    pub text: String,
    /// When it is due, or for how long it is overdue.
    pub due: Option<String>,
    pub is_late: bool,
    pub is_over: bool,
}

/// A resource out of service.
#[derive(Debug, Serialize)]
pub struct ShownOutage {
    pub resource: String,
    /// Why, as far as the coordinator has answered.
    pub text: String,
}

/// The time by the clock of the coordinator that has sent a state, in s since 1970.
pub(crate) fn now_of(cell: Aged<'_, CellState>) -> f64 {
    seconds(&cell.state.header.stamp) + cell.age.as_secs_f64()
}

impl CellPart {
    pub(crate) fn of(cell: Aged<'_, CellState>, out: &ReasonsByResource, names: &CellChoices) -> Self {
        let (state, now) = (cell.state, now_of(cell));
        let part = |of: &PartState| ShownPart {
            part: of.id,
            stage: text(&of.stage),
            place: text(&of.place),
            age: span(now - seconds(&of.since)),
            order: of_part(state, of).map(text),
        };
        let activity = |of: &ActivityState| ShownActivity {
            id: of.id,
            name: text(&of.name),
            part: (of.part != 0).then_some(of.part),
            age: span(now - seconds(&of.began)),
            running: of.running,
            text: text(&of.text),
        };
        let order = |of: &ProductionState| ShownOrder {
            id: of.id,
            name: text(&of.name),
            text: text(&of_order(of)),
            due: due(of, now).filter(|_| !is_over(of)),
            is_late: !is_over(of) && seconds(&of.due) != 0.0 && seconds(&of.due) < now,
            is_over: is_over(of),
        };
        let down =
            |name: &String| ShownOutage { resource: text(name), text: text(&left_out(state, name, out.get(name))) };
        CellPart {
            starting: state.starting,
            parts_inside: state.parts_inside,
            parts_left: state.parts_left,
            orders_open: state.orders_open,
            parts: state.parts.as_slice().iter().take(LIST_MAX).map(part).collect(),
            activities: state.activities.as_slice().iter().take(LIST_MAX).map(activity).collect(),
            orders: state.orders.as_slice().iter().take(LIST_MAX).map(order).collect(),
            out_of_service: state.down.as_slice().iter().take(LIST_MAX).map(down).collect(),
            products: texts(&names.products),
            resources: texts(&names.resources),
        }
    }
}
