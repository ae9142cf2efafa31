//! Devices of the simulated plant, to which anything may be sent, played from a script of bytes: by a property test and
//! by the fuzz target.
//!
//! Whatever comes from the bus: the outputs of an I/O device are those of the last process data that were sent to it, or
//! off. A drive to which no process data are sent, and in whose objects nothing is written, does not move. What one
//! frame is answered with is bounded.
//!
//! Frames that a script may not send: service data that write the outputs themselves, their error values, or faults,
//! and for the drive process data. All of these are meant to have an effect.

use std::time::Duration;

use linewright_canopen::sdo::wire::ClientFrame;
use linewright_canopen::{CanopenMessage, Frame, NodeId};
use linewright_line::{Drive, Tick, Timing};
use linewright_plant::{CanDevice, DeviceNode, DeviceOutbox, DriveNode};

use crate::manager_frames::drive;

const IO: u8 = 4;
const DRIVE: u8 = 5;
const BITS: usize = 10;
/// Most frames in answer to one frame: a block of a long object, an emergency, inputs.
const FRAMES_MAX: usize = 160;

/// Two devices.
pub struct DeviceBench {
    io: DeviceNode,
    drive: DriveNode,
    now: Tick,
    /// The process data last sent to the I/O device.
    sent: u64,
    place: i64,
    /// Number of times an output was on.
    pub energised: usize,
}

impl DeviceBench {
    /// Switched on and booted.
    pub fn set_up() -> Self {
        let now = Tick::from_millis(1000);
        let timing = Timing::default();
        let node = |id| NodeId::new(id).expect("a node id");
        let drive = DriveNode::new(now, node(DRIVE), &Drive { fault: None, homing: None, ..drive() }, 10.0, &timing);
        let place = drive.place(now);
        let io = DeviceNode::new(now, node(IO), BITS, BITS, &timing);
        let mut bench = DeviceBench { io, drive, now, sent: 0, place: place as i64, energised: 0 };
        bench.pass(Duration::from_millis(30));
        bench
    }

    /// Plays a script to its end.
    pub fn play(&mut self, script: &[u8]) {
        let mut script = script.iter().copied();
        while let Some(op) = script.next() {
            let mut byte = || script.next().unwrap_or(0);
            let arg = op >> 4;
            let node = u16::from([IO, DRIVE][usize::from(arg) % 2]);
            match op & 0x0F {
                0 | 1 => self.hear(0x000, &[0x01, node as u8]),
                2 => self.hear(0x77F, &[0x05]),
                3 | 4 => {
                    let data: Vec<u8> = (0..arg % 4).map(|_| byte()).collect();
                    self.hear(0x200 | u16::from(IO), &data);
                }
                5 => self.pass(Duration::from_millis(u64::from(arg) * u64::from(arg))),
                6 => self.hear(0x000, &[byte(), node as u8]),
                7 => self.hear(0x080, &[]),
                8..=10 => {
                    let data: [u8; 8] = std::array::from_fn(|_| byte());
                    self.hear(0x600 | node, &data);
                }
                // A read of something that is there, and the segments or blocks of it.
                11 => {
                    let [low, high] =
                        [0x1000u16, 0x1008, 0x1018, 0x1800, 0x6200, 0x6041][usize::from(arg) % 6].to_le_bytes();
                    let how = if arg < 8 { 0x40 } else { 0xA4 };
                    self.hear(0x600 | node, &[how, low, high, byte() % 6, 127, 0, 0, 0]);
                }
                12 => self.hear(
                    0x600 | node,
                    &[[0x60, 0x70, 0xA3, 0xA2, 0xA1, 0x80][usize::from(byte()) % 6], arg, 127, 0, 0, 0, 0, 0],
                ),
                13 => self.io.set_inputs(self.now, u64::from(byte()), &mut DeviceOutbox::default()),
                14 => {
                    let id = u16::from(byte()) << 8 | u16::from(byte());
                    let data: Vec<u8> = (0..arg.min(8)).map(|_| byte()).collect();
                    self.hear(id & 0x7FF, &data);
                }
                _ => {
                    let mut bytes: [u8; 16] = std::array::from_fn(|_| byte());
                    bytes[4] %= 9;
                    if let Ok(frame) = Frame::from_bytes(&bytes) {
                        self.hear_frame(&frame);
                    }
                }
            }
        }
    }

    fn hear(&mut self, id: u16, data: &[u8]) {
        self.hear_frame(&Frame::data_frame(id, data).expect("11 bits, 8 bytes"));
    }

    /// A frame from the bus.
    pub fn hear_frame(&mut self, frame: &Frame) {
        match CanopenMessage::decode(frame) {
            Ok(CanopenMessage::Rpdo1 { node, .. }) if node.get() == DRIVE => return,
            Ok(CanopenMessage::Rpdo1 { node, payload }) if node.get() == IO && payload.bytes().len() * 8 >= BITS => {
                self.sent = payload.bits() & ((1 << BITS) - 1);
            }
            Ok(CanopenMessage::SdoRequest { node, raw }) if is_meant(node.get(), &raw) => return,
            _ => {}
        }
        let mut out = [DeviceOutbox::default(), DeviceOutbox::default()];
        self.io.handle(self.now, frame, &mut out[0]);
        self.drive.handle(self.now, frame, &mut out[1]);
        self.check(&out);
    }

    /// Lets time pass.
    pub fn pass(&mut self, span: Duration) {
        let until = self.now + span;
        while let Some(due) =
            self.io.next_deadline().into_iter().chain(self.drive.next_deadline()).min().filter(|due| *due <= until)
        {
            self.now = self.now.max(due);
            let mut out = [DeviceOutbox::default(), DeviceOutbox::default()];
            self.io.poll(self.now, &mut out[0]);
            self.drive.poll(self.now, &mut out[1]);
            self.check(&out);
        }
        self.now = until;
    }

    fn check(&mut self, out: &[DeviceOutbox; 2]) {
        for out in out {
            assert!(out.frames.len() <= FRAMES_MAX, "{} frames", out.frames.len());
            assert!(out.orders.is_empty(), "{:?} without having been told", out.orders);
        }
        let outputs = self.io.outputs();
        assert!(outputs == 0 || outputs == self.sent, "{outputs:X}h where {:X}h was sent", self.sent);
        self.energised += usize::from(outputs != 0);
        assert_eq!(self.drive.place(self.now) as i64, self.place, "the drive has moved");
    }
}

/// A write that is meant to have an effect on outputs or axes. Of segments and blocks the beginning is enough.
fn is_meant(node: u8, raw: &[u8; 8]) -> bool {
    match ClientFrame::decode(raw) {
        Some(ClientFrame::Download { object, .. } | ClientFrame::BlockDownload { object, .. }) => {
            node == DRIVE || matches!(object.index, 0x5F00..0x6000 | 0x6200..=0x6207)
        }
        _ => false,
    }
}
