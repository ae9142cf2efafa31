//! What must hold after every event, by what happened around the controllers: positions, orders that arrived, records that
//! were written.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, OperationModule, Owner, StationId, Tick};
use linewright_plant::Plant;
use linewright_simulation::ConflictObserver;
use linewright_station_logic::{ModeOrder, StationReport, StationSnapshot};

use crate::checks::{OrderingLife, SeenState};
use crate::run::Finding;

/// An axis within this fraction of its stroke of where an operation ends is there; a switch is on within a thousandth.
pub(crate) const TOLERANCE: f64 = 0.005;
/// Time after reset and manual within which a coordinator that runs has left the emergency stop.
const ENDS_WITHIN: Duration = Duration::from_secs(1);
/// Time of a message and a step.
const SLACK: Duration = Duration::from_millis(60);

/// An emergency stop, from its first order until reset and manual have been given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopEpisode {
    number: u64,
    pub(crate) is_reset: bool,
    /// The line's coordinator has taken the reset, and needs no other one.
    is_reset_there: bool,
}

#[derive(Debug)]
pub(crate) struct ObservedStation {
    pub(crate) actuators: u128,
    /// When an order to move, or to stand by, arrived last.
    ordered: Option<Tick>,
    /// When an order arrived last in a mode that every station had acknowledged.
    pub(crate) enabled: Option<Tick>,
    /// Time that its records have taken since.
    pub(crate) held_up: Duration,
    /// The emergency stop has arrived at it, in this life or an earlier one.
    is_stopped: bool,
    /// Its process has it in memory.
    carries: bool,
    /// Its outputs arrived last at the coordinator, which runs its devices.
    images: Tick,
    /// Life and number of the newest of them, its bits and epoch, and when that life was first received.
    pub(crate) newest: ((u64, u64), (u128, u64), Tick),
    /// The states of the others as they arrived at it last, by station.
    pub(crate) views: Vec<SeenState>,
    /// Its own state as it sent it last, since it is so.
    pub(crate) own: SeenState,
    /// The mode of the newest order, and since when.
    pub(crate) newest_mode: (ControlMode, Tick),
    /// Until then orders may be taken for older ones.
    pub(crate) deaf_until: Tick,
    /// Coordinators whose orders have arrived at it, in this life.
    pub(crate) lives: Vec<OrderingLife>,
    /// Number of the record that it had written when it sent its state last.
    pub(crate) sent: u64,
    /// The newest epoch that it has acknowledged.
    pub(crate) acknowledged: u64,
    /// Generations that were founded, each with the life of it that was named.
    pub(crate) founded: Vec<(u64, u64)>,
    /// The generation in its last state.
    pub(crate) generation: u64,
    /// Its last record.
    pub(crate) record: Option<StationSnapshot>,
}

pub(crate) struct Observer {
    conflicts: ConflictObserver,
    lease: Duration,
    /// The mode that the coordinator orders, and the epoch in which it began to.
    pub(crate) ordered_mode: (ControlMode, u64),
    /// The epoch of the last emergency stop that it ordered.
    pub(crate) stop_epoch: u64,
    pub(crate) stations: Vec<ObservedStation>,
    pub(crate) stop: Option<StopEpisode>,
    stops: u64,
    /// The coordinator's process, and its disk, have the stop.
    process_carries: bool,
    disk_carries: bool,
    /// Epoch in which the last stop was ended by people, and when; the coordinator may order it for a moment longer.
    pub(crate) ended: u64,
    ended_at: Tick,
    is_ending: bool,
    /// The coordinator has taken the reset of that.
    ended_there: bool,
    pub(crate) finding: Option<Finding>,
}

impl Observer {
    pub(crate) fn new(line: &Line, plant: &Plant) -> Self {
        let actuators = |id: StationId| {
            line.station(id).operations.iter().fold(0, |bits, operation| {
                let back = match &operation.module {
                    OperationModule::Reversible { recovery, .. } => recovery.actuator.bit(),
                    OperationModule::Irreversible { .. } => 0,
                };
                bits | operation.normal.actuator.bit() | back
            })
        };
        let station = |id| ObservedStation {
            actuators: actuators(id),
            ordered: None,
            held_up: Duration::ZERO,
            is_stopped: false,
            carries: false,
            enabled: None,
            images: Tick::ZERO,
            newest: ((0, 0), (0, 0), Tick::ZERO),
            lives: Vec::new(),
            views: vec![SeenState::default(); line.stations.len()],
            own: SeenState::default(),
            newest_mode: (ControlMode::Home, Tick::ZERO),
            deaf_until: Tick::ZERO,
            sent: 0,
            acknowledged: 0,
            founded: Vec::new(),
            generation: 0,
            record: None,
        };
        Observer {
            conflicts: ConflictObserver::new(line, |_| plant),
            lease: line.timing.lease,
            ordered_mode: (ControlMode::Home, 0),
            stop_epoch: 0,
            stations: line.station_ids().map(station).collect(),
            stop: None,
            stops: 0,
            process_carries: false,
            disk_carries: false,
            ended: 0,
            ended_at: Tick::ZERO,
            is_ending: false,
            ended_there: false,
            finding: None,
        }
    }

    pub(crate) fn find(&mut self, at: Tick, text: String) {
        self.finding.get_or_insert(Finding { at, text });
    }

    /// No two states that exclude each other.
    pub(crate) fn look(&mut self, line: &Line, plant: &Plant, station: usize) {
        self.conflicts.look(line, |_| plant, station);
        if let Some(seen) = self.conflicts.seen().first() {
            let (at, text) = (seen.at, format!("conflict: {} ({})", line.conflicts[seen.conflict].why, seen.positions));
            self.find(at, text);
        }
        if plant.alarms() > 0 {
            self.find(plant.now(), "both directions of an axis are driven at once".to_owned());
        }
    }

    /// A process ends. What it has acknowledged as written is on its disk; of a station that is `record`.
    pub(crate) fn ended(&mut self, node: usize, record: Option<StationSnapshot>) {
        let coordinator = self.stations.len();
        match self.stations.get_mut(node) {
            Some(station) => {
                (station.carries, station.ordered, station.enabled) = (false, None, None);
                station.lives.clear();
                station.record = record;
            }
            None if node == coordinator => self.process_carries = false,
            None => {}
        }
        self.forget_stop();
    }

    /// The coordinator's disk has, or has not, kept the stop: after a loss of power, or of the journal.
    pub(crate) fn disk_keeps(&mut self, is_kept: bool) {
        self.disk_carries &= is_kept;
        self.forget_stop();
    }

    /// A coordinator that has started has the stop of its record. `is_stopped`: it is in one, which has to be reset anew.
    pub(crate) fn started(&mut self, node: usize, is_stopped: bool) {
        if node == self.stations.len() {
            if is_stopped {
                self.is_ending = false;
                self.begin_stop();
                self.disk_carries = true;
            }
            self.process_carries = self.disk_carries;
            if !self.disk_carries {
                // Its epochs may begin again below.
                self.stop_epoch = 0;
            }
            self.forget_stop();
        }
    }

    /// A stop that no process and no disk has any more is forgotten.
    fn forget_stop(&mut self) {
        let is_carried = self.process_carries || self.disk_carries || self.stations.iter().any(|at| at.carries);
        if !is_carried {
            self.end_stop();
        }
    }

    fn end_stop(&mut self) {
        self.stop = None;
        (self.process_carries, self.disk_carries) = (false, false);
        self.stations.iter_mut().for_each(|at| (at.is_stopped, at.carries) = (false, false));
    }

    pub(crate) fn stop_is_recorded(&mut self) {
        self.disk_carries |= self.stop.is_some();
    }

    pub(crate) fn stop_number(&self) -> u64 {
        self.stops
    }

    fn begin_stop(&mut self) {
        if self.stop.is_none_or(|stop| stop.is_reset) {
            self.stops += 1;
            self.stop = Some(StopEpisode { number: self.stops, is_reset: false, is_reset_there: false });
        }
    }

    /// A command has been taken by a coordinator. `is_stopped`: it is in an emergency stop, which it may have adopted from a station
    /// that has not left one whose end was seen here.
    pub(crate) fn commanded(&mut self, node: usize, command: ModeCommand, is_stopped: bool) {
        if command == ModeCommand::Reset && is_stopped && self.stop.is_none() {
            if self.is_ending {
                // The line's coordinator was suspended when people ended the stop at another one, and takes their reset now.
                self.ended_there |= node == self.stations.len();
            } else {
                self.begin_stop();
            }
        }
        match (command, &mut self.stop) {
            (ModeCommand::EStop, _) => {
                self.is_ending = false;
                self.begin_stop();
                self.process_carries |= node == self.stations.len();
            }
            (ModeCommand::Reset, Some(stop)) => {
                stop.is_reset = true;
                stop.is_reset_there |= node == self.stations.len();
            }
            _ => {}
        }
    }

    /// After reset, manual by command or at a selector ends the stop, from the present epoch on.
    pub(crate) fn manual_is_wanted(&mut self, now: Tick, epoch: u64) {
        if let Some(stop) = self.stop.filter(|stop| stop.is_reset) {
            (self.ended, self.ended_at, self.is_ending) = (epoch, now, true);
            self.ended_there = stop.is_reset_there;
            self.end_stop();
        }
    }

    /// Whether a station would be in conflict where its mechanisms are now, if they were let stand there.
    pub(crate) fn would_meet(&self, line: &Line, plant: &Plant, station: usize) -> bool {
        let mut tried = self.conflicts.clone();
        tried.look(line, |_| plant, station);
        tried.seen().len() > self.conflicts.seen().len()
    }

    /// What a forged order has as its epoch says nothing of those that follow.
    pub(crate) fn forget_lives(&mut self, at: usize) {
        self.stations[at].lives.clear();
    }

    /// A forged order has arrived at a station. Until then those of its coordinator may be taken for older ones, where it has a number
    /// that this one never gave, and a lease of an earlier life may go on: which lives the station has received orders of is not
    /// known here.
    pub(crate) fn deafened(&mut self, at: usize, until: Tick) {
        self.stations[at].deaf_until = self.stations[at].deaf_until.max(until);
    }

    /// A record of a station took so long. What it decided within its lease is put out after that: a motion that is in its
    /// record is under way, and is ended in stand-by.
    pub(crate) fn held_up(&mut self, at: usize, time: Duration) {
        self.stations[at].held_up += time;
    }

    /// A station takes an order, whose lease begins at `since`; `in_stop`: the line's coordinator still orders the stop, and whether
    /// manual waits in it, as for a station that has yet to acknowledge. Gives the number of the emergency stop whose outputs have to
    /// be off soon.
    pub(crate) fn ordered(
        &mut self,
        (now, since): (Tick, Tick),
        at: usize,
        order: &ModeOrder,
        (in_stop, manual_waits): (bool, bool),
    ) -> Option<u64> {
        self.is_ending &= in_stop;
        if order.lease > self.lease {
            // No coordinator's.
            return None;
        }
        let is_newest = self.is_newest(now, at, order);
        if is_newest && self.stations[at].newest_mode.0 != order.mode {
            self.stations[at].newest_mode = (order.mode, now);
        }
        if order.mode != ControlMode::EStop && !is_newest {
            return None;
        }
        if order.mode != ControlMode::EStop {
            if order.enabled {
                self.stations[at].enabled = Some(since);
            }
            (self.stations[at].ordered, self.stations[at].held_up) = (Some(since), Duration::ZERO);
            return None;
        }
        // A coordinator that stood when the commands arrived has not taken them, and is in the stop still. So is one that has taken
        // the reset and refuses manual.
        let goes_on = in_stop && !manual_waits && now > self.ended_at + ENDS_WITHIN;
        if self.stop.is_none() && (self.is_ending || order.epoch <= self.ended) && !goes_on {
            return None;
        }
        if self.stop.is_none() {
            self.begin_stop();
            let is_reset = self.is_ending && self.ended_there;
            self.stop = self.stop.map(|stop| StopEpisode { is_reset, is_reset_there: is_reset, ..stop });
        }
        let is_new = !self.stations[at].is_stopped;
        (self.stations[at].is_stopped, self.stations[at].carries) = (true, true);
        self.stop.filter(|_| is_new).map(|stop| stop.number)
    }

    /// Every motion is off by now, if that stop still lasts.
    pub(crate) fn has_to_be_off(&mut self, line: &Line, plant: &Plant, at: usize, stop: u64) {
        let bits = plant.outputs(Owner::Station(StationId::at(at))) & self.stations[at].actuators;
        if bits != 0 && self.stop.is_some_and(|now| now.number == stop && !now.is_reset) {
            let name = &line.stations[at].name;
            self.find(plant.now(), format!("{name}: a motion is driven after an emergency stop ({bits:#x})"));
        }
    }

    /// Outputs of a station behind the gateway have arrived.
    pub(crate) fn image_arrived(&mut self, now: Tick, at: usize, number: (u64, u64), newest: (u128, u64)) {
        let station = &mut self.stations[at];
        station.images = now;
        let ((life, sequence), _, since) = station.newest;
        if life != number.0 {
            station.newest = (number, newest, now);
        } else if number.1 > sequence {
            station.newest = (number, newest, since);
        }
    }

    /// What a station behind the gateway has not repeated for long is off.
    pub(crate) fn look_at_age(&mut self, line: &Line, plant: &Plant, now: Tick, at: usize) {
        let bits = plant.outputs(Owner::Station(StationId::at(at))) & self.stations[at].actuators;
        if bits != 0 && now > self.stations[at].images + 2 * line.timing.stale + SLACK {
            let name = &line.stations[at].name;
            self.find(
                now,
                format!("{name}: a motion is driven though its outputs have not arrived for long ({bits:#x})"),
            );
        }
    }

    /// A station puts out an image in which some outputs are on that were not.
    pub(crate) fn driven(
        &mut self,
        line: &Line,
        (now, at): (Tick, usize),
        rising: u128,
        mode: ControlMode,
        record: impl FnOnce() -> (StationSnapshot, Option<StationSnapshot>),
    ) {
        let station = &self.stations[at];
        if rising & station.actuators == 0 {
            return;
        }
        let name = &line.stations[at].name;
        if station.is_stopped && self.stop.is_some() {
            return self.find(now, format!("{name}: a motion starts in the emergency stop"));
        }
        let until = line.timing.lease + line.timing.refresh + SLACK + station.held_up;
        if station.ordered.is_none_or(|ordered| now > ordered + until) {
            return self.find(now, format!("{name}: a motion starts without a mode order, or after its lease"));
        }
        let (state, disk) = record();
        if disk.as_ref() != Some(&state) {
            return self.find(now, format!("{name}: a motion starts that its record does not have"));
        }
        if station.enabled.is_none_or(|enabled| now > enabled + until) {
            return self
                .find(now, format!("{name}: a motion starts in a mode that not every station has acknowledged"));
        }
        if self.are_two(line, now, at) {
            return self.find(now, format!("{name}: a motion starts while two coordinators give orders"));
        }
        if self.acts_on_another_order(line, now, at, mode) {
            return self.find(now, format!("{name}: a motion starts in {mode}, and the newest order is another one"));
        }
        self.starts_on_what_it_knows(line, (now, at), rising, mode);
    }

    /// A station sends its state: its record has it already.
    pub(crate) fn told(
        &mut self,
        line: &Line,
        (now, at): (Tick, usize),
        report: &StationReport,
        state: &StationSnapshot,
        disk: Option<&StationSnapshot>,
        number: u64,
    ) {
        self.stations[at].sent = number;
        self.takes_generation(line, now, at, report);
        let seen = SeenState::of(now, 0, report);
        if !seen.is_like(&self.stations[at].own) {
            self.stations[at].own = seen;
        }
        self.stations[at].acknowledged = self.stations[at].acknowledged.max(report.mode_epoch);
        // What it began with is as good as a record: nothing has happened since.
        let is_first = disk.is_none() && report.generation == 0 && report.done.iter().all(|&done| done == 0);
        let has = |disk: &StationSnapshot| {
            (&disk.done, &disk.started, disk.cycle, disk.next_request)
                == (&state.done, &state.started, state.cycle, state.next_request)
        };
        let is_there = disk.map_or(is_first, has);
        if !is_there {
            let name = &line.stations[at].name;
            self.find(
                now,
                format!("{name}: its state is sent before its record is written, or is not what was written"),
            );
        }
    }
}
