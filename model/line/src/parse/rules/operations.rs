//! One operation by itself.

use std::time::Duration;

use linewright_text::{Located, Problem, Report};

use crate::parse::draft::{DraftOperation, DraftStation};
use crate::parse::raw::ModuleKind;

/// Coordinates nearer than this are the same place: a micrometre below the resolution of any switch.
pub(super) const SAME_PLACE: f64 = 1e-6;

pub(in crate::parse) fn same_place(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_PLACE
}

pub(super) fn motion_goes_somewhere(operation: &DraftOperation<'_>, report: &mut Report) {
    let Some(moves) = &operation.raw.moves else { return };
    let (Some(from), Some(to)) = (&moves.from, &moves.to) else { return };
    if same_place(from.value, to.value) {
        report.add(
            Problem::error(to.at.clone(), format!("`{}` moves from {} to {}", operation.name, from.value, to.value))
                .label("does not move")
                .hint("an operation that moves nothing has no switch to tell its beginning from its end"),
        );
    }
}

/// Motions that take longer are rare, and milliseconds written as seconds are not.
const LONG: Duration = Duration::from_secs(300);

pub(super) fn duration_is_in_seconds(operation: &DraftOperation<'_>, report: &mut Report) {
    let recovery = operation.raw.recovery.as_ref().and_then(|recovery| recovery.duration.as_ref());
    for duration in operation.raw.duration.iter().chain(recovery).filter(|duration| duration.value >= LONG) {
        let takes = duration.value.as_secs_f64();
        report.add(
            Problem::warning(duration.at.clone(), format!("a motion of `{}` takes {takes} s", operation.name))
                .label("in seconds")
                .hint(format!("if these are milliseconds, write {}", takes / 1000.0)),
        );
    }
}

/// A watchdog that is so many times the motion, and so long, is in another unit: a mechanism that stands would be driven all that time.
const FAR_TOO_LONG: u32 = 100;
const LONG_WATCHDOG: Duration = Duration::from_secs(60);

/// An index homes its drive within its watchdog, and may look for the reference all the way round.
pub(super) fn watchdog_is_in_seconds(station: &DraftStation<'_>, operation: &DraftOperation<'_>, report: &mut Report) {
    if operation.by().is_some() {
        return;
    }
    for (what, duration, watchdog) in watched(station, operation) {
        if watchdog.value < LONG_WATCHDOG || watchdog.value < duration.value.saturating_mul(FAR_TOO_LONG) {
            continue;
        }
        let (limit, takes) = (watchdog.value.as_secs_f64(), duration.value.as_secs_f64());
        report.add(
            Problem::warning(
                watchdog.at.clone(),
                format!("the watchdog of {what} is {limit} s, but it takes {takes} s"),
            )
            .label("in seconds")
            .also(&duration.at, "takes this long")
            .hint(format!(
                "a mechanism that stands is driven until the watchdog ends; twice as long as the motion is usual: {}",
                takes * 2.0
            )),
        );
    }
}

/// A recovery that another operation's normal motion is, by the same output from one end to the other, takes as long.
pub(super) fn one_motion_takes_one_time(station: &DraftStation<'_>, report: &mut Report) {
    for operation in &station.operations {
        let Some(duration) = operation.raw.recovery.as_ref().and_then(|recovery| recovery.duration.as_ref()) else {
            continue;
        };
        let Some(other) = same_motion(station, operation) else { continue };
        let Some(normal) = other.raw.duration.as_ref().filter(|normal| normal.value != duration.value) else {
            continue;
        };
        let (here, there) = (duration.value.as_secs_f64(), normal.value.as_secs_f64());
        report.add(
            Problem::error(
                duration.at.clone(),
                format!("the recovery of `{}` takes {here} s, but `{}` takes {there} s", operation.name, other.name),
            )
            .label("one motion")
            .also(&normal.at, "the same motion")
            .hint("one output moves the axis from one end to the other: give one time, or leave this one out"),
        );
    }
}

/// The operation whose normal motion is the recovery of this one.
pub(in crate::parse) fn same_motion<'s, 'a>(
    station: &'s DraftStation<'a>,
    operation: &DraftOperation<'_>,
) -> Option<&'s DraftOperation<'a>> {
    let back = operation.motion.as_ref()?.value;
    let actuator = operation.recovery.as_ref()?.actuator.as_ref()?.value;
    station.operations.iter().find(|other| {
        other.normal.actuator.as_ref().is_some_and(|normal| normal.value == actuator)
            && other.motion.as_ref().is_some_and(|Located { value: on, .. }| {
                on.axis == back.axis && same_place(on.from, back.to) && same_place(on.to, back.from)
            })
    })
}

pub(super) fn watchdog_outlasts_duration(
    station: &DraftStation<'_>,
    operation: &DraftOperation<'_>,
    report: &mut Report,
) {
    for (what, duration, watchdog) in watched(station, operation) {
        outlasts(&what, duration, watchdog, report);
    }
}

/// A motion's name, its time and its watchdog.
type Watched<'a> = (String, &'a Located<Duration>, &'a Located<Duration>);

/// The motions of an operation whose times are written.
fn watched<'a>(station: &DraftStation<'a>, operation: &DraftOperation<'a>) -> Vec<Watched<'a>> {
    let raw = operation.raw;
    let what = format!("`{}`", operation.name);
    let recovery = raw.recovery.as_ref().filter(|of| of.duration.is_some() || of.watchdog.is_some());
    let recovery = recovery.and_then(|recovery| {
        // Values not given are those of the same motion, or of the operation's own.
        let same = same_motion(station, operation).map_or(raw, |other| other.raw);
        let duration = recovery.duration.as_ref().or(same.duration.as_ref())?;
        Some((format!("the recovery of {what}"), duration, recovery.watchdog.as_ref().or(same.watchdog.as_ref())?))
    });
    let normal =
        raw.duration.as_ref().zip(raw.watchdog.as_ref()).map(|(duration, watchdog)| (what, duration, watchdog));
    normal.into_iter().chain(recovery).collect()
}

fn outlasts(what: &str, duration: &Located<Duration>, watchdog: &Located<Duration>, report: &mut Report) {
    if watchdog.value <= duration.value {
        let (limit, takes) = (watchdog.value.as_secs_f64(), duration.value.as_secs_f64());
        report.add(
            Problem::error(watchdog.at.clone(), format!("the watchdog of {what} is {limit} s, but it takes {takes} s"))
                .label("too short")
                .also(&duration.at, "takes this long")
                .hint("a watchdog must be longer than the motion it watches; twice as long is usual"),
        );
    }
}

pub(super) fn module_has_its_recovery(station: &DraftStation<'_>, operation: &DraftOperation<'_>, report: &mut Report) {
    let (raw, name) = (operation.raw, operation.name);
    match operation.kind() {
        Some(ModuleKind::Reversible) => {
            if raw.recovery.is_none() {
                report.add(
                    Problem::error(operation.place(), format!("reversible operation `{name}` has no `recovery`"))
                        .hint("say which actuator takes it back and which switch says so, or make it module \"I\""),
                );
            }
            if let Some(path) = &raw.recovery_path {
                report.add(
                    Problem::error(path.at.clone(), format!("reversible operation `{name}` has a `recovery_path`"))
                        .hint("only an irreversible operation goes home along a path; this one has its `recovery`"),
                );
            }
        }
        Some(ModuleKind::Irreversible) => {
            if let Some(recovery) = &raw.recovery {
                report.add(
                    Problem::error(recovery.at.clone(), format!("irreversible operation `{name}` has a `recovery`"))
                        .hint("it is never run backwards; say how to get home from it with `recovery_path = […]`"),
                );
            }
            // Where there is no place, a way was written, be it a wrong one.
            let goes_on = raw.moves.as_ref().is_some_and(|m| m.by.is_some() || (m.from.is_none() && m.to.is_none()));
            if !goes_on && raw.recovery_path.as_ref().is_none_or(|path| path.value.is_empty()) {
                let at = raw.recovery_path.as_ref().map_or_else(|| operation.place(), |path| path.at.clone());
                let missing = if raw.recovery_path.is_some() { "an empty recovery path" } else { "no recovery path" };
                let last =
                    if station.is_task_driven() { "the last operation of its task" } else { "the home operation" };
                report.add(
                    Problem::error(at, format!("irreversible operation `{name}` has {missing}")).hint(format!(
                        "list in `recovery_path` the operations to take back, one at least, in order; then {last} follows by \
                         itself"
                    )),
                );
            }
        }
        None => {}
    }
}
