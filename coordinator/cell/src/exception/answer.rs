//! Operators' input: answers to alarms, alarms of their own, resources down and up again.

use linewright_line::{StationId, Tick};

use super::super::firing::{ActivityPhase, OngoingActivity};
use super::super::ids::{AlarmId, FiringId, ResourceId};
use super::super::orders::{CellEvent, PlayerOutbox};
use super::super::player::Coordination;
use super::super::record::{ActivityFailure, RecordKind};
use super::fact::{AlarmSubject, AnsweredBy, ExceptionStep, OutOfServiceReason, RecoveryDecision, Whereabouts};
use super::request::{AlarmAnswerRefusal, Presence, ResourceRequest, StationUnavailable};
use crate::texts::alarm;
use crate::texts::resource as resource_texts;

impl Coordination {
    /// Takes an answer, unless the stations' states contradict it.
    pub(in super::super) fn answer(&mut self, now: Tick, alarm: AlarmId, word: &str, out: &mut PlayerOutbox) {
        match self.answered(now, alarm, word, out) {
            Ok(()) => (),
            Err(why) => out.events.push(CellEvent::Objected { to: ResourceRequest::Answer(alarm), why }),
        }
    }

    fn answered(
        &mut self,
        now: Tick,
        alarm: AlarmId,
        word: &str,
        out: &mut PlayerOutbox,
    ) -> Result<(), AlarmAnswerRefusal> {
        let asked = self.state.exceptions().alarm(alarm).ok_or(AlarmAnswerRefusal::NoSuchAlarm)?;
        let is_permitted = asked.words.iter().any(|permitted| permitted == word);
        match asked.about {
            AlarmSubject::Resource(_) if !is_permitted => Err(AlarmAnswerRefusal::NoSuchWord),
            AlarmSubject::Resource(resource) if word == alarm::UP => self.try_up(now, resource, out),
            AlarmSubject::Resource(resource) if word == alarm::GONE => self.try_gone(now, resource, out),
            AlarmSubject::Resource(_) => Err(AlarmAnswerRefusal::NoSuchWord),
            AlarmSubject::Firing(firing) => {
                let ruling = self.ruling(now, firing, alarm, word)?;
                self.except(now, ExceptionStep::Answered { firing, ruling, by: AnsweredBy::Operator }, out);
                Ok(())
            }
        }
    }

    /// Meaning of the words that are permitted answers to an alarm of an activity.
    pub fn rulings(&self, alarm: AlarmId) -> Vec<RecoveryDecision> {
        let Some(said) = self.state.exceptions().alarm(alarm) else { return Vec::new() };
        let failed = match said.about {
            AlarmSubject::Firing(firing) => self.failed(firing),
            AlarmSubject::Resource(_) => None,
        };
        let Some((firing, cause)) = failed else { return Vec::new() };
        // Rules may have changed since the alarm was given, and an alarm may have other answers than its rule.
        let known: Vec<_> = self.answers(firing, cause).into_iter().chain(super::policy::usual()).collect();
        let meant = |word: &String| known.iter().find(|answer| answer.ruling.word == *word);
        said.words.iter().filter_map(|word| Some(meant(word)?.ruling.clone())).collect()
    }

    fn ruling(
        &self,
        now: Tick,
        id: FiringId,
        alarm: AlarmId,
        word: &str,
    ) -> Result<RecoveryDecision, AlarmAnswerRefusal> {
        let (firing, _) = self.failed(id).ok_or(AlarmAnswerRefusal::NoSuchAlarm)?;
        let ruling =
            self.rulings(alarm).into_iter().find(|ruling| ruling.word == word).ok_or(AlarmAnswerRefusal::NoSuchWord)?;
        let handling = self.state.table().handling();
        if let Some(station) = self.moving(now, firing).next() {
            return Err(AlarmAnswerRefusal::Moves(station));
        }
        // In manual by itself it may still be moved, also from where its order began: the activity keeps all it has taken.
        if let Some(station) = self.led_by_hand(firing) {
            return Err(AlarmAnswerRefusal::CannotWork(station, StationUnavailable::InManual));
        }
        // Where the part is of a station between two rests is decided when it is led on. And it may stand in a resource whose room
        // closing would give to others: until it stands at a rest the activity keeps all it has taken. With `carrier` it stays open.
        let mut ordered = firing.orders.iter().map(|order| order.station);
        if ruling.part != Whereabouts::Carrier
            && let Some(station) = ordered.find(|&station| self.fresh(now, station).is_some_and(|of| of.is_held))
        {
            let is_stopped = self.state.exceptions().is_stopped(station);
            let why = if is_stopped { AlarmAnswerRefusal::EmergencyStop } else { AlarmAnswerRefusal::NotAtRest };
            return Err(why(station));
        }
        // A resource that carries and works may have another part.
        let carrier = handling.mode(firing.mode).carrier;
        let carrier = carrier.filter(|&of| !self.has_parts(of) && !self.is_in_use(of, Some(id)));
        let sensed = carrier.and_then(|id| Some((id, handling.resource(id).filter(|of| of.is_sensed)?.station?)));
        let presence = sensed.and_then(|(id, station)| Some((id, self.fresh(now, station)?.presence)));
        match (presence, ruling.part) {
            (Some((id, Presence::On)), Whereabouts::From | Whereabouts::To | Whereabouts::Gone) => {
                Err(AlarmAnswerRefusal::HasPart(id))
            }
            (Some((id, Presence::Off)), Whereabouts::Carrier) => Err(AlarmAnswerRefusal::HasNoPart(id)),
            (Some((_, Presence::On)), Whereabouts::Carrier)
            | (Some((_, Presence::Off)), Whereabouts::From | Whereabouts::To | Whereabouts::Gone)
            | (Some((_, Presence::NoSensor | Presence::Unread)) | None, _) => Ok(()),
        }?;
        if ruling.part == Whereabouts::Carrier {
            return Ok(ruling);
        }
        match self.unheard(now, id) {
            Some((station, resource)) => Err(AlarmAnswerRefusal::Unheard(station, resource)),
            None => Ok(ruling),
        }
    }

    /// The first task-driven station of an activity that is not heard, and the resource to take out of service if it
    /// stays so; none as well where that is done. It may stand anywhere, also in a resource whose room closing the
    /// activity would give to others.
    pub fn unheard(&self, now: Tick, firing: FiringId) -> Option<(StationId, ResourceId)> {
        let firing = self.state.firing(firing)?;
        let handling = self.state.table().handling();
        let mut silent =
            firing.orders.iter().map(|order| order.station).filter(|&station| self.fresh(now, station).is_none());
        silent.find_map(|station| {
            let its = |id: &ResourceId| handling.resources[id.index()].station == Some(station);
            let mut of: Vec<ResourceId> = handling.resource_ids().filter(its).collect();
            if of.is_empty() {
                of = handling.mode(firing.mode).resources().collect();
            }
            let first = *of.first()?;
            of.iter().all(|&id| self.state.exceptions().is_down(id).is_none()).then_some((station, first))
        })
    }

    /// Takes an alarm given by hand of a resource: it is left out, and its activities have failed and are stopped.
    pub(in super::super) fn alarmed(&mut self, now: Tick, resource: ResourceId, text: &str, out: &mut PlayerOutbox) {
        if self.state.table().handling().resource(resource).is_none() {
            let why = AlarmAnswerRefusal::NoSuchResource;
            return out.events.push(CellEvent::Objected { to: ResourceRequest::Alarm(resource), why });
        }
        if self.state.exceptions().is_down(resource).is_none_or(|down| !down.why.is_alarm()) {
            let why = OutOfServiceReason::Alarm { text: text.to_owned() };
            self.leave_out(now, resource, why, out);
        }
        let running = self.state.firings().filter(|firing| firing.phase == ActivityPhase::Running);
        let its = running.filter(|firing| self.state.concerns(firing, resource));
        let its: Vec<FiringId> = its.map(|firing| firing.id).collect();
        for firing in its {
            self.fail(now, firing, ActivityFailure::ByHand { resource }, out);
        }
    }

    /// Leaves a resource out, or counts on it again. It finishes its activities.
    pub(in super::super) fn set_resource(&mut self, now: Tick, resource: ResourceId, up: bool, out: &mut PlayerOutbox) {
        let (to, done) = if up {
            (ResourceRequest::Up(resource), self.try_up(now, resource, out))
        } else {
            (ResourceRequest::Down(resource), self.try_down(now, resource, out))
        };
        if let Err(why) = done {
            out.events.push(CellEvent::Objected { to, why });
        }
    }

    fn try_down(&mut self, now: Tick, resource: ResourceId, out: &mut PlayerOutbox) -> Result<(), AlarmAnswerRefusal> {
        self.state.table().handling().resource(resource).ok_or(AlarmAnswerRefusal::NoSuchResource)?;
        if self.state.exceptions().is_down(resource).is_some() {
            return Err(AlarmAnswerRefusal::AlreadySo);
        }
        self.leave_out(now, resource, OutOfServiceReason::ByHand { text: String::new() }, out);
        Ok(())
    }

    /// The part that a resource should have is no more, if its sensor does not see it.
    fn try_gone(&mut self, now: Tick, resource: ResourceId, out: &mut PlayerOutbox) -> Result<(), AlarmAnswerRefusal> {
        if self.is_in_use(resource, None) {
            return Err(AlarmAnswerRefusal::Open(resource));
        }
        let (mode, part) = self.state.resting(resource).ok_or(AlarmAnswerRefusal::NoSuchWord)?;
        let station = self.state.table().handling().resource(resource).and_then(|of| of.station);
        // What a station reported that is not heard any more may be so no longer. One that was not heard yet, as after a start, is waited for.
        let is_heard = station.is_some_and(|station| self.fresh(now, station).is_some());
        let lost_after = self.state.table().handling().lost_after;
        let is_lost = |id| lost_after.is_some_and(|lost_after| self.watch.last(id) + lost_after <= now);
        if let Some(station) = station.filter(|&id| !is_heard && !is_lost(id)) {
            return Err(AlarmAnswerRefusal::NotHeard(station));
        }
        if is_heard && self.presence(resource) == Presence::On {
            return Err(AlarmAnswerRefusal::HasPart(resource));
        }
        // What is refused is not done in part.
        self.is_settled(resource)?;
        self.except(now, ExceptionStep::Missing { resource, mode, part }, out);
        // The answer is taken; what is left to be done has an alarm of its own. The resource stays out of service: with its station away, or
        // between two rests, nothing begins there, and its sensor is compared when it is counted on again.
        if let Some(why) = station.and_then(|station| self.obstacle(now, station)) {
            let text = resource_texts::given_up(&self.state, resource, why);
            let finding = resource_texts::part_given_up(&self.state, resource);
            self.alarm_of_resource(now, resource, (text, Some(finding)), vec![alarm::UP.to_owned()], out);
            return Ok(());
        }
        if self.stands_wrong(now, resource, out) {
            return Ok(());
        }
        self.try_up(now, resource, out)
    }

    /// Whether it is out of service, and nothing of it waits for an answer.
    fn is_settled(&self, resource: ResourceId) -> Result<(), AlarmAnswerRefusal> {
        self.state.table().handling().resource(resource).ok_or(AlarmAnswerRefusal::NoSuchResource)?;
        if self.state.exceptions().is_down(resource).is_none() {
            return Err(AlarmAnswerRefusal::AlreadySo);
        }
        let is_its = |firing: &OngoingActivity| self.state.concerns(firing, resource);
        let is_open = |(id, _)| self.state.firing(id).is_some_and(is_its);
        match self.state.exceptions().open().any(is_open) {
            true => Err(AlarmAnswerRefusal::Open(resource)),
            false => Ok(()),
        }
    }

    /// Whether its station can work, and nothing of it waits for an answer.
    fn may_be_up(&self, now: Tick, resource: ResourceId) -> Result<(), AlarmAnswerRefusal> {
        self.is_settled(resource)?;
        let station = self.state.table().handling().resource(resource).and_then(|of| of.station);
        station.and_then(|station| self.obstacle(now, station)).map_or(Ok(()), Err)
    }

    /// A resource is up if it may be, and its sensor agrees.
    fn try_up(&mut self, now: Tick, resource: ResourceId, out: &mut PlayerOutbox) -> Result<(), AlarmAnswerRefusal> {
        self.may_be_up(now, resource)?;
        let is_sensed = self.state.table().handling().resource(resource).is_some_and(|of| of.is_sensed);
        if let Some(found) = self.difference(resource) {
            self.mismatch(now, found, out);
            return Err(AlarmAnswerRefusal::Contradicted(resource));
        }
        if self.stands_wrong(now, resource, out) {
            return Err(AlarmAnswerRefusal::WrongRest(resource));
        }
        let unchecked = is_sensed && !self.presence(resource).is_known();
        self.watch.uncompared.remove(&resource);
        self.except(now, ExceptionStep::Up { resource, unchecked }, out);
        Ok(())
    }

    /// An activity has failed.
    pub(in super::super) fn fail(
        &mut self,
        now: Tick,
        firing: FiringId,
        cause: ActivityFailure,
        out: &mut PlayerOutbox,
    ) {
        let orders =
            self.state.firing(firing).map(|firing| firing.orders.iter().map(|order| order.key).collect::<Vec<_>>());
        orders.into_iter().flatten().for_each(|key| self.not_sent(key));
        self.write(now, RecordKind::Raised { firing, cause }, out);
    }
}
