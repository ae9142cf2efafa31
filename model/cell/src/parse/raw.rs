//! The description as written: every key it may have, and every value with the place it was written at; no name is
//! resolved yet.
//!
//! Each table of the description is one table of keys here, from which its reader and the schema for editors follow. A
//! field is `None` when it is missing or could not be read; that has been reported, so that no later rule has to.
//!
//! Every list is bounded here, so that whatever a file contains, the later passes work on something of known size.

use std::time::Duration;

use linewright_text::{
    Fields, KeyPresence, Keys, Located, LocatedName, Report, Scalar, Shape, flag, integer, keys, one_of, scalars,
    seconds, table, tables, text, texts, whole, within, written,
};

use crate::{DispatchRule, Prototype, Staying, Strategy, Whereabouts};

/// At most this many resources.
const RESOURCES_MAX: usize = 1000;
/// At most this many synchronisations.
const SYNCS_MAX: usize = 5000;
/// At most this many part types.
const PARTS_MAX: usize = 2000;
/// At most this many steps of one plan.
const STEPS_MAX: usize = 500;
/// At most this many variants of one part type.
const VARIANTS_MAX: usize = 100;
/// At most this many resources for one step.
const ALTERNATIVES_MAX: usize = 100;
/// At most this many orders of one activity.
const ORDERS_MAX: usize = 16;
/// At most this many parameters of one order.
const PARAMETERS_MAX: usize = 16;
/// At most this many actions that are one.
const ACTIONS_MAX: usize = 8;
/// At most this many rules for exceptions, and answers to one.
const EXCEPTIONS_MAX: usize = 1000;
const ANSWERS_MAX: usize = 16;
/// At most this many resources that are left out after one answer.
const DOWN_MAX: usize = 16;
/// At most this many parts in the cell at once.
const WIP_MAX: i64 = 10_000;
/// Default of a limit, as a multiple of the nominal time.
const SAFETY: f64 = 2.0;
/// The longest time that may be 0, in seconds: a day.
const DAY_S: f64 = 86_400.0;

/// Place of a part in an answer.
const WHEREABOUTS: [(&str, Whereabouts); 4] = [
    ("from", Whereabouts::From),
    ("to", Whereabouts::To),
    ("carrier", Whereabouts::Carrier),
    ("gone", Whereabouts::Gone),
];
/// Strategy in an answer.
const STRATEGIES: [(&str, Strategy); 3] =
    [("redo", Strategy::Redo), ("backward", Strategy::Backward), ("forward", Strategy::Forward)];

/// Whether a part stays where it was worked on.
const STAYING: [(&str, Staying); 2] = [("may", Staying::May), ("must", Staying::Must)];

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawCell> {
    let document = linewright_text::document(text, report)?;
    Some(RawCell::read_all(Fields::new(document.as_table(), 0..0, RawCell::WHAT), report))
}

keys! {
    /// A flexible cell: its resources, what they do together, what is done with which parts, and what to do when something
    /// fails. Times are in seconds.
    pub(super) struct RawCell is "the description" {
        /// The ROS namespace, the same as in the `line.toml` beside this file: lower-case letters, digits and single `_`, a
        /// letter first, at most 64.
        name: Option<LocatedName> = text().required(),
        /// Title of the cell for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// Dispatching: the rules by which enabled activities are chosen.
        dispatch: RawDispatch = table().or_default(),
        /// Machines, robots, stores and people, at most 1000.
        resources as "resource": Vec<RawResource> = tables(RESOURCES_MAX),
        /// Synchronisations: actions of several resources that are one activity; at most 5000.
        syncs as "sync": Vec<RawSync> = tables(SYNCS_MAX),
        /// Actions of one resource that its station works on, at most 5000.
        actions as "action": Vec<RawCellAction> = tables(SYNCS_MAX),
        /// The part types with their plans, at most 2000.
        parts as "part": Vec<RawPart> = tables(PARTS_MAX),
        /// Recovery rules for failed activities, at most 1000. The first that fits counts.
        exceptions as "exception": Vec<RawException> = tables(EXCEPTIONS_MAX),
        /// Limits of the cell as a whole.
        cell: Option<RawBounds> = table().required(),
    }

    /// Limits of the cell as a whole.
    pub(super) struct RawBounds is "`[cell]`" {
        /// Work in process: most parts in the cell at once, 1 to 10000. More than the stores hold is a warning, since
        /// the cell can deadlock.
        wip_max: Option<Located<i64>> = whole(1, WIP_MAX).required(),
        /// Whether a part is grasped only if a place for it is reserved. `false` is for showing what `check` finds;
        /// such a cell does not run.
        reserve: bool = flag().or(true),
        /// Factor on the nominal time for limits that are not given, 1 to 100.
        safety: f64 = within(1.0, 100.0).or(SAFETY),
    }

    /// Dispatching: the rules by which enabled activities are chosen.
    #[derive(Default)]
    pub(super) struct RawDispatch is "`[dispatch]`" {
        /// Dispatching rules in their order; each decides between candidates that the rules before it leave equal.
        /// `["fifo"]` if left out. `schedule` may not be the last.
        rules: Option<Located<Vec<LocatedName>>> = texts(DispatchRule::ALL.len()).like(rules),
        /// Horizon of the look-ahead, in seconds of nominal times, up to a day; 0 for none.
        look_ahead as "look_ahead_s": Option<Located<f64>> = within(0.0, DAY_S).usually(0.0),
        /// Time of waiting after which a part that could move goes first, regardless of the schedule, in seconds, up to
        /// a day.
        patience as "patience_s": Option<Located<Duration>> = seconds().usually(600.0),
        /// Tolerance around the window of a planned start, in seconds, up to a day; a later start has the schedule
        /// revised.
        window as "window_s": Option<Located<f64>> = within(0.0, DAY_S).usually(0.0),
    }

    /// A machine, a robot, a store, a person.
    pub(super) struct RawResource is "a resource" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`; not `outside` or `running`, which every cell's net has.
        name: Option<LocatedName> = text().required(),
        /// Prototype, which gives the resource its actions: `"machine"`, `"human"`, `"random-access-store"`,
        /// `"fifo-buffer"`, `"lifo-buffer"`, `"robot"` or `"conveyor"`.
        prototype: Option<LocatedName> = text().required().like(prototypes),
        /// Number of parts that it holds or carries at once: 1 to 10000, of a buffer 1 to 100. 1 for machines and
        /// people if left out; robots have none.
        capacity: Option<Located<i64>> = integer().from_to(1, 10_000),
        /// Station of the resource; at most one resource for each station.
        station: Option<LocatedName> = text(),
        /// Input of that station that is on while a part is there; of a `"fifo-buffer"`, at the end from which parts
        /// are taken.
        presence: Option<LocatedName> = text(),
    }

    /// A synchronisation: actions of several resources that are one activity and move one part from one place to
    /// another.
    pub(super) struct RawSync is "a synchronisation" {
        /// The transition's name, without `.` `<` `>` `,` `/` `*` `:`.
        name: Option<LocatedName> = text().required(),
        /// `"resource.action"`, at most 8: one source (`unload`, `retrieve`, `outside.in`), one target (`load`, `store`,
        /// `outside.out`), at most one carrier.
        actions: Option<Located<Vec<LocatedName>>> = texts(ACTIONS_MAX).required(),
        /// Nominal time, in seconds, up to a day. Without it that of the longest of its orders' tasks by their operations; without
        /// orders it takes no time.
        time as "time_s": Option<Located<Duration>> = seconds(),
        /// Task orders of the activity, at most 16. It has ended when all are done.
        orders: Vec<RawOrder> = tables(ORDERS_MAX),
    }

    /// An action of one resource that its station works on.
    pub(super) struct RawCellAction is "an action" {
        /// Resource and its action: `"M1.process"`.
        of: Option<LocatedName> = text().required(),
        /// Task orders of the activity, at most 16.
        orders: Vec<RawOrder> = tables(ORDERS_MAX),
    }

    /// A task order to a station.
    pub(super) struct RawOrder is "an order" {
        /// Parameters by name, at most 16. Each is a whole number, `"step.program"` where a machine works, or
        /// `"ST.position"` where a `random-access-store` or `lifo-buffer` takes part: the position of the part there,
        /// from 1.
        parameters: Vec<(LocatedName, Located<Scalar>)> = scalars(PARAMETERS_MAX).or_default(),
        /// Station; at most once in an activity.
        station: Option<LocatedName> = text().required(),
        /// Task of the station.
        task: Option<LocatedName> = text().required(),
        /// Time limit from the start of the activity, in seconds, up to a day; longer than the activity's nominal time.
        /// `safety` times that if left out.
        limit as "max_s": Option<Located<Duration>> = seconds(),
    }

    /// A part type with its plan.
    pub(super) struct RawPart is "a part" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`.
        name: Option<LocatedName> = text().required(),
        /// Steps of its plan, which leads forward only; at most 500.
        steps as "step": Vec<RawStep> = tables(STEPS_MAX),
        /// Variants: part types with the same plan without some of its steps; at most 100.
        variants as "variant": Vec<RawVariant> = tables(VARIANTS_MAX),
    }

    /// A variant: a part type with the plan of another one without some of its steps.
    pub(super) struct RawVariant is "a variant" {
        /// Name, which production orders refer to: without `.` `<` `>` `,` `/` `*` `:`, unique among part types.
        name: Option<LocatedName> = text().required(),
        /// The steps that are left out.
        without: Option<Located<Vec<LocatedName>>> = texts(STEPS_MAX).required(),
    }

    /// A step of a plan.
    pub(super) struct RawStep is "a step" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`; not `new` or `done`, which every part has.
        name: Option<LocatedName> = text().required(),
        /// Earlier step with which it begins: the two are alternatives.
        or: Option<LocatedName> = text(),
        /// Later step that follows it, or `"done"` for the end; the next one listed if left out.
        then: Option<LocatedName> = text(),
        /// Resources on which it can be done, 1 to 100: `{ resource = "M1", time_s = 40, program = 1 }`.
        on: Vec<RawOn> = tables(ALTERNATIVES_MAX).missed(KeyPresence::Required),
    }

    /// A resource on which a step can be done.
    pub(super) struct RawOn is "a resource of a step" {
        /// Whether a program is written, even if it could not be read.
        has_program as "program": bool = written(),
        /// Whether a time is written, even if it could not be read.
        has_time as "time_s": bool = written(),
        /// The resource.
        resource: Option<LocatedName> = text().required(),
        /// Nominal time there, in seconds, up to a day. It may be left out where the operations of the station's task give it, and
        /// no program does.
        time as "time_s": Option<Located<Duration>> = seconds(),
        /// Whether a part stays in the resource after a step there, without being unloaded: it `"may"`, or it `"must"`
        /// and is not loaded for this step. If left out, it is loaded for each step.
        stays: Option<Located<Staying>> = one_of(&STAYING),
        /// Program number of the step, the value of `"step.program"` in orders; 32 bits with a sign.
        program: Option<Located<i64>> = whole(i32::MIN.into(), i32::MAX.into()),
    }

    /// A recovery rule for failed activities.
    pub(super) struct RawException is "an exception" {
        /// Synchronisations and actions that it is for; `*` stands for any text: `"load M*"`, `"M1.process"`.
        within as "in": Option<LocatedName> = text().required(),
        /// Kind of failure: `"time-out"`, `"refused"`, `"station-lost"`, `"device-lost"`, `"alarm"`, a code of the
        /// task, or `"*"` for any.
        code: Option<LocatedName> = text().required(),
        /// Text of the alarm for the operator; may contain `{part}`, `{type}`, `{activity}`, `{carrier}`, `{from}`,
        /// `{to}`, `{slot}`.
        tell: Option<LocatedName> = text().required(),
        /// Number of times that `redo` may be answered, 0 to 100.
        retries: i64 = whole(0, 100).or(0),
        /// Resources that are out of service after any answer, at most 16: names, or `"from"`, `"to"`, `"carrier"` of
        /// the activity.
        down: Option<Located<Vec<LocatedName>>> = texts(DOWN_MAX),
        /// Whether the first answer is taken without an alarm, as long as all stations are at rest.
        automatic: bool = flag().or(false),
        /// Stations that go into emergency stop at once, at most 16; `"*"` for all with an order in the activity. Not
        /// with `automatic`.
        emergency_stop: Option<Located<Vec<LocatedName>>> = texts(DOWN_MAX),
        /// Permitted answers, at most 16.
        answers: Vec<RawAnswer> = tables(ANSWERS_MAX).missed(KeyPresence::Required),
    }

    /// An answer to an alarm.
    pub(super) struct RawAnswer is "an answer" {
        /// Word of the answer.
        word: Option<LocatedName> = text().required(),
        /// Place of the part with this answer: where it was, where it was to go, with the carrier, or gone.
        part: Option<Located<Whereabouts>> = one_of(&WHEREABOUTS).required(),
        /// Recovery. `"redo"`: the activity once more; `"backward"`: the activity is undone, and dispatching decides
        /// anew; `"forward"`: the activity counts as done.
        then: Option<Located<Strategy>> = one_of(&STRATEGIES).required(),
        /// Resources that are out of service after it, at most 16: names, or `"from"`, `"to"`, `"carrier"` of the
        /// activity.
        down: Option<Located<Vec<LocatedName>>> = texts(DOWN_MAX),
    }
}

fn rules() -> Shape {
    Shape::List(Box::new(Shape::Word(DispatchRule::ALL.map(|(word, _)| word).to_vec())), DispatchRule::ALL.len())
}

fn prototypes() -> Shape {
    Shape::Word(Prototype::ALL.map(Prototype::name).to_vec())
}

impl RawDispatch {
    /// The rules that exist, each with its place.
    pub fn known_rules(&self) -> impl Iterator<Item = Located<DispatchRule>> + '_ {
        let names = self.rules.iter().flat_map(|rules| &rules.value);
        names.filter_map(|name| {
            let (_, rule) = DispatchRule::ALL.iter().find(|(known, _)| *known == name.value)?;
            Some(Located::new(*rule, name.at.clone()))
        })
    }
}

impl RawOn {
    /// Whether a part stays for the step.
    pub fn staying(&self) -> Staying {
        self.stays.as_ref().map_or(Staying::No, |stays| stays.value)
    }
}
