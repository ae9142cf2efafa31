//! The checked line: other crates may rely on it without checks.
//!
//! A [`Line`] exists only after [`crate::parse`] has resolved every name and checked every rule, so its ids index
//! without a `Result`. It has no files, spans or spelling: those stay with the text it came from. The fields are public
//! because a `Line` is data; building one by hand is for generators and tests, which pass it through [`crate::parse`]
//! by writing it as text first.

use std::fmt;
use std::time::Duration;

use linewright_text::index_id;

use crate::hand::HandMode;
use crate::{Console, Device, MaterialFlow, NumberedOrder, Owner, Rest, Task, TaskOrderSource};

index_id! {
    /// A station, by its place in [`Line::stations`].
    StationId
}
index_id! {
    /// An operation of one station, by its place in [`Station::operations`], which is the chart's order.
    OpId
}
index_id! {
    /// A digital input of one station, by its place in [`Station::inputs`]: bit `i` of its input image.
    InputId
}
index_id! {
    /// A digital output of one station, by its place in [`Station::outputs`]: bit `i` of its output image.
    OutputId
}

impl InputId {
    /// Its bit of the image; 0 beyond its width.
    pub const fn bit(self) -> u128 {
        bit(self.0)
    }
}

impl OutputId {
    /// Its bit of the image; 0 beyond its width.
    pub const fn bit(self) -> u128 {
        bit(self.0)
    }
}

const fn bit(at: u16) -> u128 {
    if (at as usize) < IMAGE_BITS { 1 << at } else { 0 }
}

index_id! {
    /// A hand-mode push button of the main console, by its place in [`Line::buttons`].
    ButtonId
}
index_id! {
    /// A mechanism's axis of one station, by its place in [`Station::axes`].
    AxisId
}
index_id! {
    /// A CAN device, by its place in [`Line::devices`].
    DeviceId
}

/// At most this many inputs, and as many outputs, in one station's process image.
pub const IMAGE_BITS: usize = 128;
/// At most this many hand-mode buttons on the main console.
pub const BUTTONS_MAX: usize = 32;
/// At most this many operations in one station.
pub const OPERATIONS_MAX: usize = 64;
/// At most this many operations side by side in one concurrent group.
pub const BRANCHES_MAX: usize = 8;

/// A production line, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The ROS namespace: lower-case letters, digits and `_`, starting with a letter.
    pub name: String,
    pub title: String,
    /// The stations in the order of the timing bar chart.
    pub stations: Vec<Station>,
    /// The causal arrows of the timing bar chart.
    pub arrows: Vec<Arrow>,
    /// Pairs of station states that must never hold together.
    pub conflicts: Vec<Conflict>,
    /// The CAN devices.
    pub devices: Vec<Device>,
    /// The hand-mode push buttons of the main console, by name.
    pub buttons: Vec<String>,
    /// The main console's own signals.
    pub console: Console,
    /// Times.
    pub timing: Timing,
    /// Places of parts, for the simulated plant.
    pub handling: MaterialFlow,
}

/// One station: an ordered cycle of operations, or tasks that are done when ordered.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// The ROS node name: lower-case letters, digits and `_`, starting with a letter.
    pub name: String,
    pub title: String,
    /// The operations in the order the chart lists them. The first starts a new cycle; those of a task stand together.
    pub operations: Vec<Operation>,
    /// The operation that brings the station to its home position: of a task-driven station, its first rest.
    pub home: OpId,
    /// The steps of the cycle, in chart order: one operation each, or several that run side by side (seed 002,
    /// Appendix). Neither the first step nor the one of the home operation has more than one.
    pub steps: Vec<Vec<OpId>>,
    /// Rests of a task-driven station, between its tasks, home first. Empty in a station that goes round a cycle.
    pub rests: Vec<Rest>,
    /// Its tasks. Empty in a station that goes round a cycle.
    pub tasks: Vec<Task>,
    /// Senders of orders for its tasks. [`TaskOrderSource::Coordinator`] in a station that goes round a cycle.
    pub order_source: TaskOrderSource,
    /// The mechanisms, for the simulated plant and for drawing.
    pub axes: Vec<Axis>,
    /// Names of the digital inputs: bit `i` of the input image is `inputs[i]`.
    pub inputs: Vec<String>,
    /// Names of the digital outputs: bit `i` of the output image is `outputs[i]`.
    pub outputs: Vec<String>,
    /// The operator's panel at the station.
    pub panel: Panel,
    /// The bus its devices hang on.
    pub bus: DeviceBus,
}

/// CAN bus of a device.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum DeviceBus {
    /// The coordinator's bus; the coordinator is the gateway of the process images.
    Line,
    /// A bus of the station's own, by the CAN interface's name.
    Own(String),
}

/// The operator's panel at a station: inputs of that station's own image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Panel {
    /// Selector: on is station-manual, off is station-auto.
    pub manual: Option<InputId>,
    /// Manual advance, `m_a`: hold to run.
    pub advance: Option<InputId>,
    /// Manual return, `m_r`: hold to run.
    pub retract: Option<InputId>,
}

/// One mechanism's axis, in millimetres (or degrees; only differences matter).
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name, as in the description.
    pub name: String,
    /// Position when the station is at home.
    pub home: f64,
    /// Of an axis that turns endlessly, one way: how far it goes with one index. Every index begins and ends at `home`, the
    /// one place that its switch measures.
    pub index: Option<f64>,
}

/// One operation of a station.
#[derive(Clone, Debug, PartialEq)]
pub struct Operation {
    /// The name as the chart prints it, e.g. `advance clamp`.
    pub name: String,
    /// Reversible or irreversible (seed 002 §4.5.1).
    pub module: OperationModule,
    /// Duration of the normal motion without faults.
    pub duration: Duration,
    /// After this long the normal motion counts as failed.
    pub watchdog: Duration,
    /// Motion of the operation.
    pub motion: Motion,
    /// Signals of the normal motion.
    pub normal: MotionSignals,
    /// Inputs that must be on before the normal motion starts; of task-driven stations.
    pub waits: Vec<InputId>,
    /// The code of an order whose time runs out while it waits for them, from 1; 0 where the description gives none.
    pub waits_code: u16,
    /// What must be on when the normal motion has completed, before the next operation starts in auto; of task-driven stations.
    pub result: Option<MotionResult>,
    /// Hand-mode type and its operator commands (seed 002 Figure 21, Table 3).
    pub hand: HandMode,
}

/// What a motion is to have brought about besides its limit switch, e.g. that there is a part in the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionResult {
    /// On where it has been brought about.
    pub input: InputId,
    /// Time from the end of the motion until the input has to be on.
    pub within: Duration,
    /// Code of an order that fails for it, from 1.
    pub code: u16,
}

/// The motion of an operation along one axis, for the simulated plant: from where to where. From home to home is the index of
/// an endless axis, and nothing else is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The axis it moves.
    pub axis: AxisId,
    /// Start of a normal motion and end of a recovery motion.
    pub from: f64,
    /// End of a normal motion.
    pub to: f64,
}

/// The operation module (seed 002 §4.5.2).
#[derive(Clone, Debug, PartialEq)]
pub enum OperationModule {
    /// R-module: a fault is recovered by resuming, or by returning and redoing.
    Reversible {
        /// Signals of the recovery motion.
        recovery: MotionSignals,
        /// Duration of the recovery motion.
        recovery_duration: Duration,
        /// After this long the recovery motion counts as failed.
        recovery_watchdog: Duration,
    },
    /// I-module: a fault is recovered by resuming, or by going home along a path.
    Irreversible {
        /// The reversible operations whose recovery motions lead home, in the order they are run; the home
        /// operation's normal motion follows (seed 002 §5.2.1 step 4). Empty for an index alone: the only way out of it is
        /// onward.
        recovery_path: Vec<OpId>,
    },
}

/// The signals of one motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionSignals {
    /// `a`: the output that drives it.
    pub actuator: OutputId,
    /// `s`: the input that is on when the motion has arrived.
    pub complete: InputId,
    /// `f`: the input that is on when the motion has failed, where the mechanism has such a sensor; every motion
    /// has its watchdog besides.
    pub fault: Option<InputId>,
    /// `d`: the lamp that announces its fault, if there is one.
    pub lamp: Option<OutputId>,
}

/// A causal arrow: `to` may start in its cycle c iff `from` is done in cycle c − `lag`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrow {
    /// The operation that must be done.
    pub from: (StationId, OpId),
    /// The operation that waits for it; never of the same station.
    pub to: (StationId, OpId),
    /// 0 within the same cycle, 1 when carried over from the previous one.
    pub lag: u32,
    /// Holds in auto mode.
    pub auto: bool,
    /// Holds in manual mode. Hand mode observes the arrows of both (seed 002 §5.5.2).
    pub manual: bool,
}

/// Two states that must never hold together.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// Reason: printed with a counterexample.
    pub why: String,
    /// One state.
    pub a: StateSpan,
    /// The other, of another station.
    pub b: StateSpan,
}

/// A state of a station as a stretch of its cycle, or one task of a task-driven station: it begins when operation
/// `from` starts (or the undoing of `until` starts) and ends when `until` is complete (or `from` has been undone).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateSpan {
    pub station: StationId,
    /// Its first operation.
    pub from: OpId,
    /// Its last operation; it may lie before `from` in the chart: the stretch then crosses the cycle boundary.
    pub until: OpId,
}

/// Times of the whole line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Period of a station's or the coordinator's whole state when nothing changes.
    pub refresh: Duration,
    /// A view, a process image or a held button older than this is unknown.
    pub stale: Duration,
    /// A mode not refreshed within this time has run out: stand-by.
    pub lease: Duration,
    /// Period of the heartbeat of a CAN device or manager.
    pub heartbeat: Duration,
    /// A CAN device or manager without a heartbeat for this long is lost.
    pub heartbeat_timeout: Duration,
    /// Period of SYNC of a manager on its bus, if it sends any.
    pub sync: Option<Duration>,
}

impl Default for Timing {
    /// Refresh 50 ms, stale 250 ms, lease 500 ms, heartbeat 50 ms, lost after 200 ms.
    ///
    /// Each limit is at least four times the period it watches: three lost messages in a row are noise on a loaded
    /// machine, a fourth is a fault.
    fn default() -> Self {
        Timing {
            refresh: Duration::from_millis(50),
            stale: Duration::from_millis(250),
            lease: Duration::from_millis(500),
            heartbeat: Duration::from_millis(50),
            heartbeat_timeout: Duration::from_millis(200),
            sync: None,
        }
    }
}

impl Line {
    /// The station with this id.
    pub fn station(&self, id: StationId) -> &Station {
        &self.stations[id.index()]
    }

    /// The operation with this id.
    pub fn operation(&self, (station, op): (StationId, OpId)) -> &Operation {
        &self.station(station).operations[op.index()]
    }

    /// The station with this name.
    pub fn station_named(&self, name: &str) -> Option<StationId> {
        self.stations.iter().position(|s| s.name == name).map(StationId::at)
    }

    /// All station ids, in chart order.
    pub fn station_ids(&self) -> impl Iterator<Item = StationId> + use<> {
        (0..self.stations.len()).map(StationId::at)
    }

    /// The devices that carry `owner`'s image, in the order of the description.
    pub fn devices_of(&self, owner: Owner) -> impl Iterator<Item = &Device> {
        self.devices.iter().filter(move |d| d.owner == owner)
    }

    /// The orders of a station to places by number.
    pub fn numbered_orders(&self, station: StationId) -> Vec<NumberedOrder> {
        let drives = self.devices_of(Owner::Station(station)).filter_map(Device::drive);
        drives.filter_map(NumberedOrder::of).collect()
    }
}

impl Station {
    /// The operation with this name.
    pub fn operation_named(&self, name: &str) -> Option<OpId> {
        self.operations.iter().position(|o| o.name == name).map(OpId::at)
    }

    /// All operation ids, in chart order.
    pub fn op_ids(&self) -> impl Iterator<Item = OpId> + use<> {
        (0..self.operations.len()).map(OpId::at)
    }

    /// Turn of an endless axis by an operation; none where it moves from one place to another.
    pub fn index_of(&self, op: OpId) -> Option<f64> {
        self.axes[self.operations[op.index()].motion.axis.index()].index
    }

    /// The step an operation belongs to, as an index into [`Station::steps`].
    pub fn step_of(&self, op: OpId) -> usize {
        self.steps.iter().position(|step| step.contains(&op)).expect("every operation belongs to a step")
    }

    /// Name with title, as operators see the station: `mill_1 (Milling unit 1)`. The name alone where the title is the same but for case and
    /// `_`.
    pub fn label(&self) -> String {
        let plain = |text: &str| text.to_lowercase().replace('_', " ");
        if plain(&self.title) == plain(&self.name) {
            return self.name.clone();
        }
        format!("{} ({})", self.name, self.title)
    }

    /// Count of an operation when the station stands at home at the end of round `n` (the home operation done `n`
    /// times): the operations listed up to home count `n`, everything after it `n` − 1.
    ///
    /// With home listed last that is `n` for all of them; a station that has never moved stands at
    /// [`Station::initial_round`]. Counts are signed because an operator may undo the home operation of a station
    /// that has never run a cycle.
    pub fn home_count(&self, op: OpId, n: i32) -> i32 {
        if op <= self.home || self.is_task_driven() { n } else { n - 1 }
    }

    /// The round a station that has never moved stands at the end of: 0 if it is task-driven or the home operation is
    /// the last one listed, else 1 (so that the operations listed up to it count cycle 1 and everything else counts 0).
    pub fn initial_round(&self) -> i32 {
        i32::from(!self.is_task_driven() && self.home.index() + 1 < self.operations.len())
    }
}

impl fmt::Display for DeviceBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DeviceBus::Line => f.write_str("the coordinator's bus"),
            DeviceBus::Own(interface) => f.write_str(interface),
        }
    }
}
