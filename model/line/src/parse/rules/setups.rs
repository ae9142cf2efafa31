//! Identity and settings of a device, and permitted effects of its trouble.

use std::collections::HashMap;

use linewright_text::{Problem, Report, TextRange};

use crate::parse::analogue;
use crate::parse::draft::{DraftDevice, DraftLine, DraftStation};
use crate::parse::raw::{RawDevice, RawSetting};
use crate::parse::setup::{object, part, setting};
use crate::{InputId, OutputId, Owner, Reaction, is_the_managers, keeps_an_output};

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for device in &draft.raw.devices {
        identity_has_numbers(device, report);
        for setting in &device.settings {
            object_is_one(setting, report);
            object_is_not_the_managers(setting, report);
            value_fits(setting, report);
        }
        objects_are_set_once(device, report);
    }
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        nothing_depends_on_what_may_be_lost(draft, device, raw, report);
        outputs_go_off_without_a_manager(device, raw, report);
    }
}

/// A device that may be lost without a fault must carry nothing that a motion, a panel or the console is decided by.
fn nothing_depends_on_what_may_be_lost(
    draft: &DraftLine<'_>,
    device: &DraftDevice,
    raw: &RawDevice,
    report: &mut Report,
) {
    let Some(when_lost) = raw.when_lost.as_ref().filter(|key| key.value == Reaction::Report) else { return };
    let problem = |at: &TextRange, what: &str, label: &str| {
        Problem::error(when_lost.at.clone(), format!("this device cannot be lost without a fault: {what}"))
            .also(at, label.to_owned())
            .hint("write `when_lost = \"fault\"`, or leave it out")
    };
    if device.drive.is_some() {
        return report.add(problem(&raw.at, "it is a drive", "which moves an axis"));
    }
    let (inputs, outputs) = match device.owner {
        Some(Owner::Station(id)) => depended_on(&draft.stations[id.index()]),
        Some(Owner::Console) => {
            let keys = draft.console.inputs.iter().flatten().map(|input| input.value);
            (keys.chain(draft.console.buttons.iter().copied().flatten()).collect(), Vec::new())
        }
        None => return,
    };
    let (own, channels) = (&device.analogue, &raw.analogue);
    let mut input = raw.inputs.iter().zip(&device.inputs).chain(analogue::named_inputs(channels, own));
    let mut output = raw.outputs.iter().zip(&device.outputs).chain(analogue::named_outputs(channels, own));
    let input = input.find(|(_, id)| id.is_some_and(|id| inputs.contains(&id)));
    let output = output.find(|(_, id)| id.is_some_and(|id| outputs.contains(&id)));
    if let Some((name, _)) = input {
        report.add(problem(&name.at, &format!("`{}` is one of its inputs", name.value), "something is decided by it"));
    } else if let Some((name, _)) = output {
        report.add(problem(&name.at, &format!("`{}` is one of its outputs", name.value), "it drives a motion"));
    }
}

/// The manager writes the objects for a device's outputs when the manager is gone. A description with others, or a device
/// without these objects, needs a reason.
fn outputs_go_off_without_a_manager(device: &DraftDevice, raw: &RawDevice, report: &mut Report) {
    if let Some(why) = &raw.without_error_values {
        let sets = raw.outputs.iter().any(|name| !name.value.is_empty()) || !raw.analogue.outputs.is_empty();
        if why.value.trim().is_empty() {
            report.add(
                Problem::error(why.at.clone(), "no reason is given").hint(
                    "say what lets its outputs go when the manager is gone, such as a safety relay in their supply",
                ),
            );
        } else if raw.drive.is_some() || raw.frames.is_none() && !sets {
            report.add(
                Problem::error(why.at.clone(), "this device has no error values to be without")
                    .hint("`without_error_values` is for devices with `outputs` or `analogue_outputs`"),
            );
        }
        return;
    }
    let keeps = raw
        .settings
        .iter()
        .filter(|raw| setting(raw).is_some_and(|setting| keeps_an_output(&device.outputs, &setting)));
    for (name, raw) in keeps.filter_map(|raw| Some((raw.object.as_ref()?, raw))) {
        let value = raw.value.as_ref().map_or(&name.at, |value| &value.at);
        report.add(
            Problem::error(value.clone(), "an output of this device stays on when the manager is gone")
                .also(&name.at, "by this object")
                .hint("leave it out, or say in `without_error_values` why that is safe"),
        );
    }
}

/// The inputs by which a station decides, and the outputs that move something. Lamps are neither.
fn depended_on(station: &DraftStation<'_>) -> (Vec<InputId>, Vec<OutputId>) {
    let signals = || station.operations.iter().flat_map(|operation| operation.motions()).map(|(signals, _)| signals);
    let ends = signals().flat_map(|s| s.complete.iter().chain(&s.fault)).map(|input| input.value);
    let panel = station.panel.iter().flatten().map(|input| input.value);
    (ends.chain(panel).collect(), signals().filter_map(|s| s.actuator.as_ref()).map(|output| output.value).collect())
}

fn identity_has_numbers(device: &RawDevice, report: &mut Report) {
    let Some(identity) = &device.identity else { return };
    for number in identity.parts().into_iter().flatten().filter(|number| part(number.value).is_none()) {
        report.add(
            Problem::error(number.at.clone(), format!("{} is no part of an identity", number.value))
                .hint("objects 1000h and 1018h hold numbers from 0 to 0xFFFFFFFF"),
        );
    }
}

fn object_is_one(setting: &RawSetting, report: &mut Report) {
    let Some(name) = &setting.object else { return };
    if object(&name.value).is_none() {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` is no object", name.value))
                .hint("write index and subindex in hexadecimal, such as \"6206:01\""),
        );
    }
}

/// Supervision between devices and manager follows from the description's timing. A device with other settings might
/// keep its outputs when the manager is gone.
fn object_is_not_the_managers(setting: &RawSetting, report: &mut Report) {
    let Some(name) = &setting.object else { return };
    let Some((index, _)) = object(&name.value).filter(|(index, _)| is_the_managers(*index)) else { return };
    let (what, key) = if index == 0x1016 {
        ("how long the device waits for the manager", "heartbeat_timeout_ms")
    } else {
        ("how often the device sends its heartbeat", "heartbeat_ms")
    };
    report.add(
        Problem::error(name.at.clone(), format!("object {index:04X}h is written by the manager itself"))
            .label(what)
            .hint(format!("it follows from `{key}` in [timing]")),
    );
}

fn value_fits(setting: &RawSetting, report: &mut Report) {
    let Some(value) = &setting.value else { return };
    if setting.width.bytes_of(value.value).is_none() {
        let (least, most) = setting.width.limits();
        report.add(
            Problem::error(value.at.clone(), format!("{} does not fit its type", value.value))
                .hint(format!("{least} to {most} do")),
        );
    }
}

fn objects_are_set_once(device: &RawDevice, report: &mut Report) {
    let mut seen = HashMap::new();
    for name in device.settings.iter().filter_map(|setting| setting.object.as_ref()) {
        let Some(object) = object(&name.value) else { continue };
        if let Some(earlier) = seen.insert(object, &name.at) {
            report.add(
                Problem::warning(
                    name.at.clone(),
                    format!("object {:04X}h:{:02X} is written twice", object.0, object.1),
                )
                .also(earlier, "first here")
                .hint("both are sent, in this order; the last one stays"),
            );
        }
    }
}
