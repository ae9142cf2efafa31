//! A drive and its manager's side on a bus that loses, repeats and delays process data, in virtual time.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_canopen::codec::CanopenMessage;
use linewright_canopen::profile::drive::{DriveBinding, ManagedDrive};
use linewright_canopen::sdo::SdoWrite;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{AtRest, Drive as Described, DriveTarget, Homing, InputId, OutputId, Tick, Timing};
use linewright_plant::{CanDevice, DeviceOutbox, DriveNode, MotionFault};
use linewright_testkit::manager_frames::drive;

/// Time for which a frame is under way.
const LATENCY: Duration = Duration::from_micros(700);
/// Period of the manager's repeated outputs, and of its heartbeat.
const REFRESH: Duration = Duration::from_millis(50);
/// At most this many frames are lost in a row, each way.
pub const LOST_MAX: u32 = 3;

/// Targets 0, 80 (fast), 80 (slow, another output) and 100 at outputs 0 to 3; inputs 0, 1, 2 at 0, 80, 100; fault at
/// input 3; homing at output 4 and input 4.
pub fn described(at_rest: AtRest, homing: bool) -> Described {
    let target = |output, to, at, velocity| DriveTarget { output: OutputId(output), to, at: InputId(at), velocity };
    let usual = drive();
    Described {
        at_rest,
        targets: vec![
            target(0, 0.0, 0, 300.0),
            target(1, 80.0, 1, 300.0),
            target(2, 80.0, 1, 60.0),
            target(3, 100.0, 2, 300.0),
        ],
        homing: usual.homing.filter(|_| homing).map(|usual| Homing { output: OutputId(4), ..usual }),
        ..usual
    }
}

pub const FAULT: u128 = 1 << 3;
pub const HOME: u128 = 1 << 4;

pub struct Pair {
    pub described: Described,
    pub drive: ManagedDrive,
    pub node: DriveNode,
    pub now: Tick,
    pub image: u128,
    /// Frames under way, by when they arrive.
    to_node: VecDeque<(Tick, Frame)>,
    to_drive: VecDeque<(Tick, Frame)>,
    refresh: Tick,
    /// The manager is there.
    pub alive: bool,
    /// Out of 256 process data frames, this many are lost, and as many come twice.
    pub loss: u32,
    random: u64,
    lost: [u32; 2],
    /// States of its power seen.
    pub states: Vec<linewright_canopen::profile::drive::DriveState>,
    pub emergencies: Vec<u16>,
    /// Start of the last different image: time, and position of the axis.
    pub since: (Tick, f64),
}

impl Pair {
    /// Configured and started, the axis at `place` millimetres.
    pub fn new(described: Described, place: f64, seed: u64) -> Self {
        let now = Tick::from_millis(1000);
        let id = NodeId::new(5).expect("a node id");
        let timing = Timing::default();
        let node = DriveNode::new(now, id, &described, place, &timing);
        let drive = ManagedDrive::new(DriveBinding::of(&described));
        let mut pair = Pair {
            described,
            drive,
            node,
            now,
            image: 0,
            to_node: VecDeque::new(),
            to_drive: VecDeque::new(),
            refresh: now,
            alive: true,
            loss: 0,
            random: seed | 1,
            lost: [0; 2],
            states: Vec::new(),
            emergencies: Vec::new(),
            since: (now, place),
        };
        pair.run(Duration::from_millis(30), |_| {});
        for setting in pair.drive.settings(id) {
            pair.write(&setting);
        }
        pair.hear("000#0105");
        pair.run(Duration::from_millis(20), |_| {});
        pair
    }

    /// Writes an object, as the manager's SDO client does.
    fn write(&mut self, setting: &SdoWrite) {
        let [low, high] = setting.object.index.to_le_bytes();
        let len = setting.data.len();
        let mut data = vec![0x23 | (4 - len as u8) << 2, low, high, setting.object.sub, 0, 0, 0, 0];
        data[4..4 + len].copy_from_slice(&setting.data);
        let mut out = DeviceOutbox::default();
        self.node.handle(self.now, &Frame::data_frame(0x605, &data).expect("a frame"), &mut out);
        assert_eq!(out.frames[0].data()[0], 0x60, "{setting:?} answered {}", out.frames[0]);
        self.post(out);
    }

    pub fn hear(&mut self, text: &str) {
        let mut out = DeviceOutbox::default();
        self.node.handle(self.now, &text.parse().expect("a frame"), &mut out);
        self.post(out);
    }

    /// Every motion fails, or works again.
    pub fn fail(&mut self, fault: Option<MotionFault>) {
        let motions = self.described.outputs().count();
        (0..motions).for_each(|motion| self.fail_motion(motion, fault));
    }

    /// One does, counted as the outputs of the description.
    pub fn fail_motion(&mut self, motion: usize, fault: Option<MotionFault>) {
        let mut out = DeviceOutbox::default();
        self.node.fail(self.now, motion, fault, &mut out);
        self.post(out);
    }

    pub fn set(&mut self, image: u128) {
        if image != self.image {
            self.since = (self.now, self.place());
        }
        self.image = image;
        self.drive.set_image(self.now, image);
        self.answer();
    }

    /// Millimetres from the mechanical zero.
    pub fn place(&self) -> f64 {
        self.described.units(self.node.place(self.now))
    }

    pub fn speed(&self) -> f64 {
        self.described.units(self.node.speed(self.now))
    }

    pub fn inputs(&self) -> u128 {
        self.drive.inputs()
    }

    /// Lets time pass, and looks after every event and at least every millisecond.
    pub fn run(&mut self, span: Duration, mut look: impl FnMut(&Pair)) {
        let until = self.now + span;
        while self.now < until {
            let arrivals = [self.to_node.front(), self.to_drive.front()].into_iter().flatten().map(|(at, _)| *at);
            let due = [self.node.next_deadline(), self.drive.next_deadline(), Some(self.refresh)];
            let next = arrivals.chain(due.into_iter().flatten()).fold(self.now + Duration::from_millis(1), Tick::min);
            self.now = next.max(self.now).min(until);
            self.step();
            look(self);
        }
    }

    fn step(&mut self) {
        let now = self.now;
        let mut out = DeviceOutbox::default();
        while self.to_node.front().is_some_and(|(at, _)| *at <= now) {
            let (_, frame) = self.to_node.pop_front().expect("there is one");
            self.node.handle(now, &frame, &mut out);
        }
        if self.node.next_deadline().is_some_and(|at| at <= now) {
            self.node.poll(now, &mut out);
        }
        self.post(out);
        while self.to_drive.front().is_some_and(|(at, _)| *at <= now) {
            let (_, frame) = self.to_drive.pop_front().expect("there is one");
            match CanopenMessage::decode(&frame).expect("a drive sends what can be read") {
                CanopenMessage::Tpdo1 { payload, .. } => self.drive.take(now, payload).expect("as mapped"),
                CanopenMessage::Emergency { emergency, .. } => {
                    self.emergencies.push(emergency.code);
                    self.drive.emergency(now, emergency.code);
                }
                _ => {}
            }
        }
        self.drive.poll(now);
        if self.refresh <= now {
            self.refresh = now + REFRESH;
            if self.alive {
                self.hear("77F#05");
                let payload = self.drive.give();
                self.send(payload);
            }
        }
        self.answer();
        if self.states.last() != Some(&self.node.state()) {
            self.states.push(self.node.state());
        }
    }

    fn answer(&mut self) {
        if self.drive.wants_to_send() && self.alive {
            let payload = self.drive.give();
            self.send(payload);
        }
        // Service data are acknowledged, so they are not lost here.
        if let Some(setting) = self.drive.wants_write().filter(|_| self.alive) {
            self.write(&setting);
            self.drive.written(self.now, &setting, Ok(()));
            self.answer();
        }
    }

    fn send(&mut self, payload: linewright_canopen::codec::Payload) {
        let id = NodeId::new(5).expect("a node id");
        let frame = CanopenMessage::Rpdo1 { node: id, payload }.encode();
        for _ in 0..self.copies(0) {
            self.to_node.push_back((self.now + LATENCY, frame));
        }
    }

    fn post(&mut self, out: DeviceOutbox) {
        for frame in out.frames {
            let is_pdo = frame.cob_id() == Some(0x185);
            for _ in 0..if is_pdo { self.copies(1) } else { 1 } {
                self.to_drive.push_back((self.now + LATENCY, frame));
            }
        }
    }

    /// Number of times a frame arrives.
    fn copies(&mut self, way: usize) -> usize {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        let dice = (self.random >> 24) as u32 & 0xFF;
        if dice < self.loss && self.lost[way] < LOST_MAX {
            self.lost[way] += 1;
            return 0;
        }
        self.lost[way] = 0;
        if dice >= 256 - self.loss.min(128) { 2 } else { 1 }
    }
}
