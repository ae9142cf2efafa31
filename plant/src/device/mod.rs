//! The simulated devices, as pure state machines.
//!
//! [`DeviceNode`] is a generic CANopen I/O device (CiA 401), [`DriveNode`] a drive (CiA 402); their common CANopen part
//! is `comm`, and their servers `serve`.
//!
//! [`DbcDeviceNode`] has none of that, but the frames of a DBC file, and [`ModbusNode`] has a register map.
//!
//! An I/O device has bits and a bus, no mechanisms: inputs are handed to it, outputs are read from it. **Leaving the
//! operational state puts every output to zero; losing the manager, or being stopped, puts it to its error value**,
//! which is zero unless another was written. Coming back does not restore outputs: that takes a new PDO from the
//! manager.

mod bytes;
mod channels;
mod comm;
mod dbc_device;
mod drive;
mod identity;
mod modbus;
mod objects;
mod on_error;
mod pdo;
mod serve;
mod sync;
mod trouble;

use std::sync::Arc;

use linewright_canopen::Frame;
use linewright_canopen::codec::{CanopenMessage, NmtState, NodeId, Payload};
use linewright_line::{Analogue, Tick, Timing};

use crate::by_hand::PartByHand;
use crate::fault::{DeviceFault, HeldFaults, MotionFault};
use crate::parts::NestPosition;
use crate::wire::FrameFaults;
use channels::SimulatedChannels;
use comm::{Comm, CommChange};
pub use dbc_device::DbcDeviceNode;
pub use drive::DriveNode;
pub(crate) use modbus::ILLEGAL_VALUE;
pub use modbus::{ModbusNode, ModbusRequest, ModbusResponse};
use on_error::OnError;
use pdo::Pdo;
use sync::SyncWatch;

/// Error code "PDO not processed due to length error" (CiA 301 table 26).
const PDO_LENGTH: u16 = 0x8210;

/// Error code "communication": SYNC, which outputs wait for, has stopped. CiA 301 has no code of its own for it.
const NO_SYNC: u16 = 0x8100;

/// A simulated device on a CAN bus.
pub trait CanDevice {
    /// Takes a frame from the bus.
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox);

    /// Does what is due at `now`.
    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox);

    /// When [`CanDevice::poll`] has something to do next.
    fn next_deadline(&self) -> Option<Tick>;

    /// Makes its communication fail, or work again (`None`).
    fn inject(&mut self, now: Tick, fault: Option<DeviceFault>);
}

/// Effect of a simulated device on its plant, beyond its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantEffect {
    /// The motions driven by an output bit are to fail, or to work again.
    Fail {
        /// Bit of the device's output PDO.
        output: usize,
        /// Fault; `None` clears.
        fault: Option<MotionFault>,
    },
    /// An input bit is to be held at a value, or let go.
    Press {
        /// Bit of the device's input PDO.
        input: usize,
        /// The value; `None` lets go.
        value: Option<bool>,
    },
    /// An output bit is to stay at a value, or follow process data again.
    Stick {
        /// Bit of the device's output PDO.
        output: usize,
        /// The value; `None` lets go.
        value: Option<bool>,
    },
    /// A person takes a part out of a place, or puts one in.
    Part(PartByHand, NestPosition),
    /// The line to the device is to be this bad.
    Disturb(FrameFaults),
    /// Every fault, and every held input and output of this device is to be cleared.
    ClearAll,
}

/// Frames and effects of a device.
#[derive(Clone, Debug, Default)]
pub struct DeviceOutbox {
    /// Frames to send, in order.
    pub frames: Vec<Frame>,
    /// Orders to the plant, in order.
    pub orders: Vec<PlantEffect>,
}

#[derive(Debug)]
pub struct DeviceNode {
    comm: Comm,
    input_count: usize,
    output_count: usize,
    inputs: u64,
    /// Inputs have changed since they were last sent.
    unsent: bool,
    outputs: u64,
    /// Outputs that came and wait for a SYNC.
    waiting: Option<u64>,
    inputs_pdo: Pdo,
    outputs_pdo: Pdo,
    on_error: OnError,
    sync_watch: SyncWatch,
    next_inputs: Tick,
    channels: SimulatedChannels,
    /// Faults of what it moves and reads.
    held: HeldFaults,
    /// Outcome of the last part that a person has taken out or put in by it, object 5F08h:00.
    pub(crate) part_outcome: u8,
}

impl DeviceNode {
    /// A device that is switched on at `now`, with up to 64 inputs and outputs.
    pub fn new(now: Tick, node: NodeId, input_count: usize, output_count: usize, timing: &Timing) -> Self {
        let (input_count, output_count) = (input_count.min(64), output_count.min(64));
        DeviceNode {
            comm: Comm::new(now, node, timing),
            input_count,
            output_count,
            inputs: 0,
            unsent: false,
            outputs: 0,
            waiting: None,
            inputs_pdo: Pdo::of_inputs(node, input_count),
            outputs_pdo: Pdo::of_outputs(node, output_count),
            on_error: OnError::new(output_count),
            sync_watch: SyncWatch::default(),
            next_inputs: Tick::NEVER,
            channels: SimulatedChannels::new(node, &Analogue::default()),
            held: HeldFaults::default(),
            part_outcome: 0,
        }
    }

    /// The device with analogue channels.
    pub fn with_channels(self, analogue: &Analogue) -> Self {
        DeviceNode { channels: SimulatedChannels::new(self.comm.node, analogue), ..self }
    }

    /// Makes it part of a run of a line, or of a line.
    pub(crate) fn be_part_of(&mut self, text: Arc<str>) {
        self.comm.part_of = text;
    }

    /// Its outputs now; bit `i` is output `i`.
    pub fn outputs(&self) -> u64 {
        self.outputs
    }

    /// The outputs of its owner's image that are on by an analogue channel's value.
    pub fn analogue_outputs(&self) -> u128 {
        self.channels.outputs()
    }

    /// The number an analogue output is at, by its channel.
    pub fn analogue_output(&self, channel: u8) -> Option<i16> {
        self.channels.output(channel)
    }

    /// Sets the process behind its analogue channels at `now`: its owner's inputs, and the outputs that are on.
    pub fn set_plant(&mut self, now: Tick, inputs: u128, outputs: u128, out: &mut DeviceOutbox) {
        self.channels.behind(now, inputs, outputs);
        self.poll_channels(now, out);
    }

    fn poll_channels(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let Comm { node, .. } = self.comm;
        let (comm, sends) = (&self.comm, self.comm.is_operational());
        self.channels
            .poll(now, sends, |number, payload| comm.send(&CanopenMessage::Tpdo { node, number, payload }, out));
    }

    pub fn state(&self) -> NmtState {
        self.comm.nmt_state()
    }

    /// Sets its inputs as the switches have them at `now`. A change is sent at once, or with a SYNC if set so.
    pub fn set_inputs(&mut self, now: Tick, inputs: u64, out: &mut DeviceOutbox) {
        if self.inputs != inputs {
            self.inputs = inputs;
            self.unsent = true;
            if self.inputs_pdo.by_event() {
                self.send_inputs(now, out);
            }
        }
    }

    fn react(&mut self, now: Tick, change: CommChange, out: &mut DeviceOutbox) {
        match change {
            CommChange::Nothing => {}
            CommChange::Started => {
                if !self.outputs_pdo.by_event() {
                    self.sync_watch.heard(now);
                }
                // The inputs are sent at the start, though unchanged.
                self.unsent = true;
                self.channels.started();
                if self.inputs_pdo.by_event() {
                    self.send_inputs(now, out);
                }
            }
            CommChange::Stopped | CommChange::Lost => self.let_go(self.on_error.outputs(self.outputs)),
            CommChange::PreOperational => self.let_go(0),
            CommChange::Boots => self.forget(),
        }
    }

    /// It boots: what was configured of its process data is forgotten.
    fn forget(&mut self) {
        self.let_go(0);
        self.inputs_pdo = Pdo::of_inputs(self.comm.node, self.input_count);
        self.outputs_pdo = Pdo::of_outputs(self.comm.node, self.output_count);
        self.on_error = OnError::new(self.output_count);
        self.channels.forget();
        self.sync_watch = SyncWatch::default();
    }

    /// No process data switches outputs outside the operational state: what they are there is decided on leaving it.
    fn let_go(&mut self, outputs: u64) {
        self.outputs = self.wired(outputs);
        self.waiting = None;
        // Whether the loss of the manager changes its state is set by 1029h:01; its outputs let go in any case.
        self.channels.let_go();
        if !self.comm.is_operational() {
            self.sync_watch.rest();
            self.channels.rest();
            self.next_inputs = Tick::NEVER;
        }
    }

    fn take_outputs(&mut self, payload: Payload, out: &mut DeviceOutbox) {
        if !self.comm.is_operational() || !self.outputs_pdo.is_active() {
            return;
        }
        if payload.bytes().len() * 8 < self.output_count {
            return self.comm.report(PDO_LENGTH, 0, out);
        }
        let outputs = self.wired(payload.bits());
        if self.outputs_pdo.by_event() {
            self.outputs = outputs;
        } else {
            self.waiting = Some(outputs);
        }
    }

    /// Those of these bits that are outputs of this device.
    fn wired(&self, bits: u64) -> u64 {
        if self.output_count == 0 { 0 } else { Payload::from_bits(bits, self.output_count).bits() }
    }

    /// Synchronous process data is taken and sent.
    fn sync(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if !self.comm.is_operational() {
            return;
        }
        if !self.outputs_pdo.by_event() {
            self.sync_watch.heard(now);
        }
        if let Some(outputs) = self.waiting.take() {
            self.outputs = outputs;
        }
        if self.inputs_pdo.sync(self.unsent) {
            self.send_inputs(now, out);
        }
    }

    fn send_inputs(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if self.comm.is_operational() && self.inputs_pdo.is_active() {
            let payload = Payload::from_bits(self.inputs, self.input_count);
            self.comm.send(&CanopenMessage::Tpdo1 { node: self.comm.node, payload }, out);
            self.unsent = false;
            self.next_inputs = self.inputs_pdo.event_timer().map_or(Tick::NEVER, |every| now + every);
        }
    }
}

impl CanDevice for DeviceNode {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox) {
        let Ok(message) = CanopenMessage::decode(frame) else { return };
        match message {
            CanopenMessage::SdoRequest { node, raw } if node == self.comm.node => serve::serve(self, now, &raw, out),
            _ if !self.comm.hears() => {}
            CanopenMessage::Rpdo1 { node, payload } if node == self.comm.node => self.take_outputs(payload, out),
            CanopenMessage::Rpdo { node, number, payload } if node == self.comm.node => {
                if self.comm.is_operational() && !self.channels.take(number, payload) {
                    self.comm.report(PDO_LENGTH, 0, out);
                }
            }
            CanopenMessage::Sync { .. } => self.sync(now, out),
            message => {
                let change = self.comm.handle(now, &message, self.on_error.behaviour, out);
                self.react(now, change, out);
            }
        }
    }

    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let change = self.comm.poll(now, self.on_error.behaviour, out);
        self.react(now, change, out);
        if self.sync_watch.deadline() <= now {
            self.sync_watch.rest();
            let change = self.comm.lose(self.on_error.behaviour, NO_SYNC, out);
            self.react(now, change, out);
        }
        if self.next_inputs <= now {
            self.next_inputs = Tick::NEVER;
            if self.inputs_pdo.event_timer().is_some() {
                self.send_inputs(now, out);
            }
        }
        self.poll_channels(now, out);
        serve::poll(&mut self.comm, now, out);
    }

    fn next_deadline(&self) -> Option<Tick> {
        let first = self
            .comm
            .next_deadline()
            .min(self.next_inputs)
            .min(self.sync_watch.deadline())
            .min(self.channels.deadline());
        (first != Tick::NEVER).then_some(first)
    }

    /// Makes it fail, or work again (`None`). A silent device goes on by itself: unplugged from the bus it still
    /// misses its manager, and lets go of its outputs.
    fn inject(&mut self, now: Tick, fault: Option<DeviceFault>) {
        if fault.is_none() {
            self.channels.release();
        }
        let change = self.comm.inject(now, fault, self.on_error.behaviour);
        self.react(now, change, &mut DeviceOutbox::default());
    }
}
