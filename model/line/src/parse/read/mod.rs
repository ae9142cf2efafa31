//! Text → [`RawLine`]: TOML, keys and types, and nothing about meaning.
//!
//! Every list is bounded here, so that whatever a file contains, the later passes work on something of known size.

mod analogue;
mod drive;
mod frames;
mod handling;
mod line;
mod modbus;
mod setup;
mod station;
mod task;

use linewright_text::{Fields, Report};

use super::raw::RawLine;

/// At most this many stations: far more than one line has, and few enough to explore a mistake quickly.
const STATIONS_MAX: usize = 1000;
/// At most this many arrows.
const ARROWS_MAX: usize = 10_000;
/// At most this many conflicts.
const CONFLICTS_MAX: usize = 10_000;
/// At most this many devices.
const DEVICES_MAX: usize = 4000;
/// At most this many axes in one station.
const AXES_MAX: usize = 64;
/// Bits of one device each way: one PDO of 8 bytes (CiA 401's default mapping).
const DEVICE_BITS: usize = 64;
/// At most this many objects of one device that are written before it is started.
const SETTINGS_MAX: usize = 256;
/// At most this many targets of one drive.
const TARGETS_MAX: usize = 64;
/// At most this many limits or values of one analogue channel.
const LIMITS_MAX: usize = 64;
/// At most this many messages of one device each way, and of signals in each that anything follows from.
const SIGNALS_MAX: usize = 64;

/// At most this many places for parts that belong to no station, and in each station.
const HOLDERS_MAX: usize = 1000;
/// At most this many nests that the hands of one station reach.
const REACHES_MAX: usize = 256;
/// At most this many positions in one store.
const PLACES_MAX: i64 = 10_000;
/// At most this many inputs that see parts, and conditions for one.
const SENSORS_MAX: usize = 4000;
const SIGNS_MAX: usize = 16;

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawLine> {
    let document = linewright_text::document(text, report)?;
    let top = Fields::new(document.as_table(), 0..0, "the description");
    Some(line::line(top, report))
}
