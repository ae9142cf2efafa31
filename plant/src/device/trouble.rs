//! Injected faults of a simulated device on the bus, beyond those of its mechanism: their state, and their commands by
//! SDO.
//!
//! Several troubles may hold at once; each is cleared by itself, or all with 5F00h:00 = 0.

use linewright_canopen::codec::Abort;
use linewright_canopen::sdo::ObjectId;
use linewright_line::Tick;

use super::bytes::number;
use crate::fault::DeviceFault;
use crate::wire::FrameFaults;

/// Faults of a device now.
#[derive(Debug, Default)]
pub(super) struct InjectedFaults {
    /// Unplugged.
    pub silent: bool,
    /// It does not come up.
    pub dead: bool,
    /// Its heartbeats alone cease.
    pub no_heartbeat: bool,
    /// It is off the bus until then.
    pub off_until: Option<Tick>,
    /// An error of its own: code and bits of the error register.
    pub error: Option<(u16, u8)>,
    /// Since when there is an emergency to be sent.
    pub unsaid: Option<Tick>,
    identity: Option<(ObjectId, u32)>,
    refusal: Option<RefusedWrite>,
    /// Value that the next write to its companion makes effective.
    value: u32,
    code: u32,
    frames: FrameFaults,
}

#[derive(Clone, Copy, Debug)]
struct RefusedWrite {
    object: ObjectId,
    code: Abort,
    reading: bool,
    writing: bool,
}

impl InjectedFaults {
    /// It neither sends nor receives.
    pub fn is_mute(&self) -> bool {
        self.silent || self.dead || self.off_until.is_some()
    }

    /// Number of faults that hold: its own on the bus, and those of its line.
    pub fn count(&self) -> u16 {
        let FrameFaults { lost_to, lost_from, doubled, seed: _ } = self.frames;
        let own = [
            self.silent,
            self.dead,
            self.no_heartbeat,
            self.off_until.is_some(),
            self.error.is_some(),
            self.identity.is_some(),
            self.refusal.is_some(),
            lost_to + lost_from + doubled > 0,
        ];
        own.into_iter().map(u16::from).sum()
    }

    /// Its own bits of the error register.
    pub fn register(&self) -> u8 {
        self.error.map_or(0, |(_, register)| register)
    }

    /// Injected result of reading an object, instead of its value.
    pub fn read(&self, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        if let Some(refusal) = self.refusal.filter(|refusal| refusal.object == object && refusal.reading) {
            return Some(Err(refusal.code));
        }
        let (_, value) = self.identity.filter(|(other, _)| *other == object)?;
        Some(Ok(value.to_le_bytes().into()))
    }

    /// Why an object is not written.
    pub fn refuses(&self, object: ObjectId) -> Option<Abort> {
        self.refusal.filter(|refusal| refusal.object == object && refusal.writing).map(|refusal| refusal.code)
    }

    /// Begins to answer something else.
    pub fn answer_falsely(&mut self, (index, sub): (u16, u8), value: u32) {
        self.identity = Some((ObjectId::new(index, sub), value));
    }

    /// Begins to refuse an object.
    pub fn refuse(&mut self, (index, sub): (u16, u8), code: u32, reading: bool, writing: bool) {
        let object = ObjectId::new(index, sub);
        self.refusal = Some(RefusedWrite { object, code: Abort(code), reading, writing });
    }

    /// Object 5F02h is written.
    pub fn write(&mut self, now: Tick, sub: u8, data: &[u8]) -> Result<TroubleEffect, Abort> {
        let value = number(data)?;
        let object = ((value >> 8) as u16, value as u8);
        let per_mille = || u16::try_from(value).ok().filter(|share| *share <= 1000).ok_or(Abort::VALUE);
        match sub {
            1 if value == 0 => {
                self.unsaid = self.error.take().map(|_| now);
            }
            1 => {
                let fault = DeviceFault::Emergency { code: value as u16, register: (value >> 16) as u8 };
                return Ok(TroubleEffect::Inject(fault));
            }
            2 => return Ok(TroubleEffect::Inject(DeviceFault::BusOff { millis: value })),
            3 => self.value = value,
            4 if value == 0 => self.identity = None,
            4 => self.answer_falsely(object, self.value),
            5 => self.code = value,
            6 if value == 0 => self.refusal = None,
            6 => {
                let (reading, writing) = (value >> 24 & 1 == 1, value >> 25 & 1 == 1);
                self.refuse(object, self.code, reading, writing);
            }
            7 => self.frames.lost_to = per_mille()?,
            8 => self.frames.lost_from = per_mille()?,
            9 => self.frames.doubled = per_mille()?,
            10 => self.frames.seed = value.into(),
            _ => return Err(Abort::NO_SUBINDEX),
        }
        Ok(if let 7..=10 = sub { TroubleEffect::Disturb(self.frames) } else { TroubleEffect::None })
    }
}

/// Effect of writing object 5F02h beyond the state kept here.
pub(super) enum TroubleEffect {
    None,
    Inject(DeviceFault),
    Disturb(FrameFaults),
}
