//! A device's `drive` table: its names → bits of its station's image, and at the end → [`Drive`].
//!
//! A drive's signals are bits of the image like any device's; only what they mean on the wire differs, which is no
//! matter of this crate.

use linewright_text::{Located, LocatedName, NameTable, Report};

use super::draft::{DraftDrive, DraftIndex, DraftTarget};
use super::raw::{RawDrive, RawDriveIndex, RawTarget};
use super::wiring::{Wires, one_input, one_output};
use crate::{Axis, AxisId, Drive, DriveIndex, DriveTarget, Homing, InputId, OutputId};

/// Every signal a drive names.
pub(super) fn signals(raw: &RawDrive) -> impl Iterator<Item = &LocatedName> + Clone {
    let of_targets = raw.targets.iter().flat_map(|target| target.output.iter().chain(&target.input));
    let of_index =
        raw.index.iter().flat_map(|index| index.output.iter().chain(&index.input).chain(&index.to).chain(&index.place));
    let of_homing = raw.homing.iter().flat_map(|homing| homing.output.iter().chain(&homing.done));
    of_targets.chain(of_index).chain(&raw.fault).chain(of_homing)
}

/// Binds a drive's signals; `axes` are those of its station, where it has one.
pub(super) fn wire<'a>(
    raw: &'a RawDrive,
    axes: Option<&NameTable<'_>>,
    wires: &mut Wires<'a>,
    report: &mut Report,
) -> DraftDrive {
    let axis = match (&raw.axis, axes) {
        (Some(axis), Some(axes)) => axes.find(axis, "axis", report).map(AxisId::at),
        _ => None,
    };
    // Targets at one place share their input: its name stands at each of them, and is bound once.
    let mut bound: Vec<(&'a str, Option<InputId>)> = Vec::new();
    let mut targets = Vec::with_capacity(raw.targets.len());
    for target in &raw.targets {
        let output = target.output.as_ref().and_then(|output| one_output(output, wires, report));
        let at = target.input.as_ref().and_then(|input| {
            if let Some((_, id)) = bound.iter().find(|(name, _)| *name == input.value) {
                return *id;
            }
            let id = one_input(input, wires, report);
            bound.push((&input.value, id));
            id
        });
        targets.push(DraftTarget { output, at });
    }
    let index = raw.index.as_ref().map(|index| DraftIndex {
        target: DraftTarget {
            output: index.output.as_ref().and_then(|output| one_output(output, wires, report)),
            at: index.input.as_ref().and_then(|input| one_input(input, wires, report)),
        },
        to: index.to.iter().map(|bit| one_output(bit, wires, report)).collect(),
        place: index.place.iter().map(|bit| one_input(bit, wires, report)).collect(),
    });
    let fault = raw.fault.as_ref().and_then(|fault| one_input(fault, wires, report));
    let homing = raw.homing.as_ref().map(|homing| {
        let output = homing.output.as_ref().and_then(|output| {
            let named = |target: &&RawTarget| target.output.as_ref().is_some_and(|o| o.value == output.value);
            let of_index = raw.index.as_ref().and_then(|index| index.output.as_ref());
            match raw.targets.iter().position(|target| named(&target)) {
                Some(at) => targets[at].output,
                None if of_index.is_some_and(|own| own.value == output.value) => {
                    index.as_ref().and_then(|index| index.target.output)
                }
                None => one_output(output, wires, report),
            }
        });
        (output, homing.done.as_ref().and_then(|done| one_input(done, wires, report)))
    });
    DraftDrive { axis, targets, index, fault, homing }
}

/// How many places an endless axis has, where they come out even.
pub(super) fn places(turn: f64, by: f64) -> Option<u16> {
    let places = (turn / by).round();
    let fits = (2.0..=PLACES_MAX).contains(&places) && (places * by - turn).abs() < 1e-6;
    fits.then_some(places as u16)
}

/// Most places of a turn; their numbers fit `PLACE_BITS_MAX` bits.
pub(super) const PLACES_MAX: f64 = 1000.0;

/// The places of an endless axis as targets, and how it turns.
fn finish_index(
    draft: &DraftIndex,
    raw: &RawDriveIndex,
    axis: &Axis,
    velocity: f64,
) -> Option<(Vec<DriveTarget>, DriveIndex)> {
    let (output, at) = (draft.target.output?, draft.target.at?);
    let by = axis.index?;
    let turn = raw.turn.as_ref()?.value;
    let places = places(turn, by)?;
    let index = DriveIndex {
        places,
        turn,
        direction: raw.direction,
        to: draft.to.iter().copied().collect::<Option<_>>()?,
        place: draft.place.iter().copied().collect::<Option<_>>()?,
    };
    let place = |nth: u16| {
        let to = (axis.home + index.sign() * by * f64::from(nth)).rem_euclid(turn);
        DriveTarget { output, to, at, velocity }
    };
    Some(((0..places).map(place).collect(), index))
}

/// The drive a draft describes, of one of these axes; `None` if a part is missing.
pub(super) fn finish(draft: &DraftDrive, raw: &RawDrive, axes: &[Axis]) -> Option<Drive> {
    let or = |own: &Option<Located<f64>>, else_: f64| own.as_ref().map_or(else_, |own| own.value);
    let (velocity, acceleration) = (raw.velocity.as_ref()?.value, raw.acceleration.as_ref()?.value);
    let targets = draft.targets.iter().zip(&raw.targets).map(|(draft, raw)| {
        let (output, at): (OutputId, InputId) = (draft.output?, draft.at?);
        Some(DriveTarget { output, to: raw.to.as_ref()?.value, at, velocity: or(&raw.velocity, velocity) })
    });
    let targets: Vec<DriveTarget> = targets.collect::<Option<_>>()?;
    let axis = draft.axis?;
    let (targets, index) = match (&draft.index, &raw.index) {
        (Some(draft), Some(raw)) => {
            let (targets, index) = finish_index(draft, raw, axes.get(axis.index())?, velocity)?;
            (targets, Some(index))
        }
        _ => (targets, None),
    };
    let homing = match (&draft.homing, &raw.homing) {
        (Some((output, done)), Some(raw)) => Some(Homing {
            method: method(raw.method.as_ref()?.value)?,
            fast: raw.fast.as_ref()?.value,
            slow: raw.slow.as_ref()?.value,
            acceleration: or(&raw.acceleration, acceleration),
            offset: or(&raw.offset, 0.0),
            output: (*output)?,
            done: *done,
        }),
        _ => None,
    };
    Some(Drive {
        axis,
        mode: raw.mode,
        units_per_mm: raw.units.as_ref()?.value,
        window: raw.window.as_ref()?.value,
        velocity,
        acceleration,
        quick_stop: or(&raw.quick_stop, acceleration),
        at_rest: raw.at_rest,
        targets,
        index,
        fault: draft.fault,
        homing,
    })
}

/// A homing method's number: 1 to 37 are the profile's, negative ones the manufacturer's (CiA 402, object 6098h).
pub(super) fn method(value: i64) -> Option<i8> {
    i8::try_from(value).ok().filter(|method| *method < 0 || (1..=37).contains(method))
}
