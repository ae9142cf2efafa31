//! A manager among devices that may send anything, played from a script of bytes: by a property test and by the fuzz
//! target.
//!
//! Whatever comes from the bus, in whatever order: each frame of outputs that the manager sends agrees with the image
//! that the owner set last, or lets go; and once a device of the owner is lost, with the image set since. Inputs are
//! valid only while every device of the owner is operational. A drive is sent to a place only by the output that stands
//! for it. Nothing else is sent than network management, the manager's heartbeat, questions to the devices, and
//! settings of the description. What one call sends and reports is bounded.

use std::time::Duration;

use linewright_canopen::manager::{BusEvent, BusOutbox};
use linewright_canopen::sdo::ObjectId;
use linewright_canopen::sdo::wire::ClientFrame;
use linewright_canopen::{CanopenMessage, DeviceRequest, Frame, Manager, NodeId};
use linewright_line::{
    AtRest, AxisId, Canopen, Device, DeviceBus, DeviceKind, DeviceSetup, Drive, DriveMode, DriveTarget, Homing,
    InputId, OutputId, Owner, StationId, Tick, Timing,
};

/// Nodes 4 and 5 are one owner's, 6 another's, 7 is a drive.
const NODES: [u8; 4] = [4, 5, 6, 7];
const DRIVE: u8 = 7;
/// Bits of the I/O devices in each direction: more than a byte.
const BITS: u16 = 10;
/// Most frames of one call: an order and a request to each device, and those that were waiting.
const FRAMES_MAX: usize = 64;
const EVENTS_MAX: usize = 32;
/// Positions of the drive's targets, in its increments, by output.
const PLACES: [i32; 2] = [0, 80_000];
/// The output that homes it.
const HOME: u16 = 2;

fn owner(node: u8) -> Owner {
    Owner::Station(StationId(match node {
        4 | 5 => 0,
        6 => 1,
        _ => 2,
    }))
}

/// The first of its owner's outputs that a device has.
fn first(node: u8) -> u16 {
    if node == 5 { BITS } else { 0 }
}

fn device(node: u8) -> Device {
    let bits = first(node)..first(node) + BITS;
    Device {
        name: format!("io {node}"),
        owner: owner(node),
        bus: DeviceBus::Line,
        kind: if node == DRIVE {
            DeviceKind::Drive(Canopen { node_id: node, setup: DeviceSetup::default() }, drive())
        } else {
            let inputs = bits.clone().map(|bit| Some(InputId(bit))).collect();
            DeviceKind::io(node, inputs, bits.map(|bit| Some(OutputId(bit))).collect())
        },
    }
}

/// A drive with two targets, a fault and a homing.
pub fn drive() -> Drive {
    let target = |output, to| DriveTarget { output: OutputId(output), to, at: InputId(output), velocity: 300.0 };
    Drive {
        axis: AxisId(0),
        mode: DriveMode::Position,
        units_per_mm: 1000.0,
        window: 0.05,
        velocity: 300.0,
        acceleration: 2000.0,
        quick_stop: 4000.0,
        at_rest: AtRest::Hold,
        targets: vec![target(0, 0.0), target(1, 80.0)],
        index: None,
        fault: Some(InputId(3)),
        homing: Some(Homing {
            method: 17,
            fast: 40.0,
            slow: 10.0,
            acceleration: 2000.0,
            offset: 0.0,
            output: OutputId(HOME),
            done: Some(InputId(4)),
        }),
    }
}

/// Feedback of a drive that obeys at once.
fn obey(command: &[u8]) -> Option<[u8; 7]> {
    let &[low, _, mode, a, b, c, d] = command else { return None };
    let state = match low & 0x8F {
        0x06 => 0x31,
        0x07 => 0x33,
        0x0F => 0x37,
        0x02 => 0x17,
        _ => 0x40,
    };
    // Remote, target reached; set-point acknowledged, or homing attained.
    let high = 0x06 | (low & 0x10);
    Some([state, high, mode, a, b, c, d])
}

/// The manager and what is around it.
pub struct ManagerFramesBench {
    manager: Manager,
    now: Tick,
    /// Image last set by each owner; zero since one of its devices was lost.
    images: [u128; 3],
    /// Number of times each image of inputs has become invalid.
    losses: [u32; 3],
    /// The devices that were operational after the last call.
    up: Vec<u8>,
    /// Requests to devices, not yet answered.
    pending: Vec<Frame>,
    /// Number of frames of the next call that the interface refuses.
    refuse: usize,
    /// Frames of outputs that were on.
    pub energised: usize,
    /// Commands that make the drive move.
    pub driven: usize,
    /// Frames of outputs.
    pub outputs: usize,
}

impl ManagerFramesBench {
    /// At its beginning.
    pub fn set_up() -> Self {
        let devices = NODES.map(device);
        let manager = Manager::new(&devices, Timing::default()).expect("their ids are right");
        ManagerFramesBench {
            manager,
            now: Tick::from_millis(1000),
            images: [0; 3],
            losses: [0; 3],
            up: Vec::new(),
            pending: Vec::new(),
            refuse: 0,
            energised: 0,
            driven: 0,
            outputs: 0,
        }
    }

    /// Plays a script to its end.
    pub fn play(&mut self, script: &[u8]) {
        let mut script = script.iter().copied();
        self.poll();
        // Its behaviour while it only listens is left to a few scripts.
        if script.len() % 4 != 0 {
            self.pass(Duration::from_millis(600));
        }
        while let Some(op) = script.next() {
            self.act(op & 0x0F, op >> 4, &mut script);
        }
    }

    fn act(&mut self, op: u8, arg: u8, script: &mut impl Iterator<Item = u8>) {
        let mut byte = || script.next().unwrap_or(0);
        let node = u16::from(NODES[usize::from(arg) % NODES.len()]);
        match op {
            // The devices answer as they should, all of them or one.
            0 | 1 => self.answer(usize::from(arg)),
            // The same, and they live for a while.
            2 => (0..=arg).for_each(|_| {
                self.answer(usize::MAX);
                NODES.iter().for_each(|node| self.hear(0x700 | u16::from(*node), &[0x05]));
                self.pass(Duration::from_millis(40));
            }),
            3 => self.hear(0x700 | node, &[byte() & 0x7F]),
            4 => {
                let data: Vec<u8> = (0..arg / 2 + 1).map(|_| byte()).collect();
                self.hear(0x180 | node, &data);
            }
            5 => {
                let data: [u8; 8] = std::array::from_fn(|_| byte());
                self.hear(0x080 | node, &data);
            }
            // The register shows no error.
            6 => self.hear(0x080 | node, &[0; 8]),
            7 => {
                let data: [u8; 8] = std::array::from_fn(|_| byte());
                self.hear(0x580 | node, &data);
            }
            8 => self.pass(Duration::from_millis(u64::from(arg) * u64::from(arg))),
            9 | 10 => {
                let image = u128::from(byte()) << (arg / 4 * 4);
                self.set(usize::from(arg) % self.images.len(), image);
            }
            11 => (0..self.images.len()).for_each(|at| self.set(at, 0)),
            12 => {
                let id = u16::from(byte()) << 8 | u16::from(byte());
                let data: Vec<u8> = (0..arg.min(8)).map(|_| byte()).collect();
                self.hear(id & 0x7FF, &data);
            }
            // Any of the kernel's sixteen bytes: long identifiers, remote requests, reports of errors.
            13 => {
                let mut bytes: [u8; 16] = std::array::from_fn(|_| byte());
                bytes[4] %= 9;
                if let Ok(frame) = Frame::from_bytes(&bytes) {
                    self.hear_frame(&frame);
                }
            }
            14 => self.refuse = arg.into(),
            _ => {
                let object = ObjectId::new(u16::from_le_bytes([byte(), byte()]), byte());
                let ask = if arg < 12 {
                    DeviceRequest::Read(object)
                } else {
                    DeviceRequest::Write { object: ObjectId::new(0x2000, 0), value: byte().into(), bytes: Some(1) }
                };
                let mut out = BusOutbox::default();
                self.manager.ask(self.now, node as u8, ask, &mut out);
                self.check(out);
            }
        }
    }

    /// Sets an owner's image.
    fn set(&mut self, at: usize, image: u128) {
        self.images[at] = image;
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, Owner::Station(StationId(at as u16)), image, &mut out);
        self.check(out);
    }

    fn hear(&mut self, id: u16, data: &[u8]) {
        self.hear_frame(&Frame::data_frame(id, data).expect("11 bits, 8 bytes"));
    }

    pub fn hear_frame(&mut self, frame: &Frame) {
        let mut out = BusOutbox::default();
        self.manager.handle(self.now, frame, &mut out);
        self.check(out);
    }

    fn poll(&mut self) {
        let mut out = BusOutbox::default();
        self.manager.poll(self.now, &mut out);
        self.check(out);
    }

    /// Lets time pass; the manager is polled at its deadlines.
    pub fn pass(&mut self, span: Duration) {
        let until = self.now + span;
        // It never requests a poll for work already done: each poll leads on.
        while let Some(due) = self.manager.next_deadline().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.poll();
            let next = self.manager.next_deadline().expect("it has been polled");
            assert!(next > self.now, "polled at {:?} it wants to be at {next:?}", self.now);
        }
        self.now = until;
    }

    /// Proper answers to the first so many questions.
    fn answer(&mut self, count: usize) {
        let mut pending = std::mem::take(&mut self.pending);
        let left = pending.split_off(count.min(pending.len()));
        for frame in pending {
            match CanopenMessage::decode(&frame) {
                Ok(CanopenMessage::SdoRequest { node, raw }) => {
                    let [_, low, high, sub, ..] = raw;
                    let data = match ClientFrame::decode(&raw) {
                        Some(ClientFrame::Upload { object: ObjectId { index: 0x1001 | 0x1029 | 0x6207, .. } }) => {
                            [0x4F, low, high, sub, 0, 0, 0, 0]
                        }
                        Some(ClientFrame::Upload { object: ObjectId { index: 0x6206, .. } }) => {
                            [0x4F, low, high, sub, 0xFF, 0, 0, 0]
                        }
                        Some(ClientFrame::Upload { .. }) => [0x43, low, high, sub, 0x91, 0x01, 0x03, 0],
                        Some(ClientFrame::Download { .. }) => [0x60, low, high, sub, 0, 0, 0, 0],
                        _ => continue,
                    };
                    self.hear(0x580 | u16::from(node.get()), &data);
                }
                Ok(CanopenMessage::Nmt { node: Some(node), .. }) => {
                    let node = u16::from(node.get());
                    self.hear(0x700 | node, &[0x05]);
                    let inputs: &[u8] = if node == u16::from(DRIVE) { &[0x40, 0, 1, 0, 0, 0, 0] } else { &[0, 0] };
                    self.hear(0x180 | node, inputs);
                }
                Ok(CanopenMessage::Rpdo1 { payload, .. }) => {
                    if let Some(status) = obey(payload.bytes()) {
                        self.hear(0x180 | u16::from(DRIVE), &status);
                    }
                }
                _ => {}
            }
        }
        self.pending.extend(left);
    }

    /// Checks the manager's frames, and refuses them if the interface is to.
    fn check(&mut self, out: BusOutbox) {
        assert!(out.frames.len() <= FRAMES_MAX, "{} frames", out.frames.len());
        assert!(out.events.len() <= EVENTS_MAX, "{} events", out.events.len());
        let mut frames = out.frames;
        frames.iter().for_each(|frame| self.check_frame(frame));
        self.forget_images(&out.events);
        let room = frames.len().saturating_sub(std::mem::take(&mut self.refuse));
        let refused = frames.split_off(room);
        for frame in frames {
            // Devices whose answers do not come get the request again; the oldest is forgotten.
            if self.pending.len() >= FRAMES_MAX {
                self.pending.remove(0);
            }
            let command =
                matches!(CanopenMessage::decode(&frame), Ok(CanopenMessage::Rpdo1 { node, .. }) if node.get() == DRIVE);
            if command
                || matches!(
                    CanopenMessage::decode(&frame),
                    Ok(CanopenMessage::SdoRequest { .. } | CanopenMessage::Nmt { .. })
                )
            {
                self.pending.push(frame);
            }
        }
        if !refused.is_empty() {
            self.manager.return_unsent(self.now, refused);
        }
    }

    /// From the next call on nothing may be energised that was decided before a loss.
    fn forget_images(&mut self, events: &[BusEvent]) {
        for (at, losses) in self.losses.iter_mut().enumerate() {
            let now = self.manager.inputs(self.now, Owner::Station(StationId(at as u16))).losses;
            if std::mem::replace(losses, now) != now {
                self.images[at] = 0;
            }
        }
        for event in events {
            // Lost before its owner's image was ever valid.
            if let BusEvent::DeviceLost { node, .. }
            | BusEvent::DeviceRebooted { node }
            | BusEvent::DeviceLeft { node, .. } = event
                && self.up.contains(&node.get())
                && let Owner::Station(StationId(at)) = owner(node.get())
            {
                self.images[usize::from(at)] = 0;
            }
        }
        let up = self.manager.devices().filter(|(_, _, up)| *up);
        self.up = up.map(|(node, _, _)| node.get()).collect();
        // Inputs are valid only while every device of their owner is operational.
        for node in NODES.into_iter().filter(|node| !self.up.contains(node)) {
            assert!(!self.manager.inputs(self.now, owner(node)).valid, "node {node} is not up, at {:?}", self.now);
        }
    }

    fn check_frame(&mut self, frame: &Frame) {
        let known = |node: NodeId| NODES.contains(&node.get());
        match CanopenMessage::decode(frame).expect("a manager sends what can be read") {
            CanopenMessage::Heartbeat { node, .. } => assert_eq!(node.get(), 127),
            CanopenMessage::Nmt { node, .. } => assert!(node.is_some_and(known), "{frame}"),
            CanopenMessage::SdoRequest { node, raw } => {
                assert!(known(node), "{frame}");
                if let Some(ClientFrame::Download { object, .. } | ClientFrame::BlockDownload { object, .. }) =
                    ClientFrame::decode(&raw)
                {
                    let setting = matches!(object.index, 0x1016 | 0x1017 | 0x1029 | 0x2000 | 0x6206 | 0x6207);
                    assert!(setting || node.get() == DRIVE, "{frame} writes object {object}");
                }
            }
            CanopenMessage::Rpdo1 { node, payload } if node.get() == DRIVE => self.check_drive(payload.bytes()),
            CanopenMessage::Rpdo1 { node, payload } if known(node) => {
                let Owner::Station(StationId(at)) = owner(node.get()) else { unreachable!("all are stations'") };
                let share = (self.images[usize::from(at)] >> first(node.get())) as u64 & ((1 << BITS) - 1);
                let bits = payload.bits();
                assert!(bits == 0 || bits == share, "{frame} where the image says {share:X}h, at {:?}", self.now);
                self.outputs += 1;
                self.energised += usize::from(bits != 0);
            }
            other => panic!("a manager sends {other:?}"),
        }
    }

    /// A command that makes a drive move is one that its owner's image gives.
    fn check_drive(&mut self, bytes: &[u8]) {
        let [low, high, mode, target @ ..] = bytes else { panic!("{bytes:02X?} is no command") };
        let word = u16::from_le_bytes([*low, *high]);
        self.outputs += 1;
        // Bit 4 with the drive enabled: a new set-point, or homing.
        if word & 0x1F != 0x1F {
            return;
        }
        self.driven += 1;
        let image = self.images[2];
        let wanted = |output: u16| image & 0b111 == 1 << output;
        match mode {
            1 => {
                let target = i32::from_le_bytes(target.try_into().expect("a target of four bytes"));
                let meant = (0..2).find(|output| wanted(*output)).map(|output| PLACES[usize::from(output)]);
                assert_eq!(Some(target), meant, "{bytes:02X?} where the image is {image:X}h");
            }
            6 => assert!(wanted(HOME), "{bytes:02X?} where the image is {image:X}h"),
            _ => panic!("{bytes:02X?} moves in an unknown mode"),
        }
    }
}
