//! One sentence: what the drive is doing, or what it waits for.

use std::fmt::Write;

use linewright_line::{AtRest, DriveMode};

use super::{ControlwordEdge, DriveFeedback, DriveGoal, DriveInhibit, DrivePhase, DriveState, ManagedDrive, meaning};

impl ManagedDrive {
    /// Its activity, or what it waits for, in one sentence, with the statusword it was read from.
    pub fn explain(&self) -> String {
        let Some(feedback) = self.feedback else {
            return "no process data from it yet".to_owned();
        };
        let mut text = match self.phase {
            DrivePhase::Resting => self.resting(feedback),
            DrivePhase::Refused(refusal) => self.refused(refusal),
            DrivePhase::Preparing(goal) => self.preparing(goal, feedback),
            DrivePhase::Offered(at) => format!("{}: waiting for it to acknowledge the set-point", self.to(at)),
            DrivePhase::Moving(at) => self.moving(at, feedback),
            DrivePhase::Homing { .. } => format!("homing: at {}", self.units(feedback.actual)),
            DrivePhase::Homed => "homed".to_owned(),
            DrivePhase::There => format!("at {}, where it was ordered to", self.units(feedback.actual)),
        };
        let word = feedback.word;
        let power = word.state() == DriveState::SwitchOnDisabled && !matches!(self.phase, DrivePhase::Resting);
        for (applies, note) in [
            (!word.remote(), "operated locally: it does not obey"),
            (power && !word.voltage_enabled(), "no voltage"),
            (word.internal_limit(), "at a limit of its own"),
            (word.warning(), "it warns"),
        ] {
            if applies {
                let _ = write!(text, "; {note}");
            }
        }
        let _ = write!(text, " (statusword {word})");
        text
    }

    fn resting(&self, feedback: DriveFeedback) -> String {
        let state = feedback.word.state();
        match (state, self.binding.at_rest) {
            (DriveState::Fault | DriveState::FaultReactionActive, _) => {
                format!("{state}{}: being reset", self.because())
            }
            (DriveState::OperationEnabled, AtRest::Hold) => format!("holding at {}", self.units(feedback.actual)),
            (DriveState::OperationEnabled | DriveState::QuickStopActive, _) => {
                format!("{state}: stopping, no output is on")
            }
            _ if !self.knows_zero() => format!("{state}: no output is on, not homed"),
            _ => format!("{state}: no output is on"),
        }
    }

    fn refused(&self, refusal: DriveInhibit) -> String {
        let until = "until every output of it is off";
        match refusal {
            DriveInhibit::Several(one, other) => {
                format!("outputs {} and {} are on at once: it stands {until}", one.0, other.0)
            }
            DriveInhibit::NotHomed => "not homed: it goes nowhere before the homing has been ordered".to_owned(),
            DriveInhibit::NotNext { at, from } => format!(
                "ordered to {}, which is not the next place from {}: it stands {until}",
                self.units(self.binding.targets[at].to),
                self.units(from)
            ),
            DriveInhibit::Failed => format!("fault{}: it stands {until}", self.because()),
            DriveInhibit::Interrupted(word) if word.0 == 0 => {
                format!("it was lost under an order{}: it stands {until}", self.because())
            }
            DriveInhibit::Interrupted(word) => {
                format!("it left its order by itself ({}, {word}){}: it stands {until}", word.state(), self.because())
            }
            DriveInhibit::HomingFailed => format!("the homing has failed{}: it stands {until}", self.because()),
            DriveInhibit::Velocity(code) => format!("it refuses its velocity, object 6081h: {code}; it stands {until}"),
        }
    }

    fn preparing(&self, goal: DriveGoal, feedback: DriveFeedback) -> String {
        let state = feedback.word.state();
        let next = match state {
            DriveState::NotReadyToSwitchOn => DriveState::SwitchOnDisabled,
            DriveState::SwitchOnDisabled => DriveState::ReadyToSwitchOn,
            DriveState::ReadyToSwitchOn => DriveState::SwitchedOn,
            DriveState::QuickStopActive if self.binding.at_rest == AtRest::Off => DriveState::SwitchOnDisabled,
            DriveState::OperationEnabled => return self.enabled(goal, feedback),
            _ => DriveState::OperationEnabled,
        };
        format!("{state}: waiting for {next}")
    }

    /// Enabled, without an order to move yet.
    fn enabled(&self, goal: DriveGoal, feedback: DriveFeedback) -> String {
        let mode = self.mode_for(goal);
        if feedback.mode != mode {
            return format!("operation enabled: waiting for mode {mode}, it is in {}", feedback.mode);
        }
        match (self.edge, goal) {
            (ControlwordEdge::Leaving | ControlwordEdge::Raised, _) => {
                "operation enabled: waiting for it to leave that first".to_owned()
            }
            (ControlwordEdge::Acknowledged, _) => {
                "waiting for the acknowledge of the last set-point to fall".to_owned()
            }
            (ControlwordEdge::Low, DriveGoal::Target(at)) if self.slow_or_fast(at).is_some() => {
                format!("{}: waiting for its velocity to be written", self.to(at))
            }
            (ControlwordEdge::Low, _) => "operation enabled: waiting for the acknowledge to fall".to_owned(),
        }
    }

    fn moving(&self, at: usize, feedback: DriveFeedback) -> String {
        let here = self.units(feedback.actual);
        let lags = feedback.word.following_error() && self.binding.mode == DriveMode::Position;
        match (self.is_there(at), lags) {
            (true, _) => format!("{}: there", self.to(at)),
            (false, true) => format!("{}: at {here}, lagging behind", self.to(at)),
            (false, false) => format!("{}: at {here}", self.to(at)),
        }
    }

    fn to(&self, at: usize) -> String {
        format!("going to {}", self.units(self.binding.targets[at].to))
    }

    fn units(&self, increments: i32) -> f64 {
        // To the nearest millionth: what a division leaves beyond that is no position.
        (f64::from(increments) / self.binding.units * 1e6).round() / 1e6
    }

    fn because(&self) -> String {
        match self.error {
            None => String::new(),
            Some(code) => format!(", error {code:04X}h ({})", meaning(code).unwrap_or("unknown")),
        }
    }
}
