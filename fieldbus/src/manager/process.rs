//! What a device's process data mean: bits of its owner's image, or the words of a drive.
//!
//! Both keep the image their owner set last and say what follows from it. When a frame may be sent, and whether the
//! device can be trusted, is decided by whoever holds this (`peer.rs`).

use linewright_line::{Device, InputId, OutputId, Tick};

use super::image;
use crate::codec::{NodeId, Payload, Profile};
use crate::profile::drive::{Drive, DriveBinding, Setting};
use crate::sdo::Abort;

/// A device's process data.
#[derive(Debug)]
pub(super) enum Process {
    /// Digital inputs and outputs (CiA 401).
    Bits(Bits),
    /// A drive (CiA 402).
    Drive(Box<Drive>),
}

#[derive(Debug)]
pub(super) struct Bits {
    inputs: Vec<Option<InputId>>,
    outputs: Vec<Option<OutputId>>,
    /// Its inputs as last sent; kept for showing after a loss.
    heard: u64,
    /// Its share of the image its owner set last.
    wanted: u64,
    /// What it was last sent; `None` since the last boot or loss.
    sent: Option<u64>,
}

/// Process data that are shorter than what the device is said to carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Short;

impl Process {
    pub fn of(device: &Device) -> Self {
        match &device.drive {
            Some(drive) => Process::Drive(Box::new(Drive::new(DriveBinding::of(drive)))),
            None => Process::Bits(Bits {
                inputs: device.inputs.clone(),
                outputs: device.outputs.clone(),
                heard: 0,
                wanted: 0,
                sent: None,
            }),
        }
    }

    /// By which table its error codes are read.
    pub fn profile(&self) -> Profile {
        match self {
            Process::Bits(_) => Profile::Io,
            Process::Drive(_) => Profile::Drive,
        }
    }

    /// What it is told before it is started.
    pub fn settings(&self, node: NodeId) -> Vec<Setting> {
        match self {
            Process::Bits(_) => Vec::new(),
            Process::Drive(drive) => drive.settings(node),
        }
    }

    /// Whether anything moves or lights up by it.
    pub fn has_outputs(&self) -> bool {
        match self {
            Process::Bits(bits) => !bits.outputs.is_empty(),
            Process::Drive(_) => true,
        }
    }

    /// Whether it has anything to say that must have been heard.
    pub fn has_inputs(&self) -> bool {
        match self {
            Process::Bits(bits) => !bits.inputs.is_empty(),
            Process::Drive(_) => true,
        }
    }

    /// Its bits of its owner's input image.
    pub fn inputs(&self) -> u128 {
        match self {
            Process::Bits(bits) => image::gather(bits.heard, &bits.inputs),
            Process::Drive(drive) => drive.inputs(),
        }
    }

    /// Takes what it has sent.
    pub fn take(&mut self, now: Tick, payload: Payload) -> Result<(), Short> {
        match self {
            Process::Bits(bits) => {
                if payload.bytes().len() * 8 < bits.inputs.len() {
                    return Err(Short);
                }
                bits.heard = payload.bits();
                Ok(())
            }
            Process::Drive(drive) => drive.take(now, payload).map_err(|_| Short),
        }
    }

    /// Takes the image its owner has set, or the one without outputs after a loss.
    pub fn set_image(&mut self, now: Tick, image: u128) {
        match self {
            Process::Bits(bits) => bits.wanted = image::scatter(image, &bits.outputs),
            Process::Drive(drive) => drive.set_image(now, image),
        }
    }

    /// Whether it is to be sent something else than it has.
    pub fn wants_to_send(&self) -> bool {
        match self {
            Process::Bits(bits) => bits.sent.is_some_and(|sent| sent != bits.wanted),
            Process::Drive(drive) => drive.wants_to_send(),
        }
    }

    /// What it is to be sent now; the caller sends it.
    pub fn give(&mut self) -> Payload {
        match self {
            Process::Bits(bits) => {
                bits.sent = Some(bits.wanted);
                Payload::from_bits(bits.wanted, bits.outputs.len())
            }
            Process::Drive(drive) => drive.give(),
        }
    }

    /// What it is sent to let go of everything, whatever state it is in. For bits that is zero. For a drive it is a
    /// stop: all zeros would cut its power while it moves.
    pub fn rest(&self) -> Payload {
        match self {
            Process::Bits(bits) => Payload::from_bits(0, bits.outputs.len()),
            Process::Drive(drive) => drive.rest(),
        }
    }

    /// It was lost, or is about to be configured: from here on its outputs are taken to be off.
    pub fn lost(&mut self, now: Tick) {
        match self {
            Process::Bits(bits) => bits.sent = None,
            Process::Drive(drive) => drive.lost(now),
        }
    }

    pub fn emergency(&mut self, now: Tick, code: u16) {
        if let Process::Drive(drive) = self {
            drive.emergency(now, code);
        }
    }

    /// Lets time pass.
    pub fn poll(&mut self, now: Tick) {
        if let Process::Drive(drive) = self {
            drive.poll(now);
        }
    }

    /// When [`Process::poll`] changes what is to be sent.
    pub fn deadline(&self) -> Tick {
        match self {
            Process::Bits(_) => Tick::NEVER,
            Process::Drive(drive) => drive.next_deadline().unwrap_or(Tick::NEVER),
        }
    }

    /// An object it needs written before it can go on.
    pub fn wants_write(&self) -> Option<Setting> {
        match self {
            Process::Bits(_) => None,
            Process::Drive(drive) => drive.wants_write(),
        }
    }

    /// What became of that.
    pub fn written(&mut self, now: Tick, setting: &Setting, answer: Result<(), Abort>) {
        if let Process::Drive(drive) = self {
            drive.written(now, setting, answer);
        }
    }

    /// What there is to say of it while it runs.
    pub fn explain(&self) -> Option<String> {
        match self {
            Process::Bits(_) => None,
            Process::Drive(drive) => Some(drive.explain()),
        }
    }
}
