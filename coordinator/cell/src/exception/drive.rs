//! Drives exceptions on: from received reports to the next record of each.

use linewright_line::{StationId, Tick};

use super::super::firing::{ActivityPhase, OngoingActivity};
use super::super::ids::{AlarmId, FiringId, ModeId, OrderKey, PartId, ResourceId};
use super::super::orders::{PlayerOutbox, TaskReport};
use super::super::player::Coordination;
use super::super::record::{ActivityFailure, OrderFailure, RecordKind};
use super::book::ExceptionStage;
use super::compare::SensorVerdict;
use super::fact::{
    AlarmSubject, AnsweredBy, ExceptionStep, OutOfServiceReason, RecoveryDecision, SecuredState, Strategy, Whereabouts,
};
use super::policy::{PermittedAnswer, usual};
use super::request::StationUnavailable;
use crate::texts::{alarm, called};

impl Coordination {
    pub(super) fn except(&mut self, now: Tick, step: ExceptionStep, out: &mut PlayerOutbox) {
        self.write(now, RecordKind::Exception(step), out);
    }

    /// Leaves a resource out; of an activity that is still open its name is kept with the reason.
    pub(super) fn leave_out(
        &mut self,
        now: Tick,
        resource: ResourceId,
        why: OutOfServiceReason,
        out: &mut PlayerOutbox,
    ) {
        let firing = why.firing().and_then(|firing| self.state.firing(firing));
        let activity = firing.map(|firing| called(self.state.table(), firing.mode, firing.part)).unwrap_or_default();
        self.except(now, ExceptionStep::Down { resource, why, activity }, out);
    }

    /// Effects of a station's state beside its reports on orders.
    pub(in super::super) fn watch_station(
        &mut self,
        now: Tick,
        station: StationId,
        heard: &TaskReport,
        out: &mut PlayerOutbox,
    ) {
        let before = self.watch.seen(station);
        let could = self.can_work(now, station);
        let is_first = before.is_none_or(|seen| seen.heard.presence != heard.presence);
        let moved = self.moves(now, station);
        let has_come = before.map(|seen| seen.heard.rest) != Some(heard.rest);
        self.watch.hear(now, station, heard);
        if has_come && heard.rest.is_some() {
            self.watch.at_new_rest.insert(station);
        }
        if has_come || is_first || moved != self.moves(now, station) || could != self.can_work(now, station) {
            // No record shows that something can start now that could not.
            self.reconsider();
        }
        match heard.slot {
            Some(key) if !self.is_waited_for(key) => _ = self.watch.strays.insert(station),
            Some(_) | None => _ = self.watch.strays.remove(&station),
        }
        if heard.unable == Some(StationUnavailable::Devices) {
            let known = self.state.orders.keys().copied().filter(|&key| self.may_be_known(station, key));
            let lost: Vec<_> = known.filter(|&key| self.is_waited_for(key)).collect();
            for key in lost {
                self.write(now, RecordKind::OrderFailed { key, failure: OrderFailure::DevicesLost }, out);
            }
        }
    }

    fn is_waited_for(&self, key: OrderKey) -> bool {
        self.state.order(key).is_some_and(|(firing, _)| firing.phase == ActivityPhase::Running)
    }

    /// Whether a station has reported to be at an order of something that has failed, or of nothing. It has to stand
    /// before anything is concluded from where things are, and before it is given another one.
    pub(in super::super) fn moves(&self, now: Tick, station: StationId) -> bool {
        let heard = self.fresh(now, station).filter(|heard| self.counts(heard));
        heard.and_then(|heard| heard.slot).is_some_and(|key| !self.is_waited_for(key))
    }

    /// Whether the order in a station's slot counts as in progress, also where a result reports its end.
    pub(super) fn counts(&self, heard: &TaskReport) -> bool {
        let has_ended = |key| heard.results.iter().any(|(of, _)| Some(*of) == key);
        self.rules.stands_first && (self.rules.slot_counts || !has_ended(heard.slot))
    }

    /// The stations of an activity, of its orders or of its resources, that have to stand and move.
    pub(super) fn moving(&self, now: Tick, firing: &OngoingActivity) -> impl Iterator<Item = StationId> {
        let handling = self.state.table().handling();
        let ordered = firing.orders.iter().map(|order| order.station);
        let part = handling.mode(firing.mode).resources().filter_map(|id| handling.resource(id)?.station);
        ordered.chain(part).filter(move |&station| self.moves(now, station))
    }

    /// A station with an order of the activity that is in manual by itself: a person may move it.
    pub(super) fn led_by_hand(&self, firing: &OngoingActivity) -> Option<StationId> {
        let mut ordered = firing.orders.iter().map(|order| order.station);
        ordered.find(|station| self.watch.in_manual.contains_key(station))
    }

    /// Fails the orders of stations that were not received for too long.
    pub(in super::super) fn miss(&mut self, now: Tick, out: &mut PlayerOutbox) {
        while self.watch.missed_from.is_none_or(|at| at <= now) {
            match self.first_to_miss() {
                Some((at, key)) if at <= now => {
                    self.write(now, RecordKind::OrderFailed { key, failure: OrderFailure::Lost }, out);
                }
                later => {
                    self.watch.missed_from = Some(later.map_or(Tick::NEVER, |(at, _)| at));
                    return;
                }
            }
        }
    }

    /// The orders of a mode are waited for from now on.
    pub(in super::super) fn expect(&mut self, mode: ModeId) {
        let Some(lost_after) = self.state.table().handling().lost_after else { return };
        let orders = self.state.table().activity(mode).orders.iter();
        let missed = orders.map(|order| self.watch.last(order.station) + lost_after).min();
        self.watch.missed_from = self.watch.missed_from.map(|at| missed.map_or(at, |missed| at.min(missed)));
    }

    /// The order whose station will be missed first, and when.
    fn first_to_miss(&self) -> Option<(Tick, OrderKey)> {
        let lost_after = self.state.table().handling().lost_after?;
        let running = self.state.firings().filter(|firing| firing.phase == ActivityPhase::Running);
        let open = running.flat_map(|firing| firing.orders.iter().map(move |order| (firing, order)));
        let open = open.filter(|(_, order)| order.is_open());
        let missed = |(firing, order): (&OngoingActivity, &super::super::firing::OngoingOrder)| {
            ((self.watch.last(order.station) + lost_after).max(firing.spared_until), order.key)
        };
        open.map(missed).min()
    }

    /// Takes every exception as far as it goes now.
    pub(in super::super) fn attend(&mut self, now: Tick, out: &mut PlayerOutbox) {
        let open: Vec<FiringId> = self.state.exceptions().open.keys().copied().collect();
        for &id in &open {
            self.stop_stations(now, id, out);
        }
        self.leave_out_stopped(now, out);
        for id in open {
            self.secured(now, id, out);
            self.restored(now, id, out);
        }
        self.compare_anew(now, out);
        self.look_at_rests(now, out);
    }

    /// Time at which exceptions need a step without an arrival.
    pub(in super::super) fn next_of_exceptions(&self) -> Option<Tick> {
        let (secure, repeat_interval) = (self.state.table().handling().secure, self.state.table().repeat_interval());
        let limit = self.state.exceptions().open().filter_map(|(id, trouble)| match &trouble.stage {
            ExceptionStage::Securing => Some(self.securing_since(id, trouble.since) + secure),
            ExceptionStage::Restoring { ruling: _, since } => {
                Some(self.watch.waited_since(*since) + secure.max(repeat_interval))
            }
            ExceptionStage::Waiting(_) => None,
        });
        let again = self.to_secure(self.watch.now).into_iter().map(|leave| match self.told(leave) {
            Some(told) => told.at + repeat_interval,
            None => self.state.now(),
        });
        let missed = match self.watch.missed_from {
            Some(at) => Some(at).filter(|&at| at != Tick::NEVER),
            None => self.first_to_miss().map(|(at, _)| at),
        };
        limit.chain(again).chain(missed).min()
    }

    /// Permitted answers for a failed activity. Where `redo` has been answered as often as it may be, its word decides anew,
    /// unless another answer says as much: the part may well be where it was.
    pub(super) fn answers(&self, firing: &OngoingActivity, cause: ActivityFailure) -> Vec<PermittedAnswer> {
        let handling = self.state.table().handling();
        let (rule, handled) = (handling.rule(firing.mode, cause), handling.mode(firing.mode));
        let times = self.state.exceptions().times(firing.mode, firing.part);
        let can_be = |answer: &PermittedAnswer| match (answer.ruling.part, answer.ruling.then) {
            (_, Strategy::Redo) => rule.is_some_and(|rule| times < rule.retries),
            (Whereabouts::Gone, _) => handled.gone.is_some(),
            (Whereabouts::Carrier, _) => handled.carrier.is_some(),
            (Whereabouts::From | Whereabouts::To, Strategy::Backward | Strategy::Forward) => true,
        };
        let described = rule.map(|rule| &rule.answers[..]).unwrap_or_default();
        if !described.iter().any(can_be) {
            return usual().into_iter().filter(can_be).collect();
        }
        let has_from = described.iter().any(|answer| can_be(answer) && answer.leaves_it_where_it_was());
        let anew = |answer: &PermittedAnswer| match can_be(answer) {
            true => Some(answer.clone()),
            false => answer.anew().filter(|_| !has_from),
        };
        described.iter().filter_map(anew).collect()
    }

    /// No alarm where a rule is automatic and all stations are at rest; otherwise one is raised.
    pub(super) fn ask_people(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some((firing, cause)) = self.failed(id) else { return };
        let rule = self.state.table().handling().rule(firing.mode, cause);
        let answers = self.answers(firing, cause);
        let at_rest = |key| match self.state.exceptions().stands(id, key) {
            Some(SecuredState::Held | SecuredState::Unknown) => false,
            Some(SecuredState::AtRest) | None => true,
        };
        // The last reports of all count: a station that has come up anew, or is not heard any more, may stand anywhere.
        let rests = |station| {
            let is_left = !self.watch.in_manual.contains_key(&station);
            is_left && self.fresh(now, station).is_some_and(|heard| !heard.is_held && !heard.is_in_handshake)
        };
        let all_at_rest = firing.orders.iter().all(|order| at_rest(order.key) && rests(order.station));
        let first = rule.filter(|rule| rule.is_automatic && all_at_rest).and_then(|rule| rule.answers.first());
        match first.filter(|first| answers.contains(first)) {
            Some(first) => {
                let ruling = first.ruling.clone();
                self.except(now, ExceptionStep::Answered { firing: id, ruling, by: AnsweredBy::Rule }, out);
            }
            None => {
                let text = alarm::alarm(self, firing, cause, now);
                self.alarm(now, id, text, Some(String::new()), &answers, out);
            }
        }
    }

    pub(super) fn failed(&self, id: FiringId) -> Option<(&OngoingActivity, ActivityFailure)> {
        let firing = self.state.firing(id)?;
        match firing.phase {
            ActivityPhase::Failed(cause) => Some((firing, cause)),
            ActivityPhase::Running => None,
        }
    }

    fn alarm(
        &mut self,
        now: Tick,
        firing: FiringId,
        text: String,
        finding: Option<String>,
        answers: &[PermittedAnswer],
        out: &mut PlayerOutbox,
    ) {
        let alarm = AlarmId(self.state.exceptions().last_alarm + 1);
        let words = answers.iter().map(|answer| answer.ruling.word.clone()).collect();
        let about = AlarmSubject::Firing(firing);
        self.except(now, ExceptionStep::Alarmed { alarm, about, text, words, finding }, out);
    }

    /// Compares the answer with the sensors, and closes the activity if they agree.
    fn restored(&mut self, now: Tick, id: FiringId, out: &mut PlayerOutbox) {
        let Some(trouble) = self.state.exceptions().trouble(id) else { return };
        let ExceptionStage::Restoring { ruling, since } = &trouble.stage else { return };
        let (ruling, since) = (ruling.clone(), self.watch.waited_since(*since));
        let Some((firing, cause)) = self.failed(id) else { return };
        let (mode, part) = (firing.mode, firing.part);
        // In manual by itself a station may be moved after what the sensors are read for.
        let by_hand = || self.led_by_hand(firing).map(|station| alarm::led_by_hand(&self.state, &ruling, station));
        let moved = self.moving(now, firing).next().map(|station| alarm::moved(&self.state, &ruling, station));
        if let Some(finding) = moved.or_else(by_hand) {
            let text = alarm::again(&finding, &alarm::alarm(self, firing, cause, now));
            let answers = self.answers(firing, cause);
            return self.alarm(now, id, text, Some(finding), &answers, out);
        }
        match self.verdict(now, firing, &ruling, since) {
            SensorVerdict::Wait => (),
            SensorVerdict::Differs(found) => {
                let finding = alarm::differs(&self.state, &ruling, &found);
                let text = alarm::again(&finding, &alarm::alarm(self, firing, cause, now));
                let answers = self.answers(firing, cause);
                self.except(now, ExceptionStep::Mismatch { about: AlarmSubject::Firing(id), found }, out);
                self.alarm(now, id, text, Some(finding), &answers, out);
            }
            SensorVerdict::Agrees(unchecked) => match ruling.part {
                Whereabouts::Carrier => {
                    let text = alarm::carried(&self.state, mode, part);
                    let answers: Vec<_> = self.answers_of(usual().into(), mode);
                    self.except(now, ExceptionStep::Carried { firing: id }, out);
                    self.alarm(now, id, text, None, &answers, out);
                }
                Whereabouts::From | Whereabouts::To | Whereabouts::Gone => {
                    let down = self.left_out(now, firing, cause, &ruling);
                    let activity = called(self.state.table(), mode, part);
                    let involved: Vec<_> = self.state.table().handling().mode(mode).resources().collect();
                    self.except(now, ExceptionStep::Closed { firing: id, mode, part, ruling, unchecked }, out);
                    for (resource, why) in down {
                        if self.state.exceptions().is_down(resource).is_none() {
                            let activity = activity.clone();
                            self.except(now, ExceptionStep::Down { resource, why, activity }, out);
                        }
                    }
                    involved.into_iter().for_each(|resource| _ = self.stands_wrong(now, resource, out));
                }
            },
        }
    }

    fn answers_of(&self, answers: Vec<PermittedAnswer>, mode: ModeId) -> Vec<PermittedAnswer> {
        let gone = self.state.table().handling().mode(mode).gone.is_some();
        answers.into_iter().filter(|answer| gone || answer.ruling.part != Whereabouts::Gone).collect()
    }

    /// Resources that go down when an activity is closed: those of the answer, those that cannot work, and all where a station is
    /// not heard.
    fn left_out(
        &self,
        now: Tick,
        firing: &OngoingActivity,
        cause: ActivityFailure,
        ruling: &RecoveryDecision,
    ) -> Vec<(ResourceId, OutOfServiceReason)> {
        let handling = self.state.table().handling();
        let handled = handling.mode(firing.mode);
        let answers = handling.rule(firing.mode, cause).map(|rule| &rule.answers[..]).unwrap_or_default();
        let is_given = |answer: &&PermittedAnswer| {
            answer.ruling == *ruling || answer.anew().is_some_and(|anew| anew.ruling == *ruling)
        };
        let answer = answers.iter().find(is_given);
        let named = answer.iter().flat_map(|answer| answer.down.iter().copied());
        let as_whom = answer.iter().flat_map(|answer| answer.down_as.iter().filter_map(|&part| handled.holder(part)));
        let mut down: Vec<_> = named.chain(as_whom).map(|id| (id, OutOfServiceReason::Rule(firing.id))).collect();
        for order in &firing.orders {
            let stands = self.state.exceptions().stands(firing.id, order.key);
            let is_lost = stands == Some(SecuredState::Unknown) || self.obstacle(now, order.station).is_some();
            if is_lost {
                let of =
                    handling.resource_ids().filter(|id| handling.resources[id.index()].station == Some(order.station));
                down.extend(of.map(|id| (id, OutOfServiceReason::Station(firing.id))));
            }
        }
        // It may stand in any of them.
        if firing.orders.iter().any(|order| self.fresh(now, order.station).is_none()) {
            down.extend(handled.resources().map(|id| (id, OutOfServiceReason::Unheard(firing.id))));
        }
        down
    }

    /// A station's report, unless it is too old.
    pub(super) fn fresh(&self, now: Tick, station: StationId) -> Option<&TaskReport> {
        self.watch.fresh(station, now, self.state.table().handling().lost_after)
    }

    /// Whether another activity in progress has to do with a resource: then the number of its parts is uncertain.
    pub(super) fn is_in_use(&self, resource: ResourceId, but: Option<FiringId>) -> bool {
        let handling = self.state.table().handling();
        let mut others = self.state.firings().filter(|firing| Some(firing.id) != but);
        others.any(|firing| handling.mode(firing.mode).resources().any(|of| of == resource))
    }

    /// Whether a resource has parts by the marking.
    pub(super) fn has_parts(&self, resource: ResourceId) -> bool {
        let has = self.state.table().handling().resource(resource).map(|of| &of.has[..]).unwrap_or_default();
        has.iter().any(|&cell| self.state.marking().count(cell) > 0)
    }

    /// The awaited inputs of a station that are off, by its last report.
    pub(crate) fn awaited_off(&self, station: StationId) -> u128 {
        self.watch.seen(station).map_or(0, |seen| seen.heard.off)
    }

    /// The fault text of the newest report of a station; empty if it has no fault, or none is received.
    pub(crate) fn station_fault(&self, station: StationId) -> &str {
        self.watch.seen(station).map_or("", |seen| &seen.heard.fault)
    }

    /// Starts repetitions that are due, before the dispatcher is asked.
    pub(in super::super) fn again(&mut self, now: Tick, room: &mut usize, out: &mut PlayerOutbox) -> bool {
        let due: Vec<(ModeId, Option<PartId>)> = self.state.exceptions().due_again().collect();
        let mut any = false;
        for (mode, part) in due {
            let has_part = part.is_none_or(|part| self.state.takeable(mode).any(|able| able == part));
            let can = self.state.enabling().is_enabled(mode) && self.state.room(mode) > 0;
            if !can || !has_part || !self.is_heard(now, mode) || *room == 0 {
                continue;
            }
            *room -= 1;
            any = true;
            let (question, held) = (self.state.questions + 1, self.state.held().to_vec());
            self.write(now, RecordKind::Decided { question, started: vec![(mode, part)], held }, out);
            self.start_one(now, mode, part, out);
        }
        any
    }
}
