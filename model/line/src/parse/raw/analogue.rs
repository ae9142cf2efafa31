//! The `analogue_inputs` and `analogue_outputs` of a device.

use std::time::Duration;

use linewright_text::{Located, LocatedName, integer, keys, millis, number, part, table, tables, text};

use crate::CHANNELS_MAX;

/// At most this many limits or values of one channel.
const LIMITS_MAX: usize = 64;

keys! {
    /// The analogue channels of a device.
    pub(in crate::parse) struct RawAnalogue is "a device" {
        /// What it measures, up to 12 channels: measurements become inputs by limits.
        inputs as "analogue_inputs": Vec<RawAnalogueInput> = tables(CHANNELS_MAX.into()),
        /// What it puts out, up to 12 channels: an output that is on gives a channel its value.
        outputs as "analogue_outputs": Vec<RawAnalogueOutput> = tables(CHANNELS_MAX.into()),
    }

    /// A channel.
    pub(in crate::parse) struct RawChannel is "a channel" {
        /// 1 to 12, the subindex of its object (6401h, 6411h); each once.
        number as "channel": Option<Located<i64>> = integer().required().from_to(1, CHANNELS_MAX.into()),
        /// What it is measured in, for people.
        unit: Option<LocatedName> = text(),
        /// What one step of its number is worth, in its unit; not 0. A value is number × factor + offset.
        factor: Option<Located<f64>> = number().usually(1.0),
        /// The value of the number 0, in its unit.
        offset: Option<Located<f64>> = number().usually(0.0),
    }

    /// A channel that is measured.
    pub(in crate::parse) struct RawAnalogueInput is "an analogue input" {
        /// The channel.
        channel: RawChannel = part(),
        /// A value below this is no measurement.
        least: Option<Located<f64>> = number(),
        /// A value above this is no measurement.
        most: Option<Located<f64>> = number(),
        /// Inputs that follow from it by limits, up to 64.
        inputs: Vec<RawLimit> = tables(LIMITS_MAX),
        /// Input: on while there is no measurement. Without it, the station's inputs are invalid meanwhile.
        broken: Option<LocatedName> = text(),
        /// What a simulated plant has behind it; left out: what the simulated mechanisms' switches would be.
        simulated: Option<RawLag> = table(),
    }

    /// An input that is on beyond a limit: one of `above` and `below`.
    pub(in crate::parse) struct RawLimit is "a limit" {
        /// The input.
        input: Option<LocatedName> = text().required(),
        /// On from this value up, in the channel's unit.
        above: Option<Located<f64>> = number(),
        /// On from this value down, in the channel's unit.
        below: Option<Located<f64>> = number(),
        /// How far the value has to go back beyond the limit for the input to go off, in the channel's unit; 0 or more.
        hysteresis: Option<Located<f64>> = number().usually(0.0),
    }

    /// A simulated value that follows an output or an analogue output.
    pub(in crate::parse) struct RawLag is "`simulated`" {
        /// The output of the station that it follows.
        output: Option<LocatedName> = text(),
        /// Where it goes while the output is on, in the channel's unit.
        on: Option<Located<f64>> = number(),
        /// Where it goes while the output is off, in the channel's unit.
        off: Option<Located<f64>> = number().usually(0.0),
        /// Instead of `output`: the analogue output of the device that it follows, 1 to 12.
        channel: Option<Located<i64>> = integer().from_to(1, CHANNELS_MAX.into()),
        /// After this many ms it has gone 63 % of its way; 1 to 60000.
        lag as "lag_ms": Option<Located<Duration>> = millis().required(),
    }

    /// A channel that is put out.
    pub(in crate::parse) struct RawAnalogueOutput is "an analogue output" {
        /// The channel.
        channel: RawChannel = part(),
        /// Its value while none of its outputs is on, or more than one, and without a manager; in its unit.
        rest: Option<Located<f64>> = number().required(),
        /// Its values while outputs are on, up to 64.
        outputs: Vec<RawLevel> = tables(LIMITS_MAX),
    }

    /// The value of a channel while an output is on.
    pub(in crate::parse) struct RawLevel is "a value" {
        /// The output.
        output: Option<LocatedName> = text().required(),
        /// The value, in the channel's unit.
        value: Option<Located<f64>> = number().required(),
    }
}
