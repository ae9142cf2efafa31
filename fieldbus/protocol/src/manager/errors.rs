//! A device's own errors as it reports them, and how long each counts as standing.
//!
//! An emergency (CiA 301 §7.2.7) carries an error code and the error register, object 1001h. The error stands until the
//! device reports that it is gone: by an emergency 0000h with a register of zero, by a register that reads zero, or by
//! booting. That frame comes once and may be lost, so the register is read once a second while an error stands, and at
//! the end of every boot: a device may come up with an error that was not reported.
//!
//! # Which emergencies count
//!
//! Everything that sets the error register, with one exception. Codes 81xxh are about the wire: frames overrun, error
//! passive, recovered from bus-off. What went missing on the wire is made good by the next frame, and longer gaps are
//! noticed by heartbeats, on both sides; an error register that names communication alone means the same. Two of them
//! are more than a warning: 8130h and 8140h mean that the device has let go of its outputs by itself (handled in
//! `peer.rs`), and 8150h that another node uses its identifiers, so frames under them may not be its own.
//!
//! 82xxh does count: the device has not taken the outputs it was sent. So do codes of current, voltage, temperature,
//! hardware, software and everything outside of it, and those of the manufacturer: inputs may be read wrongly, outputs
//! may be off that were switched on, and the manager cannot verify either.

use std::time::Duration;

use linewright_line::{Reaction, Tick};

use super::transfer::Transfer;
use crate::codec::{Emergency, NodeId, Profile, error_register_text};
use crate::frame::Frame;
use crate::sdo::wire::SdoBytes;
use crate::sdo::{ObjectId, TransferProgress};

pub(super) const ERROR_REGISTER: ObjectId = ObjectId::new(0x1001, 0);
/// Period of reading it while an error stands.
const READ_EVERY: Duration = Duration::from_secs(1);
/// Generic and communication error: bits 0 and 4.
const WIRE: u8 = 0x11;
/// Communication error: bit 4.
const COMMUNICATION: u8 = 0x10;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ActiveError {
    /// Emergency that reported it; `None` if only the register shows it.
    emergency: Option<Emergency>,
    register: u8,
}

#[derive(Debug)]
pub(super) struct Errors {
    reaction: Reaction,
    standing: Option<ActiveError>,
    reading: Option<Transfer>,
    /// A reading is due, and the channel was not free.
    waits: bool,
    next_read: Tick,
}

impl Errors {
    pub fn new(reaction: Reaction) -> Self {
        Errors { reaction, standing: None, reading: None, waits: false, next_read: Tick::NEVER }
    }

    /// An error stands because of which the device is not to be trusted.
    pub fn stand(&self) -> bool {
        self.standing.is_some() && self.reaction == Reaction::Fault
    }

    pub fn take(&mut self, now: Tick, emergency: Emergency) {
        let Emergency { code, register, .. } = emergency;
        if register == 0 {
            // A code without a bit in the register is an event that has passed, or one that is reported as gone.
            return self.gone();
        }
        let counts = register & !WIRE != 0 || !emergency.is_reset() && !is_of_the_wire(code);
        if self.only_the_wire_is_left(register) && !counts {
            self.gone();
        } else if let Some(standing) = &mut self.standing {
            standing.register = register;
            if counts && !emergency.is_reset() {
                standing.emergency = Some(emergency);
            }
        } else if counts {
            let emergency = Some(emergency).filter(|emergency| !emergency.is_reset());
            self.standing = Some(ActiveError { emergency, register });
            self.next_read = now + READ_EVERY;
        }
    }

    /// The register has been read. Whether that is news.
    pub fn register(&mut self, now: Tick, register: u8) -> bool {
        let before = self.standing;
        let ends = register == 0 || self.only_the_wire_is_left(register);
        match &mut self.standing {
            _ if ends => self.gone(),
            Some(standing) => standing.register = register,
            None if is_the_wire_alone(register) => {}
            None => {
                self.standing = Some(ActiveError { emergency: None, register });
                self.next_read = now + READ_EVERY;
            }
        }
        before.is_some() != self.standing.is_some()
    }

    /// It has booted, and begins without.
    pub fn gone(&mut self) {
        self.standing = None;
        self.waits = false;
        self.next_read = Tick::NEVER;
    }

    /// The cause of the standing error is gone from the register, and the bits set instead would not have made it
    /// stand.
    fn only_the_wire_is_left(&self, register: u8) -> bool {
        let others = |standing: ActiveError| {
            standing.register & !WIRE != 0 && standing.emergency.is_none_or(|emergency| emergency.code >> 8 != 0x81)
        };
        self.standing.is_some_and(others) && is_the_wire_alone(register)
    }

    /// It no longer exchanges anything: a pending read will not be answered.
    pub fn lost(&mut self) {
        self.reading = None;
        self.waits = false;
    }

    /// Its register is being read: the device has one channel for that.
    pub fn is_reading(&self) -> bool {
        self.reading.is_some()
    }

    /// It is, or is to be as soon as the channel is free.
    pub fn want_channel(&self) -> bool {
        self.reading.is_some() || self.waits
    }

    /// Does what is due: reads the register, if the channel is `free`. Gives the register if it has just been read.
    pub fn poll(&mut self, now: Tick, node: NodeId, free: bool, out: &mut Vec<Frame>) -> Option<u8> {
        if let Some(transfer) = &mut self.reading {
            let progress = transfer.poll(now, out);
            return self.done(progress);
        }
        if self.next_read <= now {
            self.next_read = now + READ_EVERY;
            self.waits = true;
        }
        if free {
            self.ask(now, node, out);
        }
        None
    }

    /// The channel is free: reads the register, if that has waited.
    pub fn ask(&mut self, now: Tick, node: NodeId, out: &mut Vec<Frame>) {
        if std::mem::take(&mut self.waits) {
            self.reading = Some(Transfer::read(now, node, ERROR_REGISTER, out));
        }
    }

    /// Takes eight bytes of its server. Gives the register if it has just been read.
    pub fn answer(&mut self, now: Tick, raw: &SdoBytes, out: &mut Vec<Frame>) -> Option<u8> {
        let progress = self.reading.as_mut()?.handle(now, raw, out);
        self.done(progress)
    }

    fn done(&mut self, progress: TransferProgress) -> Option<u8> {
        let TransferProgress::Done(result) = progress else { return None };
        self.reading = None;
        // A device whose register cannot be read stays in error until it reports otherwise by itself.
        result.ok()?.first().copied()
    }

    pub fn deadline(&self) -> Tick {
        let reading = self.reading.as_ref().map_or(Tick::NEVER, Transfer::deadline);
        reading.min(self.next_read)
    }

    /// The error that stands, in words, whatever it leads to.
    pub fn explain(&self, profile: Profile) -> Option<String> {
        let ActiveError { emergency, register } = self.standing?;
        Some(match emergency {
            Some(emergency) => {
                let meaning = emergency.meaning(profile).unwrap_or("unknown error");
                format!("emergency {:04X}h ({meaning}), error register 1001h = {register:02X}h", emergency.code)
            }
            None => format!("its error register 1001h = {register:02X}h ({})", error_register_text(register)),
        })
    }
}

/// Whether a code is about the wire alone.
fn is_of_the_wire(code: u16) -> bool {
    /// Another node uses its identifier.
    const COLLISION: u16 = 0x8150;
    code >> 8 == 0x81 && code != COLLISION
}

/// Whether a register names communication and nothing else.
fn is_the_wire_alone(register: u8) -> bool {
    register & !WIRE == 0 && register & COMMUNICATION != 0
}
