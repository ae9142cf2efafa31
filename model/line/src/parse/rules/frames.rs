//! Devices without CANopen.

use linewright_text::{Problem, Report, or};

use super::devices::{canopen_keys, settings_at};
use crate::parse::draft::DraftLine;
use crate::parse::frames::when;
use crate::parse::raw::{RawDevice, RawFrames, RawSignalInput, RawTold};

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for device in &draft.raw.devices {
        let Some(frames) = &device.frames else { continue };
        nothing_of_canopen_is_said(device, frames, report);
        somebody_is_heard(frames, report);
        for input in frames.receive.iter().flat_map(|heard| &heard.inputs) {
            conditions_are_one(input, report);
        }
        for told in &frames.send {
            outputs_have_two_values(told, report);
            outputs_go_off_by_themselves(told, report);
        }
    }
}

fn nothing_of_canopen_is_said(device: &RawDevice, frames: &RawFrames, report: &mut Report) {
    let bits = device.inputs.first().or(device.outputs.first()).map(|bit| &bit.at);
    let others = [("`inputs` and `outputs`", bits), ("`settings`", settings_at(device))];
    let others = others.into_iter().filter_map(|(what, at)| Some((what, at?)));
    for (what, at) in canopen_keys(device).chain(others) {
        report.add(
            Problem::error(at.clone(), format!("a device with a `dbc` table has no {what}"))
                .also(&frames.at, "it speaks no CANopen")
                .hint("all that is known of it is in its DBC file and its `dbc` table"),
        );
    }
}

fn somebody_is_heard(frames: &RawFrames, report: &mut Report) {
    if frames.receive.is_empty() && frames.send.is_empty() {
        report.add(
            Problem::error(frames.at.clone(), "this device neither sends nor receives anything")
                .hint("name its messages in `receive` and `send`"),
        );
    } else if frames.receive.is_empty() {
        report.add(
            Problem::warning(frames.at.clone(), "nothing is heard of this device")
                .label("nobody notices when it is gone")
                .hint("name a message that it sends in `receive`, if only for its timeout"),
        );
    }
}

fn conditions_are_one(input: &RawSignalInput, report: &mut Report) {
    if when(input).is_none() {
        let problem = match &input.bit {
            Some(bit) if !(0..64).contains(&bit.value) => {
                Problem::error(bit.at.clone(), format!("a signal has no bit {}", bit.value)).hint("0 to 63")
            }
            _ => Problem::error(input.at.clone(), "an input that is on for two reasons")
                .hint("one of `equals`, `above`, `below` and `bit`, or none: on while the signal is not zero"),
        };
        report.add(problem);
    }
    let Some(hysteresis) = &input.hysteresis else { return };
    if hysteresis.value < 0.0 {
        report.add(Problem::error(hysteresis.at.clone(), "a hysteresis below zero"));
    } else if input.above.is_none() && input.below.is_none() {
        report.add(
            Problem::error(hysteresis.at.clone(), "a hysteresis without a limit")
                .hint("it belongs to `above` or `below`"),
        );
    }
}

/// Such a device receives no heartbeat of the manager. Its outputs go off only by its own time-out, which is in its manual.
fn outputs_go_off_by_themselves(told: &RawTold, report: &mut Report) {
    let Some(output) = told.outputs.iter().find_map(|output| output.output.as_ref()) else { return };
    let Some(time) = &told.lets_go_after else {
        return report.add(
            Problem::warning(told.at.clone(), format!("`{}` has no time-out: it may stay on without a manager", output.value))
                .also(&output.at, "turned on by this message")
                .hint(
                    "write `lets_go_after_ms`, beside `every_ms`: after how long without this message the device turns its \
                     outputs off by itself, as its manual says or as it is set up; one that never does needs other means",
                ),
        );
    };
    if let Some(every) = told.every.as_ref().filter(|every| time.value <= every.value) {
        report.add(
            Problem::error(time.at.clone(), "this device lets go of its outputs before the next message comes")
                .also(&every.at, "it comes that often")
                .hint("two or three times `every_ms`: a frame may be late, or lost"),
        );
    }
}

fn outputs_have_two_values(told: &RawTold, report: &mut Report) {
    for output in &told.outputs {
        let (on, off) = (or(&output.on, 1.0), or(&output.off, 0.0));
        if on == off
            && let Some(name) = &output.output
        {
            report.add(
                Problem::error(name.at.clone(), format!("`{}` is {on} when on, and when off", name.value))
                    .hint("two values, or `set` for a signal that never changes"),
            );
        }
    }
}
