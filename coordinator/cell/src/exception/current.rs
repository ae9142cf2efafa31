//! Texts of alarms and of resources left out by the present state, which may differ from that when the alarm was raised.

use linewright_line::{RestId, StationId, Tick};

use super::super::firing::{OngoingOrder, OrderProgress};
use super::super::ids::{FiringId, ResourceId};
use super::super::player::Coordination;
use super::super::record::OrderFailure;
use super::book::Alarm;
use super::direction::StationsToLead;
use super::fact::{AlarmSubject, OutOfServiceReason, SecuredState, SensorMismatch};
use super::standing::WrongRest;
use crate::texts::alarm::{self, AlarmText, StationStanding};
use crate::texts::resource as resource_texts;

/// Present finding about a resource that is left out by rule.
enum ResourceFinding {
    /// With the rest that its station has to be brought to first, where it is closed on a part that the model has not.
    Mismatch(SensorMismatch, Option<WrongRest>),
    WrongRest(WrongRest),
    Nothing,
}

impl Coordination {
    /// Stations that an alarm asks to be led, as things are now.
    pub fn alarm_leads(&self, now: Tick, of: &Alarm) -> StationsToLead {
        match of.about {
            AlarmSubject::Firing(firing) => {
                self.failed(firing).map(|(firing, _)| self.stations_to_lead(now, firing)).unwrap_or_default()
            }
            AlarmSubject::Resource(resource) => {
                let station = self.state().table().handling().resource(resource).and_then(|of| of.station);
                let stopped = station.filter(|&station| self.state().exceptions().is_stopped(station));
                // As where it was being brought to another rest, and hand mode has ended meanwhile.
                let held = station.filter(|&station| self.held_stations().any(|id| id == station));
                let (lead, reset) = (held.into_iter().collect(), stopped.into_iter().collect());
                StationsToLead { lead, reset, ..StationsToLead::default() }
            }
        }
    }

    /// Standing of a station of a failed activity, with an emergency stop of its own before anything else.
    pub(crate) fn standing_now(&self, now: Tick, firing: FiringId, order: &OngoingOrder) -> StationStanding {
        if self.state().exceptions().is_stopped(order.station) {
            return StationStanding::EmergencyStop;
        }
        self.standing_if_reset(now, firing, order)
    }

    /// Standing of a station of a failed activity: by the station's last report where that is fresh and more exact than the
    /// record, otherwise by the record.
    pub(crate) fn standing_if_reset(&self, now: Tick, firing: FiringId, order: &OngoingOrder) -> StationStanding {
        let exceptions = self.state().exceptions();
        let received = self.fresh(now, order.station);
        let has_left = received.is_some_and(|received| received.slot.is_none());
        let is_at_rest = has_left && received.is_some_and(|received| received.rest.is_some());
        if received.is_some_and(|received| received.is_held) {
            return StationStanding::Held;
        }
        match (exceptions.stands(firing, order.key), order.state) {
            (_, OrderProgress::Ended) => StationStanding::Done,
            (Some(_), _) if received.is_some_and(|of| of.slot == Some(order.key)) => StationStanding::AtOrder,
            (Some(SecuredState::AtRest), _) => StationStanding::AtRest,
            (Some(SecuredState::Held), _) if has_left => StationStanding::AtRest,
            (Some(SecuredState::Held), _) => StationStanding::Held,
            (Some(SecuredState::Unknown), _) if is_at_rest => StationStanding::AtRest,
            (Some(SecuredState::Unknown), _) => StationStanding::Unknown,
            (None, OrderProgress::Failed(OrderFailure::Forgotten)) => StationStanding::StoreReset,
            (None, OrderProgress::Failed(_) | OrderProgress::Written | OrderProgress::Running) => {
                StationStanding::NotBegun
            }
        }
    }

    /// The station that an alarm asks to be brought to another rest in hand mode, as things are now, and that rest.
    pub fn alarm_brings(&self, now: Tick, of: &Alarm) -> Option<(StationId, RestId)> {
        let AlarmSubject::Resource(resource) = of.about else { return None };
        match self.found_now(now, resource)? {
            ResourceFinding::WrongRest(found) | ResourceFinding::Mismatch(_, Some(found)) => {
                Some((found.station, found.wanted))
            }
            ResourceFinding::Mismatch(_, None) | ResourceFinding::Nothing => None,
        }
    }

    /// The present text of the alarm that the missing part of a resource is given up; none of other alarms.
    fn given_up_now(&self, now: Tick, of: &Alarm, resource: ResourceId) -> Option<String> {
        let is_its =
            of.finding.as_ref().is_some_and(|found| *found == resource_texts::part_given_up(self.state(), resource));
        let station =
            self.state().table().handling().resource(resource).and_then(|of| of.station).filter(|_| is_its)?;
        let why = self.obstacle(now, station)?;
        Some(resource_texts::given_up(self.state(), resource, why))
    }

    /// The text of an alarm as things are now.
    pub fn alarm_text(&self, now: Tick, of: &Alarm) -> String {
        let text = match of.about {
            AlarmSubject::Firing(firing) => of.finding.as_ref().and_then(|finding| {
                let (firing, cause) = self.failed(firing)?;
                Some(alarm::again(finding, &alarm::alarm(self, firing, cause, now)))
            }),
            AlarmSubject::Resource(resource) => self
                .found_now(now, resource)
                .map(|found| match found {
                    ResourceFinding::Mismatch(found, first) => {
                        let can_be_gone = found.model && of.words.iter().any(|word| word == alarm::GONE);
                        let missing = self.state().resting(resource).map(|(_, part)| part).filter(|_| can_be_gone);
                        resource_texts::mismatch(self.state(), &found, missing, first.as_ref())
                    }
                    ResourceFinding::WrongRest(found) => resource_texts::wrong_rest(self.state(), &found),
                    ResourceFinding::Nothing => {
                        AlarmText::Agrees { resource: self.state().table().handling().resource_name(resource) }.text()
                    }
                })
                .or_else(|| self.given_up_now(now, of, resource)),
        };
        text.unwrap_or_else(|| of.text.clone())
    }

    /// Why a resource is left out, as things are now; none if it is not.
    pub fn left_out_because(&self, now: Tick, resource: ResourceId) -> Option<String> {
        let down = self.state().exceptions().is_down(resource)?;
        let is_by_itself = [OutOfServiceReason::Mismatch, OutOfServiceReason::Rest].contains(&down.why);
        Some(match self.found_now(now, resource).filter(|_| is_by_itself) {
            Some(ResourceFinding::Mismatch(..)) => OutOfServiceReason::Mismatch.text(""),
            Some(ResourceFinding::WrongRest(_)) => OutOfServiceReason::Rest.text(""),
            Some(ResourceFinding::Nothing) | None => down.why.text(&down.activity),
        })
    }

    /// Present finding about a resource. None while it cannot be determined: its station is not received, its sensor or rest is
    /// unknown, or an activity or order is in progress there.
    fn found_now(&self, now: Tick, resource: ResourceId) -> Option<ResourceFinding> {
        let handling = self.state().table().handling();
        let of = handling.resource(resource)?;
        let station = of.station?;
        let received = self.fresh(now, station).filter(|_| !self.is_in_use(resource, None))?;
        if let Some(found) = self.difference(resource) {
            let first = self.wrong_rest(resource).filter(|_| !found.model);
            return Some(ResourceFinding::Mismatch(found, first));
        }
        if let Some(found) = self.wrong_rest(resource) {
            return Some(ResourceFinding::WrongRest(found));
        }
        let rests = handling.rests.iter().any(|of| of.station == station);
        let is_known = (received.rest.is_some() || !rests) && (received.presence.is_known() || !of.is_sensed);
        (is_known && self.obstacle(now, station).is_none()).then_some(ResourceFinding::Nothing)
    }
}
