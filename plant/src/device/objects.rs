//! The device's object dictionary, as far as a manager or a technician needs it.
//!
//! Outputs can be read here, never written: they follow process data alone, which stops when the manager does. What
//! belongs together is answered by its own part: identity, PDO parameters, behaviour on errors.

use linewright_canopen::codec::{Abort, Payload};
use linewright_canopen::sdo::ObjectId;
use linewright_line::{HolderId, Tick};

use super::bytes::number;
use super::comm::Comm;
use super::serve::ObjectServer;
use super::{CanDevice, DeviceNode, DeviceOutbox, PlantEffect, identity};
use crate::by_hand::PartByHand;
use crate::fault::{
    DeviceFault, FAULT_INDEX, HOLD_INDEX, HeldFaults, MotionFault, PRESS_INDEX, PUT_INDEX, STUCK_INDEX, TAKE_INDEX,
};
use crate::parts::NestPosition;

/// Device profile 401 with digital inputs and outputs (CiA 401, object 1000h).
const DEVICE_TYPE: u32 = 0x0003_0191;

impl ObjectServer for DeviceNode {
    fn comm(&mut self) -> &mut Comm {
        &mut self.comm
    }

    fn read(&self, _: Tick, object: ObjectId) -> Result<Vec<u8>, Abort> {
        let parts = identity::read(self.comm.node, object)
            .or_else(|| self.on_error.read(object))
            .or_else(|| self.comm.read(object))
            .or_else(|| self.sync_watch.read(object));
        if let Some(answer) = parts
            .or_else(|| self.channels.read(object))
            .or_else(|| self.inputs_pdo.read(object))
            .or_else(|| self.outputs_pdo.read(object))
        {
            return answer;
        }
        match (object.index, object.sub) {
            (0x1000, 0) => Ok((DEVICE_TYPE | self.channels.device_type()).to_le_bytes().into()),
            (0x1001, 0) => Ok(vec![self.comm.register()]),
            (0x6000, sub) => read_bits(self.inputs, self.input_count, sub),
            (0x6200, sub) => read_bits(self.outputs, self.output_count, sub),
            (HOLD_INDEX, _) if self.channels.measures() => Err(Abort::WRITE_ONLY),
            (TAKE_INDEX, 0) => Ok(vec![self.part_outcome]),
            (FAULT_INDEX | PRESS_INDEX | STUCK_INDEX | TAKE_INDEX | PUT_INDEX, _) => Err(Abort::WRITE_ONLY),
            (0x1000 | 0x1001, _) => Err(Abort::NO_SUBINDEX),
            _ => Err(Abort::NO_OBJECT),
        }
    }

    fn faults(&mut self) -> u16 {
        self.comm.trouble.count().saturating_add(self.held.count())
    }

    fn write(&mut self, now: Tick, object: ObjectId, data: &[u8], out: &mut DeviceOutbox) -> Result<(), Abort> {
        if let Some(answer) = self.channels.write(object, data) {
            if answer.is_ok() {
                if let Ok(value) = number(data) {
                    self.held.note(((object.index, object.sub), value));
                }
                self.poll_channels(now, out);
            }
            return answer;
        }
        if let Some(answer) = self.on_error.write(object, data).or_else(|| self.outputs_pdo.write(object, data)) {
            return answer;
        }
        if let Some(answer) = self.inputs_pdo.write(object, data) {
            // A PDO that was switched on, or set to be event-driven, begins to come.
            if answer.is_ok() && self.inputs_pdo.by_event() {
                self.send_inputs(now, out);
            }
            return answer;
        }
        if let Some(answer) = self.sync_watch.write(object, data).or_else(|| self.comm.write(now, object, data)) {
            return answer;
        }
        match (object.index, object.sub) {
            (FAULT_INDEX, 0) => {
                let fault = DeviceFault::from_code(number(data)?)?;
                if fault.is_none() {
                    out.orders.push(PlantEffect::ClearAll);
                    self.held = HeldFaults::default();
                }
                self.inject(now, fault);
                Ok(())
            }
            (FAULT_INDEX | PRESS_INDEX | STUCK_INDEX | TAKE_INDEX | PUT_INDEX, _) => {
                let place = (object.index, object.sub);
                let value = number(data)?;
                out.orders.push(PlantEffect::of(place, value, self.input_count, self.output_count)?);
                self.held.note((place, value));
                Ok(())
            }
            // Whatever else can be read cannot be written.
            _ => Err(self.read(now, object).err().unwrap_or(Abort::READ_ONLY)),
        }
    }
}

impl PlantEffect {
    /// What a number means for one bit of a device with so many inputs and outputs: in 5F00h (but for subindex 0, which is the
    /// device itself), 5F01h, 5F03h, 5F08h and 5F09h.
    pub fn of((index, sub): (u16, u8), value: u32, inputs: usize, outputs: usize) -> Result<Self, Abort> {
        match index {
            FAULT_INDEX => {
                let output = bit_of(sub, outputs)?;
                Ok(PlantEffect::Fail { output, fault: MotionFault::from_code(value)? })
            }
            PRESS_INDEX => Ok(PlantEffect::Press { input: bit_of(sub, inputs)?, value: held(value)? }),
            STUCK_INDEX => Ok(PlantEffect::Stick { output: bit_of(sub, outputs)?, value: held(value)? }),
            TAKE_INDEX | PUT_INDEX => {
                let nest = HolderId::at(usize::from(sub.checked_sub(1).ok_or(Abort::NO_SUBINDEX)?));
                let position = u16::try_from(value).map_err(|_| Abort::VALUE)?;
                let what = if index == TAKE_INDEX { PartByHand::Take } else { PartByHand::Put };
                Ok(PlantEffect::Part(what, NestPosition { nest, position }))
            }
            _ => Err(Abort::NO_OBJECT),
        }
    }
}

/// Objects 6000h and 6200h: subindex 0 is the number of bytes, subindex n byte n − 1.
fn read_bits(bits: u64, count: usize, sub: u8) -> Result<Vec<u8>, Abort> {
    if count == 0 {
        return Err(Abort::NO_OBJECT);
    }
    let payload = Payload::from_bits(bits, count);
    match usize::from(sub).checked_sub(1) {
        None => Ok(vec![payload.bytes().len() as u8]),
        Some(at) => payload.bytes().get(at).map(|byte| vec![*byte]).ok_or(Abort::NO_SUBINDEX),
    }
}

/// At which value a bit is held: 0 off, 1 on, 2 at none.
fn held(code: u32) -> Result<Option<bool>, Abort> {
    match code {
        0 => Ok(Some(false)),
        1 => Ok(Some(true)),
        2 => Ok(None),
        _ => Err(Abort::VALUE),
    }
}

/// Subindex n is bit n − 1.
fn bit_of(sub: u8, count: usize) -> Result<usize, Abort> {
    usize::from(sub).checked_sub(1).filter(|bit| *bit < count).ok_or(Abort::NO_SUBINDEX)
}
