//! The texts and words of the plant for operators. All of them are here; `tests/texts.rs` keeps a list of them.

use crate::fault::{InputFault, MotionFault};

/// The word for the end of a fault, in scenarios and in `linewright fail`.
pub const CLEAR_WORD: &str = "clear";

impl InputFault {
    /// The word for it, in scenarios and in `linewright fail`.
    pub const fn name(self) -> &'static str {
        match self {
            InputFault::StuckOn => "stuck-on",
            InputFault::StuckOff => "stuck-off",
        }
    }

    /// Effect of the fault, in words.
    pub const fn about(self) -> &'static str {
        match self {
            InputFault::StuckOn => "The input stays on, whatever the machine does.",
            InputFault::StuckOff => "The input stays off, whatever the machine does.",
        }
    }
}

impl MotionFault {
    /// The word for it, in scenarios and in `linewright fail`.
    pub const fn name(self) -> &'static str {
        match self {
            MotionFault::Stick => "stick",
            MotionFault::Slip => "slip",
            MotionFault::Break => "break",
            MotionFault::SlipBack => "slip-back",
            MotionFault::Miss => "miss",
            MotionFault::Drop => "drop",
        }
    }

    /// Effect of the fault on a drive; none where a drive has no such fault.
    pub const fn about_drive(self) -> Option<&'static str> {
        match self {
            MotionFault::Stick => {
                Some("It holds the axis where it is, and fails by its following error once it is ordered to move.")
            }
            MotionFault::Break => Some(
                "Its encoder is broken: it fails at once, at rest as well, and stays so until `clear`; a reset does not end it.",
            ),
            MotionFault::Slip | MotionFault::SlipBack | MotionFault::Miss | MotionFault::Drop => None,
        }
    }

    /// Effect of the fault, in words.
    pub const fn about(self) -> &'static [&'static str] {
        match self {
            MotionFault::Stick => &["The mechanism does not move."],
            MotionFault::Slip => &["It moves at a quarter of its speed."],
            MotionFault::Break => &["It does not move, and its fault signal comes on."],
            MotionFault::SlipBack => &["It moves the wrong way."],
            MotionFault::Miss => &["It moves, but the gripper that it closes takes nothing."],
            MotionFault::Drop => &["It moves, but the gripper that it has closed holds nothing fast."],
        }
    }
}
