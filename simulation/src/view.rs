//! What a run shows to whoever watches it.

use linewright_line::net::ControlMode;
use linewright_line::{AxisId, Line, OpId, StationId, Tick};
use linewright_station_logic::Controller;

use crate::log::Log;
use crate::observer::Seen;
use crate::record::Record;
use crate::sim::Sim;

impl Sim {
    /// The line.
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

    /// What has happened, if the log is kept.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Motions, counts, cycles.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The conflicts that were seen.
    pub fn conflicts(&self) -> &[Seen] {
        self.observer.seen()
    }

    /// How often drives both ways of one axis came on at once.
    pub fn alarms(&self) -> u64 {
        self.field.plant().alarms()
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

    /// A station is up, heard by the coordinator, and has its devices.
    pub fn hears(&self, station: StationId) -> bool {
        self.coordinator.is_up
            && self.coordinator.shell.coordinator().hears(station)
            && self.controller(station).is_some_and(|controller| controller.report().devices_valid)
    }

    /// Where an axis stands.
    pub fn position(&self, station: StationId, axis: AxisId) -> f64 {
        self.field.position(station, axis)
    }
}
