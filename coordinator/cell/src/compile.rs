//! From a cell's description to the table that the token player plays, and its dispatcher.
//!
//! The only module here that reads descriptions. Each mode of the coordination net gets an activity of its own, since times
//! and programs depend on the stage. What follows from the net is not worked out again.

mod handling;
mod recovery;
mod sheet;

use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::{CellNet, Detail, Origin, PlaceMeaning, ResourcePosition, Supply, TransitionPhase, net};
use linewright_cell::{Cell, ParameterSource, Prototype, ResourceId, Role, StageMove};
use linewright_line::{Line, StationId};
use linewright_nets::PlaceId;
use linewright_nets::coloured::{ColouredError, Colours, UnfoldError, Unfolding, unfold};
use thiserror::Error;

pub use handling::rests;
pub use recovery::{ErrorPart, Recovery, RecoveryNet, recovery_net};
pub use sheet::sheet;

use crate::ahead::LookAhead;
use crate::dispatch::RuleDispatcher;
use crate::production::DispatchConfiguration;
use crate::schedule::{RolloutScheduler, ScheduleFollower};
use crate::{
    ActivityTiming, CellId, CellKind, CellTable, ModeId, PartPick, PlanError, PlayPlan, PlayedActivity,
    PlayedOrderTemplate, PlayerState, Product, StorePositions, TaskParameterValue,
};

/// At most so many places and transitions: a thousand resources need a tenth of it.
const NODES_MAX: usize = 1_000_000;

/// Time limits of the player for stations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrderTiming {
    /// Time after which an order that no station has acknowledged is sent again.
    pub repeat_interval: Duration,
    /// Time after a restart in which no limit runs out.
    pub grace: Duration,
}

/// Reason why a cell cannot be played.
#[derive(Debug, Error)]
pub enum Unplayable {
    /// Such a cell is there to be found wrong.
    #[error("`reserve = false`: a part could be grasped without a free place for it; not allowed for a running cell")]
    Unreserved,
    /// Too large for a net.
    #[error("the cell has no net: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Net(Vec<ColouredError>),
    /// Too large to be written out.
    #[error(transparent)]
    Unfold(#[from] UnfoldError),
    /// A station that the line does not have.
    #[error("the line has no station `{0}`")]
    Station(String),
    /// An order that would be waited for until the end of days.
    #[error("`{0}` gives an order without a limit")]
    Limit(String),
    /// A parameter without a value is not sent.
    #[error(
        "`{activity}`: no value for the parameter `{parameter}`: no program in the plan, or no such store in the activity"
    )]
    Parameter {
        /// Activity with the order.
        activity: String,
        parameter: String,
    },
    /// The table is refused.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A cell, ready to be played.
#[derive(Clone, Debug)]
pub struct CompiledCell {
    /// Table that is played.
    pub table: CellTable,
    /// The net it was made of.
    pub net: CellNet,
    /// Its long form; modes and cells of the table are its transitions and places.
    pub long: Unfolding,
}

/// Makes the table of a cell. Stations are those of `line`; without one, those that the cell names, in that order.
///
/// # Errors
/// Reasons why the cell cannot be played.
pub fn compile_cell(
    cell: &Cell,
    line: Option<&Line>,
    supply: Supply<'_>,
    pace: OrderTiming,
) -> Result<CompiledCell, Unplayable> {
    if !cell.limits.reserve {
        return Err(Unplayable::Unreserved);
    }
    let net = net(cell, Detail::Coordination, supply).map_err(Unplayable::Net)?;
    let stations = cell.controllers.iter().enumerate().map(|(at, name)| match line {
        None => Ok(StationId::at(at)),
        Some(line) => line.station_named(name).ok_or_else(|| Unplayable::Station(name.clone())),
    });
    let stations: Vec<StationId> = stations.collect::<Result<_, _>>()?;
    let long = unfold(net.net(), Colours::Reachable, NODES_MAX)?;
    let kind = |place| {
        let holds_parts = net.holds_parts(long.cell(net.net(), place).place);
        if holds_parts { CellKind::Parts(PartPick::Any) } else { CellKind::Tokens }
    };
    let mut activities = Vec::with_capacity(long.net().transition_count());
    for t in long.net().transitions() {
        let mode = long.mode(t);
        activities.push(match (net.origin(mode.transition), net.move_of(cell, mode)) {
            (Origin::Activity { phase: TransitionPhase::Whole, .. }, Some((activity, of))) => {
                decided(cell, activity, of, &stations)?
            }
            // A shift in a buffer; there is nothing else where every grasp is reserved.
            (Origin::Activity { .. } | Origin::Shift, _) => PlayedActivity {
                name: long.net().transition_name(t).into(),
                kind: ActivityTiming::Immediate,
                servers: 1,
                orders: Vec::new(),
            },
        });
    }
    let plan = PlayPlan {
        products: match supply {
            Supply::Open | Supply::Batch(_) => products(cell, &net, &long),
            // All parts that will ever come wait outside already; there are no orders.
            Supply::Closed(_) => Vec::new(),
        },
        stores: stores(cell, &net, &long),
        cells: long.net().places().map(kind).collect(),
        activity_of: (0..activities.len()).collect(),
        activities,
        repeat_interval: pace.repeat_interval,
        grace: pace.grace,
    };
    let table = CellTable::compile(&long, plan)?;
    let handling = handling::handling(cell, &net, &long, &table, (line, &stations), supply);
    let table = table.with_handling(handling);
    Ok(CompiledCell { table, net, long })
}

fn decided(
    cell: &Cell,
    activity: &linewright_cell::Activity,
    of: &StageMove,
    stations: &[StationId],
) -> Result<PlayedActivity, Unplayable> {
    let order = |order: &linewright_cell::OrderTemplate| {
        let limit = cell.limit(order, of).ok_or_else(|| Unplayable::Limit(activity.name.clone()))?;
        let value = |source: &ParameterSource| match *source {
            ParameterSource::Number(number) => Some(TaskParameterValue::Number(number)),
            ParameterSource::Program => of.program.map(TaskParameterValue::Number),
            ParameterSource::Position(store) => position(activity, store),
        };
        let parameters = order.parameters.iter().map(|(name, of)| match value(of) {
            Some(value) => Ok((Arc::from(name.as_str()), value)),
            None => Err(Unplayable::Parameter { activity: activity.name.clone(), parameter: name.clone() }),
        });
        Ok(PlayedOrderTemplate {
            station: stations[order.controller.index()],
            task: order.task.as_str().into(),
            parameters: parameters.collect::<Result<_, _>>()?,
            limit,
        })
    };
    Ok(PlayedActivity {
        name: activity.name.as_str().into(),
        kind: ActivityTiming::Decided { time: of.time.unwrap_or(Duration::ZERO), limit: None },
        servers: servers(cell, activity),
        orders: activity.orders.iter().map(order).collect::<Result<_, Unplayable>>()?,
    })
}

/// One of each mode at a time (seed 000, proposition 15, L2385), unless the worker or carrier has room for more.
fn servers(cell: &Cell, activity: &linewright_cell::Activity) -> u32 {
    let of = activity.used(Role::Worker).or_else(|| activity.used(Role::Carrier));
    let Some(resource) = of.and_then(|part| part.of).map(|id| cell.resource(id)) else { return 1 };
    match resource.prototype {
        Prototype::Machine | Prototype::Conveyor => resource.capacity,
        // A human has one token for all work; a store neither works nor carries.
        Prototype::Human
        | Prototype::Robot
        | Prototype::RandomAccessStore
        | Prototype::FifoBuffer
        | Prototype::LifoBuffer => 1,
    }
}

/// Position meant in a store: that of the part before or after.
fn position(activity: &linewright_cell::Activity, store: ResourceId) -> Option<TaskParameterValue> {
    let is_in = |role| activity.used(role).is_some_and(|part| part.of == Some(store));
    match (is_in(Role::Source), is_in(Role::Target)) {
        (true, _) => Some(TaskParameterValue::Source),
        (false, true) => Some(TaskParameterValue::Target),
        (false, false) => None,
    }
}

/// Products of a cell: of each part type its name, and the modes that let its parts enter.
fn products(cell: &Cell, net: &CellNet, long: &Unfolding) -> Vec<Product> {
    let product = |part: &linewright_cell::PartType| Product { name: part.name.as_str().into(), enters: Vec::new() };
    let mut products: Vec<Product> = cell.part_types.iter().map(product).collect();
    for t in long.net().transitions() {
        if let Some((activity, of)) = net.move_of(cell, long.mode(t))
            && activity.kind == linewright_cell::ActivityKind::Enter
        {
            products[cell.stages[of.from.index()].part_type.index()].enters.push(ModeId(t.0));
        }
    }
    products
}

/// The stores of a cell in which parts have positions. Those of a stack are in use from the first one upwards, so the first
/// free one is where the next part goes.
fn stores(cell: &Cell, net: &CellNet, long: &Unfolding) -> Vec<StorePositions> {
    let has_positions = |&id: &ResourceId| cell.resource(id).prototype.has_positions();
    let store = |id: ResourceId| {
        let is_here = |&place: &PlaceId| {
            net.meaning(long.cell(net.net(), place).place) == PlaceMeaning::Held(id, ResourcePosition::Stored)
        };
        let cells = long.net().places().filter(is_here).map(|place| CellId(place.0)).collect();
        StorePositions { name: cell.resource(id).name.as_str().into(), cells }
    };
    cell.resource_ids().filter(has_positions).map(store).collect()
}

/// The dispatcher of a description, with production orders, looking ahead, and a schedule if that is among its rules. It
/// begins with the state of the cell, and takes all records from then on. It plans at once, within decisions.
pub fn schedule_follower(cell: &Cell, made: &CompiledCell, state: &PlayerState) -> ScheduleFollower {
    ScheduleFollower::new(look_ahead(cell, made, state), Box::new(RolloutScheduler::default()))
}

/// The same with a planner beside the decisions.
pub fn follower_beside(cell: &Cell, made: &CompiledCell, state: &PlayerState) -> ScheduleFollower {
    ScheduleFollower::beside(look_ahead(cell, made, state))
}

fn look_ahead(cell: &Cell, made: &CompiledCell, state: &PlayerState) -> LookAhead {
    let desk = DispatchConfiguration::new(dispatcher(cell, &made.table), state.production().clone());
    LookAhead::new(&made.table, desk, cell.dispatch.look_ahead)
}

/// The same without production orders: all parts that wait outside are to be made.
pub fn planner(cell: &Cell, made: &CompiledCell) -> ScheduleFollower {
    let desk = DispatchConfiguration::without_orders(dispatcher(cell, &made.table));
    let look = LookAhead::new(&made.table, desk, cell.dispatch.look_ahead);
    ScheduleFollower::new(look, Box::new(RolloutScheduler::default()))
}

/// The rules of a description, without any timetable yet. Its table is [`CompiledCell::table`].
pub fn dispatcher(cell: &Cell, table: &CellTable) -> RuleDispatcher {
    let mut by_rules = RuleDispatcher::new(table, &cell.dispatch.rules, cell.dispatch.patience);
    by_rules.timetable.tolerance = cell.dispatch.window;
    by_rules
}
