//! The machine by process images that travel at once, through devices that may be lost.
//!
//! A lost device neither receives nor sends. Its outputs stay as they were until its own heartbeat consumer turns them
//! off, and at the same time its station receives the loss; until then the station sees the image as it was. When it
//! comes back its outputs are off until its station sets others. A CANopen device behaves so (compare the full one in
//! the plant crate), without the frames.

use linewright_line::{Device, DeviceBus, InputId, Line, OpId, Owner, StationId, Tick};
use linewright_plant::{MotionFault, NestPosition, PartByHand, Plant, PlantOptions};

struct ImageSlot {
    device: usize,
    inputs: u128,
    outputs: u128,
    /// Reason why it is not received: unplugged, or the node that reads its bus is down.
    unplugged: bool,
    unread: bool,
    /// Time at which the loss is detected on both sides.
    noticed: Tick,
    /// That moment has come, and has been handled.
    is_noticed: bool,
}

impl ImageSlot {
    fn is_lost(&self) -> bool {
        self.unplugged || self.unread
    }

    /// Its loss is to be noticed by now, and has not been dealt with.
    fn is_due(&self, now: Tick) -> bool {
        self.is_lost() && !self.is_noticed && self.noticed <= now
    }
}

/// The devices of one owner: of a station or, at the end, of the console.
struct OwnedDevices {
    owner: Owner,
    slots: Vec<ImageSlot>,
    /// Of lost devices: last inputs seen, last outputs received.
    frozen_inputs: u128,
    frozen_outputs: u128,
    lost_inputs: u128,
    lost_outputs: u128,
    asked: u128,
    /// Time until which the owner's outputs stay, because the owner is down.
    runs_out: Tick,
}

/// The plant behind its devices.
pub(crate) struct Images {
    plant: Plant,
    owned: Vec<OwnedDevices>,
    timeout: std::time::Duration,
}

impl Images {
    pub(crate) fn new(line: &Line, options: PlantOptions) -> Self {
        let owners = line.station_ids().map(Owner::Station).chain([Owner::Console]);
        let owned = |owner: Owner| OwnedDevices {
            owner,
            slots: line.devices.iter().enumerate().filter(|(_, d)| d.owner == owner).map(slot).collect(),
            frozen_inputs: 0,
            frozen_outputs: 0,
            lost_inputs: 0,
            lost_outputs: 0,
            asked: 0,
            runs_out: Tick::NEVER,
        };
        Images {
            plant: Plant::new(line, options),
            owned: owners.map(owned).collect(),
            timeout: line.timing.heartbeat_timeout,
        }
    }

    pub(crate) fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Whether the console has devices at all.
    pub(crate) fn has_console(&self) -> bool {
        self.owned.last().is_some_and(|owned| !owned.slots.is_empty())
    }

    /// Lets time pass for everything, and detects losses and returns of owner `at`.
    pub(crate) fn poll(&mut self, now: Tick, at: usize) {
        self.plant.advance(now);
        let owned = &mut self.owned[at];
        let mut changes = false;
        for slot in owned.slots.iter_mut().filter(|slot| slot.is_due(now)) {
            slot.is_noticed = true;
            owned.frozen_outputs &= !slot.outputs;
            changes = true;
        }
        if owned.runs_out <= now {
            owned.asked = 0;
            owned.runs_out = Tick::NEVER;
            changes = true;
        }
        if changes {
            self.carry(now, at);
        }
    }

    /// The image of an owner's inputs, and whether its devices vouch for it.
    pub(crate) fn image(&self, at: usize) -> (u128, bool) {
        let owned = &self.owned[at];
        let gone = owned.slots.iter().any(|slot| slot.is_lost() && slot.is_noticed);
        let bits = self.plant.inputs(owned.owner) & !owned.lost_inputs | owned.frozen_inputs;
        if gone { (0, false) } else { (bits, true) }
    }

    /// Sets the outputs that an owner requires from now on.
    pub(crate) fn ask(&mut self, now: Tick, at: usize, outputs: u128) {
        self.plant.advance(now);
        self.owned[at].asked = outputs;
        self.carry(now, at);
    }

    fn carry(&mut self, now: Tick, at: usize) {
        let owned = &self.owned[at];
        let outputs = owned.asked & !owned.lost_outputs | owned.frozen_outputs;
        self.plant.set_outputs(now, owned.owner, outputs);
    }

    /// Time of the next poll of an owner's devices.
    pub(crate) fn deadline(&self, at: usize) -> Tick {
        let owned = &self.owned[at];
        let change = match owned.owner {
            Owner::Station(id) => self.plant.next_change_of(id).unwrap_or(Tick::NEVER),
            Owner::Console => Tick::NEVER,
        };
        let noticed = owned.slots.iter().filter(|slot| slot.is_lost() && !slot.is_noticed).map(|slot| slot.noticed);
        noticed.fold(change, Tick::min).min(owned.runs_out)
    }

    /// The owner's process has died: its outputs stay until `until`.
    pub(crate) fn owner_down(&mut self, at: usize, until: Tick) {
        self.owned[at].runs_out = until;
    }

    /// The owner's process is back.
    pub(crate) fn owner_up(&mut self, now: Tick, at: usize) {
        self.owned[at].runs_out = Tick::NEVER;
        self.ask(now, at, 0);
    }

    /// Unplugs a device of the description, or plugs it in again. Gives the place of its owner.
    pub(crate) fn unplug(&mut self, now: Tick, device: usize, unplugged: bool) -> Option<usize> {
        let at = self.owned.iter().position(|owned| owned.slots.iter().any(|slot| slot.device == device))?;
        self.lose(now, at, |slot| {
            if slot.device == device {
                slot.unplugged = unplugged;
            }
        });
        Some(at)
    }

    /// Whether a device of the description is unplugged.
    pub(crate) fn is_unplugged(&self, device: usize) -> bool {
        self.owned.iter().flat_map(|owned| &owned.slots).any(|slot| slot.device == device && slot.unplugged)
    }

    /// The node that reads the line's bus is down, or up again.
    pub(crate) fn bus_read(&mut self, now: Tick, line: &Line, read: bool) {
        for at in 0..self.owned.len() {
            self.lose(now, at, |slot| {
                if line.devices[slot.device].bus == DeviceBus::Line {
                    slot.unread = !read;
                }
            });
        }
    }

    fn lose(&mut self, now: Tick, at: usize, change: impl Fn(&mut ImageSlot)) {
        self.plant.advance(now);
        let seen = self.plant.inputs(self.owned[at].owner);
        let noticed = now + self.timeout;
        let owned = &mut self.owned[at];
        for slot in &mut owned.slots {
            let was = slot.is_lost();
            change(slot);
            if slot.is_lost() && !was {
                (slot.noticed, slot.is_noticed) = (noticed, false);
                owned.lost_inputs |= slot.inputs;
                owned.lost_outputs |= slot.outputs;
                owned.frozen_inputs |= seen & slot.inputs;
                owned.frozen_outputs |= owned.asked & slot.outputs;
            }
            if was && !slot.is_lost() {
                owned.lost_inputs &= !slot.inputs;
                owned.lost_outputs &= !slot.outputs;
                owned.frozen_inputs &= !slot.inputs;
                owned.frozen_outputs &= !slot.outputs;
                if slot.is_noticed {
                    // It started over: earlier outputs are not put on again.
                    owned.asked &= !slot.outputs;
                }
            }
        }
        self.carry(now, at);
    }

    pub(crate) fn fail(
        &mut self,
        now: Tick,
        (station, op): (StationId, OpId),
        normal: bool,
        fault: Option<MotionFault>,
    ) {
        if normal {
            self.plant.inject(now, station, op, fault);
        } else {
            self.plant.inject_recovery(now, station, op, fault);
        }
    }

    pub(crate) fn by_hand(&mut self, now: Tick, what: PartByHand, place: NestPosition) {
        _ = self.plant.by_hand(now, what, place);
    }

    pub(crate) fn force(&mut self, now: Tick, at: usize, input: InputId, value: Option<bool>) {
        self.plant.advance(now);
        self.plant.force(self.owned[at].owner, input, value);
    }
}

fn slot((number, device): (usize, &Device)) -> ImageSlot {
    let bits = |wired: &mut dyn Iterator<Item = u16>| wired.fold(0, |bits, bit| bits | 1 << bit);
    ImageSlot {
        device: number,
        inputs: bits(&mut device.carried_inputs().into_iter().map(|input| input.0)),
        outputs: bits(&mut device.carried_outputs().into_iter().map(|output| output.0)),
        unplugged: false,
        unread: false,
        noticed: Tick::NEVER,
        is_noticed: false,
    }
}
