//! The device's object dictionary, as far as a manager or a technician needs it.
//!
//! Outputs can be read here, never written: they follow process data alone, which stops when the manager does.

use std::time::Duration;

use linewright_fieldbus::codec::{Abort, Message, NodeId, Payload, SdoData, SdoRequest, SdoResponse};
use linewright_line::Tick;

use super::{DeviceNode, DeviceOutbox, Order, State};
use crate::fault::{DeviceFault, FAULT_INDEX, Fault, PRESS_INDEX};

/// Device profile 401 with digital inputs and outputs (CiA 401, object 1000h).
const DEVICE_TYPE: u32 = 0x0003_0191;

impl DeviceNode {
    /// Answers a request. A silent device hears none but the one that ends its silence.
    pub(super) fn serve(&mut self, now: Tick, request: SdoRequest, out: &mut DeviceOutbox) {
        let plug = matches!(request, SdoRequest::Download { index: FAULT_INDEX, sub: 0, .. });
        let deaf = self.silent || matches!(self.state, State::Booting { .. } | State::Stopped);
        if deaf && !(self.silent && plug) {
            return;
        }
        let response = match request {
            SdoRequest::Upload { index, sub } => match self.read(index, sub) {
                Ok(data) => SdoResponse::Uploaded { index, sub, data },
                Err(code) => SdoResponse::Aborted { index, sub, code },
            },
            SdoRequest::Download { index, sub, data } => match self.write(now, index, sub, data, out) {
                Ok(()) => SdoResponse::Downloaded { index, sub },
                Err(code) => SdoResponse::Aborted { index, sub, code },
            },
            // Expedited transfers are over with their answer: there is nothing to give up.
            SdoRequest::Abort { .. } => return,
        };
        // Also the answer that announces the silence is sent: `write` may just have begun it.
        out.frames.push(Message::SdoResponse { node: self.node, response }.encode());
    }

    fn read(&self, index: u16, sub: u8) -> Result<SdoData, Abort> {
        let millis = |span: Duration| span.as_millis().min(0xFFFF) as u16;
        match (index, sub) {
            (0x1000, 0) => Ok(SdoData::u32(DEVICE_TYPE)),
            (0x1001, 0) => Ok(SdoData::u8(self.error_register)),
            (0x1016 | 0x1018, 0) => Ok(SdoData::u8(1)),
            (0x1016, 1) => Ok(SdoData::u32(
                self.watched.map_or(0, |(node, timeout)| u32::from(node.get()) << 16 | u32::from(millis(timeout))),
            )),
            (0x1017, 0) => Ok(SdoData::u16(millis(self.heartbeat))),
            // Identity: no vendor id was ever assigned to a simulation.
            (0x1018, 1) => Ok(SdoData::u32(0)),
            (0x6000, sub) => read_bits(self.inputs, self.input_count, sub),
            (0x6200, sub) => read_bits(self.outputs, self.output_count, sub),
            (FAULT_INDEX | PRESS_INDEX, _) => Err(Abort::WRITE_ONLY),
            (0x1000 | 0x1001 | 0x1016..=0x1018, _) => Err(Abort::NO_SUBINDEX),
            _ => Err(Abort::NO_OBJECT),
        }
    }

    fn write(&mut self, now: Tick, index: u16, sub: u8, data: SdoData, out: &mut DeviceOutbox) -> Result<(), Abort> {
        match (index, sub) {
            (0x1016, 1) => self.write_watched(now, data),
            (0x1017, 0) => {
                expect_len(data, 2)?;
                self.heartbeat = Duration::from_millis(data.value().into());
                self.schedule_heartbeat(now);
                Ok(())
            }
            (FAULT_INDEX, 0) => {
                let fault = DeviceFault::from_code(data.value())?;
                if fault.is_none() {
                    out.orders.push(Order::ClearAll);
                }
                self.inject(now, fault);
                Ok(())
            }
            (FAULT_INDEX, sub) => {
                let output = bit_of(sub, self.output_count)?;
                out.orders.push(Order::Fail { output, fault: Fault::from_code(data.value())? });
                Ok(())
            }
            (PRESS_INDEX, sub) => {
                let input = bit_of(sub, self.input_count)?;
                let value = match data.value() {
                    0 => Some(false),
                    1 => Some(true),
                    2 => None,
                    _ => return Err(Abort::VALUE),
                };
                out.orders.push(Order::Press { input, value });
                Ok(())
            }
            // Whatever else can be read cannot be written.
            _ => Err(self.read(index, sub).err().unwrap_or(Abort::READ_ONLY)),
        }
    }

    /// Object 1016h sub 1: node id in bits 16 to 23, time in ms below; 0 in either switches the watch off.
    fn write_watched(&mut self, now: Tick, data: SdoData) -> Result<(), Abort> {
        expect_len(data, 4)?;
        let [low, high, node, reserved] = data.value().to_le_bytes();
        if reserved != 0 || node > 127 {
            return Err(Abort::VALUE);
        }
        let timeout = Duration::from_millis(u16::from_le_bytes([low, high]).into());
        self.watched = NodeId::new(node).filter(|_| !timeout.is_zero()).map(|node| (node, timeout));
        // The standard starts the watch with the first heartbeat. Here it starts at once: who configures the watch
        // is there, and if it goes away before its first heartbeat that is a loss too.
        self.lost_at = self.watched.map(|(_, timeout)| now + timeout);
        Ok(())
    }
}

fn expect_len(data: SdoData, len: usize) -> Result<(), Abort> {
    if data.bytes().len() == len { Ok(()) } else { Err(Abort::LENGTH) }
}

/// Objects 6000h and 6200h: subindex 0 is the number of bytes, subindex n byte n − 1.
fn read_bits(bits: u64, count: usize, sub: u8) -> Result<SdoData, Abort> {
    if count == 0 {
        return Err(Abort::NO_OBJECT);
    }
    let payload = Payload::from_bits(bits, count);
    match usize::from(sub).checked_sub(1) {
        None => Ok(SdoData::u8(payload.bytes().len() as u8)),
        Some(at) => payload.bytes().get(at).map(|byte| SdoData::u8(*byte)).ok_or(Abort::NO_SUBINDEX),
    }
}

/// Subindex n is bit n − 1.
fn bit_of(sub: u8, count: usize) -> Result<usize, Abort> {
    usize::from(sub).checked_sub(1).filter(|bit| *bit < count).ok_or(Abort::NO_SUBINDEX)
}
