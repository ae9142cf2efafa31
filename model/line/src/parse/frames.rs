//! A device's `dbc` table: its names → bits of its station's image, and at the end → [`FrameTable`].
//!
//! Names of messages and signals are those of the DBC file, which is read elsewhere: they are passed on with their
//! places.

use linewright_text::{LocatedName, Report, or};

use super::draft::DraftFrames;
use super::raw::{RawChecksum, RawFrames, RawHeard, RawSignalInput, RawTold};
use super::wiring::{Wires, one_input, one_output};
use crate::{Checksum, CyclicFrame, DbcName, FrameTable, ReceivedMessageTable, SignalInput, SignalOutput, When};

/// Every signal of its owner that a device's frames name.
pub(super) fn signals(raw: &RawFrames) -> impl Iterator<Item = &LocatedName> + Clone {
    let inputs = raw.receive.iter().flat_map(|heard| heard.inputs.iter().filter_map(|input| input.input.as_ref()));
    let outputs = raw.send.iter().flat_map(|told| told.outputs.iter().filter_map(|output| output.output.as_ref()));
    inputs.chain(outputs)
}

/// Binds them.
pub(super) fn wire<'a>(raw: &'a RawFrames, wires: &mut Wires<'a>, report: &mut Report) -> DraftFrames {
    let mut draft = DraftFrames::default();
    for heard in &raw.receive {
        let bound = heard.inputs.iter().map(|input| one_input(input.input.as_ref()?, wires, report));
        draft.inputs.push(bound.collect());
    }
    for told in &raw.send {
        let bound = told.outputs.iter().map(|output| one_output(output.output.as_ref()?, wires, report));
        draft.outputs.push(bound.collect());
    }
    draft
}

/// Condition of an input; `None` where that is not given well.
pub(super) fn when(raw: &RawSignalInput) -> Option<When> {
    let hysteresis = or(&raw.hysteresis, 0.0);
    Some(match (&raw.equals, &raw.above, &raw.below, &raw.bit) {
        (None, None, None, None) => When::NotZero,
        (Some(equals), None, None, None) => When::Equals(equals.value),
        (None, Some(at), None, None) => When::Above { at: at.value, hysteresis },
        (None, None, Some(at), None) => When::Below { at: at.value, hysteresis },
        (None, None, None, Some(bit)) => When::Bit(u8::try_from(bit.value).ok().filter(|bit| *bit < 64)?),
        _ => return None,
    })
}

/// The frames a draft describes; `None` if a part is missing.
pub(super) fn finish(draft: &DraftFrames, raw: &RawFrames) -> Option<FrameTable> {
    let receive = raw.receive.iter().zip(&draft.inputs).map(|(raw, bound)| receive(raw, bound));
    let send = raw.send.iter().zip(&draft.outputs).map(|(raw, bound)| send(raw, bound));
    Some(FrameTable {
        file: named(raw.file.as_ref()?),
        receive: receive.collect::<Option<_>>()?,
        send: send.collect::<Option<_>>()?,
        bound: None,
    })
}

fn receive(raw: &RawHeard, bound: &[Option<crate::InputId>]) -> Option<ReceivedMessageTable> {
    let inputs = raw.inputs.iter().zip(bound).map(|(raw, input)| {
        Some(SignalInput { input: (*input)?, signal: named(raw.signal.as_ref()?), when: when(raw)? })
    });
    Some(ReceivedMessageTable {
        message: named(raw.message.as_ref()?),
        timeout: raw.timeout.as_ref()?.value,
        counter: raw.counter.as_ref().map(named),
        checksum: raw.checksum.as_ref().and_then(checksum),
        inputs: inputs.collect::<Option<_>>()?,
    })
}

fn send(raw: &RawTold, bound: &[Option<crate::OutputId>]) -> Option<CyclicFrame> {
    let outputs = raw.outputs.iter().zip(bound).map(|(raw, output)| {
        let signal = named(raw.signal.as_ref()?);
        Some(SignalOutput { output: (*output)?, signal, on: or(&raw.on, 1.0), off: or(&raw.off, 0.0) })
    });
    let set = raw.set.iter().map(|set| Some((named(set.signal.as_ref()?), set.value.as_ref()?.value)));
    Some(CyclicFrame {
        message: named(raw.message.as_ref()?),
        every: raw.every.as_ref()?.value,
        lets_go_after: raw.lets_go_after.as_ref().map(|time| time.value),
        counter: raw.counter.as_ref().map(named),
        checksum: raw.checksum.as_ref().and_then(checksum),
        outputs: outputs.collect::<Option<_>>()?,
        set: set.collect::<Option<_>>()?,
    })
}

fn checksum(raw: &RawChecksum) -> Option<(DbcName, Checksum)> {
    Some((named(raw.signal.as_ref()?), raw.kind))
}

fn named(name: &LocatedName) -> DbcName {
    DbcName { name: name.value.clone(), at: name.at.clone() }
}
