//! The compiled cell: tokens that every mode takes and gives, and its activity.
//!
//! A coloured net is unfolded, so that a mode is a row and a colour of a place is a *cell*; the player never evaluates a
//! function or a guard. Rows lie one after the other in one block of memory, found by where they start. The table has no
//! notion of a machine or a robot; it never changes, and exists only in sound form.
//!
//! The inputs of a mode are in the order in which enabling looks at them: those few modes compete for come first (the
//! part at its location, then the target's capacity), those many compete for come last (the carrier). A mode that cannot
//! fire then waits for what is its own rather than for the robot; for the benefit see [`super::enabling`].

use std::sync::Arc;
use std::time::Duration;

use linewright_nets::coloured::Unfolding;
use linewright_nets::{Net, PlaceId, TransitionId};
use thiserror::Error;

use super::exception::RecoveryPolicy;
use super::ids::{CellId, ModeId, TokenDemand};
use super::plan::{ActivityTiming, CellKind, PlayPlan, PlayedActivity, Product, StorePositions, TaskParameterValue};

/// Reason why a plan does not fit its net.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PlanError {
    /// Not one kind for each cell.
    #[error("the plan has kinds for {has} cells, the net has {expected}")]
    Cells {
        /// Number found.
        has: usize,
        /// Number required.
        expected: usize,
    },
    /// Not one activity for each mode.
    #[error("the plan has activities for {has} modes, the net has {expected}")]
    Modes {
        /// Number found.
        has: usize,
        /// Number required.
        expected: usize,
    },
    /// An activity that is not in the list.
    #[error("`{mode}` names activity {activity}; there are {count}")]
    NoActivity {
        mode: String,
        /// Position requested.
        activity: usize,
        /// Number of activities.
        count: usize,
    },
    /// A mode moves more than one part.
    #[error("`{mode}` {moves} more than one part; a mode moves one at most")]
    Parts {
        mode: String,
        /// `takes` or `gives`.
        moves: &'static str,
    },
    /// More parts than are kept apart.
    #[error("{has} parts are in the cell from the beginning, at most {most} can be")]
    TooManyParts {
        /// Number there would be.
        has: u64,
        /// Largest number possible.
        most: u64,
    },
    /// An immediate activity takes no time, so it cannot have orders.
    #[error("activity `{activity}` is immediate and has orders; make it a decided one")]
    ImmediateOrders { activity: String },
    /// It would happen for ever.
    #[error("`{mode}` is immediate and consumes no token: it would fire without end")]
    ImmediateSource { mode: String },
    /// A product whose parts do not enter by that mode.
    #[error("product `{product}` names entry mode {mode}, which admits no part")]
    NoEntrance {
        product: String,
        /// The mode, as a number.
        mode: u32,
    },
    /// A store of a cell that does not exist, or that is another store's.
    #[error("store `{store}` has cell {cell}, which holds no parts or belongs to another store")]
    Store {
        store: String,
        /// The cell, as a number.
        cell: u32,
    },
    /// The number to send is not determined.
    #[error("task `{task}` of `{mode}` has a store position as parameter, but the part is in no store")]
    NoPosition { task: String, mode: String },
    /// Not even one firing is allowed.
    #[error("activity `{activity}` has no server; 1 lets each of its modes happen once at a time")]
    NoServer { activity: String },
}

/// At most so many parts from the beginning; each is kept by itself.
const PARTS_MAX: u64 = 1_000_000;

/// Data of a mode beside its arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TableMode {
    activity: usize,
    part_in: Option<CellId>,
    part_out: Option<CellId>,
}

/// Lists of one length each, one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Rows<T> {
    starts: Vec<usize>,
    items: Vec<T>,
}

impl<T> Rows<T> {
    fn new(rows: impl Iterator<Item = Vec<T>>) -> Self {
        let (mut starts, mut items) = (vec![0], Vec::new());
        for row in rows {
            items.extend(row);
            starts.push(items.len());
        }
        Rows { starts, items }
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    fn of(&self, row: usize) -> &[T] {
        &self.items[self.range(row)]
    }
}

/// A cell, compiled.
///
/// # Panics
/// Methods that take an id panic when it is not one of this table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellTable {
    cell_names: Vec<Arc<str>>,
    mode_names: Vec<Arc<str>>,
    kinds: Vec<CellKind>,
    initial: Vec<u64>,
    activities: Vec<PlayedActivity>,
    modes: Vec<TableMode>,
    inputs: Rows<TokenDemand>,
    outputs: Rows<TokenDemand>,
    consumers: Rows<ModeId>,
    /// The mode of each input arc.
    arc_modes: Vec<ModeId>,
    products: Vec<Product>,
    stores: Vec<StorePositions>,
    /// The store of each cell, if it belongs to one.
    store_of: Vec<Option<usize>>,
    repeat_interval: Duration,
    grace: Duration,
    handling: Arc<RecoveryPolicy>,
}

impl CellTable {
    /// Compiles the long form of a coloured net, with `plan` for its places and transitions. Cells and modes are numbered
    /// as places and transitions of [`Unfolding::net`] are.
    pub fn compile(unfolding: &Unfolding, plan: PlayPlan) -> Result<Self, PlanError> {
        let net = unfolding.net();
        let cells = net.place_count();
        if plan.cells.len() != cells {
            return Err(PlanError::Cells { has: plan.cells.len(), expected: cells });
        }
        if plan.activity_of.len() != net.transition_count() {
            return Err(PlanError::Modes { has: plan.activity_of.len(), expected: net.transition_count() });
        }
        plan.activities.iter().try_for_each(check_activity)?;
        let modes = net.transitions().map(|t| row(net, t, &plan)).collect::<Result<Vec<_>, _>>()?;
        let takes = |t: TransitionId| {
            let mut arcs: Vec<(PlaceId, u32)> = net.preset(t).to_vec();
            arcs.sort_by_key(|&(place, _)| (net.consumers(place).len(), place));
            arcs.into_iter().map(|(place, weight)| (CellId(place.0), weight)).collect()
        };
        let gives = |t| net.postset(t).iter().map(|&(place, weight)| (CellId(place.0), weight)).collect();
        let takers = |p| net.consumers(p).iter().map(|&(t, _)| ModeId(t.0)).collect();
        let mine = |t| net.preset(t).iter().map(move |_| ModeId(t.0));
        let start = net.initial_marking();
        let parts = plan.cells.iter().zip(start.as_slice()).filter(|(kind, _)| matches!(kind, CellKind::Parts(_)));
        let has = parts.map(|(_, &count)| u64::from(count)).sum();
        if has > PARTS_MAX {
            return Err(PlanError::TooManyParts { has, most: PARTS_MAX });
        }
        let store_of = store_of(&plan)?;
        let table = CellTable {
            cell_names: net.places().map(|p| net.place_name(p).into()).collect(),
            mode_names: net.transitions().map(|t| net.transition_name(t).into()).collect(),
            initial: start.as_slice().iter().map(|&count| u64::from(count)).collect(),
            modes,
            inputs: Rows::new(net.transitions().map(takes)),
            outputs: Rows::new(net.transitions().map(gives)),
            consumers: Rows::new(net.places().map(takers)),
            arc_modes: net.transitions().flat_map(mine).collect(),
            kinds: plan.cells,
            activities: plan.activities,
            products: plan.products,
            stores: plan.stores,
            store_of,
            repeat_interval: plan.repeat_interval,
            grace: plan.grace,
            handling: Arc::default(),
        };
        table.check_entrances()?;
        table.check_positions()?;
        Ok(table)
    }

    fn check_entrances(&self) -> Result<(), PlanError> {
        let enters =
            |mode: ModeId| self.has_mode(mode) && self.part_in(mode).is_none() && self.part_out(mode).is_some();
        let all = self.products.iter().flat_map(|product| product.enters.iter().map(move |&mode| (product, mode)));
        match all.into_iter().find(|&(_, mode)| !enters(mode)) {
            Some((product, mode)) => Err(PlanError::NoEntrance { product: product.name.to_string(), mode: mode.0 }),
            None => Ok(()),
        }
    }

    fn check_positions(&self) -> Result<(), PlanError> {
        for mode in self.modes() {
            for order in &self.activity(mode).orders {
                let is_known = |value: &TaskParameterValue| match value {
                    TaskParameterValue::Number(_) => true,
                    TaskParameterValue::Source => self.part_in(mode).and_then(|cell| self.store_of(cell)).is_some(),
                    TaskParameterValue::Target => self.part_out(mode).and_then(|cell| self.store_of(cell)).is_some(),
                };
                if !order.parameters.iter().all(|(_, value)| is_known(value)) {
                    let (task, mode) = (order.task.to_string(), self.mode_name(mode).to_owned());
                    return Err(PlanError::NoPosition { task, mode });
                }
            }
        }
        Ok(())
    }

    /// The same cell, with a recovery policy.
    #[must_use]
    pub fn with_handling(mut self, handling: RecoveryPolicy) -> Self {
        self.handling = Arc::new(handling);
        self
    }

    /// Operators' name of the activity of a mode; its own name where there is none.
    pub fn called(&self, mode: ModeId) -> &str {
        let activity = &self.handling.mode(mode).activity;
        if activity.is_empty() { self.mode_name(mode) } else { activity }
    }

    /// Recovery policy.
    pub fn handling(&self) -> &RecoveryPolicy {
        &self.handling
    }

    /// The same cell without stations: all that takes time ends by the clock alone. Used in forward simulations alone.
    pub fn without_orders(&self) -> Self {
        let mut quiet = self.clone();
        quiet.activities.iter_mut().for_each(|activity| activity.orders.clear());
        quiet
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cell_names.len()
    }

    /// Number of modes.
    pub fn mode_count(&self) -> usize {
        self.mode_names.len()
    }

    /// All cells.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = CellId> + use<> {
        // Nets are bounded far below 32 bits.
        (0..self.cell_count() as u32).map(CellId)
    }

    /// All modes.
    pub fn modes(&self) -> impl ExactSizeIterator<Item = ModeId> + use<> {
        (0..self.mode_count() as u32).map(ModeId)
    }

    /// Whether there is such a mode.
    pub fn has_mode(&self, mode: ModeId) -> bool {
        mode.index() < self.mode_count()
    }

    /// Name of a cell in the net.
    pub fn cell_name(&self, cell: CellId) -> &str {
        &self.cell_names[cell.index()]
    }

    /// Name of a mode in the net.
    pub fn mode_name(&self, mode: ModeId) -> &str {
        &self.mode_names[mode.index()]
    }

    /// Kind of the tokens of a cell.
    pub fn kind(&self, cell: CellId) -> CellKind {
        self.kinds[cell.index()]
    }

    /// The tokens of each cell before anything has happened.
    pub fn initial(&self) -> &[u64] {
        &self.initial
    }

    /// Tokens that a mode takes, each cell once, in the order in which enabling looks at them.
    pub fn takes(&self, mode: ModeId) -> &[TokenDemand] {
        self.inputs.of(mode.index())
    }

    /// Tokens that a mode gives, each cell once.
    pub fn gives(&self, mode: ModeId) -> &[TokenDemand] {
        self.outputs.of(mode.index())
    }

    /// The modes that take from a cell.
    pub fn consumers(&self, cell: CellId) -> &[ModeId] {
        self.consumers.of(cell.index())
    }

    /// Activity of a mode.
    pub fn activity(&self, mode: ModeId) -> &PlayedActivity {
        &self.activities[self.modes[mode.index()].activity]
    }

    /// Whether a mode happens by itself.
    pub fn is_immediate(&self, mode: ModeId) -> bool {
        matches!(self.activity(mode).kind, ActivityTiming::Immediate)
    }

    /// Cell that a mode takes its part from; none if it takes none.
    pub fn part_in(&self, mode: ModeId) -> Option<CellId> {
        self.modes[mode.index()].part_in
    }

    /// Where a mode puts its part; none if it puts none. A mode that takes none and puts one lets a part enter; one that
    /// takes one and puts none lets it leave.
    pub fn part_out(&self, mode: ModeId) -> Option<CellId> {
        self.modes[mode.index()].part_out
    }

    pub fn products(&self) -> &[Product] {
        &self.products
    }

    /// The stores whose parts have positions.
    pub fn stores(&self) -> &[StorePositions] {
        &self.stores
    }

    /// The store to which a cell belongs, as its place in [`CellTable::stores`].
    pub fn store_of(&self, cell: CellId) -> Option<usize> {
        self.store_of[cell.index()]
    }

    /// Time after which an order that no station has acknowledged is sent again.
    pub fn repeat_interval(&self) -> Duration {
        self.repeat_interval
    }

    /// Time after a restart in which no limit runs out.
    pub fn grace(&self) -> Duration {
        self.grace
    }

    /// Number of input arcs in all.
    pub(super) fn arc_count(&self) -> usize {
        self.arc_modes.len()
    }

    /// The numbers of a mode's input arcs.
    pub(super) fn arcs(&self, mode: ModeId) -> std::ops::Range<usize> {
        self.inputs.range(mode.index())
    }

    /// One input arc: its mode, and the tokens it takes.
    pub(super) fn arc(&self, arc: usize) -> (ModeId, TokenDemand) {
        (self.arc_modes[arc], self.inputs.items[arc])
    }
}

fn store_of(plan: &PlayPlan) -> Result<Vec<Option<usize>>, PlanError> {
    let mut store_of = vec![None; plan.cells.len()];
    for (at, store) in plan.stores.iter().enumerate() {
        for &cell in &store.cells {
            let holds_parts = plan.cells.get(cell.index()).is_some_and(|kind| matches!(kind, CellKind::Parts(_)));
            if !holds_parts || store_of[cell.index()].replace(at).is_some() {
                return Err(PlanError::Store { store: store.name.to_string(), cell: cell.0 });
            }
        }
    }
    Ok(store_of)
}

fn check_activity(activity: &PlayedActivity) -> Result<(), PlanError> {
    if matches!(activity.kind, ActivityTiming::Immediate) && !activity.orders.is_empty() {
        return Err(PlanError::ImmediateOrders { activity: activity.name.to_string() });
    }
    if activity.servers == 0 {
        return Err(PlanError::NoServer { activity: activity.name.to_string() });
    }
    Ok(())
}

fn row(net: &Net, t: TransitionId, plan: &PlayPlan) -> Result<TableMode, PlanError> {
    let (mode, at) = (|| net.transition_name(t).to_owned(), plan.activity_of[t.index()]);
    let Some(activity) = plan.activities.get(at) else {
        return Err(PlanError::NoActivity { mode: mode(), activity: at, count: plan.activities.len() });
    };
    if matches!(activity.kind, ActivityTiming::Immediate) && net.preset(t).is_empty() {
        return Err(PlanError::ImmediateSource { mode: mode() });
    }
    let the_part = |arcs: &[(PlaceId, u32)], moves| {
        let mut parts = arcs.iter().filter(|(place, _)| matches!(plan.cells[place.index()], CellKind::Parts(_)));
        match (parts.next(), parts.next()) {
            (None, _) => Ok(None),
            (Some(&(place, 1)), None) => Ok(Some(CellId(place.0))),
            (Some(_), _) => Err(PlanError::Parts { mode: mode(), moves }),
        }
    };
    let (part_in, part_out) = (the_part(net.preset(t), "takes")?, the_part(net.postset(t), "gives")?);
    Ok(TableMode { activity: at, part_in, part_out })
}
