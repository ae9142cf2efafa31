//! Reports of stations in this life: which of them count, and since when. None of it outlives a restart.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::{StationId, Tick};
use linewright_orders::LeaveWay;

use super::super::ids::{OrderKey, ResourceId};
use super::super::orders::{TaskReply, TaskReport};
use super::super::player::Coordination;
use super::super::state::PlayerState;
use super::request::{AlarmAnswerRefusal, Presence};

/// Last report of a station.
#[derive(Clone, Debug)]
pub(super) struct LastReport {
    /// Time of arrival.
    pub at: Tick,
    /// Content of the report.
    pub heard: TaskReport,
}

/// The last order to leave an order.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecureRequest {
    pub at: Tick,
    /// Time of the first one of this way.
    pub since: Tick,
    pub way: LeaveWay,
    /// Time of the reply to it, and whether it is still at it.
    pub answered: Option<(Tick, bool)>,
}

/// Reports of stations in this life.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct StationMonitor {
    began: Tick,
    /// Time of the last step.
    pub(super) now: Tick,
    seen: BTreeMap<StationId, LastReport>,
    /// Until then no station with an order is missed; none if that has to be computed. A report makes it later, and so does
    /// an end: only a start can make it sooner.
    pub(super) missed_from: Option<Tick>,
    pub(super) told: BTreeMap<OrderKey, SecureRequest>,
    /// Stations at an order that no activity waits for.
    pub(super) strays: BTreeSet<StationId>,
    /// Stations that a person leads in manual while the others are in auto, and the epoch since which it is so.
    pub(super) in_manual: BTreeMap<StationId, u64>,
    /// Stations that have come to a rest, and have not been looked at there.
    pub(super) at_new_rest: BTreeSet<StationId>,
    /// Resources of which model and plant have still to be compared: not in this life, or with a difference when an activity ended.
    pub(super) uncompared: BTreeMap<ResourceId, PendingComparison>,
}

/// Which reports of a resource's sensor count.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingComparison {
    /// One of this time or later that agrees with the model ends it.
    pub(super) agrees_from: Tick,
    /// One of this time or later that differs is a mismatch: what was under way before has come to its end.
    pub(super) differs_from: Tick,
}

impl StationMonitor {
    /// Of a life that begins. What a life before has left is compared with the plant, also by one without records: its log
    /// may be lost, and the parts still be there. Then nothing can be under way, so reports count at once.
    pub fn new(state: &PlayerState, now: Tick) -> Self {
        let handling = state.table().handling();
        let from = if state.epoch() == 0 { now } else { now + state.table().grace() };
        let sensed = handling.resource_ids().filter(|id| handling.resources[id.index()].is_sensed);
        let pending = PendingComparison { agrees_from: from, differs_from: from };
        let uncompared = sensed.map(|id| (id, pending)).collect();
        StationMonitor { began: now, now, uncompared, ..StationMonitor::default() }
    }

    /// Time from which what is waited for counts that has begun at `since`: nothing was received before this life.
    pub fn waited_since(&self, since: Tick) -> Tick {
        since.max(self.began)
    }

    /// A step begins. Returns its time.
    pub fn steps(&mut self, now: Tick) -> Tick {
        self.now = now;
        now
    }

    /// Takes a station's report.
    pub fn hear(&mut self, now: Tick, station: StationId, heard: &TaskReport) {
        let seen = self.seen.entry(station).or_insert_with(|| LastReport { at: now, heard: TaskReport::default() });
        seen.at = now;
        seen.heard.clone_from(heard);
    }

    /// Takes a station's reply to the order to leave an order. One to less than the last one does not count.
    pub fn answered(&mut self, now: Tick, key: OrderKey, way: LeaveWay, reply: TaskReply) {
        let is_at_it = match reply {
            TaskReply::Running => true,
            TaskReply::Ended(_) | TaskReply::Refused(_) => false,
        };
        let told = self.told.get_mut(&key).filter(|told| told.way <= way);
        told.into_iter().for_each(|told| told.answered = Some((now, is_at_it)));
    }

    /// A report that an order is done.
    pub fn done(&mut self, station: StationId, key: OrderKey) {
        if let Some(seen) = self.seen.get_mut(&station).filter(|seen| seen.heard.slot == Some(key)) {
            // Where it has come to it says in its next report.
            (seen.heard.slot, seen.heard.rest) = (None, None);
            self.strays.remove(&station);
        }
    }

    /// The stations between two rests, at no order.
    pub(super) fn held(&self) -> impl Iterator<Item = StationId> + '_ {
        self.seen.iter().filter(|(_, seen)| seen.heard.is_held).map(|(&station, _)| station)
    }

    /// Last report of a station.
    pub(super) fn seen(&self, station: StationId) -> Option<&LastReport> {
        self.seen.get(&station)
    }

    /// Time of a station's last report; beginning of this life if there was none.
    pub(super) fn last(&self, station: StationId) -> Tick {
        self.seen.get(&station).map_or(self.began, |seen| seen.at)
    }

    /// A station's report, unless it is too old.
    pub(super) fn fresh(&self, station: StationId, now: Tick, lost_after: Option<Duration>) -> Option<&TaskReport> {
        let seen =
            self.seen.get(&station).filter(|seen| lost_after.is_none_or(|lost_after| seen.at + lost_after > now));
        seen.map(|seen| &seen.heard)
    }

    /// Reason why a station could not be given an order.
    pub(super) fn objection(
        &self,
        station: StationId,
        now: Tick,
        lost_after: Option<Duration>,
    ) -> Option<AlarmAnswerRefusal> {
        let Some(heard) = self.fresh(station, now, lost_after) else {
            return Some(AlarmAnswerRefusal::NotHeard(station));
        };
        if heard.is_held {
            return Some(AlarmAnswerRefusal::NotAtRest(station));
        }
        heard.unable.map(|unable| AlarmAnswerRefusal::CannotWork(station, unable))
    }

    /// Whether a resource has still to be compared, and can be, or may be when its station is heard, or its sensor is read. Only
    /// a station that has no such sensor leaves nothing to be compared.
    pub fn is_to_be_compared(&self, state: &PlayerState, resource: ResourceId) -> bool {
        let station = |id: ResourceId| state.table().handling().resource(id)?.station;
        let knows = |station| self.seen.get(&station).is_none_or(|seen| seen.heard.presence != Presence::NoSensor);
        !self.uncompared.is_empty() && self.uncompared.contains_key(&resource) && station(resource).is_some_and(knows)
    }
}

impl Coordination {
    /// This process has stood, or its machine has slept: nothing that was received before counts, as at the beginning of a life.
    pub fn stood(&mut self, now: Tick) {
        self.watch = StationMonitor::new(&self.state, now.max(self.state.now()));
        self.heard.clear();
        self.reconsider();
    }
}
