//! The view of a run for its watchers.

use linewright_coordinator_logic::Coordinator;
use linewright_line::net::ControlMode;
use linewright_line::{AxisId, Line, OpId, Owner, StationId, Tick};
use linewright_plant::Plant;
use linewright_station_logic::Controller;

use crate::field::SimulatedField;
use crate::log::RunLog;
use crate::observer::SeenConflict;
use crate::record::RunRecord;
use crate::sim::LineSim;

impl LineSim {
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The present moment.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// Events played so far.
    pub fn events(&self) -> u64 {
        self.events
    }

    /// Events, if the log is kept.
    pub fn log(&self) -> &RunLog {
        &self.log
    }

    /// Motions, counts, cycles.
    pub fn record(&self) -> &RunRecord {
        &self.record
    }

    /// The conflicts that were seen.
    pub fn conflicts(&self) -> &[SeenConflict] {
        self.observer.seen()
    }

    /// Number of times that drives both ways of one axis came on at once.
    pub fn alarms(&self) -> u64 {
        self.field.alarms()
    }

    /// The mode of the line, by the coordinator that was last up.
    pub fn mode(&self) -> ControlMode {
        self.mode
    }

    /// The controller of a station; none while its process is down.
    pub fn controller(&self, station: StationId) -> Option<&Controller> {
        let node = &self.stations[station.index()];
        node.is_up().then_some(node.controller())
    }

    /// The last cycle in which an operation is done.
    pub fn done(&self, station: StationId, op: OpId) -> i32 {
        self.record.count(station, op)
    }

    /// A station is up, received by the coordinator, and has its devices.
    pub fn hears(&self, station: StationId) -> bool {
        self.coordinator.is_up
            && self.coordinator.shell.coordinator().hears(station)
            && self.controller(station).is_some_and(|controller| controller.report().devices_valid)
    }

    /// The mode decision; none while the coordinator's process is down.
    pub fn coordinator(&self) -> Option<&Coordinator> {
        self.coordinator.is_up.then(|| self.coordinator.shell.coordinator())
    }

    /// The lives of all stations and then of the coordinator, 0 for one that is down. Each start gives another.
    pub fn lives(&self) -> Vec<u64> {
        (0..=self.coordinator_node()).map(|node| if self.is_up(node) { self.lives[node] } else { 0 }).collect()
    }

    /// Number of commands that the coordinator has answered.
    pub fn answered(&self) -> usize {
        self.answers.len()
    }

    /// Reason why a command was refused, by its place among the answered ones; none if it was obeyed.
    pub fn refusal(&self, answer: usize) -> Option<String> {
        self.answers.get(answer)?.refusal.as_ref().map(|refusal| refusal.text(&self.line))
    }

    /// Faults of an owner's devices, in the words of their bus's manager. Without frames there is none.
    pub fn trouble_of(&self, owner: Owner) -> Vec<String> {
        match &self.field {
            SimulatedField::Images(_) => Vec::new(),
            SimulatedField::Frames(frames) => frames.trouble(self.now, owner),
        }
    }

    /// The actuators of a station that are energised at its devices, a bit per output.
    pub fn energised(&self, station: StationId) -> u128 {
        self.field.energised(&self.line, station)
    }

    /// The mechanisms of a station. With frames those of each bus are by themselves.
    pub fn plant_of(&self, station: StationId) -> &Plant {
        self.field.plant_of(station)
    }

    /// Position of an axis.
    pub fn position(&self, station: StationId, axis: AxisId) -> f64 {
        self.field.position(station, axis)
    }
}
