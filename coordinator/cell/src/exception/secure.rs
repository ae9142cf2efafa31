//! Bringing the stations of a failed activity to rest: their orders, and the evidence that they stand.
//!
//! Usually a station goes back to where its order began, as far as that goes by itself. Where a person has given alarm of a
//! resource nothing goes back: something is wrong there, and the way back may be as wrong as the way on. All stations of its
//! activities are ordered to stop, also those that are on their way back from another failure. That follows from the
//! resource's being left out for an alarm, which is a record; so a later life does the same.

use linewright_line::{StationId, Tick};

use super::super::firing::{OngoingActivity, OngoingOrder};
use super::super::ids::{FiringId, OrderKey, ResourceId};
use super::super::orders::{CellMessage, PlayerOutbox, TaskReport};
use super::super::player::Coordination;
use super::super::state::PlayerState;
use super::book::ExceptionStage;
use super::fact::{ExceptionStep, SecuredState};
use super::watch::SecureRequest;

/// Request that a station leave an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SecureOrderRequest {
    pub station: StationId,
    pub key: OrderKey,
    /// And to stop at once instead of going back.
    pub stop: bool,
}

impl PlayerState {
    /// Whether an activity has to do with a resource: it takes part, or its station has an order.
    pub(in super::super) fn concerns(&self, firing: &OngoingActivity, resource: ResourceId) -> bool {
        let handling = self.table().handling();
        let station = handling.resource(resource).and_then(|of| of.station);
        let has_order = station.is_some_and(|station| firing.orders.iter().any(|order| order.station == station));
        has_order || handling.mode(firing.mode).resources().any(|of| of == resource)
    }

    /// Whether a station is to stop what it does for an order: alarm was given of a resource that its activity has to do with,
    /// also if that is over by now, or of the station's own, or the station is in emergency stop.
    pub fn stops(&self, station: StationId, key: OrderKey) -> bool {
        if self.exceptions().is_stopped(station) || self.exceptions().unstopped.get(&station) == Some(&key) {
            return true;
        }
        let handling = self.table().handling();
        let firing = self.order(key).map(|(firing, _)| firing);
        let concerns = |resource: ResourceId| match firing {
            Some(firing) => self.concerns(firing, resource),
            None => handling.resource(resource).is_some_and(|of| of.station == Some(station)),
        };
        self.exceptions().down().any(|(resource, down)| down.why.is_alarm() && concerns(resource))
    }

    /// The orders of an activity that are to stop, where it is not known whether they have.
    pub(super) fn unstopped(&self, id: FiringId) -> impl Iterator<Item = (StationId, OrderKey)> {
        let orders = self.firing(id).into_iter().flat_map(|firing| &firing.orders);
        let unknown =
            move |order: &&OngoingOrder| self.exceptions().stands(id, order.key) == Some(SecuredState::Unknown);
        orders
            .filter(unknown)
            .map(|order| (order.station, order.key))
            .filter(|&(station, key)| self.stops(station, key))
    }
}

impl Coordination {
    /// The stations that have to be ordered to leave an order, or to stop.
    pub(super) fn to_secure(&self) -> Vec<SecureOrderRequest> {
        if self.is_superseded() {
            return Vec::new();
        }
        let strays =
            self.watch.strays.iter().filter_map(|&station| Some((station, self.watch.seen(station)?.heard.slot?)));
        let mut all: Vec<_> = strays.collect();
        let open = self.state.exceptions().open();
        for (id, _) in open.filter(|(_, trouble)| trouble.stage == ExceptionStage::Securing) {
            let Some(firing) = self.state.firing(id) else { continue };
            for order in self.state.owed(firing) {
                // Keys reach a station rising: an older order that it has not received would be too old for it.
                let older = self.state.unheard.get(&order.station).and_then(|keys| keys.first());
                if older.is_none_or(|&older| order.key < older) {
                    all.push((order.station, order.key));
                }
            }
        }
        all.sort_unstable();
        all.dedup();
        let stops = |station, key| self.rules.stops && self.state.stops(station, key);
        all.into_iter().map(|(station, key)| SecureOrderRequest { station, key, stop: stops(station, key) }).collect()
    }

    /// The last such order to a station, if there was one.
    pub(super) fn told(&self, leave: SecureOrderRequest) -> Option<SecureRequest> {
        // An order to go back is none to stop.
        self.watch.told.get(&leave.key).copied().filter(|told| told.stop || !leave.stop)
    }

    /// Sends these orders, again and again until they are obeyed.
    pub(in super::super) fn send_secure(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let all = self.to_secure();
        if all.is_empty() && self.watch.told.is_empty() {
            return;
        }
        self.watch.told.retain(|key, _| all.iter().any(|of| of.key == *key));
        let repeat_interval = self.state.table().repeat_interval();
        for leave in all {
            let SecureOrderRequest { station, key, stop } = leave;
            if self.told(leave).is_none_or(|told| told.at + repeat_interval <= now) {
                let answered = self.watch.told.get(&key).and_then(|told| told.answered);
                self.watch.told.insert(key, SecureRequest { at: now, stop, answered });
                out.sends.push(CellMessage::Secure { station, key, stop });
            }
        }
    }

    /// Standing of a station that was ordered to leave an order; none as long as it is uncertain.
    fn standing(&self, station: StationId, key: OrderKey) -> Option<SecuredState> {
        if !self.rules.stands_first {
            return Some(SecuredState::AtRest);
        }
        let is_at_it = |heard: &TaskReport| heard.slot == Some(key) && self.counts(heard);
        let seen = self.watch.seen(station).filter(|seen| !is_at_it(&seen.heard))?;
        let answered = self.watch.told.get(&key).and_then(|told| told.answered);
        // Before the order it may not have begun to go back.
        let has_left = answered.is_some_and(|(at, is_at_it)| !is_at_it && at <= seen.at);
        let has_ended = seen.heard.results.iter().any(|(of, _)| *of == key);
        match (has_left, has_ended, seen.heard.is_held) {
            (true, _, true) => Some(SecuredState::Held),
            (true, _, false) | (_, true, false) => Some(SecuredState::AtRest),
            (false, false, _) | (false, true, true) => None,
        }
    }

    /// Records the stations that have come to rest; raises the alarm when all have.
    pub(super) fn secured(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some(trouble) = self.state.exceptions().trouble(id).filter(|of| of.stage == ExceptionStage::Securing)
        else {
            return;
        };
        let Some(firing) = self.state.firing(id) else { return };
        let is_late = trouble.since + self.state.table().handling().secure <= now;
        let stands = |order: &OngoingOrder| {
            let late = is_late.then_some(SecuredState::Unknown);
            Some((order.key, self.standing(order.station, order.key).or(late)?))
        };
        let known: Vec<_> = self.state.owed(firing).filter_map(stands).collect();
        for (key, standing) in known {
            self.except(now, ExceptionStep::Secured { firing: id, key, standing }, out);
        }
        let is_over = self.state.firing(id).is_none_or(|firing| self.state.owed(firing).next().is_none());
        if is_over {
            self.ask_people(now, id, out);
        }
    }
}
