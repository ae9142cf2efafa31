//! Bringing the stations of a failed activity to rest: their orders, and the evidence that they stand.
//!
//! First all are ordered to hold: the motion under way ends, the order too. Which of them go back to where their orders began is
//! decided when all stand: a station goes back only if no other one relies on where it stands. A station relies on others from the first
//! operation of its task that waits for inputs or other stations until that is taken back; there it is in a handshake. So
//!
//! - a station goes back while no other one of the activity is in a handshake, and none has completed its order;
//! - one in a handshake goes back first, and the others when it stands where its order began;
//! - of two in a handshake none goes back: a robot that has come to a clamp does not leave it when the clamp may have closed. A person
//!   leads both.
//!
//! The only station of an activity goes back at once.
//!
//! Where a person has given alarm of a resource nothing goes back: something is wrong there, and the way back may be as wrong as
//! the way on. All stations of its activities are ordered to stop, also those that are on their way back from another failure. That
//! follows from the resource's being left out for an alarm, which is a record; so a later life does the same. Nor does anything
//! go back for an order whose activity is over or not on record.

use linewright_line::{StationId, Tick};
use linewright_orders::LeaveWay;

use super::super::firing::{OngoingActivity, OngoingOrder, OrderProgress};
use super::super::ids::{FiringId, OrderKey, ResourceId};
use super::super::orders::{CellMessage, PlayerOutbox, TaskOutcome, TaskReport};
use super::super::player::Coordination;
use super::super::record::OrderFailure;
use super::super::state::PlayerState;
use super::book::ExceptionStage;
use super::fact::{ExceptionStep, SecuredState};
use super::watch::SecureRequest;

/// Request that a station leave an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SecureOrderRequest {
    pub station: StationId,
    pub key: OrderKey,
    pub way: LeaveWay,
}

/// How a station leaves an order, as far as that is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct WayToRest {
    way: LeaveWay,
    /// No other way follows.
    is_final: bool,
}

/// Where a station of a failed activity stands whose order is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OrderLeft {
    /// Where the order began.
    AtBeginning,
    /// Further, and not in a handshake.
    Apart,
    /// In a handshake, or its order is completed, or a person has led it to another rest.
    Involved,
}

impl WayToRest {
    const fn last(way: LeaveWay) -> Self {
        WayToRest { way, is_final: true }
    }

    const HOLDS: WayToRest = WayToRest { way: LeaveWay::Hold, is_final: false };
}

impl PlayerState {
    /// Whether an activity has to do with a resource: it takes part, or its station has an order.
    pub(in super::super) fn concerns(&self, firing: &OngoingActivity, resource: ResourceId) -> bool {
        let handling = self.table().handling();
        let station = handling.resource(resource).and_then(|of| of.station);
        let has_order = station.is_some_and(|station| firing.orders.iter().any(|order| order.station == station));
        has_order || handling.mode(firing.mode).resources().any(|of| of == resource)
    }

    /// Whether a station is to stop what it does for an order, whatever its activity's other stations do: alarm was given of a
    /// resource that the activity has to do with, the station is in emergency stop, or there is no such activity.
    pub fn stops(&self, station: StationId, key: OrderKey) -> bool {
        let Some((firing, _)) = self.order(key) else { return true };
        let mut down = self.exceptions().down();
        self.exceptions().is_stopped(station)
            || down.any(|(resource, down)| down.why.is_alarm() && self.concerns(firing, resource))
    }
}

impl Coordination {
    /// The stations that have to be ordered to leave an order, or to stop.
    pub(super) fn to_secure(&self, now: Tick) -> Vec<SecureOrderRequest> {
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
        let request = |(station, key)| {
            let way = self.way_to_rest(now, station, key).way;
            let is_over = || self.state.order(key).is_some_and(|(of, own)| self.order_left(now, of, own).is_some());
            (way != LeaveWay::Hold || !is_over()).then_some(SecureOrderRequest { station, key, way })
        };
        all.into_iter().filter_map(request).collect()
    }

    /// How a station leaves an order.
    fn way_to_rest(&self, now: Tick, station: StationId, key: OrderKey) -> WayToRest {
        if self.state.stops(station, key) {
            return WayToRest::last(if self.rules.stops { LeaveWay::Stop } else { LeaveWay::Back });
        }
        let Some((firing, own)) = self.state.order(key) else { return WayToRest::last(LeaveWay::Stop) };
        if !self.rules.goes_back_alone || firing.orders.iter().all(|order| order.station == own.station) {
            return WayToRest::last(LeaveWay::Back);
        }
        let stand = |order| Some((order, self.order_left(now, firing, order)?));
        let Some(stand) = firing.orders.iter().map(stand).collect::<Option<Vec<_>>>() else {
            return WayToRest::HOLDS;
        };
        // No other station of the activity is in a handshake, and none has completed its order.
        let may_go_back = |own: &OngoingOrder| {
            stand.iter().all(|(order, left)| order.station == own.station || *left != OrderLeft::Involved)
        };
        let returns = self.fresh(now, station).is_some_and(|heard| heard.slot == Some(key));
        if returns || may_go_back(own) {
            return WayToRest::last(LeaveWay::Back);
        }
        // One that has come to rest is not ordered back any more.
        let is_open = |order: &OngoingOrder| self.state.owed(firing).any(|owed| owed.key == order.key);
        let mut blocking =
            stand.iter().filter(|(order, left)| order.station != own.station && *left == OrderLeft::Involved);
        if blocking.all(|(order, _)| is_open(order) && may_go_back(order)) {
            return WayToRest::HOLDS;
        }
        WayToRest::last(LeaveWay::Stop)
    }

    /// Where a station stands whose order is over, by its last report; none if it is not over, or not known to be. One that has an
    /// order that has failed is on its way back from it.
    fn order_left(&self, now: Tick, firing: &OngoingActivity, order: &OngoingOrder) -> Option<OrderLeft> {
        let heard = self.fresh(now, order.station)?;
        let trouble = self.state.exceptions().trouble(firing.id);
        if trouble.is_some_and(|trouble| trouble.forgotten.contains(&order.station.0)) {
            return Some(OrderLeft::Involved);
        }
        let is_at_it = heard.slot == Some(order.key);
        let failed = |(key, end): &(OrderKey, TaskOutcome)| *key == order.key && matches!(end, TaskOutcome::Failed(_));
        let has_failed = heard.results.iter().any(failed);
        let is_over = match order.state {
            // A station without its memory may have completed it, and what it reports of its place was not kept.
            OrderProgress::Ended | OrderProgress::Failed(OrderFailure::Forgotten) => return Some(OrderLeft::Involved),
            OrderProgress::Failed(OrderFailure::Refused(_)) => !is_at_it,
            OrderProgress::Written | OrderProgress::Running | OrderProgress::Failed(_) => has_failed,
        };
        if !is_over {
            return None;
        }
        let handled = self.state.table().handling().mode(firing.mode);
        let begins = handled.begins.iter().find(|(id, _)| *id == order.station).map(|(_, rest)| *rest);
        Some(match heard.rest {
            _ if heard.is_in_handshake => OrderLeft::Involved,
            Some(rest) if begins.is_none_or(|begins| begins == rest) => OrderLeft::AtBeginning,
            None if heard.is_held || is_at_it => OrderLeft::Apart,
            Some(_) | None => OrderLeft::Involved,
        })
    }

    /// The last such order to a station, if there was one.
    pub(super) fn told(&self, leave: SecureOrderRequest) -> Option<SecureRequest> {
        self.watch.told.get(&leave.key).copied().filter(|told| told.way == leave.way)
    }

    /// Sends these orders, again and again until they are obeyed.
    pub(in super::super) fn send_secure(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let all = self.to_secure(now);
        if all.is_empty() && self.watch.told.is_empty() {
            return;
        }
        self.watch.told.retain(|key, _| all.iter().any(|of| of.key == *key));
        let repeat_interval = self.state.table().repeat_interval();
        for leave in all {
            let SecureOrderRequest { station, key, way } = leave;
            let told = self.told(leave);
            if told.is_none_or(|told| told.at + repeat_interval <= now) {
                let answered = told.and_then(|told| told.answered);
                let since = told.map_or(now, |told| told.since);
                self.watch.told.insert(key, SecureRequest { at: now, since, way, answered });
                out.sends.push(CellMessage::Secure { station, key, way });
            }
        }
    }

    /// Standing of a station that was ordered to leave an order so; none as long as it is uncertain.
    fn standing(&self, station: StationId, key: OrderKey, way: WayToRest) -> Option<SecuredState> {
        if !self.rules.stands_first {
            return Some(SecuredState::AtRest);
        }
        let is_at_it = |heard: &TaskReport| heard.slot == Some(key) && self.counts(heard);
        let seen = self.watch.seen(station).filter(|seen| !is_at_it(&seen.heard))?;
        let told = self.watch.told.get(&key).filter(|told| way.is_final && told.way == way.way);
        let answered = told.and_then(|told| told.answered);
        // Before the order it may not have begun to go back.
        let has_left = answered.is_some_and(|(at, is_at_it)| !is_at_it && at <= seen.at);
        let has_ended = seen.heard.results.iter().any(|(of, _)| *of == key);
        match (has_left, has_ended, seen.heard.is_held) {
            (true, _, true) => Some(SecuredState::Held),
            (true, _, false) | (_, true, false) => Some(SecuredState::AtRest),
            (false, false, _) | (false, true, true) => None,
        }
    }

    /// Time from which the stations of an activity have to come to rest: from the last order of another way, since one may go back only
    /// when another one has.
    pub(super) fn securing_since(&self, id: FiringId, failed: Tick) -> Tick {
        let orders = self.state.firing(id).into_iter().flat_map(|firing| &firing.orders);
        let told = orders.filter_map(|order| Some(self.watch.told.get(&order.key)?.since));
        told.fold(self.watch.waited_since(failed), Tick::max)
    }

    /// Records the stations that have come to rest; raises the alarm when all have.
    pub(super) fn secured(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some(trouble) = self.state.exceptions().trouble(id).filter(|of| of.stage == ExceptionStage::Securing)
        else {
            return;
        };
        let Some(firing) = self.state.firing(id) else { return };
        let is_late = self.securing_since(id, trouble.since) + self.state.table().handling().secure <= now;
        let stands = |order: &OngoingOrder| {
            let way = self.way_to_rest(now, order.station, order.key);
            let standing = self.standing(order.station, order.key, way);
            // Without what is to be done about it and how it stands: the text stays when the station has been led on.
            let fault = self.station_fault(order.station).split("; ").next().unwrap_or_default().to_owned();
            Some((order.key, standing.or(is_late.then_some(SecuredState::Unknown))?, fault))
        };
        let known: Vec<_> = self.state.owed(firing).filter_map(stands).collect();
        for (key, standing, fault) in known {
            self.except(now, ExceptionStep::Secured { firing: id, key, standing, fault }, out);
        }
        let is_over = self.state.firing(id).is_none_or(|firing| self.state.owed(firing).next().is_none());
        if is_over {
            self.ask_people(now, id, out);
        }
    }
}
