//! Meaning of a device's process data: bits of its owner's image and analogue channels, or the words of a drive.
//!
//! All of them keep the image their owner set last and derive the frames from it. When a frame may be sent, and whether
//! the device can be trusted, is decided by the peer (`peer.rs`).

use linewright_fieldbus_seam::{gather, scatter};
use linewright_line::{InputId, Io, OutputId, Tick, Timing};

use super::channels::AnalogueChannels;
use super::fault::{ChannelFault, IgnoreReason};
use super::on_error;
use crate::codec::{NodeId, Payload, Profile};
use crate::profile::drive::{DriveBinding, ManagedDrive};
use crate::sdo::Abort;
use crate::sdo::SdoWrite;

#[derive(Debug)]
pub(super) enum ProcessData {
    /// Digital inputs and outputs, and analogue channels (CiA 401).
    Io(BitImage, Box<AnalogueChannels>),
    /// A drive (CiA 402).
    Drive(Box<ManagedDrive>),
}

#[derive(Debug)]
pub(super) struct BitImage {
    inputs: Vec<Option<InputId>>,
    outputs: Vec<Option<OutputId>>,
    /// Its inputs as last sent; kept for showing after a loss.
    received: u64,
    /// Its share of the image its owner set last.
    wanted: u64,
    /// Data last sent to it; `None` since the last boot or loss.
    sent: Option<u64>,
}

impl ProcessData {
    pub fn of_drive(drive: &linewright_line::Drive) -> Self {
        ProcessData::Drive(Box::new(ManagedDrive::new(DriveBinding::of(drive))))
    }

    pub fn of_io(io: &Io, timing: &Timing) -> Self {
        let (inputs, outputs) = (io.inputs.clone(), io.outputs.clone());
        let bits = BitImage { inputs, outputs, received: 0, wanted: 0, sent: None };
        ProcessData::Io(bits, Box::new(AnalogueChannels::of(&io.analogue, timing)))
    }

    /// By which table its error codes are read.
    pub fn profile(&self) -> Profile {
        match self {
            ProcessData::Io(..) => Profile::Io,
            ProcessData::Drive(_) => Profile::Drive,
        }
    }

    /// Settings before the device is started.
    pub fn settings(&self, node: NodeId, own: &[linewright_line::ObjectWrite]) -> Vec<SdoWrite> {
        match self {
            ProcessData::Io(bits, channels) => {
                let mut settings = on_error::settings(&bits.outputs, channels.has_outputs(), own);
                settings.extend(channels.settings(node, own));
                settings
            }
            ProcessData::Drive(drive) => drive.settings(node),
        }
    }

    /// Whether anything moves or lights up by it.
    pub fn has_outputs(&self) -> bool {
        match self {
            ProcessData::Io(bits, channels) => !bits.outputs.is_empty() || channels.has_outputs(),
            ProcessData::Drive(_) => true,
        }
    }

    /// Whether its first process data object has inputs that must have been received. Channels: see
    /// [`AnalogueChannels::fault`].
    pub fn has_inputs(&self) -> bool {
        match self {
            ProcessData::Io(bits, _) => !bits.inputs.is_empty(),
            ProcessData::Drive(_) => true,
        }
    }

    /// Why its channels' values are unusable, if so.
    pub fn fault(&self, now: Tick) -> Option<ChannelFault> {
        self.channels().and_then(|channels| channels.fault(now))
    }

    pub fn channels(&self) -> Option<&AnalogueChannels> {
        match self {
            ProcessData::Io(_, channels) => Some(channels),
            ProcessData::Drive(_) => None,
        }
    }

    pub fn channels_mut(&mut self) -> Option<&mut AnalogueChannels> {
        match self {
            ProcessData::Io(_, channels) => Some(channels),
            ProcessData::Drive(_) => None,
        }
    }

    /// Its bits of its owner's input image.
    pub fn inputs(&self) -> u128 {
        match self {
            ProcessData::Io(bits, channels) => gather(bits.received, &bits.inputs) | channels.bits(),
            ProcessData::Drive(drive) => drive.inputs(),
        }
    }

    /// Takes data of its first object, or of one with channels, 2 to 4.
    pub fn take(&mut self, now: Tick, object: u8, payload: Payload) -> Result<(), IgnoreReason> {
        match self {
            ProcessData::Io(_, channels) if object > 1 => channels.take(now, object, payload),
            ProcessData::Drive(_) if object > 1 => Err(IgnoreReason::UnknownCobId),
            ProcessData::Io(bits, _) => {
                if payload.bytes().len() * 8 < bits.inputs.len() {
                    return Err(IgnoreReason::ShortPdo);
                }
                bits.received = payload.bits();
                Ok(())
            }
            ProcessData::Drive(drive) => drive.take(now, payload).map_err(|_| IgnoreReason::ShortPdo),
        }
    }

    /// Takes the image its owner has set, or the one without outputs after a loss.
    pub fn set_image(&mut self, now: Tick, image: u128) {
        match self {
            ProcessData::Io(bits, channels) => {
                bits.wanted = scatter(image, &bits.outputs);
                channels.set_image(image);
            }
            ProcessData::Drive(drive) => drive.set_image(now, image),
        }
    }

    /// Whether it is to be sent something else than it has.
    pub fn wants_to_send(&self) -> bool {
        match self {
            ProcessData::Io(bits, channels) => {
                bits.sent.is_some_and(|sent| sent != bits.wanted) || channels.wants_to_send()
            }
            ProcessData::Drive(drive) => drive.wants_to_send(),
        }
    }

    /// Data it is to be sent now, each with the number of its object; the caller sends them.
    pub fn give(&mut self, mut send: impl FnMut(u8, Payload)) {
        match self {
            ProcessData::Io(bits, channels) => {
                bits.sent = Some(bits.wanted);
                bits.give(bits.wanted, &mut send);
                channels.give(&mut send);
            }
            ProcessData::Drive(drive) => send(1, drive.give()),
        }
    }

    /// Data by which it lets go of everything, whatever its state. For bits that is zero. For a drive it is a stop: all
    /// zeros would cut its power while it moves.
    pub fn rest(&self, mut send: impl FnMut(u8, Payload)) {
        match self {
            ProcessData::Io(bits, channels) => {
                bits.give(0, &mut send);
                channels.rest(&mut send);
            }
            ProcessData::Drive(drive) => send(1, drive.rest()),
        }
    }

    /// It was lost, or is about to be configured: from here on its outputs are taken to be off.
    pub fn lost(&mut self, now: Tick) {
        match self {
            ProcessData::Io(bits, channels) => {
                bits.sent = None;
                channels.lost();
            }
            ProcessData::Drive(drive) => drive.lost(now),
        }
    }

    pub fn emergency(&mut self, now: Tick, code: u16) {
        if let ProcessData::Drive(drive) = self {
            drive.emergency(now, code);
        }
    }

    pub fn poll(&mut self, now: Tick) {
        if let ProcessData::Drive(drive) = self {
            drive.poll(now);
        }
    }

    /// When time alone changes something: data to send, or whether inputs can be trusted.
    pub fn deadline(&self) -> Tick {
        match self {
            ProcessData::Io(_, channels) => channels.deadline(),
            ProcessData::Drive(drive) => drive.next_deadline().unwrap_or(Tick::NEVER),
        }
    }

    /// An object it needs written before it can go on.
    pub fn wants_write(&self) -> Option<SdoWrite> {
        match self {
            ProcessData::Io(..) => None,
            ProcessData::Drive(drive) => drive.wants_write(),
        }
    }

    pub fn written(&mut self, now: Tick, setting: &SdoWrite, answer: Result<(), Abort>) {
        if let ProcessData::Drive(drive) = self {
            drive.written(now, setting, answer);
        }
    }

    /// Description of its state while it runs.
    pub fn explain(&self) -> Option<String> {
        match self {
            ProcessData::Io(_, channels) => channels.explain(),
            ProcessData::Drive(drive) => Some(drive.explain()),
        }
    }
}

impl BitImage {
    fn give(&self, bits: u64, send: &mut impl FnMut(u8, Payload)) {
        if !self.outputs.is_empty() {
            send(1, Payload::from_bits(bits, self.outputs.len()));
        }
    }
}
