//! Meaning of a station's signals: one each.
//!
//! An input is a limit switch at one position, a fault sensor, or part of the panel; an output drives one axis to one
//! position, or is a lamp. A name that would mean two of these is a slip that no test run shows before the plant does.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use linewright_text::{Located, Problem, Report};

use super::operations::same_place;
use crate::parse::draft::{DraftIndex, DraftStation};

/// Meaning of a signal.
#[derive(Clone, Debug)]
pub(super) enum SignalUse {
    /// On while this axis stands here.
    Switch(String, f64),
    Fault,
    /// A key of `panel` or `[console]`, or a button.
    Control(String),
    /// Moves this axis to here.
    Drive(String, f64),
    Lamp,
    /// A bit of a task's parameter, by its name.
    Number(String, usize),
    /// A bit of the number of a place of an endless axis, by its key.
    Place(&'static str, usize),
    /// It sees parts.
    Part,
    /// A lamp of the console, by its key.
    ModeLamp(&'static str),
}

impl SignalUse {
    fn agrees_with(&self, other: &SignalUse) -> bool {
        match (self, other) {
            (SignalUse::Switch(a, x), SignalUse::Switch(b, y)) | (SignalUse::Drive(a, x), SignalUse::Drive(b, y)) => {
                a == b && same_place(*x, *y)
            }
            (SignalUse::Number(a, x), SignalUse::Number(b, y)) => a == b && x == y,
            (SignalUse::Fault, SignalUse::Fault) | (SignalUse::Lamp, SignalUse::Lamp) => true,
            _ => false,
        }
    }
}

impl fmt::Display for SignalUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SignalUse::Switch(axis, at) => write!(f, "`{axis}` has arrived at {at}"),
            SignalUse::Fault => f.write_str("a motion has failed"),
            SignalUse::Control(key) => write!(f, "the operator's `{key}`"),
            SignalUse::Drive(axis, to) => write!(f, "drive `{axis}` to {to}"),
            SignalUse::Lamp => f.write_str("a fault lamp"),
            SignalUse::Number(parameter, bit) => write!(f, "bit {bit} of parameter `{parameter}`"),
            SignalUse::Place(key, bit) => write!(f, "bit {bit} of `{key}`, the number of a place"),
            SignalUse::Part => f.write_str("a sensor sees parts"),
            SignalUse::ModeLamp(key) => write!(f, "the lamp for `{key}`"),
        }
    }
}

/// The uses of one image's bits, in the order of the text.
pub(super) struct Uses<'d> {
    names: &'d [Located<String>],
    by_bit: BTreeMap<usize, Vec<(SignalUse, Range<usize>)>>,
}

impl<'d> Uses<'d> {
    pub fn of(names: &'d [Located<String>]) -> Self {
        Uses { names, by_bit: BTreeMap::new() }
    }

    /// Notes that bit `bit` is used as `meaning` at `at`.
    pub fn note(&mut self, bit: usize, meaning: SignalUse, at: &Range<usize>) {
        self.by_bit.entry(bit).or_default().push((meaning, at.clone()));
    }

    /// Notes that the bit is used, though not what for: the text does not give it, or anything will do.
    fn note_unclear(&mut self, bit: usize) {
        self.by_bit.entry(bit).or_default();
    }

    /// Reports bits that mean two things, and (as warnings) bits that mean nothing; what is unused is known only where every use is
    /// understood.
    pub fn report(&self, report: &mut Report) {
        let is_understood = !report.has_unknown();
        for (bit, name) in self.names.iter().enumerate() {
            let Some(uses) = self.by_bit.get(&bit) else {
                if is_understood {
                    report.add(
                        Problem::warning(name.at.clone(), format!("nothing uses `{}`", name.value))
                            .label("bound, but not used")
                            .hint("write \"\" for a bit that is not connected"),
                    );
                }
                continue;
            };
            let Some(((first, first_at), others)) = uses.split_first() else { continue };
            if let Some((other, at)) = others.iter().find(|(other, _)| !first.agrees_with(other)) {
                report.add(
                    Problem::error(at.clone(), format!("`{}` means two things", name.value))
                        .label(other.to_string())
                        .also(first_at, first.to_string())
                        .hint("a signal means one thing; use another one here"),
                );
            }
        }
    }
}

pub(super) fn inputs_mean_one_thing<'d>(
    station: &DraftStation<'_>,
    drives: impl Iterator<Item = &'d DraftIndex>,
    report: &mut Report,
) {
    let mut uses = Uses::of(&station.wiring.inputs);
    for operation in &station.operations {
        for (signals, _) in operation.motions() {
            if let Some(fault) = &signals.fault {
                uses.note(fault.value.index(), SignalUse::Fault, &fault.at);
            }
        }
        let axis = operation.motion.as_ref().map(|m| station.axes[m.value.axis.index()].name.clone());
        for (signals, end) in operation.motions() {
            match (&signals.complete, &axis, end) {
                (Some(complete), Some(axis), Some(end)) => {
                    uses.note(complete.value.index(), SignalUse::Switch(axis.clone(), end), &complete.at);
                }
                (Some(complete), _, _) => uses.note_unclear(complete.value.index()),
                (None, _, _) => {}
            }
        }
    }
    // What an operation waits for may be any input, one with another meaning too.
    station.operations.iter().flat_map(|operation| operation.waits.iter().chain(&operation.result)).for_each(|input| {
        uses.note_unclear(input.value.index());
    });
    for (input, key) in station.panel.iter().zip(["manual", "advance", "return"]) {
        if let Some(input) = input {
            uses.note(input.value.index(), SignalUse::Control(key.to_owned()), &input.at);
        }
    }
    for (nth, bit) in drives.flat_map(|index| index.place.iter().enumerate()) {
        if let Some(bit) = bit {
            let at = &station.wiring.inputs[bit.index()].at;
            uses.note(bit.index(), SignalUse::Place("place", nth), at);
        }
    }
    for input in &station.sensed {
        uses.note(input.value.index(), SignalUse::Part, &input.at);
    }
    uses.report(report);
}

pub(super) fn outputs_mean_one_thing<'d>(
    station: &DraftStation<'_>,
    drives: impl Iterator<Item = &'d DraftIndex>,
    report: &mut Report,
) {
    let mut uses = Uses::of(&station.wiring.outputs);
    for operation in &station.operations {
        let axis = operation.motion.as_ref().map(|m| station.axes[m.value.axis.index()].name.clone());
        for (signals, end) in operation.motions() {
            match (&signals.actuator, &axis, end) {
                (Some(actuator), Some(axis), Some(end)) => {
                    uses.note(actuator.value.index(), SignalUse::Drive(axis.clone(), end), &actuator.at);
                }
                (Some(actuator), _, _) => uses.note_unclear(actuator.value.index()),
                (None, _, _) => {}
            }
            if let Some(lamp) = &signals.lamp {
                uses.note(lamp.value.index(), SignalUse::Lamp, &lamp.at);
            }
        }
    }
    for (nth, bit) in drives.flat_map(|index| index.to.iter().enumerate()) {
        if let Some(bit) = bit {
            let at = &station.wiring.outputs[bit.index()].at;
            uses.note(bit.index(), SignalUse::Place("to", nth), at);
        }
    }
    for parameter in station.tasks.iter().flat_map(|task| &task.parameters) {
        for (nth, bit) in parameter.bits.iter().enumerate() {
            if let Some(bit) = bit {
                uses.note(bit.value.index(), SignalUse::Number(parameter.name.to_owned(), nth), &bit.at);
            }
        }
    }
    uses.report(report);
}
