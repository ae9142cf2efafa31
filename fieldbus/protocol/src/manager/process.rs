//! What a device's process data mean: bits of its owner's image and analogue channels, or the words of a drive.
//!
//! All of them keep the image their owner set last and say what follows from it. When a frame may be sent, and whether the
//! device can be trusted, is decided by whoever holds this (`peer.rs`).

use linewright_fieldbus_seam::{gather, scatter};
use linewright_line::{InputId, Io, OutputId, Tick, Timing};

use super::channels::{ChannelFault, Channels};
use super::event::IgnoreReason;
use super::on_error;
use crate::codec::{NodeId, Payload, Profile};
use crate::profile::drive::{Drive, DriveBinding};
use crate::sdo::Abort;
use crate::sdo::Setting;

/// A device's process data.
#[derive(Debug)]
pub(super) enum Process {
    /// Digital inputs and outputs, and analogue channels (CiA 401).
    Io(Bits, Box<Channels>),
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

impl Process {
    pub fn of_drive(drive: &linewright_line::Drive) -> Self {
        Process::Drive(Box::new(Drive::new(DriveBinding::of(drive))))
    }

    pub fn of_io(io: &Io, timing: &Timing) -> Self {
        let (inputs, outputs) = (io.inputs.clone(), io.outputs.clone());
        let bits = Bits { inputs, outputs, heard: 0, wanted: 0, sent: None };
        Process::Io(bits, Box::new(Channels::of(&io.analogue, timing)))
    }

    /// By which table its error codes are read.
    pub fn profile(&self) -> Profile {
        match self {
            Process::Io(..) => Profile::Io,
            Process::Drive(_) => Profile::Drive,
        }
    }

    /// What it is told before it is started.
    pub fn settings(&self, node: NodeId, own: &[linewright_line::Setting]) -> Vec<Setting> {
        match self {
            Process::Io(bits, channels) => {
                let mut settings = on_error::settings(&bits.outputs, channels.has_outputs(), own);
                settings.extend(channels.settings(node, own));
                settings
            }
            Process::Drive(drive) => drive.settings(node),
        }
    }

    /// Whether anything moves or lights up by it.
    pub fn has_outputs(&self) -> bool {
        match self {
            Process::Io(bits, channels) => !bits.outputs.is_empty() || channels.has_outputs(),
            Process::Drive(_) => true,
        }
    }

    /// Whether its first process data object has anything to say that must have been heard. What its channels say
    /// [`Channels::fault`] looks at.
    pub fn has_inputs(&self) -> bool {
        match self {
            Process::Io(bits, _) => !bits.inputs.is_empty(),
            Process::Drive(_) => true,
        }
    }

    /// Why nothing follows from what its channels say, if so.
    pub fn fault(&self, now: Tick) -> Option<ChannelFault> {
        self.channels().and_then(|channels| channels.fault(now))
    }

    pub fn channels(&self) -> Option<&Channels> {
        match self {
            Process::Io(_, channels) => Some(channels),
            Process::Drive(_) => None,
        }
    }

    pub fn channels_mut(&mut self) -> Option<&mut Channels> {
        match self {
            Process::Io(_, channels) => Some(channels),
            Process::Drive(_) => None,
        }
    }

    /// Its bits of its owner's input image.
    pub fn inputs(&self) -> u128 {
        match self {
            Process::Io(bits, channels) => gather(bits.heard, &bits.inputs) | channels.bits(),
            Process::Drive(drive) => drive.inputs(),
        }
    }

    /// Takes what it has sent in its first object, or in one with channels, 2 to 4.
    pub fn take(&mut self, now: Tick, object: u8, payload: Payload) -> Result<(), IgnoreReason> {
        match self {
            Process::Io(_, channels) if object > 1 => channels.take(now, object, payload),
            Process::Drive(_) if object > 1 => Err(IgnoreReason::UnknownCobId),
            Process::Io(bits, _) => {
                if payload.bytes().len() * 8 < bits.inputs.len() {
                    return Err(IgnoreReason::ShortPdo);
                }
                bits.heard = payload.bits();
                Ok(())
            }
            Process::Drive(drive) => drive.take(now, payload).map_err(|_| IgnoreReason::ShortPdo),
        }
    }

    /// Takes the image its owner has set, or the one without outputs after a loss.
    pub fn set_image(&mut self, now: Tick, image: u128) {
        match self {
            Process::Io(bits, channels) => {
                bits.wanted = scatter(image, &bits.outputs);
                channels.set_image(image);
            }
            Process::Drive(drive) => drive.set_image(now, image),
        }
    }

    /// Whether it is to be sent something else than it has.
    pub fn wants_to_send(&self) -> bool {
        match self {
            Process::Io(bits, channels) => {
                bits.sent.is_some_and(|sent| sent != bits.wanted) || channels.wants_to_send()
            }
            Process::Drive(drive) => drive.wants_to_send(),
        }
    }

    /// What it is to be sent now, each with the number of its object; the caller sends it.
    pub fn give(&mut self, mut send: impl FnMut(u8, Payload)) {
        match self {
            Process::Io(bits, channels) => {
                bits.sent = Some(bits.wanted);
                bits.give(bits.wanted, &mut send);
                channels.give(&mut send);
            }
            Process::Drive(drive) => send(1, drive.give()),
        }
    }

    /// What it is sent to let go of everything, whatever state it is in. For bits that is zero. For a drive it is a
    /// stop: all zeros would cut its power while it moves.
    pub fn rest(&self, mut send: impl FnMut(u8, Payload)) {
        match self {
            Process::Io(bits, channels) => {
                bits.give(0, &mut send);
                channels.rest(&mut send);
            }
            Process::Drive(drive) => send(1, drive.rest()),
        }
    }

    /// It was lost, or is about to be configured: from here on its outputs are taken to be off.
    pub fn lost(&mut self, now: Tick) {
        match self {
            Process::Io(bits, channels) => {
                bits.sent = None;
                channels.lost();
            }
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

    /// When time alone changes something: what is to be sent, or what can be trusted.
    pub fn deadline(&self) -> Tick {
        match self {
            Process::Io(_, channels) => channels.deadline(),
            Process::Drive(drive) => drive.next_deadline().unwrap_or(Tick::NEVER),
        }
    }

    /// An object it needs written before it can go on.
    pub fn wants_write(&self) -> Option<Setting> {
        match self {
            Process::Io(..) => None,
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
            Process::Io(_, channels) => channels.explain(),
            Process::Drive(drive) => Some(drive.explain()),
        }
    }
}

impl Bits {
    fn give(&self, bits: u64, send: &mut impl FnMut(u8, Payload)) {
        if !self.outputs.is_empty() {
            send(1, Payload::from_bits(bits, self.outputs.len()));
        }
    }
}
