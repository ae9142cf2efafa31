//! The mode, with the reasons that keep it.

use linewright_line::net::ControlMode;

/// Contents of the text of the mode; stations by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModeText<'a> {
    /// The emergency stop is reset; without meaning in other modes.
    pub reset: bool,
    /// The line stops at home.
    pub stopping: bool,
    /// Stations that have not acknowledged the mode.
    pub waiting: Vec<&'a str>,
    /// Stations left out of the mode decision.
    pub without: Vec<&'a str>,
    /// Stations in an emergency stop of their own.
    pub stopped: Vec<&'a str>,
    /// Reasons against other modes.
    pub troubles: Vec<String>,
    /// The mode that ended by itself last, and why; until the next command.
    pub ended: Option<(ControlMode, Vec<String>)>,
}

impl ModeText<'_> {
    /// The text, e.g. `auto, stopping at home` or `stand-by: mill_1: no state received`.
    pub fn text(&self, mode: ControlMode) -> String {
        let mut text = mode.name().to_owned();
        if mode == ControlMode::EStop {
            text.push_str(if self.reset { ", reset; select manual" } else { ", not reset; give reset, then manual" });
        }
        if self.stopping {
            text.push_str(", stopping at home");
        }
        if !self.waiting.is_empty() {
            text.push_str(&format!(", waiting for {}", self.waiting.join(", ")));
        }
        if !self.without.is_empty() {
            text.push_str(&format!(", without {}", self.without.join(", ")));
        }
        if !self.stopped.is_empty() {
            text.push_str(&format!(", {} in emergency stop", self.stopped.join(" and ")));
        }
        if let Some((mode, reasons)) = &self.ended
            && reasons.iter().any(|reason| !self.troubles.contains(reason))
        {
            text.push_str(&format!(", {mode} ended ({})", reasons.join("; ")));
        }
        if !self.troubles.is_empty() {
            text.push_str(&format!(": {}", self.troubles.join("; ")));
        }
        text
    }
}
