//! The mode, with the reasons that keep it.

use linewright_line::Line;
use linewright_line::net::ControlMode;

use crate::coordinator::EStopCause;

/// The console's emergency stop button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EStopButton {
    /// The console's devices are not received, or the button is not what gave the stop.
    #[default]
    Unknown,
    /// In: reset is refused.
    Pressed,
    /// It gave the stop, and is out again.
    Released,
}

impl EStopButton {
    /// What the text of the mode has while it is pressed.
    pub const RELEASE_IT: &'static str = "release the emergency stop button";
}

/// Contents of the text of the mode; stations by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModeText<'a> {
    /// Why the emergency stop is latched; none once it is reset.
    pub stop: Option<String>,
    /// State of the console's button.
    pub button: EStopButton,
    /// When it was latched; empty where that is unknown.
    pub stopped_at: &'a str,
    /// The coordinator was started while a station was away from home.
    pub found_away: bool,
    /// The line stops at home.
    pub stopping: bool,
    /// Stations that have not acknowledged the mode.
    pub waiting: Vec<&'a str>,
    /// Stations left out of the mode decision.
    pub without: Vec<&'a str>,
    /// Stations in an emergency stop of their own.
    pub stopped: Vec<&'a str>,
    /// Stations in manual by themselves, each with the reasons why its panel does not act.
    pub manual: Vec<(&'a str, Vec<String>)>,
    /// Stations left out whose selectors stand at manual without effect, each with the reasons.
    pub selectors: Vec<(&'a str, Vec<String>)>,
    /// Reasons against other modes.
    pub troubles: Vec<String>,
    /// The mode that ended by itself last, and why; until the next command, and where that is no trouble now.
    pub ended: Option<(ControlMode, Vec<String>)>,
}

/// Sentence of the text of the mode on stations that are left out of it, between the mode and the reasons; empty where none is.
pub fn left_out<S: AsRef<str>>(stations: &[S]) -> String {
    let names: Vec<&str> = stations.iter().map(AsRef::as_ref).collect();
    if names.is_empty() { String::new() } else { format!(". Left out: {}", names.join(", ")) }
}

impl ModeText<'_> {
    /// The text, e.g. `auto, stopping at home` or `stand-by: mill_1: no state received`.
    pub fn text(&self, mode: ControlMode) -> String {
        let mut text = mode.name().to_owned();
        if mode == ControlMode::EStop {
            match &self.stop {
                Some(cause) if self.stopped_at.is_empty() => text.push_str(&format!(" ({cause})")),
                Some(cause) => text.push_str(&format!(" since {} ({cause})", self.stopped_at)),
                None => {}
            }
            match (&self.stop, self.button) {
                (None, _) => text.push_str(", reset; select manual"),
                (Some(_), EStopButton::Unknown) => text.push_str(", not reset; give reset, then manual"),
                (Some(_), EStopButton::Released) => {
                    text.push_str(", button released, not reset; give reset, then manual");
                }
                (Some(_), EStopButton::Pressed) => {
                    let release = EStopButton::RELEASE_IT;
                    text.push_str(&format!(", not reset; {release}, then give reset, then manual"));
                }
            }
        }
        if self.found_away {
            text.push_str(", coordinator started with stations away from home");
        }
        if self.stopping {
            text.push_str(", stopping at home");
        }
        if !self.waiting.is_empty() {
            text.push_str(&format!(", waiting for {}", self.waiting.join(", ")));
        }
        if !self.stopped.is_empty() {
            text.push_str(&format!(", {} in emergency stop", self.stopped.join(" and ")));
        }
        for (name, reasons) in &self.manual {
            text.push_str(&format!(", {name} in manual"));
            if !reasons.is_empty() {
                text.push_str(&format!(" without effect ({})", reasons.join("; ")));
            }
        }
        for (name, reasons) in &self.selectors {
            text.push_str(&format!(", selector of {name} at manual without effect ({})", reasons.join("; ")));
        }
        if let Some((mode, reasons)) = &self.ended {
            text.push_str(&format!(", {mode} ended ({})", reasons.join("; ")));
        }
        text.push_str(&left_out(&self.without));
        if !self.troubles.is_empty() {
            let joint = if self.without.is_empty() { ": " } else { ". " };
            text.push_str(&format!("{joint}{}", self.troubles.join("; ")));
        }
        text
    }
}

impl EStopCause {
    /// The cause, e.g. `console lost`.
    pub fn text(self, line: &Line) -> String {
        match self {
            EStopCause::Pressed(input) => match line.console.inputs.get(usize::from(input.0)) {
                Some(input) => format!("button {} of the console pressed", input),
                None => "button of the console pressed".to_owned(),
            },
            EStopCause::ConsoleLost => "console lost: its I/O devices were not operational".to_owned(),
            EStopCause::Commanded => "command estop".to_owned(),
            EStopCause::JournalLost => "coordinator journal not writable".to_owned(),
            EStopCause::Station(station) => {
                format!("{} reports an emergency stop, not of this coordinator", line.station(station).name)
            }
            EStopCause::Restarted => "in force before the coordinator was restarted".to_owned(),
        }
    }
}
