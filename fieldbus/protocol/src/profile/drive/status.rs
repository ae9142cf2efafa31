//! The statusword (CiA 402, object 6041h): total, and nothing of it is lost.

use std::fmt;

/// The state of a drive's power and function (CiA 402, the figure of the power drive system's state machine).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DriveState {
    /// Self-test, initialisation. It obeys no command.
    NotReadyToSwitchOn,
    /// Initialised; power must not be switched on.
    SwitchOnDisabled,
    /// Power may be switched on.
    ReadyToSwitchOn,
    /// Power is on; no torque yet.
    SwitchedOn,
    /// It obeys its mode of operation.
    OperationEnabled,
    /// It is stopping, or has stopped, by the quick stop function.
    QuickStopActive,
    /// A fault has come up; its fault reaction is active.
    FaultReactionActive,
    /// It has failed, and its power is off.
    Fault,
    /// Bits that the profile gives no meaning.
    Unknown,
}

impl DriveState {
    /// The bits of a statusword in this state: bits 0 to 3, 5 and 6. [`DriveState::Unknown`] has none.
    pub const fn bits(self) -> u16 {
        match self {
            DriveState::NotReadyToSwitchOn | DriveState::Unknown => 0x00,
            DriveState::SwitchOnDisabled => 0x40,
            DriveState::ReadyToSwitchOn => 0x21,
            DriveState::SwitchedOn => 0x23,
            DriveState::OperationEnabled => 0x27,
            DriveState::QuickStopActive => 0x07,
            DriveState::FaultReactionActive => 0x0F,
            DriveState::Fault => 0x08,
        }
    }
}

impl fmt::Display for DriveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DriveState::NotReadyToSwitchOn => "not ready to switch on",
            DriveState::SwitchOnDisabled => "switch on disabled",
            DriveState::ReadyToSwitchOn => "ready to switch on",
            DriveState::SwitchedOn => "switched on",
            DriveState::OperationEnabled => "operation enabled",
            DriveState::QuickStopActive => "quick stop active",
            DriveState::FaultReactionActive => "fault reaction active",
            DriveState::Fault => "fault",
            DriveState::Unknown => "in a state the profile does not know",
        })
    }
}

/// A statusword as it came, unknown bits and all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Statusword(pub u16);

impl Statusword {
    /// The state it reports.
    pub const fn state(self) -> DriveState {
        // Bit 5 has a meaning in some states only, so it is looked at in those.
        match (self.0 & 0x4F, self.0 & 0x20 != 0) {
            (0x00, _) => DriveState::NotReadyToSwitchOn,
            (0x40, _) => DriveState::SwitchOnDisabled,
            (0x01, true) => DriveState::ReadyToSwitchOn,
            (0x03, true) => DriveState::SwitchedOn,
            (0x07, true) => DriveState::OperationEnabled,
            (0x07, false) => DriveState::QuickStopActive,
            (0x0F, _) => DriveState::FaultReactionActive,
            (0x08, _) => DriveState::Fault,
            _ => DriveState::Unknown,
        }
    }

    /// Bit 4: high voltage is there.
    pub const fn voltage_enabled(self) -> bool {
        self.bit(4)
    }

    /// Bit 7: a warning.
    pub const fn warning(self) -> bool {
        self.bit(7)
    }

    /// Bit 9: it obeys the controlword. Off: it is operated locally.
    pub const fn remote(self) -> bool {
        self.bit(9)
    }

    /// Bit 10: it is at its target position or velocity; with halt set: it stands.
    pub const fn target_reached(self) -> bool {
        self.bit(10)
    }

    /// Bit 11: a limit of the drive keeps it from its target.
    pub const fn internal_limit(self) -> bool {
        self.bit(11)
    }

    /// Bit 12 in profile position mode: it has taken the set-point.
    pub const fn set_point_acknowledge(self) -> bool {
        self.bit(12)
    }

    /// Bit 12 in homing mode: the homing was carried out.
    pub const fn homing_attained(self) -> bool {
        self.bit(12)
    }

    /// Bit 13 in profile position mode: it lags behind its own profile.
    pub const fn following_error(self) -> bool {
        self.bit(13)
    }

    /// Bit 13 in homing mode: the homing has failed.
    pub const fn homing_error(self) -> bool {
        self.bit(13)
    }

    const fn bit(self, at: u32) -> bool {
        self.0 >> at & 1 == 1
    }
}

impl fmt::Display for Statusword {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of the standard as it prints it, x for a bit that does not matter.
    const TABLE: [(&str, DriveState); 8] = [
        ("xxxxxxxxx0xx0000", DriveState::NotReadyToSwitchOn),
        ("xxxxxxxxx1xx0000", DriveState::SwitchOnDisabled),
        ("xxxxxxxxx01x0001", DriveState::ReadyToSwitchOn),
        ("xxxxxxxxx01x0011", DriveState::SwitchedOn),
        ("xxxxxxxxx01x0111", DriveState::OperationEnabled),
        ("xxxxxxxxx00x0111", DriveState::QuickStopActive),
        ("xxxxxxxxx0xx1111", DriveState::FaultReactionActive),
        ("xxxxxxxxx0xx1000", DriveState::Fault),
    ];

    fn fits(word: u16, pattern: &str) -> bool {
        let digits = pattern.bytes().rev().enumerate();
        digits.into_iter().all(|(at, digit)| digit == b'x' || (digit == b'1') == (word >> at & 1 == 1))
    }

    #[test]
    fn every_statusword_is_the_row_of_the_table_that_fits_it() {
        for word in 0..=u16::MAX {
            let rows: Vec<DriveState> =
                TABLE.iter().filter(|(row, _)| fits(word, row)).map(|(_, state)| *state).collect();
            let expected = rows.first().copied().unwrap_or(DriveState::Unknown);
            assert!(rows.len() <= 1, "{word:04X}");
            assert_eq!(Statusword(word).state(), expected, "{word:04X}");
        }
        for (_, state) in TABLE {
            assert_eq!(Statusword(state.bits()).state(), state);
        }
    }
}
