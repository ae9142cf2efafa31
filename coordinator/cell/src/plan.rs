//! Data of a cell beside its net: which tokens are parts, what the transitions are, and the orders to stations.
//!
//! Plain data beside the net, indexed by its places and transitions, filled from the description of a cell. It is
//! checked once, when the table is made; here are only shapes.

use std::sync::Arc;
use std::time::Duration;

use linewright_line::StationId;

use super::ids::{CellId, ModeId};

/// Everything the player needs beside the net.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayPlan {
    /// Kinds of tokens of the places of the unfolded net, in its order.
    pub cells: Vec<CellKind>,
    pub activities: Vec<PlayedActivity>,
    /// For each transition of the unfolded net, in its order, the position of its activity in `activities`.
    pub activity_of: Vec<usize>,
    /// Products. Without any, there are no production orders.
    pub products: Vec<Product>,
    /// The stores whose parts have positions.
    pub stores: Vec<StorePositions>,
    /// Time after which an order that no station has acknowledged is sent again.
    pub repeat_interval: Duration,
    /// Time after a restart in which no limit runs out: reports on orders that ended meanwhile arrive first.
    pub grace: Duration,
}

/// Part type that production orders can name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Product {
    /// Its name in production orders.
    pub name: Arc<str>,
    /// The modes by which its parts enter.
    pub enters: Vec<ModeId>,
}

/// A place with positions, numbered from 1, each for one part: a random-access store (seed 001, L72-77). The position of
/// a part matters to the robot that takes it, and enables nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StorePositions {
    pub name: Arc<str>,
    /// Its parts are on these cells. The net limits their number.
    pub cells: Vec<CellId>,
}

/// Kind of the tokens of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Capacities, permissions: one is as good as another.
    Tokens,
    /// Parts, each itself.
    Parts(PartPick),
}

/// Parts of a cell that can be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartPick {
    Any,
    /// The one that has been there longest.
    Oldest,
    /// The one that came last.
    Newest,
}

/// Meaning of a transition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayedActivity {
    pub name: Arc<str>,
    /// Whether the dispatcher decides about it, and its time.
    pub kind: ActivityTiming,
    /// Most firings of one mode in progress. 1 is the single server of seed 000, proposition 15 (L2385).
    pub servers: u32,
    /// Orders to stations when it starts. It has ended when all of them are done.
    pub orders: Vec<PlayedOrderTemplate>,
}

/// Start and end of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActivityTiming {
    /// It happens by itself as soon as it can, and takes no time. No station is ordered.
    Immediate,
    /// Its start is decided (seed 001, L187-190).
    Decided {
        /// Nominal time. Without orders it ends after exactly that.
        time: Duration,
        /// Time limit of the whole; none leaves it to the limits of its orders.
        limit: Option<Duration>,
    },
}

/// Order to one station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayedOrderTemplate {
    pub station: StationId,
    pub task: Arc<str>,
    /// The task's parameters.
    pub parameters: Vec<(Arc<str>, TaskParameterValue)>,
    /// Time limit from the start of the activity: one for each operation and resource (seed 001, Fig. 6, L137-177).
    pub limit: Duration,
}

/// Source of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskParameterValue {
    /// Always this.
    Number(i32),
    /// The position that the part has in the store it comes from.
    Source,
    /// The position that it will have in the store it goes to.
    Target,
}
