//! Effect of a record on a state: the one place where a cell's state changes.
//!
//! A record is looked at before anything is changed, so one that does not fit leaves the state as it was. The player
//! writes none that do not fit; a log of another cell, or an edited one, can have them.

use linewright_line::{StationId, Tick};

use super::firing::{ActivityPhase, OngoingActivity, OngoingOrder, OrderProgress, PendingRecord};
use super::ids::{CellId, FiringId, ModeId, NUMBER_MAX, OrderKey, PartId};
use super::plan::{CellKind, PlayedOrderTemplate};
use super::question::HoldReason;
use super::record::{ActivityFailure, OrderFailure, Record, RecordKind};
use super::state::{Part, PartPlace, PlayerState, ReplayError};

type FitResult = Result<(), String>;

impl PlayerState {
    /// Applies a record. It takes time for what it touches only: the cells of one mode, one firing.
    pub fn apply(&mut self, record: &Record) -> Result<(), ReplayError> {
        let sequence = self.sequence + 1;
        if record.at < self.now {
            return Err(ReplayError { sequence, why: format!("it is of {}, after one of {}", record.at, self.now) });
        }
        let result = match &record.fact {
            RecordKind::Epoch { epoch } => self.begin_epoch(*epoch, record.at),
            RecordKind::Memory { station, memory } => {
                let before = self.memory.insert(*station, *memory);
                if before.is_some_and(|before| before != *memory) {
                    self.forgets(*station);
                }
                Ok(())
            }
            RecordKind::Decided { question, started, held } => self.decided(*question, started, held),
            RecordKind::Started { firing, mode, part, orders } => {
                self.started(*firing, *mode, *part, orders, record.at)
            }
            RecordKind::Acknowledged { key } => self.acknowledged(*key),
            RecordKind::OrderEnded { key } => self.order_ended(*key),
            RecordKind::OrderFailed { key, failure } => self.order_failed(*key, *failure),
            RecordKind::Raised { firing, cause } => self.raised(*firing, *cause, record.at),
            RecordKind::Ended { firing } => self.ended(*firing, record.at),
            RecordKind::Fired { mode, part } => self.fired(*mode, *part, record.at),
            // Production orders look at all records themselves, and refuse none but their own.
            RecordKind::Production { change: _ } => Ok(()),
            RecordKind::Exception(step) => self.exception(step, record.at),
        };
        let noted = |()| self.production.note(record).map_err(|unfit| unfit.to_string());
        result.and_then(noted).map_err(|why| ReplayError { sequence, why })?;
        self.sequence = sequence;
        self.now = record.at;
        Ok(())
    }

    fn begin_epoch(&mut self, epoch: u64, at: Tick) -> FitResult {
        if epoch <= self.epoch || epoch >= NUMBER_MAX {
            return Err(format!("epoch {epoch} after epoch {}", self.epoch));
        }
        self.epoch = epoch;
        let open: Vec<FiringId> = self.firings.keys().copied().collect();
        let spared_until = at + self.table.grace();
        open.into_iter().for_each(|id| self.change(id, |firing| firing.spared_until = spared_until));
        Ok(())
    }

    fn decided(
        &mut self,
        question: u64,
        started: &[(ModeId, Option<PartId>)],
        held: &[(ModeId, HoldReason)],
    ) -> FitResult {
        if question != self.questions + 1 {
            return Err(format!("question {question} after question {}", self.questions));
        }
        let modes = started.iter().map(|(mode, _)| *mode);
        let modes = modes.chain(held.iter().flat_map(|(mode, reason)| reason.modes().chain([*mode])));
        if let Some(unknown) = modes.into_iter().find(|&mode| !self.table.has_mode(mode)) {
            return Err(format!("there is no {unknown}"));
        }
        self.questions = question;
        self.held = held.to_vec();
        Ok(())
    }

    fn started(&mut self, id: FiringId, mode: ModeId, part: Option<PartId>, keys: &[OrderKey], at: Tick) -> FitResult {
        let arrival = self.can_fire(mode, part)?;
        let table = self.table.clone();
        if id.0 != self.last_firing + 1 {
            return Err(format!("{id} after firing {}", self.last_firing));
        }
        if table.is_immediate(mode) {
            return Err(format!("`{}` takes no time and cannot be in progress", table.mode_name(mode)));
        }
        let templates = &table.activity(mode).orders;
        let expected = (1..=templates.len() as u64).map(|k| OrderKey { epoch: self.epoch, id: self.last_order + k });
        if !expected.eq(keys.iter().copied()) {
            return Err(format!("the keys of its orders are not the next {} of this epoch", templates.len()));
        }
        self.moves_on(mode, part, false);
        self.take(mode, part, arrival);
        if let Some(part) = part {
            self.place(part, PartPlace::In(id), at);
            self.reserve(mode, part);
        }
        let order = |(&key, template): (&OrderKey, &PlayedOrderTemplate)| OngoingOrder {
            key,
            station: template.station,
            state: OrderProgress::Written,
            limit: at + template.limit,
        };
        let orders: Vec<OngoingOrder> = keys.iter().zip(templates).map(order).collect();
        for (position, order) in orders.iter().enumerate() {
            self.orders.insert(order.key, (id, position));
            self.unheard.entry(order.station).or_default().insert(order.key);
        }
        let firing = OngoingActivity {
            id,
            mode,
            part,
            began: at,
            orders,
            phase: ActivityPhase::Running,
            spared_until: Tick::ZERO,
        };
        self.due.extend(firing.due(table.activity(mode)).map(|due| (due, id)));
        self.firings.insert(id, firing);
        self.in_progress[mode.index()] += 1;
        self.last_firing = id.0;
        self.last_order += keys.len() as u64;
        Ok(())
    }

    fn acknowledged(&mut self, key: OrderKey) -> FitResult {
        let (id, position, OngoingOrder { station, state, .. }) = self.open(key)?;
        if state != OrderProgress::Written {
            return Err(format!("{key} is taken on, but is {state:?}"));
        }
        self.answered(station, key);
        self.change(id, |firing| firing.orders[position].state = OrderProgress::Running);
        Ok(())
    }

    fn order_ended(&mut self, key: OrderKey) -> FitResult {
        let (id, position, OngoingOrder { station, state, .. }) = self.open(key)?;
        let failed = self.running(id).is_err();
        match state {
            OrderProgress::Written | OrderProgress::Running => (),
            OrderProgress::Failed(_) if failed => (),
            OrderProgress::Ended | OrderProgress::Failed(_) => return Err(format!("{key} ends, but is {state:?}")),
        }
        self.answered(station, key);
        self.change(id, |firing| firing.orders[position].state = OrderProgress::Ended);
        Ok(())
    }

    fn order_failed(&mut self, key: OrderKey, failure: OrderFailure) -> FitResult {
        let (id, position, OngoingOrder { station, state, .. }) = self.open(key)?;
        match state {
            OrderProgress::Written | OrderProgress::Running => (),
            OrderProgress::Failed(OrderFailure::TimedOut) if failure.is_expiry() && self.exceptions.is_securing(id) => {
            }
            OrderProgress::Ended | OrderProgress::Failed(_) => return Err(format!("{key} fails, but is {state:?}")),
        }
        self.answered(station, key);
        self.change(id, |firing| {
            firing.orders[position].state = OrderProgress::Failed(failure);
            // The same, more exactly.
            if firing.phase == ActivityPhase::Failed(ActivityFailure::Order { key, failure: OrderFailure::TimedOut }) {
                firing.phase = ActivityPhase::Failed(ActivityFailure::Order { key, failure });
            }
        });
        Ok(())
    }

    fn raised(&mut self, id: FiringId, cause: ActivityFailure, at: Tick) -> FitResult {
        let firing = self.running(id)?;
        // Parts of it that have not been acknowledged are not sent any more.
        let keys: Vec<_> = firing.orders.iter().map(|order| (order.station, order.key)).collect();
        keys.into_iter().for_each(|(station, key)| self.answered(station, key));
        self.change(id, |firing| firing.phase = ActivityPhase::Failed(cause));
        self.exception_begins(id, at);
        Ok(())
    }

    fn ended(&mut self, id: FiringId, at: Tick) -> FitResult {
        let firing = self.running(id)?;
        if firing.orders.iter().any(|order| order.state != OrderProgress::Ended) {
            return Err(format!("{id} ends before its orders do"));
        }
        let (mode, part) = (firing.mode, firing.part);
        self.forget(id);
        self.moves_on(mode, part, true);
        self.give(mode, part, at);
        Ok(())
    }

    /// An activity is not in progress any more. The tokens it has taken are nowhere then.
    pub(super) fn forget(&mut self, id: FiringId) {
        self.unschedule(id);
        let Some(firing) = self.firings.remove(&id) else { return };
        firing.orders.iter().for_each(|order| _ = self.orders.remove(&order.key));
        self.in_progress[firing.mode.index()] -= 1;
    }

    fn fired(&mut self, mode: ModeId, part: Option<PartId>, at: Tick) -> FitResult {
        let arrival = self.can_fire(mode, part)?;
        if !self.table.is_immediate(mode) {
            return Err(format!("`{}` takes time", self.table.mode_name(mode)));
        }
        self.take(mode, part, arrival);
        if let Some(part) = part {
            // It is nowhere in between, and where that is does not matter.
            self.parts.entry(part).or_insert(Part::new(part, at));
            self.reserve(mode, part);
        }
        self.give(mode, part, at);
        Ok(())
    }

    /// Whether a mode has its tokens, a server, and the right part; and since when that has been where it is.
    fn can_fire(&self, mode: ModeId, part: Option<PartId>) -> Result<u64, String> {
        if !self.table.has_mode(mode) {
            return Err(format!("there is no {mode}"));
        }
        let name = self.table.mode_name(mode);
        if let Some(cell) = self.enabling.lacks(mode) {
            return Err(format!("`{name}` lacks tokens of `{}`", self.table.cell_name(cell)));
        }
        if let Some(resource) = self.needs_down(mode) {
            return Err(format!("`{name}` needs {resource}, which is down"));
        }
        if self.room(mode) == 0 {
            return Err(format!("`{name}` is in progress as often as it may be"));
        }
        match (self.table.part_in(mode), self.table.part_out(mode), part) {
            (None, None, None) => Ok(0),
            (None, Some(_), Some(PartId(new))) if new == self.last_part + 1 => Ok(0),
            (Some(from), _, Some(part)) => self
                .arrival(from, part)
                .ok_or_else(|| format!("`{name}` cannot take {part} from `{}`", self.table.cell_name(from))),
            (_, _, part) => Err(format!("`{name}` does not happen with {part:?}")),
        }
    }

    /// Whether a part is on a cell and can be taken from it.
    pub(super) fn can_take(&self, from: CellId, part: PartId) -> bool {
        self.arrival(from, part).is_some()
    }

    /// Number of the arrival of a part on a cell, if it is there and can be taken.
    fn arrival(&self, from: CellId, part: PartId) -> Option<u64> {
        let CellKind::Parts(pick) = self.table.kind(from) else { return None };
        match self.parts.get(&part)?.place {
            PartPlace::On { cell, arrival } if cell == from => {
                self.marking.is_takeable(cell, pick, arrival).then_some(arrival)
            }
            PartPlace::On { .. } | PartPlace::In(_) => None,
        }
    }

    /// Takes the tokens of a mode. A part that it does not take from anywhere is a new one.
    fn take(&mut self, mode: ModeId, part: Option<PartId>, arrival: u64) {
        let table = self.table.clone();
        for &(cell, weight) in table.takes(mode) {
            self.marking.take(cell, weight);
            self.enabling.taken(&table, self.marking.counts(), cell);
        }
        match (table.part_in(mode), part) {
            (Some(from), _) => self.marking.pull(from, arrival),
            (None, Some(PartId(new))) => self.last_part = new,
            (None, None) => (),
        }
    }

    /// Gives the tokens of a mode. A part that it does not put anywhere has left.
    pub(super) fn give(&mut self, mode: ModeId, part: Option<PartId>, at: Tick) {
        let table = self.table.clone();
        for &(cell, weight) in table.gives(mode) {
            self.marking.give(cell, weight);
            self.enabling.given(&table, self.marking.counts(), cell);
        }
        let Some(part) = part else { return };
        match table.part_out(mode) {
            Some(cell) => {
                let arrival = self.marking.put(cell, part);
                self.place(part, PartPlace::On { cell, arrival }, at);
                self.arrive(mode, part);
            }
            None => {
                self.leave_position(mode, part);
                self.remove(part);
                self.left += 1;
            }
        }
    }

    pub(super) fn place(&mut self, id: PartId, place: PartPlace, at: Tick) {
        let part = self.parts.entry(id).or_insert(Part::new(id, at));
        self.waiting.remove(&(part.since, id));
        (part.place, part.since) = (place, at);
        match place {
            PartPlace::On { .. } => _ = self.waiting.insert((at, id)),
            PartPlace::In(_) => (),
        }
    }

    /// A part is in the cell no more.
    pub(super) fn remove(&mut self, part: PartId) {
        let was = self.parts.remove(&part);
        was.into_iter().for_each(|was| _ = self.waiting.remove(&(was.since, part)));
    }

    fn running(&self, id: FiringId) -> Result<&OngoingActivity, String> {
        let firing = self.firings.get(&id).ok_or_else(|| format!("{id} is not in progress"))?;
        match firing.phase {
            ActivityPhase::Running => Ok(firing),
            ActivityPhase::Failed(_) => Err(format!("{id} has failed already")),
        }
    }

    fn open(&self, key: OrderKey) -> Result<(FiringId, usize, OngoingOrder), String> {
        let &(id, at) = self.orders.get(&key).ok_or_else(|| format!("{key} is of no activity in progress"))?;
        let order = self.firings.get(&id).and_then(|firing| firing.orders.get(at));
        order.map(|order| (id, at, *order)).ok_or_else(|| format!("{key} is not where it was"))
    }

    /// An order need not be sent any more.
    fn answered(&mut self, station: StationId, key: OrderKey) {
        if let Some(keys) = self.unheard.get_mut(&station) {
            keys.remove(&key);
            if keys.is_empty() {
                self.unheard.remove(&station);
            }
        }
    }

    /// Changes a firing, and with it when it is due and whether it is settled.
    fn change(&mut self, id: FiringId, change: impl FnOnce(&mut OngoingActivity)) {
        self.unschedule(id);
        if let Some(firing) = self.firings.get_mut(&id) {
            change(firing);
            self.due.extend(firing.due(self.table.activity(firing.mode)).map(|due| (due, id)));
            if firing.next() != PendingRecord::Wait {
                self.settled.insert(id);
            }
        }
    }

    fn unschedule(&mut self, id: FiringId) {
        if let Some(firing) = self.firings.get(&id) {
            firing.due(self.table.activity(firing.mode)).map(|due| self.due.remove(&(due, id)));
            self.settled.remove(&id);
        }
    }
}
