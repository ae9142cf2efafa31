//! A device's objects behind its SDO server.

use std::borrow::Cow;

use linewright_canopen::codec::{Abort, CanopenMessage};
use linewright_canopen::sdo::wire::{ClientFrame, SdoBytes};
use linewright_canopen::sdo::{Dictionary, ObjectId, SdoServer};
use linewright_line::Tick;

use super::comm::{Comm, CommState};
use super::trouble::TroubleEffect;
use super::{CanDevice, DeviceOutbox, PlantEffect};
use crate::fault::{FAULT_INDEX, FAULTS_INDEX, PART_OF_INDEX, SIMULATED, SIMULATED_INDEX, TROUBLE_INDEX};

/// A device with an object dictionary.
pub(super) trait ObjectServer: CanDevice {
    /// Its share of CANopen.
    fn comm(&mut self) -> &mut Comm;

    fn read(&self, now: Tick, object: ObjectId) -> Result<Vec<u8>, Abort>;

    fn write(&mut self, now: Tick, object: ObjectId, data: &[u8], out: &mut DeviceOutbox) -> Result<(), Abort>;

    /// Number of injected faults that hold in it.
    fn faults(&mut self) -> u16;
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
        if is_about_simulation(object.index) {
            return about_simulation(self.device, object).map(Cow::Owned);
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
        if is_about_simulation(object.index) {
            return Err(Abort::READ_ONLY);
        }
        if let Some(code) = self.device.comm().trouble.refuses(object) {
            return Err(code);
        }
        self.device.write(self.now, object, data, self.out)
    }

    fn may_write(&mut self, object: ObjectId, _len: Option<usize>) -> Result<(), Abort> {
        // A missing object is refused before its bytes come.
        if let Some(code) = self.device.comm().trouble.refuses(object) {
            return Err(code);
        }
        match self.device.read(self.now, object) {
            _ if object.index == TROUBLE_INDEX => Ok(()),
            _ if is_about_simulation(object.index) => Err(Abort::READ_ONLY),
            Err(code) if code != Abort::WRITE_ONLY => Err(code),
            _ => Ok(()),
        }
    }
}

/// Whether this object is about the simulation itself: read only, and answered in every state but a boot.
const fn is_about_simulation(index: u16) -> bool {
    matches!(index, SIMULATED_INDEX | PART_OF_INDEX | FAULTS_INDEX)
}

/// The value of such an object.
fn about_simulation(device: &mut impl ObjectServer, ObjectId { index, sub }: ObjectId) -> Result<Vec<u8>, Abort> {
    match index {
        _ if sub != 0 => Err(Abort::NO_SUBINDEX),
        PART_OF_INDEX => Ok(device.comm().part_of.as_bytes().to_vec()),
        FAULTS_INDEX => Ok(device.faults().to_le_bytes().to_vec()),
        _ => Ok(SIMULATED.to_le_bytes().to_vec()),
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

/// Whether a silent device answers a request: the one that ends its silence, and those about the simulation.
fn is_for_silent(request: &ClientFrame, server: &SdoServer) -> bool {
    match request {
        ClientFrame::Download { object, .. } => *object == ObjectId::new(FAULT_INDEX, 0),
        ClientFrame::Upload { object } => is_about_simulation(object.index),
        ClientFrame::UploadSegment { .. } => server.under_way().is_some_and(|object| is_about_simulation(object.index)),
        _ => false,
    }
}

/// Answers a request. A silent device answers few, and a device that boots or is stopped none.
pub(super) fn serve<D: ObjectServer>(device: &mut D, now: Tick, raw: &SdoBytes, out: &mut DeviceOutbox) {
    let comm = device.comm();
    let mute = comm.trouble.is_mute();
    let deaf = mute || matches!(comm.state, CommState::Booting { .. } | CommState::Stopped);
    let plug = mute && ClientFrame::decode(raw).is_some_and(|request| is_for_silent(&request, &comm.server));
    if deaf && !plug {
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
