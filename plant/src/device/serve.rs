//! A device's objects behind its SDO server.

use std::borrow::Cow;

use linewright_canopen::codec::{Abort, CanopenMessage};
use linewright_canopen::sdo::wire::{ClientFrame, SdoBytes};
use linewright_canopen::sdo::{Dictionary, ObjectId, SdoServer};
use linewright_line::Tick;

use super::comm::{Comm, CommState};
use super::trouble::TroubleEffect;
use super::{CanDevice, DeviceOutbox, PlantEffect};
use crate::fault::{FAULT_INDEX, SIMULATED, SIMULATED_INDEX, TROUBLE_INDEX};

/// A device with an object dictionary.
pub(super) trait ObjectServer: CanDevice {
    /// Its share of CANopen.
    fn comm(&mut self) -> &mut Comm;

    fn read(&self, now: Tick, object: ObjectId) -> Result<Vec<u8>, Abort>;

    fn write(&mut self, now: Tick, object: ObjectId, data: &[u8], out: &mut DeviceOutbox) -> Result<(), Abort>;
}

/// A device, as its server reaches it while it answers one frame.
struct ServedObjects<'a, D> {
    device: &'a mut D,
    now: Tick,
    out: &'a mut DeviceOutbox,
}

impl<D: ObjectServer> Dictionary for ServedObjects<'_, D> {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        if object.index == TROUBLE_INDEX {
            return Err(Abort::WRITE_ONLY);
        }
        if object.index == SIMULATED_INDEX {
            let is_there = object.sub == 0;
            return if is_there { Ok(SIMULATED.to_le_bytes().to_vec().into()) } else { Err(Abort::NO_SUBINDEX) };
        }
        let own = self.device.read(self.now, object);
        // Of another number as many bytes as the object has.
        let instead = self.device.comm().trouble.read(object).map(|answer| match (answer, &own) {
            (Ok(number), Ok(own)) => Ok(number.into_iter().chain(std::iter::repeat(0)).take(own.len()).collect()),
            (answer, _) => answer,
        });
        instead.unwrap_or(own).map(Cow::Owned)
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        if object.index == TROUBLE_INDEX {
            return write_trouble(self.device, self.now, object.sub, data, self.out);
        }
        if object.index == SIMULATED_INDEX {
            return Err(Abort::READ_ONLY);
        }
        match self.device.comm().trouble.refuses(object) {
            Some(code) => Err(code),
            None => self.device.write(self.now, object, data, self.out),
        }
    }

    fn may_write(&mut self, object: ObjectId, _len: Option<usize>) -> Result<(), Abort> {
        // A missing object is refused before its bytes come.
        if let Some(code) = self.device.comm().trouble.refuses(object) {
            return Err(code);
        }
        match self.device.read(self.now, object) {
            _ if object.index == TROUBLE_INDEX => Ok(()),
            _ if object.index == SIMULATED_INDEX => Err(Abort::READ_ONLY),
            Err(code) if code != Abort::WRITE_ONLY => Err(code),
            _ => Ok(()),
        }
    }
}

/// Object 5F02h is written.
pub(super) fn write_trouble<D: ObjectServer>(
    device: &mut D,
    now: Tick,
    sub: u8,
    data: &[u8],
    out: &mut DeviceOutbox,
) -> Result<(), Abort> {
    match device.comm().trouble.write(now, sub, data)? {
        TroubleEffect::None => {}
        TroubleEffect::Inject(fault) => device.inject(now, Some(fault)),
        TroubleEffect::Disturb(faults) => out.orders.push(PlantEffect::Disturb(faults)),
    }
    Ok(())
}

/// Answers a request. A silent device takes none but the one that ends its silence, and that for whether it is simulated.
pub(super) fn serve<D: ObjectServer>(device: &mut D, now: Tick, raw: &SdoBytes, out: &mut DeviceOutbox) {
    let plug = matches!(
        ClientFrame::decode(raw),
        Some(
            ClientFrame::Download { object: ObjectId { index: FAULT_INDEX, sub: 0 }, .. }
                | ClientFrame::Upload { object: ObjectId { index: SIMULATED_INDEX, sub: 0 } }
        )
    );
    let comm = device.comm();
    let mute = comm.trouble.is_mute();
    let deaf = mute || matches!(comm.state, CommState::Booting { .. } | CommState::Stopped);
    if deaf && !(mute && plug) {
        return;
    }
    let mut answers = Vec::new();
    // The server cannot be part of the device it serves while it does.
    let mut server = std::mem::replace(&mut comm.server, SdoServer::new(0));
    server.handle(now, raw, &mut ServedObjects { device, now, out }, &mut answers);
    let comm = device.comm();
    comm.server = server;
    // Also the answer that announces the silence is sent: `write` may just have begun it.
    answer(comm, answers, out);
}

/// Does what is due in a transfer.
pub(super) fn poll(comm: &mut Comm, now: Tick, out: &mut DeviceOutbox) {
    let mut answers = Vec::new();
    comm.server.poll(now, &mut answers);
    if !comm.trouble.is_mute() {
        answer(comm, answers, out);
    }
}

fn answer(comm: &Comm, answers: Vec<SdoBytes>, out: &mut DeviceOutbox) {
    out.frames.extend(answers.into_iter().map(|raw| CanopenMessage::SdoResponse { node: comm.node, raw }.encode()));
}
