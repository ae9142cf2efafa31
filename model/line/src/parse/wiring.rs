//! Devices → process images: names and bits of each owner's image.
//!
//! An image has no layout of its own in a description: its bits are the connected bits of its owner's devices, in the
//! order in which the devices are written.

use linewright_text::{Located, LocatedName, NameTable, Problem, Report, tag};

use super::draft::{DraftDevice, Wiring};
use super::names::LineNames;
use super::raw::{RawDevice, RawLine};
use super::{analogue, drive, frames};
use crate::{DeviceBus, IMAGE_BITS, InputId, OutputId, Owner, StationId};

/// One owner's image while it is being put together.
#[derive(Default)]
pub(super) struct Wires<'a> {
    pub inputs: NameTable<'a>,
    pub outputs: NameTable<'a>,
    pub wiring: Wiring,
}

/// All owners' images.
pub(super) struct OwnedImages<'a> {
    pub stations: Vec<Wires<'a>>,
    pub console: Wires<'a>,
    pub raw: &'a RawLine,
}

impl OwnedImages<'_> {
    /// Whether a device names this station as its owner.
    pub fn has_device(&self, station: &LocatedName, stations: &NameTable<'_>) -> bool {
        let own = stations.get(&station.value);
        let owner = |device: &RawDevice| device.station.as_ref().and_then(|owner| stations.meant(&owner.value));
        self.raw.devices.iter().any(|device| owner(device).is_some_and(|owner| Some(owner) == own))
    }

    /// Some owner of a device with a signal of this name, for a hint.
    pub fn elsewhere(&self, name: &str) -> Option<String> {
        let device = self.raw.devices.iter().find(|device| signals(device).any(|signal| signal.value == name))?;
        match (&device.station, &device.console) {
            (Some(station), _) => Some(format!("station `{}`", station.value)),
            (None, Some(_)) => Some("the console".to_owned()),
            (None, None) => None,
        }
    }
}

/// Whether a device whose owner is unknown carries a signal of this name: what the signal is used for does not report it once more.
pub(super) fn is_on_unowned(raw: &RawLine, names: &LineNames<'_>, name: &str) -> bool {
    let is_unowned = |device: &&RawDevice| match (&device.station, &device.console) {
        (Some(station), console) => {
            names.stations.meant(&station.value).is_none() || console.as_ref().is_some_and(|console| console.value)
        }
        (None, console) => !console.as_ref().is_some_and(|console| console.value),
    };
    raw.devices.iter().filter(is_unowned).any(|device| signals(device).any(|signal| signal.value == name))
}

/// Every signal that a device carries, as it is written.
pub(super) fn signals(device: &RawDevice) -> impl Iterator<Item = &LocatedName> + Clone {
    let drive = device.drive.iter().flat_map(drive::signals);
    let frames = device.frames.iter().flat_map(frames::signals);
    device.inputs.iter().chain(&device.outputs).chain(drive).chain(frames).chain(analogue::signals(&device.analogue))
}

/// Puts all images together.
pub(super) fn wire<'a>(
    raw: &'a RawLine,
    names: &LineNames<'a>,
    buses: &[DeviceBus],
    report: &mut Report,
) -> (Vec<DraftDevice>, OwnedImages<'a>) {
    let stations = raw.stations.iter().map(|_| Wires::default()).collect();
    let mut owned = OwnedImages { stations, console: Wires::default(), raw };
    let mut nobody = Wires::default();
    let mut devices = Vec::new();
    for device in &raw.devices {
        let owner = owner(device, names, report);
        let (wires, bus) = match owner {
            Some(Owner::Station(id)) => (&mut owned.stations[id.index()], buses[id.index()].clone()),
            Some(Owner::Console) => (&mut owned.console, DeviceBus::Line),
            None => (&mut nobody, DeviceBus::Line),
        };
        let (inputs, outputs) = (inputs(device, wires, report), outputs(device, wires, report));
        let axes = match owner {
            Some(Owner::Station(id)) => Some(&names.inside[id.index()].axes),
            _ => None,
        };
        let drive = device.drive.as_ref().map(|drive| drive::wire(drive, axes, wires, report));
        let frames = device.frames.as_ref().map(|frames| frames::wire(frames, wires, report));
        let analogue = analogue::wire(&device.analogue, wires, report);
        devices.push(DraftDevice { owner, bus, inputs, outputs, drive, analogue, frames });
        if owner.is_none() {
            nobody = Wires::default();
        }
    }
    (devices, owned)
}

/// Owner of a device: a station or the console, and one of them.
fn owner(device: &RawDevice, names: &LineNames<'_>, report: &mut Report) -> Option<Owner> {
    let is_console = device.console.as_ref().filter(|c| c.value);
    match (&device.station, is_console) {
        (Some(station), None) => {
            names.stations.find(station, "station", report).map(|id| Owner::Station(StationId::at(id)))
        }
        (None, Some(_)) => Some(Owner::Console),
        (Some(station), Some(console)) => {
            report.add(
                Problem::error(console.at.clone(), "a device is a station's or the console's, not both")
                    .also(&station.at, "the other owner"),
            );
            None
        }
        (None, None) => {
            report.add(
                Problem::error(device.at.clone(), "this device belongs to nobody")
                    .hint("say `station = \"…\"` or `console = true`"),
            );
            None
        }
    }
}

fn inputs<'a>(device: &'a RawDevice, wires: &mut Wires<'a>, report: &mut Report) -> Vec<Option<InputId>> {
    let Wires { inputs, outputs, wiring } = wires;
    bits(&device.inputs, "input", inputs, outputs, &mut wiring.inputs, report, InputId::at)
}

fn outputs<'a>(device: &'a RawDevice, wires: &mut Wires<'a>, report: &mut Report) -> Vec<Option<OutputId>> {
    let Wires { inputs, outputs, wiring } = wires;
    bits(&device.outputs, "output", outputs, inputs, &mut wiring.outputs, report, OutputId::at)
}

fn bits<'a, Id>(
    bits: &'a [LocatedName],
    what: &str,
    table: &mut NameTable<'a>,
    others: &NameTable<'a>,
    image: &mut Vec<Located<String>>,
    report: &mut Report,
    id: impl Fn(usize) -> Id,
) -> Vec<Option<Id>> {
    let mut bound = Vec::with_capacity(bits.len());
    for bit in bits {
        bound.push(if bit.value.is_empty() { None } else { one_bit(bit, what, table, others, image, report).map(&id) });
    }
    bound
}

/// Binds one input that is named by itself, and not in a list.
pub(super) fn one_input<'a>(bit: &'a LocatedName, wires: &mut Wires<'a>, report: &mut Report) -> Option<InputId> {
    let Wires { inputs, outputs, wiring } = wires;
    one_bit(bit, "input", inputs, outputs, &mut wiring.inputs, report).map(InputId::at)
}

/// Binds one output that is named by itself, and not in a list.
pub(super) fn one_output<'a>(bit: &'a LocatedName, wires: &mut Wires<'a>, report: &mut Report) -> Option<OutputId> {
    let Wires { inputs, outputs, wiring } = wires;
    one_bit(bit, "output", outputs, inputs, &mut wiring.outputs, report).map(OutputId::at)
}

/// Binds one bit, or reports why it cannot be bound.
fn one_bit<'a>(
    bit: &'a LocatedName,
    what: &str,
    table: &mut NameTable<'a>,
    others: &NameTable<'a>,
    image: &mut Vec<Located<String>>,
    report: &mut Report,
) -> Option<usize> {
    table.note(bit, tag(bit, what, report));
    if let Some(other) = others.place(&bit.value) {
        report.add(
            Problem::error(bit.at.clone(), format!("`{}` names an input and an output", bit.value))
                .label(format!("as an {what}"))
                .also(other, "and here the other way"),
        );
        return None;
    }
    let next = image.len();
    if let Some(earlier) = table.define(bit, next) {
        report.add(
            Problem::error(bit.at.clone(), format!("`{}` is bound to two bits", bit.value))
                .label("again")
                .also(earlier, "first here")
                .hint("give each bit a name of its own; an unused bit is \"\""),
        );
        return None;
    }
    if next == IMAGE_BITS {
        report.add(
            Problem::error(bit.at.clone(), format!("more than {IMAGE_BITS} {what}s in one process image"))
                .label("one too many")
                .hint("divide the station in two, or leave unused bits \"\""),
        );
    }
    image.push(Located::new(bit.value.clone(), bit.at.clone()));
    Some(next)
}
