//! One CAN bus in virtual time: a manager at the near end, devices and the plant behind them at the far one.
//!
//! The manager dies and comes back with the node that reads the bus. The wire delays every frame by the same time, so
//! frames keep their order, as they do on a bus.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_canopen::{BusOutbox, Frame, Manager, ManagerError};
use linewright_line::{Device, Line, Tick};
use linewright_plant::Rack;

/// Approximate time of a classic CAN frame at 1 Mbit/s, with its arbitration.
const FRAME_TIME: Duration = Duration::from_micros(150);

/// Error frames of the kernel: its interface is off the bus, and has restarted.
const BUS_OFF: &str = "20000040#0000000000000000";
const RESTARTED: &str = "20000100#0000000000000000";

/// One bus.
pub(crate) struct SimulatedBus {
    /// The node that reads it.
    pub(super) reader: usize,
    pub(super) rack: Rack,
    devices: Vec<Device>,
    /// None while its reader is down.
    manager: Option<Manager>,
    outbox: BusOutbox,
    /// Frames of devices that are not on the wire yet.
    from_devices: Vec<Frame>,
    /// On their way, the oldest first.
    to_devices: VecDeque<(Tick, Frame)>,
    to_manager: VecDeque<(Tick, Frame)>,
    /// The manager's interface is off the bus.
    is_off: bool,
    /// Time of the next event of devices or mechanisms, and of the manager.
    rack_due: Tick,
    manager_due: Tick,
}

/// Actions on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Played {
    /// Something of the devices or of the mechanisms behind them.
    Devices,
    /// Something that the bus's reader has to look at.
    Manager,
    /// Nothing that matters to either.
    Nothing,
}

impl SimulatedBus {
    pub(super) fn new(line: &Line, devices: Vec<Device>, rack: Rack, reader: usize) -> Result<Self, ManagerError> {
        let manager = Some(Manager::new(&devices, line.timing)?);
        Ok(SimulatedBus {
            reader,
            rack,
            devices,
            manager,
            outbox: BusOutbox::default(),
            from_devices: Vec::new(),
            to_devices: VecDeque::new(),
            to_manager: VecDeque::new(),
            is_off: false,
            rack_due: Tick::ZERO,
            manager_due: Tick::ZERO,
        })
    }

    pub(super) fn manager(&self) -> Option<&Manager> {
        self.manager.as_ref()
    }

    /// The process that reads it ends, or starts.
    pub(super) fn read(&mut self, line: &Line, read: bool) {
        // The same devices had a manager when the line was switched on.
        self.manager = read.then(|| Manager::new(&self.devices, line.timing).ok()).flatten();
        self.find_manager_due();
    }

    /// Plays one thing that is due.
    pub(super) fn play(&mut self, now: Tick) -> Played {
        if let Some(frame) = due(&mut self.to_devices, now) {
            self.rack.handle(now, &frame, &mut self.from_devices);
        } else if let Some(frame) = due(&mut self.to_manager, now) {
            let is_heard = !self.is_off || frame.cob_id().is_none();
            let Some(manager) = self.manager.as_mut().filter(|_| is_heard) else { return Played::Nothing };
            manager.handle(now, &frame, &mut self.outbox);
            self.find_manager_due();
            return Played::Manager;
        } else if self.rack_due <= now {
            self.rack.poll(now, &mut self.from_devices);
        } else {
            return if self.manager_due <= now { Played::Manager } else { Played::Nothing };
        }
        self.rack_due = self.rack.next_deadline().unwrap_or(Tick::NEVER);
        self.send(now);
        Played::Devices
    }

    /// Lets the manager do its work that is due.
    pub(super) fn poll(&mut self, now: Tick) {
        if self.manager_due <= now {
            self.ask(|manager, out| manager.poll(now, out));
        }
    }

    /// Calls the manager.
    pub(super) fn ask(&mut self, does: impl FnOnce(&mut Manager, &mut BusOutbox)) {
        if let Some(manager) = &mut self.manager {
            does(manager, &mut self.outbox);
            self.find_manager_due();
        }
    }

    /// A manager that has not been polled yet is due at once.
    fn find_manager_due(&mut self) {
        self.manager_due = self.manager.as_ref().map_or(Tick::NEVER, |m| m.next_deadline().unwrap_or(Tick::ZERO));
    }

    /// Does something to the devices or the mechanisms.
    pub(super) fn disturb(&mut self, now: Tick, does: impl FnOnce(&mut Rack, &mut Vec<Frame>)) {
        does(&mut self.rack, &mut self.from_devices);
        self.rack.poll(now, &mut self.from_devices);
        self.rack_due = self.rack.next_deadline().unwrap_or(Tick::NEVER);
        self.send(now);
    }

    /// The manager's interface leaves the bus, or comes back to it, with an error frame of the kernel for the manager.
    pub(super) fn turn_off(&mut self, now: Tick, off: bool) {
        self.is_off = off;
        if let Ok(frame) = if off { BUS_OFF } else { RESTARTED }.parse() {
            self.to_manager.push_front((now, frame));
        }
    }

    /// Puts the frames of both sides on the wire.
    pub(super) fn send(&mut self, now: Tick) {
        self.outbox.events.clear();
        let arrives = now + FRAME_TIME;
        self.to_manager.extend(self.from_devices.drain(..).map(|frame| (arrives, frame)));
        let is_off = self.is_off;
        self.to_devices.extend(self.outbox.frames.drain(..).filter(|_| !is_off).map(|frame| (arrives, frame)));
    }

    /// Time of the next event.
    pub(super) fn deadline(&self) -> Tick {
        let first = |on_way: &VecDeque<(Tick, Frame)>| on_way.front().map_or(Tick::NEVER, |(arrives, _)| *arrives);
        first(&self.to_devices).min(first(&self.to_manager)).min(self.rack_due).min(self.manager_due)
    }
}

/// Takes the first frame on its way, if it has arrived.
fn due(on_way: &mut VecDeque<(Tick, Frame)>, now: Tick) -> Option<Frame> {
    if on_way.front().is_some_and(|(arrives, _)| *arrives <= now) {
        return on_way.pop_front().map(|(_, frame)| frame);
    }
    None
}
