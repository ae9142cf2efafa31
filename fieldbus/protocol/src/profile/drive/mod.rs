//! One drive axis (CiA 402) bound to operations: an output means "go to this target", an input "is there".
//!
//! Pure: image, time and the drive's frames go in, frames to send come out. Transport, and whether the drive is alive,
//! are the manager's business.
//!
//! ```text
//!           one output on                enabled, mode shown        acknowledged
//!  Resting ───────────────▶ Preparing ────────────────────▶ Offered ────────────▶ Moving
//!     ▲                        │ │                             │                     │
//!     │                        │ └──────▶ Homing ──▶ Homed     │ drops out, fails    │
//!     │ every output off       ▼                               ▼                     ▼
//!     └───────────────────── Refused ◀──────────────────────────────────────────────┘
//! ```
//!
//! # Why it is safe to let go
//!
//! An output that is off must mean that nothing moves, whatever has been lost on the way:
//!
//! - **Rest is one constant word.** Without an order the drive is sent *quick stop*, in every state and again and
//!   again. It needs no knowledge of the drive, so it cannot be wrong about it; a lost frame is made good by the next,
//!   a repeated one changes nothing. The drive brakes on its quick stop ramp and then switches its power off by itself
//!   (option 605Ah = 2): after that one frame no further one is needed. From a disabled drive a stray frame moves
//!   nothing; motion takes four different words in the right order.
//! - **An axis that would sink** (`at_rest = "hold"`) must not lose its torque whenever an operation is complete. It
//!   gets *halt* instead: the same ramp (605Dh = 2), and then the drive holds.
//! - **The manager is gone**: the drive's own heartbeat consumer makes it quick stop (6007h = 3). A drive that refuses
//!   one of these options is not started.
//! - **The image was forgotten** because another device was lost: that is an image without outputs, and the same.
//! - **Two outputs at once** are two answers to where to go. Neither is chosen; it stops, and moves again only after
//!   all of them have been off.
//! - **A drive that drops out** of an order (a fault, a guard, a technician's tool) is not enabled again under that
//!   order. Whether it is safe to go on is decided with the next one.
//! - **A set-point is taken on a rising edge**, so a lost frame could make the drive go on to an older one. Before a
//!   new set-point is offered, the drive has therefore been seen to know that the bit is low: by its acknowledge
//!   falling, or by leaving operation enabled. Where neither can be seen it is disabled first. Target and edge are in
//!   one frame.
//! - **Where it is counts only if it knows.** Before homing it is at no target, and refuses to go to one.
//! - **An endless axis is sent to a place, and positions count within one turn**: an order that comes twice, late, or again after a
//!   restart leads to the same place. It turns one way, so a drive that has gone past its place by a hair would go round for
//!   it. Therefore nothing is offered while it is there already, before it stands, or from anywhere but between that place
//!   and the one before.
//!
//! A failed drive is reset only while none of its outputs is on. The latch a person has to release is the operation's:
//! it stays incomplete until an operator leads on.

mod binding;
mod error;
mod explain;
mod places;
mod plan;
mod settings;
mod status;
pub mod word;

use std::time::Duration;

use linewright_line::{OutputId, Tick};

pub use binding::{DriveBinding, DriveSetpoint, HomingBinding};
pub use error::{FOLLOWING_ERROR, SENSOR_1, loses_position, meaning};
pub use places::{DrivePlaces, PlaceAt};
pub use status::{DriveState, Statusword};

use crate::codec::Payload;
use crate::sdo::{Abort, SdoWrite};
use binding::DriveDemand;

/// Bytes of a drive's process data, each way: controlword or statusword, mode, target or actual value.
pub const PDO_BYTES: usize = 7;
/// In which part of its round the fault reset is high: low first, so that there is an edge, and long enough that a lost
/// frame is repeated within it.
const RESET_HIGH: std::ops::Range<Duration> = Duration::from_millis(100)..Duration::from_millis(300);
/// A reset that did not help is tried again after this long.
const RESET_ROUND: Duration = Duration::from_millis(1000);
/// A homing that has been reported all along counts as new after this long: some methods take no time at all.
const HOMING_SETTLE: Duration = Duration::from_millis(200);

/// Process data from a drive are shorter than they were mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{actual} bytes from a drive, expected {PDO_BYTES}")]
pub struct ShortPdo {
    pub actual: usize,
}

/// Data last received from a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct DriveFeedback {
    word: Statusword,
    mode: i8,
    /// Position or velocity.
    actual: i32,
}

/// Data for a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct DriveCommand {
    word: u16,
    mode: i8,
    target: i32,
}

/// Goal of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DriveGoal {
    Target(usize),
    Home,
}

/// Why it does not obey its outputs. Lasts until all of them have been off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DriveInhibit {
    Several(OutputId, OutputId),
    NotHomed,
    /// It is not between this target and the place before it, where its position is at all.
    NotNext {
        at: usize,
        from: i32,
    },
    Failed,
    /// It left operation enabled, or its mode, under an order.
    Interrupted(Statusword),
    HomingFailed,
    Velocity(Abort),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DrivePhase {
    Resting,
    Refused(DriveInhibit),
    Preparing(DriveGoal),
    Offered(usize),
    Moving(usize),
    /// `open`: it has been seen without a homing attained since this one was ordered.
    Homing {
        open: bool,
        since: Tick,
    },
    /// Homed as ordered; the output is still on.
    Homed,
    /// It was at its place as it was ordered there: nothing is to be moved.
    There,
}

/// Evidence of what the drive has seen of bit 4 of its controlword, whose rising edge starts things, and of the words
/// that take it out of operation enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ControlwordEdge {
    /// It has seen the bit low since it was last high, and obeys.
    Low,
    /// It may have seen it high.
    Raised,
    /// It has acknowledged it.
    Acknowledged,
    /// It was sent a word that takes it out of operation enabled, and has not been seen to leave.
    Leaving,
}

/// One drive, as the manager sees it.
#[derive(Clone, Debug)]
pub struct ManagedDrive {
    binding: DriveBinding,
    now: Tick,
    image: u128,
    feedback: Option<DriveFeedback>,
    sent: Option<DriveCommand>,
    phase: DrivePhase,
    edge: ControlwordEdge,
    homed: bool,
    /// Its profile velocity (6081h); `None` if unknown.
    velocity: Option<u32>,
    /// Its last error code, kept after a reset for diagnosis.
    error: Option<u16>,
    /// Since when it has been seen in fault without an order.
    failed_since: Option<Tick>,
}

impl ManagedDrive {
    /// A drive from which nothing has been received.
    pub fn new(binding: DriveBinding) -> Self {
        let velocity = Some(binding.velocity);
        ManagedDrive {
            binding,
            now: Tick::ZERO,
            image: 0,
            feedback: None,
            sent: None,
            phase: DrivePhase::Resting,
            edge: ControlwordEdge::Leaving,
            homed: false,
            velocity,
            error: None,
            failed_since: None,
        }
    }

    pub fn binding(&self) -> &DriveBinding {
        &self.binding
    }

    /// Takes its owner's output image. To be called with every image, also those in which nothing of it changes.
    pub fn set_image(&mut self, now: Tick, image: u128) {
        self.image = image;
        self.advance(now);
    }

    /// Takes what the drive sent.
    ///
    /// # Errors
    /// Process data that are too short change nothing.
    pub fn take(&mut self, now: Tick, payload: Payload) -> Result<(), ShortPdo> {
        let &[low, high, mode, a, b, c, d, ..] = payload.bytes() else {
            return Err(ShortPdo { actual: payload.bytes().len() });
        };
        let word = Statusword(u16::from_le_bytes([low, high]));
        let feedback = DriveFeedback { word, mode: mode as i8, actual: i32::from_le_bytes([a, b, c, d]) };
        self.see_edge(feedback);
        if !matches!(word.state(), DriveState::Fault | DriveState::FaultReactionActive) {
            self.failed_since = None;
        }
        self.feedback = Some(feedback);
        self.advance(now);
        Ok(())
    }

    pub fn poll(&mut self, now: Tick) {
        self.advance(now);
    }

    /// When [`ManagedDrive::poll`] changes what is to be sent, if nothing happens before.
    pub fn next_deadline(&self) -> Option<Tick> {
        let since = self.failed_since?;
        let round = self.now.since(since).as_micros() / RESET_ROUND.as_micros();
        let start = since + RESET_ROUND * u32::try_from(round).unwrap_or(u32::MAX);
        let edges = [start + RESET_HIGH.start, start + RESET_HIGH.end, start + RESET_ROUND + RESET_HIGH.start];
        edges.into_iter().find(|edge| *edge > self.now)
    }

    /// The device was lost, or is about to be configured: its state is forgotten, its zero included, since the drive
    /// may have lost it. An order that was on has to be given anew.
    ///
    /// [`ManagedDrive::settings`] are to be written before it is started again.
    pub fn lost(&mut self, now: Tick) {
        self.now = now;
        self.feedback = None;
        self.sent = None;
        self.edge = ControlwordEdge::Leaving;
        self.homed = false;
        self.velocity = Some(self.binding.velocity);
        self.failed_since = None;
        self.phase = match self.binding.wanted(self.image) {
            DriveDemand::Nothing => DrivePhase::Resting,
            _ => DrivePhase::Refused(DriveInhibit::Interrupted(Statusword(0))),
        };
    }

    /// Takes the error code of an emergency from it; 0: its errors are gone.
    pub fn emergency(&mut self, now: Tick, code: u16) {
        if code != 0 {
            self.error = Some(code);
        }
        if loses_position(code) {
            self.homed = false;
        }
        self.advance(now);
    }

    /// An object that must be written by SDO before it can go on. Stays until [`ManagedDrive::written`].
    pub fn wants_write(&self) -> Option<SdoWrite> {
        let DrivePhase::Preparing(DriveGoal::Target(at)) = self.phase else { return None };
        self.slow_or_fast(at).map(settings::profile_velocity)
    }

    /// The answer to a write from [`ManagedDrive::wants_write`].
    pub fn written(&mut self, now: Tick, setting: &SdoWrite, answer: Result<(), Abort>) {
        match answer {
            Ok(()) => self.velocity = setting.data.as_slice().try_into().ok().map(u32::from_le_bytes),
            Err(code) => {
                self.velocity = None;
                if matches!(self.phase, DrivePhase::Preparing(_)) {
                    self.phase = DrivePhase::Refused(DriveInhibit::Velocity(code));
                }
            }
        }
        self.advance(now);
    }

    /// Whether its data to be sent differ from those last sent.
    pub fn wants_to_send(&self) -> bool {
        self.sent != Some(self.command())
    }

    /// Data it is to be sent now; the caller sends them.
    pub fn give(&mut self) -> Payload {
        let command = self.command();
        let enables = |word: u16| word & word::ENABLE_OPERATION == word::ENABLE_OPERATION;
        if !enables(command.word) {
            let enabled = self.feedback.is_none_or(|feedback| feedback.word.state() == DriveState::OperationEnabled);
            // It is enabled, or may be by the time this arrives.
            if enabled || self.sent.is_some_and(|sent| enables(sent.word)) {
                self.edge = ControlwordEdge::Leaving;
            }
        } else if command.word & word::NEW_SET_POINT != 0 && self.edge == ControlwordEdge::Low {
            self.edge = ControlwordEdge::Raised;
        }
        self.sent = Some(command);
        payload(command)
    }

    /// Data that stop a drive in any state. All zeros would cut its power while it moves.
    pub fn rest(&self) -> Payload {
        payload(DriveCommand { word: word::QUICK_STOP, mode: self.binding.profile(), target: 0 })
    }

    /// The bits of its owner's input image that are on.
    pub fn inputs(&self) -> u128 {
        let home = self.binding.home.filter(|_| self.homed && !matches!(self.phase, DrivePhase::Homing { .. }));
        let done = home.and_then(|home| home.done).filter(|_| self.phase != DrivePhase::Preparing(DriveGoal::Home));
        let fault = self.binding.fault.filter(|_| self.has_failed());
        let targets = if self.binding.index.is_none() { self.binding.targets.len() } else { 0 };
        let places = (0..targets).filter(|&at| self.is_there(at)).map(|at| self.binding.targets[at].at);
        self.place_inputs() | places.chain(done).chain(fault).fold(0, |image, input| image | input.bit())
    }

    /// Of an endless axis: at which place it is, or which it has left last.
    fn place_inputs(&self) -> u128 {
        let (Some(places), Some(feedback)) = (&self.binding.index, self.feedback.filter(|_| self.knows_zero())) else {
            return 0;
        };
        // On its way to its zero it knows none.
        if matches!(self.phase, DrivePhase::Homing { .. } | DrivePhase::Preparing(DriveGoal::Home)) {
            return 0;
        }
        let Some(at) = places.at(feedback.actual) else { return 0 };
        self.binding.place_inputs(at.number, self.is_there(usize::from(at.number) - 1))
    }

    /// Whether it is at target `at`. While it is ordered there, also whether its statusword reports so.
    fn is_there(&self, at: usize) -> bool {
        let Some(feedback) = self.feedback.filter(|_| self.knows_zero()) else { return false };
        let target = &self.binding.targets[at];
        let is_near = match &self.binding.index {
            Some(places) => places.has(at, feedback.actual),
            None => feedback.actual.abs_diff(target.to) <= self.binding.window,
        };
        // Targets at one place share their input; of an endless axis all do, wherever they are.
        let is_same = |to: usize| match &self.binding.index {
            Some(_) => to == at,
            None => self.binding.targets[to].at == target.at,
        };
        is_near
            && match self.phase {
                DrivePhase::Preparing(DriveGoal::Target(to)) | DrivePhase::Offered(to) => !is_same(to),
                DrivePhase::Moving(to) => !is_same(to) || feedback.word.target_reached(),
                _ => true,
            }
    }

    fn has_failed(&self) -> bool {
        let failed = |feedback: DriveFeedback| {
            matches!(feedback.word.state(), DriveState::Fault | DriveState::FaultReactionActive)
        };
        matches!(self.phase, DrivePhase::Refused(_)) || self.feedback.is_some_and(failed)
    }

    fn knows_zero(&self) -> bool {
        self.homed || self.binding.home.is_none()
    }
}

fn payload(command: DriveCommand) -> Payload {
    let target = u64::from(command.target as u32);
    let bits = u64::from(command.word) | u64::from(command.mode as u8) << 16 | target << 24;
    Payload::from_bits(bits, PDO_BYTES * 8)
}

#[cfg(test)]
mod tests;
