//! Starts and ends of processes: what is lost with a life, and what the others see.
//!
//! A process that dies sends nothing any more, and its devices keep its outputs until they miss it. One that starts has
//! its journal and nothing else: it receives and sends everything anew.

use linewright_coordinator_shell::CoordinatorRecord;
use linewright_line::{DeviceBus, StationId, Tick};
use linewright_station_logic::Restore;

use crate::error::StartError;
use crate::field::SimulatedField;
use crate::node::{CoordinatorNode, StationNode};
use crate::sim::LineSim;

impl LineSim {
    pub(crate) fn next_life(&mut self) -> u64 {
        self.life += 1;
        self.life
    }

    /// A node begins a life now: it reads its devices and sends its state, now and from now on.
    pub(crate) fn begin(&mut self, node: usize, life: u64) {
        self.lives[node] = life;
        self.wake_field(node);
        self.wake_node(node, self.now);
        if self.options.frames {
            // It repeats its state by itself, and what is on its way to it still arrives.
            return;
        }
        for at in 0..self.out_of[node].len() {
            self.links[self.out_of[node][at]].forget_said();
        }
        for at in 0..self.into[node].len() {
            let link = self.into[node][at];
            self.links[link].forget_heard();
            self.timers.set(link, Tick::NEVER);
        }
        self.repeats.push_front((self.now, node, life));
    }

    /// Starts a station that is down, from its journal, or without it.
    pub(crate) fn restart_station(&mut self, at: usize, remembers: bool) -> Result<(), StartError> {
        let Some(journal) = self.stations[at].journal.take() else { return Ok(()) };
        let life = self.next_life();
        let id = StationId::at(at);
        let restore = if remembers {
            Restore::From(journal)
        } else {
            self.record.forgotten_by(id);
            Restore::Fresh
        };
        self.stations[at] = StationNode::start(&self.line, id, life, restore, &self.options)?;
        match &mut self.field {
            SimulatedField::Images(field) => field.owner_up(self.now, at),
            SimulatedField::Frames(frames) => frames.read(&self.line, at, true),
        }
        self.begin(at, life);
        Ok(())
    }

    /// Ends a station's process.
    pub(crate) fn kill_station(&mut self, at: usize) {
        let node = &mut self.stations[at];
        if node.is_up() {
            node.kill();
            self.record.lost(self.now, StationId::at(at));
            // Its outputs stay until the gateway or its own bus's devices miss it.
            let timing = &self.line.timing;
            let until = match self.line.stations[at].bus {
                DeviceBus::Line => timing.stale,
                DeviceBus::Own(_) => timing.heartbeat_timeout,
            };
            match &mut self.field {
                SimulatedField::Images(field) => field.owner_down(at, self.now + until),
                SimulatedField::Frames(frames) => frames.read(&self.line, at, false),
            }
            self.timers.set(self.node_slot(at), Tick::NEVER);
            self.wake_field(at);
        }
    }

    /// Ends the coordinator's process, and with it the reader of the line's bus.
    pub(crate) fn kill_coordinator(&mut self) {
        if self.coordinator.is_up {
            self.coordinator.is_up = false;
            self.line_bus_read(false);
            self.timers.set(self.node_slot(self.coordinator_node()), Tick::NEVER);
            self.wake_fields();
        }
    }

    /// Starts a coordinator that has the journal of the one before, or has lost it.
    pub(crate) fn restart_coordinator(&mut self, remembers: bool) {
        if !self.coordinator.is_up {
            let life = self.next_life();
            let journal = if remembers { self.coordinator.journal } else { CoordinatorRecord::default() };
            self.coordinator = CoordinatorNode::start(&self.line, life, journal, &self.options);
            self.mode = self.coordinator.shell.coordinator().mode();
            self.entered = (self.now, self.coordinator.shell.coordinator().text());
            self.line_bus_read(true);
            self.wake_fields();
            self.begin(self.coordinator_node(), life);
        }
    }

    fn line_bus_read(&mut self, read: bool) {
        match &mut self.field {
            SimulatedField::Images(field) => field.bus_read(self.now, &self.line, read),
            SimulatedField::Frames(frames) => frames.read(&self.line, self.stations.len(), read),
        }
    }
}
