//! Nodes that are not active: a station's, and the coordinator's own.
//!
//! A station whose node is not active follows no order, and its outputs are off. It counts as one that is not received, at once and for
//! everything that is decided; only the reason that operators read is another one. Its life is not taken, so no order names it before it
//! is active.
//!
//! A coordinator that is not active grants no mode that enables motion, as if another coordinator gave orders: auto and hand end in
//! stand-by, so does manual, and of the commands only emergency stop is obeyed. It goes on receiving stations and console.

use linewright_lifecycle::LifecycleState;
use linewright_line::StationId;

use super::{Coordinator, ModeRefusal};

impl Coordinator {
    /// The coordinator's own node.
    pub(super) fn take_lifecycle(&mut self, state: LifecycleState) {
        let inactive = (state != LifecycleState::Active).then_some(state);
        self.changed |= self.inactive != inactive;
        self.inactive = inactive;
        if inactive.is_some() {
            // What was commanded before does not wait for activity.
            self.manual_all = false;
            self.resume.disarm();
        }
    }

    /// A station has reported that its node is not active.
    pub(super) fn hear_inactive(&mut self, id: StationId, state: LifecycleState) {
        let until = self.now + 2 * self.line.timing.stale;
        let Some(station) = self.stations.get_mut(id.index()) else { return };
        self.changed |= self.now < station.known_until || station.inactive.map(|of| of.0) != Some(state);
        station.known_until = station.known_until.min(self.now);
        station.inactive = Some((state, until));
    }

    /// Of the stations that are left out, those whose nodes are not active.
    pub(super) fn inactive_left_out(&self) -> impl Iterator<Item = ModeRefusal> {
        let isolated = self.line.station_ids().zip(&self.stations).filter(|(_, station)| station.isolated);
        let reasons = isolated.filter(|(_, of)| !self.is_known(of)).map(|(id, _)| self.silence(id));
        reasons.filter(|reason| matches!(reason, ModeRefusal::Inactive(..)))
    }

    /// State of a station's node by its last report, if that is not active and still counts.
    pub fn inactive_node(&self, station: StationId) -> Option<LifecycleState> {
        let inactive = self.stations.get(station.index())?.inactive;
        inactive.filter(|(_, until)| self.now < *until).map(|(state, _)| state)
    }

    /// Reason against motion of a station that is not received.
    pub(super) fn silence(&self, id: StationId) -> ModeRefusal {
        match self.inactive_node(id) {
            Some(state) => ModeRefusal::Inactive(id, state),
            None => ModeRefusal::NotHeard(id),
        }
    }
}
