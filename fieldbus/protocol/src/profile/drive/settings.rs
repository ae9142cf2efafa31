//! Settings of a drive before it is started: its process data, its motion, and its stop behaviour.
//!
//! A process data object is remapped as CiA 301 §7.5.2.35 to §7.5.2.38 demands: switched off by bit 31 of its COB-ID,
//! its number of objects set to zero, then the objects, their number, and the COB-ID without bit 31 last.

use linewright_line::{AtRest, DriveMode, TurnDirection};

use super::binding::DriveBinding;
use super::{ManagedDrive, word};
use crate::codec::NodeId;
use crate::sdo::SdoWrite;

/// Bit 31 of a COB-ID parameter: the object is switched off.
const INVALID: u32 = 1 << 31;
/// Bit 30 of a transmit object's: it is not sent on remote request.
const NO_REMOTE: u32 = 1 << 30;
/// Transmission type: when something changes, and by the event timer.
const EVENT_DRIVEN: u8 = 255;
/// Shortest time between two transmit objects, in 100 µs: a moving drive's position changes all the time; a
/// few hundred frames a second show an arrival, and every step of enabling it, within 5 ms.
const INHIBIT: u16 = 50;
/// Longest time between two, in ms: what makes a lost frame good.
const EVENT_TIMER: u16 = 50;
/// Time within its window before it reports to have arrived, in ms.
const WINDOW_TIME: u16 = 10;

/// Controlword, mode of operation, target: index, subindex and bits of each.
const POSITION_OUT: [u32; 3] = [0x6040_0010, 0x6060_0008, 0x607A_0020];
const VELOCITY_OUT: [u32; 3] = [0x6040_0010, 0x6060_0008, 0x60FF_0020];
/// Statusword, mode of operation display, actual value.
const POSITION_IN: [u32; 3] = [0x6041_0010, 0x6061_0008, 0x6064_0020];
const VELOCITY_IN: [u32; 3] = [0x6041_0010, 0x6061_0008, 0x606C_0020];

impl ManagedDrive {
    /// The settings for a drive that is `node`, in the order in which they are to be written.
    pub fn settings(&self, node: NodeId) -> Vec<SdoWrite> {
        let binding = self.binding();
        let (receive, transmit) = match binding.mode {
            DriveMode::Position => (POSITION_OUT, POSITION_IN),
            DriveMode::Velocity => (VELOCITY_OUT, VELOCITY_IN),
        };
        let rpdo = 0x200 + u32::from(node.get());
        let tpdo = NO_REMOTE | (0x180 + u32::from(node.get()));
        let mut settings = vec![SdoWrite::u32(0x1400, 1, INVALID | rpdo), SdoWrite::u32(0x1800, 1, INVALID | tpdo)];
        map(0x1600, receive, &mut settings);
        map(0x1A00, transmit, &mut settings);
        stopping(binding, &mut settings);
        motion(binding, &mut settings);
        circle(binding, &mut settings);
        homing(binding, &mut settings);
        settings.extend([
            SdoWrite::u8(0x1400, 2, EVENT_DRIVEN),
            SdoWrite::u8(0x1800, 2, EVENT_DRIVEN),
            SdoWrite::u16(0x1800, 3, INHIBIT).optional(),
            SdoWrite::u16(0x1800, 5, EVENT_TIMER),
            SdoWrite::u32(0x1400, 1, rpdo),
            SdoWrite::u32(0x1800, 1, tpdo),
        ]);
        settings
    }
}

fn map(index: u16, objects: [u32; 3], settings: &mut Vec<SdoWrite>) {
    settings.push(SdoWrite::u8(index, 0, 0));
    for (sub, object) in (1..).zip(objects) {
        settings.push(SdoWrite::u32(index, sub, object));
    }
    settings.push(SdoWrite::u8(index, 0, objects.len() as u8));
}

/// Its stop behaviour. None of these may be missing: the reasoning in [`super`] rests on them.
fn stopping(binding: &DriveBinding, settings: &mut Vec<SdoWrite>) {
    let quick_stop = match binding.at_rest {
        // Slow down on the quick stop ramp, then switch off.
        AtRest::Off => 2,
        // The same, but stay in quick stop active, holding.
        AtRest::Hold => 6,
    };
    settings.extend([
        SdoWrite::i16(0x605A, quick_stop),
        // Disable operation: slow down, then disable.
        SdoWrite::i16(0x605C, 1),
        // Halt: slow down on the quick stop ramp, stay enabled.
        SdoWrite::i16(0x605D, 2),
        // When the manager's heartbeat, or the bus, is gone: the quick stop command.
        SdoWrite::i16(0x6007, 3),
        // On a fault: slow down on the quick stop ramp where that is still possible.
        SdoWrite::i16(0x605E, 2).optional(),
        SdoWrite::u32(0x6085, 0, binding.quick_stop),
    ]);
}

fn motion(binding: &DriveBinding, settings: &mut Vec<SdoWrite>) {
    settings.extend([
        SdoWrite::u32(0x6083, 0, binding.acceleration),
        SdoWrite::u32(0x6084, 0, binding.acceleration),
        // A linear ramp: what its braking distance is worked out from.
        SdoWrite::i16(0x6086, 0).optional(),
        SdoWrite::u8(0x6060, 0, binding.profile() as u8),
    ]);
    match binding.mode {
        DriveMode::Position => settings.extend([
            profile_velocity(binding.velocity),
            SdoWrite::u32(0x6067, 0, binding.window).optional(),
            SdoWrite::u16(0x6068, 0, WINDOW_TIME).optional(),
        ]),
        DriveMode::Velocity => {
            let window = u16::try_from(binding.window).unwrap_or(u16::MAX);
            settings.push(SdoWrite::u16(0x606D, 0, window).optional());
        }
    }
}

/// How it counts on an endless axis. None of these may be missing, and they are read back: a drive that does not begin anew
/// after a turn, or goes the other way, would go to another place.
fn circle(binding: &DriveBinding, settings: &mut Vec<SdoWrite>) {
    let Some(places) = &binding.index else { return };
    let way = match places.index.direction {
        TurnDirection::Positive => word::ROTARY_POSITIVE,
        TurnDirection::Negative => word::ROTARY_NEGATIVE,
    };
    settings.extend([
        // On reaching the greatest it goes on from the least: a turn is the way between the two.
        SdoWrite::u32(0x607B, 1, 0).read_back(),
        SdoWrite::u32(0x607B, 2, places.turn().unsigned_abs()).read_back(),
        SdoWrite::u16(0x60F2, 0, way).read_back(),
    ]);
}

fn homing(binding: &DriveBinding, settings: &mut Vec<SdoWrite>) {
    let Some(home) = &binding.home else { return };
    settings.extend([
        SdoWrite::u8(0x6098, 0, home.method as u8),
        SdoWrite::u32(0x6099, 1, home.fast),
        SdoWrite::u32(0x6099, 2, home.slow),
        SdoWrite::u32(0x609A, 0, home.acceleration).optional(),
        SdoWrite::u32(0x607C, 0, home.offset as u32),
    ]);
}

/// Object 6081h, which a target may have of its own.
pub(super) fn profile_velocity(velocity: u32) -> SdoWrite {
    SdoWrite::u32(0x6081, 0, velocity)
}
