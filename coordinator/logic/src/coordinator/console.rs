//! The console: its inputs as commands, its buttons, resume, and its emergency stop.

use linewright_line::net::ControlMode;
use linewright_line::{InputId, Owner};

use super::{Coordinator, EStopCause};
use crate::decision::ModeCommand;
use crate::refusal::{ModeRefusal, OperatorCommand, RefusedCommand};
use crate::texts::EStopButton;

impl Coordinator {
    pub(super) fn wired_buttons(&self) -> u32 {
        let wired = self.line.console.buttons.iter().enumerate();
        wired.fold(0, |bits, (i, input)| bits | u32::from(self.wired(*input)) << i) & !self.unreleased
    }

    pub(super) fn estop_is_pressed(&self) -> bool {
        let (bits, valid) = self.console;
        valid && self.line.console.estop.is_some_and(|contact| contact.is_pressed(bits))
    }

    /// The button as the text of the mode has it.
    pub(super) fn estop_button(&self) -> EStopButton {
        match self.estop {
            _ if self.estop_is_pressed() => EStopButton::Pressed,
            Some((EStopCause::Pressed(_), _)) if self.console.1 => EStopButton::Released,
            _ => EStopButton::Unknown,
        }
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

    /// Whether resume is in force: held at one console, in a manual that was commanded and that every station has acknowledged.
    pub(super) fn resumes(&self) -> bool {
        self.mode == ControlMode::Manual && self.manual_all && self.enabled && self.resume.is_held(self.now)
    }

    pub(super) fn hear_resume(&mut self, console: u64, held: bool) {
        if !self.resume.hear(self.now, console, held, self.line.timing.stale) {
            return;
        }
        let reason = match self.rival() {
            _ if self.mode != ControlMode::Manual => Some(ModeRefusal::NotManual),
            Some(life) => Some(ModeRefusal::OtherCoordinator(life)),
            None if !self.manual_all => Some(ModeRefusal::ManualBySelectors),
            None if self.resume.is_contested(self.now) => Some(ModeRefusal::TwoConsoles),
            None if self.resume.is_unreleased() => Some(ModeRefusal::Unreleased),
            None => None,
        };
        if let Some(reason) = reason {
            self.resume.disarm();
            let (command, mode) = (OperatorCommand::Resume, self.mode);
            self.refusals.push(RefusedCommand { command, mode, reasons: vec![reason] });
            self.changed = true;
        }
    }
}
