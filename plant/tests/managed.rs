//! A manager and the simulated devices of a line's bus, in virtual time, a millisecond at a time.

use std::time::Duration;

use linewright_canopen::{BusEvent, BusOutbox, Frame, Manager};
use linewright_line::{DeviceBus, Line, Owner, StationId, Tick};
use linewright_plant::{PlantOptions, Rack};

const OWNER: Owner = Owner::Station(StationId(0));
/// Polls at one moment, and answers to one another without time passing.
const AT_ONCE_MAX: usize = 100;

pub struct Managed {
    pub now: Tick,
    pub manager: Manager,
    pub rack: Rack,
    /// Filter of the manager's frames that reach the devices.
    pub passes: fn(&Frame) -> bool,
    /// Every frame that was sent.
    pub wire: Vec<(Tick, String)>,
    pub events: Vec<BusEvent>,
}

impl Managed {
    /// Switched on.
    pub fn new(line: &Line) -> Self {
        let now = Tick::from_millis(100);
        let devices = line.devices.iter().filter(|device| device.bus == DeviceBus::Line);
        Managed {
            now,
            manager: Manager::new(devices, line.timing).expect("devices of a test"),
            rack: Rack::new(now, line, &DeviceBus::Line, PlantOptions::default()),
            passes: |_| true,
            wire: Vec::new(),
            events: Vec::new(),
        }
    }

    /// The devices of station 0 are operational. The manager listens for another one first.
    pub fn up(line: &Line) -> Self {
        let mut bus = Managed::new(line);
        bus.run(400);
        assert!(bus.is_valid(), "{:?}", bus.trouble());
        bus
    }

    pub fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            for _ in 0..AT_ONCE_MAX {
                let (mut out, mut sent) = (BusOutbox::default(), Vec::new());
                self.rack.poll(self.now, &mut sent);
                self.manager.poll(self.now, &mut out);
                self.carry(out, sent);
                if self.deadline() > self.now {
                    break;
                }
            }
            assert!(self.deadline() > self.now, "a deadline stays in the past");
        }
    }

    fn deadline(&self) -> Tick {
        let deadlines = self.rack.next_deadline().into_iter().chain(self.manager.next_deadline());
        deadlines.fold(Tick::NEVER, Tick::min)
    }

    pub fn until(&mut self, what: &str, holds: impl Fn(&Managed) -> bool) {
        let patience = self.now + Duration::from_secs(30);
        while !holds(self) {
            assert!(self.now < patience, "waited in vain: {what}; {:?}, {:?}", self.trouble(), self.events);
            self.run(1);
        }
    }

    fn carry(&mut self, mut out: BusOutbox, mut sent: Vec<Frame>) {
        for _ in 0..AT_ONCE_MAX {
            self.events.append(&mut out.events);
            let (down, up) = (std::mem::take(&mut out.frames), std::mem::take(&mut sent));
            if down.is_empty() && up.is_empty() {
                return;
            }
            self.wire.extend(down.iter().chain(&up).map(|frame| (self.now, frame.to_string())));
            for frame in down.iter().filter(|frame| (self.passes)(frame)) {
                self.rack.handle(self.now, frame, &mut sent);
            }
            for frame in &up {
                self.manager.handle(self.now, frame, &mut out);
            }
        }
        panic!("manager and devices never stop answering each other");
    }

    /// Sets the outputs of station 0.
    pub fn set(&mut self, image: u128) {
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, OWNER, image, &mut out);
        self.carry(out, Vec::new());
    }

    /// A frame to the devices that is not the manager's.
    pub fn send(&mut self, frame: &str) {
        let mut sent = Vec::new();
        self.rack.handle(self.now, &frame.parse().expect("a frame"), &mut sent);
        self.carry(BusOutbox::default(), sent);
    }

    /// Orders node 4 to give an object this value.
    pub fn order(&mut self, (index, sub): (u16, u8), value: u32) {
        let ([low, high], value) = (index.to_le_bytes(), value.swap_bytes());
        self.send(&format!("604#23{low:02X}{high:02X}{sub:02X}{value:08X}"));
    }

    /// Writes an object of node 4, which takes it.
    pub fn write(&mut self, index: u16, sub: u8, value: u32) {
        self.order((index, sub), value);
        let [low, high] = index.to_le_bytes();
        let taken = format!("584#60{low:02X}{high:02X}{sub:02X}00000000");
        assert!(self.wire.iter().any(|(at, frame)| *at == self.now && *frame == taken), "{index:04X}h:{sub:02X}");
    }

    /// Whether the inputs can be acted upon.
    pub fn is_valid(&self) -> bool {
        self.manager.inputs(self.now, OWNER).valid
    }

    /// The inputs that can be acted upon.
    pub fn bits(&self) -> u128 {
        let inputs = self.manager.inputs(self.now, OWNER);
        if inputs.valid { inputs.bits } else { 0 }
    }

    /// Outputs that the devices drive.
    pub fn outputs(&self) -> u128 {
        self.rack.plant().outputs(OWNER)
    }

    pub fn trouble(&self) -> Vec<String> {
        self.manager.trouble(self.now, OWNER).collect()
    }

    /// When frames that begin so were sent.
    pub fn sent(&self, begin: &str) -> Vec<Tick> {
        self.wire.iter().filter(|(_, frame)| frame.starts_with(begin)).map(|(at, _)| *at).collect()
    }
}
