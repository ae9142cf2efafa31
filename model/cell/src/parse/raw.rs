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
        /// What people call the cell; the name if left out.
        title: Option<LocatedName> = text(),
        /// By which rules is decided what happens next.
        dispatch: RawDispatch = table().or_default(),
        /// Machines, robots, stores and people, at most 1000.
        resources as "resource": Vec<RawResource> = tables(RESOURCES_MAX),
        /// Actions of resources that are one, at most 5000.
        syncs as "sync": Vec<RawSync> = tables(SYNCS_MAX),
        /// What resources do by themselves that is work for a station, at most 5000.
        actions as "action": Vec<RawCellAction> = tables(SYNCS_MAX),
        /// The part types with their plans, at most 2000.
        parts as "part": Vec<RawPart> = tables(PARTS_MAX),
        /// What to do when an activity fails, at most 1000. The first that fits counts.
        exceptions as "exception": Vec<RawException> = tables(EXCEPTIONS_MAX),
        /// Numbers of the cell as a whole.
        cell: Option<RawBounds> = table().required(),
    }

    /// Numbers of the cell as a whole.
    pub(super) struct RawBounds is "`[cell]`" {
        /// Parts in the cell at once, 1 to 10000. More than the stores hold is a warning: then it can get stuck.
        wip_max: Option<Located<i64>> = whole(1, WIP_MAX).required(),
        /// A part is grasped only if the place for it is reserved; `false` is there to be found wrong by `check`.
        reserve: bool = flag().or(true),
        /// A limit that is not given is so many times the nominal time; 1 to 100.
        safety: f64 = within(1.0, 100.0).or(SAFETY),
    }

    /// By which rules is decided what happens next.
    #[derive(Default)]
    pub(super) struct RawDispatch is "`[dispatch]`" {
        /// In this order, what one leaves equal the next decides; `["fifo"]` if left out. `schedule` is not the last.
        rules: Option<Located<Vec<LocatedName>>> = texts(DispatchRule::ALL.len()).like(rules),
        /// How far decisions are tried out beforehand, in seconds of nominal times, up to a day; 0: not at all.
        look_ahead as "look_ahead_s": Option<Located<f64>> = within(0.0, DAY_S).usually(0.0),
        /// A part that could move and has waited for so many seconds goes first, regardless of the schedule; up to a day.
        patience as "patience_s": Option<Located<Duration>> = seconds().usually(600.0),
        /// How far from its window in the schedule something may start, in seconds, up to a day; what is later makes the
        /// schedule be revised.
        window as "window_s": Option<Located<f64>> = within(0.0, DAY_S).usually(0.0),
    }

    /// A machine, a robot, a store, a person.
    pub(super) struct RawResource is "a resource" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`; not `outside` or `running`, which every cell's net has.
        name: Option<LocatedName> = text().required(),
        /// What it is and which actions it has: `"machine"`, `"human"`, `"random-access-store"`, `"fifo-buffer"`,
        /// `"lifo-buffer"`, `"robot"` or `"conveyor"`.
        prototype: Option<LocatedName> = text().required().like(prototypes),
        /// Parts that it holds, or carries at a time: 1 to 10000, of a buffer 1 to 100. Machines and people have 1 if it is
        /// left out; robots have none.
        capacity: Option<Located<i64>> = integer().from_to(1, 10_000),
        /// Its station; one resource each.
        station: Option<LocatedName> = text(),
        /// An input of that station that is on while a part is there; of a `"fifo-buffer"`, at the end it is taken from.
        presence: Option<LocatedName> = text(),
    }

    /// Actions that are one: together they move one part from one place to one other.
    pub(super) struct RawSync is "a synchronisation" {
        /// The transition's name, without `.` `<` `>` `,` `/` `*` `:`.
        name: Option<LocatedName> = text().required(),
        /// `"resource.action"`, at most 8: one source (`unload`, `retrieve`, `outside.in`), one target (`load`, `store`,
        /// `outside.out`), at most one carrier.
        actions: Option<Located<Vec<LocatedName>>> = texts(ACTIONS_MAX).required(),
        /// How many seconds it takes, up to a day; without it, and without orders, it takes no time.
        time as "time_s": Option<Located<Duration>> = seconds(),
        /// What stations are ordered to do for it, at most 16. It has ended when all are done.
        orders: Vec<RawOrder> = tables(ORDERS_MAX),
    }

    /// What a machine does by itself, with the work of its station.
    pub(super) struct RawCellAction is "an action" {
        /// `"M1.process"`: the resource and its action.
        of: Option<LocatedName> = text().required(),
        /// What stations are ordered to do for it, at most 16.
        orders: Vec<RawOrder> = tables(ORDERS_MAX),
    }

    /// A task that a station is ordered to do.
    pub(super) struct RawOrder is "an order" {
        /// By name, at most 16: a whole number, `"step.program"` where a machine works, or `"ST.position"` where a
        /// `random-access-store` or `lifo-buffer` takes part: the position, from 1, that the part has there.
        parameters: Vec<(LocatedName, Located<Scalar>)> = scalars(PARAMETERS_MAX).or_default(),
        /// The station, at most once in an activity.
        station: Option<LocatedName> = text().required(),
        /// One of its tasks.
        task: Option<LocatedName> = text().required(),
        /// How many seconds it may take from the start of the activity, up to a day; longer than the activity's time. Left
        /// out it is `safety` times that.
        limit as "max_s": Option<Located<Duration>> = seconds(),
    }

    /// A part type: what is done with it, in which order.
    pub(super) struct RawPart is "a part" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`.
        name: Option<LocatedName> = text().required(),
        /// Its plan, which leads forward only; at most 500 steps.
        steps as "step": Vec<RawStep> = tables(STEPS_MAX),
        /// Part types of their own with which some of these steps are not done, at most 100.
        variants as "variant": Vec<RawVariant> = tables(VARIANTS_MAX),
    }

    /// A part type with the plan of another one, but for some steps.
    pub(super) struct RawVariant is "a variant" {
        /// Its name, which production orders have: without `.` `<` `>` `,` `/` `*` `:`, no other part's.
        name: Option<LocatedName> = text().required(),
        /// The steps that are left out.
        without: Option<Located<Vec<LocatedName>>> = texts(STEPS_MAX).required(),
    }

    /// A step of a plan.
    pub(super) struct RawStep is "a step" {
        /// Its name, without `.` `<` `>` `,` `/` `*` `:`; not `new` or `done`, which every part has.
        name: Option<LocatedName> = text().required(),
        /// An alternative: it begins where this earlier step begins.
        or: Option<LocatedName> = text(),
        /// It leads to where this later step begins, or with `"done"` to the end; the next one listed if left out.
        then: Option<LocatedName> = text(),
        /// Where it can be done, one or several, at most 100: `{ resource = "M1", time_s = 40, program = 1 }`.
        on: Vec<RawOn> = tables(ALTERNATIVES_MAX).missed(KeyPresence::Required),
    }

    /// A resource on which a step can be done.
    pub(super) struct RawOn is "a resource of a step" {
        /// Whether a program is written, even if it could not be read.
        has_program as "program": bool = written(),
        /// The resource.
        resource: Option<LocatedName> = text().required(),
        /// How many seconds it takes there, up to a day.
        time as "time_s": Option<Located<Duration>> = seconds().required(),
        /// A part stays in the resource after a step there and is not unloaded for this one: it `"may"`, or it `"must"` and
        /// is not loaded for this step. Left out, each step is after a load.
        stays: Option<Located<Staying>> = one_of(&STAYING),
        /// The number that orders mean by `"step.program"`, of 32 bits.
        program: Option<Located<i64>> = whole(i32::MIN.into(), i32::MAX.into()),
    }

    /// What to do when an activity fails.
    pub(super) struct RawException is "an exception" {
        /// Of which synchronisations and actions; `*` stands for anything: `"load M*"`, `"M1.process"`.
        within as "in": Option<LocatedName> = text().required(),
        /// `"time-out"`, `"refused"`, `"station-lost"`, `"device-lost"`, `"alarm"`, a code of the task, or `"*"`.
        code: Option<LocatedName> = text().required(),
        /// The message to the operator, with `{part}`, `{type}`, `{activity}`, `{carrier}`, `{from}`, `{to}`, `{slot}`.
        tell: Option<LocatedName> = text().required(),
        /// How often `redo` may be answered, 0 to 100.
        retries: i64 = whole(0, 100).or(0),
        /// What is left out after any answer, at most 16: resources, or `"from"`, `"to"`, `"carrier"` of the activity.
        down: Option<Located<Vec<LocatedName>>> = texts(DOWN_MAX),
        /// The first answer is taken without asking, as long as all stations are at rest.
        automatic: bool = flag().or(false),
        /// Stations that go into emergency stop at once, at most 16; `"*"` for all that have an order in the activity. Not
        /// with `automatic`.
        emergency_stop: Option<Located<Vec<LocatedName>>> = texts(DOWN_MAX),
        /// What can be answered, at most 16.
        answers: Vec<RawAnswer> = tables(ANSWERS_MAX).missed(KeyPresence::Required),
    }

    /// An answer to an alarm.
    pub(super) struct RawAnswer is "an answer" {
        /// What is answered: one word.
        word: Option<LocatedName> = text().required(),
        /// Where the part is: where it was, where it was to go, with the carrier, or gone.
        part: Option<Located<Whereabouts>> = one_of(&WHEREABOUTS).required(),
        /// `"redo"`: the same once more; `"backward"`: decided anew; `"forward"`: as if it were done.
        then: Option<Located<Strategy>> = one_of(&STRATEGIES).required(),
        /// What is left out after it, at most 16: resources, or `"from"`, `"to"`, `"carrier"` of the activity.
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
