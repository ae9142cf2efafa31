//! What people say: answers to alarms, alarms of their own, what is down and what is up again.

use linewright_line::Tick;

use super::super::firing::{Firing, Phase};
use super::super::ids::{AlarmId, FiringId, ResourceId};
use super::super::orders::{Event, Outbox};
use super::super::player::Coordination;
use super::super::record::{Cause, Fact};
use super::fact::{About, By, DownCause, Ruling, Step, Whereabouts};
use super::watch::{Asked, Objection, Presence};
use super::words;

impl Coordination {
    /// Takes an answer, unless stations say that it cannot be.
    pub(in super::super) fn answer(&mut self, now: Tick, alarm: AlarmId, word: &str, out: &mut Outbox) {
        match self.answered(now, alarm, word, out) {
            Ok(()) => (),
            Err(why) => out.events.push(Event::Objected { to: Asked::Answer(alarm), why }),
        }
    }

    fn answered(&mut self, now: Tick, alarm: AlarmId, word: &str, out: &mut Outbox) -> Result<(), Objection> {
        let about = self.state.exceptions().alarm(alarm).ok_or(Objection::NoSuchAlarm)?.about;
        match about {
            About::Resource(resource) if word == words::UP => self.try_up(now, resource, out),
            About::Resource(resource) if word == words::GONE => self.try_gone(now, resource, out),
            About::Resource(_) => Err(Objection::NoSuchWord),
            About::Firing(firing) => {
                let ruling = self.ruling(now, firing, alarm, word)?;
                self.except(now, Step::Answered { firing, ruling, by: By::Operator }, out);
                Ok(())
            }
        }
    }

    /// What the words mean that can be answered to an alarm of an activity.
    pub fn rulings(&self, alarm: AlarmId) -> Vec<Ruling> {
        let Some(said) = self.state.exceptions().alarm(alarm) else { return Vec::new() };
        let failed = match said.about {
            About::Firing(firing) => self.failed(firing),
            About::Resource(_) => None,
        };
        let Some((firing, cause)) = failed else { return Vec::new() };
        // Rules may have changed since the alarm was given, and an alarm may have other answers than its rule.
        let known: Vec<_> = self.answers(firing, cause).into_iter().chain(super::handling::usual()).collect();
        let meant = |word: &String| known.iter().find(|answer| answer.ruling.word == *word);
        said.words.iter().filter_map(|word| Some(meant(word)?.ruling.clone())).collect()
    }

    fn ruling(&self, now: Tick, id: FiringId, alarm: AlarmId, word: &str) -> Result<Ruling, Objection> {
        let (firing, _) = self.failed(id).ok_or(Objection::NoSuchAlarm)?;
        let ruling = self.rulings(alarm).into_iter().find(|ruling| ruling.word == word).ok_or(Objection::NoSuchWord)?;
        let handling = self.state.table().handling();
        let fresh = |station| self.watch.fresh(station, now, handling.stale);
        if let Some(station) = self.moving(now, firing) {
            return Err(Objection::Moves(station));
        }
        // Somebody who carries and works may have another part.
        let carrier = handling.mode(firing.mode).carrier;
        let carrier = carrier.filter(|&of| !self.has_parts(of) && !self.is_in_use(of, Some(id)));
        let sensed = carrier.and_then(|id| Some((id, handling.resource(id).filter(|of| of.is_sensed)?.station?)));
        let presence = sensed.and_then(|(id, station)| Some((id, fresh(station)?.presence)));
        match (presence, ruling.part) {
            (Some((id, Presence::On)), Whereabouts::From | Whereabouts::To | Whereabouts::Gone) => {
                Err(Objection::HasPart(id))
            }
            (Some((id, Presence::Off)), Whereabouts::Carrier) => Err(Objection::HasNoPart(id)),
            (Some((_, Presence::On)), Whereabouts::Carrier)
            | (Some((_, Presence::Off)), Whereabouts::From | Whereabouts::To | Whereabouts::Gone)
            | (Some((_, Presence::Unknown)) | None, _) => Ok(ruling),
        }
    }

    /// Takes an alarm that a person gives of a resource: it is left out, and what it is doing has failed and is stopped.
    pub(in super::super) fn alarmed(&mut self, now: Tick, resource: ResourceId, text: &str, out: &mut Outbox) {
        if self.state.table().handling().resource(resource).is_none() {
            let why = Objection::NoSuchResource;
            return out.events.push(Event::Objected { to: Asked::Alarm(resource), why });
        }
        if self.state.exceptions().is_down(resource).is_none_or(|down| !down.why.is_alarm()) {
            let why = DownCause::Alarm { text: text.to_owned() };
            self.except(now, Step::Down { resource, why }, out);
        }
        let running = self.state.firings().filter(|firing| firing.phase == Phase::Running);
        let its = running.filter(|firing| self.state.concerns(firing, resource));
        let its: Vec<FiringId> = its.map(|firing| firing.id).collect();
        for firing in its {
            self.fail(now, firing, Cause::ByHand { resource }, out);
        }
    }

    /// Leaves a resource out, or counts on it again. What it is doing it finishes.
    pub(in super::super) fn set_resource(&mut self, now: Tick, resource: ResourceId, up: bool, out: &mut Outbox) {
        let (to, done) = if up {
            (Asked::Up(resource), self.try_up(now, resource, out))
        } else {
            (Asked::Down(resource), self.try_down(now, resource, out))
        };
        if let Err(why) = done {
            out.events.push(Event::Objected { to, why });
        }
    }

    fn try_down(&mut self, now: Tick, resource: ResourceId, out: &mut Outbox) -> Result<(), Objection> {
        self.state.table().handling().resource(resource).ok_or(Objection::NoSuchResource)?;
        if self.state.exceptions().is_down(resource).is_some() {
            return Err(Objection::AlreadySo);
        }
        self.except(now, Step::Down { resource, why: DownCause::ByHand { text: String::new() } }, out);
        Ok(())
    }

    /// The part that a resource should have is no more, if its sensor does not see it.
    fn try_gone(&mut self, now: Tick, resource: ResourceId, out: &mut Outbox) -> Result<(), Objection> {
        if self.is_in_use(resource, None) {
            return Err(Objection::Open(resource));
        }
        let (mode, part) = self.state.resting(resource).ok_or(Objection::NoSuchWord)?;
        if self.presence(resource) == Presence::On {
            return Err(Objection::HasPart(resource));
        }
        self.except(now, Step::Missing { resource, mode, part }, out);
        self.try_up(now, resource, out)
    }

    /// A resource is up if its station can work, nothing of it waits for an answer, and its sensor agrees.
    fn try_up(&mut self, now: Tick, resource: ResourceId, out: &mut Outbox) -> Result<(), Objection> {
        let handling = self.state.table().handling();
        let of = handling.resource(resource).ok_or(Objection::NoSuchResource)?;
        let (station, is_sensed) = (of.station, of.is_sensed);
        if self.state.exceptions().is_down(resource).is_none() {
            return Err(Objection::AlreadySo);
        }
        let is_its = |firing: &Firing| self.state.concerns(firing, resource);
        let is_open = |(id, _)| self.state.firing(id).is_some_and(is_its);
        if self.state.exceptions().open().any(is_open) {
            return Err(Objection::Open(resource));
        }
        if let Some(why) = station.and_then(|station| self.objection(now, station)) {
            return Err(why);
        }
        if let Some(found) = self.difference(resource) {
            self.mismatch(now, found, out);
            return Ok(());
        }
        let unchecked = is_sensed && self.presence(resource) == Presence::Unknown;
        self.watch.uncompared.remove(&resource);
        self.except(now, Step::Up { resource, unchecked }, out);
        Ok(())
    }

    /// An activity has failed.
    pub(in super::super) fn fail(&mut self, now: Tick, firing: FiringId, cause: Cause, out: &mut Outbox) {
        let orders =
            self.state.firing(firing).map(|firing| firing.orders.iter().map(|order| order.key).collect::<Vec<_>>());
        orders.into_iter().flatten().for_each(|key| self.not_sent(key));
        self.write(now, Fact::Raised { firing, cause }, out);
    }
}
