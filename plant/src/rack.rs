//! The devices of one bus, wired to the mechanisms behind them.
//!
//! Pure: frames and time in, frames out. Every device sees every frame, as on a bus; what one device sends is not
//! shown to the others, which have no use for it.

use linewright_fieldbus::{Frame, NodeId};
use linewright_line::{Bus, Device, DriveMode, Line, Owner, StationId, Tick};

use crate::device::{DeviceNode, DeviceOutbox, DriveNode, Order};
use crate::mechanism::bit;
use crate::plant::{Plant, PlantOptions};

struct Slot {
    device: Device,
    node: Node,
}

enum Node {
    Io(Box<DeviceNode>),
    /// With the station whose axis it moves.
    Drive(Box<DriveNode>, StationId),
}

impl Node {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut DeviceOutbox) {
        match self {
            Node::Io(node) => node.handle(now, frame, out),
            Node::Drive(node, _) => node.handle(now, frame, out),
        }
    }

    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        match self {
            Node::Io(node) => node.poll(now, out),
            Node::Drive(node, _) => node.poll(now, out),
        }
    }

    fn next_deadline(&self) -> Option<Tick> {
        match self {
            Node::Io(node) => node.next_deadline(),
            Node::Drive(node, _) => node.next_deadline(),
        }
    }
}

/// The devices of one bus and the plant they hang on.
pub struct Rack {
    plant: Plant,
    slots: Vec<Slot>,
    owners: Vec<Owner>,
}

impl Rack {
    /// The devices of `line` on `bus`, switched on at `now`. A device without a valid node id is left out; the
    /// description's parser lets none through.
    ///
    /// The plant is that of the whole line; stations on other buses stand still in this one's.
    pub fn new(now: Tick, line: &Line, bus: &Bus, options: PlantOptions) -> Self {
        let mut slots = Vec::new();
        let mut owners = Vec::new();
        for device in line.devices.iter().filter(|d| d.bus == *bus) {
            let Some(id) = NodeId::new(device.node_id) else { continue };
            let node = match (&device.drive, device.owner) {
                (Some(drive), Owner::Station(station)) => {
                    let home = line.station(station).axes[drive.axis.index()].home;
                    Node::Drive(Box::new(DriveNode::new(now, id, drive, home, &line.timing)), station)
                }
                _ => {
                    let (inputs, outputs) = (device.inputs.len(), device.outputs.len());
                    Node::Io(Box::new(DeviceNode::new(now, id, inputs, outputs, &line.timing)))
                }
            };
            slots.push(Slot { device: device.clone(), node });
            if !owners.contains(&device.owner) {
                owners.push(device.owner);
            }
        }
        Rack { plant: Plant::new(line, options), slots, owners }
    }

    /// Takes one frame from the bus at `now`.
    pub fn handle(&mut self, now: Tick, frame: &Frame, out: &mut Vec<Frame>) {
        self.each(now, out, |node, outbox| node.handle(now, frame, outbox));
    }

    /// Does what is due at `now`.
    pub fn poll(&mut self, now: Tick, out: &mut Vec<Frame>) {
        self.each(now, out, |node, outbox| node.poll(now, outbox));
    }

    /// When [`Rack::poll`] has something to do next.
    pub fn next_deadline(&self) -> Option<Tick> {
        let devices = self.slots.iter().filter_map(|slot| slot.node.next_deadline());
        devices.chain(self.plant.next_change()).min()
    }

    /// The mechanisms, to look at.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The mechanisms, to make them fail.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The I/O device with this node id.
    pub fn device(&self, node: NodeId) -> Option<&DeviceNode> {
        self.slots.iter().filter(|slot| slot.device.node_id == node.get()).find_map(|slot| match &slot.node {
            Node::Io(node) => Some(node.as_ref()),
            Node::Drive(..) => None,
        })
    }

    /// The I/O device with this node id, to make it fail.
    pub fn device_mut(&mut self, node: NodeId) -> Option<&mut DeviceNode> {
        self.slots.iter_mut().filter(|slot| slot.device.node_id == node.get()).find_map(|slot| match &mut slot.node {
            Node::Io(node) => Some(node.as_mut()),
            Node::Drive(..) => None,
        })
    }

    /// The drive with this node id.
    pub fn drive(&self, node: NodeId) -> Option<&DriveNode> {
        self.slots.iter().filter(|slot| slot.device.node_id == node.get()).find_map(|slot| match &slot.node {
            Node::Drive(node, _) => Some(node.as_ref()),
            Node::Io(_) => None,
        })
    }

    /// The drive with this node id, to make it fail.
    pub fn drive_mut(&mut self, node: NodeId) -> Option<&mut DriveNode> {
        self.slots.iter_mut().filter(|slot| slot.device.node_id == node.get()).find_map(|slot| match &mut slot.node {
            Node::Drive(node, _) => Some(node.as_mut()),
            Node::Io(_) => None,
        })
    }

    /// Lets every device act, then carries outputs to the mechanisms and switches back to the devices.
    fn each(&mut self, now: Tick, out: &mut Vec<Frame>, act: impl Fn(&mut Node, &mut DeviceOutbox)) {
        // Time first: what has happened until now happened under the old outputs.
        self.plant.advance(now);
        self.carry_axes(now);
        self.carry_inputs(now, out);
        for at in 0..self.slots.len() {
            let mut outbox = DeviceOutbox::default();
            act(&mut self.slots[at].node, &mut outbox);
            out.append(&mut outbox.frames);
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
            if let (Node::Drive(node, station), Some(drive)) = (&slot.node, &slot.device.drive) {
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
                    Node::Io(node) => node.outputs(),
                    Node::Drive(..) => 0,
                };
                let wired = slot.device.outputs.iter().enumerate();
                wired.filter(move |(at, _)| bits >> at & 1 == 1).filter_map(|(_, output)| *output)
            });
            let image = on.fold(0, |image, output| image | bit(output.index()));
            self.plant.set_outputs(now, *owner, image);
        }
    }

    fn carry_inputs(&mut self, now: Tick, out: &mut Vec<Frame>) {
        for slot in &mut self.slots {
            let Node::Io(node) = &mut slot.node else { continue };
            let image = self.plant.inputs(slot.device.owner);
            let wired = slot.device.inputs.iter().take(64).enumerate();
            let on = wired.filter(|(_, input)| input.is_some_and(|input| image & bit(input.index()) != 0));
            let bits = on.fold(0, |bits, (at, _)| bits | 1 << at);
            let mut outbox = DeviceOutbox::default();
            node.set_inputs(now, bits, &mut outbox);
            out.append(&mut outbox.frames);
        }
    }

    fn perform(&mut self, now: Tick, slot: usize, order: Order) {
        let device = &self.slots[slot].device;
        let owner = device.owner;
        match order {
            Order::Fail { output, fault } => {
                // A bit without a wire drives nothing that could fail.
                if let Some(output) = device.outputs.get(output).copied().flatten() {
                    self.plant.inject_output(now, owner, output, fault);
                }
            }
            Order::Press { input, value } => {
                if let Some(input) = device.inputs.get(input).copied().flatten() {
                    self.plant.force(owner, input, value);
                }
            }
            Order::ClearAll => {
                for output in device.outputs.iter().flatten() {
                    self.plant.inject_output(now, owner, *output, None);
                }
                for input in device.inputs.iter().flatten() {
                    self.plant.force(owner, *input, None);
                }
            }
        }
    }
}
