//! Effect of the records of exceptions on a state. As in [`super::super::apply`], they are checked first, then applied.

use linewright_line::{StationId, Tick};

use super::super::firing::{ActivityPhase, OngoingActivity, OngoingOrder, OrderProgress};
use super::super::ids::{AlarmId, CellId, FiringId, ModeId, OrderKey, PartId, ResourceId, TokenDemand};
use super::super::record::OrderFailure;
use super::super::state::{PartPlace, PlayerState};
use super::book::{Alarm, ExceptionStage, Exceptions, FailedActivity, OutOfService, Retry};
use super::fact::{AlarmSubject, ExceptionStep, RecoveryDecision, Strategy, Whereabouts};

type ExceptionFitResult = Result<(), String>;

impl PlayerState {
    /// The exceptions of this state.
    pub fn exceptions(&self) -> &Exceptions {
        &self.exceptions
    }

    /// Applies a step of an exception.
    pub(in super::super) fn exception(&mut self, step: &ExceptionStep, at: Tick) -> ExceptionFitResult {
        match step {
            ExceptionStep::Secured { firing, key, standing, fault } => {
                self.owes(*firing, *key)?;
                let trouble = self.trouble(*firing)?;
                trouble.standing.push((*key, *standing));
                trouble.faults.extend((!fault.is_empty()).then(|| (*key, fault.clone())));
                Ok(())
            }
            ExceptionStep::Alarmed { alarm, about, text, words, finding } => self.alarmed(Alarm {
                id: *alarm,
                since: at,
                about: *about,
                text: text.clone(),
                words: words.clone(),
                finding: finding.clone(),
            }),
            ExceptionStep::Answered { firing, ruling, by: _ } => {
                let trouble = self.trouble(*firing)?;
                let alarm = match &trouble.stage {
                    ExceptionStage::Securing => None,
                    ExceptionStage::Waiting(alarm) => Some(*alarm),
                    ExceptionStage::Restoring { .. } => return Err(format!("{firing} was answered already")),
                };
                trouble.stage = ExceptionStage::Restoring { ruling: ruling.clone(), since: at };
                alarm.map(|alarm| self.exceptions.alarms.remove(&alarm));
                Ok(())
            }
            ExceptionStep::Carried { firing } => match self.restoring(*firing)?.part {
                Whereabouts::Carrier => Ok(()),
                part @ (Whereabouts::From | Whereabouts::To | Whereabouts::Gone) => {
                    Err(format!("the part of {firing} is not with its carrier, but {part:?}"))
                }
            },
            ExceptionStep::Closed { firing, mode, part, ruling, unchecked: _ } => {
                self.closed(*firing, (*mode, *part), ruling, at)
            }
            ExceptionStep::Mismatch { about, found: _ } => match about {
                AlarmSubject::Firing(firing) => self.restoring(*firing).map(|_| ()),
                AlarmSubject::Resource(resource) => self.known(*resource),
            },
            ExceptionStep::Missing { resource, mode, part } => self.missing(*resource, *mode, *part),
            ExceptionStep::Stopped { station, .. } if !self.table().handling().knows_station(*station) => {
                Err(format!("station {} is none of this cell", station.0))
            }
            ExceptionStep::Stopped { firing, station } => {
                self.trouble(*firing)?.stopped.push(station.0);
                self.exceptions.stopped.entry(*station).or_insert(*firing);
                Ok(())
            }
            ExceptionStep::Reset { station } => {
                let was = self.exceptions.stopped.remove(station).map(|_| ());
                was.ok_or_else(|| format!("station {} is not in emergency stop", station.0))
            }
            ExceptionStep::Down { resource, why, activity } => {
                self.down(*resource, OutOfService { since: at, why: why.clone(), activity: activity.clone() })
            }
            ExceptionStep::Up { resource, unchecked: _ } => self.up(*resource),
        }
    }

    /// An activity has failed: its exception begins.
    pub(in super::super) fn exception_begins(&mut self, firing: FiringId, at: Tick) {
        let trouble = FailedActivity {
            since: at,
            standing: Vec::new(),
            faults: Vec::new(),
            stopped: Vec::new(),
            forgotten: Vec::new(),
            stage: ExceptionStage::Securing,
        };
        self.exceptions.open.insert(firing, trouble);
    }

    /// A station has come up without its memory.
    pub(in super::super) fn forgets(&mut self, station: StationId) {
        for (id, trouble) in &mut self.exceptions.open {
            let orders = self.firings.get(id).map_or(&[][..], |firing| &firing.orders);
            if orders.iter().any(|order| order.station == station) && !trouble.forgotten.contains(&station.0) {
                trouble.forgotten.push(station.0);
            }
        }
    }

    /// Updates the repetitions when an activity has started or ended.
    pub(in super::super) fn moves_on(&mut self, mode: ModeId, part: Option<PartId>, ends: bool) {
        if self.exceptions.retries.is_empty() {
            return;
        }
        let key = self.retry_key(mode, part);
        let retries = &mut self.exceptions.retries;
        // A part that does something else has not been tried here.
        retries.retain(|&of, _| if of == key { !ends } else { part.is_none() || of.1 != part });
        retries.get_mut(&key).into_iter().for_each(|retry| retry.is_due = false);
    }

    /// Parts that enter have no number before.
    fn retry_key(&self, mode: ModeId, part: Option<PartId>) -> (ModeId, Option<PartId>) {
        (mode, part.filter(|_| self.table.part_in(mode).is_some()))
    }

    /// A resource that is down and that a mode needs.
    pub(in super::super) fn needs_down(&self, mode: ModeId) -> Option<ResourceId> {
        if self.exceptions.down.is_empty() {
            return None;
        }
        let handled = self.table.handling().mode(mode);
        handled.resources().find(|resource| self.exceptions.down.contains_key(resource))
    }

    /// Disables the modes that need a resource that is down.
    pub(in super::super) fn block_down(&mut self) {
        let table = self.table.clone();
        for mode in table.modes() {
            let blocks = self.needs_down(mode).is_some();
            self.enabling.block(&table, self.marking.counts(), mode, blocks);
        }
    }

    /// The orders of a failed activity whose stations have to come to rest, and have not certainly.
    pub(super) fn owed<'a>(&'a self, firing: &'a OngoingActivity) -> impl Iterator<Item = &'a OngoingOrder> {
        let owes = |order: &&OngoingOrder| match order.state {
            OrderProgress::Ended => false,
            // It does not do it, or has come up anew since.
            OrderProgress::Failed(OrderFailure::Refused(_) | OrderFailure::Forgotten) => false,
            OrderProgress::Written
            | OrderProgress::Running
            | OrderProgress::Failed(
                OrderFailure::Code(_) | OrderFailure::TimedOut | OrderFailure::Lost | OrderFailure::DevicesLost,
            ) => true,
        };
        let open = firing.orders.iter().filter(owes);
        open.filter(|order| self.exceptions.stands(firing.id, order.key).is_none())
    }

    fn owes(&self, id: FiringId, key: OrderKey) -> ExceptionFitResult {
        let firing = self.failed(id)?;
        match self.exceptions.open.get(&id).map(|trouble| &trouble.stage) {
            Some(ExceptionStage::Securing) => (),
            Some(ExceptionStage::Waiting(_) | ExceptionStage::Restoring { .. }) | None => {
                return Err(format!("{id} is not secured"));
            }
        }
        let owes = self.owed(firing).any(|order| order.key == key);
        if owes { Ok(()) } else { Err(format!("no securing is in progress for order {key}")) }
    }

    fn failed(&self, id: FiringId) -> Result<&OngoingActivity, String> {
        let firing = self.firings.get(&id).ok_or_else(|| format!("{id} is not in progress"))?;
        match firing.phase {
            ActivityPhase::Failed(_) => Ok(firing),
            ActivityPhase::Running => Err(format!("{id} has not failed")),
        }
    }

    fn trouble(&mut self, id: FiringId) -> Result<&mut FailedActivity, String> {
        self.failed(id)?;
        self.exceptions.open.get_mut(&id).ok_or_else(|| format!("{id} has no exception"))
    }

    fn restoring(&self, id: FiringId) -> Result<&RecoveryDecision, String> {
        self.failed(id)?;
        match self.exceptions.open.get(&id).map(|trouble| &trouble.stage) {
            Some(ExceptionStage::Restoring { ruling, since: _ }) => Ok(ruling),
            Some(ExceptionStage::Securing | ExceptionStage::Waiting(_)) | None => {
                Err(format!("{id}: no recovery decision recorded"))
            }
        }
    }

    fn known(&self, resource: ResourceId) -> ExceptionFitResult {
        let known = self.table.handling().resource(resource).map(|_| ());
        known.ok_or_else(|| format!("there is no {resource}"))
    }

    fn alarmed(&mut self, alarm: Alarm) -> ExceptionFitResult {
        let AlarmId(number) = alarm.id;
        if number != self.exceptions.last_alarm + 1 {
            return Err(format!("alarm {number} after alarm {}", self.exceptions.last_alarm));
        }
        match alarm.about {
            AlarmSubject::Firing(firing) => {
                let trouble = self.trouble(firing)?;
                if let ExceptionStage::Waiting(earlier) = trouble.stage {
                    return Err(format!("{firing} waits for an answer to {earlier}"));
                }
                trouble.stage = ExceptionStage::Waiting(alarm.id);
            }
            AlarmSubject::Resource(resource) => {
                self.known(resource)?;
                // The earlier alarm about it no longer holds.
                self.exceptions.alarms.retain(|_, earlier| earlier.about != alarm.about);
            }
        }
        self.exceptions.last_alarm = number;
        self.exceptions.alarms.insert(alarm.id, alarm);
        Ok(())
    }

    /// An alarm can be given of a resource that is left out already.
    fn down(&mut self, resource: ResourceId, new: OutOfService) -> ExceptionFitResult {
        self.known(resource)?;
        let before = self.exceptions.down.get(&resource);
        if before.is_some_and(|before| before.why.is_alarm() || !new.why.is_alarm()) {
            return Err(format!("{resource} is down already"));
        }
        let since = before.map_or(new.since, |before| before.since);
        self.exceptions.down.insert(resource, OutOfService { since, ..new });
        self.block_down();
        Ok(())
    }

    fn up(&mut self, resource: ResourceId) -> ExceptionFitResult {
        if self.exceptions.down.remove(&resource).is_none() {
            return Err(format!("{resource} is not down"));
        }
        self.exceptions.alarms.retain(|_, alarm| alarm.about != AlarmSubject::Resource(resource));
        self.block_down();
        Ok(())
    }

    fn closed(
        &mut self,
        id: FiringId,
        (mode, part): (ModeId, Option<PartId>),
        ruling: &RecoveryDecision,
        at: Tick,
    ) -> ExceptionFitResult {
        if self.restoring(id)? != ruling {
            return Err(format!("{id} is closed by another answer than it was given"));
        }
        if self.failed(id).map(|firing| (firing.mode, firing.part))? != (mode, part) {
            return Err(format!("{id} is not of {mode} with {part:?}"));
        }
        let table = self.table.clone();
        let gone = match ruling.part {
            Whereabouts::Gone => table.handling().mode(mode).gone.as_deref(),
            Whereabouts::From | Whereabouts::To => Some(&[][..]),
            Whereabouts::Carrier => return Err(format!("the part of {id} is with its carrier")),
        };
        let gone = gone.ok_or_else(|| format!("`{}`: no marking defined for a removed part", table.mode_name(mode)))?;
        self.forget(id);
        self.exceptions.open.remove(&id);
        let times = self.exceptions.times(mode, self.retry_key(mode, part).1);
        self.moves_on(mode, part, true);
        match ruling.part {
            Whereabouts::To => self.give(mode, part, at),
            Whereabouts::Gone => {
                self.give_tokens(gone);
                part.into_iter().for_each(|part| self.scrap(mode, part));
            }
            Whereabouts::From | Whereabouts::Carrier => {
                self.give_tokens(table.takes(mode));
                part.into_iter().for_each(|part| self.stay(mode, part));
                match (part, table.part_in(mode)) {
                    (Some(part), Some(cell)) => {
                        let arrival = self.marking.put_back(cell, table.kind(cell), part);
                        self.place(part, PartPlace::On { cell, arrival }, at);
                    }
                    // It has not come in.
                    (Some(part), None) => self.remove(part),
                    (None, _) => (),
                }
            }
        }
        let key = self.retry_key(mode, part);
        match (ruling.then, ruling.part) {
            (Strategy::Redo, _) => {
                self.exceptions.retries.insert(key, Retry { times: times.saturating_add(1), is_due: true });
            }
            // The dispatcher may decide for the same again: it has been tried as often as before.
            (Strategy::Backward, Whereabouts::From | Whereabouts::Carrier) if times > 0 => {
                self.exceptions.retries.insert(key, Retry { times, is_due: false });
            }
            (Strategy::Backward | Strategy::Forward, _) => (),
        }
        Ok(())
    }

    /// The one part that rests at a resource, and a mode that would take it and has what is left without it.
    pub(super) fn resting(&self, resource: ResourceId) -> Option<(ModeId, PartId)> {
        let has = &self.table.handling().resource(resource)?.has;
        let mut parts = has.iter().flat_map(|&cell| self.marking.parts(cell).map(move |part| (cell, part)));
        let (cell, part) = parts.next().filter(|_| parts.next().is_none())?;
        let mut modes = self.table.consumers(cell).iter().copied();
        modes.find(|&mode| self.left_without(mode, cell).is_some()).map(|mode| (mode, part))
    }

    /// Tokens left when the part that a mode would take from a cell is no more, and the mode has not begun: what it gives
    /// back then, but for what it would have taken.
    fn left_without(&self, mode: ModeId, cell: CellId) -> Option<Vec<TokenDemand>> {
        let mut left =
            self.table.handling().mode(mode).gone.clone().filter(|_| self.table.part_in(mode) == Some(cell))?;
        for &(taken, weight) in self.table.takes(mode).iter().filter(|(taken, _)| *taken != cell) {
            let (_, given) = left.iter_mut().find(|(of, _)| *of == taken)?;
            *given = given.checked_sub(weight)?;
        }
        left.retain(|(_, weight)| *weight > 0);
        Some(left)
    }

    fn missing(&mut self, resource: ResourceId, mode: ModeId, part: PartId) -> ExceptionFitResult {
        self.known(resource)?;
        let place = self.parts.get(&part).map(|part| part.place);
        let (cell, arrival) = match place {
            Some(PartPlace::On { cell, arrival }) => (cell, arrival),
            Some(PartPlace::In(_)) | None => return Err(format!("{part} does not rest anywhere")),
        };
        if !self.table.handling().resource(resource).is_some_and(|of| of.has.contains(&cell)) {
            return Err(format!("{part} does not rest at {resource}"));
        }
        let known = self.table.has_mode(mode).then(|| self.left_without(mode, cell)).flatten();
        let left = known.ok_or_else(|| format!("{mode}: no marking defined without {part}"))?;
        let table = self.table.clone();
        self.marking.take(cell, 1);
        self.enabling.taken(&table, self.marking.counts(), cell);
        self.marking.pull(cell, arrival);
        self.give_tokens(&left);
        self.exceptions.retries.retain(|of, _| of.1 != Some(part));
        self.scrap(mode, part);
        Ok(())
    }

    fn scrap(&mut self, mode: ModeId, part: PartId) {
        self.stay(mode, part);
        self.leave_position(mode, part);
        self.remove(part);
        self.exceptions.scrapped += 1;
    }

    fn give_tokens(&mut self, tokens: &[TokenDemand]) {
        let table = self.table.clone();
        for &(cell, weight) in tokens {
            self.marking.give(cell, weight);
            self.enabling.given(&table, self.marking.counts(), cell);
        }
    }
}
