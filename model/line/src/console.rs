//! The main console: its signals, and the contact of its emergency stop.

use crate::{InputId, OutputId};

/// The main console (seed 002 §5.4, Figures 18 and 23). Its image has its own input and output numbering.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Console {
    /// Names of its inputs: bit `i` of the console's input image.
    pub inputs: Vec<String>,
    /// Names of its outputs: bit `i` of the console's output image.
    pub outputs: Vec<String>,
    /// Master start push button.
    pub start: Option<InputId>,
    /// Master stop push button.
    pub stop: Option<InputId>,
    /// Auto push button.
    pub auto: Option<InputId>,
    /// Hand push button.
    pub hand: Option<InputId>,
    /// Emergency stop, latching mushroom button.
    pub estop: Option<StopContact>,
    /// Reset push button.
    pub reset: Option<InputId>,
    /// For each of [`Line::buttons`](crate::Line::buttons), its input; `None` for a button that exists on ROS topics alone.
    pub buttons: Vec<Option<InputId>>,
    /// Lamps: on while the line is in that mode, in the order auto, hand, manual, fault (any incomplete operation).
    pub lamps: [Option<OutputId>; 4],
}

/// The contact of an emergency stop button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StopContact {
    /// Its input of the console.
    pub input: InputId,
    /// State of the input while the button is pressed: false with a closed-circuit contact, whose broken wire reads as
    /// pressed too.
    pub pressed: bool,
}

impl StopContact {
    /// Whether the button is pressed, by the console's input image.
    pub fn is_pressed(self, image: u128) -> bool {
        (image & (1 << self.input.0) != 0) == self.pressed
    }
}
