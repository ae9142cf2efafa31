//! The console: its inputs as commands, its buttons, and its emergency stop.

use linewright_line::{InputId, Owner};

use super::{Coordinator, EStopCause};
use crate::decision::ModeCommand;

impl Coordinator {
    pub(super) fn wired_buttons(&self) -> u32 {
        let wired = self.line.console.buttons.iter().enumerate();
        wired.fold(0, |bits, (i, input)| bits | u32::from(self.wired(*input)) << i) & !self.unreleased
    }

    pub(super) fn estop_is_pressed(&self) -> bool {
        let (bits, valid) = self.console;
        valid && self.line.console.estop.is_some_and(|contact| contact.is_pressed(bits))
    }

    /// A console is described and has not been received since the start: whether its emergency stop is pressed is
    /// unknown.
    pub(super) fn console_is_unknown(&self) -> bool {
        !self.console_was_heard && self.line.devices.iter().any(|device| device.owner == Owner::Console)
    }

    pub(super) fn wired(&self, input: Option<InputId>) -> bool {
        let (bits, valid) = self.console;
        valid && input.is_some_and(|input| bits & (1 << input.0) != 0)
    }

    pub(super) fn hear_console(&mut self, bits: u128, valid: bool) {
        let before = self.console;
        if before == (bits, valid) {
            return;
        }
        let lost = before.1 && !valid;
        self.console = (bits, valid);
        self.changed = true;
        let console = self.line.console.clone();
        if let Some(contact) = console.estop.filter(|_| self.estop_is_pressed()) {
            self.stop(EStopCause::Pressed(contact.input));
        }
        // An emergency stop that cannot be received counts as pressed.
        if lost && console.estop.is_some() {
            self.stop(EStopCause::ConsoleLost);
        }
        // Hand-mode buttons that are down when the console comes back may never have been released.
        let wired = |on: u32, (i, input): (usize, &Option<InputId>)| on | u32::from(self.wired(*input)) << i;
        let down = console.buttons.iter().enumerate().fold(0, wired);
        self.unreleased = if before.1 && valid { self.unreleased & down } else { down };
        // A button that was already down when the console came up was not pressed now.
        let first = !before.1;
        if valid && !first {
            let pressed = |input: Option<InputId>| input.is_some_and(|input| bits & !before.0 & (1 << input.0) != 0);
            let buttons = [
                (console.start, ModeCommand::Start),
                (console.stop, ModeCommand::Stop),
                (console.auto, ModeCommand::Auto),
                (console.hand, ModeCommand::Hand),
                (console.reset, ModeCommand::Reset),
            ];
            for (input, command) in buttons {
                if pressed(input) {
                    self.command(command);
                }
            }
        }
        self.console_was_heard |= valid;
    }
}
