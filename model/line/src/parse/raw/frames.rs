//! The `dbc` table of a device.

use std::time::Duration;

use linewright_text::{Located, LocatedName, integer, keys, millis, number, table, tables, text, word};

use crate::Checksum;

/// At most this many messages of one device each way, and of signals in each that anything follows from.
const SIGNALS_MAX: usize = 64;

keys! {
    /// A device without CANopen, whose frames a DBC file describes.
    pub(in crate::parse) struct RawFrames is "`dbc`" {
        /// The DBC file, by its path from this file.
        file: Option<LocatedName> = text().required(),
        /// The messages the device sends, each once, at most 64.
        receive: Vec<RawHeard> = tables(SIGNALS_MAX),
        /// The messages sent to the device, at most 64.
        send: Vec<RawTold> = tables(SIGNALS_MAX),
    }

    /// A message that the device sends.
    pub(in crate::parse) struct RawHeard is "a message received" {
        /// Its name in the DBC file.
        message: Option<LocatedName> = text().required(),
        /// Time without this message after which the device is lost, in ms, 1 to 60000.
        timeout as "timeout_ms": Option<Located<Duration>> = millis().required(),
        /// Counter: a signal with another value in each frame; a frame with the value of the one before does not count.
        counter: Option<LocatedName> = text(),
        /// Checksum over the bytes of the frame.
        checksum: Option<RawChecksum> = table(),
        /// Inputs that follow from the message's signals, at most 64.
        inputs: Vec<RawSignalInput> = tables(SIGNALS_MAX),
    }

    /// A message sent to the device.
    pub(in crate::parse) struct RawTold is "a message sent" {
        /// Its name in the DBC file.
        message: Option<LocatedName> = text().required(),
        /// Period of the message when nothing changes, in ms, 1 to 60000.
        every as "every_ms": Option<Located<Duration>> = millis().required(),
        /// Time without this message after which the device turns its outputs off by itself, in ms; longer than
        /// `every_ms`.
        lets_go_after as "lets_go_after_ms": Option<Located<Duration>> = millis(),
        /// Counter: a signal that counts the frames.
        counter: Option<LocatedName> = text(),
        /// Checksum over the bytes of the frame.
        checksum: Option<RawChecksum> = table(),
        /// Signals that follow from outputs, at most 64.
        outputs: Vec<RawSignalOutput> = tables(SIGNALS_MAX),
        /// Signals with a constant value, at most 64; all others are 0.
        set: Vec<RawSet> = tables(SIGNALS_MAX),
    }

    /// Checksum over the bytes of a frame.
    pub(in crate::parse) struct RawChecksum is "`checksum`" {
        /// The signal, a whole byte.
        signal: Option<LocatedName> = text().required(),
        /// Method, over all bytes but its own: `"xor"`, `"sum"` or `"crc8"` (SAE J1850).
        kind: Checksum = word(&[("xor", Checksum::Xor), ("sum", Checksum::Sum), ("crc8", Checksum::Crc8)]),
    }

    /// An input that follows from a signal: on while the signal is not zero, or as one of `equals`, `above`, `below` and
    /// `bit` says.
    pub(in crate::parse) struct RawSignalInput is "an input" {
        /// The input.
        input: Option<LocatedName> = text().required(),
        /// The signal's name in the DBC file.
        signal: Option<LocatedName> = text().required(),
        /// Value of the signal with which the input is on, in the signal's unit.
        equals: Option<Located<f64>> = number(),
        /// Limit from which up the input is on, in the signal's unit.
        above: Option<Located<f64>> = number(),
        /// Limit from which down the input is on, in the signal's unit.
        below: Option<Located<f64>> = number(),
        /// Bit of the unscaled signal that the input follows, 0 to 63.
        bit: Option<Located<i64>> = integer().from_to(0, 63),
        /// Distance back from the limit at which the input goes off, in the signal's unit; 0 or more.
        hysteresis: Option<Located<f64>> = number().usually(0.0),
    }

    /// A signal that follows from an output.
    pub(in crate::parse) struct RawSignalOutput is "an output" {
        /// The output.
        output: Option<LocatedName> = text().required(),
        /// The signal's name in the DBC file.
        signal: Option<LocatedName> = text().required(),
        /// The signal's value while the output is on, in its unit.
        on: Option<Located<f64>> = number().usually(1.0),
        /// The signal's value while the output is off, in its unit.
        off: Option<Located<f64>> = number().usually(0.0),
    }

    /// A signal with a constant value.
    pub(in crate::parse) struct RawSet is "a value" {
        /// The signal's name in the DBC file.
        signal: Option<LocatedName> = text().required(),
        /// Value, in the signal's unit.
        value: Option<Located<f64>> = number().required(),
    }
}
