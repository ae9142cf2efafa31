//! Injectable faults, and their numbers over CAN.

use std::collections::BTreeSet;

use linewright_canopen::codec::Abort;

/// Manufacturer object 5F00h of a simulated device. Subindex 0 is the whole device, subindex n output bit n − 1.
pub const FAULT_INDEX: u16 = 0x5F00;
/// Manufacturer object 5F01h of a simulated device: subindex n holds input bit n − 1 at a value, like a finger on a
/// button or a stuck switch. 0 off, 1 on, 2 lets go.
pub const PRESS_INDEX: u16 = 0x5F01;

/// Manufacturer object 5F02h of a simulated device: trouble on the bus, see `docs/can.md`.
pub const TROUBLE_INDEX: u16 = 0x5F02;
/// Manufacturer object 5F03h of a simulated device: subindex n holds output bit n − 1 at a value, whatever the process
/// data, like a relay whose contacts have welded or broken. 0 off, 1 on, 2 lets go.
pub const STUCK_INDEX: u16 = 0x5F03;

/// Manufacturer object 5F04h of a simulated device: subindex n holds analogue input n at a number, whatever the
/// measurement. 0 to FFFFh are its 16 bits, 10000h lets go.
pub const HOLD_INDEX: u16 = 0x5F04;

/// Manufacturer object 5F05h:00 of a simulated device: [`SIMULATED`], also while the device is silent. It distinguishes simulated
/// devices from real ones.
pub const SIMULATED_INDEX: u16 = 0x5F05;
/// What 5F05h:00 of a simulated device reads as: the characters `LWSD`.
pub const SIMULATED: u32 = u32::from_le_bytes(*b"LWSD");
/// Manufacturer object 5F06h:00 of a simulated device: the run or the line that it is part of, as text, also while the device is
/// silent. Lines on one bus and buses of one name are told apart by it.
pub const PART_OF_INDEX: u16 = 0x5F06;
/// Manufacturer object 5F07h:00 of a simulated device: number of injected faults that hold, also while the device is silent.
pub const FAULTS_INDEX: u16 = 0x5F07;

/// Manufacturer object 5F08h of a simulated I/O device: subindex n takes the part out of holder n − 1 of the line, by hand; the number is
/// its position there, from 1. Subindex 0 reads as the outcome of the last that was written here or to 5F09h: 0 done, else the number
/// of a [`PartRefusal`](crate::PartRefusal).
pub const TAKE_INDEX: u16 = 0x5F08;
/// Manufacturer object 5F09h of a simulated I/O device: the same, puts a part in.
pub const PUT_INDEX: u16 = 0x5F09;

/// Fault of one motion. Lasts until it is cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionFault {
    /// It does not move.
    Stick = 1,
    /// It moves at a quarter of its speed.
    Slip = 2,
    /// It does not move, and its fault sensor, where it has one, is on.
    Break = 3,
    /// It moves the wrong way, at a quarter of its speed, as far as where it came from.
    SlipBack = 4,
    /// It moves, but the gripper that it closes takes nothing.
    Miss = 5,
    /// It moves, but the gripper that it has closed holds nothing fast: a part that is in no nest falls.
    Drop = 6,
}

/// What goes wrong with an input: a switch, a sensor, a contact of the console. Lasts until it is cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InputFault {
    /// It stays on.
    StuckOn,
    /// It stays off.
    StuckOff,
}

impl InputFault {
    pub const ALL: [InputFault; 2] = [InputFault::StuckOn, InputFault::StuckOff];

    /// The value it is held at.
    pub const fn value(self) -> bool {
        matches!(self, InputFault::StuckOn)
    }

    /// What is written to a device to hold its input bit so, or to let it go (`None`).
    pub fn orders(bit: u8, fault: Option<InputFault>) -> ObjectWrites {
        vec![((PRESS_INDEX, bit + 1), fault.map_or(2, |fault| u32::from(fault.value())))]
    }
}

/// A write to a simulated device: index and subindex of the object, and the value.
pub type FaultWrite = ((u16, u8), u32);

/// Objects of a device that hold a motion, an input, an output or a number at a fault, by what was written to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeldFaults(BTreeSet<(u16, u8)>);

impl HeldFaults {
    /// Notes a number written to an object; other objects than those of faults hold nothing.
    pub fn note(&mut self, (object, value): FaultWrite) {
        let is_held = match object {
            // Subindex 0 is the whole device, whose faults are states of it.
            (FAULT_INDEX, 1..) => value != 0,
            (PRESS_INDEX | STUCK_INDEX, _) => value < 2,
            (HOLD_INDEX, _) => value <= 0xFFFF,
            _ => return,
        };
        if is_held {
            self.0.insert(object)
        } else {
            self.0.remove(&object)
        };
    }

    /// How many objects hold one.
    pub fn count(&self) -> u16 {
        u16::try_from(self.0.len()).unwrap_or(u16::MAX)
    }
}

/// Writes to a simulated device. The order matters.
pub type ObjectWrites = Vec<FaultWrite>;

/// Write that clears all faults of a device.
pub const CLEAR: FaultWrite = ((FAULT_INDEX, 0), 0);

impl MotionFault {
    /// Every fault, in the order of their numbers.
    pub const ALL: [MotionFault; 6] = [
        MotionFault::Stick,
        MotionFault::Slip,
        MotionFault::Break,
        MotionFault::SlipBack,
        MotionFault::Miss,
        MotionFault::Drop,
    ];

    /// Those that a motion of a drive can have: it moves by its own position, not along a mechanism of the plant.
    pub const OF_DRIVE: [MotionFault; 2] = [MotionFault::Stick, MotionFault::Break];

    /// The number it has in 5F00h.
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The fault a number stands for; 0 clears (`Ok(None)`).
    pub fn from_code(code: u32) -> Result<Option<Self>, Abort> {
        match MotionFault::ALL.into_iter().find(|fault| fault.code() == code) {
            None if code != 0 => Err(Abort::VALUE),
            fault => Ok(fault),
        }
    }
}

/// Fault of a whole device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceFault {
    /// 1: it neither sends nor receives, as if unplugged, except that object 5F00h:00 can plug it in again.
    Silent,
    /// 2: it boots.
    Reboot,
    /// 3: it boots and does not come up again: no boot-up message, no answer.
    NoBoot,
    /// 4: its heartbeats cease, and all else goes on.
    NoHeartbeat,
    /// 5F02h:04: an object reads as another value: a device type, an identity.
    Identity { object: (u16, u8), value: u32 },
    /// 5F02h:06: an object is refused.
    Abort {
        object: (u16, u8),
        /// With which abort code.
        code: u32,
        /// When it is read.
        reading: bool,
        /// When it is written.
        writing: bool,
    },
    /// 5F02h:01: it reports an error, which then stands in its error register, over boots too.
    Emergency {
        code: u16,
        /// Bits of the error register, object 1001h.
        register: u8,
    },
    /// 5F02h:02: it is off the bus for a time, and then reports it. It lets go of its outputs as if it had lost its
    /// manager.
    BusOff {
        /// Duration, in ms.
        millis: u32,
    },
}

/// In 5F02h:06: when the object is read, when it is written.
const READING: u32 = 1 << 24;
const WRITING: u32 = 1 << 25;

impl DeviceFault {
    /// Writes that cause this fault.
    pub fn orders(self) -> ObjectWrites {
        let whole = |code| vec![((FAULT_INDEX, 0), code)];
        let place = |(index, sub): (u16, u8)| u32::from(index) << 8 | u32::from(sub);
        let trouble = |sub, value| ((TROUBLE_INDEX, sub), value);
        match self {
            DeviceFault::Silent => whole(1),
            DeviceFault::Reboot => whole(2),
            DeviceFault::NoBoot => whole(3),
            DeviceFault::NoHeartbeat => whole(4),
            DeviceFault::Emergency { code, register } => {
                vec![trouble(1, u32::from(register) << 16 | u32::from(code))]
            }
            DeviceFault::BusOff { millis } => vec![trouble(2, millis)],
            DeviceFault::Identity { object, value } => vec![trouble(3, value), trouble(4, place(object))],
            DeviceFault::Abort { object, code, reading, writing } => {
                let when = if reading { READING } else { 0 } | if writing { WRITING } else { 0 };
                vec![trouble(5, code), trouble(6, place(object) | when)]
            }
        }
    }
}

impl DeviceFault {
    /// The fault a number in 5F00h:00 stands for; 0 clears (`Ok(None)`).
    pub fn from_code(code: u32) -> Result<Option<Self>, Abort> {
        match code {
            0 => Ok(None),
            1 => Ok(Some(DeviceFault::Silent)),
            2 => Ok(Some(DeviceFault::Reboot)),
            3 => Ok(Some(DeviceFault::NoBoot)),
            4 => Ok(Some(DeviceFault::NoHeartbeat)),
            _ => Err(Abort::VALUE),
        }
    }
}
