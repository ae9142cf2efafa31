//! Analogue channels of an I/O device (CiA 401): numbers ↔ bits of its owner's image.
//!
//! A measured number turns inputs on and off by limits, each with its own memory for its hysteresis: what is on follows
//! from the numbers received since the device came up, in their order, and from nothing else. An output gives a channel
//! its value; none, or two at once, is rest.
//!
//! # Invalid measurements
//!
//! A number at the end of its range, or outside of what the description allows, comes from a broken wire or a converter
//! that has run out of its range. Nothing follows from it: "not above 5 bar" would be as wrong as "above 5 bar". If the
//! description names an input for it, that is on and the limits' are off, and the owner decides. Otherwise the owner's
//! inputs are invalid until the channel measures again, as if the device were lost. It does when its numbers have been
//! measurements for as long as they may stay away: a loose contact may flicker with every frame, and each change of the
//! owner's validity is published. The same holds for a value that stays away: digital inputs that do not come have not
//! changed, but the device is configured to send its channels cyclically, so one that does not is faulty, and its last
//! value means nothing.
//!
//! # Settings
//!
//! Permission to send by itself (6423h, by default it may not), on a change and ten times a second; which errors make
//! its outputs rest (6443h: each), and at what (6444h), both read back (`on_error.rs`). A device that refuses one of
//! these is not started. The size of such a change (6426h) may be given by the device's settings.

use std::time::Duration;

use linewright_line::{Analogue, AnalogueInput, AnalogueOutput, InputId, Tick, Timing};

use super::fault::{ChannelFault, IgnoreReason};
use crate::codec::{NodeId, Payload};
use crate::sdo::SdoWrite;

/// The first process data object with channels, and how many there are.
const FIRST: u8 = 2;
const OBJECTS: usize = 3;
/// Period at which the device sends its channels when nothing changes (event timer).
const EVERY: Duration = Duration::from_millis(100);
/// So many in a row may be missing.
const MISSING: u32 = 3;
/// Least time between two frames of the device, in 100 µs: a noisy input changes all the time.
const INHIBIT: u16 = 50;
/// Transmission type: when something changes, and by the event timer.
const EVENT_DRIVEN: u8 = 255;
/// In a COB-ID parameter: the object does not exist; it is not sent on remote request.
const INVALID: u32 = 1 << 31;
const NO_REMOTE: u32 = 1 << 30;

#[derive(Debug)]
struct ChannelInput {
    of: AnalogueInput,
    /// Its last number; `None` since the last boot or loss.
    number: Option<i16>,
    /// For each of its limits' inputs whether it is on, by its numbers since the last invalid one; kept for display
    /// after a loss.
    on: Vec<bool>,
    /// Why it counts as no measurement; `None` while it is one.
    broken: Option<BrokenChannel>,
}

#[derive(Clone, Copy, Debug)]
struct BrokenChannel {
    /// The last number that was no measurement.
    number: i16,
    /// When it is one again, if its numbers stay so; `None` while the last was none.
    mended: Option<Tick>,
}

/// The channels of one device.
#[derive(Debug)]
pub(super) struct AnalogueChannels {
    inputs: Vec<ChannelInput>,
    outputs: Vec<AnalogueOutput>,
    /// Most time between inputs, and time for which they are measurements again before that counts.
    within: Duration,
    /// The image its owner set last.
    image: u128,
    /// The image it was last sent; `None` since the last boot or loss.
    sent: Option<u128>,
    /// For each object, when it last came since the last boot or loss.
    received: [Option<Tick>; OBJECTS],
    /// Whether all channels were received and measured at the last check.
    sound: bool,
}

impl AnalogueChannels {
    pub fn of(analogue: &Analogue, timing: &Timing) -> Self {
        let input = |of: &AnalogueInput| ChannelInput {
            of: of.clone(),
            number: None,
            on: vec![false; of.inputs.len()],
            broken: None,
        };
        AnalogueChannels {
            inputs: analogue.inputs.iter().map(input).collect(),
            outputs: analogue.outputs.clone(),
            within: (EVERY * MISSING).max(timing.heartbeat_timeout),
            image: 0,
            sent: None,
            received: [None; OBJECTS],
            sound: false,
        }
    }

    /// Whether the device has channels at all.
    pub fn is_any(&self) -> bool {
        !self.inputs.is_empty() || !self.outputs.is_empty()
    }

    pub fn has_outputs(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// Settings before the device is started. `own` are those its description already contains.
    pub fn settings(&self, node: NodeId, own: &[linewright_line::ObjectWrite]) -> Vec<SdoWrite> {
        let mut settings = Vec::new();
        for output in &self.outputs {
            let sub = output.channel.number;
            settings.push(SdoWrite::new(0x6443, sub, [1]));
            // An INTEGER32 in CiA 401. For devices that have it in two bytes instead, the description has the setting.
            if !own.iter().any(|setting| (setting.index, setting.sub) == (0x6444, sub)) {
                settings.push(SdoWrite::new(0x6444, sub, i32::from(output.at_rest()).to_le_bytes()));
            }
        }
        for at in (0..OBJECTS as u16).filter(|at| self.last_input(FIRST + *at as u8).is_some()) {
            let (index, cob_id) = (0x1801 + at, NO_REMOTE | u32::from(0x280 + 0x100 * at) | u32::from(node.get()));
            settings.extend([
                SdoWrite::new(index, 1, (INVALID | cob_id).to_le_bytes()),
                SdoWrite::new(index, 2, [EVENT_DRIVEN]),
                SdoWrite { optional: true, ..SdoWrite::new(index, 3, INHIBIT.to_le_bytes()) },
                SdoWrite::new(index, 5, (EVERY.as_millis() as u16).to_le_bytes()),
                SdoWrite::new(index, 1, cob_id.to_le_bytes()),
            ]);
        }
        if !self.inputs.is_empty() {
            settings.push(SdoWrite::new(0x6423, 0, [1]));
        }
        settings
    }

    /// Takes a process data object, 2 to 4, that the device has sent.
    pub fn take(&mut self, now: Tick, object: u8, payload: Payload) -> Result<(), IgnoreReason> {
        // No input uses it, so nothing follows from it.
        let last = self.last_input(object).ok_or(IgnoreReason::UnknownCobId)?;
        if payload.bytes().len() < usize::from((last - 1) % 4 + 1) * 2 {
            return Err(IgnoreReason::ShortPdo);
        }
        if let Some(received) = self.received.get_mut(usize::from(object - FIRST)) {
            *received = Some(now);
        }
        let data = payload.bits().to_le_bytes();
        for input in self.inputs.iter_mut().filter(|input| input.of.channel.pdo() == object) {
            input.take(now, input.of.channel.field().get(&data) as u16 as i16, self.within);
        }
        Ok(())
    }

    /// Its bits of its owner's input image.
    pub fn bits(&self) -> u128 {
        let on = |input: &ChannelInput| {
            if input.broken.is_some() {
                return input.of.broken.map_or(0, InputId::bit);
            }
            let limits = input.of.inputs.iter().zip(&input.on).filter(|(_, on)| **on);
            limits.fold(0, |bits, ((id, _), _)| bits | id.bit())
        };
        self.inputs.iter().fold(0, |bits, input| bits | on(input))
    }

    /// Why its owner's inputs cannot be valid, if they cannot.
    pub fn fault(&self, now: Tick) -> Option<ChannelFault> {
        let late = |input: &&ChannelInput| {
            let received = self.received.get(usize::from(input.of.channel.pdo() - FIRST)).copied().flatten();
            received.is_none_or(|received| received + self.within <= now)
        };
        if let Some(input) = self.inputs.iter().find(late) {
            return Some(ChannelFault::Late { object: input.of.channel.pdo() });
        }
        self.inputs.iter().filter(|input| input.of.broken.is_none()).find_map(|input| {
            let number = input.broken?.number;
            Some(ChannelFault::Number { channel: input.of.channel.number, number })
        })
    }

    /// Lets time pass: channels that have measured for long enough are measured again. Whether there are any.
    pub fn mend(&mut self, now: Tick) -> bool {
        let mut any = false;
        for input in &mut self.inputs {
            if input.mended_at().is_some_and(|at| at <= now) {
                input.broken = None;
                any = true;
            }
        }
        any
    }

    /// Checks again whether all channels are received and measured; the result, if it has changed.
    pub fn news(&mut self, now: Tick) -> Option<Result<(), ChannelFault>> {
        let now_is = self.fault(now).map_or(Ok(()), Err);
        (std::mem::replace(&mut self.sound, now_is.is_ok()) != now_is.is_ok()).then_some(now_is)
    }

    /// When an object is late, or a channel measured again.
    pub fn deadline(&self) -> Tick {
        let used = self.received.iter().flatten().filter(|_| self.sound);
        let late = used.map(|received| *received + self.within);
        late.chain(self.inputs.iter().filter_map(ChannelInput::mended_at)).fold(Tick::NEVER, Tick::min)
    }

    /// Takes the image its owner has set, or the one without outputs after a loss.
    pub fn set_image(&mut self, image: u128) {
        self.image = image;
    }

    /// Whether it is to be sent something else than it has.
    pub fn wants_to_send(&self) -> bool {
        let differs = |sent| self.outputs.iter().any(|output| output.number(sent) != output.number(self.image));
        self.sent.is_some_and(differs)
    }

    /// Frames it is to be sent now; the caller sends them.
    pub fn give(&mut self, send: &mut impl FnMut(u8, Payload)) {
        self.sent = Some(self.image);
        self.payloads(self.image, send);
    }

    /// Frames that bring it to rest.
    pub fn rest(&self, send: &mut impl FnMut(u8, Payload)) {
        self.payloads(0, send);
    }

    fn payloads(&self, image: u128, send: &mut impl FnMut(u8, Payload)) {
        for object in FIRST..FIRST + OBJECTS as u8 {
            let mine = || self.outputs.iter().filter(move |output| output.channel.pdo() == object);
            // The frame is as long as its last channel needs; a channel that is not described is 0.
            let Some(last) = mine().map(|output| output.channel.number).max() else { continue };
            let mut data = [0; 8];
            for output in mine() {
                output.channel.field().put(&mut data, u64::from(output.number(image) as u16));
            }
            send(object, Payload::from_bits(u64::from_le_bytes(data), usize::from((last - 1) % 4 + 1) * 16));
        }
    }

    /// It was lost, or is about to be configured.
    pub fn lost(&mut self) {
        self.sent = None;
        self.received = [None; OBJECTS];
        self.sound = false;
        for input in &mut self.inputs {
            input.number = None;
            if let Some(broken) = &mut input.broken {
                broken.mended = None;
            }
        }
    }

    /// When it last sent a channel.
    pub fn updated(&self) -> Option<Tick> {
        self.received.iter().flatten().max().copied()
    }

    /// Measured and set values, in words; `None` without channels.
    pub fn explain(&self) -> Option<String> {
        let measured = self.inputs.iter().map(|input| {
            let channel = &input.of.channel;
            match (input.number, input.broken) {
                (Some(_), Some(BrokenChannel { number, .. })) => {
                    format!("analogue input {}: no measurement ({number})", channel.number)
                }
                (Some(number), None) => {
                    format!("analogue input {}: {}", channel.number, channel.text(channel.value_of(number)))
                }
                (None, _) => format!("analogue input {}: nothing yet", channel.number),
            }
        });
        let set = self.outputs.iter().map(|output| {
            let value = output.value(self.sent.unwrap_or(0));
            format!("analogue output {}: {}", output.channel.number, output.channel.text(value))
        });
        let all: Vec<String> = measured.chain(set).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }

    /// The highest channel that is read of an object.
    fn last_input(&self, object: u8) -> Option<u8> {
        let own = self.inputs.iter().map(|input| &input.of.channel).filter(|channel| channel.pdo() == object);
        own.map(|channel| channel.number).max()
    }
}

impl ChannelInput {
    /// Takes a number; one that was none counts as measured again after it has been so for `steady`.
    fn take(&mut self, now: Tick, number: i16, steady: Duration) {
        // The state before a loss, or before the wire broke, is no memory to go on with.
        let knew = self.number.is_some_and(|last| self.of.is_measured(last));
        let measured = self.of.is_measured(number);
        self.number = Some(number);
        self.broken = match self.broken {
            _ if !measured => Some(BrokenChannel { number, mended: None }),
            Some(BrokenChannel { mended: Some(at), .. }) if at <= now => None,
            Some(BrokenChannel { number, mended }) => {
                Some(BrokenChannel { number, mended: mended.or(Some(now + steady)) })
            }
            None => None,
        };
        for (at, on) in self.on.iter_mut().enumerate() {
            let (_, when) = self.of.inputs[at];
            *on = measured && self.of.holds(when, number, knew && *on);
        }
    }

    fn mended_at(&self) -> Option<Tick> {
        self.broken?.mended
    }
}
