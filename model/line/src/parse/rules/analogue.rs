//! Analogue channels.

use std::collections::HashMap;

use linewright_text::{Located, NameTable, Problem, Report, TextRange, or, suggestion};

use crate::parse::analogue::{channel, number, when};
use crate::parse::draft::{DraftDevice, DraftLine, Wiring};
use crate::parse::raw::{RawAnalogueInput, RawAnalogueOutput, RawChannel, RawDevice, RawLag};
use crate::parse::setup::object;
use crate::{AnalogueChannel, CHANNELS_MAX};

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let (inputs, outputs) = (&raw.analogue.inputs, &raw.analogue.outputs);
        let channels = || inputs.iter().map(|input| &input.channel).chain(outputs.iter().map(|output| &output.channel));
        let Some(first) = channels().next() else { continue };
        only_io_has_channels(raw, first, report);
        objects_are_not_the_managers(raw, report);
        for channel in channels() {
            numbers_mean_something(channel, report);
        }
        channels_are_there_once(inputs.iter().map(|input| &input.channel), "input", report);
        channels_are_there_once(outputs.iter().map(|output| &output.channel), "output", report);
        for input in inputs {
            range_is_one(input, report);
            limits_are_one_each(input, report);
            limits_can_be_reached(input, report);
            if let Some(lag) = &input.simulated {
                simulated_value_follows_something(lag, raw, owner(draft, device), report);
            }
        }
        for output in outputs {
            values_fit(output, report);
        }
    }
}

fn owner<'a>(draft: &'a DraftLine<'_>, device: &DraftDevice) -> Option<&'a Wiring> {
    device.owner.map(|owner| draft.image(owner))
}

fn only_io_has_channels(device: &RawDevice, first: &RawChannel, report: &mut Report) {
    let other = match (&device.drive, &device.frames, &device.modbus) {
        (Some(drive), ..) => ("`drive`", &drive.at),
        (None, Some(frames), _) => ("`dbc`", &frames.at),
        (None, None, Some(modbus)) => ("`modbus`", &modbus.at),
        (None, None, None) => return,
    };
    report.add(
        Problem::error(first.at.clone(), format!("a device with a {} table has no analogue channels", other.0))
            .also(other.1, "all its signals are here"),
    );
}

/// Objects for the transmission of channels and their rest without a manager follow from the rest of the description.
fn objects_are_not_the_managers(device: &RawDevice, report: &mut Report) {
    for name in device.settings.iter().filter_map(|setting| setting.object.as_ref()) {
        let what = match object(&name.value) {
            Some((0x6423, _)) => "that inputs are sent by themselves",
            Some((0x6443, _)) => "that outputs rest when the manager is gone",
            Some((0x1801..=0x1803 | 0x1401..=0x1403, _)) => "how channels are sent",
            _ => continue,
        };
        report.add(
            Problem::error(name.at.clone(), "an object that the manager writes for analogue channels").label(what),
        );
    }
}

fn numbers_mean_something(raw: &RawChannel, report: &mut Report) {
    if let Some(own) = raw.number.as_ref().filter(|own| number(own.value).is_none()) {
        report.add(Problem::error(own.at.clone(), format!("there is no channel {}", own.value)).hint(format!(
            "1 to {CHANNELS_MAX}: the second to fourth process data objects of CiA 401 carry four channels each"
        )));
    }
    if let Some(factor) = raw.factor.as_ref().filter(|factor| factor.value == 0.0) {
        report.add(
            Problem::error(factor.at.clone(), "a factor of zero")
                .hint("what one step of the channel's number is worth"),
        );
    }
}

fn channels_are_there_once<'a>(channels: impl Iterator<Item = &'a RawChannel>, what: &str, report: &mut Report) {
    let mut seen: HashMap<i64, &TextRange> = HashMap::new();
    for own in channels.filter_map(|channel| channel.number.as_ref()) {
        if let Some(earlier) = seen.insert(own.value, &own.at) {
            report.add(
                Problem::error(own.at.clone(), format!("analogue {what} {} twice", own.value))
                    .label("again")
                    .also(earlier, "first here")
                    .hint("all that follows from a channel stands in one entry"),
            );
        }
    }
}

fn range_is_one(input: &RawAnalogueInput, report: &mut Report) {
    if let (Some(least), Some(most)) = (&input.least, &input.most)
        && least.value >= most.value
    {
        report.add(
            Problem::error(most.at.clone(), format!("no value is from {} to {}", least.value, most.value))
                .also(&least.at, "the least"),
        );
    }
    if input.inputs.is_empty() && input.broken.is_none() {
        report.add(
            Problem::warning(input.channel.at.clone(), "nothing follows from this analogue input")
                .hint("name what it turns on in `inputs`: { input = \"…\", above = … }"),
        );
    }
}

fn limits_are_one_each(input: &RawAnalogueInput, report: &mut Report) {
    for limit in &input.inputs {
        if when(limit).is_none() {
            let fault = if limit.above.is_some() { "on above one limit and below another" } else { "without a limit" };
            report
                .add(Problem::error(limit.at.clone(), format!("an input {fault}")).hint("one of `above` and `below`"));
        }
        if let Some(hysteresis) = limit.hysteresis.as_ref().filter(|own| own.value < 0.0) {
            report.add(Problem::error(hysteresis.at.clone(), "a hysteresis below zero"));
        }
    }
}

/// Each input must be able to go on, and off again.
fn limits_can_be_reached(input: &RawAnalogueInput, report: &mut Report) {
    let Some(channel) = channel(&input.channel) else { return };
    let (least, most) = measured(&channel, input);
    if least >= most {
        return;
    }
    for limit in &input.inputs {
        let (Some(when), Some(at)) = (when(limit), limit.above.as_ref().or(limit.below.as_ref())) else { continue };
        let Some(fault) = when.out_of_reach(least, most) else { continue };
        let range = format!("{} to {} can be measured", channel.text(least), channel.text(most));
        report.add(Problem::error(at.at.clone(), format!("a limit that {fault}")).hint(range));
    }
}

/// The least and the greatest value that counts as measured.
fn measured(channel: &AnalogueChannel, input: &RawAnalogueInput) -> (f64, f64) {
    let ends = [channel.value_of(i16::MIN + 1), channel.value_of(i16::MAX - 1)];
    let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    (or(&input.least, least).max(least), or(&input.most, most).min(most))
}

fn simulated_value_follows_something(lag: &RawLag, device: &RawDevice, image: Option<&Wiring>, report: &mut Report) {
    let hint = "`output`, with its `on` and `off`, or `channel`, an analogue output of this device";
    match (&lag.output, &lag.channel) {
        (Some(_), Some(channel)) => {
            report.add(Problem::error(channel.at.clone(), "a value that follows two things").hint(hint));
        }
        (None, None) => report.add(Problem::error(lag.at.clone(), "a value that follows nothing").hint(hint)),
        (Some(output), None) => {
            let names = image.map(|image| NameTable::of_tags(&image.outputs));
            if let Some(names) = names.filter(|names| names.meant(&output.value).is_none()) {
                let problem = Problem::error(output.at.clone(), format!("no output `{}` here", output.value));
                report.add(problem.maybe_hint(suggestion(&output.value, names.names())));
            }
            if lag.on.is_none() {
                let problem = Problem::error(lag.at.clone(), "a simulated value that goes nowhere");
                report.add(problem.hint("`on`: the value while the output is on"));
            }
        }
        (None, Some(channel)) => {
            let own = |output: &RawAnalogueOutput| output.channel.number.as_ref().map(|own| own.value);
            if !device.analogue.outputs.iter().any(|output| own(output) == Some(channel.value)) {
                let problem = format!("this device has no analogue output {}", channel.value);
                report.add(Problem::error(channel.at.clone(), problem).hint(hint));
            }
        }
    }
}

fn values_fit(output: &RawAnalogueOutput, report: &mut Report) {
    let Some(channel) = channel(&output.channel) else { return };
    let fits = |value: &Located<f64>, report: &mut Report| {
        if channel.number_of(value.value).is_none() {
            let ends = [channel.value_of(i16::MIN), channel.value_of(i16::MAX)];
            let (least, most) = (channel.text(ends[0].min(ends[1])), channel.text(ends[0].max(ends[1])));
            report.add(
                Problem::error(value.at.clone(), format!("{} is beyond what the channel can be set to", value.value))
                    .hint(format!("{least} to {most}")),
            );
        }
    };
    if let Some(rest) = &output.rest {
        fits(rest, report);
    }
    for level in &output.outputs {
        let (Some(value), Some(name)) = (&level.value, &level.output) else { continue };
        fits(value, report);
        if let Some(rest) =
            output.rest.as_ref().filter(|rest| channel.number_of(rest.value) == channel.number_of(value.value))
        {
            report.add(
                Problem::error(value.at.clone(), format!("`{}` changes nothing", name.value))
                    .label("the same number")
                    .also(&rest.at, "as at rest"),
            );
        }
    }
}
