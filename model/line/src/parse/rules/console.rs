//! The main console and its hand-mode buttons.

use linewright_text::{Problem, Report};

use super::signals::{SignalUse, Uses};
use crate::ButtonId;
use crate::Owner;
use crate::parse::draft::DraftLine;

const INPUT_KEYS: [&str; 6] = ["start", "stop", "auto", "hand", "estop", "reset"];
const LAMP_KEYS: [&str; 4] = ["auto", "hand", "manual", "fault"];

pub(super) fn console_exists(draft: &DraftLine<'_>, report: &mut Report) {
    let has_device = draft.devices.iter().any(|device| device.owner == Some(Owner::Console));
    if draft.raw.console.is_none() {
        report.add(
            Problem::warning(0..0, "the line has no `[console]`")
                .hint("without one, only ROS topics can start it, stop it and change its mode"),
        );
    } else if let Some(console) = &draft.raw.console
        && console.estop.input.is_none()
    {
        report.add(
            Problem::warning(console.at.clone(), "the console has no `estop`")
                .hint("the emergency stop can then be given over ROS topics only"),
        );
    }
    if !has_device {
        return;
    }
    for (button, input) in draft.raw.buttons.iter().zip(&draft.console.buttons) {
        if input.is_none() {
            report.add(
                Problem::warning(button.at.clone(), format!("no console device has an input `{}`", button.value))
                    .hint("the button then exists on ROS topics only"),
            );
        }
    }
}

pub(super) fn buttons_are_used(draft: &DraftLine<'_>, report: &mut Report) {
    let mut used = vec![false; draft.raw.buttons.len()];
    for operation in draft.stations.iter().flat_map(|s| &s.operations) {
        let Some(raw) = &operation.raw.hand else { continue };
        for name in [&raw.forward, &raw.back, &raw.next].into_iter().flatten() {
            if let Some(button) = draft.names.buttons.meant(&name.value).map(ButtonId::at) {
                used[button.index()] = true;
            }
        }
    }
    // What is unused is known only where every use is understood.
    let is_understood = !report.has_unknown();
    for (button, _) in draft.raw.buttons.iter().zip(used).filter(|(_, used)| !used && is_understood) {
        report.add(
            Problem::warning(button.at.clone(), format!("no operation uses button `{}`", button.value))
                .hint("remove it from `buttons` until one does"),
        );
    }
}

pub(super) fn signals_mean_one_thing(draft: &DraftLine<'_>, report: &mut Report) {
    let console = &draft.console;
    let mut inputs = Uses::of(&console.wiring.inputs);
    for (button, input) in draft.raw.buttons.iter().zip(&console.buttons) {
        if let Some(input) = input {
            inputs.note(input.index(), SignalUse::Control(button.value.clone()), &button.at);
        }
    }
    for (input, key) in console.inputs.iter().zip(INPUT_KEYS) {
        if let Some(input) = input {
            inputs.note(input.value.index(), SignalUse::Control(key.to_owned()), &input.at);
        }
    }
    inputs.report(report);

    let mut outputs = Uses::of(&console.wiring.outputs);
    for (output, key) in console.lamps.iter().zip(LAMP_KEYS) {
        if let Some(output) = output {
            outputs.note(output.value.index(), SignalUse::ModeLamp(key), &output.at);
        }
    }
    outputs.report(report);
}
