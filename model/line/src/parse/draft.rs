//! The description with its names resolved, as far as they could be.
//!
//! A draft has the shape of the [`crate::Line`] it may become, but every part may be missing where the text was wrong,
//! and every part has its place. The rules read a draft, so that one unknown name does not hide other errors.

use std::ops::Range;

use linewright_text::{Located, TextRange};

use super::names::LineNames;
use super::raw::{ModuleKind, RawHolder, RawLine, RawOperation, RawReach, RawStation, RawTask};
use crate::{
    Axis, AxisId, DeviceBus, HandMode, HolderId, InputId, Motion, OpId, OutputId, Owner, RestId, Stand, StationId,
    TaskId,
};

pub(super) struct DraftLine<'a> {
    pub raw: &'a RawLine,
    pub names: LineNames<'a>,
    pub stations: Vec<DraftStation<'a>>,
    pub arrows: Vec<DraftArrow>,
    pub conflicts: Vec<DraftConflict>,
    pub devices: Vec<DraftDevice>,
    pub console: DraftConsole,
    pub handling: DraftHandling<'a>,
}

pub(super) struct DraftStation<'a> {
    pub raw: &'a RawStation,
    /// Its name for messages; `?` where it has none.
    pub name: &'a str,
    pub operations: Vec<DraftOperation<'a>>,
    pub home: Option<Located<OpId>>,
    pub steps: Vec<Vec<OpId>>,
    pub axes: Vec<Axis>,
    /// Position of each axis, rest by rest.
    pub rests: Vec<Vec<f64>>,
    pub tasks: Vec<DraftTask<'a>>,
    /// Inputs that see parts.
    pub sensed: Vec<Located<InputId>>,
    pub bus: DeviceBus,
    pub wiring: Wiring,
    /// Manual, advance, return.
    pub panel: [Option<Located<InputId>>; 3],
}

pub(super) struct DraftOperation<'a> {
    pub raw: &'a RawOperation,
    /// Its name for messages; `?` where it has none.
    pub name: &'a str,
    pub motion: Option<Located<Motion>>,
    pub normal: DraftSignals,
    pub recovery: Option<DraftSignals>,
    pub hand: Option<Located<HandMode>>,
    pub path: Vec<Located<OpId>>,
    pub task: Option<Located<TaskId>>,
    pub waits: Vec<Located<InputId>>,
    pub result: Option<Located<InputId>>,
}

pub(super) struct DraftTask<'a> {
    pub raw: &'a RawTask,
    /// Its name for messages; `?` where it has none.
    pub name: &'a str,
    pub from: Option<Located<RestId>>,
    pub to: Option<Located<RestId>>,
    /// Its operations, as far as they stand together.
    pub ops: Range<usize>,
    pub parameters: Vec<DraftParameter<'a>>,
}

pub(super) struct DraftParameter<'a> {
    pub name: &'a str,
    pub bits: Vec<Option<Located<OutputId>>>,
}

#[derive(Clone, Default)]
pub(super) struct DraftSignals {
    pub actuator: Option<Located<OutputId>>,
    pub complete: Option<Located<InputId>>,
    pub fault: Option<Located<InputId>>,
    pub lamp: Option<Located<OutputId>>,
}

/// The image of one owner: the names of its bits, in the order of the devices.
#[derive(Default)]
pub(super) struct Wiring {
    pub inputs: Vec<Located<String>>,
    pub outputs: Vec<Located<String>>,
}

pub(super) type DraftEnd = Located<(StationId, OpId)>;

pub(super) struct DraftArrow {
    pub at: TextRange,
    pub from: Option<DraftEnd>,
    pub to: Option<DraftEnd>,
    pub lag: u32,
    pub auto: bool,
    pub manual: bool,
}

pub(super) struct DraftConflict {
    pub at: TextRange,
    pub a: Option<Located<crate::StateSpan>>,
    pub b: Option<Located<crate::StateSpan>>,
}

pub(super) struct DraftDevice {
    pub owner: Option<Owner>,
    pub bus: DeviceBus,
    pub inputs: Vec<Option<InputId>>,
    pub outputs: Vec<Option<OutputId>>,
    pub drive: Option<DraftDrive>,
    pub analogue: DraftAnalogue,
    pub frames: Option<DraftFrames>,
}

/// The signals of a device's frames, message by message.
#[derive(Default)]
pub(super) struct DraftFrames {
    pub inputs: Vec<Vec<Option<InputId>>>,
    pub outputs: Vec<Vec<Option<OutputId>>>,
}

/// The signals of a device's channels, channel by channel.
#[derive(Default)]
pub(super) struct DraftAnalogue {
    /// Those of its limits, and the one for a missing measurement.
    pub inputs: Vec<(Vec<Option<InputId>>, Option<InputId>)>,
    pub outputs: Vec<Vec<Option<OutputId>>>,
}

pub(super) struct DraftDrive {
    pub axis: Option<AxisId>,
    /// In the order of the text, what is missing left out of each.
    pub targets: Vec<DraftTarget>,
    /// Of an endless axis: what moves it and where it is in place, and the bits of its places' numbers.
    pub index: Option<DraftIndex>,
    pub fault: Option<InputId>,
    pub homing: Option<(Option<OutputId>, Option<InputId>)>,
}

pub(super) struct DraftIndex {
    pub target: DraftTarget,
    pub to: Vec<Option<OutputId>>,
    pub place: Vec<Option<InputId>>,
}

#[derive(Clone, Copy)]
pub(super) struct DraftTarget {
    pub output: Option<OutputId>,
    pub at: Option<InputId>,
}

#[derive(Default)]
pub(super) struct DraftConsole {
    pub wiring: Wiring,
    /// Start, stop, auto, hand, estop, reset.
    pub inputs: [Option<Located<InputId>>; 6],
    pub buttons: Vec<Option<InputId>>,
    /// Auto, hand, manual, fault.
    pub lamps: [Option<Located<OutputId>>; 4],
}

pub(super) type DraftStand = Located<Stand>;

pub(super) struct DraftHandling<'a> {
    pub holders: Vec<DraftHolder<'a>>,
    pub reaches: Vec<DraftReach<'a>>,
    pub sensors: Vec<DraftSensor>,
}

pub(super) struct DraftHolder<'a> {
    pub raw: &'a RawHolder,
    /// With its station's before it.
    pub name: String,
    /// Its name and its station's are well formed.
    pub is_well_named: bool,
    pub closes: Option<DraftStand>,
}

pub(super) struct DraftReach<'a> {
    pub raw: &'a RawReach,
    pub hand: Option<HolderId>,
    pub to: Option<Located<HolderId>>,
    pub when: Vec<Option<DraftStand>>,
    pub position: Vec<Option<Located<OutputId>>>,
}

pub(super) struct DraftSensor {
    pub at: TextRange,
    pub input: Option<(StationId, Located<InputId>)>,
    pub when: Vec<Option<DraftSign>>,
}

pub(super) enum DraftSign {
    Part(HolderId),
    Stands(DraftStand),
}

impl DraftHolder<'_> {
    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }
}

impl DraftLine<'_> {
    fn drives_of(&self, station: StationId) -> impl Iterator<Item = &DraftDrive> {
        let of_station = self.devices.iter().filter(move |device| device.owner == Some(Owner::Station(station)));
        of_station.filter_map(|device| device.drive.as_ref())
    }

    /// How the drives of a station turn endless axes.
    pub fn indexes_of(&self, station: StationId) -> impl Iterator<Item = &DraftIndex> {
        self.drives_of(station).filter_map(|drive| drive.index.as_ref())
    }

    /// Whether a drive turns this axis of a station from place to place.
    pub fn is_turned_by_drive(&self, station: StationId, axis: AxisId) -> bool {
        self.drives_of(station).any(|drive| drive.axis == Some(axis) && drive.index.is_some())
    }

    /// What the bits of an owner's image are called.
    pub fn image(&self, owner: Owner) -> &Wiring {
        match owner {
            Owner::Station(id) => &self.stations[id.index()].wiring,
            Owner::Console => &self.console.wiring,
        }
    }
}

impl DraftDrive {
    /// What it is sent by, and the inputs that say that it is there.
    pub fn all_targets(&self) -> impl Iterator<Item = &DraftTarget> {
        self.targets.iter().chain(self.index.as_ref().map(|index| &index.target))
    }
}

impl DraftOperation<'_> {
    /// Reversible or not; `None` where the text has neither.
    pub fn kind(&self) -> Option<ModuleKind> {
        self.raw.kind.as_ref().map(|kind| kind.value)
    }

    /// Turn of an endless axis.
    pub fn by(&self) -> Option<&Located<f64>> {
        self.raw.moves.as_ref()?.by.as_ref()
    }

    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }

    /// Its motions' signals, normal and recovery, each with the position it drives to.
    pub fn motions(&self) -> impl Iterator<Item = (&DraftSignals, Option<f64>)> {
        let ends = self.motion.as_ref().map(|m| (m.value.to, m.value.from));
        let normal = (&self.normal, ends.map(|(to, _)| to));
        std::iter::once(normal).chain(self.recovery.as_ref().map(|r| (r, ends.map(|(_, from)| from))))
    }
}

impl DraftTask<'_> {
    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }
}

impl DraftStation<'_> {
    pub fn operation(&self, op: OpId) -> &DraftOperation<'_> {
        &self.operations[op.index()]
    }

    pub fn op_ids(&self) -> Range<usize> {
        0..self.operations.len()
    }

    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }

    /// Whether it is task-driven; else it goes round a cycle.
    pub fn is_task_driven(&self) -> bool {
        !self.tasks.is_empty()
    }

    /// The step an operation belongs to.
    pub fn step_of(&self, op: OpId) -> usize {
        self.steps.iter().position(|step| step.contains(&op)).unwrap_or(0)
    }

    /// Number of steps from the home operation to this one, going round: 1 for the first, the number of steps for the
    /// home operation itself.
    pub fn steps_since_home(&self, op: OpId) -> Option<usize> {
        let home = self.step_of(self.home.as_ref()?.value);
        let count = self.steps.len();
        Some((self.step_of(op) + count - home - 1) % count.max(1) + 1)
    }

    /// The operations in the order they are done after home; the home operation comes last.
    pub fn round_from_home(&self) -> Option<Vec<OpId>> {
        Some(self.round_after(self.home.as_ref()?.value).collect())
    }

    /// The operations in the order they are done after this one, which comes last.
    pub fn round_after(&self, last: OpId) -> impl Iterator<Item = OpId> {
        let count = self.operations.len();
        (1..=count).map(move |i| OpId::at((last.index() + i) % count))
    }
}

impl DraftLine<'_> {
    /// `station: operation`, for messages.
    pub fn full_name(&self, (station, op): (StationId, OpId)) -> String {
        let station = &self.stations[station.index()];
        format!("{}: {}", station.name, station.operation(op).name)
    }
}
