//! A state without what can be computed from it, written in the place of the records that led to it.
//!
//! Its contents are the state's own affair; the caller turns it into bytes and back. On the way in everything is checked
//! against the table and against itself: a snapshot that fits is a state that records can go on from, and one that does
//! not is refused before anything is made of it. A token that is missing altogether is found only by a checksum.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use linewright_line::{StationId, Tick};
use serde::{Deserialize, Serialize};

use super::enabling::Enabling;
use super::exception::{Exceptions, SavedExceptions};
use super::firing::{ActivityPhase, OngoingActivity, OrderProgress, PendingRecord};
use super::ids::{CellId, FiringId, ModeId, NUMBER_MAX, PartId};
use super::marking::CellMarking;
use super::plan::CellKind;
use super::positions::Positions;
use super::production::{Production, SavedProduction};
use super::question::HoldReason;
use super::serial;
use super::state::{Part, PartPlace, PlayerState, ReplayError, waiting};
use super::table::CellTable;

/// No store has so many positions.
const POSITION_MAX: u32 = 1_000_000;

/// A state to be written down.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellSnapshot {
    sequence: u64,
    #[serde(with = "serial::micros")]
    now: Tick,
    epoch: u64,
    questions: u64,
    last_order: u64,
    last_firing: u64,
    last_part: u64,
    left: u64,
    arrivals: u64,
    /// The cells of plain tokens that have any.
    tokens: Vec<(CellId, u64)>,
    parts: Vec<Part>,
    firings: Vec<OngoingActivity>,
    memory: Vec<Memory>,
    held: Vec<(ModeId, HoldReason)>,
    production: SavedProduction,
    exceptions: SavedExceptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Memory {
    #[serde(with = "serial::station")]
    station: StationId,
    memory: u64,
}

impl CellSnapshot {
    /// The number of the last record that it stands for.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }
}

impl PlayerState {
    /// The parts of this state.
    pub fn snapshot(&self) -> CellSnapshot {
        let is_tokens = |cell: &CellId| self.table.kind(*cell) == CellKind::Tokens && self.marking.count(*cell) > 0;
        CellSnapshot {
            sequence: self.sequence,
            now: self.now,
            epoch: self.epoch,
            questions: self.questions,
            last_order: self.last_order,
            last_firing: self.last_firing,
            last_part: self.last_part,
            left: self.left,
            arrivals: self.marking.arrivals(),
            tokens: self.table.cells().filter(is_tokens).map(|cell| (cell, self.marking.count(cell))).collect(),
            parts: self.parts.values().copied().collect(),
            firings: self.firings.values().cloned().collect(),
            memory: self.memory.iter().map(|(&station, &memory)| Memory { station, memory }).collect(),
            held: self.held.clone(),
            production: self.production.kept(),
            exceptions: self.exceptions.kept(),
        }
    }

    /// The state that was taken a snapshot of.
    ///
    /// # Errors
    /// Reason why it is no state of this table.
    pub fn restore(table: Arc<CellTable>, of: CellSnapshot) -> Result<Self, ReplayError> {
        let sequence = of.sequence;
        restored(table, of).map_err(|why| ReplayError { sequence, why })
    }
}

fn restored(table: Arc<CellTable>, of: CellSnapshot) -> Result<PlayerState, String> {
    let counters =
        [of.sequence, of.epoch, of.questions, of.last_order, of.last_firing, of.last_part, of.left, of.arrivals];
    if counters.iter().any(|&counter| counter >= NUMBER_MAX) {
        return Err("counter out of range".to_owned());
    }
    let marking = marking(&table, &of)?;
    let production = Production::restored(&table, of.production)?;
    let (mut parts, mut firings) = (BTreeMap::new(), BTreeMap::new());
    for part in of.parts {
        if part.id.0 > of.last_part || parts.insert(part.id, part).is_some() {
            return Err(format!("{}: occurs twice, or its number was not assigned yet", part.id));
        }
    }
    let mut in_progress = vec![0; table.mode_count()];
    let (mut orders, mut unheard) = (BTreeMap::new(), BTreeMap::<_, BTreeSet<_>>::new());
    let (mut due, mut settled) = (BTreeSet::new(), BTreeSet::new());
    for firing in of.firings {
        let id = firing.id;
        can_be(&table, &firing)?;
        if id.0 > of.last_firing || firings.contains_key(&id) {
            return Err(format!("{id} is in it twice, or has not started yet"));
        }
        let is_held = |part| parts.get(&part).is_some_and(|part: &Part| part.place == PartPlace::In(id));
        if firing.part.is_some_and(|part| !is_held(part)) {
            return Err(format!("{id} does not hold its part"));
        }
        for (position, order) in firing.orders.iter().enumerate() {
            let is_new = order.key.id <= of.last_order && order.key.epoch <= of.epoch;
            if !is_new || orders.insert(order.key, (id, position)).is_some() {
                return Err(format!("{} is in it twice, or has not been given yet", order.key));
            }
            if firing.phase == ActivityPhase::Running && order.state == OrderProgress::Written {
                unheard.entry(order.station).or_default().insert(order.key);
            }
        }
        in_progress[firing.mode.index()] += 1;
        due.extend(firing.due(table.activity(firing.mode)).map(|due| (due, id)));
        settled.extend((firing.next() != PendingRecord::Wait).then_some(id));
        firings.insert(id, firing);
    }
    for part in parts.values() {
        let holds = |id: FiringId| firings.get(&id).is_some_and(|firing| firing.part == Some(part.id));
        match part.place {
            PartPlace::In(firing) if !holds(firing) => {
                return Err(format!("{} is with {firing}, which has it not", part.id));
            }
            PartPlace::In(_) | PartPlace::On { .. } => (),
        }
    }
    if !of.held.iter().all(|(mode, reason)| table.has_mode(*mode) && reason.modes().all(|mode| table.has_mode(mode))) {
        return Err("it holds back what there is not".to_owned());
    }
    let positions = positions(&table, &parts, &firings)?;
    let state = PlayerState {
        waiting: waiting(&parts),
        production,
        positions,
        enabling: Enabling::new(&table, marking.counts()),
        marking,
        parts,
        firings,
        in_progress,
        orders,
        unheard,
        due,
        settled,
        memory: of.memory.iter().map(|of| (of.station, of.memory)).collect(),
        held: of.held,
        exceptions: Exceptions::default(),
        epoch: of.epoch,
        questions: of.questions,
        last_order: of.last_order,
        last_firing: of.last_firing,
        last_part: of.last_part,
        left: of.left,
        sequence: of.sequence,
        now: of.now,
        table,
    };
    state.with_exceptions(of.exceptions)
}

/// The positions that parts have in stores: each has one where it should, and no two have the same.
fn positions(
    table: &CellTable,
    parts: &BTreeMap<PartId, Part>,
    firings: &BTreeMap<FiringId, OngoingActivity>,
) -> Result<Vec<Positions>, String> {
    let mut positions = vec![Positions::default(); table.stores().len()];
    for part in parts.values() {
        let (from, to) = match part.place {
            PartPlace::On { cell, arrival: _ } => (Some(cell), None),
            PartPlace::In(firing) => match firings.get(&firing) {
                Some(firing) => (table.part_in(firing.mode), table.part_out(firing.mode)),
                None => (None, None),
            },
        };
        for (cell, position) in [(from, part.position), (to, part.target)] {
            let fits = match (cell.and_then(|cell| table.store_of(cell)), position) {
                (None, None) => true,
                (Some(store), Some(position)) => position <= POSITION_MAX && positions[store].take(position),
                (None, Some(_)) | (Some(_), None) => false,
            };
            if !fits {
                return Err(format!(
                    "{} has no position of its own where it should, or one where there are none",
                    part.id
                ));
            }
        }
    }
    Ok(positions)
}

/// Tokens and parts where the snapshot has them.
fn marking(table: &CellTable, of: &CellSnapshot) -> Result<CellMarking, String> {
    let mut marking = CellMarking::empty(table, of.arrivals);
    let mut before = None;
    for &(cell, count) in &of.tokens {
        let is_tokens = cell.index() < table.cell_count() && table.kind(cell) == CellKind::Tokens;
        if !is_tokens || before.is_some_and(|before| cell <= before) {
            return Err(format!("{cell} is no place of tokens, or is in it twice"));
        }
        before = Some(cell);
        marking.set(cell, count);
    }
    for part in &of.parts {
        let PartPlace::On { cell, arrival } = part.place else { continue };
        let is_parts = cell.index() < table.cell_count() && table.kind(cell) != CellKind::Tokens;
        if !is_parts || arrival > of.arrivals || !marking.lay(cell, arrival, part.id) {
            return Err(format!("{}: not valid at {cell} with arrival number {arrival}", part.id));
        }
    }
    Ok(marking)
}

/// Whether the table has such an activity, with such orders.
fn can_be(table: &CellTable, firing: &OngoingActivity) -> Result<(), String> {
    let id = firing.id;
    if !table.has_mode(firing.mode) || table.is_immediate(firing.mode) {
        return Err(format!("{id} is of {}, which cannot be in progress", firing.mode));
    }
    let moves_part = table.part_in(firing.mode).or(table.part_out(firing.mode)).is_some();
    if moves_part != firing.part.is_some() {
        return Err(format!("{id} has {:?} as its part", firing.part));
    }
    let told = table.activity(firing.mode).orders.iter().map(|order| order.station);
    if !told.eq(firing.orders.iter().map(|order| order.station)) {
        return Err(format!("the orders of {id} are not those of its activity"));
    }
    Ok(())
}
