//! Error behaviour of a device that has lost its manager: objects 1029h (CiA 301), 6206h and 6207h (CiA 401).

use linewright_canopen::codec::Abort;
use linewright_canopen::sdo::ObjectId;

use super::bytes::exactly;

/// State after a communication error (object 1029h sub 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Behaviour {
    /// 0: pre-operational, if it was operational.
    PreOperational,
    /// 1: as it is.
    NoChange,
    /// 2: stopped.
    Stopped,
}

#[derive(Debug)]
pub(super) struct OnError {
    pub(super) behaviour: Behaviour,
    /// Object 6206h: outputs whose bit is set take their error value, the others stay as they are.
    mode: u64,
    /// Object 6207h.
    value: u64,
    /// Outputs of the device, in bytes.
    bytes: usize,
}

impl OnError {
    /// As after a boot: every output goes off.
    pub(super) fn new(outputs: usize) -> Self {
        OnError { behaviour: Behaviour::PreOperational, mode: u64::MAX, value: 0, bytes: outputs.div_ceil(8) }
    }

    /// The outputs after an error that had these.
    pub(super) fn outputs(&self, outputs: u64) -> u64 {
        outputs & !self.mode | self.value & self.mode
    }

    /// The bytes of an object; `None` for any other.
    pub(super) fn read(&self, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        Some(match (object.index, object.sub) {
            (0x1029, 0) => Ok(vec![1]),
            (0x1029, 1) => Ok(vec![self.behaviour as u8]),
            (0x1029, _) => Err(Abort::NO_SUBINDEX),
            (0x6206 | 0x6207, _) if self.bytes == 0 => Err(Abort::NO_OBJECT),
            (0x6206 | 0x6207, 0) => Ok(vec![self.bytes as u8]),
            (0x6206, sub) => self.at(sub).map(|at| vec![self.mode.to_le_bytes()[at]]),
            (0x6207, sub) => self.at(sub).map(|at| vec![self.value.to_le_bytes()[at]]),
            _ => return None,
        })
    }

    /// Gives an object these bytes; `None` for what cannot be written here.
    pub(super) fn write(&mut self, object: ObjectId, data: &[u8]) -> Option<Result<(), Abort>> {
        match (object.index, object.sub) {
            (0x1029, 1) => Some(exactly(data).and_then(|[code]| {
                self.behaviour = match code {
                    0 => Behaviour::PreOperational,
                    1 => Behaviour::NoChange,
                    2 => Behaviour::Stopped,
                    _ => return Err(Abort::VALUE),
                };
                Ok(())
            })),
            (0x6206, 1..) if self.bytes > 0 => Some(self.at(object.sub).and_then(|at| put(&mut self.mode, at, data))),
            (0x6207, 1..) if self.bytes > 0 => Some(self.at(object.sub).and_then(|at| put(&mut self.value, at, data))),
            _ => None,
        }
    }

    /// Index of a subindex's byte.
    fn at(&self, sub: u8) -> Result<usize, Abort> {
        usize::from(sub).checked_sub(1).filter(|at| *at < self.bytes).ok_or(Abort::NO_SUBINDEX)
    }
}

fn put(bits: &mut u64, at: usize, data: &[u8]) -> Result<(), Abort> {
    let [byte] = exactly(data)?;
    let mut bytes = bits.to_le_bytes();
    bytes[at] = byte;
    *bits = u64::from_le_bytes(bytes);
    Ok(())
}
