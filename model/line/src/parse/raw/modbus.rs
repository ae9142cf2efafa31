//! The `modbus` table of a device.

use std::time::Duration;

use linewright_text::{KeyKind, Located, LocatedName, flag, keys, millis, table, tables, text, whole, word};

use crate::Table;

/// The greatest address, and the greatest number in a register.
const WORD_MAX: i64 = 0xFFFF;
/// At most so many registers of one device that are read or written before it is used.
const REGISTERS_MAX: usize = 256;

keys! {
    /// A device in Modbus TCP: its address, the addresses of its bits, and its times.
    pub(in crate::parse) struct RawModbus is "`modbus`" {
        /// Host and port: `"192.168.1.20:502"`; 502 is the usual port.
        address: Option<LocatedName> = text().required(),
        /// Unit identifier behind the address, 0 to 255; 1 if left out.
        unit: Option<Located<i64>> = whole(0, 255).usually(1),
        /// Period of reading and writing, in ms; 20 if left out.
        cycle as "cycle_ms": Option<Located<Duration>> = millis().usually(20),
        /// Longest time for an answer, in ms; 100 if left out.
        timeout as "timeout_ms": Option<Located<Duration>> = millis().usually(100),
        /// Address of the first bit of its `inputs`; discrete input 0 if left out.
        inputs: Option<RawInputRegisters> = table(),
        /// Address of the first bit of its `outputs`; coil 0 if left out.
        outputs: Option<RawOutputRegisters> = table(),
        /// Whether its outputs are read back and compared in each cycle, which detects another master; false if left
        /// out.
        read_back: Option<Located<bool>> = flag(),
        /// Watchdog register: the device turns its outputs off when it is no longer written.
        watchdog: Option<RawWatchdog> = table(),
        /// Reason, in words, why a device with outputs may have no watchdog register: what else turns them off.
        without_watchdog: Option<LocatedName> = text(),
        /// Holding registers with their expected values, at most 256; a device with another value is not used.
        expect: Vec<RawRegisterValue> = tables(REGISTERS_MAX),
        /// Holding registers that are written before the device is used, in this order; at most 256.
        settings: Vec<RawRegisterValue> = tables(REGISTERS_MAX),
    }

    /// A table of the device, and the address of the first bit in it.
    pub(in crate::parse) struct RawInputRegisters is "`inputs`" {
        /// The table that is read.
        table: Table = word(&[
            ("discrete_inputs", Table::DiscreteInputs),
            ("coils", Table::Coils),
            ("input_registers", Table::InputRegisters),
            ("holding_registers", Table::HoldingRegisters),
        ]),
        /// Address of the first bit or register, 0 to 65535; 0 if left out.
        first: Option<Located<i64>> = whole(0, WORD_MAX).usually(0),
    }

    /// A table of the device, and the address of the first bit in it.
    pub(in crate::parse) struct RawOutputRegisters is "`outputs`" {
        /// The table that is written.
        table: Table = word(&[("coils", Table::Coils), ("holding_registers", Table::HoldingRegisters)]),
        /// Address of the first bit or register, 0 to 65535; 0 if left out.
        first: Option<Located<i64>> = whole(0, WORD_MAX).usually(0),
    }

    /// A holding register that is written with another number in each cycle.
    pub(in crate::parse) struct RawWatchdog is "`watchdog`" {
        /// Its address, 0 to 65535.
        register: Option<Located<i64>> = register().required(),
        /// Time after which the device turns its outputs off by itself, in ms; more than `cycle_ms` and twice `timeout_ms`.
        timeout as "timeout_ms": Option<Located<Duration>> = millis().required(),
    }

    /// A holding register and its value.
    pub(in crate::parse) struct RawRegisterValue is "a register" {
        /// Its address, 0 to 65535.
        register: Option<Located<i64>> = register().required(),
        /// Its value, 0 to 65535.
        value: Option<Located<i64>> = register().required(),
    }
}

fn register() -> KeyKind<Option<Located<i64>>> {
    whole(0, WORD_MAX)
}
