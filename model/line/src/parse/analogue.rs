//! A device's analogue channels: their names → bits of its owner's image, and at the end → [`Analogue`].
//!
//! A simulated channel follows an output that may be carried by a device further down: its name is looked up when all
//! images are complete.

use linewright_text::{LocatedName, Report, or};

use super::draft::{DraftAnalogue, Wiring};
use super::raw::{RawAnalogue, RawAnalogueInput, RawAnalogueOutput, RawChannel, RawLag, RawLimit};
use super::wiring::{Wires, one_input, one_output};
use crate::{
    Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, CHANNELS_MAX, Follows, InputId, Lag, OutputId, When,
};

/// Every signal of its owner that a device's channels carry.
pub(super) fn signals(raw: &RawAnalogue) -> impl Iterator<Item = &LocatedName> + Clone {
    let limits = raw.inputs.iter().flat_map(|input| input.inputs.iter().filter_map(|limit| limit.input.as_ref()));
    let broken = raw.inputs.iter().filter_map(|input| input.broken.as_ref());
    let levels = raw.outputs.iter().flat_map(|output| output.outputs.iter().filter_map(|level| level.output.as_ref()));
    limits.chain(broken).chain(levels)
}

/// The inputs among them, each with its bit.
pub(super) fn named_inputs<'a>(
    raw: &'a RawAnalogue,
    draft: &'a DraftAnalogue,
) -> impl Iterator<Item = (&'a LocatedName, &'a Option<InputId>)> {
    raw.inputs.iter().zip(&draft.inputs).flat_map(|(raw, (bound, broken))| {
        let limits = raw.inputs.iter().zip(bound).filter_map(|(limit, id)| Some((limit.input.as_ref()?, id)));
        limits.chain(raw.broken.iter().map(move |name| (name, broken)))
    })
}

/// The outputs among them, each with its bit.
pub(super) fn named_outputs<'a>(
    raw: &'a RawAnalogue,
    draft: &'a DraftAnalogue,
) -> impl Iterator<Item = (&'a LocatedName, &'a Option<OutputId>)> {
    raw.outputs.iter().zip(&draft.outputs).flat_map(|(raw, bound)| {
        raw.outputs.iter().zip(bound).filter_map(|(level, id)| Some((level.output.as_ref()?, id)))
    })
}

/// Binds them.
pub(super) fn wire<'a>(raw: &'a RawAnalogue, wires: &mut Wires<'a>, report: &mut Report) -> DraftAnalogue {
    let mut draft = DraftAnalogue::default();
    for input in &raw.inputs {
        let bound = input.inputs.iter().map(|limit| one_input(limit.input.as_ref()?, wires, report)).collect();
        let broken = input.broken.as_ref().and_then(|broken| one_input(broken, wires, report));
        draft.inputs.push((bound, broken));
    }
    for output in &raw.outputs {
        let bound = output.outputs.iter().map(|level| one_output(level.output.as_ref()?, wires, report));
        draft.outputs.push(bound.collect());
    }
    draft
}

/// A channel's number, if it can be one.
pub(super) fn number(value: i64) -> Option<u8> {
    u8::try_from(value).ok().filter(|number| (1..=CHANNELS_MAX).contains(number))
}

/// The channel; `None` where its number is none or its steps are worth nothing.
pub(super) fn channel(raw: &RawChannel) -> Option<AnalogueChannel> {
    Some(AnalogueChannel {
        number: number(raw.number.as_ref()?.value)?,
        unit: raw.unit.as_ref().map_or_else(String::new, |unit| unit.value.clone()),
        factor: Some(or(&raw.factor, 1.0)).filter(|factor| *factor != 0.0)?,
        offset: or(&raw.offset, 0.0),
    })
}

/// Condition of an input; `None` where that is not given well.
pub(super) fn when(raw: &RawLimit) -> Option<When> {
    let hysteresis = or(&raw.hysteresis, 0.0);
    match (&raw.above, &raw.below) {
        (Some(at), None) => Some(When::Above { at: at.value, hysteresis }),
        (None, Some(at)) => Some(When::Below { at: at.value, hysteresis }),
        _ => None,
    }
}

/// The channels a draft describes; `None` if a part is missing. `image` is what their owner's bits are called.
pub(super) fn finish(draft: &DraftAnalogue, raw: &RawAnalogue, image: &Wiring) -> Option<Analogue> {
    let inputs = raw.inputs.iter().zip(&draft.inputs).map(|(raw, (bound, broken))| input(raw, bound, *broken, image));
    let outputs = raw.outputs.iter().zip(&draft.outputs).map(|(raw, bound)| output(raw, bound));
    Some(Analogue { inputs: inputs.collect::<Option<_>>()?, outputs: outputs.collect::<Option<_>>()? })
}

fn input(
    raw: &RawAnalogueInput,
    bound: &[Option<InputId>],
    broken: Option<InputId>,
    image: &Wiring,
) -> Option<AnalogueInput> {
    let inputs = raw.inputs.iter().zip(bound).map(|(raw, input)| Some(((*input)?, when(raw)?)));
    let simulated = match &raw.simulated {
        Some(raw) => Some(Lag { follows: follows(raw, image)?, time_constant: raw.lag.as_ref()?.value }),
        None => None,
    };
    Some(AnalogueInput {
        channel: channel(&raw.channel)?,
        least: raw.least.as_ref().map(|least| least.value),
        most: raw.most.as_ref().map(|most| most.value),
        inputs: inputs.collect::<Option<_>>()?,
        broken,
        simulated,
    })
}

fn output(raw: &RawAnalogueOutput, bound: &[Option<OutputId>]) -> Option<AnalogueOutput> {
    let outputs = raw.outputs.iter().zip(bound).map(|(raw, output)| Some(((*output)?, raw.value.as_ref()?.value)));
    Some(AnalogueOutput {
        channel: channel(&raw.channel)?,
        rest: raw.rest.as_ref()?.value,
        outputs: outputs.collect::<Option<_>>()?,
    })
}

/// Target of a simulated value; `None` where that is not given well.
pub(super) fn follows(raw: &RawLag, image: &Wiring) -> Option<Follows> {
    match (&raw.output, &raw.channel) {
        (Some(output), None) => {
            let at = image.outputs.iter().position(|name| name.value == output.value)?;
            Some(Follows::Output { output: OutputId::at(at), on: raw.on.as_ref()?.value, off: or(&raw.off, 0.0) })
        }
        (None, Some(channel)) => number(channel.value).map(Follows::Channel),
        _ => None,
    }
}
