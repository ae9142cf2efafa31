//! A simulated device in Modbus: the register map of its description, from the far end.
//!
//! It has exactly the coils, inputs and registers that the description names; any other request is an illegal data
//! address. It behaves as described: with a watchdog register, **its outputs go off** when that has not been written
//! for its time. Without one they stay as they are, as most devices do.

use std::collections::BTreeMap;

use linewright_line::{Modbus, REGISTER_BITS, Table, Tick};

use crate::fault::{DeviceFault, FaultWrite, HeldFaults};

/// Exception code of an address that is not there (MODBUS Application Protocol V1.1b3 §7).
const ILLEGAL_ADDRESS: u8 = 2;
/// Exception code of a count or a value that cannot be.
pub(crate) const ILLEGAL_VALUE: u8 = 3;
/// The most bits and the most words of one request.
const BITS_MAX: u16 = 2000;
const WORDS_MAX: u16 = 125;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusRequest {
    Read {
        table: Table,
        first: u16,
        count: u16,
    },
    /// To write coils from this address on.
    WriteCoils(u16, Vec<bool>),
    /// To write holding registers from this address on.
    WriteRegisters(u16, Vec<u16>),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusResponse {
    Bits(Vec<bool>),
    Words(Vec<u16>),
    Written,
}

/// A simulated device in Modbus.
#[derive(Debug)]
pub struct ModbusNode {
    modbus: Modbus,
    inputs: u64,
    outputs: u64,
    /// Holding registers that are neither inputs nor outputs.
    registers: BTreeMap<u16, u16>,
    /// When its watchdog turns its outputs off; `None` without one, and after that.
    missed: Option<Tick>,
    silent: bool,
    held: HeldFaults,
}

impl ModbusNode {
    /// One that is switched on, as its description has it.
    pub fn new(modbus: &Modbus) -> Self {
        let expected = modbus.expect.iter().map(|own| (own.register, own.value));
        let set = modbus.settings.iter().map(|own| (own.register, 0));
        let watchdog = modbus.watchdog.iter().map(|own| (own.register, 0));
        ModbusNode {
            inputs: 0,
            outputs: 0,
            // Registers for its identification are there from the beginning.
            registers: set.chain(watchdog).chain(expected).collect(),
            missed: None,
            silent: false,
            held: HeldFaults::default(),
            modbus: modbus.clone(),
        }
    }

    /// Whether it has this address and unit.
    pub fn is_at(&self, address: &str, unit: u8) -> bool {
        self.modbus.address == address && self.modbus.unit == unit
    }

    /// Bit `i` is its output `i`.
    pub fn outputs(&self) -> u64 {
        self.outputs
    }

    /// Sets its inputs as the switches have them.
    pub fn set_inputs(&mut self, inputs: u64) {
        self.inputs = inputs;
    }

    /// Unplugs it, makes it boot, or lets it work again (`None`).
    pub fn inject(&mut self, fault: Option<DeviceFault>) {
        self.silent = matches!(fault, Some(DeviceFault::Silent | DeviceFault::NoBoot));
        match fault {
            None => self.held = HeldFaults::default(),
            Some(DeviceFault::Reboot | DeviceFault::NoBoot) => {
                // What it moves and reads goes on failing.
                let held = std::mem::take(&mut self.held);
                *self = ModbusNode { silent: self.silent, inputs: self.inputs, held, ..ModbusNode::new(&self.modbus) };
            }
            Some(_) => {}
        }
    }

    /// Notes what was written to one of the objects that hold a fault.
    pub(crate) fn hold(&mut self, written: FaultWrite) {
        self.held.note(written);
    }

    /// Number of injected faults that hold.
    pub(crate) fn faults(&self) -> u16 {
        self.held.count().saturating_add(self.silent.into())
    }

    pub fn poll(&mut self, now: Tick) {
        if self.missed.is_some_and(|missed| missed <= now) {
            (self.outputs, self.missed) = (0, None);
        }
    }

    pub fn next_deadline(&self) -> Option<Tick> {
        self.missed
    }

    /// Answers a request, with an exception's code if it refuses it; `None` while it is unplugged.
    pub fn handle(&mut self, now: Tick, request: &ModbusRequest) -> Option<Result<ModbusResponse, u8>> {
        self.poll(now);
        if self.silent {
            return None;
        }
        Some(match request {
            ModbusRequest::Read { table, first, count } if table.has_registers() => self.words(*table, *first, *count),
            ModbusRequest::Read { table, first, count } => self.bits(*table, *first, *count),
            ModbusRequest::WriteCoils(first, bits) => self.write_coils(*first, bits),
            ModbusRequest::WriteRegisters(first, words) => self.write_registers(now, *first, words),
        })
    }

    fn bits(&self, table: Table, first: u16, count: u16) -> Result<ModbusResponse, u8> {
        if !(1..=BITS_MAX).contains(&count) {
            return Err(ILLEGAL_VALUE);
        }
        let bits = (0..count).map(|at| self.bit(table, first.checked_add(at)?));
        bits.collect::<Option<_>>().map(ModbusResponse::Bits).ok_or(ILLEGAL_ADDRESS)
    }

    fn bit(&self, table: Table, address: u16) -> Option<bool> {
        let inputs = (self.modbus.inputs_at, self.modbus.inputs.len(), self.inputs);
        let outputs = (self.modbus.outputs_at, self.modbus.outputs.len(), self.outputs);
        [inputs, outputs].into_iter().find_map(|((own, first), bits, value)| {
            let at = usize::from(address.checked_sub(first)?);
            (own == table && at < bits).then(|| value >> at & 1 == 1)
        })
    }

    fn words(&self, table: Table, first: u16, count: u16) -> Result<ModbusResponse, u8> {
        if !(1..=WORDS_MAX).contains(&count) {
            return Err(ILLEGAL_VALUE);
        }
        let words = (0..count).map(|at| self.word(table, first.checked_add(at)?));
        words.collect::<Option<_>>().map(ModbusResponse::Words).ok_or(ILLEGAL_ADDRESS)
    }

    fn word(&self, table: Table, address: u16) -> Option<u16> {
        let inputs = (self.modbus.inputs_at, self.modbus.inputs.len(), self.inputs);
        let outputs = (self.modbus.outputs_at, self.modbus.outputs.len(), self.outputs);
        let of_bits = [inputs, outputs].into_iter().find_map(|((own, first), bits, value)| {
            let at = usize::from(address.checked_sub(first)?);
            (own == table && at < table.addresses(bits)).then(|| (value >> (at * REGISTER_BITS)) as u16)
        });
        let others = (table == Table::HoldingRegisters).then(|| self.registers.get(&address).copied());
        of_bits.or(others.flatten())
    }

    fn write_coils(&mut self, first: u16, bits: &[bool]) -> Result<ModbusResponse, u8> {
        let (table, own) = self.modbus.outputs_at;
        let start = usize::from(first.checked_sub(own).ok_or(ILLEGAL_ADDRESS)?);
        if table != Table::Coils || start + bits.len() > self.modbus.outputs.len() {
            return Err(ILLEGAL_ADDRESS);
        }
        for (at, on) in (start..).zip(bits) {
            self.outputs = self.outputs & !(1 << at) | u64::from(*on) << at;
        }
        Ok(ModbusResponse::Written)
    }

    fn write_registers(&mut self, now: Tick, first: u16, words: &[u16]) -> Result<ModbusResponse, u8> {
        let addresses: Option<Vec<u16>> =
            (0..words.len()).map(|at| first.checked_add(u16::try_from(at).ok()?)).collect();
        let addresses = addresses.ok_or(ILLEGAL_ADDRESS)?;
        // All of it or nothing.
        let (table, own) = self.modbus.outputs_at;
        let output = |address: u16| {
            let at = usize::from(address.checked_sub(own)?);
            (table == Table::HoldingRegisters && at < table.addresses(self.modbus.outputs.len())).then_some(at)
        };
        if addresses.iter().any(|at| output(*at).is_none() && !self.registers.contains_key(at)) {
            return Err(ILLEGAL_ADDRESS);
        }
        let places: Vec<Option<usize>> = addresses.iter().map(|address| output(*address)).collect();
        for ((address, place), word) in addresses.into_iter().zip(places).zip(words) {
            match place {
                Some(at) => {
                    let shift = at * REGISTER_BITS;
                    self.outputs = self.outputs & !(0xFFFF << shift) | u64::from(*word) << shift;
                }
                None => self.write_register(now, address, *word),
            }
        }
        Ok(ModbusResponse::Written)
    }

    fn write_register(&mut self, now: Tick, address: u16, word: u16) {
        let before = self.registers.insert(address, word);
        if let Some(watchdog) = self.modbus.watchdog.filter(|own| own.register == address && before != Some(word)) {
            self.missed = Some(now + watchdog.timeout);
        }
    }
}
