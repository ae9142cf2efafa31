//! Analogue channels of a device (CiA 401), bound to the bits of its owner's process image.
//!
//! To a station nothing changes: an input is on while a measured value is above or below a limit, an output that is on
//! gives a channel its value. This is its description, in the channel's unit. The place of the 16 bits of a channel in
//! a process data object is a [`FrameField`], as for other devices' signals.

use crate::{Coding, FrameField, InputId, OutputId, When};

/// Channels of one device each way: CiA 401 gives its second to fourth process data objects four each.
pub const CHANNELS_MAX: u8 = 12;
/// Channels in one process data object: four of 16 bits.
const IN_ONE: u8 = 4;

/// The analogue channels of a device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Analogue {
    /// Channels that are measured, each once.
    pub inputs: Vec<AnalogueInput>,
    /// Channels that are set, each once.
    pub outputs: Vec<AnalogueOutput>,
}

/// A channel, and the meaning of its number.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalogueChannel {
    /// 1 to [`CHANNELS_MAX`]: the subindex of object 6401h or 6411h.
    pub number: u8,
    /// Unit, for people; may be empty.
    pub unit: String,
    /// Value of a step of the number; not 0.
    pub factor: f64,
    /// Value of 0.
    pub offset: f64,
}

/// A channel that is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalogueInput {
    /// The channel, and the meaning of its number.
    pub channel: AnalogueChannel,
    /// A value below it is no measurement.
    pub least: Option<f64>,
    /// A value above it is no measurement.
    pub most: Option<f64>,
    /// Inputs, and when they are on: [`When::Above`] or [`When::Below`].
    pub inputs: Vec<(InputId, When)>,
    /// The input that is on while there is no measurement. Without one the owner's inputs are then invalid.
    pub broken: Option<InputId>,
    /// Simulated source of the value. Without one its value is such that its inputs follow the mechanisms.
    pub simulated: Option<Lag>,
}

/// A channel that is set.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalogueOutput {
    /// The channel, and the meaning of its number.
    pub channel: AnalogueChannel,
    /// Its value while none of its outputs is on, or more than one; and the device's own value without a manager.
    pub rest: f64,
    /// Its values while one of them is on.
    pub outputs: Vec<(OutputId, f64)>,
}

/// Simulated source of a measured channel: a value that goes to another with a delay of first order.
#[derive(Clone, Debug, PartialEq)]
pub struct Lag {
    /// Target of the value.
    pub follows: Follows,
    /// After this time it has done 63 % of its way.
    pub time_constant: std::time::Duration,
}

/// Target of a simulated value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Follows {
    /// An output of the owner.
    Output {
        output: OutputId,
        /// The value while it is on.
        on: f64,
        /// The value while it is off.
        off: f64,
    },
    /// An analogue output of the same device, by its number.
    Channel(u8),
}

impl AnalogueChannel {
    /// Number of the process data object that carries it, 2 to 4.
    pub fn pdo(&self) -> u8 {
        2 + self.number.saturating_sub(1) / IN_ONE
    }

    /// Place of its 16 bits in that, and their meaning.
    pub fn field(&self) -> FrameField {
        let start = self.number.saturating_sub(1) % IN_ONE * 16;
        let (factor, offset) = (self.factor, self.offset);
        FrameField { start, size: 16, motorola: false, coding: Coding::Signed, factor, offset }
    }

    /// The number that is worth `value`, or what comes nearest; `None` if it is beyond 16 bits.
    pub fn number_of(&self, value: f64) -> Option<i16> {
        self.field().bits(value).map(|bits| bits as u16 as i16)
    }

    /// Value of a number.
    pub fn value_of(&self, number: i16) -> f64 {
        f64::from(number) * self.factor + self.offset
    }

    /// A value in words, with as many decimals as the channel resolves.
    pub fn text(&self, value: f64) -> String {
        let decimals = (-self.factor.abs().log10()).ceil().clamp(0.0, 6.0) as usize;
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        format!("{value:.decimals$}{unit}")
    }
}

impl AnalogueInput {
    /// Whether a number is a measurement. The ends of the range are none, whatever the limits: a converter that has run
    /// out of its range, or has lost its wire, stands there.
    pub fn is_measured(&self, number: i16) -> bool {
        let value = self.channel.value_of(number);
        number != i16::MIN
            && number != i16::MAX
            && self.least.is_none_or(|least| value >= least)
            && self.most.is_none_or(|most| value <= most)
    }

    /// Whether an input that is now `on` is on with this number.
    pub fn holds(&self, when: When, number: i16, on: bool) -> bool {
        when.holds(&self.channel.field(), u64::from(number as u16), on)
    }
}

impl AnalogueOutput {
    /// Its value for an image of its owner's outputs.
    pub fn value(&self, image: u128) -> f64 {
        let mut on = self.outputs.iter().filter(|(output, _)| image & output.bit() != 0);
        match (on.next(), on.next()) {
            (Some((_, value)), None) => *value,
            _ => self.rest,
        }
    }

    /// Value as a number.
    pub fn number(&self, image: u128) -> i16 {
        // The description's rules let no value be beyond the range; were one, the channel stays at rest.
        self.channel.number_of(self.value(image)).unwrap_or_else(|| self.at_rest())
    }

    /// The number it rests at.
    pub fn at_rest(&self) -> i16 {
        self.channel.number_of(self.rest).unwrap_or(0)
    }
}

impl Analogue {
    /// Every input of its owner that a measured value turns on and off.
    pub fn carried_inputs(&self) -> impl Iterator<Item = InputId> {
        self.inputs.iter().flat_map(|channel| channel.inputs.iter().map(|(input, _)| *input).chain(channel.broken))
    }

    /// Every output of its owner that gives a channel its value.
    pub fn carried_outputs(&self) -> impl Iterator<Item = OutputId> {
        self.outputs.iter().flat_map(|channel| channel.outputs.iter().map(|(output, _)| *output))
    }

    /// The object of the channel that turns an input on and off, and how; `None` if none does.
    pub(crate) fn source(&self, input: InputId) -> Option<String> {
        self.inputs.iter().find_map(|own| {
            let (channel, number) = (&own.channel, own.channel.number);
            if own.broken == Some(input) {
                return Some(format!("6401h:{number:02X} is no measurement"));
            }
            let (_, when) = own.inputs.iter().find(|(bound, _)| *bound == input)?;
            let limit = match when {
                When::Above { at, .. } => format!(" above {}", channel.text(*at)),
                When::Below { at, .. } => format!(" below {}", channel.text(*at)),
                When::NotZero | When::Equals(_) | When::Bit(_) => String::new(),
            };
            Some(format!("6401h:{number:02X}{limit}"))
        })
    }
}
