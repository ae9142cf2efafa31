//! A CAN bus of 500 kbit/s in virtual time, with a manager, devices and others on it.
//!
//! One frame at a time; of those that are first in their senders' queues the lowest identifier goes (CiA 301 §6,
//! ISO 11898-1 §10.4.3). A frame is as long as it is with every stuff bit it can have. Each member has one queue, first
//! in first out, as a Linux interface has and a simple controller: a heartbeat that has to wait holds up what is behind
//! it, whatever its identifier.

mod latency;

use std::collections::VecDeque;
use std::time::Duration;

use linewright_canopen::manager::BusOutbox;
use linewright_canopen::{BusEvent, CanopenMessage, Frame, Manager};
use linewright_line::{
    Console, Device, DeviceBus, DeviceKind, InputId, Line, MaterialFlow, OutputId, Owner, Tick, Timing,
};
use linewright_plant::{PlantOptions, Rack};
use linewright_random::Random;

pub use latency::Report;

const BIT: Duration = Duration::from_micros(2);
/// Frames an interface queues (`txqueuelen`).
const QUEUE: usize = 10;
/// Devices: their heartbeats, inputs, outputs and refreshes are about 4 % of the bus, and fit beside the others.
const DEVICES: u8 = 4;
/// Bits of each in each direction.
const BITS: u16 = 16;
/// A program with timers of a millisecond polls that often.
const GRAIN: Duration = Duration::from_millis(1);

/// Time of a frame on the bus, with the gap after it. The bits from its start to the checksum are subject to stuffing:
/// after the first, every four can bring one.
fn time(frame: &Frame) -> Duration {
    let data = 8 * frame.len() as u32;
    let (stuffed, rest) = if frame.cob_id().is_some() { (34 + data, 13) } else { (54 + data, 13) };
    BIT * (stuffed + (stuffed - 1) / 4 + rest)
}

/// Frames of other nodes: they occupy the bus for nine tenths of the time.
pub struct Foreign {
    ids: Vec<u16>,
    /// Number of frames sent at the same moment.
    at_once: usize,
    next: Tick,
    turn: usize,
    random: Random,
    queues: Vec<VecDeque<Frame>>,
}

impl Foreign {
    /// No other nodes.
    pub fn none() -> Self {
        Foreign::steady(Vec::new())
    }

    /// One after the other.
    pub fn steady(ids: Vec<u16>) -> Self {
        Foreign {
            at_once: 1,
            next: Tick::ZERO,
            turn: 0,
            random: Random::new(7),
            queues: vec![VecDeque::new(); ids.len()],
            ids,
        }
    }

    /// Ten at once, then a pause.
    pub fn bursts(ids: Vec<u16>) -> Self {
        Foreign { at_once: 10, ..Foreign::steady(ids) }
    }

    /// Puts what is due until `now` in the senders' queues.
    fn send(&mut self, now: Tick) {
        while !self.ids.is_empty() && self.next <= now {
            let mut takes = Duration::ZERO;
            for _ in 0..self.at_once {
                let len = if self.random.next().is_multiple_of(4) { 4 } else { 8 };
                let data = self.random.next().to_le_bytes();
                let frame = Frame::data_frame(self.ids[self.turn], &data[..len]).expect("11 bits, 8 bytes");
                takes += time(&frame);
                self.queues[self.turn].push_back(frame);
                self.turn = (self.turn + 1) % self.ids.len();
            }
            // A tenth around the mean, so that it is in step with no other.
            let permille = 1110 * (900 + self.random.next() % 201) / 1000;
            self.next = self.next + takes * permille as u32 / 1000;
        }
    }
}

/// Sender that has the bus.
#[derive(Clone, Copy)]
enum Sender {
    Manager,
    Device(usize),
    Foreign(usize),
}

/// A counter that goes up in some bits of an image, and when it did.
#[derive(Default)]
struct Counter {
    value: u16,
    seen: u16,
    changed: Tick,
    next: Tick,
}

/// The bus and all its nodes.
pub struct Wire {
    now: Tick,
    polled: Tick,
    manager: Manager,
    interface: VecDeque<Frame>,
    rack: Rack,
    devices: Vec<VecDeque<Frame>>,
    foreign: Foreign,
    inputs: Vec<Counter>,
    outputs: Vec<Counter>,
    up: usize,
    swallow: u64,
    random: Random,
    report: Report,
}

impl Wire {
    /// Everything is switched on at once.
    pub fn new(foreign: Foreign) -> Self {
        let line = line();
        let manager = Manager::new(&line.devices, line.timing).expect("their ids are right");
        let counters = || (0..DEVICES).map(|_| Counter::default()).collect();
        Wire {
            now: Tick::ZERO,
            polled: Tick::ZERO,
            manager,
            interface: VecDeque::new(),
            rack: Rack::new(Tick::ZERO, &line, &DeviceBus::Line, PlantOptions::default()),
            devices: vec![VecDeque::new(); DEVICES.into()],
            foreign,
            inputs: counters(),
            outputs: counters(),
            up: 0,
            swallow: u64::MAX,
            random: Random::new(1),
            report: Report::default(),
        }
    }

    /// From here on one frame of process data in so many is lost.
    pub fn swallow_one_in(&mut self, frames: u64) {
        self.swallow = frames;
    }

    /// Until all devices are up, and what others could not send meanwhile is through.
    pub fn boot(&mut self) {
        while self.up < DEVICES.into() || !self.manager.inputs(self.now, Owner::Console).valid {
            assert!(self.now < Tick::from_millis(5000), "{} are up", self.up);
            self.step();
        }
        self.report = Report { up_after: self.now, ..Report::default() };
        while self.now.since(self.report.up_after) < Duration::from_secs(1) {
            self.step();
        }
        self.report = Report { up_after: self.report.up_after, ..Report::default() };
        for at in 0..usize::from(DEVICES) {
            let later = |random: &mut Random| self.now + Duration::from_micros(random.next() % 20_000);
            self.inputs[at].next = later(&mut self.random);
            self.outputs[at].next = later(&mut self.random);
        }
    }

    /// Counts inputs and outputs up, each at a moment of its own, and follows them.
    pub fn exchange(&mut self, long: Duration) {
        let began = self.now;
        while self.now.since(began) < long {
            self.count_up();
            self.step();
            self.look();
        }
        self.report.long = self.now.since(began);
    }

    pub fn report(&self) -> Report {
        let mut report = self.report.clone();
        report.foreign_share = report.foreign.as_secs_f64() / report.long.as_secs_f64();
        report
    }

    /// Inputs of the devices and outputs of the owner that are due.
    fn count_up(&mut self) {
        for at in 0..usize::from(DEVICES) {
            if self.inputs[at].next <= self.now {
                let value = self.count(at, true);
                for bit in 0..BITS {
                    let input = InputId(at as u16 * BITS + bit);
                    self.rack.plant_mut().force(Owner::Console, input, Some(value >> bit & 1 == 1));
                }
                let mut out = Vec::new();
                self.rack.poll(self.now, &mut out);
                self.queue(out);
            }
            if self.outputs[at].next <= self.now {
                self.count(at, false);
                let image = self.outputs.iter().rev().fold(0, |image, c| image << BITS | u128::from(c.value));
                let mut out = BusOutbox::default();
                self.manager.set_outputs(self.now, Owner::Console, image, &mut out);
                self.take(out);
            }
        }
    }

    fn count(&mut self, at: usize, inputs: bool) -> u16 {
        let counter = if inputs { &mut self.inputs[at] } else { &mut self.outputs[at] };
        counter.value = counter.value.wrapping_add(1);
        // Its own moment, in the middle of another frame: the bus makes it wait for the end of that.
        counter.changed = counter.next;
        counter.next = counter.next + Duration::from_micros(40_000 + self.random.next() % 100_000);
        counter.value
    }

    /// Checks the states that have arrived since the last call. Each must, before the next one.
    fn look(&mut self) {
        let image = self.manager.inputs(self.now, Owner::Console);
        for at in 0..usize::from(DEVICES) {
            let shown = (image.bits >> (at as u16 * BITS)) as u16;
            let wired = self.rack.device(node(at)).expect("it is there").outputs() as u16;
            let seen = [(&mut self.inputs[at], shown, "inputs"), (&mut self.outputs[at], wired, "outputs")];
            for (counter, shown, what) in seen {
                if shown == counter.seen {
                    continue;
                }
                let expected = counter.seen.wrapping_add(1);
                assert_eq!(shown, expected, "a state of the {what} was skipped at device {at}, {:?}", self.now);
                assert_eq!(shown, counter.value, "a state of the {what} arrived only after the next one");
                counter.seen = shown;
                let took = self.now.since(counter.changed);
                if what == "inputs" { &mut self.report.inputs } else { &mut self.report.outputs }.add(took);
            }
        }
    }

    /// One frame, or a moment of silence.
    fn step(&mut self) {
        self.foreign.send(self.now);
        if self.now.since(self.polled) >= GRAIN {
            self.polled = self.now;
            self.poll();
        }
        let Some((frame, sender)) = self.winner() else {
            self.now = self.now + BIT * 10;
            return;
        };
        let takes = time(&frame);
        self.now = self.now + takes;
        if let Sender::Foreign(_) = sender {
            self.report.foreign += takes;
        } else {
            self.report.own += takes;
            let process_data = frame.cob_id().is_some_and(|id| (0x180..0x280).contains(&id));
            if process_data && self.random.next().is_multiple_of(self.swallow) {
                return;
            }
        }
        self.deliver(&frame, sender);
    }

    fn poll(&mut self) {
        let mut out = BusOutbox::default();
        if self.manager.next_deadline().is_none_or(|due| due <= self.now) {
            self.manager.poll(self.now, &mut out);
        }
        self.take(out);
        let mut frames = Vec::new();
        if self.rack.next_deadline().is_some_and(|due| due <= self.now) {
            self.rack.poll(self.now, &mut frames);
        }
        self.queue(frames);
    }

    /// The frame that wins arbitration, taken from its queue.
    fn winner(&mut self) -> Option<(Frame, Sender)> {
        let manager = self.interface.front().map(|frame| (frame, Sender::Manager));
        let first = |queues: &[VecDeque<Frame>], at: usize| queues[at].front().is_some();
        let devices = (0..self.devices.len()).filter(|at| first(&self.devices, *at));
        let devices = devices.map(|at| (&self.devices[at][0], Sender::Device(at)));
        let foreign = (0..self.foreign.queues.len()).filter(|at| first(&self.foreign.queues, *at));
        let foreign = foreign.map(|at| (&self.foreign.queues[at][0], Sender::Foreign(at)));
        let wins = manager.into_iter().chain(devices).chain(foreign).min_by_key(|(frame, _)| frame.id_word());
        let (_, sender) = wins?;
        let queue = match sender {
            Sender::Manager => &mut self.interface,
            Sender::Device(at) => &mut self.devices[at],
            Sender::Foreign(at) => &mut self.foreign.queues[at],
        };
        Some((queue.pop_front()?, sender))
    }

    fn deliver(&mut self, frame: &Frame, sender: Sender) {
        if !matches!(sender, Sender::Manager) {
            let mut out = BusOutbox::default();
            self.manager.handle(self.now, frame, &mut out);
            self.take(out);
        }
        if !matches!(sender, Sender::Device(_)) {
            let mut frames = Vec::new();
            self.rack.handle(self.now, frame, &mut frames);
            self.queue(frames);
        }
    }

    /// Frames of the manager, as far as its interface has room.
    fn take(&mut self, out: BusOutbox) {
        for event in &out.events {
            match event {
                BusEvent::DeviceUp { .. } => self.up += 1,
                BusEvent::DeviceLost { .. } | BusEvent::BootFailed { .. } | BusEvent::DeviceLeft { .. } => {
                    self.report.lost_devices += 1;
                }
                _ => {}
            }
        }
        let mut frames = out.frames;
        let refused = frames.split_off((QUEUE - self.interface.len()).min(frames.len()));
        self.interface.extend(frames);
        if !refused.is_empty() {
            self.report.refused += refused.len();
            self.manager.return_unsent(self.now, refused);
        }
    }

    /// Frames of the devices, each by its own controller.
    fn queue(&mut self, frames: Vec<Frame>) {
        for frame in frames {
            let at = match CanopenMessage::decode(&frame) {
                Ok(
                    CanopenMessage::Tpdo1 { node, .. }
                    | CanopenMessage::Heartbeat { node, .. }
                    | CanopenMessage::Emergency { node, .. }
                    | CanopenMessage::SdoResponse { node, .. },
                ) => usize::from(node.get()) - 1,
                other => panic!("a device sends {other:?}"),
            };
            self.devices[at].push_back(frame);
        }
    }
}

fn node(at: usize) -> linewright_canopen::NodeId {
    linewright_canopen::NodeId::new(at as u8 + 1).expect("from 1")
}

/// The devices and nothing behind them: fingers press their inputs.
fn line() -> Line {
    let device = |at: u8| Device {
        name: format!("io {at}"),
        owner: Owner::Console,
        bus: DeviceBus::Line,
        kind: DeviceKind::io(
            at + 1,
            (0..BITS).map(|bit| Some(InputId(u16::from(at) * BITS + bit))).collect(),
            (0..BITS).map(|bit| Some(OutputId(u16::from(at) * BITS + bit))).collect(),
        ),
    };
    Line {
        name: "test".to_owned(),
        title: "Test".to_owned(),
        stations: Vec::new(),
        arrows: Vec::new(),
        conflicts: Vec::new(),
        devices: (0..DEVICES).map(device).collect(),
        buttons: Vec::new(),
        console: Console::default(),
        timing: Timing::default(),
        handling: MaterialFlow::default(),
    }
}
