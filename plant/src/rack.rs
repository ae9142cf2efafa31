//! The devices of one bus, wired to the mechanisms behind them.
//!
//! Pure: frames and time in, frames out. Every device sees every frame, as on a bus; what one device sends is not
//! shown to the others, which have no use for it.

mod kept;

use std::sync::Arc;

use linewright_canopen::codec::Abort;
use linewright_canopen::{Frame, NodeId};
use linewright_line::{Device, DeviceBus, DeviceKind, Drive, DriveMode, Line, OutputId, Owner, StationId, Tick};

use crate::by_hand::PartRefusal;
use crate::device::{
    CanDevice, DbcDeviceNode, DeviceNode, DeviceOutbox, DriveNode, ILLEGAL_VALUE, ModbusNode, ModbusRequest,
    ModbusResponse, PlantEffect,
};
use crate::fault::{DeviceFault, FAULT_INDEX, FAULTS_INDEX, FaultWrite, MotionFault};
use crate::plant::{Plant, PlantOptions};
use crate::wire::{FaultyWire, FrameFaults};

struct RackSlot {
    device: Device,
    node: RackNode,
    wire: FaultyWire,
    /// Output bits that do not follow process data, and those of them that stay on.
    stuck: (u64, u64),
}

impl RackSlot {
    fn of(device: &Device, node: RackNode) -> Self {
        RackSlot { device: device.clone(), node, wire: FaultyWire::default(), stuck: (0, 0) }
    }

    fn send(&mut self, frames: &mut Vec<Frame>, out: &mut Vec<Frame>) {
        for frame in frames.drain(..) {
            out.extend(std::iter::repeat_n(frame, self.wire.away()));
        }
    }
}

enum RackNode {
    Io(Box<DeviceNode>),
    /// With the station whose axis it moves.
    Drive(Box<DriveNode>, StationId),
    Plain(Box<DbcDeviceNode>),
    Modbus(Box<ModbusNode>),
}

impl RackNode {
    fn on_can(&mut self) -> Option<&mut dyn CanDevice> {
        match self {
            RackNode::Io(node) => Some(&mut **node),
            RackNode::Drive(node, _) => Some(&mut **node),
            RackNode::Plain(node) => Some(&mut **node),
            RackNode::Modbus(_) => None,
        }
    }

    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox) {
        if let Some(device) = self.on_can() {
            device.handle(now, frame, out);
        }
    }

    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        match self {
            RackNode::Modbus(node) => node.poll(now),
            node => node.on_can().into_iter().for_each(|device| device.poll(now, out)),
        }
    }

    fn next_deadline(&self) -> Option<Tick> {
        match self {
            RackNode::Io(node) => node.next_deadline(),
            RackNode::Drive(node, _) => node.next_deadline(),
            RackNode::Plain(node) => node.next_deadline(),
            RackNode::Modbus(node) => node.next_deadline(),
        }
    }

    fn inject(&mut self, now: Tick, fault: Option<DeviceFault>) {
        match self {
            RackNode::Modbus(node) => node.inject(fault),
            node => node.on_can().into_iter().for_each(|device| device.inject(now, fault)),
        }
    }
}

/// The devices of one bus and the plant they hang on.
pub struct Rack {
    plant: Plant,
    slots: Vec<RackSlot>,
    owners: Vec<Owner>,
}

impl Rack {
    /// The devices of `line` on `bus`, switched on at `now`. A device without a valid node id is left out; the
    /// description's parser lets none through.
    ///
    /// The plant is that of the whole line; stations on other buses stand still in this one's.
    pub fn new(now: Tick, line: &Line, bus: &DeviceBus, options: PlantOptions) -> Self {
        let mut slots = Vec::new();
        let mut owners = Vec::new();
        for device in line.devices.iter().filter(|d| d.bus == *bus) {
            if !owners.contains(&device.owner) {
                owners.push(device.owner);
            }
            let node = match (&device.kind, device.owner) {
                (DeviceKind::Frames(frames), _) => {
                    let Some(binding) = &frames.bound else { continue };
                    RackNode::Plain(Box::new(DbcDeviceNode::new(now, binding)))
                }
                (DeviceKind::Drive(canopen, drive), Owner::Station(station)) => {
                    let Some(id) = NodeId::new(canopen.node_id) else { continue };
                    let home = line.station(station).axes[drive.axis.index()].home;
                    RackNode::Drive(Box::new(DriveNode::new(now, id, drive, home, &line.timing)), station)
                }
                (DeviceKind::Modbus(modbus), _) => RackNode::Modbus(Box::new(ModbusNode::new(modbus))),
                // The console has no axis that a drive could move.
                (DeviceKind::Drive(..), Owner::Console) => continue,
                (DeviceKind::Io(canopen, io), _) => {
                    let Some(id) = NodeId::new(canopen.node_id) else { continue };
                    let node = DeviceNode::new(now, id, io.inputs.len(), io.outputs.len(), &line.timing);
                    RackNode::Io(Box::new(node.with_channels(&io.analogue)))
                }
            };
            slots.push(RackSlot::of(device, node));
        }
        Rack { plant: Plant::new(line, options), slots, owners }
    }

    /// Makes its CANopen devices part of a run of a line, or of a line; object 5F06h has the text.
    pub fn be_part_of(&mut self, text: &str) {
        let text: Arc<str> = text.into();
        for slot in &mut self.slots {
            match &mut slot.node {
                RackNode::Io(node) => node.be_part_of(text.clone()),
                RackNode::Drive(node, _) => node.be_part_of(text.clone()),
                RackNode::Plain(_) | RackNode::Modbus(_) => {}
            }
        }
    }

    /// Takes one frame from the bus at `now`.
    pub fn handle(&mut self, now: Tick, frame: &Frame, out: &mut Vec<Frame>) {
        self.each(now, out, FaultyWire::towards, |node, outbox| node.handle(now, frame, outbox));
    }

    pub fn poll(&mut self, now: Tick, out: &mut Vec<Frame>) {
        self.each(now, out, |_| 1, |node, outbox| node.poll(now, outbox));
    }

    /// Sends a request to the Modbus device at this address and unit. An exception's code if it refuses, `None` without
    /// an answer.
    pub fn ask(
        &mut self,
        now: Tick,
        (address, unit): (&str, u8),
        request: &ModbusRequest,
        out: &mut Vec<Frame>,
    ) -> Option<Result<ModbusResponse, u8>> {
        // Everything else at this moment first: the switches are read as they are now.
        self.poll(now, out);
        let mut answer = None;
        for slot in &mut self.slots {
            let RackNode::Modbus(node) = &mut slot.node else { continue };
            // Several may share one: what is not the first one's may be the next one's.
            if node.is_at(address, unit) && !matches!(answer, Some(Ok(_))) {
                answer = node.handle(now, request);
            }
        }
        self.carry_outputs(now);
        self.carry_axes(now);
        self.carry_inputs(now, out);
        answer
    }

    /// Makes the Modbus device of this name, at this address and unit, fail: a number for one of the objects 5F00h and 5F01h of
    /// a simulated CANopen device; for 5F07h nothing. The number of injected faults that hold then; an exception's code if it
    /// has no such fault, `None` if it is not here.
    pub fn fail_modbus(
        &mut self,
        now: Tick,
        (address, unit): (&str, u8),
        device: &str,
        (object, value): FaultWrite,
        out: &mut Vec<Frame>,
    ) -> Option<Result<u16, u8>> {
        // Everything else at this moment first.
        self.poll(now, out);
        let here = |slot: &RackSlot| {
            let RackNode::Modbus(node) = &slot.node else { return false };
            node.is_at(address, unit) && slot.device.name == *device
        };
        let at = self.slots.iter().position(here)?;
        let failed = self.fail_modbus_at(now, at, object, value);
        self.carry_inputs(now, out);
        let RackNode::Modbus(node) = &mut self.slots[at].node else { return None };
        Some(failed.map_err(|_| ILLEGAL_VALUE).map(|()| {
            node.hold((object, value));
            node.faults()
        }))
    }

    fn fail_modbus_at(&mut self, now: Tick, at: usize, object: (u16, u8), value: u32) -> Result<(), Abort> {
        if object == (FAULTS_INDEX, 0) {
            return Ok(());
        }
        if object == (FAULT_INDEX, 0) {
            let fault = DeviceFault::from_code(value)?;
            if matches!(fault, Some(DeviceFault::NoHeartbeat)) {
                return Err(Abort::VALUE);
            }
            self.slots[at].node.inject(now, fault);
            if fault.is_none() {
                self.perform(now, at, PlantEffect::ClearAll);
            }
            return Ok(());
        }
        let device = &self.slots[at].device;
        let effect = PlantEffect::of(object, value, device.input_bits().len(), device.output_bits().len())?;
        if matches!(effect, PlantEffect::Stick { .. } | PlantEffect::Part(..)) {
            return Err(Abort::NO_OBJECT);
        }
        self.perform(now, at, effect);
        Ok(())
    }

    pub fn next_deadline(&self) -> Option<Tick> {
        let devices = self.slots.iter().filter_map(|slot| slot.node.next_deadline());
        devices.chain(self.plant.next_change()).min()
    }

    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The mechanisms, to make them fail.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// Makes any device fail, or work again: all its faults of communication, and its line.
    pub fn inject(&mut self, now: Tick, node: NodeId, fault: Option<DeviceFault>) {
        let Some(slot) = self.slots.iter_mut().find(|slot| slot.device.node_id() == Some(node.get())) else { return };
        slot.node.inject(now, fault);
        if fault.is_none() {
            slot.wire = FaultyWire::default();
        }
    }

    /// The same of a device of the description, CANopen or not.
    pub fn fail_device(&mut self, now: Tick, device: &Device, fault: Option<DeviceFault>) {
        if let Some(node) = device.node_id().and_then(NodeId::new) {
            self.inject(now, node, fault);
            return;
        }
        for slot in self.slots.iter_mut().filter(|slot| slot.device.name == device.name) {
            slot.node.inject(now, fault);
        }
    }

    /// Makes the line to a device this bad.
    pub fn disturb(&mut self, node: NodeId, faults: FrameFaults) {
        for slot in self.slots.iter_mut().filter(|slot| slot.device.node_id() == Some(node.get())) {
            slot.wire = FaultyWire::new(faults);
        }
    }

    /// Holds an output bit of a device at a value, whatever the process data, or lets it follow them again.
    pub fn stick(&mut self, node: NodeId, output: usize, value: Option<bool>) {
        let bit = u32::try_from(output).ok().and_then(|output| 1u64.checked_shl(output)).unwrap_or(0);
        for slot in self.slots.iter_mut().filter(|slot| slot.device.node_id() == Some(node.get())) {
            let (held, on) = slot.stuck;
            let held = if value.is_some() { held | bit } else { held & !bit };
            slot.stuck = (held, if value == Some(true) { on | bit } else { on & !bit });
        }
    }

    /// The I/O device with this node id.
    pub fn device(&self, node: NodeId) -> Option<&DeviceNode> {
        self.slots.iter().filter(|slot| slot.device.node_id() == Some(node.get())).find_map(|slot| match &slot.node {
            RackNode::Io(node) => Some(node.as_ref()),
            RackNode::Drive(..) | RackNode::Plain(_) | RackNode::Modbus(_) => None,
        })
    }

    /// Makes the motion of a drive by this output fail, or work again (`None`). `false`: no drive obeys it.
    pub fn fail_motion(
        &mut self,
        now: Tick,
        owner: Owner,
        output: OutputId,
        fault: Option<MotionFault>,
        out: &mut Vec<Frame>,
    ) -> bool {
        let mut found = false;
        for slot in self.slots.iter_mut().filter(|slot| slot.device.owner == owner) {
            let motion = slot.device.drive().and_then(|drive| drive.motions().position(|own| own == output));
            if let (RackNode::Drive(node, _), Some(motion)) = (&mut slot.node, motion) {
                let mut outbox = DeviceOutbox::default();
                node.fail(now, motion, fault, &mut outbox);
                slot.send(&mut outbox.frames, out);
                found = true;
            }
        }
        found
    }

    /// Outputs that an owner's devices drive: bit `i` is its output `i`. All outputs of a drive that moves by an order
    /// count.
    pub fn driven(&self, owner: Owner) -> u128 {
        let drives = self.slots.iter().filter(|slot| slot.device.owner == owner).filter_map(|slot| match &slot.node {
            RackNode::Drive(node, _) if node.obeys_an_order() => slot.device.drive(),
            RackNode::Drive(..) | RackNode::Io(_) | RackNode::Plain(_) | RackNode::Modbus(_) => None,
        });
        let moved = drives.flat_map(Drive::motions).fold(0, |image, output| image | output.bit());
        self.plant.outputs(owner) | moved
    }

    /// Lets every device act, then carries outputs to the mechanisms and switches back to the devices.
    fn each(
        &mut self,
        now: Tick,
        out: &mut Vec<Frame>,
        times: impl Fn(&mut FaultyWire) -> usize,
        act: impl Fn(&mut RackNode, &mut DeviceOutbox),
    ) {
        // Time first: what has happened until now happened under the old outputs.
        self.plant.advance(now);
        self.carry_axes(now);
        self.carry_inputs(now, out);
        for at in 0..self.slots.len() {
            let mut outbox = DeviceOutbox::default();
            let slot = &mut self.slots[at];
            for _ in 0..times(&mut slot.wire) {
                act(&mut slot.node, &mut outbox);
            }
            slot.send(&mut outbox.frames, out);
            for order in outbox.orders {
                self.perform(now, at, order);
            }
        }
        self.carry_outputs(now);
        self.carry_axes(now);
        self.carry_inputs(now, out);
    }

    /// Puts the axes where their drives have moved them to.
    fn carry_axes(&mut self, now: Tick) {
        for slot in &self.slots {
            if let (RackNode::Drive(node, station), Some(drive)) = (&slot.node, slot.device.drive()) {
                let increments = match drive.mode {
                    DriveMode::Position => node.place(now),
                    DriveMode::Velocity => node.speed(now),
                };
                self.plant.place(now, *station, drive.axis, drive.units(increments));
            }
        }
    }

    fn carry_outputs(&mut self, now: Tick) {
        for owner in &self.owners {
            let on = self.slots.iter().filter(|slot| slot.device.owner == *owner).flat_map(|slot| {
                let bits = match &slot.node {
                    RackNode::Io(node) => node.outputs() & !slot.stuck.0 | slot.stuck.1,
                    RackNode::Modbus(node) => node.outputs(),
                    RackNode::Drive(..) | RackNode::Plain(_) => 0,
                };
                let wired = slot.device.output_bits().iter().enumerate();
                wired.filter(move |(at, _)| bits >> at & 1 == 1).filter_map(|(_, output)| *output)
            });
            let plain = self.slots.iter().filter(|slot| slot.device.owner == *owner).map(|slot| match &slot.node {
                RackNode::Plain(node) => node.outputs(),
                RackNode::Io(node) => node.analogue_outputs(),
                RackNode::Drive(..) | RackNode::Modbus(_) => 0,
            });
            let plain = plain.fold(0, |all, outputs| all | outputs);
            let image = on.fold(plain, |image, output| image | output.bit());
            self.plant.set_outputs(now, *owner, image);
        }
    }

    fn carry_inputs(&mut self, now: Tick, out: &mut Vec<Frame>) {
        for slot in &mut self.slots {
            let image = self.plant.inputs(slot.device.owner);
            if let RackNode::Plain(node) = &mut slot.node {
                let mut outbox = DeviceOutbox::default();
                node.set_inputs(now, image, &mut outbox);
                slot.send(&mut outbox.frames, out);
                continue;
            }
            let wired = slot.device.input_bits().iter().take(64).enumerate();
            let on = wired.filter(|(_, input)| input.is_some_and(|input| image & input.bit() != 0));
            let bits = on.fold(0, |bits, (at, _)| bits | 1 << at);
            if let RackNode::Modbus(node) = &mut slot.node {
                node.set_inputs(bits);
                continue;
            }
            let RackNode::Io(node) = &mut slot.node else { continue };
            let mut outbox = DeviceOutbox::default();
            node.set_inputs(now, bits, &mut outbox);
            node.set_plant(now, image, self.plant.outputs(slot.device.owner), &mut outbox);
            slot.send(&mut outbox.frames, out);
        }
    }

    fn perform(&mut self, now: Tick, at: usize, order: PlantEffect) {
        let slot = &mut self.slots[at];
        let device = &slot.device;
        let owner = device.owner;
        match order {
            PlantEffect::Fail { output, fault } => {
                // A bit without a wire drives nothing that could fail.
                if let Some(output) = device.output_bits().get(output).copied().flatten() {
                    self.plant.inject_output(now, owner, output, fault);
                }
            }
            PlantEffect::Press { input, value } => {
                if let Some(input) = device.input_bits().get(input).copied().flatten() {
                    self.plant.force(owner, input, value);
                }
            }
            PlantEffect::Stick { output, value } => {
                if let Some(node) = device.node_id().and_then(NodeId::new) {
                    self.stick(node, output, value);
                }
            }
            PlantEffect::Part(what, place) => {
                let outcome = self.plant.by_hand(now, what, place);
                if let RackNode::Io(node) = &mut slot.node {
                    node.part_outcome = outcome.err().map_or(0, PartRefusal::code);
                }
            }
            PlantEffect::Disturb(faults) => slot.wire = FaultyWire::new(faults),
            PlantEffect::ClearAll => {
                slot.wire = FaultyWire::default();
                slot.stuck = (0, 0);
                for output in device.output_bits().iter().flatten() {
                    self.plant.inject_output(now, owner, *output, None);
                }
                for input in device.input_bits().iter().flatten() {
                    self.plant.force(owner, *input, None);
                }
            }
        }
    }
}
