//! Stations that are left out of the mode decision or in emergency stop by themselves; and the mode in words.
//!
//! In a cell a fault of a station is an exception of its order. The station is then left out of the mode decision, or it is in
//! emergency stop by itself, whatever the mode: the cell names the stations again and again, and nothing here remembers them. A
//! station leaves its emergency stop only by an epoch of its own, so that no order which is older than its reset can end it;
//! until it has acknowledged that epoch, its report of an emergency stop is ignored.

use linewright_line::StationId;
use linewright_line::net::ControlMode;

use super::{Coordinator, StationEntry, StationView};
use crate::refusal::{ModeRefusal, RefusedCommand};
use crate::texts::{ModeText, reason_texts};

impl Coordinator {
    /// Leaves these stations out, and no others: their faults are exceptions of the cell they work in (found by the
    /// cell), and the others work on. Only task-driven stations can be left out. Call it whenever that changes, before
    /// [`Coordinator::step`]. The second argument of `stations`: the station is received.
    pub fn isolate(&mut self, stations: impl Fn(StationId, bool) -> bool) {
        for (id, station) in self.line.station_ids().zip(&mut self.stations) {
            let isolated = station.task_driven && stations(id, self.now < station.known_until);
            self.changed |= station.isolated != isolated;
            station.isolated = isolated;
        }
    }

    /// Sets the task-driven stations that stand between two rests without a task. Auto has nothing to continue there, so it
    /// is refused while there is one. To be called whenever that set changes.
    pub fn hold(&mut self, stations: impl Fn(StationId) -> bool) {
        for (id, station) in self.line.station_ids().zip(&mut self.stations) {
            station.held = station.task_driven && stations(id);
        }
    }

    /// The stations that the mode depends on. Where people move stations, and in the emergency stop, that is all of them.
    pub(super) fn counted(&self) -> impl Iterator<Item = (StationId, &StationEntry)> {
        self.counted_in(self.mode)
    }

    /// The same of another mode: a command is judged by the stations that count where it leads.
    pub(super) fn counted_in(&self, mode: ControlMode) -> impl Iterator<Item = (StationId, &StationEntry)> {
        let leaves_out = match mode {
            ControlMode::Home | ControlMode::StandBy | ControlMode::Auto => true,
            ControlMode::Hand | ControlMode::Manual | ControlMode::EStop => false,
        };
        let is_out = move |station: &StationEntry| {
            leaves_out && (station.isolated || station.stopped || station.single.in_force)
        };
        self.line.station_ids().zip(&self.stations).filter(move |(_, station)| !is_out(station))
    }

    /// Reasons of one station against motion in auto and hand.
    pub(super) fn troubles_of(&self, id: StationId, station: &StationEntry, reasons: &mut Vec<ModeRefusal>) {
        if !self.is_known(station) {
            reasons.push(self.silence(id));
            return;
        }
        if !station.heard.devices_valid {
            reasons.push(match station.had_devices {
                true => ModeRefusal::DevicesLost(id),
                false => ModeRefusal::DevicesAwaited(id),
            });
        }
        if station.heard.incomplete && !self.is_index_in_doubt(id) {
            reasons.push(ModeRefusal::Incomplete(id, station.heard.incomplete_op));
        }
        if station.heard.position_lost {
            reasons.push(ModeRefusal::PositionLost(id));
        }
        if station.restarted {
            reasons.push(ModeRefusal::Restarted(id));
        }
    }

    /// The stations left out of the mode decision that keep the line from home.
    pub(super) fn left_out_away(&self) -> Vec<ModeRefusal> {
        let counted: Vec<StationId> = self.counted().map(|(id, _)| id).collect();
        let left_out = self.line.station_ids().zip(&self.stations).filter(|(id, _)| !counted.contains(id));
        let away = left_out.filter_map(|(id, station)| match self.is_known(station) {
            false => Some(self.silence(id)),
            true => (!station.heard.at_home).then_some(ModeRefusal::NotAtHome(id)),
        });
        away.collect()
    }

    /// These stations are in emergency stop by themselves, and no others. Only task-driven stations can be. Call it whenever that
    /// changes, before [`Coordinator::step`].
    pub fn stop_alone(&mut self, stations: impl Fn(StationId) -> bool) {
        let next = self.epoch.saturating_add(1);
        let mut any_is_reset = false;
        for (id, station) in self.line.station_ids().zip(&mut self.stations) {
            let stopped = station.task_driven && stations(id);
            self.changed |= station.stopped != stopped;
            if station.stopped && !stopped {
                (station.reset_in, any_is_reset) = (next, true);
            }
            station.stopped = stopped;
        }
        if any_is_reset {
            // The mode stays, and goes on meanwhile.
            self.epoch = next;
        }
    }

    /// Whether a station is in emergency stop, by itself or with the line.
    pub fn is_stopped(&self, station: StationId) -> bool {
        self.mode == ControlMode::EStop || self.stations.get(station.index()).is_some_and(|station| station.stopped)
    }

    /// The epoch in which a station's emergency stop was entered or left last: earlier decisions are not acted on after it.
    pub fn stopped_until(&self, station: StationId) -> u64 {
        self.stopped_in.max(self.stations.get(station.index()).map_or(0, |station| station.reset_in))
    }

    /// Whether a station is stopped by another coordinator, or by one before that left no journal.
    pub(super) fn is_stopped_by_another(&self, id: StationId, heard: StationView) -> bool {
        let station = &self.stations[id.index()];
        let knows_better = heard.mode_epoch >= self.released.max(station.reset_in);
        heard.estopped && !self.is_stopped(id) && knows_better
    }

    /// Stations that have not acknowledged the epoch of a mode that enables motion.
    pub fn waiting_for(&self) -> Vec<StationId> {
        if !self.mode.enables_motion() || self.enabled {
            return Vec::new();
        }
        let waits = |s: &StationEntry| !self.is_known(s) || s.heard.mode_epoch < self.epoch;
        self.counted().filter(|&(id, s)| waits(s) || !self.has_founded(id)).map(|(id, _)| id).collect()
    }

    /// An index that was stopped, of a station whose position is lost: it is not led on before a person has looked.
    pub(super) fn is_index_in_doubt(&self, id: StationId) -> bool {
        let heard = &self.stations[id.index()].heard;
        heard.position_lost && heard.incomplete_op.is_some_and(|op| self.line.station(id).index_of(op).is_some())
    }

    /// Whether a station is heard.
    pub fn hears(&self, station: StationId) -> bool {
        self.stations.get(station.index()).is_some_and(|s| self.is_known(s))
    }

    /// Whether something stands against motion, or has ended a mode that nothing has followed yet.
    pub fn is_troubled(&self) -> bool {
        self.ended.is_some() || !self.troubles_in(self.mode).is_empty()
    }

    /// Refusals of commands since the last step.
    pub fn refusals(&self) -> &[RefusedCommand] {
        &self.refusals
    }

    /// The text of the mode, with the reasons that keep it.
    pub fn text(&self) -> String {
        self.text_with("")
    }

    /// The same with the time at which the emergency stop was latched ([`Coordinator::stop_cause`]), as people read it.
    pub fn text_with(&self, stopped_at: &str) -> String {
        let name = |id| self.line.station(id).name.as_str();
        let stations = || self.line.station_ids().zip(&self.stations);
        let texts = |reasons: &[ModeRefusal]| reason_texts(reasons, &self.line, |_| String::new());
        let mut troubles = self.troubles_in(self.mode);
        if self.mode == ControlMode::Home {
            // Start leads to manual with it, and auto is refused then.
            troubles.extend(self.which(|heard| heard.selector_manual, ModeRefusal::SelectorManual));
        }
        // What keeps a station left out that no message names otherwise: it reports, and is not received.
        troubles.extend(self.inactive_left_out());
        let is_other = |reasons: &[ModeRefusal]| reasons.iter().any(|reason| !troubles.contains(reason));
        let ended = self.ended.as_ref().filter(|(_, reasons)| is_other(reasons));
        let named = |of: &mut dyn Iterator<Item = (StationId, Vec<ModeRefusal>)>| {
            of.map(|(id, reasons)| (name(id), texts(&reasons))).collect()
        };
        let text = ModeText {
            stopping: self.stopping,
            stop: self.estop.map(|(cause, _)| cause.text(&self.line)),
            button: self.estop_button(),
            stopped_at,
            found_away: self.found_away,
            waiting: self.waiting_for().into_iter().map(name).collect(),
            without: stations().filter(|(_, station)| station.isolated).map(|(id, _)| name(id)).collect(),
            stopped: stations().filter(|(_, station)| station.stopped).map(|(id, _)| name(id)).collect(),
            manual: named(&mut self.singles()),
            selectors: named(&mut self.idle_selectors()),
            ended: ended.map(|(mode, reasons)| (*mode, texts(reasons))),
            troubles: texts(&troubles),
        };
        text.text(self.mode)
    }
}
