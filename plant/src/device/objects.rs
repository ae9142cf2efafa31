//! The device's object dictionary, as far as a manager or a technician needs it.
//!
//! Outputs can be read here, never written: they follow process data alone, which stops when the manager does. What
//! belongs together is answered by its own part: identity, PDO parameters, behaviour on errors.

use std::borrow::Cow;
use std::time::Duration;

use linewright_fieldbus::codec::{Abort, Message, NodeId, Payload};
use linewright_fieldbus::sdo::wire::{Raw, Request};
use linewright_fieldbus::sdo::{Dictionary, ObjectId, Server};
use linewright_line::Tick;

use super::{DeviceNode, DeviceOutbox, Order, State, identity};
use crate::fault::{DeviceFault, FAULT_INDEX, Fault, PRESS_INDEX};

/// Device profile 401 with digital inputs and outputs (CiA 401, object 1000h).
const DEVICE_TYPE: u32 = 0x0003_0191;
/// Bytes of an object written at most; all of them are shorter.
pub(super) const LEN_MAX: usize = 64;

/// A device, as its server reaches it while it answers one frame.
struct Objects<'a> {
    device: &'a mut DeviceNode,
    now: Tick,
    out: &'a mut DeviceOutbox,
}

impl Dictionary for Objects<'_> {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        self.device.read(object).map(Cow::Owned)
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        self.device.write(self.now, object, data, self.out)
    }

    fn may_write(&mut self, object: ObjectId, _len: Option<usize>) -> Result<(), Abort> {
        // One that is not there says so before its bytes come.
        match self.device.read(object) {
            Err(code) if code != Abort::WRITE_ONLY => Err(code),
            _ => Ok(()),
        }
    }
}

impl DeviceNode {
    /// Answers a request. A silent device hears none but the one that ends its silence.
    pub(super) fn serve(&mut self, now: Tick, raw: &Raw, out: &mut DeviceOutbox) {
        let plug = matches!(
            Request::decode(raw),
            Some(Request::Download { object: ObjectId { index: FAULT_INDEX, sub: 0 }, .. })
        );
        let deaf = self.silent || matches!(self.state, State::Booting { .. } | State::Stopped);
        if deaf && !(self.silent && plug) {
            return;
        }
        let mut answers = Vec::new();
        // The server cannot be part of the device it serves while it does.
        let mut server = std::mem::replace(&mut self.server, Server::new(0));
        server.handle(now, raw, &mut Objects { device: self, now, out }, &mut answers);
        self.server = server;
        // Also the answer that announces the silence is sent: `write` may just have begun it.
        self.answer(answers, out);
    }

    /// Does what is due in a transfer.
    pub(super) fn poll_server(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let mut answers = Vec::new();
        self.server.poll(now, &mut answers);
        if !self.silent {
            self.answer(answers, out);
        }
    }

    fn answer(&self, answers: Vec<Raw>, out: &mut DeviceOutbox) {
        out.frames.extend(answers.into_iter().map(|raw| Message::SdoResponse { node: self.node, raw }.encode()));
    }

    fn read(&self, object: ObjectId) -> Result<Vec<u8>, Abort> {
        let parts = identity::read(self.node, object).or_else(|| self.on_error.read(object));
        if let Some(answer) = parts.or_else(|| self.inputs_pdo.read(object)).or_else(|| self.outputs_pdo.read(object)) {
            return answer;
        }
        let millis = |span: Duration| span.as_millis().min(0xFFFF) as u16;
        match (object.index, object.sub) {
            (0x1000, 0) => Ok(DEVICE_TYPE.to_le_bytes().into()),
            (0x1001, 0) => Ok(vec![self.error_register]),
            (0x1016, 0) => Ok(vec![1]),
            (0x1016, 1) => {
                let watch = |(node, timeout): (NodeId, _)| u32::from(node.get()) << 16 | u32::from(millis(timeout));
                Ok(self.watched.map_or(0, watch).to_le_bytes().into())
            }
            (0x1017, 0) => Ok(millis(self.heartbeat).to_le_bytes().into()),
            (0x6000, sub) => read_bits(self.inputs, self.input_count, sub),
            (0x6200, sub) => read_bits(self.outputs, self.output_count, sub),
            (FAULT_INDEX | PRESS_INDEX, _) => Err(Abort::WRITE_ONLY),
            (0x1000 | 0x1001 | 0x1016 | 0x1017, _) => Err(Abort::NO_SUBINDEX),
            _ => Err(Abort::NO_OBJECT),
        }
    }

    fn write(&mut self, now: Tick, object: ObjectId, data: &[u8], out: &mut DeviceOutbox) -> Result<(), Abort> {
        if let Some(answer) = self.on_error.write(object, data).or_else(|| self.outputs_pdo.write(object, data)) {
            return answer;
        }
        if let Some(answer) = self.inputs_pdo.write(object, data) {
            // A PDO that was switched on, or told to come by itself, begins to.
            if answer.is_ok() && self.inputs_pdo.by_event() {
                self.send_inputs(now, out);
            }
            return answer;
        }
        match (object.index, object.sub) {
            (0x1016, 1) => self.write_watched(now, data),
            (0x1017, 0) => {
                self.heartbeat = Duration::from_millis(u16::from_le_bytes(exactly(data)?).into());
                self.schedule_heartbeat(now);
                Ok(())
            }
            (FAULT_INDEX, 0) => {
                let fault = DeviceFault::from_code(number(data)?)?;
                if fault.is_none() {
                    out.orders.push(Order::ClearAll);
                }
                self.inject(now, fault);
                Ok(())
            }
            (FAULT_INDEX, sub) => {
                let output = bit_of(sub, self.output_count)?;
                out.orders.push(Order::Fail { output, fault: Fault::from_code(number(data)?)? });
                Ok(())
            }
            (PRESS_INDEX, sub) => {
                let input = bit_of(sub, self.input_count)?;
                let value = match number(data)? {
                    0 => Some(false),
                    1 => Some(true),
                    2 => None,
                    _ => return Err(Abort::VALUE),
                };
                out.orders.push(Order::Press { input, value });
                Ok(())
            }
            // Whatever else can be read cannot be written.
            _ => Err(self.read(object).err().unwrap_or(Abort::READ_ONLY)),
        }
    }

    /// Object 1016h sub 1: node id in bits 16 to 23, time in ms below; 0 in either switches the watch off.
    fn write_watched(&mut self, now: Tick, data: &[u8]) -> Result<(), Abort> {
        let [low, high, node, reserved] = exactly(data)?;
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

/// The bytes of an object of `N` bytes.
pub(super) fn exactly<const N: usize>(data: &[u8]) -> Result<[u8; N], Abort> {
    data.try_into().map_err(|_| Abort::LENGTH)
}

/// A number of one to four bytes: the simulation's own objects are not particular about their size.
fn number(data: &[u8]) -> Result<u32, Abort> {
    let mut bytes = [0; 4];
    bytes.get_mut(..data.len()).filter(|b| !b.is_empty()).ok_or(Abort::LENGTH)?.copy_from_slice(data);
    Ok(u32::from_le_bytes(bytes))
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

/// Subindex n is bit n − 1.
fn bit_of(sub: u8, count: usize) -> Result<usize, Abort> {
    usize::from(sub).checked_sub(1).filter(|bit| *bit < count).ok_or(Abort::NO_SUBINDEX)
}
