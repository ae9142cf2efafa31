//! A station's table, its operations and its tasks.

use std::time::Duration;

use linewright_text::{
    Located, LocatedName, Named, Problem, Report, Scalar, Shape, coordinate, coordinates, integer, keys, lists, one_of,
    part, positive, scalars, seconds, table, tables, text, texts, whole,
};

use super::station_type::TYPE_PARAMETERS_MAX;
use super::{RawHolder, RawReach};
use crate::{CODE_MAX, OPERATIONS_MAX, PARAMETER_BITS_MAX, PARAMETERS_MAX, RESTS_MAX, TASKS_MAX, TaskOrderSource};

/// At most this many axes in one station.
pub(super) const AXES_MAX: usize = 64;
/// At most this many places for parts in one station.
const HOLDERS_MAX: usize = 1000;
/// At most this many nests that the hands of one station reach.
const REACHES_MAX: usize = 256;
/// At most this many inputs that one operation waits for.
const WAITS_MAX: usize = 16;

keys! {
    /// A station: its mechanisms, and its operations in the order of the timing bar chart.
    pub(in crate::parse) struct RawStation is "a station" {
        /// The ROS node name: lower-case letters, digits and single `_`, a letter first, at most 64; `coordinator` is taken.
        name: Option<LocatedName> = text().required(),
        /// Station type; keys that the type gives can be left out here.
        of as "type": Option<LocatedName> = text(),
        /// Values of the type's parameters: `{ number = 3, io = 0x29 }`.
        parameters: Named<Located<Scalar>> = scalars(TYPE_PARAMETERS_MAX).or_default().like(parameters),
        /// Title of the station for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// The operation that brings the station to its home position. A task-driven station has tasks and rests instead.
        home: Option<LocatedName> = text().required_unless(&["task", "type"]),
        /// CAN interface (`"can1"`) of a bus of the station's own; the coordinator's bus if left out.
        bus: Option<LocatedName> = text(),
        /// The mechanisms, each with its position at home, in mm or degrees: `{ vertical = 0.0, horizontal = 0.0 }`. At
        /// most 64.
        axes: Vec<(LocatedName, f64)> = coordinates(AXES_MAX).required_unless(&["type"]).or_default(),
        /// Rests of a task-driven station, home first; at most 8.
        rests as "rest": Vec<RawRest> = tables(RESTS_MAX),
        /// Tasks of a task-driven station, at most 16.
        tasks as "task": Vec<RawTask> = tables(TASKS_MAX),
        /// Of a task-driven station: `"coordinator"` takes tasks only from the coordinator whose mode the station follows, `"any"`
        /// from every node of the ROS domain.
        order_source as "orders": Option<Located<TaskOrderSource>> =
            one_of(&[("coordinator", TaskOrderSource::Coordinator), ("any", TaskOrderSource::Any)]),
        /// Places for parts in this station, for the simulated plant; at most 1000.
        holders as "holder": Vec<RawHolder> = tables(HOLDERS_MAX),
        /// Nests that the station's grippers reach, for the simulated plant; at most 256.
        reaches as "reach": Vec<RawReach> = tables(REACHES_MAX),
        /// The operator's panel at the station: inputs of its own devices.
        panel: Option<RawPanel> = table(),
        /// The operations, in the order of the timing bar chart, at most 64. The first one begins a new cycle.
        operations as "operation": Vec<RawOperation> = tables(OPERATIONS_MAX),
    }

    /// A position of the whole station in which it rests between tasks.
    pub(in crate::parse) struct RawRest is "a rest" {
        /// Its name, unique in the station.
        name: Option<LocatedName> = text().required(),
        /// Positions of axes, in mm or degrees; that of `axes` for each that is left out. The first rest has none.
        positions as "at": Vec<(LocatedName, f64)> = coordinates(AXES_MAX).or_default(),
    }

    /// A task of a task-driven station: its operations lead from one rest to another, or to the same.
    pub(in crate::parse) struct RawTask is "a task" {
        /// Parameters of the order, at most 8: each a number, with the outputs that carry it, the lowest bit first, at
        /// most 31: `{ program = ["prog_1", "prog_2"] }`.
        parameters: Vec<(LocatedName, Located<Vec<LocatedName>>)> = lists(PARAMETERS_MAX, PARAMETER_BITS_MAX).or_default(),
        /// Name by which it is ordered, unique in the station.
        name: Option<LocatedName> = text().required(),
        /// The rest where it begins.
        from: Option<LocatedName> = text().required(),
        /// The rest where it ends.
        to: Option<LocatedName> = text().required(),
        /// Time limit of the task, in seconds, up to a day, whatever limit the order has; longer than its motions
        /// together.
        limit as "limit_s": Option<Located<Duration>> = seconds().required(),
    }

    /// The operator's panel at a station. Keys that are left out can be operated over ROS topics only.
    pub(in crate::parse) struct RawPanel is "`panel`" {
        /// Input: the selector, on is station-manual.
        manual: Option<LocatedName> = text(),
        /// Input: the button that is held to advance.
        advance: Option<LocatedName> = text(),
        /// Input: the button that is held to go back.
        retract as "return": Option<LocatedName> = text(),
    }

    /// An operation: one motion of an axis, with its signals, and how it is recovered.
    pub(in crate::parse) struct RawOperation is "an operation" {
        /// Name in the chart, unique in its station; words without `:`, at most 64 characters.
        name: Option<LocatedName> = text().required(),
        /// `"R"`: reversible, after a fault it is resumed or taken back; `"I"`: irreversible, it is resumed or the station
        /// goes home along `recovery_path`.
        kind as "module": Option<Located<ModuleKind>> = text().required().then(kind).like(|| Shape::Word(vec!["R", "I"])),
        /// The motion: `{ axis = "vertical", from = 0, to = 50 }`; the index of an endless axis: `{ axis = "table", by = 90 }`.
        moves: Option<RawMoves> = table().required(),
        /// Duration of the motion without faults, in seconds, up to a day.
        duration as "duration_s": Option<Located<Duration>> = seconds().required(),
        /// Time limit of the motion, in seconds, up to a day; longer than the duration, twice as long is usual.
        watchdog as "watchdog_s": Option<Located<Duration>> = seconds().required(),
        /// The signals of the motion.
        normal: Option<RawSignals> = table().required(),
        /// The signals of the motion back, of a reversible operation.
        recovery: Option<RawRecovery> = table(),
        /// Hand-mode type and buttons: `{ type = 3, forward = "PB_2", back = "PB_4" }`.
        hand: Option<RawHand> = table().required(),
        /// Recovery path after a fault, of an irreversible operation that is no index: reversible operations that are
        /// taken back in this order; the home operation follows by itself.
        recovery_path: Option<Located<Vec<LocatedName>>> = texts(OPERATIONS_MAX),
        /// Operation listed directly before; the two run side by side.
        with: Option<LocatedName> = text(),
        /// Task of the operation, at a task-driven station.
        task: Option<LocatedName> = text(),
        /// Inputs that must be on before the motion starts, at a task-driven station; at most 16.
        waits: Option<Located<Vec<LocatedName>>> = texts(WAITS_MAX),
        /// Code with which an order fails whose time runs out while the operation waits for `waits`, at a task-driven
        /// station; 1 to 999.
        waits_code: Option<Located<i64>> = whole(1, CODE_MAX.into()),
        /// What the motion is to have brought about, at a task-driven station:
        /// `{ input = "part_in_hand", within_s = 0.5, code = 24 }`. In auto the next operation of the task waits for it.
        result: Option<RawResult> = table(),
    }

    /// What a motion is to have brought about.
    pub(in crate::parse) struct RawResult is "`result`" {
        /// Input that is on where it has been brought about.
        input: Option<LocatedName> = text().required(),
        /// Time from the end of the motion until it has to be on, in seconds, up to a day.
        within as "within_s": Option<Located<Duration>> = seconds().required(),
        /// Code with which an order fails when it is not on then; 1 to 999.
        code: Option<Located<i64>> = whole(1, CODE_MAX.into()).required(),
    }

    /// The motion of an operation.
    pub(in crate::parse) struct RawMoves is "`moves`" {
        /// Axis that moves.
        axis: Option<LocatedName> = text().required(),
        /// Position where it starts, in mm or degrees.
        from: Option<Located<f64>> = coordinate().required_unless(&["by"]),
        /// Position where it ends, in mm or degrees.
        to: Option<Located<f64>> = coordinate().required_unless(&["by"]),
        /// Length of one index of an endless axis, in mm or degrees, above zero, instead of `from` and `to`. The index
        /// begins and ends at the switch `complete`.
        by: Option<Located<f64>> = positive(),
    }

    /// The signals of a motion.
    pub(in crate::parse) struct RawSignals is "`normal`" {
        /// Output that drives the motion.
        actuator: Option<LocatedName> = text().required(),
        /// Input that is on when the motion has arrived.
        complete: Option<LocatedName> = text().required(),
        /// Input that is on when the motion has failed; every motion has its watchdog besides.
        fault: Option<LocatedName> = text(),
        /// Output: a lamp that is on after a fault of the motion.
        lamp: Option<LocatedName> = text(),
    }

    /// The motion back.
    pub(in crate::parse) struct RawRecovery is "`recovery`" {
        /// Its signals.
        signals: RawSignals = part(),
        /// Duration of the motion back, in seconds, up to a day; if left out, that of the operation that is the same
        /// motion, or else that of the motion.
        duration as "duration_s": Option<Located<Duration>> = seconds(),
        /// Time limit of the motion back, in seconds, up to a day; that of the motion if left out.
        watchdog as "watchdog_s": Option<Located<Duration>> = seconds(),
    }

    /// Part of an operation in a hand-mode sequence: one held button runs the sequence, a second one may run it back.
    pub(in crate::parse) struct RawHand is "`hand`" {
        /// Hand type, 1 to 6. 1: first or intermediate operation of a sequence that is never reversed; 2: its last one.
        /// 3, 4, 5: first, intermediate and last operation of a reversed sequence. 6: on its own, reversed by another
        /// button.
        number as "type": Option<Located<i64>> = integer().required().from_to(1, 6),
        /// Button that is held to run.
        forward: Option<LocatedName> = text().required(),
        /// Button that is held to run back; types 3 to 6.
        back: Option<LocatedName> = text(),
        /// Button that starts the next operation, the `forward` of that; types 2, 5 and 6.
        next: Option<LocatedName> = text(),
    }
}

/// Whether an operation can be taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::parse) enum ModuleKind {
    Reversible,
    Irreversible,
}

/// Texts, numbers, true or false.
fn parameters() -> Shape {
    let number = Shape::Number(f64::NEG_INFINITY, f64::INFINITY);
    let value = Shape::Either(vec![Shape::Text, number, Shape::Flag]);
    Shape::Names(Box::new(value), TYPE_PARAMETERS_MAX)
}

fn kind(module: Option<LocatedName>, report: &mut Report) -> Option<Located<ModuleKind>> {
    let module = module?;
    let kind = match module.value.as_str() {
        "R" => ModuleKind::Reversible,
        "I" => ModuleKind::Irreversible,
        other => {
            report.add(
                Problem::error(module.at, format!("unknown module `{other}`"))
                    .hint("`R` for a reversible operation, `I` for an irreversible one"),
            );
            return None;
        }
    };
    Some(Located::new(kind, module.at))
}
