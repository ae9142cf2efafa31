//! The description as written: every key it may have, and every value with the place it was written at; no name is
//! resolved yet.
//!
//! Each table of the description is one table of keys here, from which its reader and the schema for editors follow. A
//! field is `None` when it is missing or could not be read; that has been reported, so that no later rule has to. This is
//! the only form with the layout of the text; [`super::draft`] is the first with resolved names.
//!
//! Every list is bounded here, so that whatever a file contains, the later passes work on something of known size.

mod analogue;
mod device;
mod drive;
mod frames;
mod handling;
mod line;
mod modbus;
mod station;
mod station_type;

pub(super) use analogue::{RawAnalogue, RawAnalogueInput, RawAnalogueOutput, RawChannel, RawLag, RawLimit};
pub(super) use device::{RawDevice, RawDeviceKind, RawIdentity, RawSetting, RawTransmission, Width};
pub(super) use drive::{RawDrive, RawDriveIndex, RawTarget};
pub(super) use frames::{RawChecksum, RawFrames, RawHeard, RawSignalInput, RawTold};
pub(super) use handling::{RawHolder, RawReach, RawSensor, RawSign, RawStand};
pub(super) use line::{RawArrow, RawConflict, RawConsole, RawEnd, RawLine, RawSpan, RawTiming};
pub(super) use modbus::{RawModbus, RawRegisterValue};
pub(super) use station::{ModuleKind, RawHand, RawMoves, RawOperation, RawSignals, RawStation, RawTask};
pub(super) use station_type::RawStationType;

use linewright_text::{Fields, Keys, Report};

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawLine> {
    let document = linewright_text::document(text, report)?;
    Some(RawLine::read_all(Fields::new(document.as_table(), 0..0, RawLine::WHAT), report))
}
