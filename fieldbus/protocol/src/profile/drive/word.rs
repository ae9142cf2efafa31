//! The controlword (CiA 402, object 6040h) and the modes of operation (6060h, 6061h).
//!
//! The commands to the state machine are whole words, by the standard's command table. What a mode of operation adds
//! to them are single bits.

/// Command "shutdown": transitions 2, 6, 8.
pub const SHUTDOWN: u16 = 0x0006;
/// Command "switch on": transition 3; from operation enabled it is "disable operation", transition 5.
pub const SWITCH_ON: u16 = 0x0007;
/// Command "disable operation": transition 5. The same word as [`SWITCH_ON`].
pub const DISABLE_OPERATION: u16 = 0x0007;
/// Command "enable operation": transitions 4 and 16.
pub const ENABLE_OPERATION: u16 = 0x000F;
/// Command "quick stop": transitions 7, 10, 11.
pub const QUICK_STOP: u16 = 0x0002;
/// Command "disable voltage": transitions 7, 9, 10, 12.
pub const DISABLE_VOLTAGE: u16 = 0x0000;
/// Command "fault reset", on its rising edge: transition 15.
pub const FAULT_RESET: u16 = 0x0080;

/// Bit 4 in profile position mode: a new set-point, on its rising edge.
pub const NEW_SET_POINT: u16 = 1 << 4;
/// Bit 4 in homing mode: home, as long as it is set.
pub const HOMING_START: u16 = 1 << 4;
/// Bit 5 in profile position mode: the set-point replaces the one that is being moved to.
pub const CHANGE_IMMEDIATELY: u16 = 1 << 5;
/// Bit 6 in profile position mode: the set-point is relative.
pub const RELATIVE: u16 = 1 << 6;
/// Bit 8: halt.
pub const HALT: u16 = 1 << 8;

/// Mode of operation "profile position".
pub const PROFILE_POSITION: i8 = 1;
/// Mode of operation "profile velocity".
pub const PROFILE_VELOCITY: i8 = 3;
/// Mode of operation "homing".
pub const HOMING: i8 = 6;

/// Bits 7 and 6 of the positioning option code (60F2h, rotary axis direction option): towards greater positions alone, past
/// the greatest one if need be.
pub const ROTARY_POSITIVE: u16 = 2 << 6;
/// These bits: towards smaller positions alone, past the smallest one if need be.
pub const ROTARY_NEGATIVE: u16 = 1 << 6;
/// The shorter way; towards greater positions if both are as long.
pub const ROTARY_SHORTEST: u16 = 3 << 6;
