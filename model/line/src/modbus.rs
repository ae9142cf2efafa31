//! A device in Modbus TCP: where its bits lie, and how it is watched.
//!
//! Addresses are those of the protocol, from 0: "coil 1" in a manual is address 0 here, "40001" holding register 0.

use std::fmt;
use std::time::Duration;

use crate::{InputId, OutputId};

/// Of registers that hold inputs or outputs, how many bits each has.
pub const REGISTER_BITS: usize = 16;

/// Description of such a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Modbus {
    /// Host and port.
    pub address: String,
    /// Unit identifier.
    pub unit: u8,
    /// Period of reading its inputs and writing its outputs.
    pub cycle: Duration,
    /// Time limit of its answer. A device that takes longer is lost.
    pub timeout: Duration,
    /// For each bit of its inputs, the input of its owner's image it carries.
    pub inputs: Vec<Option<InputId>>,
    /// Their first address.
    pub inputs_at: (Table, u16),
    /// For each bit of its outputs, the output of its owner's image it carries.
    pub outputs: Vec<Option<OutputId>>,
    /// Their first address: coils or holding registers.
    pub outputs_at: (Table, u16),
    /// Its outputs are read back and compared in each cycle.
    pub reads_back: bool,
    /// The register that turns its outputs off when the manager is gone.
    pub watchdog: Option<WatchdogRegister>,
    /// Reason why it may be without a watchdog register.
    pub without_watchdog: Option<String>,
    /// Holding registers by which the right device is recognised.
    pub expect: Vec<RegisterValue>,
    /// Holding registers that are written before it is used, in this order.
    pub settings: Vec<RegisterValue>,
}

/// The four tables of a Modbus device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Table {
    /// Bits to be read and written.
    Coils,
    /// Bits to be read.
    DiscreteInputs,
    /// Words to be read and written.
    HoldingRegisters,
    /// Words to be read.
    InputRegisters,
}

/// A holding register that is written with another number in each cycle: the device turns its outputs off when that stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchdogRegister {
    /// Its address.
    pub register: u16,
    /// After how long without a write the device turns its outputs off.
    pub timeout: Duration,
}

/// A holding register and a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegisterValue {
    /// Its address.
    pub register: u16,
    /// The number.
    pub value: u16,
}

impl Table {
    /// Whether it has words, not bits.
    pub fn has_registers(self) -> bool {
        matches!(self, Table::HoldingRegisters | Table::InputRegisters)
    }

    /// Number of addresses of so many bits.
    pub fn addresses(self, bits: usize) -> usize {
        if self.has_registers() { bits.div_ceil(REGISTER_BITS) } else { bits }
    }

    /// One bit, for a person, by its address.
    fn bit(self, first: u16, bit: usize) -> String {
        let at = usize::from(first) + if self.has_registers() { bit / REGISTER_BITS } else { bit };
        match self {
            Table::Coils => format!("coil {at}"),
            Table::DiscreteInputs => format!("discrete input {at}"),
            Table::HoldingRegisters => format!("holding register {at} bit {}", bit % REGISTER_BITS),
            Table::InputRegisters => format!("input register {at} bit {}", bit % REGISTER_BITS),
        }
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Table::Coils => "coils",
            Table::DiscreteInputs => "discrete inputs",
            Table::HoldingRegisters => "holding registers",
            Table::InputRegisters => "input registers",
        })
    }
}

impl Modbus {
    /// Place of the device, for a person.
    pub fn place(&self) -> String {
        format!("{} unit {}", self.address, self.unit)
    }

    /// Place of an input, for a person; `None` if it is not one of the device's.
    pub(crate) fn source(&self, input: InputId) -> Option<String> {
        let bit = self.inputs.iter().position(|carried| *carried == Some(input))?;
        let (table, first) = self.inputs_at;
        Some(format!("{}, {}", self.place(), table.bit(first, bit)))
    }
}
