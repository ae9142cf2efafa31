//! Error behaviour of a device's outputs when its manager is missing, it fails, or is stopped: CiA 301 1029h, CiA 401
//! 6206h and 6207h for bits, 6443h and 6444h for channels.
//!
//! When the manager is dead, only the device itself can switch an output off. So factory settings are not relied upon:
//! each of these objects is written before the device is started, and read back, since some devices accept a write and
//! keep the old value. One that lacks an object, or gives back another value, is not started, unless the description
//! gives a reason ([`DeviceSetup::without_error_values`]); the objects are then written all the same, and refusals are
//! ignored.
//!
//! Values that the description itself writes to one of these objects stay, and are read back as well.
//!
//! [`DeviceSetup::without_error_values`]: linewright_line::Setup::without_error_values

use linewright_line::{DeviceSetup, OutputId, wired_bits};

use crate::sdo::SdoWrite;

/// Error behaviour: where a communication error leads. 0 is pre-operational, which a device without the object does
/// anyway (CiA 301 §7.5.2.32).
const BEHAVIOUR: (u16, u8) = (0x1029, 1);
/// Whether a byte of outputs takes its error value, bit by bit, and which that is.
const MODE: u16 = 0x6206;
const VALUE: u16 = 0x6207;

/// Whether an object belongs to these.
pub(super) fn is_one(index: u16) -> bool {
    matches!(index, 0x1029 | MODE | VALUE | 0x6443 | 0x6444)
}

/// Objects written to an I/O device with outputs. `own` are the settings in its description; they replace these.
pub(super) fn settings(
    outputs: &[Option<OutputId>],
    sets: bool,
    own: &[linewright_line::ObjectWrite],
) -> Vec<SdoWrite> {
    if outputs.is_empty() && !sets {
        return Vec::new();
    }
    let (index, sub) = BEHAVIOUR;
    let mut settings = vec![SdoWrite::u8(index, sub, 0).optional().read_back()];
    for (nth, byte) in (1..).zip(outputs.chunks(8)) {
        // Bits without a wire may have any value: many devices have fewer outputs than a byte has bits.
        let mask = wired_bits(byte);
        if mask != 0 {
            settings.push(SdoWrite::u8(MODE, nth, 0xFF).read_back_bits(mask));
            settings.push(SdoWrite::u8(VALUE, nth, 0).read_back_bits(mask));
        }
    }
    settings
        .retain(|setting| !own.iter().any(|own| (own.index, own.sub) == (setting.object.index, setting.object.sub)));
    settings
}

/// Marks a plan's settings that belong here: those of the description are read back like the manager's own, and all of
/// them are excused where the description gives a reason.
pub(super) fn judged(setup: &DeviceSetup, settings: impl Iterator<Item = SdoWrite>) -> Vec<SdoWrite> {
    let excused = setup.without_error_values.is_some();
    let judge = |setting: SdoWrite| {
        let concerned = is_one(setting.object.index);
        let setting = if concerned && setting.compared.is_none() { setting.read_back() } else { setting };
        SdoWrite { excused: concerned && excused, ..setting }
    };
    settings.map(judge).collect()
}
