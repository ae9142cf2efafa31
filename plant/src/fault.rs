//! What can be made to go wrong, and by which number over CAN.

#[cfg(feature = "can")]
use linewright_fieldbus::codec::Abort;

/// Manufacturer object 5F00h of a simulated device. Subindex 0 is the whole device, subindex n output bit n − 1.
pub const FAULT_INDEX: u16 = 0x5F00;
/// Manufacturer object 5F01h of a simulated device: subindex n holds input bit n − 1 at a value, like a finger on a
/// button or a stuck switch. 0 off, 1 on, 2 lets go.
pub const PRESS_INDEX: u16 = 0x5F01;

/// What goes wrong with one motion. Lasts until it is cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// 1: it does not move.
    Stick,
    /// 2: it moves at a quarter of its speed.
    Slip,
    /// 3: it does not move, and its fault sensor, where it has one, is on.
    Break,
    /// 4: it moves the wrong way, at a quarter of its speed, as far as where it came from.
    SlipBack,
}

#[cfg(feature = "can")]
impl Fault {
    /// The fault a number stands for; 0 clears (`Ok(None)`).
    pub fn from_code(code: u32) -> Result<Option<Self>, Abort> {
        match code {
            0 => Ok(None),
            1 => Ok(Some(Fault::Stick)),
            2 => Ok(Some(Fault::Slip)),
            3 => Ok(Some(Fault::Break)),
            4 => Ok(Some(Fault::SlipBack)),
            _ => Err(Abort::VALUE),
        }
    }
}

/// What goes wrong with a whole device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceFault {
    /// 1: it neither sends nor hears, as if unplugged, except that object 5F00h:00 can plug it in again.
    Silent,
    /// 2: it boots.
    Reboot,
}

#[cfg(feature = "can")]
impl DeviceFault {
    /// The fault a number stands for; 0 clears (`Ok(None)`).
    pub fn from_code(code: u32) -> Result<Option<Self>, Abort> {
        match code {
            0 => Ok(None),
            1 => Ok(Some(DeviceFault::Silent)),
            2 => Ok(Some(DeviceFault::Reboot)),
            _ => Err(Abort::VALUE),
        }
    }
}
