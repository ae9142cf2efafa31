//! A simulated drive (CiA 402): profile position, profile velocity and homing, with ramps in virtual time.
//!
//! It counts in its own increments, without reference to the line. Its position is the axis: the simulation of the
//! mechanics reads it. A drive that is not absolute reports zero when it boots, wherever it is, as a real one does.
//!
//! Words are obeyed as levels, again at every event, and edges once. What takes a ramp first (disabling, quick stop, the
//! reaction to a fault) waits as `pending` until the axis stands.

mod machine;
mod motion;
mod objects;
mod profile;

use std::sync::Arc;
use std::time::Duration;

use linewright_canopen::Frame;
use linewright_canopen::codec::{Abort, CanopenMessage, NmtState, NodeId, Payload};
use linewright_canopen::profile::drive::word::{DISABLE_VOLTAGE, HOMING, PROFILE_VELOCITY, QUICK_STOP};
use linewright_canopen::profile::drive::{DriveBinding, DriveState, FOLLOWING_ERROR, SENSOR_1};
use linewright_canopen::sdo::ObjectId;
use linewright_line::{Drive, DriveMode, Tick, Timing};

use super::bytes::number;
use super::comm::{Comm, CommChange};
use super::on_error::Behaviour;
use super::serve::{self, ObjectServer};
use super::{CanDevice, DeviceOutbox, PDO_LENGTH, PlantEffect};
use crate::fault::{DeviceFault, FAULT_INDEX, MotionFault};
use motion::DriveMotion;
use objects::DriveObjects;
use profile::HomingPhase;

/// Period of checks of its own following error.
const SERVO: Duration = Duration::from_millis(1);
/// Error register (object 1001h) of a fault: generic, and of the device profile.
const PROFILE_ERROR: u8 = 0x21;
/// Error code of a lost connection where option 6007h makes that a fault.
const CONNECTION_LOST: u16 = 0x8130;

/// Goal of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MotionGoal {
    /// A set-point or a velocity, in the drive's own increments.
    Value(i32),
    /// Any place of an endless axis: to turn it is one motion.
    Turn,
    Home,
}

impl MotionGoal {
    /// Whether a motion for `goal` is this one.
    fn covers(self, goal: MotionGoal) -> bool {
        self == goal || (self == MotionGoal::Turn && goal != MotionGoal::Home)
    }
}

#[derive(Debug)]
pub struct DriveNode {
    comm: Comm,
    objects: DriveObjects,
    now: Tick,
    state: DriveState,
    /// The controlword that was last obeyed.
    word: u16,
    /// A transition that is made when the axis stands.
    pending: Option<u8>,
    /// Its commanded motion, in mechanical increments.
    motion: DriveMotion,
    /// Its zero, in mechanical increments.
    origin: f64,
    absolute: bool,
    /// The reference switch that it looks for, in mechanical increments.
    reference: f64,
    mode: i8,
    /// The set-point it follows, in its own increments.
    set_point: Option<i32>,
    /// One that waits for the first to be reached.
    next_set_point: Option<i32>,
    acknowledged: bool,
    halted: bool,
    /// The velocity last commanded in velocity mode.
    running: i32,
    homing: HomingPhase,
    /// Its motions, as [`Drive::motions`] counts them: the goal, and whether the axis sticks in it.
    motions: Vec<(MotionGoal, bool)>,
    /// Where it is stuck, in mechanical increments.
    blocked: Option<f64>,
    /// Its encoder is broken.
    broken: bool,
    /// Since when it lags too far behind.
    lagging: Option<Tick>,
    sent: Option<Payload>,
    sent_at: Tick,
}

impl DriveNode {
    /// A drive that is switched on at `now`, its axis at `place`. One whose description has a homing begins with an
    /// unknown zero.
    pub fn new(now: Tick, node: NodeId, drive: &Drive, place: f64, timing: &Timing) -> Self {
        let place = if drive.mode == DriveMode::Position { place * drive.units_per_mm } else { 0.0 };
        let absolute = drive.homing.is_none();
        let binding = DriveBinding::of(drive);
        let mut goals = match &drive.index {
            Some(_) => vec![MotionGoal::Turn],
            None => binding.targets.iter().map(|target| MotionGoal::Value(target.to)).collect(),
        };
        goals.extend(drive.homing.map(|_| MotionGoal::Home));
        DriveNode {
            comm: Comm::new(now, node, timing),
            objects: DriveObjects::new(node),
            now,
            state: DriveState::NotReadyToSwitchOn,
            word: 0,
            pending: None,
            motion: DriveMotion::standing(now, place),
            origin: if absolute { 0.0 } else { place },
            absolute,
            reference: 0.0,
            mode: 1,
            set_point: None,
            next_set_point: None,
            acknowledged: false,
            halted: false,
            running: 0,
            homing: HomingPhase::Idle,
            motions: goals.into_iter().map(|goal| (goal, false)).collect(),
            blocked: None,
            broken: false,
            lagging: None,
            sent: None,
            sent_at: now,
        }
    }

    /// Makes it part of a run of a line, or of a line.
    pub(crate) fn be_part_of(&mut self, text: Arc<str>) {
        self.comm.part_of = text;
    }

    pub fn nmt_state(&self) -> NmtState {
        self.comm.nmt_state()
    }

    /// The state of its power.
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// Position of its axis, in increments from the mechanical zero.
    pub fn place(&self, now: Tick) -> f64 {
        self.blocked.unwrap_or_else(|| self.motion.position(now))
    }

    /// Velocity of its axis, in increments per second.
    pub fn speed(&self, now: Tick) -> f64 {
        if self.blocked.is_some() { 0.0 } else { self.motion.velocity(now) }
    }

    /// Whether it has an order to move, and may. A drive that holds its place under power, or brakes, has none.
    pub fn obeys_an_order(&self) -> bool {
        self.state == DriveState::OperationEnabled && !self.halted && self.set_point.is_some()
    }

    /// Makes a motion fail, or work again (`None`): stuck, until its following error trips, or with a broken encoder, which is
    /// the axis's whatever the motion. They are counted as the outputs of its description.
    pub fn fail(&mut self, now: Tick, motion: usize, fault: Option<MotionFault>, out: &mut DeviceOutbox) {
        if let Some((_, sticks)) = self.motions.get_mut(motion) {
            *sticks = fault == Some(MotionFault::Stick);
        }
        let was_broken = self.broken;
        self.broken = fault == Some(MotionFault::Break) || self.broken && fault.is_some();
        if was_broken && !self.broken && self.state == DriveState::Fault {
            // Mended, it has no fault left that would have to be reset.
            self.enter(now, 15, out);
        }
        match self.goal() {
            Some(goal) => self.aim(now, goal),
            None => self.release(now),
        }
        self.settle(now, out);
    }

    /// Goal of its motion, if it moves.
    fn goal(&self) -> Option<MotionGoal> {
        match self.mode {
            HOMING => matches!(self.homing, HomingPhase::Seeking | HomingPhase::Returning).then_some(MotionGoal::Home),
            PROFILE_VELOCITY => Some(MotionGoal::Value(self.running)),
            _ => self.set_point.map(MotionGoal::Value),
        }
    }

    /// From here on it moves for this: where it is stuck, or free.
    fn aim(&mut self, now: Tick, goal: MotionGoal) {
        let sticks = self.motions.iter().any(|(of, sticks)| *sticks && of.covers(goal));
        if !sticks {
            self.release(now);
        } else if self.blocked.is_none() {
            self.blocked = Some(self.place(now));
        }
    }

    fn release(&mut self, now: Tick) {
        if let Some(place) = self.blocked.take() {
            self.motion = DriveMotion::standing(now, place);
        }
    }

    /// Updates everything that follows from its position and its commands.
    fn settle(&mut self, now: Tick, out: &mut DeviceOutbox) {
        self.now = now;
        if self.state == DriveState::NotReadyToSwitchOn && self.comm.nmt_state() != NmtState::BootUp {
            self.enter(now, 1, out);
        }
        if self.broken && !matches!(self.state, DriveState::NotReadyToSwitchOn) {
            self.trip(now, SENSOR_1, out);
        }
        self.watch_lag(now, out);
        self.obey(now, out);
        if let Some(transition) = self.pending.filter(|_| self.motion.stands(now)) {
            self.pending = None;
            self.enter(now, transition, out);
        }
        self.move_on(now);
        self.send(now);
        self.flush(now, out);
    }

    fn react(&mut self, now: Tick, change: CommChange, out: &mut DeviceOutbox) {
        match change {
            CommChange::Nothing => {}
            // Its position is sent at the start, though unchanged.
            CommChange::Started => self.sent = None,
            // Option 6007h: reaction to the loss of the connection.
            CommChange::Stopped | CommChange::PreOperational | CommChange::Lost => match self.objects.i16(0x6007) {
                1 => self.trip(now, CONNECTION_LOST, out),
                2 => self.objects.set(0x6040, 0, DISABLE_VOLTAGE.into()),
                3 => self.objects.set(0x6040, 0, QUICK_STOP.into()),
                _ => {}
            },
            CommChange::Boots => self.begin_anew(now),
        }
    }

    /// It boots: its power is off, its brake holds, and all commands and settings are forgotten.
    fn begin_anew(&mut self, now: Tick) {
        self.power_off(now);
        self.objects = DriveObjects::new(self.comm.node);
        self.state = DriveState::NotReadyToSwitchOn;
        self.word = 0;
        self.pending = None;
        self.mode = 1;
        self.homing = HomingPhase::Idle;
        if !self.absolute {
            self.origin = self.place(now);
        }
        self.sent = None;
    }

    /// Process data from the manager: all of the objects first, then the command of the controlword among them.
    fn take(&mut self, payload: Payload, out: &mut DeviceOutbox) {
        if !self.comm.is_operational() || !self.objects.is_on(0x1400) {
            return;
        }
        let mapped: Vec<(u16, usize)> = self.objects.mapped(0x1600).collect();
        let bytes = payload.bytes();
        if bytes.len() < mapped.iter().map(|(_, len)| len).sum() {
            return self.comm.report(PDO_LENGTH, 0, out);
        }
        let mut rest = bytes;
        for (index, len) in mapped {
            let (own, more) = rest.split_at(len);
            rest = more;
            // A mode it does not have changes nothing.
            let _ = self.objects.write(ObjectId::new(index, 0), own);
        }
    }

    /// Content of its transmit object now.
    fn payload(&self) -> Payload {
        let mut bits = 0u64;
        let mut at = 0;
        for (index, len) in self.objects.mapped(0x1A00) {
            let value = self.objects.u32(index, 0).to_le_bytes();
            bits |= value[..len].iter().enumerate().fold(0, |bits, (i, b)| bits | u64::from(*b) << (8 * (at + i)));
            at += len;
        }
        Payload::from_bits(bits, at * 8)
    }

    fn flush(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if !self.comm.is_operational() || !self.objects.is_on(0x1800) {
            self.sent = None;
            return;
        }
        let payload = self.payload();
        let timer = self.timer();
        let due = self.sent.is_none() || timer.is_some_and(|timer| self.sent_at + timer <= now);
        let changed = self.sent != Some(payload) && self.sent_at + self.inhibit() <= now;
        if due || changed {
            self.comm.send(&CanopenMessage::Tpdo1 { node: self.comm.node, payload }, out);
            self.sent = Some(payload);
            self.sent_at = now;
        }
    }

    /// When the transmit object is sent next, whatever its content then.
    fn next_pdo(&self) -> Option<Tick> {
        self.sent?;
        let moving = !self.motion.stands(self.now) && self.blocked.is_none();
        let waiting = moving || self.sent != Some(self.payload());
        let soon = waiting.then(|| self.sent_at + self.inhibit().max(SERVO));
        soon.into_iter().chain(self.timer().map(|timer| self.sent_at + timer)).min()
    }

    /// Object 1800h sub 3, in 100 µs.
    fn inhibit(&self) -> Duration {
        Duration::from_micros(u64::from(self.objects.u32(0x1800, 3)) * 100)
    }

    /// Object 1800h sub 5, in ms; 0 is off.
    fn timer(&self) -> Option<Duration> {
        let timer = self.objects.u32(0x1800, 5);
        (timer > 0).then(|| Duration::from_millis(timer.into()))
    }

    fn watch_lag(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let lag = self.motion.position(now) - self.place(now);
        if lag.abs() <= f64::from(self.objects.u32(0x6065, 0)) {
            self.lagging = None;
            return;
        }
        let since = *self.lagging.get_or_insert(now);
        let patience = Duration::from_millis(self.objects.u32(0x6066, 0).into());
        if self.state == DriveState::OperationEnabled && since + patience <= now {
            self.trip(now, FOLLOWING_ERROR, out);
        }
    }
}

impl CanDevice for DriveNode {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox) {
        let Ok(message) = CanopenMessage::decode(frame) else { return };
        match message {
            CanopenMessage::SdoRequest { node, raw } if node == self.comm.node => serve::serve(self, now, &raw, out),
            _ if !self.comm.hears() => return,
            CanopenMessage::Rpdo1 { node, payload } if node == self.comm.node => self.take(payload, out),
            message => {
                let change = self.comm.handle(now, &message, Behaviour::PreOperational, out);
                self.react(now, change, out);
            }
        }
        self.settle(now, out);
    }

    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let change = self.comm.poll(now, Behaviour::PreOperational, out);
        self.react(now, change, out);
        self.settle(now, out);
        serve::poll(&mut self.comm, now, out);
    }

    fn next_deadline(&self) -> Option<Tick> {
        let stands = self.motion.stands_at();
        let settled = stands.map(|at| at + self.window_time());
        let lag = self.blocked.filter(|_| !self.motion.stands(self.now) || self.lagging.is_some());
        let servo = lag.map(|_| self.now + SERVO);
        let own = [stands, settled, servo, self.next_pdo()].into_iter().flatten().filter(|at| *at > self.now);
        let first = own.fold(self.comm.next_deadline(), Tick::min);
        (first != Tick::NEVER).then_some(first)
    }

    /// Makes its communication fail, or work again (`None`). A silent drive goes on by itself: unplugged from the bus it
    /// still misses its manager, and stops.
    fn inject(&mut self, now: Tick, fault: Option<DeviceFault>) {
        let change = self.comm.inject(now, fault, Behaviour::PreOperational);
        let mut unsaid = DeviceOutbox::default();
        self.react(now, change, &mut unsaid);
        self.settle(now, &mut unsaid);
    }
}

impl ObjectServer for DriveNode {
    fn comm(&mut self) -> &mut Comm {
        &mut self.comm
    }

    fn read(&self, _: Tick, object: ObjectId) -> Result<Vec<u8>, Abort> {
        match object.index {
            FAULT_INDEX => Err(Abort::WRITE_ONLY),
            0x1001 if object.sub == 0 => {
                let profile = if self.objects.u32(0x603F, 0) == 0 { 0 } else { PROFILE_ERROR };
                Ok(vec![self.comm.register() | profile])
            }
            _ => self.comm.read(object).unwrap_or_else(|| self.objects.read(object)),
        }
    }

    fn faults(&mut self) -> u16 {
        let sticking = self.motions.iter().filter(|(_, sticks)| *sticks).map(|_| 1);
        sticking.fold(self.comm.trouble.count() + u16::from(self.broken), u16::saturating_add)
    }

    fn write(&mut self, now: Tick, object: ObjectId, data: &[u8], out: &mut DeviceOutbox) -> Result<(), Abort> {
        match (object.index, object.sub) {
            (FAULT_INDEX, 0) => {
                let fault = DeviceFault::from_code(number(data)?)?;
                if fault.is_none() {
                    out.orders.push(PlantEffect::ClearAll);
                    (0..self.motions.len()).for_each(|motion| self.fail(now, motion, None, out));
                }
                self.inject(now, fault);
                Ok(())
            }
            (FAULT_INDEX, sub) if usize::from(sub) <= self.motions.len() => {
                let fault = MotionFault::from_code(number(data)?)?;
                if fault.is_some_and(|fault| !MotionFault::OF_DRIVE.contains(&fault)) {
                    return Err(Abort::VALUE);
                }
                self.fail(now, usize::from(sub) - 1, fault, out);
                Ok(())
            }
            (FAULT_INDEX, _) => Err(Abort::NO_SUBINDEX),
            _ => match self.comm.write(now, object, data) {
                Some(answer) => answer,
                None if self.comm.read(object).is_some() => Err(Abort::READ_ONLY),
                None => self.objects.write(object, data),
            },
        }
    }
}
