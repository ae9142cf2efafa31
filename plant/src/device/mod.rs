//! A generic CANopen I/O device (CiA 401), as a pure state machine.
//!
//! ```text
//!  Booting ──boot-up message──▶ PreOperational ──start──▶ Operational
//!     ▲                             ▲    ▲                 │      │
//!     │                             │    └─ pre-op, manager lost  │ stop
//!     │                             └────────────── Stopped ◀─────┘   (start leads back to Operational)
//!     └── reset node, reset communication: from every state
//! ```
//!
//! It knows its bits and its bus, nothing of mechanisms: inputs are handed to it, outputs are read from it. **Leaving
//! the operational state puts every output to zero; losing the manager, or being stopped, puts it to its error value**,
//! which is zero unless somebody has set another. Coming back does not restore outputs: that takes a new PDO from
//! whoever is in charge.

mod identity;
mod objects;
mod on_error;
mod pdo;

use std::time::Duration;

use linewright_fieldbus::codec::{Emergency, HEARTBEAT_LOST, Message, NO_ERROR, NmtCommand, NmtState, NodeId, Payload};
use linewright_fieldbus::sdo::Server;
use linewright_fieldbus::{Frame, MANAGER_NODE};
use linewright_line::{Tick, Timing};

use crate::fault::{DeviceFault, Fault};
use on_error::{Behaviour, OnError};
use pdo::Pdo;

/// What a boot takes. Short against any timeout, long enough that a reboot is a gap and not an instant.
const BOOT: Duration = Duration::from_millis(20);
/// Error register (object 1001h): generic and communication error.
const COMMUNICATION_ERROR: u8 = 0x11;
/// Error code "PDO not processed due to length error" (CiA 301 table 26).
const PDO_LENGTH: u16 = 0x8210;

/// What a simulated device does to the plant it hangs on, beyond its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The motions driven by an output bit are to fail, or to work again.
    Fail {
        /// Bit of the device's output PDO.
        output: usize,
        /// How; `None` clears.
        fault: Option<Fault>,
    },
    /// An input bit is to be held at a value, or let go.
    Press {
        /// Bit of the device's input PDO.
        input: usize,
        /// The value; `None` lets go.
        value: Option<bool>,
    },
    /// Every fault and every held input of this device is to be cleared.
    ClearAll,
}

/// What a device wants done.
#[derive(Clone, Debug, Default)]
pub struct DeviceOutbox {
    /// Frames to send, in order.
    pub frames: Vec<Frame>,
    /// Orders to the plant, in order.
    pub orders: Vec<Order>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Booting { until: Tick },
    PreOperational,
    Operational,
    Stopped,
}

/// A simulated device.
#[derive(Debug)]
pub struct DeviceNode {
    node: NodeId,
    input_count: usize,
    output_count: usize,
    state: State,
    silent: bool,
    inputs: u64,
    /// Inputs have changed since they were last sent.
    unsent: bool,
    outputs: u64,
    /// Outputs that came and wait for a SYNC.
    waiting: Option<u64>,
    inputs_pdo: Pdo,
    outputs_pdo: Pdo,
    on_error: OnError,
    /// Object 1017h.
    heartbeat: Duration,
    next_heartbeat: Tick,
    next_inputs: Tick,
    /// Object 1016h sub 1: whom it watches, and how long it waits.
    watched: Option<(NodeId, Duration)>,
    /// When the watched node counts as lost; `None` until it is heard (CiA 301 §7.2.8.3.2.2).
    lost_at: Option<Tick>,
    error_register: u8,
    server: Server,
}

impl DeviceNode {
    /// A device that is switched on at `now`, with up to 64 inputs and outputs.
    pub fn new(now: Tick, node: NodeId, input_count: usize, output_count: usize, timing: &Timing) -> Self {
        let (input_count, output_count) = (input_count.min(64), output_count.min(64));
        DeviceNode {
            node,
            input_count,
            output_count,
            state: State::Booting { until: now + BOOT },
            silent: false,
            inputs: 0,
            unsent: false,
            outputs: 0,
            waiting: None,
            inputs_pdo: Pdo::of_inputs(node, input_count),
            outputs_pdo: Pdo::of_outputs(node, output_count),
            on_error: OnError::new(output_count),
            heartbeat: timing.heartbeat,
            next_heartbeat: Tick::NEVER,
            next_inputs: Tick::NEVER,
            watched: Some((MANAGER_NODE, timing.heartbeat_timeout)),
            lost_at: None,
            error_register: 0,
            server: Server::new(objects::LEN_MAX),
        }
    }

    /// Its outputs now; bit `i` is output `i`.
    pub fn outputs(&self) -> u64 {
        self.outputs
    }

    /// The state it reports of itself.
    pub fn state(&self) -> NmtState {
        match self.state {
            State::Booting { .. } => NmtState::BootUp,
            State::PreOperational => NmtState::PreOperational,
            State::Operational => NmtState::Operational,
            State::Stopped => NmtState::Stopped,
        }
    }

    /// Makes it fail, or work again (`None`). A silent device goes on by itself: unplugged from the bus it still
    /// misses its manager, and lets go of its outputs.
    pub fn inject(&mut self, now: Tick, fault: Option<DeviceFault>) {
        self.silent = fault == Some(DeviceFault::Silent);
        if fault == Some(DeviceFault::Reboot) {
            self.boot(now);
        }
    }

    /// Sets its inputs as the switches have them at `now`. A change is sent at once, or with a SYNC if it was told so.
    pub fn set_inputs(&mut self, now: Tick, inputs: u64, out: &mut DeviceOutbox) {
        if self.inputs != inputs {
            self.inputs = inputs;
            self.unsent = true;
            if self.inputs_pdo.by_event() {
                self.send_inputs(now, out);
            }
        }
    }

    /// Takes a frame from the bus.
    pub fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox) {
        let Ok(message) = Message::decode(frame) else { return };
        if let Message::SdoRequest { node, raw } = message
            && node == self.node
        {
            return self.serve(now, &raw, out);
        }
        if self.silent || matches!(self.state, State::Booting { .. }) {
            return;
        }
        match message {
            Message::Nmt { command, node } if node.is_none_or(|node| node == self.node) => {
                self.obey(now, command, out);
            }
            Message::Rpdo1 { node, payload } if node == self.node => self.take_outputs(payload, out),
            Message::Sync { .. } => self.sync(now, out),
            Message::Heartbeat { node, state } => self.watch(now, node, state, out),
            _ => {}
        }
    }

    /// Does what is due at `now`.
    pub fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if let State::Booting { until } = self.state
            && until <= now
        {
            self.state = State::PreOperational;
            self.send(Message::Heartbeat { node: self.node, state: NmtState::BootUp }, out);
            self.schedule_heartbeat(now);
        }
        if self.lost_at.is_some_and(|at| at <= now) {
            self.lose_manager(out);
        }
        if self.next_heartbeat <= now {
            self.send(Message::Heartbeat { node: self.node, state: self.state() }, out);
            self.schedule_heartbeat(now);
        }
        if self.next_inputs <= now {
            self.next_inputs = Tick::NEVER;
            if self.inputs_pdo.event_timer().is_some() {
                self.send_inputs(now, out);
            }
        }
        self.poll_server(now, out);
    }

    /// When [`DeviceNode::poll`] has something to do next.
    pub fn next_deadline(&self) -> Option<Tick> {
        let boot = match self.state {
            State::Booting { until } => until,
            _ => Tick::NEVER,
        };
        let own = self.lost_at.into_iter().chain(self.server.next_deadline());
        let first = own.fold(boot.min(self.next_heartbeat).min(self.next_inputs), Tick::min);
        (first != Tick::NEVER).then_some(first)
    }

    fn obey(&mut self, now: Tick, command: NmtCommand, out: &mut DeviceOutbox) {
        match command {
            NmtCommand::Start if self.state != State::Operational => {
                self.state = State::Operational;
                // What the inputs are is news to whoever just started it.
                self.unsent = true;
                if self.inputs_pdo.by_event() {
                    self.send_inputs(now, out);
                }
            }
            NmtCommand::Start | NmtCommand::Unknown(_) => {}
            NmtCommand::Stop => self.leave_operational(State::Stopped, self.on_error.outputs(self.outputs)),
            NmtCommand::EnterPreOperational => self.leave_operational(State::PreOperational, 0),
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => self.boot(now),
        }
    }

    /// What was configured of its process data is forgotten.
    fn boot(&mut self, now: Tick) {
        self.leave_operational(State::Booting { until: now + BOOT }, 0);
        self.inputs_pdo = Pdo::of_inputs(self.node, self.input_count);
        self.outputs_pdo = Pdo::of_outputs(self.node, self.output_count);
        self.on_error = OnError::new(self.output_count);
        self.next_heartbeat = Tick::NEVER;
        self.lost_at = None;
        self.error_register = 0;
    }

    /// No process data switches outputs outside the operational state: what they are there is decided on leaving it.
    fn leave_operational(&mut self, state: State, outputs: u64) {
        self.state = state;
        self.outputs = self.wired(outputs);
        self.waiting = None;
        self.next_inputs = Tick::NEVER;
        if state != State::PreOperational {
            self.server.reset();
        }
    }

    fn take_outputs(&mut self, payload: Payload, out: &mut DeviceOutbox) {
        if self.state != State::Operational || !self.outputs_pdo.is_active() {
            return;
        }
        if payload.bytes().len() * 8 < self.output_count {
            return self.report(PDO_LENGTH, out);
        }
        let outputs = self.wired(payload.bits());
        if self.outputs_pdo.by_event() {
            self.outputs = outputs;
        } else {
            self.waiting = Some(outputs);
        }
    }

    /// What of these bits are outputs of this device.
    fn wired(&self, bits: u64) -> u64 {
        if self.output_count == 0 { 0 } else { Payload::from_bits(bits, self.output_count).bits() }
    }

    /// Synchronous process data is taken and sent.
    fn sync(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if self.state != State::Operational {
            return;
        }
        if let Some(outputs) = self.waiting.take() {
            self.outputs = outputs;
        }
        if self.inputs_pdo.sync(self.unsent) {
            self.send_inputs(now, out);
        }
    }

    /// Hears the heartbeat of another node.
    fn watch(&mut self, now: Tick, node: NodeId, state: NmtState, out: &mut DeviceOutbox) {
        let Some((_, timeout)) = self.watched.filter(|(watched, _)| *watched == node) else { return };
        if state == NmtState::BootUp && self.lost_at.is_some() {
            // It has booted: whatever it ordered before, it does not know of any more.
            self.lose_manager(out);
        }
        if self.lost_at.is_none() && self.error_register != 0 {
            self.error_register = 0;
            self.report(NO_ERROR, out);
        }
        self.lost_at = Some(now + timeout);
    }

    fn lose_manager(&mut self, out: &mut DeviceOutbox) {
        self.lost_at = None;
        self.error_register = COMMUNICATION_ERROR;
        let outputs = self.on_error.outputs(self.outputs);
        match (self.state, self.on_error.behaviour) {
            (State::Operational, Behaviour::NoChange) => {
                self.outputs = self.wired(outputs);
                self.waiting = None;
            }
            (State::Operational, Behaviour::PreOperational) => self.leave_operational(State::PreOperational, outputs),
            (State::Operational | State::PreOperational, Behaviour::Stopped) => {
                // Said before it may say nothing any more.
                self.report(HEARTBEAT_LOST, out);
                return self.leave_operational(State::Stopped, outputs);
            }
            (State::Booting { .. } | State::PreOperational | State::Stopped, _) => {}
        }
        self.report(HEARTBEAT_LOST, out);
    }

    fn report(&self, code: u16, out: &mut DeviceOutbox) {
        let emergency = Emergency { code, register: self.error_register, vendor: [0; 5] };
        // A stopped device sends nothing but heartbeats (CiA 301 §7.3.2.2).
        if self.state != State::Stopped {
            self.send(Message::Emergency { node: self.node, emergency }, out);
        }
    }

    fn send_inputs(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if self.state == State::Operational && self.inputs_pdo.is_active() {
            let payload = Payload::from_bits(self.inputs, self.input_count);
            self.send(Message::Tpdo1 { node: self.node, payload }, out);
            self.unsent = false;
            self.next_inputs = self.inputs_pdo.event_timer().map_or(Tick::NEVER, |every| now + every);
        }
    }

    /// From now, not from the last one: a caller who is late does not get a burst.
    fn schedule_heartbeat(&mut self, now: Tick) {
        self.next_heartbeat = if self.heartbeat.is_zero() { Tick::NEVER } else { now + self.heartbeat };
    }

    fn send(&self, message: Message, out: &mut DeviceOutbox) {
        if !self.silent {
            out.frames.push(message.encode());
        }
    }
}
