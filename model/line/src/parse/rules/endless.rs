//! Axes that turn endlessly: rotary tables, chains. An operation with `by` is the index of one.
//!
//! An index is never taken back, and a cycle in which it is done twice has lost its parts. So a station with an endless axis
//! has no way home along which its round would be done again: nothing else in it is irreversible.

use std::collections::HashMap;
use std::time::Duration;

use linewright_text::{Problem, Report, TextRange};

use super::operations::same_place;
use crate::parse::draft::{DraftIndex, DraftLine, DraftOperation, DraftStation};
use crate::parse::drive::{PLACES_MAX, places};
use crate::parse::raw::{ModuleKind, RawDrive, RawDriveIndex};
use crate::{AxisId, Owner, StationId};

/// Applies the rules for the endless axes of a station.
pub(super) fn check(draft: &DraftLine<'_>, id: StationId, stale: Duration, report: &mut Report) {
    let station = &draft.stations[id.index()];
    let mut indexes = station.operations.iter().filter(|op| op.by().is_some());
    for index in indexes.clone() {
        has_no_way_back(index, report);
        // A drive tells which place it is at, and goes to one.
        let axis = index.motion.as_ref().map(|motion| motion.value.axis);
        if axis.is_none_or(|axis| !draft.is_turned_by_drive(id, axis)) {
            passes_no_place_unseen(index, stale, report);
        }
    }
    goes_one_way_to_one_switch(station, report);
    let Some(first) = indexes.next() else { return };
    if station.is_task_driven() {
        let at = first.by().map_or_else(|| first.place(), |by| by.at.clone());
        report.add(
            Problem::error(at, format!("an endless axis in station `{}`, which is task-driven", station.name)).hint(
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
                format!("the watchdog of index `{name}` is {limit} s, twice its {takes} s or longer"),
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

/// The drive of an endless axis is sent to its places, by their numbers.
pub(super) fn drives_go_to_places(draft: &DraftLine<'_>, report: &mut Report) {
    let mut first: HashMap<StationId, &TextRange> = HashMap::new();
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let (Some(Owner::Station(id)), Some(drive), Some(raw)) = (device.owner, &device.drive, &raw.drive) else {
            continue;
        };
        let (Some(axis), Some(name)) = (drive.axis, &raw.axis) else { continue };
        let station = &draft.stations[id.index()];
        match (station.axes[axis.index()].index, &drive.index, &raw.index) {
            (Some(by), Some(drive), Some(index)) => {
                if let Some(other) = first.insert(id, &index.at) {
                    report.add(
                        Problem::error(index.at.clone(), "a second drive with an `index` in one station")
                            .also(other, "the first")
                            .hint("a station of its own for each such axis"),
                    );
                }
                places_come_out_even(by, raw, index, report);
                ends_where_the_drive_says(axis, drive, index, station, report);
            }
            (Some(_), ..) => report.add(
                Problem::error(
                    name.at.clone(),
                    format!("a drive of the endless axis `{}` without an `index`", name.value),
                )
                .hint(
                    "it goes from place to place: `index = { output = \"…\", at = \"…\", turn = 360, to = […], place = \
                         […] }` instead of `targets`",
                ),
            ),
            (None, _, Some(index)) => report.add(
                Problem::error(index.at.clone(), format!("an `index` of `{}`, which is not endless", name.value))
                    .hint("`targets`; or an operation that moves it `by` so much, which makes it endless"),
            ),
            (None, _, None) => {}
        }
    }
}

/// Its places are told apart by number and by position.
fn places_come_out_even(by: f64, drive: &RawDrive, index: &RawDriveIndex, report: &mut Report) {
    if let Some(window) = drive.window.as_ref().filter(|window| window.value * 2.0 >= by) {
        report.add(
            Problem::error(window.at.clone(), format!("a window of {} where places are {by} apart", window.value))
                .hint("less than half the way from place to place, so that it is never at two"),
        );
    }
    let Some(turn) = &index.turn else { return };
    let Some(count) = places(turn.value, by) else {
        report.add(
            Problem::error(turn.at.clone(), format!("a turn of {} is {} indexes of {by}", turn.value, turn.value / by))
                .hint(format!(
                    "a whole number of them, from 2 to {PLACES_MAX}: with one place its position would not tell before an \
                     index from after it"
                )),
        );
        return;
    };
    let needed = (u16::BITS - count.leading_zeros()) as usize;
    for (bits, key) in [(&index.to, "to"), (&index.place, "place")] {
        if let Some(bit) = bits.iter().find(|bit| bit.value.is_empty()) {
            report.add(
                Problem::error(bit.at.clone(), format!("a bit of `{key}` without a name"))
                    .hint("all bits of the number have names"),
            );
        } else if bits.len() != needed {
            let (has, bits) = (bits.len(), if needed == 1 { "bit" } else { "bits" });
            report.add(
                Problem::error(
                    index.at.clone(),
                    format!("`{key}` needs {needed} {bits} for {count} places, has {has}"),
                )
                .hint("names, the lowest bit first; places are numbered from 1, and 0 is none of them"),
            );
        }
    }
}

/// An index ends where its drive says that it is in place.
fn ends_where_the_drive_says(
    axis: AxisId,
    drive: &DraftIndex,
    raw: &RawDriveIndex,
    station: &DraftStation<'_>,
    report: &mut Report,
) {
    let of_axis = |op: &&DraftOperation<'_>| op.motion.as_ref().is_some_and(|motion| motion.value.axis == axis);
    for operation in station.operations.iter().filter(of_axis) {
        if let (Some(complete), Some(at), Some(input)) = (&operation.normal.complete, drive.target.at, &raw.input)
            && complete.value != at
        {
            report.add(
                Problem::error(
                    complete.at.clone(),
                    format!("`{}` ends where another input than `{}` is on", operation.name, input.value),
                )
                .also(&input.at, "on while the drive is at a place"),
            );
        }
    }
}
