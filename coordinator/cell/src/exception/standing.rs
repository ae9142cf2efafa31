//! Whether the station of a resource stands at a rest where its next task begins.
//!
//! A machine that rests clamped gets the order to clamp when the next part comes, and takes that on only at its open rest. Where the
//! model changes and the station does not (a part was taken away by hand, or brought), nothing would ever begin there. Then the
//! resource is left out, and an alarm names the rest and the way to it. The coordinator does not move the station by itself:
//! a person may still be at it; in hand mode the person who holds the button sees what moves.

use linewright_line::{RestId, StationId, Tick};

use super::super::ids::{AlarmId, ModeId, ResourceId};
use super::super::orders::PlayerOutbox;
use super::super::player::Coordination;
use super::book::Alarm;
use super::fact::{AlarmSubject, ExceptionStep, OutOfServiceReason};
use crate::texts::alarm;
use crate::texts::resource as resource_texts;

/// A station that stands at another rest than the model has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WrongRest {
    pub resource: ResourceId,
    pub station: StationId,
    /// Where it stands.
    pub stands: RestId,
    /// Where this mode begins, which is next.
    pub wanted: RestId,
    pub next: ModeId,
    /// By the model there is a part.
    pub has_part: bool,
}

/// A station that stands at another rest than its task of an activity begins at: it would refuse that order each time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OtherRest {
    pub station: StationId,
    /// Where it stands.
    pub stands: RestId,
    /// Where its task begins.
    pub wanted: RestId,
}

impl Coordination {
    /// The first station of a mode that stands at another rest than its task begins at, by its last report; none where that is not known.
    pub(crate) fn other_rest(&self, mode: ModeId) -> Option<OtherRest> {
        self.state.table().handling().mode(mode).begins.iter().find_map(|&(station, wanted)| {
            let stands = self.watch.seen(station)?.heard.rest.filter(|stands| *stands != wanted)?;
            Some(OtherRest { station, stands, wanted })
        })
    }

    /// Whether the next look at rests leaves out a resource of this mode.
    pub(crate) fn is_to_be_left_out(&self, mode: ModeId) -> bool {
        let Some(OtherRest { station, .. }) = self.other_rest(mode) else { return false };
        let handling = self.state.table().handling();
        let mut of_station =
            handling.resource_ids().filter(|&id| handling.resources[id.index()].station == Some(station));
        self.watch.at_new_rest.contains(&station) && of_station.any(|resource| self.wrong_rest(resource).is_some())
    }

    /// Leaves resources out whose stations have been led to a rest from which nothing can be done with them, in hand mode or by
    /// themselves. Each is looked at once for each rest that it has come to, when nothing is under way there and it could work.
    pub(super) fn look_at_rests(&mut self, now: Tick, out: &mut PlayerOutbox) {
        if !self.starts || self.watch.at_new_rest.is_empty() {
            return;
        }
        for station in self.watch.at_new_rest.clone() {
            let handling = self.state.table().handling();
            let resource = handling.resource_ids().find(|&id| handling.resources[id.index()].station == Some(station));
            let is_busy = resource.is_some_and(|resource| self.is_in_use(resource, None));
            if is_busy || self.objection(now, station).is_some() || self.moves(now, station) {
                continue;
            }
            self.watch.at_new_rest.remove(&station);
            let in_service = |&id: &ResourceId| self.state.exceptions().is_down(id).is_none();
            if let Some(resource) = resource.filter(in_service) {
                self.stands_wrong(now, resource, out);
            }
        }
    }

    /// Where the station of a resource should stand and does not; none as well where that is not decided: something is under way
    /// there, its rest is not known, there is room for several parts, one of the next activities has no order for the station, or another one
    /// begins where it stands.
    pub(super) fn wrong_rest(&self, resource: ResourceId) -> Option<WrongRest> {
        let (state, table) = (&self.state, self.state.table());
        let handling = table.handling();
        let of = handling.resource(resource).filter(|of| of.is_single && !of.has.is_empty())?;
        let station = of.station?;
        let stands = self.watch.seen(station)?.heard.rest?;
        if self.is_in_use(resource, None) {
            return None;
        }
        let has_part = self.has_parts(resource);
        let next: Vec<ModeId> = if has_part {
            let with_part = of.has.iter().filter(|&&cell| state.marking().count(cell) > 0);
            with_part.flat_map(|&cell| table.consumers(cell)).copied().collect()
        } else {
            let brings = |mode: &ModeId| {
                let handled = handling.mode(*mode);
                handled.to == Some(resource) && handled.from != Some(resource)
            };
            table.modes().filter(brings).collect()
        };
        let begins =
            |mode: ModeId| handling.mode(mode).begins.iter().find(|(id, _)| *id == station).map(|(_, rest)| *rest);
        // An activity of other resources that begins where it stands may lead it on.
        let is_led_on = table.modes().any(|mode| {
            let handled = handling.mode(mode);
            ![handled.from, handled.to].contains(&Some(resource)) && begins(mode) == Some(stands)
        });
        if is_led_on {
            return None;
        }
        let wanted: Vec<(ModeId, RestId)> =
            next.iter().map(|&mode| Some((mode, begins(mode)?))).collect::<Option<_>>()?;
        let &(next, rest) = wanted.first().filter(|_| wanted.iter().all(|(_, rest)| *rest != stands))?;
        Some(WrongRest { resource, station, stands, wanted: rest, next, has_part })
    }

    /// Leaves a resource out whose station stands at a rest where nothing can be done with it, with an alarm that says what to
    /// do; whether that is so.
    pub(super) fn stands_wrong(&mut self, now: Tick, resource: ResourceId, out: &mut PlayerOutbox) -> bool {
        let Some(found) = self.wrong_rest(resource) else { return false };
        if self.state.exceptions().is_down(resource).is_none() {
            self.leave_out(now, resource, OutOfServiceReason::Rest, out);
        }
        let text = resource_texts::wrong_rest(&self.state, &found);
        self.alarm_of_resource(now, resource, (text, None), vec![alarm::UP.to_owned()], out);
        true
    }

    /// Raises an alarm of a resource, with what was found after an answer where its text begins with that. One that stands with the same
    /// text and answers keeps its number.
    pub(super) fn alarm_of_resource(
        &mut self,
        now: Tick,
        resource: ResourceId,
        (text, finding): (String, Option<String>),
        words: Vec<String>,
        out: &mut PlayerOutbox,
    ) {
        let about = AlarmSubject::Resource(resource);
        let is_same = |alarm: &Alarm| alarm.about == about && alarm.text == text && alarm.words == words;
        if !self.state.exceptions().alarms().any(is_same) {
            let alarm = AlarmId(self.state.exceptions().last_alarm + 1);
            self.except(now, ExceptionStep::Alarmed { alarm, about, text, words, finding }, out);
        }
    }
}
