//! The checked cell: other crates may rely on it without checks.
//!
//! A [`Cell`] comes from [`crate::parse`] alone, which has resolved every name and checked every rule; so ids index
//! without a `Result`. Fields are public because a cell is data. Times are nominal; limits are what may pass before
//! something counts as failed. Nothing here moves.

use std::fmt;
use std::ops::Range;
use std::time::Duration;

use linewright_line::{Fnv, Line};
use linewright_text::index_id;

use crate::prototype::{Prototype, ResourceAction, Role};

index_id! {
    /// A resource, by its place in [`Cell::resources`].
    ResourceId
    /// An activity, by its place in [`Cell::activities`].
    ActivityId
    /// A part type, by its place in [`Cell::part_types`].
    PartTypeId
    /// Progress of parts of one type, by its place in [`Cell::stages`]. Its tone in the nets is one more.
    StageId
    /// A task-driven station, by its place in [`Cell::controllers`].
    ControllerId
}

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The ROS namespace, which is the line's.
    pub name: String,
    pub title: String,
    /// Limits of the whole cell.
    pub limits: CellTimeouts,
    /// Configuration of the dispatcher.
    pub dispatch: Dispatch,
    /// The stations that get orders or belong to resources, by name.
    pub controllers: Vec<String>,
    /// Resources: they move, work on and keep parts.
    pub resources: Vec<Resource>,
    /// Synchronisations in the order of the description, then one for each resource that works on parts.
    pub activities: Vec<Activity>,
    /// Part types that come in.
    pub part_types: Vec<PartType>,
    /// The stages of all part types, those of one type side by side, in the order of its plan.
    pub stages: Vec<Stage>,
    /// Recovery rules, in the order of the description; the first that fits counts.
    pub exceptions: Vec<ExceptionRule>,
}

/// Limits of the whole cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellTimeouts {
    /// Parts in the cell at once.
    pub wip_max: u32,
    /// A part is grasped only if the place for it is reserved (seed 000, L1439).
    pub reserve: bool,
    /// s in τs = s·τM (seed 000, L3002): a limit that is not given is so many times the nominal time.
    pub safety: f64,
}

/// Configuration of the dispatcher.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispatch {
    /// In this order; what one leaves equal the next decides.
    pub rules: Vec<DispatchRule>,
    /// Time of the simulation before decisions; zero for none.
    pub look_ahead: Duration,
    /// A part that could move and has waited this long goes first.
    pub patience: Duration,
    /// Permitted difference from the schedule.
    pub window: Duration,
}

/// A rule of the dispatcher.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DispatchRule {
    /// First come, first served: the part that has been where it is for longest.
    Fifo,
    /// The least time, with what then follows by itself.
    ShortestProcessingTime,
    /// The part that is due first; those that never are come last.
    EarliestDueDate,
    /// The part with the least slack: time until it is due, less the work that remains.
    LeastSlack,
    /// The part with the smallest ratio of time until it is due to work that remains. Below 1 it will be late; below 0
    /// it is.
    CriticalRatio,
    /// The part whose order has the highest priority.
    Priority,
    /// The first by the timetable. A start that it has later is held; one that should have begun before comes first.
    Schedule,
}

/// One resource.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resource {
    /// Its name, which its places have as well.
    pub name: String,
    pub prototype: Prototype,
    /// Number of parts it holds, or carries at a time.
    pub capacity: u32,
    /// Its station, if it has one.
    pub controller: Option<ControllerId>,
    /// The input of that station that is on while a part is there; of a row, at the end where parts are taken.
    pub presence: Option<String>,
}

/// Transition with a start and an end: what resources do together with parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Activity {
    /// Its name: the synchronisation's, or `M1.process`.
    pub name: String,
    pub kind: ActivityKind,
    /// The actions that are one here.
    pub uses: Vec<Use>,
    /// Orders to stations; it has ended when all of them are done.
    pub orders: Vec<OrderTemplate>,
    /// Stages for which it is possible, in their order, and their changes. At most one for each pair.
    pub moves: Vec<StageMove>,
}

/// Kind of activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ActivityKind {
    /// A part is moved within the cell.
    Transport,
    /// A part is worked on.
    Process,
    /// A part comes in.
    Enter,
    /// A part leaves.
    Leave,
}

/// A part of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Use {
    /// Resource of the action; none for the outside.
    pub of: Option<ResourceId>,
    pub action: ResourceAction,
}

/// Change of one stage by an activity.
#[derive(Clone, Debug, PartialEq)]
pub struct StageMove {
    /// Before.
    pub from: StageId,
    /// Afterwards; the same where parts are only moved.
    pub to: StageId,
    /// Nominal time; none for an instantaneous one.
    pub time: Option<Duration>,
    /// Where no time is written: how long the operations of its tasks take one after the other, by which its orders are limited.
    pub charted: Option<Duration>,
    /// The number of the program, where the plan gives one.
    pub program: Option<i32>,
    /// Of work: whether the part has to be loaded for it.
    pub stays: Staying,
}

/// Limit of an order that states none: a multiple of a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NominalLimit {
    /// The written time of the change; without it that of the operations of its tasks one after the other.
    pub time: Duration,
    /// `safety` of the cell times that.
    pub limit: Duration,
    /// Whether no time is written.
    pub is_charted: bool,
}

/// Whether a part stays in the resource that has worked on it, for the next step there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Staying {
    /// It is unloaded, and loaded again.
    #[default]
    No,
    /// It can stay, and it can be unloaded and loaded again.
    May,
    /// It is not loaded for this step.
    Must,
}

/// Order to one station when an activity starts.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderTemplate {
    /// Station that gets the order.
    pub controller: ControllerId,
    pub task: String,
    /// The task's parameters, by name.
    pub parameters: Vec<(String, ParameterSource)>,
    /// Time limit from the start of the activity; none for safety × nominal time. One limit for each operation and
    /// resource (seed 001, Fig. 6, L137-177).
    pub limit: Option<Duration>,
}

/// Source of the value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterSource {
    /// It is always this.
    Number(i32),
    /// The position that the part has, or will have, in a store.
    Position(ResourceId),
    /// [`StageMove::program`].
    Program,
}

/// A type of parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartType {
    /// Name, as in the description.
    pub name: String,
    /// Its stages: the first is that of a part on which nothing has been done, the last that of a finished one.
    pub stages: Range<u16>,
    /// Its plan, in the order of the description.
    pub steps: Vec<PlanStep>,
}

/// A step of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanStep {
    /// Name, as in the description.
    pub name: String,
    /// Before.
    pub from: StageId,
    /// Afterwards.
    pub to: StageId,
    /// Resources that can do it.
    pub on: Vec<ResourceId>,
}

/// Progress of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// `A.new`, `A.turn` when that has been done, `A.done`.
    pub name: String,
    pub part_type: PartTypeId,
}

/// Rule for the failure of an activity (seed 001 §6, L214-229).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExceptionRule {
    pub activities: Vec<ActivityId>,
    /// The code of the failure; `*` for any.
    pub code: String,
    /// Text for the operator, with names in braces.
    pub tell: String,
    /// Most repetitions of the activity.
    pub retries: u32,
    /// No answer is needed: the first answer holds.
    pub automatic: bool,
    /// The stations that go into emergency stop at once (seed 001 §5.2, L206).
    pub emergency_stop: Vec<StopOf>,
    /// Permitted answers.
    pub answers: Vec<AlarmAnswer>,
}

/// An answer: where the part is, and how to go on from there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmAnswer {
    pub word: String,
    /// Place of the part.
    pub part: Whereabouts,
    /// Strategy.
    pub then: Strategy,
    /// Resources left out then, until an operator puts them back.
    pub down: Vec<LeftOut>,
}

/// Stations that go into emergency stop after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopOf {
    /// All stations that have an order in the activity.
    Activity,
    Station(ControllerId),
}

/// A resource that is left out after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LeftOut {
    Resource(ResourceId),
    /// The resource that has the part in the activity when it is there.
    As(Whereabouts),
}

/// Place of a part after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Whereabouts {
    /// At the resource it came from.
    From,
    /// Its destination.
    To,
    Carrier,
    /// Nowhere any more.
    Gone,
}

/// Continuation after a failure. The source names the three (seed 000, L3101-3104); their meaning here is ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// The activity is done once more, from its beginning.
    Redo,
    /// As it was before; then it is decided anew.
    Backward,
    /// The activity is taken as done.
    Forward,
}

impl Cell {
    /// Fingerprint of this cell with the line of its stations, as [`Line::fingerprint`].
    pub fn fingerprint(&self, line: &Line) -> u64 {
        let mut sum = Fnv::default();
        sum.number(line.fingerprint());
        sum.debug(&Cell { title: String::new(), ..self.clone() });
        sum.sum()
    }

    pub fn resource(&self, id: ResourceId) -> &Resource {
        &self.resources[id.index()]
    }

    /// All resources.
    pub fn resource_ids(&self) -> impl ExactSizeIterator<Item = ResourceId> + use<> {
        (0..self.resources.len()).map(ResourceId::at)
    }

    pub fn activity(&self, id: ActivityId) -> &Activity {
        &self.activities[id.index()]
    }

    /// All activities.
    pub fn activity_ids(&self) -> impl ExactSizeIterator<Item = ActivityId> + use<> {
        (0..self.activities.len()).map(ActivityId::at)
    }

    pub fn activity_named(&self, name: &str) -> Option<ActivityId> {
        self.activities.iter().position(|activity| activity.name == name).map(ActivityId::at)
    }

    pub fn part_type_named(&self, name: &str) -> Option<PartTypeId> {
        self.part_types.iter().position(|part| part.name == name).map(PartTypeId::at)
    }

    /// Time limit of an order; none where neither a limit nor a time is known.
    pub fn limit(&self, order: &OrderTemplate, of: &StageMove) -> Option<Duration> {
        order.limit.or_else(|| self.nominal_limit(of).map(|nominal| nominal.limit))
    }

    /// What an order may take that states no limit; none where no time is known.
    pub fn nominal_limit(&self, of: &StageMove) -> Option<NominalLimit> {
        let time = of.charted.or(of.time)?;
        Some(NominalLimit { time, limit: time.mul_f64(self.limits.safety), is_charted: of.charted.is_some() })
    }
}

impl Activity {
    /// The resource in that role.
    pub fn used(&self, role: Role) -> Option<Use> {
        self.uses.iter().copied().find(|part| part.action.role() == role)
    }

    /// Its change of a stage, by the tones of a mode: before, and afterwards.
    pub fn move_of(&self, from: StageId, to: StageId) -> Option<&StageMove> {
        self.moves.iter().find(|of| (of.from, of.to) == (from, to))
    }

    /// Whether it takes no time and has no orders: a step of the books only (seed 000, definitions 32 and 33, L1445).
    pub fn is_logical(&self) -> bool {
        self.orders.is_empty() && self.moves.iter().all(|of| of.time.is_none())
    }
}

impl Staying {
    /// Whether the work can begin with a part that has been loaded.
    pub fn allows_loaded(self) -> bool {
        self != Staying::Must
    }

    /// Whether it can begin with a part that has been worked on there before.
    pub fn allows_ready(self) -> bool {
        self != Staying::No
    }
}

impl PartType {
    /// Nothing has been done.
    pub fn new_stage(&self) -> StageId {
        StageId(self.stages.start)
    }
}

impl DispatchRule {
    /// All rules with the words that a description has for them.
    pub const ALL: [(&'static str, DispatchRule); 7] = [
        ("fifo", DispatchRule::Fifo),
        ("shortest-processing-time", DispatchRule::ShortestProcessingTime),
        ("earliest-due-date", DispatchRule::EarliestDueDate),
        ("least-slack", DispatchRule::LeastSlack),
        ("critical-ratio", DispatchRule::CriticalRatio),
        ("priority", DispatchRule::Priority),
        ("schedule", DispatchRule::Schedule),
    ];
}

impl fmt::Display for DispatchRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, _) = DispatchRule::ALL.iter().find(|(_, rule)| rule == self).ok_or(fmt::Error)?;
        f.write_str(word)
    }
}
