//! Emergency stop of single stations, by a rule (seed 001 §5.2, L206: "the exception module can send emergency
//! stoppage orders to the controllers").
//!
//! A rule names stations that go into emergency stop as soon as its failure is known: their outputs go off whatever they are
//! doing, for this activity or for another, which then fails by that. The others stay in their mode. The player only names
//! the stations; the mode decision orders it as it orders the mode (`Coordinator::stop_alone`), over and over, so that a
//! station that is started again gets it again. Their task orders are stopped as well.
//!
//! Each is a record, and lasts until an operator resets that station: no change of mode ends it, no restart, and no answer.
//! Reset it follows the line's mode again. It is put right then like any other that stands half-way. Its resource is left out
//! from the stop on, so being reset starts nothing; it comes up when its station stands at a rest and can work.

use std::collections::BTreeSet;

use linewright_line::{StationId, Tick};

use super::super::firing::ActivityPhase;
use super::super::ids::{FiringId, ResourceId};
use super::super::orders::{CellEvent, PlayerOutbox};
use super::super::player::Coordination;
use super::book::ExceptionStage;
use super::fact::{ExceptionStep, OutOfServiceReason};
use super::request::{AlarmAnswerRefusal, ResourceRequest, StationUnavailable};

impl Coordination {
    /// Has the stations stopped that the rule of a failed activity names, once.
    pub(super) fn stop_stations(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some(trouble) = self.state.exceptions().trouble(id).filter(|of| of.stage == ExceptionStage::Securing)
        else {
            return;
        };
        let Some((firing, cause)) = self.failed(id) else { return };
        let Some(rule) = self.state.table().handling().rule(firing.mode, cause) else { return };
        let own = firing.orders.iter().map(|order| order.station).filter(|_| rule.stops_activity);
        let named: BTreeSet<StationId> = rule.stops.iter().copied().chain(own).collect();
        let new: Vec<StationId> = named.into_iter().filter(|station| !trouble.stopped.contains(&station.0)).collect();
        for station in new {
            self.except(now, ExceptionStep::Stopped { firing: id, station }, out);
        }
    }

    /// Leaves out the resources of stopped stations. Nothing of them counts as up before its station is reset.
    pub(super) fn leave_out_stopped(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let exceptions = self.state.exceptions();
        let handling = self.state.table().handling();
        let because = |id: ResourceId| exceptions.stopped.get(&handling.resource(id)?.station?).copied();
        let up = handling.resource_ids().filter(|&id| exceptions.is_down(id).is_none());
        let new: Vec<_> = up.filter_map(|id| Some((id, because(id)?))).collect();
        for (resource, firing) in new {
            self.leave_out(now, resource, OutOfServiceReason::EmergencyStop(firing), out);
        }
    }

    /// Reset of a station that is in emergency stop by itself.
    pub(in super::super) fn reset(&mut self, now: Tick, station: StationId, out: &mut PlayerOutbox) {
        match self.against_reset(now, station) {
            None => self.except(now, ExceptionStep::Reset { station }, out),
            Some(why) => out.events.push(CellEvent::Objected { to: ResourceRequest::Reset(station), why }),
        }
    }

    fn against_reset(&self, now: Tick, station: StationId) -> Option<AlarmAnswerRefusal> {
        if !self.state.exceptions().is_stopped(station) {
            return Some(AlarmAnswerRefusal::AlreadySo);
        }
        match self.fresh(now, station) {
            None => Some(AlarmAnswerRefusal::NotHeard(station)),
            // It has not received the stop, or an activity that it works for has not failed yet: the station would be ordered
            // back, and would go once it is reset.
            Some(heard) => {
                (heard.slot.is_some() || self.is_working(station)).then_some(AlarmAnswerRefusal::Moves(station))
            }
        }
    }

    fn is_working(&self, station: StationId) -> bool {
        let mut running = self.state.firings().filter(|firing| firing.phase == ActivityPhase::Running);
        running.any(|firing| firing.orders.iter().any(|order| order.station == station))
    }

    /// Reason why a station could not be given an order.
    pub(in super::super) fn objection(&self, now: Tick, station: StationId) -> Option<AlarmAnswerRefusal> {
        if self.state.exceptions().is_stopped(station) {
            return Some(AlarmAnswerRefusal::EmergencyStop(station));
        }
        // Not by its report: it is so from the moment at which the coordinator gives it.
        if self.watch.in_manual.contains_key(&station) {
            return Some(AlarmAnswerRefusal::CannotWork(station, StationUnavailable::InManual));
        }
        self.watch.objection(station, now, self.state.table().handling().lost_after)
    }

    /// Why a station could not be given an order when hand and manual mode are over: in them it stands at its rests as in auto,
    /// and nothing is ordered of it before they end.
    pub(super) fn obstacle(&self, now: Tick, station: StationId) -> Option<AlarmAnswerRefusal> {
        let by_hand = AlarmAnswerRefusal::CannotWork(station, StationUnavailable::ByHand);
        self.objection(now, station).filter(|why| *why != by_hand)
    }

    /// Whether a station that was received in this life can be given an order.
    pub(in super::super) fn can_work(&self, now: Tick, station: StationId) -> bool {
        self.objection(now, station).is_none()
    }
}
