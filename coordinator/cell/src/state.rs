//! State of a cell: marking, parts, what is in progress, and the counters that numbers come from.
//!
//! It changes in [`PlayerState::apply`] alone, and all of it follows from the records. What does not follow from them (what
//! was sent when, which stations were received in this life) is the player's and is lost in a restart on purpose. Beside
//! the facts there are lists that could be computed from them and are kept up to date instead, so that no step searches:
//! the enabled modes, the parts by since when they wait, the firings by when they are due, those that can be closed, the
//! orders not acknowledged.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use linewright_line::{StationId, Tick};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::enabling::Enabling;
use super::exception::Exceptions;
use super::firing::OngoingActivity;
use super::ids::{CellId, FiringId, ModeId, OrderKey, PartId};
use super::marking::CellMarking;
use super::plan::{CellKind, PartPick, TaskParameterValue};
use super::positions::Positions;
use super::production::Production;
use super::reason::HoldReason;
use super::record::Record;
use super::serial;
use super::table::CellTable;

/// The name of a task, and the numbers of its parameters.
type OrderedTask<'s> = (&'s Arc<str>, Vec<(Arc<str>, i32)>);

/// A part in the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Number of the part.
    pub id: PartId,
    #[serde(with = "serial::micros")]
    pub entered: Tick,
    /// Time since which it has been where it is.
    #[serde(with = "serial::micros")]
    pub since: Tick,
    /// Current place.
    pub place: PartPlace,
    /// Its position in the store that it is in, or comes from, from 1; none where there are no positions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<u32>,
    /// The position that it will have in the store that it goes to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

impl Part {
    /// One that enters, before it is anywhere.
    pub(super) fn new(id: PartId, at: Tick) -> Self {
        let nowhere = PartPlace::In(FiringId(0));
        Part { id, entered: at, since: at, place: nowhere, position: None, target: None }
    }
}

/// Place of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PartPlace {
    /// On a cell.
    On {
        /// Token element with the part.
        cell: CellId,
        /// Of two parts of a cell the one that came first has the smaller number.
        arrival: u64,
    },
    /// Held by an activity in progress.
    In(FiringId),
}

/// Reason why records cannot be what happened to this cell.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("record {sequence} does not fit: {why}")]
pub struct ReplayError {
    /// The position of the record, from 1.
    pub sequence: u64,
    /// Error in it.
    pub why: String,
}

/// The state of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayerState {
    pub(super) table: Arc<CellTable>,
    pub(super) marking: CellMarking,
    pub(super) enabling: Enabling,
    pub(super) parts: BTreeMap<PartId, Part>,
    /// The parts that are on a cell, by since when.
    pub(super) waiting: BTreeSet<(Tick, PartId)>,
    pub(super) firings: BTreeMap<FiringId, OngoingActivity>,
    /// Number of firings of each mode.
    pub(super) in_progress: Vec<u32>,
    /// The firing of each order of one, and the position there.
    pub(super) orders: BTreeMap<OrderKey, (FiringId, usize)>,
    /// Orders not acknowledged, of activities that have not failed, for each station.
    pub(super) unheard: BTreeMap<StationId, BTreeSet<OrderKey>>,
    pub(super) due: BTreeSet<(Tick, FiringId)>,
    /// Firings with an end or failure that has not been written yet.
    pub(super) settled: BTreeSet<FiringId>,
    pub(super) memory: BTreeMap<StationId, u64>,
    /// Production orders.
    pub(super) production: Production,
    /// Of each store.
    pub(super) positions: Vec<Positions>,
    pub(super) held: Vec<(ModeId, HoldReason)>,
    pub(super) exceptions: Exceptions,
    pub(super) epoch: u64,
    pub(super) questions: u64,
    pub(super) last_order: u64,
    pub(super) last_firing: u64,
    pub(super) last_part: u64,
    pub(super) left: u64,
    pub(super) sequence: u64,
    pub(super) now: Tick,
}

/// Of these parts those that no activity holds, by since when they are where they are.
pub(super) fn waiting(parts: &BTreeMap<PartId, Part>) -> BTreeSet<(Tick, PartId)> {
    let is_waiting = |part: &&Part| match part.place {
        PartPlace::On { .. } => true,
        PartPlace::In(_) => false,
    };
    parts.values().filter(is_waiting).map(|part| (part.since, part.id)).collect()
}

impl PlayerState {
    /// Before anything has happened. The parts of the initial marking have the first numbers, in the order of the cells.
    pub fn new(table: Arc<CellTable>) -> Self {
        let mut marking = CellMarking::new(&table);
        let (mut parts, mut last_part) = (BTreeMap::new(), 0);
        let mut positions = vec![Positions::default(); table.stores().len()];
        for cell in table.cells().filter(|&cell| matches!(table.kind(cell), CellKind::Parts(_))) {
            for _ in 0..table.initial()[cell.index()] {
                last_part += 1;
                let id = PartId(last_part);
                marking.give(cell, 1);
                let arrival = marking.put(cell, id);
                let position = table.store_of(cell).map(|store| positions[store].take_lowest());
                let place = PartPlace::On { cell, arrival };
                let part = Part { id, entered: Tick::ZERO, since: Tick::ZERO, place, position, target: None };
                parts.insert(id, part);
            }
        }
        PlayerState {
            enabling: Enabling::new(&table, marking.counts()),
            marking,
            waiting: waiting(&parts),
            parts,
            firings: BTreeMap::new(),
            in_progress: vec![0; table.mode_count()],
            orders: BTreeMap::new(),
            unheard: BTreeMap::new(),
            due: BTreeSet::new(),
            settled: BTreeSet::new(),
            memory: BTreeMap::new(),
            production: Production::new(&table),
            positions,
            held: Vec::new(),
            exceptions: Exceptions::default(),
            epoch: 0,
            questions: 0,
            last_order: 0,
            last_firing: 0,
            last_part,
            left: 0,
            sequence: 0,
            now: Tick::ZERO,
            table,
        }
    }

    /// State of a cell by its records. Records of another cell, or not from the beginning, do not fit.
    pub fn replay<'a>(
        table: Arc<CellTable>,
        records: impl IntoIterator<Item = &'a Record>,
    ) -> Result<Self, ReplayError> {
        let mut state = PlayerState::new(table);
        records.into_iter().try_for_each(|record| state.apply(record))?;
        Ok(state)
    }

    /// Table that is played.
    pub fn table(&self) -> &Arc<CellTable> {
        &self.table
    }

    /// Places of the tokens, without those that activities in progress have taken.
    pub fn marking(&self) -> &CellMarking {
        &self.marking
    }

    /// Modes that have their tokens.
    pub fn enabling(&self) -> &Enabling {
        &self.enabling
    }

    /// The modes that have their tokens, in order, decided ones and others.
    pub fn enabled(&self) -> Vec<ModeId> {
        let mut all = [self.enabling.decided(), self.enabling.immediate()].concat();
        all.sort_unstable();
        all
    }

    /// The parts in the cell, by number.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = &Part> {
        self.parts.values()
    }

    /// The parts that no activity holds, the one first that has been where it is for the longest time.
    pub fn waiting(&self) -> impl Iterator<Item = &Part> {
        self.waiting.iter().filter_map(|&(_, part)| self.part(part))
    }

    /// A part, if it is in the cell.
    pub fn part(&self, part: PartId) -> Option<&Part> {
        self.parts.get(&part)
    }

    /// Production orders and their progress.
    pub fn production(&self) -> &Production {
        &self.production
    }

    /// Number of parts that have left.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// The activities in progress, by number.
    pub fn firings(&self) -> impl ExactSizeIterator<Item = &OngoingActivity> {
        self.firings.values()
    }

    /// An activity, if it is in progress.
    pub fn firing(&self, firing: FiringId) -> Option<&OngoingActivity> {
        self.firings.get(&firing)
    }

    /// Number of firings of a mode in progress.
    pub fn in_progress(&self, mode: ModeId) -> u32 {
        self.in_progress[mode.index()]
    }

    /// The modes that were last decided not to start, and why.
    pub fn held(&self) -> &[(ModeId, HoldReason)] {
        &self.held
    }

    /// The coordinator's life; 0 before the first.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Number of records in this state.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// The time of the newest record.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// The parts with which a mode could start now, longest there first; none if it takes none.
    pub fn takeable(&self, mode: ModeId) -> impl Iterator<Item = PartId> + '_ {
        let with_pick = self.table.part_in(mode).and_then(|cell| match self.table.kind(cell) {
            CellKind::Tokens => None,
            CellKind::Parts(pick) => Some((cell, pick)),
        });
        with_pick.into_iter().flat_map(|(cell, pick)| self.marking.takeable(cell, pick))
    }

    /// The part that has been there longest, of those a mode can take; or a new one for a mode that lets one enter.
    pub(super) fn part_for(&self, mode: ModeId) -> Option<PartId> {
        match (self.table.part_in(mode), self.table.part_out(mode)) {
            (Some(_), _) => self.takeable(mode).next(),
            (None, Some(_)) => Some(PartId(self.last_part + 1)),
            (None, None) => None,
        }
    }

    /// Number of firings of a mode that could be added at once, if it had all tokens for itself.
    pub fn room(&self, mode: ModeId) -> u32 {
        let servers = self.table.activity(mode).servers.saturating_sub(self.in_progress(mode));
        let times = |&(cell, weight): &(CellId, u32)| self.marking.count(cell) / u64::from(weight).max(1);
        let tokens = self.table.takes(mode).iter().map(times).min().unwrap_or(u64::MAX);
        let ordered = self.table.part_in(mode).is_some_and(|cell| match self.table.kind(cell) {
            CellKind::Tokens | CellKind::Parts(PartPick::Any) => false,
            CellKind::Parts(PartPick::Oldest | PartPick::Newest) => true,
        });
        let most = if ordered { servers.min(1) } else { servers };
        u32::try_from(tokens).map_or(most, |tokens| tokens.min(most))
    }

    /// The order of that key, if its activity is in progress.
    pub fn order(&self, key: OrderKey) -> Option<(&OngoingActivity, &super::firing::OngoingOrder)> {
        let &(firing, at) = self.orders.get(&key)?;
        let firing = self.firings.get(&firing)?;
        Some((firing, firing.orders.get(at)?))
    }

    /// The task of that order, and the numbers of its parameters; none if its activity is not in progress, or a number is not known.
    pub fn ordered_task(&self, key: OrderKey) -> Option<OrderedTask<'_>> {
        let &(_, at) = self.orders.get(&key)?;
        let (firing, _) = self.order(key)?;
        let template = self.table.activity(firing.mode).orders.get(at)?;
        let part = firing.part.and_then(|part| self.part(part));
        let value = |value: &TaskParameterValue| match *value {
            TaskParameterValue::Number(number) => Some(number),
            TaskParameterValue::Source => i32::try_from(part?.position?).ok(),
            TaskParameterValue::Target => i32::try_from(part?.target?).ok(),
        };
        // The table has values that can be known alone. Should one not be, then no number is given rather than a wrong place.
        let numbers = template.parameters.iter().map(|(name, of)| Some((name.clone(), value(of)?)));
        Some((&template.task, numbers.collect::<Option<_>>()?))
    }
}

impl PlayerState {
    fn store(&mut self, cell: Option<CellId>) -> Option<&mut Positions> {
        let store = self.table.store_of(cell?)?;
        self.positions.get_mut(store)
    }

    /// A part sets out: it gets a position where it goes.
    pub(super) fn reserve(&mut self, mode: ModeId, part: PartId) {
        let to = self.table.part_out(mode);
        let target = self.store(to).map(Positions::take_lowest);
        self.parts.entry(part).and_modify(|part| part.target = target);
    }

    /// A part has arrived: where it was there is room again.
    pub(super) fn arrive(&mut self, mode: ModeId, part: PartId) {
        self.leave_position(mode, part);
        self.parts.entry(part).and_modify(|part| part.position = part.target.take());
    }

    /// A part does not go where it was to go.
    pub(super) fn stay(&mut self, mode: ModeId, part: PartId) {
        let Some(target) = self.parts.get_mut(&part).and_then(|part| part.target.take()) else { return };
        let to = self.table.part_out(mode);
        if let Some(store) = self.store(to) {
            store.give(target);
        }
    }

    /// Gives back the position a part comes from.
    pub(super) fn leave_position(&mut self, mode: ModeId, part: PartId) {
        let Some(position) = self.parts.get_mut(&part).and_then(|part| part.position.take()) else { return };
        let from = self.table.part_in(mode);
        if let Some(store) = self.store(from) {
            store.give(position);
        }
    }
}
