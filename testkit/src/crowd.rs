//! Many devices in their simplest form, and a manager that has brought them up: for figures and counters.
//!
//! The devices take every setting, are of the requested profile, and send the frames required. They share nothing with
//! those of the simulated plant.

use std::time::Duration;

use linewright_canopen::codec::{NmtCommand, NmtState, Payload};
use linewright_canopen::manager::BusOutbox;
use linewright_canopen::sdo::ObjectId;
use linewright_canopen::sdo::wire::{ClientFrame, SdoBytes};
use linewright_canopen::{BusEvent, CanopenMessage, Frame, Manager, NodeId};
use linewright_line::{Device, DeviceBus, DeviceKind, InputId, OutputId, Owner, StationId, Tick, Timing};

/// Bits that each device has in each direction.
pub const BITS: u16 = 16;
/// Devices of one owner at most: what its image holds.
pub const OF_ONE_OWNER: u16 = 4;

/// The devices 1 to `count`, four of them at a station.
pub fn devices(count: u8) -> Vec<Device> {
    (1..=count).map(device).collect()
}

fn device(id: u8) -> Device {
    let first = (u16::from(id) - 1) % OF_ONE_OWNER * BITS;
    Device {
        name: format!("io {id}"),
        owner: owner(id),
        bus: DeviceBus::Line,
        kind: DeviceKind::io(
            id,
            (first..first + BITS).map(|bit| Some(InputId(bit))).collect(),
            (first..first + BITS).map(|bit| Some(OutputId(bit))).collect(),
        ),
    }
}

/// The owner of that device.
pub fn owner(id: u8) -> Owner {
    Owner::Station(StationId((u16::from(id) - 1) / OF_ONE_OWNER))
}

/// Offset of a device's bits in its owner's image.
pub fn shift(id: u8) -> u16 {
    (u16::from(id) - 1) % OF_ONE_OWNER * BITS
}

/// Answer of a device to a frame, if it is for it.
pub fn answer(frame: &Frame) -> Option<Frame> {
    match CanopenMessage::decode(frame) {
        Ok(CanopenMessage::SdoRequest { node, raw }) => {
            Some(CanopenMessage::SdoResponse { node, raw: answer_raw(&raw)? }.encode())
        }
        Ok(CanopenMessage::Nmt { command: NmtCommand::Start, node: Some(node) }) => Some(inputs(node.get(), 0)),
        _ => None,
    }
}

/// It is a generic I/O device, has no error, and takes whatever it is written in one frame.
fn answer_raw(raw: &SdoBytes) -> Option<SdoBytes> {
    let [_, low, high, sub, ..] = *raw;
    match ClientFrame::decode(raw)? {
        // No error, and the error behaviour is as written.
        ClientFrame::Upload { object: ObjectId { index: 0x1001 | 0x1029 | 0x6207, .. } } => {
            Some([0x4F, low, high, sub, 0, 0, 0, 0])
        }
        ClientFrame::Upload { object: ObjectId { index: 0x6206, .. } } => Some([0x4F, low, high, sub, 0xFF, 0, 0, 0]),
        ClientFrame::Upload { .. } => Some([0x43, low, high, sub, 0x91, 0x01, 0x03, 0]),
        ClientFrame::Download { .. } => Some([0x60, low, high, sub, 0, 0, 0, 0]),
        _ => None,
    }
}

pub fn inputs(id: u8, bits: u64) -> Frame {
    CanopenMessage::Tpdo1 { node: node(id), payload: Payload::from_bits(bits, BITS.into()) }.encode()
}

pub fn heartbeat(id: u8) -> Frame {
    CanopenMessage::Heartbeat { node: node(id), state: NmtState::Operational }.encode()
}

pub fn node(id: u8) -> NodeId {
    NodeId::new(id).expect("devices have ids from 1 to 126")
}

/// A manager and its devices, the time, and its output.
pub struct Crowd {
    pub manager: Manager,
    pub now: Tick,
    /// Frames and events since the last [`Crowd::forget`].
    pub out: BusOutbox,
}

impl Crowd {
    /// A manager that has brought up `count` devices.
    pub fn up(count: u8) -> Self {
        let manager = Manager::new(&devices(count), Timing::default()).expect("their ids are right");
        let mut crowd = Crowd { manager, now: Tick::from_millis(1000), out: BusOutbox::default() };
        let mut up = 0;
        while up < count {
            crowd.manager.poll(crowd.now, &mut crowd.out);
            for frame in std::mem::take(&mut crowd.out.frames) {
                if let Some(answer) = answer(&frame) {
                    crowd.manager.handle(crowd.now, &answer, &mut crowd.out);
                }
            }
            up += crowd.out.events.drain(..).filter(|event| matches!(event, BusEvent::DeviceUp { .. })).count() as u8;
            crowd.now = crowd.now + Duration::from_millis(1);
            let valid = (1..=count).all(|id| up < count || crowd.manager.inputs(crowd.now, owner(id)).valid);
            assert!(valid, "a device that is up is not trusted");
            assert!(crowd.now < Tick::from_millis(9000), "{up} of {count} devices are up");
            for id in 1..=count {
                crowd.manager.handle(crowd.now, &heartbeat(id), &mut crowd.out);
            }
        }
        // Frames waiting for their turn go.
        crowd.tenth(count, 0);
        crowd
    }

    pub fn hear(&mut self, frame: &Frame) {
        self.manager.handle(self.now, frame, &mut self.out);
    }

    /// Discards its output.
    pub fn forget(&mut self) {
        self.out.frames.clear();
        self.out.events.clear();
    }

    /// A tenth of a second as a busy line has it: each device sends its inputs, changed, once and its heartbeat twice;
    /// each owner sets its outputs ten times, every other time to something new. Gives the number of frames received
    /// and sent.
    pub fn tenth(&mut self, count: u8, round: u64) -> usize {
        let mut frames = 0;
        for milli in 0..100u64 {
            self.manager.poll(self.now, &mut self.out);
            for id in 1..=count {
                if (u64::from(id) + milli) % 50 == 0 {
                    self.hear(&heartbeat(id));
                    frames += 1;
                }
                if u64::from(id) % 100 == milli {
                    self.hear(&inputs(id, round ^ u64::from(id)));
                    frames += 1;
                }
                if id % OF_ONE_OWNER as u8 == 1 && (u64::from(id) + milli) % 10 == 0 {
                    let image = u128::from(round + milli / 20) << (milli % 64);
                    self.manager.set_outputs(self.now, owner(id), image, &mut self.out);
                }
            }
            frames += self.out.frames.len();
            self.forget();
            self.now = self.now + Duration::from_millis(1);
        }
        frames
    }
}
