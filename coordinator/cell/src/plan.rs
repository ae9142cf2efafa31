//! What a net does not say of a cell: which tokens are parts, what the transitions are, and what stations are told.
//!
//! Plain data beside the net, indexed by its places and transitions, for whoever describes a cell to fill. It is checked
//! once, when the table is made; here are only shapes.

use std::sync::Arc;
use std::time::Duration;

use linewright_line::StationId;

use super::ids::{CellId, ModeId};

/// Everything the player needs beside the net.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayPlan {
    /// What the tokens of each place of the unfolded net are, in its order.
    pub cells: Vec<CellKind>,
    /// What can be done.
    pub activities: Vec<PlayedActivity>,
    /// For each transition of the unfolded net, in its order, the position of its activity in `activities`.
    pub activity_of: Vec<usize>,
    /// What is made. Where nothing is said to be, there are no production orders.
    pub products: Vec<Product>,
    /// The store whose parts have positions.
    pub stores: Vec<StorePositions>,
    /// An order that no station has acknowledged is repeated after this time.
    pub refresh: Duration,
    /// After a restart no limit runs out before this time: what has ended meanwhile is to be heard first.
    pub grace: Duration,
}

/// Something that is made on order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Product {
    /// What orders call it.
    pub name: Arc<str>,
    /// The modes by which its parts enter.
    pub enters: Vec<ModeId>,
}

/// A place with positions, numbered from 1, each for one part: a random-access store (seed 001, L72-77). Which position a
/// part has matters to whoever reaches for it, and enables nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StorePositions {
    pub name: Arc<str>,
    /// Its parts are on these cells. How many there can be the net knows.
    pub cells: Vec<CellId>,
}

/// What the tokens of a cell are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Capacities, permissions: one is as good as another.
    Tokens,
    /// Parts, each itself.
    Parts(PartPick),
}

/// Which of the parts of a cell can be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartPick {
    Any,
    /// The one that has been there longest.
    Oldest,
    /// The one that came last.
    Newest,
}

/// What transitions stand for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayedActivity {
    pub name: Arc<str>,
    /// Whether anybody decides about it, and how long it takes.
    pub kind: ActivityTiming,
    /// How many firings of one mode may be in progress. 1 is the single server of seed 000, proposition 15 (L2385).
    pub servers: u32,
    /// What stations are told when it starts. It has ended when all of them have done what they were told.
    pub orders: Vec<PlayedOrderTemplate>,
}

/// How an activity comes and goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActivityTiming {
    /// It happens by itself as soon as it can, and takes no time. No station is ordered.
    Immediate,
    /// Its start is decided (seed 001, L187-190).
    Decided {
        /// How long it should take. Without orders it ends after exactly that.
        time: Duration,
        /// How long it may take altogether; none leaves it to the limits of its orders.
        limit: Option<Duration>,
    },
}

/// What one station is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayedOrderTemplate {
    pub station: StationId,
    pub task: Arc<str>,
    /// The task's parameters.
    pub parameters: Vec<(Arc<str>, TaskParameterValue)>,
    /// How long that may take from the start of the activity: one limit for each operation and resource (seed 001,
    /// Fig. 6, L137-177).
    pub limit: Duration,
}

/// What a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskParameterValue {
    /// Always this.
    Number(i32),
    /// The position that the part has in the store it comes from.
    Source,
    /// The position that it will have in the store it goes to.
    Target,
}
