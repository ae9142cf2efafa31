//! The `dbc` table of a device.

use std::time::Duration;

use linewright_text::{Located, LocatedName, integer, keys, millis, number, table, tables, text, word};

use crate::Checksum;

/// At most this many messages of one device each way, and of signals in each that anything follows from.
const SIGNALS_MAX: usize = 64;

keys! {
    /// A device that speaks no CANopen: plain frames, described by a DBC file.
    pub(in crate::parse) struct RawFrames is "`dbc`" {
        /// The DBC file, by its path from this file.
        file: Option<LocatedName> = text().required(),
        /// The messages the device sends, each once, up to 64.
        receive: Vec<RawHeard> = tables(SIGNALS_MAX),
        /// The messages it is sent, up to 64.
        send: Vec<RawTold> = tables(SIGNALS_MAX),
    }

    /// A message that the device sends.
    pub(in crate::parse) struct RawHeard is "a message received" {
        /// Its name in the DBC file.
        message: Option<LocatedName> = text().required(),
        /// The device is lost when the message has not come for this long, in ms, 1 to 60000.
        timeout as "timeout_ms": Option<Located<Duration>> = millis().required(),
        /// A signal that is another in each frame; a frame with the number of the one before it does not count.
        counter: Option<LocatedName> = text(),
        /// The signal that adds up the bytes of the frame.
        checksum: Option<RawChecksum> = table(),
        /// Inputs that follow from its signals, up to 64.
        inputs: Vec<RawSignalInput> = tables(SIGNALS_MAX),
    }

    /// A message that the device is sent.
    pub(in crate::parse) struct RawTold is "a message sent" {
        /// Its name in the DBC file.
        message: Option<LocatedName> = text().required(),
        /// How often it is sent when nothing changes, in ms, 1 to 60000.
        every as "every_ms": Option<Located<Duration>> = millis().required(),
        /// After how many ms without this message the device turns its outputs off by itself; longer than `every_ms`.
        lets_go_after as "lets_go_after_ms": Option<Located<Duration>> = millis(),
        /// A signal that counts the frames.
        counter: Option<LocatedName> = text(),
        /// The signal that adds up the bytes of the frame.
        checksum: Option<RawChecksum> = table(),
        /// Signals that follow from outputs, up to 64.
        outputs: Vec<RawSignalOutput> = tables(SIGNALS_MAX),
        /// Signals that never change, up to 64; all others are 0.
        set: Vec<RawSet> = tables(SIGNALS_MAX),
    }

    /// The signal that adds up the bytes of a frame.
    pub(in crate::parse) struct RawChecksum is "`checksum`" {
        /// The signal, a whole byte.
        signal: Option<LocatedName> = text().required(),
        /// How: all bytes but its own, `"xor"`, `"sum"` or `"crc8"` (SAE J1850).
        kind: Checksum = word(&[("xor", Checksum::Xor), ("sum", Checksum::Sum), ("crc8", Checksum::Crc8)]),
    }

    /// An input that follows from a signal: on while the signal is not zero, or as one of `equals`, `above`, `below` and
    /// `bit` says.
    pub(in crate::parse) struct RawSignalInput is "an input" {
        /// The input.
        input: Option<LocatedName> = text().required(),
        /// The signal's name in the DBC file.
        signal: Option<LocatedName> = text().required(),
        /// On while the signal has this value, in its unit.
        equals: Option<Located<f64>> = number(),
        /// On from this value up, in the signal's unit.
        above: Option<Located<f64>> = number(),
        /// On from this value down, in the signal's unit.
        below: Option<Located<f64>> = number(),
        /// On while this bit of the signal is, before scaling; 0 to 63.
        bit: Option<Located<i64>> = integer().from_to(0, 63),
        /// How far the value has to go back beyond the limit for the input to go off, in the signal's unit; 0 or more.
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

    /// A signal that never changes.
    pub(in crate::parse) struct RawSet is "a value" {
        /// The signal's name in the DBC file.
        signal: Option<LocatedName> = text().required(),
        /// Its value, in its unit.
        value: Option<Located<f64>> = number().required(),
    }
}
