//! The `analogue_inputs` and `analogue_outputs` of a device.

use linewright_text::{Fields, Report};

use super::LIMITS_MAX;
use super::line::each;
use crate::CHANNELS_MAX;
use crate::parse::raw::{RawAnalogue, RawAnalogueInput, RawAnalogueOutput, RawChannel, RawLag, RawLevel, RawLimit};

pub(super) fn channels(f: &mut Fields<'_>, report: &mut Report) -> RawAnalogue {
    let most = usize::from(CHANNELS_MAX);
    RawAnalogue {
        inputs: each(f.tables(report, "analogue_inputs", "an analogue input", most), report, input),
        outputs: each(f.tables(report, "analogue_outputs", "an analogue output", most), report, output),
    }
}

fn channel(f: &mut Fields<'_>, report: &mut Report) -> RawChannel {
    RawChannel {
        at: f.at.clone(),
        number: f.required_integer(report, "channel"),
        unit: f.text(report, "unit"),
        factor: f.number(report, "factor"),
        offset: f.number(report, "offset"),
    }
}

fn input(mut f: Fields<'_>, report: &mut Report) -> RawAnalogueInput {
    let raw = RawAnalogueInput {
        channel: channel(&mut f, report),
        least: f.number(report, "least"),
        most: f.number(report, "most"),
        inputs: each(f.tables(report, "inputs", "a limit", LIMITS_MAX), report, limit),
        broken: f.text(report, "broken"),
        simulated: f.table(report, "simulated", "`simulated`").map(|f| lag(f, report)),
    };
    f.finish(report);
    raw
}

fn limit(mut f: Fields<'_>, report: &mut Report) -> RawLimit {
    let raw = RawLimit {
        at: f.at.clone(),
        input: f.required_text(report, "input"),
        above: f.number(report, "above"),
        below: f.number(report, "below"),
        hysteresis: f.number(report, "hysteresis"),
    };
    f.finish(report);
    raw
}

fn lag(mut f: Fields<'_>, report: &mut Report) -> RawLag {
    let raw = RawLag {
        at: f.at.clone(),
        output: f.text(report, "output"),
        on: f.number(report, "on"),
        off: f.number(report, "off"),
        channel: f.integer(report, "channel"),
        lag: f.required_millis(report, "lag_ms"),
    };
    f.finish(report);
    raw
}

fn output(mut f: Fields<'_>, report: &mut Report) -> RawAnalogueOutput {
    let raw = RawAnalogueOutput {
        channel: channel(&mut f, report),
        rest: f.required_number(report, "rest"),
        outputs: each(f.tables(report, "outputs", "a value", LIMITS_MAX), report, level),
    };
    f.finish(report);
    raw
}

fn level(mut f: Fields<'_>, report: &mut Report) -> RawLevel {
    let raw = RawLevel { output: f.required_text(report, "output"), value: f.required_number(report, "value") };
    f.finish(report);
    raw
}
