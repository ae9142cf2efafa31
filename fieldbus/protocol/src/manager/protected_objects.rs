//! Objects of a device that external requests must not write.
//!
//! While a device is operational its owner moves machines by what the manager wrote into it and reads from it. A
//! changed meaning of a bit (a polarity, a mapping), an output that stays on without a manager (1016h, 6206h) or a
//! direct write to an output makes the image false, and no check of the line would notice. So everything is refused
//! that a standard gives a meaning for the process, and what the description sets; the rest of the manufacturer's own
//! objects may be written: parameters of a sensor, faults of a simulated device.
//!
//! That holds in every state of the device. One that was refused is looked at again and started without a reset, and
//! what the description does not set keeps what was written meanwhile: an output that goes on without a manager, say.

use crate::sdo::{ObjectId, SdoWrite};

/// Why an object is not written for others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteProtection {
    /// The description sets it.
    Described,
    /// Heartbeats and their consumers.
    Heartbeat,
    /// Mapping of the process data.
    Mapping,
    Communication,
    /// Outputs, targets, and the meaning of inputs.
    Process,
    /// No standard gives it a meaning that is known to be harmless.
    Unknown,
}

/// Why `object` is not written for others; `None` if it may be.
pub(super) fn guarded(object: ObjectId, settings: &[SdoWrite]) -> Option<WriteProtection> {
    match object.index {
        _ if settings.iter().any(|setting| setting.object == object) => Some(WriteProtection::Described),
        // 1003h:00 clears the list of past errors, 1010h stores parameters.
        0x1003 | 0x1010 => None,
        0x1016 | 0x1017 => Some(WriteProtection::Heartbeat),
        0x1400..0x1C00 => Some(WriteProtection::Mapping),
        0x1000..0x2000 => Some(WriteProtection::Communication),
        0x2000..0x6000 => None,
        0x6000..0xA000 => Some(WriteProtection::Process),
        _ => Some(WriteProtection::Unknown),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_process_rests_on_is_guarded_and_what_is_the_manufacturers_is_not() {
        let set = [SdoWrite::new(0x2001, 1, [7])];
        for guarded_one in [
            0x1005, 0x1014, 0x1016, 0x1017, 0x1029, 0x1200, 0x1400, 0x1600, 0x1800, 0x1A00, 0x1BFF, 0x1F51, 0x6000,
            0x6002, 0x6040, 0x607A, 0x6200, 0x6206, 0x6207, 0x60FF, 0x9FFF, 0xA000, 0xFFFF, 0x0001,
        ] {
            assert!(guarded(ObjectId::new(guarded_one, 1), &set).is_some(), "{guarded_one:04X}h");
        }
        assert!(guarded(ObjectId::new(0x2001, 1), &set).is_some());
        for free in [(0x2001, 2), (0x5F00, 1), (0x1003, 0), (0x1010, 1)] {
            assert_eq!(guarded(ObjectId::new(free.0, free.1), &set), None, "{:04X}h", free.0);
        }
    }
}
