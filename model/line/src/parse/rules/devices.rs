//! Devices on their buses.

use std::collections::HashMap;

use linewright_text::{NameTable, Problem, Report, TextRange, suggestion};

use crate::DeviceBus;
use crate::parse::draft::DraftLine;
use crate::parse::raw::RawDevice;
use crate::parse::wiring;

/// CANopen node ids are 1 to 127 (CiA 301); the highest is the bus manager's own, which by convention it is.
const NODE_MAX: i64 = 126;
const MANAGER: i64 = 127;

/// A device's node id, where it is usable.
pub(in crate::parse) fn node_id(value: i64) -> Option<u8> {
    u8::try_from(value).ok().filter(|_| (1..=NODE_MAX).contains(&value))
}

/// Where a device has the keys of CANopen that devices of other kinds have not.
pub(super) fn canopen_keys(device: &RawDevice) -> impl Iterator<Item = (&'static str, &TextRange)> {
    let identity = device.identity.as_ref().and_then(|identity| identity.parts().into_iter().flatten().next());
    let keys = [
        ("`node`", device.node.as_ref().map(|node| &node.at)),
        ("`identity`", identity.map(|part| &part.at)),
        ("`file`", device.file.as_ref().map(|file| &file.at)),
        ("`transmission`", device.transmission.as_ref().map(|transmission| &transmission.at)),
        ("`without_error_values`", device.without_error_values.as_ref().map(|why| &why.at)),
        ("`on_emergency`", device.on_emergency.as_ref().map(|key| &key.at)),
        ("`when_lost`", device.when_lost.as_ref().map(|key| &key.at)),
        ("`drive`", device.drive.as_ref().map(|drive| &drive.at)),
    ];
    keys.into_iter().filter_map(|(what, at)| Some((what, at?)))
}

/// Where its settings begin.
pub(super) fn settings_at(device: &RawDevice) -> Option<&TextRange> {
    device.settings.first().and_then(|setting| setting.object.as_ref()).map(|object| &object.at)
}

pub(super) fn node_ids_are_usable(draft: &DraftLine<'_>, report: &mut Report) {
    for node in draft.raw.devices.iter().filter_map(|device| device.node.as_ref()) {
        if node_id(node.value).is_some() {
            continue;
        }
        let problem = if node.value == MANAGER {
            Problem::error(node.at.clone(), format!("node id {MANAGER:02X}h is the bus manager's own"))
                .label("reserved")
        } else {
            Problem::error(node.at.clone(), format!("{} is not a node id", node.value))
        };
        report.add(problem.hint(format!("devices have node ids from 1 to {NODE_MAX}")));
    }
}

pub(super) fn node_ids_are_unique_on_a_bus(draft: &DraftLine<'_>, report: &mut Report) {
    let mut seen = HashMap::new();
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let Some(node) = raw.node.as_ref().filter(|_| device.owner.is_some()) else { continue };
        if let Some(earlier) = seen.insert((&device.bus, node.value), &node.at) {
            report.add(
                Problem::error(
                    node.at.clone(),
                    format!("two devices with node id {:02X}h on {}", node.value, device.bus),
                )
                .label("again")
                .also(earlier, "first here")
                .hint("a node id is unique on its bus"),
            );
        }
    }
}

pub(super) fn devices_carry_something(draft: &DraftLine<'_>, report: &mut Report) {
    for device in draft.raw.devices.iter().filter(|device| device.drive.is_none() && device.frames.is_none()) {
        let channels = device.analogue.inputs.len() + device.analogue.outputs.len();
        if channels == 0 && device.inputs.iter().chain(&device.outputs).all(|bit| bit.value.is_empty()) {
            let at = device.name.as_ref().map_or(&device.at, |name| &name.at);
            report.add(
                Problem::warning(at.clone(), "this device has no connected input or output")
                    .hint("name its bits in `inputs` and `outputs`"),
            );
        }
    }
}

pub(super) fn comments_are_of_signals(draft: &DraftLine<'_>, report: &mut Report) {
    for device in &draft.raw.devices {
        let signals = NameTable::of_tags(wiring::signals(device).filter(|signal| !signal.value.is_empty()));
        for (name, _) in device.comments.iter().filter(|(name, _)| signals.meant(&name.value).is_none()) {
            report.add(
                Problem::error(
                    name.at.clone(),
                    format!("a comment on `{}`, which is no signal of this device", name.value),
                )
                .maybe_hint(suggestion(&name.value, signals.names())),
            );
        }
    }
}

pub(super) fn own_buses_are_not_shared(draft: &DraftLine<'_>, report: &mut Report) {
    let mut seen = HashMap::new();
    for station in &draft.stations {
        let (DeviceBus::Own(name), Some(raw)) = (&station.bus, &station.raw.bus) else { continue };
        if let Some((other, earlier)) = seen.insert(name, (station.name, &raw.at)) {
            report.add(
                Problem::warning(
                    raw.at.clone(),
                    format!("stations `{other}` and `{}` both have bus `{name}`", station.name),
                )
                .also(earlier, "first here")
                .hint("a station is the manager of its own bus: this is right only on two computers"),
            );
        }
    }
}
