//! Data of a described cell that a report needs beside its records.

use std::time::Duration;

use linewright_cell::{ActivityKind, Cell, Role};

use super::CompiledCell;
use crate::tracking::{ModeEntry, PartFlow, ReportMetadata, ResourceEntry};

/// Data of a cell that a report needs beside its records.
pub fn sheet(cell: &Cell, made: &CompiledCell) -> ReportMetadata {
    let resource = |resource: &linewright_cell::Resource| ResourceEntry {
        name: resource.name.as_str().into(),
        prototype: resource.prototype.name().into(),
        capacity: resource.capacity,
    };
    ReportMetadata {
        resources: cell.resources.iter().map(resource).collect(),
        products: cell.part_types.iter().map(|part| part.name.as_str().into()).collect(),
        modes: made.long.net().transitions().map(|t| entry(cell, made, t)).collect(),
    }
}

fn entry(cell: &Cell, made: &CompiledCell, t: linewright_nets::TransitionId) -> ModeEntry {
    let name = made.long.net().transition_name(t);
    let mut entry = ModeEntry {
        name: name.into(),
        activity: name.into(),
        product: None,
        resources: Vec::new(),
        worker: None,
        carrier: None,
        source: None,
        target: None,
        nominal: Duration::ZERO,
        passing: PartFlow::Inside,
    };
    // A shift in a buffer is not work of a resource.
    let Some((activity, of)) = made.net.move_of(cell, made.long.mode(t)) else { return entry };
    let index = |part: linewright_cell::Use| part.of.map(|id| id.index());
    let in_role = |role| activity.used(role).and_then(index);
    entry.activity = activity.name.as_str().into();
    entry.product = Some(cell.stages[of.from.index()].part_type.index());
    entry.resources = activity.uses.iter().copied().filter_map(index).collect();
    entry.worker = match activity.kind {
        ActivityKind::Process => in_role(Role::Worker),
        ActivityKind::Transport | ActivityKind::Enter | ActivityKind::Leave => None,
    };
    (entry.carrier, entry.source, entry.target) =
        (in_role(Role::Carrier), in_role(Role::Source), in_role(Role::Target));
    entry.nominal = of.time.unwrap_or_default();
    entry.passing = match activity.kind {
        ActivityKind::Enter => PartFlow::Enters,
        ActivityKind::Leave => PartFlow::Leaves,
        ActivityKind::Transport | ActivityKind::Process => PartFlow::Inside,
    };
    entry
}
