//! The `dbc` table of a device.

use linewright_text::{Fields, Name, Report};

use super::SIGNALS_MAX;
use super::line::each;
use crate::Checksum;
use crate::parse::raw::{RawFrames, RawHeard, RawSet, RawSignalInput, RawSignalOutput, RawTold};

pub(super) fn frames(mut f: Fields<'_>, report: &mut Report) -> RawFrames {
    let raw = RawFrames {
        at: f.at.clone(),
        file: f.required_text(report, "file"),
        receive: each(f.tables(report, "receive", "a message received", SIGNALS_MAX), report, heard),
        send: each(f.tables(report, "send", "a message sent", SIGNALS_MAX), report, told),
    };
    f.finish(report);
    raw
}

fn heard(mut f: Fields<'_>, report: &mut Report) -> RawHeard {
    let raw = RawHeard {
        message: f.required_text(report, "message"),
        timeout: f.required_millis(report, "timeout_ms"),
        counter: f.text(report, "counter"),
        checksum: checksum(&mut f, report),
        inputs: each(f.tables(report, "inputs", "an input", SIGNALS_MAX), report, input),
    };
    f.finish(report);
    raw
}

fn told(mut f: Fields<'_>, report: &mut Report) -> RawTold {
    let raw = RawTold {
        at: f.at.clone(),
        message: f.required_text(report, "message"),
        every: f.required_millis(report, "every_ms"),
        lets_go_after: f.millis(report, "lets_go_after_ms"),
        counter: f.text(report, "counter"),
        checksum: checksum(&mut f, report),
        outputs: each(f.tables(report, "outputs", "an output", SIGNALS_MAX), report, output),
        set: each(f.tables(report, "set", "a value", SIGNALS_MAX), report, set),
    };
    f.finish(report);
    raw
}

fn checksum(f: &mut Fields<'_>, report: &mut Report) -> Option<(Name, Checksum)> {
    let mut f = f.table(report, "checksum", "`checksum`")?;
    let signal = f.required_text(report, "signal");
    let kinds = [("xor", Checksum::Xor), ("sum", Checksum::Sum), ("crc8", Checksum::Crc8)];
    let kind = f.word(report, "kind", &kinds);
    f.finish(report);
    Some((signal?, kind))
}

fn input(mut f: Fields<'_>, report: &mut Report) -> RawSignalInput {
    let raw = RawSignalInput {
        at: f.at.clone(),
        input: f.required_text(report, "input"),
        signal: f.required_text(report, "signal"),
        equals: f.number(report, "equals"),
        above: f.number(report, "above"),
        below: f.number(report, "below"),
        bit: f.integer(report, "bit"),
        hysteresis: f.number(report, "hysteresis"),
    };
    f.finish(report);
    raw
}

fn output(mut f: Fields<'_>, report: &mut Report) -> RawSignalOutput {
    let raw = RawSignalOutput {
        output: f.required_text(report, "output"),
        signal: f.required_text(report, "signal"),
        on: f.number(report, "on"),
        off: f.number(report, "off"),
    };
    f.finish(report);
    raw
}

fn set(mut f: Fields<'_>, report: &mut Report) -> RawSet {
    let raw = RawSet { signal: f.required_text(report, "signal"), value: f.required_number(report, "value") };
    f.finish(report);
    raw
}
