//! Process data that wait for SYNC.

use linewright_text::{Located, Problem, Report};

use crate::device::is_synchronous;
use crate::parse::draft::DraftLine;
use crate::parse::raw::RawDevice;
use crate::parse::setup::transmission;

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for device in &draft.raw.devices {
        let Some(raw) = &device.transmission else { continue };
        for number in [&raw.inputs, &raw.outputs].into_iter().flatten() {
            check_type(number, draft, report);
        }
        if device.drive.is_some() {
            report.add(
                Problem::error(raw.at.clone(), "a drive's process data do not wait for SYNC")
                    .hint("leave `transmission` out: enabling a drive is a dialogue, and goes by event"),
            );
            continue;
        }
        outputs_have_inputs_to_show(device, report);
    }
}

fn check_type(number: &Located<i64>, draft: &DraftLine<'_>, report: &mut Report) {
    match transmission(number.value) {
        None => report.add(
            Problem::error(number.at.clone(), format!("{} is no transmission type", number.value))
                .hint("1 to 240: with every so many SYNCs; 254 or 255: at once"),
        ),
        Some(kind) if is_synchronous(kind) && draft.raw.timing.sync.is_none() => report.add(
            Problem::error(number.at.clone(), "process data with SYNC, but nobody sends it")
                .hint("say how often in [timing]: `sync_ms = 10`"),
        ),
        Some(_) => {}
    }
}

/// A device that no longer receives SYNC keeps its outputs, and receives every heartbeat: that it still receives SYNC
/// shows only by inputs that come with it.
fn outputs_have_inputs_to_show(device: &RawDevice, report: &mut Report) {
    let Some(raw) = &device.transmission else { return };
    let synchronous = |number: &Option<Located<i64>>| {
        number.as_ref().and_then(|number| transmission(number.value)).is_some_and(is_synchronous)
    };
    let Some(outputs) = raw.outputs.as_ref().filter(|_| synchronous(&raw.outputs)) else { return };
    if !synchronous(&raw.inputs) || device.inputs.is_empty() {
        report.add(
            Problem::error(outputs.at.clone(), "outputs that wait for SYNC, without inputs that come with it")
                .label("nobody would notice that the device hears no SYNC")
                .hint("`inputs` of a type from 1 to 240 as well, or outputs of type 255"),
        );
    }
}
