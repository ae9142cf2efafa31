//! A device without CANopen: plain CAN frames, as a DBC file describes them.
//!
//! To a station it is a device like any other: its frames turn inputs on and off, outputs turn into numbers in frames it
//! is sent. [`FrameTable`] is the description, in the names of the DBC file; [`FrameBinding`] is the same in numbers,
//! computed by the reader of that file. A [`FrameField`] is the place of a number in eight bytes.

use std::fmt;
use std::ops::Range;
use std::time::Duration;

use crate::{InputId, OutputId};

/// A name of the DBC file, and its place in the description, for messages about it.
#[derive(Clone, PartialEq, Eq)]
pub struct DbcName {
    pub name: String,
    /// The bytes of the description it stands in.
    pub at: Range<usize>,
}

/// Without its place, which a comment changes: [`Line::fingerprint`](crate::Line::fingerprint) is taken of this form.
impl fmt::Debug for DbcName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name.fmt(f)
    }
}

/// Description of such a device.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTable {
    /// Its DBC file, by its path from the description's directory.
    pub file: DbcName,
    /// The messages it sends.
    pub receive: Vec<ReceivedMessageTable>,
    /// The messages it is sent.
    pub send: Vec<CyclicFrame>,
    /// The same in numbers. `None` until the file has been read.
    pub bound: Option<FrameBinding>,
}

/// A message that the device sends.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceivedMessageTable {
    /// Name of the message in the DBC file.
    pub message: DbcName,
    /// The device is lost when it has not come for this long.
    pub timeout: Duration,
    /// A signal that is another in each frame: one that comes with the same number again is no news.
    pub counter: Option<DbcName>,
    /// Its checksum, and the signal that carries it.
    pub checksum: Option<(DbcName, Checksum)>,
    /// Inputs that follow from it.
    pub inputs: Vec<SignalInput>,
}

/// An input that follows a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalInput {
    pub input: InputId,
    pub signal: DbcName,
    /// Condition under which it is on.
    pub when: When,
}

/// Condition of an input that follows a signal. Numbers are in the signal's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// While the signal is not zero.
    NotZero,
    /// While it has this value.
    Equals(f64),
    /// While this bit of it, before scaling, is set.
    Bit(u8),
    /// From a limit up, and until it falls below the limit by more than the hysteresis.
    Above {
        /// The limit.
        at: f64,
        /// At least 0.
        hysteresis: f64,
    },
    /// From a limit down, and until it rises above the limit by more than the hysteresis.
    Below {
        /// The limit.
        at: f64,
        /// At least 0.
        hysteresis: f64,
    },
}

/// A message that the device is sent.
#[derive(Clone, Debug, PartialEq)]
pub struct CyclicFrame {
    /// Name of the message in the DBC file.
    pub message: DbcName,
    /// Period, when nothing changes.
    pub every: Duration,
    /// Time after the last one until the device turns its outputs off by itself; `None`: not given.
    pub lets_go_after: Option<Duration>,
    /// A signal that counts the frames.
    pub counter: Option<DbcName>,
    /// A signal for its checksum.
    pub checksum: Option<(DbcName, Checksum)>,
    /// Values by outputs.
    pub outputs: Vec<SignalOutput>,
    /// Signals that have the same value in every frame.
    pub set: Vec<(DbcName, f64)>,
}

/// A signal that follows an output.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalOutput {
    pub output: OutputId,
    pub signal: DbcName,
    /// Its value while the output is on.
    pub on: f64,
    /// And while it is off.
    pub off: f64,
}

/// Computation of one byte from the other bytes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checksum {
    /// Exclusive or.
    Xor,
    /// Their sum, the lower eight bits of it.
    Sum,
    /// CRC-8 of SAE J1850: polynomial 1Dh, begun with FFh, inverted.
    Crc8,
}

/// A frame's identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId {
    /// 11 or 29 bits.
    pub id: u32,
    /// Whether it has 29.
    pub extended: bool,
}

impl fmt::Display for FrameId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.extended { write!(f, "{:08X}h", self.id) } else { write!(f, "{:03X}h", self.id) }
    }
}

/// Coding of a field's bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// A number without a sign.
    Unsigned,
    /// A number in two's complement.
    Signed,
    /// An IEEE number of 32 bits.
    Float,
    /// An IEEE number of 64 bits.
    Double,
}

/// Place of a signal in a frame, and meaning of its bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameField {
    /// As a DBC file counts, bit *n* is bit *n* mod 8 of byte *n* / 8: the lowest bit of an Intel field, the highest of a
    /// Motorola one.
    pub start: u8,
    /// Bits, 1 to 64.
    pub size: u8,
    /// Motorola byte order: the higher byte comes first.
    pub motorola: bool,
    /// Coding of the bits.
    pub coding: Coding,
    /// Value of a step; not 0.
    pub factor: f64,
    /// Value of 0.
    pub offset: f64,
}

impl FrameField {
    /// Whether it is within a frame of so many bytes.
    pub fn fits(&self, len: u8) -> bool {
        let (start, size, bits) = (u32::from(self.start), u32::from(self.size), u32::from(len) * 8);
        let first = if self.motorola { start / 8 * 8 + 7 - start % 8 } else { start };
        (1..=64).contains(&size) && first + size <= bits
    }

    /// Distance of its lowest bit from that of the 64 bits, read in its byte order. It fits 8 bytes.
    fn shift(&self) -> u32 {
        let (start, size) = (u32::from(self.start), u32::from(self.size));
        if self.motorola { 64u32.saturating_sub(start / 8 * 8 + 7 - start % 8 + size) } else { start.min(63) }
    }

    fn mask(&self) -> u64 {
        u64::MAX >> (64 - u32::from(self.size.clamp(1, 64)))
    }

    /// Its bits.
    pub fn get(&self, data: &[u8; 8]) -> u64 {
        let all = if self.motorola { u64::from_be_bytes(*data) } else { u64::from_le_bytes(*data) };
        all >> self.shift() & self.mask()
    }

    /// Puts bits there; those beyond its size are left out.
    pub fn put(&self, data: &mut [u8; 8], bits: u64) {
        let all = if self.motorola { u64::from_be_bytes(*data) } else { u64::from_le_bytes(*data) };
        let all = all & !(self.mask() << self.shift()) | (bits & self.mask()) << self.shift();
        *data = if self.motorola { all.to_be_bytes() } else { all.to_le_bytes() };
    }

    /// Whether the two have a bit in common. Both fit 8 bytes.
    pub fn meets(&self, other: &FrameField) -> bool {
        let [own, others] = [self, other].map(|field| {
            let mut data = [0; 8];
            field.put(&mut data, u64::MAX);
            u64::from_le_bytes(data)
        });
        own & others != 0
    }

    /// The least and the greatest value it holds.
    pub fn range(&self) -> (f64, f64) {
        let highest = 1 << (self.size.clamp(1, 64) - 1);
        let ends = match self.coding {
            Coding::Unsigned => [0, self.mask()],
            Coding::Signed => [highest, self.mask() & !highest],
            Coding::Float => [f32::MIN, f32::MAX].map(|end| end.to_bits().into()),
            Coding::Double => [f64::MIN, f64::MAX].map(f64::to_bits),
        };
        let [one, other] = ends.map(|bits| self.value(bits));
        (one.min(other), one.max(other))
    }

    /// Value of its bits.
    pub fn value(&self, bits: u64) -> f64 {
        let number = match self.coding {
            Coding::Unsigned => bits as f64,
            Coding::Signed => {
                let unused = 64 - u32::from(self.size.clamp(1, 64));
                ((bits << unused) as i64 >> unused) as f64
            }
            Coding::Float => f32::from_bits(bits as u32).into(),
            Coding::Double => f64::from_bits(bits),
        };
        number * self.factor + self.offset
    }

    /// The bits that are worth `value`, or what comes nearest; `None` if it is beyond what the field holds.
    pub fn bits(&self, value: f64) -> Option<u64> {
        let number = (value - self.offset) / self.factor;
        let whole = number.round();
        let size = i32::from(self.size.clamp(1, 64));
        match self.coding {
            _ if !number.is_finite() => None,
            Coding::Unsigned => (whole >= 0.0 && whole < 2f64.powi(size)).then_some(whole as u64),
            Coding::Signed => {
                let half = 2f64.powi(size - 1);
                (whole >= -half && whole < half).then_some(whole as i64 as u64 & self.mask())
            }
            Coding::Float => Some((number as f32).to_bits().into()),
            Coding::Double => Some(number.to_bits()),
        }
    }
}

impl Checksum {
    /// Of the first `len` bytes but for the one at `own`.
    pub fn of(self, data: &[u8; 8], len: u8, own: u8) -> u8 {
        let bytes = data.iter().take(len.into()).enumerate().filter(|(at, _)| *at != usize::from(own));
        let bytes = bytes.map(|(_, byte)| *byte);
        match self {
            Checksum::Xor => bytes.fold(0, |sum, byte| sum ^ byte),
            Checksum::Sum => bytes.fold(0, u8::wrapping_add),
            Checksum::Crc8 => !bytes.fold(0xFF, |crc, byte| {
                (0..8).fold(crc ^ byte, |crc: u8, _| crc << 1 ^ if crc & 0x80 != 0 { 0x1D } else { 0 })
            }),
        }
    }
}

/// [`FrameTable`] in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameBinding {
    /// The messages the device sends.
    pub heard: Vec<ReceivedFrameBinding>,
    /// The messages it is sent.
    pub told: Vec<SentFrameBinding>,
}

/// A message that the device sends.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceivedFrameBinding {
    /// Name, as in the description.
    pub name: String,
    /// Its identifier.
    pub id: FrameId,
    /// Its bytes, 0 to 8.
    pub len: u8,
    /// Longest time without it.
    pub timeout: Duration,
    /// Differs from frame to frame.
    pub counter: Option<FrameField>,
    /// The byte that holds a checksum.
    pub checksum: Option<(u8, Checksum)>,
    /// Pages read of it, at least one; a message that is not multiplexed has one.
    pub pages: Vec<Page>,
}

/// Signals read together: all that is not multiplexed, or those of one value of the selector. Each page has to come in
/// time.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The selector, and the values of it with which this page is there.
    pub selected: Option<(FrameField, Vec<(u64, u64)>)>,
    /// Inputs, the fields they follow, and their conditions.
    pub inputs: Vec<(InputId, FrameField, When)>,
    /// Least and greatest valid values, of signals with inputs, where the DBC file has them. Many devices send "not
    /// available" beyond them.
    pub limits: Vec<(FrameField, f64, f64)>,
}

/// Reason why the bits of a signal are no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalError {
    /// The signal that starts at this bit is infinite, or no number.
    Number(u8),
    /// The signal that starts at this bit is beyond its limits.
    Limits(u8),
}

impl fmt::Display for SignalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SignalError::Number(start) => write!(f, "its signal at bit {start} is no number"),
            SignalError::Limits(start) => write!(f, "its signal at bit {start} is beyond its limits in the DBC file"),
        }
    }
}

/// A message that the device is sent.
#[derive(Clone, Debug, PartialEq)]
pub struct SentFrameBinding {
    /// Name, as in the description.
    pub name: String,
    /// Its identifier.
    pub id: FrameId,
    /// Its bytes, 0 to 8.
    pub len: u8,
    /// Period.
    pub every: Duration,
    /// Time after the last one until the device turns its outputs off by itself, where the description has it.
    pub lets_go_after: Option<Duration>,
    /// Counts the frames.
    pub counter: Option<FrameField>,
    /// The byte that holds a checksum.
    pub checksum: Option<(u8, Checksum)>,
    /// The bytes with nothing on: constants, and every output's `off`.
    pub rest: [u8; 8],
    /// Outputs, where they lie, and the bits for on.
    pub outputs: Vec<(OutputId, FrameField, u64)>,
}

impl Page {
    /// Whether a frame has it.
    pub fn is_in(&self, data: &[u8; 8]) -> bool {
        self.selected.as_ref().is_none_or(|(selector, values)| {
            let value = selector.get(data);
            values.iter().any(|(first, last)| (*first..=*last).contains(&value))
        })
    }

    /// Signal in a frame of this page that is no value, although an input follows it.
    pub fn unsound(&self, data: &[u8; 8]) -> Option<SignalError> {
        let value = |field: &FrameField| field.value(field.get(data));
        let is_none = |(_, field, _): &&(InputId, FrameField, When)| !value(field).is_finite();
        let is_beyond = |(field, least, most): &&(FrameField, f64, f64)| !(*least..=*most).contains(&value(field));
        let number = self.inputs.iter().find(is_none).map(|(_, field, _)| SignalError::Number(field.start));
        number.or_else(|| self.limits.iter().find(is_beyond).map(|(field, ..)| SignalError::Limits(field.start)))
    }
}

impl When {
    /// Reason why a limit does not divide the values from `least` to `most`; `None` if they are on either side of it.
    pub fn out_of_reach(self, least: f64, most: f64) -> Option<&'static str> {
        let (on, off) = match self {
            When::NotZero | When::Equals(_) | When::Bit(_) => return None,
            When::Above { at, hysteresis } => (at <= most, at - hysteresis > least),
            When::Below { at, hysteresis } => (at >= least, at + hysteresis < most),
        };
        match (on, off) {
            (true, true) => None,
            (false, _) => Some("is never reached"),
            (true, false) => Some("is never left again"),
        }
    }

    /// Whether an input that is now `on` is on with these bits.
    pub fn holds(self, field: &FrameField, bits: u64, on: bool) -> bool {
        let value = field.value(bits);
        match self {
            When::NotZero => value != 0.0,
            When::Equals(equal) => field.bits(equal) == Some(bits),
            When::Bit(bit) => bits.checked_shr(bit.into()).is_some_and(|bits| bits & 1 == 1),
            When::Above { at, hysteresis } => value >= if on { at - hysteresis } else { at },
            When::Below { at, hysteresis } => value <= if on { at + hysteresis } else { at },
        }
    }
}

impl SentFrameBinding {
    /// The bytes for an image of its owner's outputs.
    pub fn bytes(&self, image: u128, count: u64) -> [u8; 8] {
        let mut data = self.rest;
        for (output, field, on) in &self.outputs {
            if image & output.bit() != 0 {
                field.put(&mut data, *on);
            }
        }
        if let Some(counter) = &self.counter {
            counter.put(&mut data, count);
        }
        if let Some((at, checksum)) = self.checksum {
            data[usize::from(at.min(7))] = checksum.of(&data, self.len, at);
        }
        data
    }
}

impl FrameTable {
    /// Every input of its station that its frames turn on and off.
    pub fn inputs(&self) -> impl Iterator<Item = InputId> {
        self.receive.iter().flat_map(|message| message.inputs.iter().map(|input| input.input))
    }

    /// Message and signal that turn an input on, as `18FEF100h State.Temperature`, without the identifier while the DBC file
    /// has not been read; `None` if it is none of this device's.
    pub fn source(&self, input: InputId) -> Option<String> {
        let of_message = |message: &ReceivedMessageTable| {
            let signal = &message.inputs.iter().find(|of_signal| of_signal.input == input)?.signal.name;
            let name = &message.message.name;
            let bound = self.bound.iter().flat_map(|bound| &bound.heard).find(|heard| heard.name == *name);
            let id = bound.map(|heard| format!("{} ", heard.id)).unwrap_or_default();
            Some(format!("{id}{name}.{signal}"))
        };
        self.receive.iter().find_map(of_message)
    }

    /// Every output of its station that goes into frames.
    pub fn outputs(&self) -> impl Iterator<Item = OutputId> {
        self.send.iter().flat_map(|message| message.outputs.iter().map(|output| output.output))
    }
}
