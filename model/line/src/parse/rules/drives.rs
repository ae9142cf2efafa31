//! Drives: what their targets, and the operations that use them, must agree on.

use std::collections::HashMap;
use std::time::Duration;

use linewright_text::{Located, Problem, Report, TextRange};

use super::operations::same_place;
use crate::drive::trapezoid_time;
use crate::parse::draft::{DraftDrive, DraftLine, DraftStation};
use crate::parse::drive::method;
use crate::parse::raw::{RawDevice, RawDrive, RawTarget};
use crate::{AxisId, DriveMode, Owner, StationId};

/// Methods that take the place where the axis stands.
const HOMING_IN_PLACE: [i64; 2] = [35, 37];

/// Applies every rule about drives.
pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    axes_have_one_drive(draft, report);
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let (Some(drive), Some(raw_drive)) = (&device.drive, &raw.drive) else { continue };
        drives_have_no_other_bits(raw, raw_drive, report);
        drives_have_targets(raw_drive, report);
        numbers_fit_the_drive(raw_drive, report);
        index_fits_the_drive(raw_drive, report);
        places_are_told_apart(raw_drive, report);
        homing_is_possible(raw_drive, report);
        match device.owner {
            Some(Owner::Station(id)) => {
                let station = &draft.stations[id.index()];
                motions_end_at_their_targets(drive, raw_drive, station, report);
                axes_are_moved_by_their_drive(drive, raw_drive, station, report);
                drives_take_their_time(drive, raw_drive, station, report);
                watchdogs_leave_time_to_home(drive, raw_drive, station, report);
            }
            Some(Owner::Console) => report.add(
                Problem::error(raw_drive.at.clone(), "a drive of the console")
                    .hint("a drive moves an axis of a station; say `station = \"…\"`"),
            ),
            None => {}
        }
    }
}

fn axes_have_one_drive(draft: &DraftLine<'_>, report: &mut Report) {
    let mut seen: HashMap<(StationId, AxisId), _> = HashMap::new();
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let (Some(Owner::Station(station)), Some(drive), Some(raw)) = (device.owner, &device.drive, &raw.drive) else {
            continue;
        };
        let (Some(axis), Some(name)) = (drive.axis, &raw.axis) else { continue };
        if let Some(earlier) = seen.insert((station, axis), &name.at) {
            report.add(
                Problem::error(name.at.clone(), format!("a second drive of axis `{}`", name.value))
                    .label("again")
                    .also(earlier, "first here")
                    .hint("give each drive an axis of its own"),
            );
        }
    }
}

fn drives_have_no_other_bits(raw: &RawDevice, drive: &RawDrive, report: &mut Report) {
    if let Some(bit) = raw.inputs.first().or(raw.outputs.first()) {
        report.add(
            Problem::error(bit.at.clone(), "a drive has no `inputs` and `outputs` beside its `drive` table")
                .also(&drive.at, "its signals are named here")
                .hint("bind the others to a device of their own"),
        );
    }
}

fn drives_have_targets(drive: &RawDrive, report: &mut Report) {
    if let (Some(index), Some(target)) = (&drive.index, drive.targets.first()) {
        report.add(
            Problem::error(target.at.clone(), "a drive has `targets` or an `index`, not both")
                .also(&index.at, "the index")
                .hint("an endless axis has an `index`, any other has `targets`"),
        );
    } else if drive.targets.is_empty() && drive.index.is_none() {
        report.add(
            Problem::error(drive.at.clone(), "this drive has no targets")
                .hint("`targets = [{ output = \"…\", to = 80, at = \"…\" }, …]`"),
        );
    }
}

/// A drive counts in 32 bits. Half of them, so that no sum on the way overflows either.
const INCREMENTS_MAX: f64 = (1u32 << 30) as f64;
/// Within this they are a whole number: more is no rounding of a number that people write.
const INCREMENTS_EVEN: f64 = 1e-6;

fn numbers_fit_the_drive(drive: &RawDrive, report: &mut Report) {
    let Some(units) = drive.units.as_ref().map(|units| units.value) else { return };
    let mut fits = |number: &Option<Located<f64>>, what: &str, least: f64| {
        let Some(number) = number else { return };
        let increments = (number.value * units).round().abs();
        if increments > INCREMENTS_MAX || increments < least {
            let fault = if increments < least { "less than one increment" } else { "more than a drive counts" };
            report.add(
                Problem::error(number.at.clone(), format!("{what} of {} is {fault}", number.value))
                    .label(format!("{increments} increments"))
                    .hint(format!("from {least} to {INCREMENTS_MAX} increments, of which `units_per_mm` is {units}")),
            );
        }
    };
    fits(&drive.window, "a window", 1.0);
    fits(&drive.velocity, "a velocity", 1.0);
    fits(&drive.acceleration, "an acceleration", 1.0);
    fits(&drive.quick_stop, "a deceleration", 1.0);
    for target in &drive.targets {
        fits(&target.to, "a target", 0.0);
        fits(&target.velocity, "a velocity", 1.0);
    }
    if let Some(homing) = &drive.homing {
        fits(&homing.fast, "a speed", 1.0);
        fits(&homing.slow, "a speed", 1.0);
        fits(&homing.acceleration, "an acceleration", 1.0);
        fits(&homing.offset, "an offset", 0.0);
    }
}

/// The drive counts a turn in whole increments; what is left over would add up, turn by turn.
fn index_fits_the_drive(drive: &RawDrive, report: &mut Report) {
    let Some(index) = &drive.index else { return };
    if drive.mode == DriveMode::Velocity {
        report.add(
            Problem::error(index.at.clone(), "an `index` of a drive in velocity mode")
                .hint("`mode = \"position\"`: it goes to places"),
        );
    }
    if let (Some(turn), Some(units)) = (&index.turn, &drive.units) {
        let increments = turn.value * units.value;
        if increments > INCREMENTS_MAX || (increments - increments.round()).abs() > INCREMENTS_EVEN {
            report.add(
                Problem::error(turn.at.clone(), format!("a turn of {} is {increments} increments", turn.value))
                    .label("not a whole number of them, or too many")
                    .also(&units.at, "increments for one unit")
                    .hint(format!(
                        "a whole number, up to {INCREMENTS_MAX}: what is left over would add up with every turn; set up \
                         the drive's own units so that a turn is one"
                    )),
            );
        }
    }
    if let (Some(homing), Some(output)) = (&drive.homing, &index.output)
        && let Some(starts) = &homing.output
        && starts.value != output.value
    {
        report.add(
            Problem::error(starts.at.clone(), format!("the homing of an endless axis by `{}`", starts.value))
                .also(&output.at, "what turns it")
                .hint(format!("`output = \"{}\"`: while it is not homed, this output homes it", output.value)),
        );
    }
}

/// Targets at one place share their input; at different ones they do not, and their windows do not meet.
fn places_are_told_apart(drive: &RawDrive, report: &mut Report) {
    let window = drive.window.as_ref().map_or(0.0, |window| window.value);
    for (nth, target) in drive.targets.iter().enumerate() {
        for earlier in &drive.targets[..nth] {
            let (Some(to), Some(at), Some(other_to), Some(other_at)) =
                (&target.to, &target.input, &earlier.to, &earlier.input)
            else {
                continue;
            };
            let shared = at.value == other_at.value;
            let problem = if same_place(to.value, other_to.value) == shared {
                let apart = (to.value - other_to.value).abs();
                if shared || apart > 2.0 * window {
                    continue;
                }
                Problem::error(to.at.clone(), format!("targets {apart} apart with a window of {window}"))
                    .also(&other_to.at, "the other")
                    .hint("more than two windows apart, so that it is never at both")
            } else if shared {
                Problem::error(at.at.clone(), format!("`{}` would be on at two places", at.value))
                    .also(&other_at.at, format!("at {}", other_to.value))
                    .hint("an input of its own for each place")
            } else {
                Problem::error(at.at.clone(), format!("a second input for being at {}", to.value))
                    .also(&other_at.at, "the first")
                    .hint(format!("`at = \"{}\"` here too: one place, one input", other_at.value))
            };
            report.add(problem);
            break;
        }
    }
}

fn homing_is_possible(drive: &RawDrive, report: &mut Report) {
    let Some(homing) = &drive.homing else { return };
    if let Some(number) = &homing.method
        && method(number.value).is_none()
    {
        report.add(
            Problem::error(number.at.clone(), format!("{} is not a homing method", number.value))
                .hint("1 to 37 as CiA 402 numbers them, or -128 to -1 for the manufacturer's own"),
        );
    }
    if let (Some(fast), Some(slow)) = (&homing.fast, &homing.slow)
        && slow.value > fast.value
    {
        report.add(
            Problem::error(slow.at.clone(), format!("homing slowly at {} and fast at {}", slow.value, fast.value))
                .also(&fast.at, "less than that"),
        );
    }
    if drive.mode == DriveMode::Velocity
        && let Some(output) = &homing.output
    {
        report.add(Problem::error(output.at.clone(), "no homing in velocity mode"));
    }
}

/// The motions of a station that an output drives: operation, where they end, their limit switch, their watchdog.
fn motions_end_at_their_targets(drive: &DraftDrive, raw: &RawDrive, station: &DraftStation<'_>, report: &mut Report) {
    for (target, raw_target) in drive.targets.iter().zip(&raw.targets) {
        let (Some(output), Some(to)) = (target.output, &raw_target.to) else { continue };
        for operation in &station.operations {
            let Some(motion) = &operation.motion else { continue };
            for (signals, end) in operation.motions() {
                let (Some(actuator), Some(end)) = (&signals.actuator, end) else { continue };
                if actuator.value != output {
                    continue;
                }
                let name = raw_target.output.as_ref().map_or("?", |name| name.value.as_str());
                if drive.axis.is_some_and(|axis| axis != motion.value.axis) {
                    let moved = &station.axes[motion.value.axis.index()].name;
                    report.add(
                        Problem::error(actuator.at.clone(), format!("`{name}` does not move `{moved}`"))
                            .also(&raw_target.at, "a target of the drive of another axis"),
                    );
                } else if !same_place(end, to.value) {
                    report.add(
                        Problem::error(to.at.clone(), format!("`{name}` goes to {}, not to {end}", to.value))
                            .also(&actuator.at, format!("`{}` drives to {end}", operation.name)),
                    );
                } else if let (Some(complete), Some(at)) = (&signals.complete, target.at)
                    && complete.value != at
                {
                    report.add(
                        Problem::error(
                            complete.at.clone(),
                            format!("`{name}` ends where another input than this one is on"),
                        )
                        .also(&raw_target.at, "the target and its input"),
                    );
                }
            }
        }
    }
}

/// An axis on a drive is moved by the drive alone.
fn axes_are_moved_by_their_drive(drive: &DraftDrive, raw: &RawDrive, station: &DraftStation<'_>, report: &mut Report) {
    let Some(axis) = drive.axis else { return };
    let of_drive = |output| {
        let homing = drive.homing.and_then(|(output, _)| output);
        drive.all_targets().filter_map(|target| target.output).chain(homing).any(|own| own == output)
    };
    for operation in &station.operations {
        if operation.motion.as_ref().is_none_or(|motion| motion.value.axis != axis) {
            continue;
        }
        for actuator in operation.motions().filter_map(|(signals, _)| signals.actuator.as_ref()) {
            if !of_drive(actuator.value) {
                let axis = &station.axes[axis.index()].name;
                report.add(
                    Problem::error(
                        actuator.at.clone(),
                        format!("`{}` moves `{axis}` by something else than its drive", operation.name),
                    )
                    .also(&raw.at, format!("the drive of `{axis}`"))
                    .hint("make it a target of the drive"),
                );
            }
        }
    }
}

/// A drive that takes less than this part of the planned time: one of the two numbers is wrong.
const FAR_TOO_FAST: f64 = 0.25;

/// The drive must be able to make the way in the time the watchdog leaves, and takes about as long as is planned.
fn drives_take_their_time(drive: &DraftDrive, raw: &RawDrive, station: &DraftStation<'_>, report: &mut Report) {
    let (DriveMode::Position, Some(velocity), Some(acceleration)) = (raw.mode, &raw.velocity, &raw.acceleration) else {
        return;
    };
    let target_of = |output| -> Option<Option<&RawTarget>> {
        let at = drive.all_targets().position(|target| target.output == Some(output))?;
        Some(raw.targets.get(at))
    };
    for operation in &station.operations {
        let Some(motion) = &operation.motion else { continue };
        let (own, recovery) = (operation.raw, operation.raw.recovery.as_ref());
        let watchdog = recovery.and_then(|of| of.watchdog.as_ref()).or(own.watchdog.as_ref());
        let duration = recovery.and_then(|of| of.duration.as_ref()).or(own.duration.as_ref());
        let limits = [(own.watchdog.as_ref(), own.duration.as_ref()), (watchdog, duration)];
        // Both motions at one velocity and with one time are one mistake.
        let mut reported: Vec<(TextRange, TextRange)> = Vec::new();
        for (nth, ((signals, _), (watchdog, duration))) in operation.motions().zip(limits).enumerate() {
            let (Some(actuator), Some(watchdog), Some(duration)) = (&signals.actuator, watchdog, duration) else {
                continue;
            };
            let Some(target) = target_of(actuator.value) else { continue };
            let velocity = target.and_then(|target| target.velocity.as_ref()).unwrap_or(velocity);
            let way = operation.by().map_or(motion.value.to - motion.value.from, |by| by.value);
            let name = format!("{}`{}`", if nth == 0 { "" } else { "the recovery motion of " }, operation.name);
            let motion = DrivenMotion { name, way, velocity, acceleration };
            let Some((problem, places)) = motion.late(watchdog).or_else(|| motion.far_too_fast(duration)) else {
                continue;
            };
            if !reported.contains(&places) {
                reported.push(places);
                report.add(problem);
            }
        }
    }
}

/// A motion that a drive makes.
struct DrivenMotion<'r> {
    name: String,
    way: f64,
    velocity: &'r Located<f64>,
    acceleration: &'r Located<f64>,
}

impl DrivenMotion<'_> {
    fn takes(&self) -> f64 {
        trapezoid_time(self.way, self.velocity.value, self.acceleration.value)
    }

    /// It takes longer than its watchdog: the problem, and the places of the two numbers.
    fn late(&self, watchdog: &Located<Duration>) -> Option<(Problem, (TextRange, TextRange))> {
        let (takes, limit) = (self.takes(), watchdog.value.as_secs_f64());
        if takes < limit {
            return None;
        }
        let is_in_time = |velocity, acceleration| trapezoid_time(self.way, velocity, acceleration) < limit;
        // The acceleration alone: no velocity would do, and this one would with another acceleration.
        let by_acceleration =
            is_in_time(self.velocity.value, f64::INFINITY) && !is_in_time(f64::INFINITY, self.acceleration.value);
        let (at, mark, hint) = if by_acceleration {
            (&self.acceleration.at, "at this acceleration", "a longer watchdog, or a greater `acceleration`")
        } else {
            (&self.velocity.at, "at this velocity", "a longer watchdog, or a faster drive")
        };
        let message = format!("the watchdog of {} is {limit} s, but the drive takes {takes:.3} s", self.name);
        let problem = Problem::error(watchdog.at.clone(), message).label("too short").also(at, mark).hint(hint);
        Some((problem, (watchdog.at.clone(), at.clone())))
    }

    /// It takes far less than is planned: the problem, and the places of the two numbers.
    fn far_too_fast(&self, duration: &Located<Duration>) -> Option<(Problem, (TextRange, TextRange))> {
        let (takes, planned) = (self.takes(), duration.value.as_secs_f64());
        if takes >= planned * FAR_TOO_FAST {
            return None;
        }
        let message = format!("the drive takes {takes:.3} s for {}, `duration_s` says {planned} s", self.name);
        let problem = Problem::warning(self.velocity.at.clone(), message)
            .label("at this velocity")
            .also(&duration.at, "planned")
            .hint("if the drive is to be so fast, plan what it takes; else write its velocity in units per second");
        Some((problem, (duration.at.clone(), self.velocity.at.clone())))
    }
}

/// An index that is cut short, and the first one, homes the drive within its watchdog: it may look for its reference all the way
/// round before it goes on.
fn watchdogs_leave_time_to_home(drive: &DraftDrive, raw: &RawDrive, station: &DraftStation<'_>, report: &mut Report) {
    let (Some(homing), Some(index)) = (&raw.homing, &raw.index) else { return };
    let (Some(fast), Some(turn), Some(number)) = (&homing.fast, &index.turn, &homing.method) else { return };
    let (Some(velocity), Some(acceleration)) = (&raw.velocity, &raw.acceleration) else { return };
    if HOMING_IN_PLACE.contains(&number.value) {
        return;
    }
    let Some((output, _)) = drive.homing else { return };
    for operation in &station.operations {
        let (Some(way), Some(watchdog)) = (operation.by(), operation.raw.watchdog.as_ref()) else { continue };
        let turns =
            operation.motions().any(|(signals, _)| signals.actuator.as_ref().map(|actuator| actuator.value) == output);
        let takes = turn.value / fast.value + trapezoid_time(way.value, velocity.value, acceleration.value);
        let limit = watchdog.value.as_secs_f64();
        if turns && takes >= limit {
            report.add(
                Problem::warning(
                    watchdog.at.clone(),
                    format!(
                        "the watchdog of `{}` is {limit} s, but with the homing it may take {takes:.1} s",
                        operation.name
                    ),
                )
                .label("too short for both")
                .also(&fast.at, format!("a whole turn of {} at this speed", turn.value))
                .hint(
                    "a longer watchdog, or a faster search; else it is held again and again until the drive is homed",
                ),
            );
        }
    }
}
