//! Requests as bytes.

use linewright_line::Table;
use linewright_modbus::{ModbusRequest, kept_bits};

#[test]
fn requests_are_encoded_as_the_specification_shows() {
    // §6.11: coils 20 to 29 (address 13h), CDh 01h.
    let coils = ModbusRequest::WriteCoils { first: 0x13, count: 10, bits: 0x01CD };
    assert_eq!(coils.adu(1, 0xFF), [0, 1, 0, 0, 0, 9, 0xFF, 0x0F, 0, 0x13, 0, 0x0A, 2, 0xCD, 0x01]);
    // §6.12: two registers from 2 (address 1): 000Ah and 0102h.
    let registers = ModbusRequest::WriteRegisters { first: 1, count: 2, words: 0x0102_000A };
    assert_eq!(registers.adu(2, 1), [0, 2, 0, 0, 0, 11, 1, 0x10, 0, 1, 0, 2, 4, 0, 0x0A, 0x01, 0x02]);
    // §6.2: discrete inputs 197 to 218.
    let read = ModbusRequest::Read { table: Table::DiscreteInputs, first: 0xC4, count: 0x16 };
    assert_eq!(read.adu(3, 1), [0, 3, 0, 0, 0, 6, 1, 2, 0, 0xC4, 0, 0x16]);
}

#[test]
fn bits_fill_coils_one_by_one_and_registers_sixteen_by_sixteen() {
    let coils = ModbusRequest::write_bits((Table::Coils, 5), 3, 0xFF);
    assert_eq!(coils, ModbusRequest::WriteCoils { first: 5, count: 3, bits: 0b111 });
    let registers = ModbusRequest::write_bits((Table::HoldingRegisters, 5), 17, u64::MAX);
    assert_eq!(registers, ModbusRequest::WriteRegisters { first: 5, count: 2, words: 0x1_FFFF });
    assert_eq!(kept_bits(u64::MAX, 64), u64::MAX);
}
