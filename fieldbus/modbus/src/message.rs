//! Requests and answers, and the few of them that are encoded here.

use linewright_line::{REGISTER_BITS, Table};

/// Request to a device. Bits and registers are numbers: bit `i` is the one at `first + i`, and of registers each has
/// sixteen bits, the first one the lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModbusRequest {
    /// To read so many bits or registers (functions 01h to 04h).
    Read { table: Table, first: u16, count: u16 },
    /// To write coils (function 0Fh).
    WriteCoils { first: u16, count: u16, bits: u64 },
    /// To write holding registers (function 10h).
    WriteRegisters {
        first: u16,
        /// Number of registers, at most four.
        count: u16,
        words: u64,
    },
}

/// Why there is no answer, or none that can be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusFailure {
    /// There is no connection, or none any more.
    Gone(String),
    /// The device refuses, with this code.
    Exception(u8),
    /// The answer cannot be decoded; the error.
    Malformed(String),
    /// The answer is one to another request.
    OtherAnswer,
    /// The answer has another number of bits or registers than requested.
    Count { came: usize, count: u16 },
}

/// Of a number, so many low bits.
pub fn kept_bits(value: u64, count: usize) -> u64 {
    if count >= 64 { value } else { value & ((1 << count) - 1) }
}

impl ModbusRequest {
    /// To write one holding register.
    pub fn write_register(register: u16, value: u16) -> Self {
        ModbusRequest::WriteRegisters { first: register, count: 1, words: value.into() }
    }

    /// To write these bits into coils or registers.
    pub fn write_bits((table, first): (Table, u16), bits: usize, value: u64) -> Self {
        let count = u16::try_from(table.addresses(bits)).unwrap_or(u16::MAX);
        if table.has_registers() {
            ModbusRequest::WriteRegisters { first, count, words: kept_bits(value, bits) }
        } else {
            ModbusRequest::WriteCoils { first, count, bits: kept_bits(value, bits) }
        }
    }

    /// To read so many bits.
    pub fn read_bits((table, first): (Table, u16), bits: usize) -> Self {
        ModbusRequest::Read { table, first, count: u16::try_from(table.addresses(bits)).unwrap_or(u16::MAX) }
    }

    /// Its bytes on a TCP connection (MBAP header, function, data), for a last order without an awaited answer.
    pub fn adu(&self, transaction: u16, unit: u8) -> Vec<u8> {
        let mut pdu = Vec::with_capacity(16);
        let head = |pdu: &mut Vec<u8>, function: u8, first: u16, count: u16| {
            pdu.push(function);
            pdu.extend(first.to_be_bytes());
            pdu.extend(count.to_be_bytes());
        };
        match *self {
            ModbusRequest::Read { table, first, count } => head(&mut pdu, function_of(table), first, count),
            ModbusRequest::WriteCoils { first, count, bits } => {
                head(&mut pdu, 0x0F, first, count);
                let bytes = usize::from(count).div_ceil(8).min(8);
                pdu.push(bytes as u8);
                pdu.extend(&bits.to_le_bytes()[..bytes]);
            }
            ModbusRequest::WriteRegisters { first, count, words } => {
                let count = count.min(4);
                head(&mut pdu, 0x10, first, count);
                pdu.push(count as u8 * 2);
                for at in 0..usize::from(count) {
                    pdu.extend(((words >> (REGISTER_BITS * at)) as u16).to_be_bytes());
                }
            }
        }
        let mut adu = Vec::with_capacity(7 + pdu.len());
        adu.extend(transaction.to_be_bytes());
        adu.extend([0, 0]);
        adu.extend((pdu.len() as u16 + 1).to_be_bytes());
        adu.push(unit);
        adu.extend(pdu);
        adu
    }
}

fn function_of(table: Table) -> u8 {
    match table {
        Table::Coils => 1,
        Table::DiscreteInputs => 2,
        Table::HoldingRegisters => 3,
        Table::InputRegisters => 4,
    }
}
