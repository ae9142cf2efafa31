//! The description as written: every value with the place it was written at, no name resolved yet.
//!
//! A field is `None` when it is missing or could not be read; whoever read it has reported that, so that no later rule
//! has to. This is the only form that knows how the text is laid out; [`super::draft`] is the first that knows what the
//! names mean.

use std::time::Duration;

use linewright_text::{At, Name, Where};

use crate::{AtRest, Checksum, DriveMode, Reaction, Table};

#[derive(Debug)]
pub(super) struct RawLine {
    pub name: Option<Name>,
    pub title: Option<Name>,
    pub buttons: Vec<Name>,
    pub timing: RawTiming,
    pub stations: Vec<RawStation>,
    pub arrows: Vec<RawArrow>,
    pub conflicts: Vec<RawConflict>,
    pub devices: Vec<RawDevice>,
    pub holders: Vec<RawHolder>,
    pub sensors: Vec<RawSensor>,
    pub console: Option<RawConsole>,
}

#[derive(Debug, Default)]
pub(super) struct RawTiming {
    pub refresh: Option<At<Duration>>,
    pub stale: Option<At<Duration>>,
    pub lease: Option<At<Duration>>,
    pub heartbeat: Option<At<Duration>>,
    pub heartbeat_timeout: Option<At<Duration>>,
    pub sync: Option<At<Duration>>,
}

#[derive(Debug)]
pub(super) struct RawStation {
    /// Its header, for problems that are about the station as a whole.
    pub at: Where,
    pub name: Option<Name>,
    pub title: Option<Name>,
    pub home: Option<Name>,
    pub bus: Option<Name>,
    pub axes: Vec<(Name, f64)>,
    pub rests: Vec<RawRest>,
    pub tasks: Vec<RawTask>,
    pub holders: Vec<RawHolder>,
    pub reaches: Vec<RawReach>,
    pub panel: Option<RawPanel>,
    pub operations: Vec<RawOperation>,
}

#[derive(Debug)]
pub(super) struct RawRest {
    pub at: Where,
    pub name: Option<Name>,
    pub positions: Vec<(Name, f64)>,
}

#[derive(Debug)]
pub(super) struct RawTask {
    pub at: Where,
    pub name: Option<Name>,
    pub from: Option<Name>,
    pub to: Option<Name>,
    pub limit: Option<At<Duration>>,
    pub parameters: Vec<(Name, At<Vec<Name>>)>,
}

#[derive(Debug)]
pub(super) struct RawHolder {
    pub at: Where,
    pub name: Option<Name>,
    pub places: Option<At<i64>>,
    pub is_hand: bool,
    pub closes: Option<RawStand>,
}

#[derive(Debug)]
pub(super) struct RawStand {
    pub axis: Option<Name>,
    pub position: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawReach {
    pub at: Where,
    pub hand: Option<Name>,
    pub to: Option<Name>,
    pub when: Vec<(Name, f64)>,
    pub position: Option<At<Vec<Name>>>,
}

#[derive(Debug)]
pub(super) struct RawSensor {
    pub at: Where,
    pub station: Option<Name>,
    pub input: Option<Name>,
    pub when: Vec<RawSign>,
}

/// A part, or an axis and where it stands.
#[derive(Debug)]
pub(super) struct RawSign {
    pub at: Where,
    pub part: Option<Name>,
    pub axis: Option<Name>,
    pub position: Option<At<f64>>,
}

#[derive(Debug, Default)]
pub(super) struct RawPanel {
    pub manual: Option<Name>,
    pub advance: Option<Name>,
    pub retract: Option<Name>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Reversible,
    Irreversible,
}

#[derive(Debug)]
pub(super) struct RawOperation {
    /// Its header.
    pub at: Where,
    pub name: Option<Name>,
    pub kind: Option<At<Kind>>,
    pub moves: Option<RawMoves>,
    pub duration: Option<At<Duration>>,
    pub watchdog: Option<At<Duration>>,
    pub normal: Option<RawSignals>,
    pub recovery: Option<RawRecovery>,
    pub hand: Option<RawHand>,
    pub recovery_path: Option<At<Vec<Name>>>,
    pub with: Option<Name>,
    pub task: Option<Name>,
    pub waits: Option<At<Vec<Name>>>,
    pub waits_code: Option<At<i64>>,
}

#[derive(Debug)]
pub(super) struct RawMoves {
    pub at: Where,
    pub axis: Option<Name>,
    pub from: Option<At<f64>>,
    pub to: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawSignals {
    pub actuator: Option<Name>,
    pub complete: Option<Name>,
    pub fault: Option<Name>,
    pub lamp: Option<Name>,
}

#[derive(Debug)]
pub(super) struct RawRecovery {
    pub at: Where,
    pub signals: RawSignals,
    pub duration: Option<At<Duration>>,
    pub watchdog: Option<At<Duration>>,
}

#[derive(Debug)]
pub(super) struct RawHand {
    pub at: Where,
    pub number: Option<At<i64>>,
    pub forward: Option<Name>,
    pub back: Option<Name>,
    pub next: Option<Name>,
}

/// An end of an arrow, `station: operation`, taken apart; each half with its own place.
#[derive(Clone, Debug)]
pub(super) struct RawEnd {
    pub station: Name,
    pub operation: Name,
}

#[derive(Debug)]
pub(super) struct RawArrow {
    pub at: Where,
    pub from: Option<RawEnd>,
    pub to: Option<RawEnd>,
    pub lag: u32,
    pub auto: bool,
    pub manual: bool,
}

#[derive(Debug)]
pub(super) struct RawConflict {
    pub at: Where,
    pub why: Option<Name>,
    pub a: Option<RawSpan>,
    pub b: Option<RawSpan>,
}

#[derive(Debug)]
pub(super) struct RawSpan {
    pub at: Where,
    pub station: Option<Name>,
    pub from: Option<Name>,
    pub until: Option<Name>,
    /// Of a station on order, instead of both.
    pub task: Option<Name>,
}

#[derive(Debug)]
pub(super) struct RawDevice {
    pub at: Where,
    pub name: Option<Name>,
    pub node: Option<At<i64>>,
    pub station: Option<Name>,
    pub console: Option<At<bool>>,
    pub inputs: Vec<Name>,
    pub outputs: Vec<Name>,
    pub file: Option<Name>,
    pub identity: Option<RawIdentity>,
    pub settings: Vec<RawSetting>,
    pub without_error_values: Option<Name>,
    /// With its place.
    pub transmission: Option<(RawTransmission, Where)>,
    pub on_emergency: Option<At<Reaction>>,
    pub when_lost: Option<At<Reaction>>,
    pub drive: Option<RawDrive>,
    pub analogue: RawAnalogue,
    pub frames: Option<RawFrames>,
    pub kind: Option<At<RawDeviceKind>>,
    pub modbus: Option<RawModbus>,
}

/// What a device speaks, where its `kind` says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RawDeviceKind {
    Canopen,
    Modbus,
}

/// The `modbus` table of a device.
#[derive(Debug)]
pub(super) struct RawModbus {
    pub at: Where,
    pub address: Option<Name>,
    pub unit: Option<At<i64>>,
    pub cycle: Option<At<Duration>>,
    pub timeout: Option<At<Duration>>,
    pub inputs: Option<RawRegisters>,
    pub outputs: Option<RawRegisters>,
    pub watchdog: Option<RawWatchdog>,
    pub without_watchdog: Option<Name>,
    pub expect: Vec<RawRegisterValue>,
    pub settings: Vec<RawRegisterValue>,
}

/// A table of a Modbus device, and where in it bits begin.
#[derive(Debug)]
pub(super) struct RawRegisters {
    pub at: Where,
    pub table: Table,
    pub first: Option<At<i64>>,
}

#[derive(Debug)]
pub(super) struct RawWatchdog {
    pub at: Where,
    pub register: Option<At<i64>>,
    pub timeout: Option<At<Duration>>,
}

#[derive(Debug)]
pub(super) struct RawRegisterValue {
    pub register: Option<At<i64>>,
    pub value: Option<At<i64>>,
}

/// Device type, vendor, product, revision, serial.
#[derive(Debug)]
pub(super) struct RawIdentity(pub [Option<At<i64>>; 5]);

#[derive(Debug)]
pub(super) struct RawTransmission {
    pub inputs: Option<At<i64>>,
    pub outputs: Option<At<i64>>,
}

#[derive(Debug)]
pub(super) struct RawSetting {
    pub object: Option<Name>,
    pub width: Width,
    pub value: Option<At<i64>>,
}

/// How many bytes a number has, and whether it has a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Width {
    pub bytes: u8,
    pub signed: bool,
}

#[derive(Debug)]
pub(super) struct RawDrive {
    pub at: Where,
    pub axis: Option<Name>,
    pub mode: DriveMode,
    pub units: Option<At<f64>>,
    pub window: Option<At<f64>>,
    pub velocity: Option<At<f64>>,
    pub acceleration: Option<At<f64>>,
    pub quick_stop: Option<At<f64>>,
    pub at_rest: AtRest,
    pub fault: Option<Name>,
    pub targets: Vec<RawTarget>,
    pub homing: Option<RawHoming>,
}

#[derive(Debug)]
pub(super) struct RawTarget {
    pub at: Where,
    pub output: Option<Name>,
    pub to: Option<At<f64>>,
    /// The input that says so.
    pub input: Option<Name>,
    pub velocity: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawHoming {
    pub method: Option<At<i64>>,
    pub fast: Option<At<f64>>,
    pub slow: Option<At<f64>>,
    pub acceleration: Option<At<f64>>,
    pub offset: Option<At<f64>>,
    pub output: Option<Name>,
    pub done: Option<Name>,
}

/// The channels of a device.
#[derive(Debug)]
pub(super) struct RawAnalogue {
    pub inputs: Vec<RawAnalogueInput>,
    pub outputs: Vec<RawAnalogueOutput>,
}

#[derive(Debug)]
pub(super) struct RawChannel {
    pub at: Where,
    pub number: Option<At<i64>>,
    pub unit: Option<Name>,
    pub factor: Option<At<f64>>,
    pub offset: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawAnalogueInput {
    pub channel: RawChannel,
    pub least: Option<At<f64>>,
    pub most: Option<At<f64>>,
    pub inputs: Vec<RawLimit>,
    pub broken: Option<Name>,
    pub simulated: Option<RawLag>,
}

#[derive(Debug)]
pub(super) struct RawLimit {
    pub at: Where,
    pub input: Option<Name>,
    pub above: Option<At<f64>>,
    pub below: Option<At<f64>>,
    pub hysteresis: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawLag {
    pub at: Where,
    pub output: Option<Name>,
    pub on: Option<At<f64>>,
    pub off: Option<At<f64>>,
    pub channel: Option<At<i64>>,
    pub lag: Option<At<Duration>>,
}

#[derive(Debug)]
pub(super) struct RawAnalogueOutput {
    pub channel: RawChannel,
    pub rest: Option<At<f64>>,
    pub outputs: Vec<RawLevel>,
}

#[derive(Debug)]
pub(super) struct RawLevel {
    pub output: Option<Name>,
    pub value: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawFrames {
    pub at: Where,
    pub file: Option<Name>,
    pub receive: Vec<RawHeard>,
    pub send: Vec<RawTold>,
}

#[derive(Debug)]
pub(super) struct RawHeard {
    pub message: Option<Name>,
    pub timeout: Option<At<Duration>>,
    pub counter: Option<Name>,
    pub checksum: Option<(Name, Checksum)>,
    pub inputs: Vec<RawSignalInput>,
}

#[derive(Debug)]
pub(super) struct RawSignalInput {
    pub at: Where,
    pub input: Option<Name>,
    pub signal: Option<Name>,
    pub equals: Option<At<f64>>,
    pub above: Option<At<f64>>,
    pub below: Option<At<f64>>,
    pub bit: Option<At<i64>>,
    pub hysteresis: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawTold {
    pub at: Where,
    pub message: Option<Name>,
    pub every: Option<At<Duration>>,
    pub lets_go_after: Option<At<Duration>>,
    pub counter: Option<Name>,
    pub checksum: Option<(Name, Checksum)>,
    pub outputs: Vec<RawSignalOutput>,
    pub set: Vec<RawSet>,
}

#[derive(Debug)]
pub(super) struct RawSignalOutput {
    pub output: Option<Name>,
    pub signal: Option<Name>,
    pub on: Option<At<f64>>,
    pub off: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawSet {
    pub signal: Option<Name>,
    pub value: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawConsole {
    pub at: Where,
    pub start: Option<Name>,
    pub stop: Option<Name>,
    pub auto: Option<Name>,
    pub hand: Option<Name>,
    pub estop: Option<Name>,
    /// What `estop` reads while it is pressed.
    pub estop_pressed: bool,
    pub reset: Option<Name>,
    /// In the order of [`crate::Console::lamps`].
    pub lamps: [Option<Name>; 4],
}
