//! Sensors and model: comparisons of what `presence` names with where parts are by the marking.
//!
//! After a restart, after an answer, and at the end of each activity. A sensor that differs is a mismatch, and its resource is left
//! out until an operator has put that right.

use linewright_line::Tick;

use super::super::firing::OngoingActivity;
use super::super::ids::{CellId, FiringId, ResourceId};
use super::super::orders::PlayerOutbox;
use super::super::player::Coordination;
use super::fact::{AlarmSubject, ExceptionStep, OutOfServiceReason, RecoveryDecision, SensorMismatch, Whereabouts};
use super::request::Presence;
use super::watch::PendingComparison;
use crate::record::RecordKind;
use crate::texts::alarm;
use crate::texts::resource as resource_texts;

/// Result of comparing sensors with an answer.
pub(super) enum SensorVerdict {
    /// The reports are older than the answer.
    Wait,
    /// Something else.
    Differs(Vec<SensorMismatch>),
    /// Agreement, but for these, whose sensors give nothing.
    Agrees(Vec<ResourceId>),
}

impl Coordination {
    /// Expected value of the sensor of a resource, by the marking; none if parts are in it of which it may see one or not:
    /// in a `fifo-buffer` they come to the end by themselves, at an unknown time.
    fn expected(&self, resource: ResourceId) -> Option<bool> {
        let of = self.state.table().handling().resource(resource)?;
        let has = |cells: &[CellId]| cells.iter().any(|&cell| self.state.marking().count(cell) > 0);
        match (has(&of.sees), has(&of.has)) {
            (true, _) => Some(true),
            (false, true) => None,
            (false, false) => Some(false),
        }
    }

    /// How the sensors of an activity's resources compare with an answer that was taken at `since`.
    pub(super) fn verdict(
        &self,
        now: Tick,
        firing: &OngoingActivity,
        ruling: &RecoveryDecision,
        since: Tick,
    ) -> SensorVerdict {
        let (handling, repeat_interval) = (self.state.table().handling(), self.state.table().repeat_interval());
        let handled = handling.mode(firing.mode);
        let (mut found, mut unchecked, mut waits) = (Vec::new(), Vec::new(), false);
        for id in handled.resources() {
            let Some(station) = handling.resource(id).filter(|of| of.is_sensed).and_then(|of| of.station) else {
                continue;
            };
            if self.is_in_use(id, Some(firing.id)) {
                unchecked.push(id);
                continue;
            }
            // What was on its way while it was put right does not count.
            let seen = self.watch.seen(station).filter(|seen| seen.at >= since + repeat_interval);
            let Some(seen) = seen else {
                if now < since + handling.secure.max(repeat_interval) {
                    waits = true
                } else {
                    unchecked.push(id)
                }
                continue;
            };
            // What was put into a row has perhaps not come to its end yet.
            let is_on_its_way =
                ruling.part == Whereabouts::To && handling.resource(id).is_some_and(|of| !of.sees_all());
            let model = match handled.holder(ruling.part) == Some(id) {
                true if is_on_its_way => None,
                true => Some(true),
                false => self.expected(id),
            };
            match (seen.heard.presence, model) {
                (Presence::NoSensor | Presence::Unread, _) | (_, None) => unchecked.push(id),
                (Presence::On, Some(model @ false)) => {
                    found.push(SensorMismatch { resource: id, model, plant: true });
                }
                (Presence::Off, Some(model @ true)) => {
                    found.push(SensorMismatch { resource: id, model, plant: false });
                }
                (Presence::On, Some(true)) | (Presence::Off, Some(false)) => (),
            }
        }
        match (waits, found.is_empty()) {
            (true, _) => SensorVerdict::Wait,
            (false, false) => SensorVerdict::Differs(found),
            (false, true) => SensorVerdict::Agrees(unchecked),
        }
    }

    /// Last value of the sensor of a resource, if it has one.
    pub(in super::super) fn presence(&self, id: ResourceId) -> Presence {
        let sensed = self.state.table().handling().resource(id).filter(|of| of.is_sensed);
        let Some(station) = sensed.and_then(|of| of.station) else { return Presence::NoSensor };
        self.watch.seen(station).map_or(Presence::Unread, |seen| seen.heard.presence)
    }

    /// Difference between the sensor of a resource and a model in which nothing is under way; none if they agree or the
    /// sensor has no value.
    pub(super) fn difference(&self, id: ResourceId) -> Option<SensorMismatch> {
        let model = self.expected(id)?;
        match self.presence(id) {
            Presence::On if !model => Some(SensorMismatch { resource: id, model, plant: true }),
            Presence::Off if model => Some(SensorMismatch { resource: id, model, plant: false }),
            Presence::NoSensor | Presence::Unread | Presence::On | Presence::Off => None,
        }
    }

    /// Closes an activity that has ended, and compares the sensors of its resources with where its part is now. Where one differs by
    /// the last report, or is not read now, nothing is begun there until a later report agrees, or differs still when a sensor has had
    /// time to follow. Of a row nothing is concluded: parts come to its end some time later.
    pub(in super::super) fn end(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some(mode) = self.state.firing(id).map(|firing| firing.mode) else { return };
        self.write(now, RecordKind::Ended { firing: id }, out);
        let table = self.state.table();
        let pending = PendingComparison { agrees_from: now, differs_from: now + table.repeat_interval() };
        let resources: Vec<ResourceId> = table.handling().mode(mode).resources().collect();
        for id in resources {
            let is_row = self.state.table().handling().resource(id).is_none_or(|of| !of.sees_all());
            if !is_row && !self.is_in_use(id, None) && !self.agrees_now(now, id) {
                self.watch.uncompared.entry(id).or_insert(pending);
            }
        }
    }

    /// Whether the sensor of a resource agrees with the model by a report that is not old, or there is nothing to be compared.
    fn agrees_now(&self, now: Tick, id: ResourceId) -> bool {
        let of = self.state.table().handling().resource(id).filter(|of| of.is_sensed);
        let Some(station) = of.and_then(|of| of.station).filter(|_| self.expected(id).is_some()) else { return true };
        let seen = self.watch.seen(station).filter(|seen| seen.at + self.state.table().repeat_interval() >= now);
        seen.is_some_and(|seen| seen.heard.presence != Presence::Unread) && self.difference(id).is_none()
    }

    /// Compares model and plant of resources that have still to be compared, as soon as the plant is known and nothing is under
    /// way there.
    pub(super) fn compare_anew(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let all: Vec<(ResourceId, PendingComparison)> =
            self.watch.uncompared.iter().map(|(&id, &pending)| (id, pending)).collect();
        for (id, pending) in all {
            if self.is_in_use(id, None) {
                let from = pending.differs_from.max(now + self.state.table().repeat_interval());
                self.watch.uncompared.insert(id, PendingComparison { agrees_from: from, differs_from: from });
                continue;
            }
            let station = self.state.table().handling().resource(id).and_then(|of| of.station);
            let seen =
                station.and_then(|station| self.watch.seen(station)).filter(|seen| seen.at >= pending.agrees_from);
            let Some(at) = seen.filter(|seen| seen.heard.presence.is_known()).map(|seen| seen.at) else { continue };
            let found = self.difference(id);
            if found.is_some() && at < pending.differs_from {
                continue;
            }
            self.watch.uncompared.remove(&id);
            self.reconsider();
            if let Some(found) = found {
                self.mismatch(now, found, out);
            }
        }
    }

    /// A sensor contradicts the model: the resource is left out until an operator has put that right.
    pub(super) fn mismatch(&mut self, now: Tick, found: SensorMismatch, out: &mut PlayerOutbox) {
        let resource = found.resource;
        self.except(now, ExceptionStep::Mismatch { about: AlarmSubject::Resource(resource), found: vec![found] }, out);
        if self.state.exceptions().is_down(resource).is_none() {
            self.leave_out(now, resource, OutOfServiceReason::Mismatch, out);
        }
        let missing = self.state.resting(resource).map(|(_, part)| part).filter(|_| found.model);
        let text = resource_texts::mismatch(&self.state, &found, missing, None);
        let words = [alarm::UP].into_iter().chain(missing.map(|_| alarm::GONE)).map(str::to_owned).collect();
        self.alarm_of_resource(now, resource, (text, None), words, out);
    }
}
