//! Axes that turn endlessly: rotary tables, chains. An operation with `by` is the index of one.
//!
//! An index is never taken back, and a cycle in which it is done twice has lost its parts. So a station with an endless axis
//! has no way home along which its round would be done again: nothing else in it is irreversible.

use std::time::Duration;

use linewright_text::{Problem, Report};

use super::operations::same_place;
use crate::Owner;
use crate::parse::draft::{DraftLine, DraftOperation, DraftStation};
use crate::parse::raw::ModuleKind;

/// Applies the rules for the endless axes of a station.
pub(super) fn check(station: &DraftStation<'_>, stale: Duration, report: &mut Report) {
    let mut indexes = station.operations.iter().filter(|op| op.by().is_some());
    for index in indexes.clone() {
        has_no_way_back(index, report);
        passes_no_place_unseen(index, stale, report);
    }
    goes_one_way_to_one_switch(station, report);
    let Some(first) = indexes.next() else { return };
    if station.is_task_driven() {
        let at = first.by().map_or_else(|| first.place(), |by| by.at.clone());
        report.add(
            Problem::error(at, format!("an endless axis in station `{}`, which works on order", station.name)).hint(
                "where an order ends in the midst of an index nothing leads back: let the station go round a cycle",
            ),
        );
    }
    for other in station.operations.iter().filter(|op| op.by().is_none()) {
        if other.kind() == Some(ModuleKind::Irreversible) {
            report.add(
                Problem::error(
                    other.place(),
                    format!("irreversible operation `{}` in a station with an index", other.name),
                )
                .also(&first.place(), "the index")
                .hint("its recovery path would have the round done again, with the index: a station of its own for the axis"),
            );
        }
    }
}

fn has_no_way_back(index: &DraftOperation<'_>, report: &mut Report) {
    let (raw, name) = (index.raw, index.name);
    let place = raw.moves.as_ref().and_then(|moves| moves.from.as_ref().or(moves.to.as_ref()));
    if let (Some(by), Some(place)) = (index.by(), place) {
        report.add(
            Problem::error(by.at.clone(), format!("`{name}` has a place beside `by`"))
                .also(&place.at, "the place")
                .hint("an index has `by` alone: it begins and ends at its switch"),
        );
    }
    if let Some(kind) = raw.kind.as_ref().filter(|kind| kind.value == ModuleKind::Reversible) {
        report.add(
            Problem::error(kind.at.clone(), format!("`{name}` turns an endless axis and is module \"R\""))
                .hint("an index is never taken back: module \"I\", without a recovery path"),
        );
    } else if let Some(path) = &raw.recovery_path {
        report.add(
            Problem::error(path.at.clone(), format!("`{name}` turns an endless axis and has a `recovery_path`"))
                .hint("leave it out: the only way out of an index is onward"),
        );
    }
}

/// Its switch is seen in images, and may be stuck: until that is found the next place must not be passed.
fn passes_no_place_unseen(index: &DraftOperation<'_>, stale: Duration, report: &mut Report) {
    let Some(duration) = &index.raw.duration else { return };
    let (name, takes) = (index.name, duration.value.as_secs_f64());
    if duration.value <= stale * 2 {
        let stale = stale.as_millis();
        report.add(
            Problem::error(duration.at.clone(), format!("`{name}` takes {takes} s, but `stale_ms` is {stale} ms"))
                .hint("an index takes longer than twice `stale_ms`: its switch is seen in images, and one may be that old"),
        );
    }
    if let Some(watchdog) = &index.raw.watchdog
        && watchdog.value >= duration.value * 2
    {
        let limit = watchdog.value.as_secs_f64();
        report.add(
            Problem::error(
                watchdog.at.clone(),
                format!("the watchdog of index `{name}` is {limit} s, but it takes {takes} s"),
            )
            .also(&duration.at, "takes this long")
            .hint("it must be less than twice `duration_s`: with a switch that is stuck the axis would come to the place after the next"),
        );
    }
}

/// Whatever moves an endless axis goes on by the same way, and ends at the same switch.
fn goes_one_way_to_one_switch(station: &DraftStation<'_>, report: &mut Report) {
    for (nth, operation) in station.operations.iter().enumerate() {
        let Some(motion) = &operation.motion else { continue };
        let axis = &station.axes[motion.value.axis.index()];
        let Some(index) = axis.index else { continue };
        match operation.by() {
            None => report.add(
                Problem::error(
                    motion.at.clone(),
                    format!("`{}` moves `{}` between places, which is endless", operation.name, axis.name),
                )
                .hint("all motions of an endless axis have `by`; the one place of it is where its switch is on"),
            ),
            Some(by) if !same_place(by.value, index) => report.add(
                Problem::error(by.at.clone(), format!("`{}` goes on by another way than {index}", operation.name))
                    .hint(format!("its switch comes on every {index}: two operations for two places")),
            ),
            Some(_) => {}
        }
        let of_axis = |op: &&DraftOperation<'_>| {
            op.by().is_some() && op.motion.as_ref().is_some_and(|m| m.value.axis == motion.value.axis)
        };
        let first = station.operations[..nth].iter().find(of_axis).and_then(|op| op.normal.complete.as_ref());
        if let (Some(first), Some(complete)) = (first, &operation.normal.complete)
            && operation.by().is_some()
            && first.value != complete.value
        {
            report.add(
                Problem::error(complete.at.clone(), format!("a second switch for `{}` in position", axis.name))
                    .also(&first.at, "the first")
                    .hint("an index begins and ends at one switch"),
            );
        }
    }
}

/// A drive counts from a zero, and an axis that turns endlessly leaves its range.
pub(super) fn axes_have_no_drive(draft: &DraftLine<'_>, report: &mut Report) {
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let (Some(Owner::Station(id)), Some(drive), Some(raw)) = (device.owner, &device.drive, &raw.drive) else {
            continue;
        };
        let (Some(axis), Some(name)) = (drive.axis, &raw.axis) else { continue };
        if draft.stations[id.index()].axes[axis.index()].index.is_some() {
            report.add(
                Problem::error(name.at.clone(), format!("a drive of the endless axis `{}`", name.value))
                    .hint("turn it by an output to a switch; drives go to places, from zero to the end of an axis"),
            );
        }
    }
}
