//! Situation of the line, for the cell and for the database; and the answer of the cell: the stations that are not treated
//! like the others.

use std::collections::{BTreeMap, BTreeSet};

use linewright_coordinator_cell::Coordination;
use linewright_coordinator_cell::exception::isolated;
use linewright_coordinator_logic::ManualPermit;
use linewright_coordinator_shell::orders::manual_permit;
use linewright_history::Note;
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};

/// Situation of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSituation {
    /// Activities may start.
    pub starts: bool,
    pub mode: ControlMode,
    /// By station: its state is received.
    pub heard: Vec<bool>,
    /// By station: it has its devices, by its last state.
    pub devices: Vec<bool>,
    /// The stations in manual by themselves, and the epoch since which they are.
    pub in_manual: BTreeMap<StationId, u64>,
}

/// Stations that the cell has the rest of the coordinator treat unlike the others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IsolatedStations {
    /// Their faults are the cell's alone.
    pub isolated: BTreeSet<StationId>,
    /// They are in emergency stop by themselves.
    pub stopped: BTreeSet<StationId>,
    /// They stand between two rests, at no order.
    pub held: BTreeSet<StationId>,
    /// What is permitted at each while the others are in auto.
    pub permits: BTreeMap<StationId, ManualPermit>,
    /// The cell decides nothing now: faults that are not the cell's yet are the line's.
    pub is_unattended: bool,
}

impl IsolatedStations {
    /// As it follows from the state of the cell, which decides nothing while its log cannot be written.
    pub fn of(coordination: &Coordination, line: &Line, now: Tick, is_unattended: bool) -> Self {
        let state = coordination.state();
        let stopped = state.exceptions().stopped().collect();
        let held = coordination.held_stations().collect();
        let permit = |id| (id, manual_permit(coordination, line, now, id));
        let permits = line.station_ids().map(permit).collect();
        IsolatedStations { isolated: isolated(state), stopped, held, permits, is_unattended }
    }

    /// What is permitted at a station.
    pub fn permit(&self, station: StationId) -> Option<ManualPermit> {
        let permit = self.permits.get(&station).copied();
        permit.map(|permit| if self.is_unattended { ManualPermit::Unattended } else { permit })
    }
}

impl LineSituation {
    /// Of a line of so many stations that has just begun: nothing may start, and no station was received.
    pub fn new(stations: usize) -> Self {
        LineSituation {
            starts: false,
            mode: ControlMode::StandBy,
            heard: vec![false; stations],
            devices: vec![false; stations],
            in_manual: BTreeMap::new(),
        }
    }

    /// One that differs in everything: the notes since it are of the whole situation, also of what is lost.
    pub fn opposite(&self) -> Self {
        let stopped = self.mode == ControlMode::EStop;
        let not = |all: &[bool]| all.iter().map(|is| !is).collect();
        LineSituation {
            starts: !self.starts,
            mode: if stopped { ControlMode::StandBy } else { ControlMode::EStop },
            heard: not(&self.heard),
            devices: not(&self.devices),
            in_manual: self.in_manual.clone(),
        }
    }

    /// Changes since `before`, for the database.
    pub fn notes_since(&self, before: &LineSituation) -> impl Iterator<Item = Note> {
        let is_stopped = |of: &LineSituation| of.mode == ControlMode::EStop;
        let mode = ((self.mode, self.starts) != (before.mode, before.starts))
            .then(|| Note::Mode { name: self.mode.name().to_owned(), starts: self.starts });
        let stop = (is_stopped(self) != is_stopped(before)).then(|| Note::EmergencyStop { on: is_stopped(self) });
        let stations =
            changed(&self.heard, &before.heard).map(|(station, heard)| Note::Station { station, lost: !heard });
        let devices = changed(&self.devices, &before.devices);
        // A station reports its devices as a whole.
        let devices = devices.map(|(station, there)| Note::Device { station, device: String::new(), lost: !there });
        mode.into_iter().chain(stop).chain(stations).chain(devices)
    }
}

/// The stations with a change, and their new value.
fn changed(now: &[bool], before: &[bool]) -> impl Iterator<Item = (u16, bool)> {
    let both = (0..).zip(now.iter().zip(before));
    both.filter(|(_, (now, before))| now != before).map(|(station, (&now, _))| (station, now))
}

/// The note of a station's fault, with its cause and place as operators read it, if that is not as it was last noted. With none
/// noted yet it is noted in any case: a fault that was noted in an earlier life and has gone meanwhile is over.
pub fn fault_note(noted: &mut Option<String>, station: u16, text: &str) -> Option<Note> {
    if noted.as_deref() == Some(text) {
        return None;
    }
    *noted = Some(text.to_owned());
    Some(Note::Fault { station, text: text.to_owned() })
}
