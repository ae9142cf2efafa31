//! The `analogue_inputs` and `analogue_outputs` of a device.

use std::time::Duration;

use linewright_text::{Located, LocatedName, integer, keys, millis, number, part, table, tables, text};

use crate::CHANNELS_MAX;

/// At most this many limits or values of one channel.
const LIMITS_MAX: usize = 64;

keys! {
    /// The analogue channels of a device.
    pub(in crate::parse) struct RawAnalogue is "a device" {
        /// Measured channels, at most 12: measurements become inputs by limits.
        inputs as "analogue_inputs": Vec<RawAnalogueInput> = tables(CHANNELS_MAX.into()),
        /// Channels that the device puts out, at most 12: an output that is on gives a channel its value.
        outputs as "analogue_outputs": Vec<RawAnalogueOutput> = tables(CHANNELS_MAX.into()),
    }

    /// A channel.
    pub(in crate::parse) struct RawChannel is "a channel" {
        /// Number of the channel, 1 to 12: the subindex of its object (6401h, 6411h); each once.
        number as "channel": Option<Located<i64>> = integer().required().from_to(1, CHANNELS_MAX.into()),
        /// Unit, for people.
        unit: Option<LocatedName> = text(),
        /// Value of one step of the channel's number, in its unit; not 0. A value is number × factor + offset.
        factor: Option<Located<f64>> = number().usually(1.0),
        /// Value of the number 0, in the channel's unit.
        offset: Option<Located<f64>> = number().usually(0.0),
    }

    /// A channel that is measured.
    pub(in crate::parse) struct RawAnalogueInput is "an analogue input" {
        /// The channel.
        channel: RawChannel = part(),
        /// Least measurement, in the channel's unit; a value below it is a fault.
        least: Option<Located<f64>> = number(),
        /// Greatest measurement, in the channel's unit; a value above it is a fault.
        most: Option<Located<f64>> = number(),
        /// Inputs that follow from the measurement by limits, at most 64.
        inputs: Vec<RawLimit> = tables(LIMITS_MAX),
        /// Input: on while there is no measurement. Without it, the station's inputs are invalid meanwhile.
        broken: Option<LocatedName> = text(),
        /// Value in the simulated plant; if left out, the one that gives its inputs the state of the simulated
        /// mechanisms' switches.
        simulated: Option<RawLag> = table(),
    }

    /// An input that is on beyond a limit: one of `above` and `below`.
    pub(in crate::parse) struct RawLimit is "a limit" {
        /// The input.
        input: Option<LocatedName> = text().required(),
        /// Limit from which up the input is on, in the channel's unit.
        above: Option<Located<f64>> = number(),
        /// Limit from which down the input is on, in the channel's unit.
        below: Option<Located<f64>> = number(),
        /// Distance back from the limit at which the input goes off, in the channel's unit; 0 or more.
        hysteresis: Option<Located<f64>> = number().usually(0.0),
    }

    /// A simulated value that follows an output or an analogue output.
    pub(in crate::parse) struct RawLag is "`simulated`" {
        /// The output of the station that it follows.
        output: Option<LocatedName> = text(),
        /// Final value while the output is on, in the channel's unit.
        on: Option<Located<f64>> = number(),
        /// Final value while the output is off, in the channel's unit.
        off: Option<Located<f64>> = number().usually(0.0),
        /// Analogue output of the device that it follows, 1 to 12, instead of `output`.
        channel: Option<Located<i64>> = integer().from_to(1, CHANNELS_MAX.into()),
        /// Time constant, in ms, 1 to 60000: the time after which 63 % of a change are done.
        lag as "lag_ms": Option<Located<Duration>> = millis().required(),
    }

    /// A channel that the device puts out.
    pub(in crate::parse) struct RawAnalogueOutput is "an analogue output" {
        /// The channel.
        channel: RawChannel = part(),
        /// Value while none of the channel's outputs is on, or more than one, and without a manager; in its unit.
        rest: Option<Located<f64>> = number().required(),
        /// Values while outputs are on, at most 64.
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
