//! Processes that come and go: what is forgotten with a life, and what the others notice.
//!
//! A process that dies says nothing any more, and its devices keep what it asked for until they miss it. One that starts
//! has its journal and nothing else: it hears and says everything anew.

use linewright_line::{Bus, StationId, Tick};
use linewright_station_logic::{CompileError, Restore};

use crate::node::{CoordinatorNode, StationNode};
use crate::sim::Sim;

impl Sim {
    pub(crate) fn next_life(&mut self) -> u64 {
        self.life += 1;
        self.life
    }

    /// A node begins a life now: it looks at its devices and says its state, now and from now on.
    pub(crate) fn begin(&mut self, node: usize, life: u64) {
        self.lives[node] = life;
        for at in 0..self.out_of[node].len() {
            self.links[self.out_of[node][at]].forget_said();
        }
        for at in 0..self.into[node].len() {
            let link = self.into[node][at];
            self.links[link].forget_heard();
            self.timers.set(link, Tick::NEVER);
        }
        self.repeats.push_front((self.now, node, life));
        self.wake_field(node);
        self.wake_node(node, self.now);
    }

    /// Starts a station that is down, from its journal.
    pub(crate) fn restart_station(&mut self, at: usize) -> Result<(), CompileError> {
        let Some(journal) = self.stations[at].journal.take() else { return Ok(()) };
        let life = self.next_life();
        let id = StationId::at(at);
        self.stations[at] = StationNode::start(&self.line, id, life, Restore::From(journal), self.options.rules)?;
        self.field.owner_up(self.now, at);
        self.begin(at, life);
        Ok(())
    }

    /// Ends a station's process.
    pub(crate) fn kill_station(&mut self, at: usize) {
        let node = &mut self.stations[at];
        if node.is_up() {
            node.kill();
            self.record.lost(self.now, StationId::at(at));
            // What it asked for stands until the gateway or its own bus's devices miss it.
            let timing = &self.line.timing;
            let until = match self.line.stations[at].bus {
                Bus::Line => timing.stale,
                Bus::Own(_) => timing.heartbeat_timeout,
            };
            self.field.owner_down(at, self.now + until);
            self.timers.set(self.node_slot(at), Tick::NEVER);
            self.wake_field(at);
        }
    }

    /// Ends the coordinator's process, and with it whoever reads the line's bus.
    pub(crate) fn kill_coordinator(&mut self) {
        if self.coordinator.is_up {
            self.coordinator.is_up = false;
            self.field.bus_read(self.now, &self.line, false);
            self.timers.set(self.node_slot(self.coordinator_node()), Tick::NEVER);
            self.wake_fields();
        }
    }

    /// Starts a coordinator that has the journal of the one before.
    pub(crate) fn restart_coordinator(&mut self) {
        if !self.coordinator.is_up {
            let life = self.next_life();
            self.coordinator = CoordinatorNode::start(&self.line, life, self.coordinator.journal);
            self.mode = self.coordinator.shell.coordinator().mode();
            self.entered = (self.now, self.coordinator.shell.coordinator().text());
            self.field.bus_read(self.now, &self.line, true);
            self.wake_fields();
            self.begin(self.coordinator_node(), life);
        }
    }
}
