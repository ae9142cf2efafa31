//! Analogue channels of a simulated I/O device (CiA 401), and the process behind the measured ones.
//!
//! A measured value follows a cause with a delay of first order, where the description names it; elsewhere it is such
//! that the inputs made of it are what the mechanisms' switches would be. It can be held at any number by SDO (5F04h):
//! a broken wire, a sensor that sticks. Outputs without a manager go to their error value (6443h, 6444h), also where a
//! manager sends the device to pre-operational: zero is no rest for a valve that needs 4 mA.
//!
//! Time is exact: a value is what the exponential has come to, not a sum of steps.

use std::time::Duration;

use linewright_canopen::codec::{Abort, NodeId, Payload};
use linewright_canopen::sdo::ObjectId;
use linewright_line::{Analogue, AnalogueInput, AnalogueOutput, Follows, Tick, When};

use super::bytes::{exactly, number};
use super::pdo::Pdo;
use crate::fault::HOLD_INDEX;

/// Period of checks of a value on its way.
const GRAIN: Duration = Duration::from_millis(5);
/// Process data objects with channels: the second to the fourth.
const OBJECTS: u8 = 3;

#[derive(Debug)]
struct Measured {
    of: AnalogueInput,
    /// Earlier value, its time, and the final value.
    from: f64,
    at: Tick,
    to: f64,
    /// The number it is held at.
    held: Option<i16>,
    number: i16,
    /// The number last sent.
    sent: Option<i16>,
    /// Object 6426h: a smaller change is none.
    delta: u32,
}

#[derive(Debug)]
struct SetChannel {
    of: AnalogueOutput,
    number: i16,
    /// Object 6443h: whether it takes its error value.
    takes: u8,
    /// Object 6444h.
    error: i32,
}

#[derive(Debug)]
pub(super) struct SimulatedChannels {
    node: NodeId,
    measured: Vec<Measured>,
    set: Vec<SetChannel>,
    /// Object 6423h: whether inputs are sent by themselves.
    enabled: bool,
    transmit: Vec<Pdo>,
    receive: Vec<Pdo>,
    /// For each of the first, when it is sent although nothing changes.
    due: Vec<Tick>,
    /// When values that are on their way are looked at again.
    next_look: Tick,
}

impl SimulatedChannels {
    pub fn new(node: NodeId, of: &Analogue) -> Self {
        let highest = |numbers: &mut dyn Iterator<Item = u8>| numbers.max().unwrap_or(0);
        let inputs = highest(&mut of.inputs.iter().map(|input| input.channel.number));
        let outputs = highest(&mut of.outputs.iter().map(|output| output.channel.number));
        let measured = of.inputs.iter().map(|of| {
            let from = match &of.simulated {
                Some(lag) => match lag.follows {
                    Follows::Output { off, .. } => off,
                    Follows::Channel(_) => 0.0,
                },
                None => 0.0,
            };
            let number = of.channel.number_of(from).unwrap_or(0);
            let (at, to, held, sent) = (Tick::ZERO, from, None, None);
            Measured { of: of.clone(), from, at, to, held, number, sent, delta: 0 }
        });
        SimulatedChannels {
            node,
            measured: measured.collect(),
            set: of.outputs.iter().map(|of| SetChannel { of: of.clone(), number: 0, takes: 1, error: 0 }).collect(),
            enabled: false,
            transmit: (0..OBJECTS).map(|nth| Pdo::of_channels(node, true, nth, inputs)).collect(),
            receive: (0..OBJECTS).map(|nth| Pdo::of_channels(node, false, nth, outputs)).collect(),
            due: vec![Tick::NEVER; OBJECTS.into()],
            next_look: Tick::NEVER,
        }
    }

    /// Bits of the device type (1000h): analogue inputs and outputs.
    pub fn device_type(&self) -> u32 {
        u32::from(!self.measured.is_empty()) << 18 | u32::from(!self.set.is_empty()) << 19
    }

    /// Whether anything is measured.
    pub fn measures(&self) -> bool {
        !self.measured.is_empty()
    }

    /// Outputs of its owner that are on: those whose value a channel has.
    pub fn outputs(&self) -> u128 {
        let on = |set: &SetChannel| {
            let level = |value: &f64| set.of.channel.number_of(*value) == Some(set.number);
            let found = set.of.outputs.iter().find(|(_, value)| level(value));
            found.map_or(0, |(output, _)| output.bit())
        };
        self.set.iter().fold(0, |bits, set| bits | on(set))
    }

    /// The number an output is at.
    pub fn output(&self, channel: u8) -> Option<i16> {
        self.set.iter().find(|set| set.of.channel.number == channel).map(|set| set.number)
    }

    /// The plant has changed: what the owner's inputs would be, and which of its outputs are on.
    pub fn behind(&mut self, now: Tick, inputs: u128, outputs: u128) {
        for at in 0..self.measured.len() {
            let to = match self.measured[at].of.simulated.as_ref().map(|lag| lag.follows) {
                Some(Follows::Output { output, on, off }) => {
                    if outputs & output.bit() == 0 {
                        off
                    } else {
                        on
                    }
                }
                Some(Follows::Channel(channel)) => {
                    let set = self.set.iter().find(|set| set.of.channel.number == channel);
                    set.map_or(0.0, |set| set.of.channel.value_of(set.number))
                }
                None => {
                    self.measured[at].number = fitting(&self.measured[at].of, inputs);
                    continue;
                }
            };
            self.measured[at].go(now, to);
        }
    }

    /// Takes an object, 2 to 4; false if it is too short.
    pub fn take(&mut self, object: u8, payload: Payload) -> bool {
        let Some(pdo) = self.receive.get(usize::from(object.wrapping_sub(2))).filter(|pdo| pdo.is_active()) else {
            return true;
        };
        if payload.bytes().len() < pdo.len() {
            return false;
        }
        let data = payload.bits().to_le_bytes();
        for set in self.set.iter_mut().filter(|set| set.of.channel.pdo() == object) {
            set.number = set.of.channel.field().get(&data) as u16 as i16;
        }
        true
    }

    /// The manager is gone, or the device is not operational any more: outputs take their error values.
    pub fn let_go(&mut self) {
        for set in self.set.iter_mut().filter(|set| set.takes == 1) {
            set.number = i16::try_from(set.error).unwrap_or(if set.error < 0 { i16::MIN } else { i16::MAX });
        }
    }

    /// The device is not operational any more, and sends nothing.
    pub fn rest(&mut self) {
        self.due.fill(Tick::NEVER);
    }

    pub fn forget(&mut self) {
        let of = Analogue {
            inputs: self.measured.iter().map(|own| own.of.clone()).collect(),
            outputs: self.set.iter().map(|own| own.of.clone()).collect(),
        };
        let fresh = SimulatedChannels::new(self.node, &of);
        let before = std::mem::replace(&mut self.measured, fresh.measured);
        for (own, before) in self.measured.iter_mut().zip(before) {
            // The process behind a channel does not boot with it.
            *own = Measured { delta: 0, sent: None, ..before };
        }
        (self.set, self.transmit, self.receive, self.enabled) = (fresh.set, fresh.transmit, fresh.receive, false);
        self.due.fill(Tick::NEVER);
    }

    /// Lets go of every channel that is held.
    pub fn release(&mut self) {
        for own in &mut self.measured {
            own.held = None;
        }
    }

    /// It has just been started: what the channels are is news.
    pub fn started(&mut self) {
        for own in &mut self.measured {
            own.sent = None;
        }
    }

    /// Measures at `now`, and sends channels that have changed or are due. `sends`: whether the device sends process
    /// data at all.
    pub fn poll(&mut self, now: Tick, sends: bool, mut send: impl FnMut(u8, Payload)) {
        if self.measured.is_empty() {
            return;
        }
        for own in &mut self.measured {
            own.look(now);
        }
        let moving = self.measured.iter().any(|own| own.held.is_none() && own.is_moving());
        self.next_look = if moving { now + GRAIN } else { Tick::NEVER };
        if !sends {
            return;
        }
        for (nth, pdo) in self.transmit.iter().enumerate() {
            let object = nth as u8 + 2;
            let is_mine = |own: &Measured| own.of.channel.pdo() == object;
            let changed = self.measured.iter().any(|own| is_mine(own) && own.has_changed());
            if !self.enabled || !pdo.is_active() {
                self.due[nth] = Tick::NEVER;
                continue;
            }
            if !(changed || self.due[nth] <= now) {
                continue;
            }
            let mut data = [0; 8];
            for own in self.measured.iter_mut().filter(|own| is_mine(own)) {
                own.of.channel.field().put(&mut data, u64::from(own.number as u16));
                own.sent = Some(own.number);
            }
            send(object, Payload::from_bits(u64::from_le_bytes(data), pdo.len() * 8));
            self.due[nth] = pdo.event_timer().map_or(Tick::NEVER, |every| now + every);
        }
    }

    pub fn deadline(&self) -> Tick {
        self.due.iter().copied().fold(self.next_look, Tick::min)
    }

    /// The bytes of an object; `None` for any other.
    pub fn read(&self, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        let pdo = self.transmit.iter().chain(&self.receive).find_map(|pdo| pdo.read(object));
        if pdo.is_some() {
            return pdo;
        }
        let (inputs, outputs) = (!self.measured.is_empty(), !self.set.is_empty());
        let highest = match object.index {
            0x6401 | 0x6426 if inputs => self.measured.iter().map(|own| own.of.channel.number).max(),
            0x6411 | 0x6443 | 0x6444 if outputs => self.set.iter().map(|own| own.of.channel.number).max(),
            0x6423 if inputs => {
                return Some(if object.sub == 0 { Ok(vec![self.enabled.into()]) } else { Err(Abort::NO_SUBINDEX) });
            }
            _ => return None,
        }?;
        if object.sub == 0 {
            return Some(Ok(vec![highest]));
        }
        if object.sub > highest {
            return Some(Err(Abort::NO_SUBINDEX));
        }
        let measured = self.measured.iter().find(|own| own.of.channel.number == object.sub);
        let set = self.set.iter().find(|own| own.of.channel.number == object.sub);
        // A channel that does not exist is 0.
        Some(Ok(match object.index {
            0x6401 => measured.map_or(0, |own| own.number).to_le_bytes().into(),
            0x6426 => measured.map_or(0, |own| own.delta).to_le_bytes().into(),
            0x6411 => set.map_or(0, |own| own.number).to_le_bytes().into(),
            0x6443 => vec![set.map_or(1, |own| own.takes)],
            _ => set.map_or(0, |own| own.error).to_le_bytes().into(),
        }))
    }

    /// Gives an object these bytes; `None` for what cannot be written here.
    pub fn write(&mut self, object: ObjectId, data: &[u8]) -> Option<Result<(), Abort>> {
        if matches!(object.index, 0x1801..=0x1803 | 0x6423) {
            // Whatever may be sent from now on is news.
            self.started();
        }
        let pdo = self.transmit.iter_mut().chain(&mut self.receive).find_map(|pdo| pdo.write(object, data));
        if pdo.is_some() {
            return pdo;
        }
        let set = self.set.iter_mut().find(|own| own.of.channel.number == object.sub);
        let measured = self.measured.iter_mut().find(|own| own.of.channel.number == object.sub);
        Some(match (object.index, set, measured) {
            (0x6423, ..) if object.sub == 0 => exactly(data).and_then(|[value]| match value {
                0 | 1 => {
                    self.enabled = value == 1;
                    Ok(())
                }
                _ => Err(Abort::VALUE),
            }),
            (0x6443, Some(own), _) => exactly(data).and_then(|[mode]| match mode {
                0 | 1 => {
                    own.takes = mode;
                    Ok(())
                }
                _ => Err(Abort::VALUE),
            }),
            (0x6444, Some(own), _) => exactly(data).map(|bytes| own.error = i32::from_le_bytes(bytes)),
            (0x6426, _, Some(own)) => exactly(data).map(|bytes| own.delta = u32::from_le_bytes(bytes)),
            (HOLD_INDEX, _, Some(own)) => {
                number(data).map(|value| own.held = u16::try_from(value).ok().map(|n| n as i16))
            }
            (HOLD_INDEX, ..) => Err(Abort::NO_SUBINDEX),
            _ => return None,
        })
    }
}

impl Measured {
    fn value(&self, now: Tick) -> f64 {
        let Some(lag) = &self.of.simulated else { return self.from };
        let passed = now.since(self.at).as_secs_f64() / lag.time_constant.as_secs_f64().max(1e-9);
        self.to + (self.from - self.to) * (-passed).exp()
    }

    /// It goes elsewhere from here on.
    fn go(&mut self, now: Tick, to: f64) {
        if self.to != to {
            (self.from, self.at, self.to) = (self.value(now), now, to);
        }
    }

    fn look(&mut self, now: Tick) {
        if let Some(held) = self.held {
            self.number = held;
        } else if self.of.simulated.is_some() {
            let value = self.value(now);
            let beyond =
                if (value - self.of.channel.offset) / self.of.channel.factor < 0.0 { i16::MIN } else { i16::MAX };
            self.number = self.of.channel.number_of(value).unwrap_or(beyond);
        }
    }

    /// Whether it is still on its way.
    fn is_moving(&self) -> bool {
        self.of.simulated.is_some() && self.of.channel.number_of(self.to).is_some_and(|to| to != self.number)
    }

    fn has_changed(&self) -> bool {
        self.sent.is_none_or(|sent| u32::from(sent.abs_diff(self.number)) > self.delta)
    }
}

/// A number that makes the inputs of a channel what they would be, whatever they are now; of those that do so the one
/// nearest to 0. Where none can, the one that is right for most of them.
fn fitting(of: &AnalogueInput, image: u128) -> i16 {
    let is_on = |input: linewright_line::InputId| image & input.bit() != 0;
    if of.broken.is_some_and(is_on) {
        return i16::MAX;
    }
    let edges = of.inputs.iter().flat_map(|(_, when)| match *when {
        When::Above { at, hysteresis } => [at, at - hysteresis],
        When::Below { at, hysteresis } => [at, at + hysteresis],
        _ => [0.0, 0.0],
    });
    let ends = [of.least, of.most].into_iter().flatten();
    let edges = edges.chain(ends).chain([0.0, of.channel.offset]).filter_map(|edge| of.channel.number_of(edge));
    let candidates = edges.flat_map(|edge| [edge, edge.saturating_sub(1), edge.saturating_add(1)]);
    let right = |number: i16| {
        let holds = |on| move |(input, when): &&(_, When)| of.holds(*when, number, on) == is_on(*input);
        of.inputs.iter().filter(holds(false)).filter(holds(true)).count()
    };
    let best = candidates.filter(|number| of.is_measured(*number));
    best.max_by_key(|number| (right(*number), std::cmp::Reverse(number.unsigned_abs()))).unwrap_or(0)
}
