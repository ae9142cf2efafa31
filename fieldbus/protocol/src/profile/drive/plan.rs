//! The next command, from the demand and the drive's feedback.
//!
//! `advance` moves the phase, on evidence from the drive alone: what was sent proves nothing. `command` is the word for
//! a phase.

use linewright_line::{AtRest, DriveMode, Tick};

use super::binding::DriveDemand;
use super::word::{
    CHANGE_IMMEDIATELY, DISABLE_OPERATION, DISABLE_VOLTAGE, ENABLE_OPERATION, FAULT_RESET, HALT, HOMING, HOMING_START,
    NEW_SET_POINT, PROFILE_POSITION, PROFILE_VELOCITY, QUICK_STOP, SHUTDOWN, SWITCH_ON,
};
use super::{
    ControlwordEdge, DriveCommand, DriveFeedback, DriveGoal, DriveInhibit, DrivePhase, DriveState, HOMING_SETTLE,
    ManagedDrive, RESET_HIGH, RESET_ROUND,
};

impl ManagedDrive {
    /// Takes the evidence of a statusword about bit 4: see [`ControlwordEdge`].
    pub(super) fn see_edge(&mut self, feedback: DriveFeedback) {
        let before = self.feedback.map(|feedback| feedback.mode);
        let is_low = self.sent.is_some_and(|sent| sent.word & NEW_SET_POINT == 0);
        let acknowledged = feedback.mode == PROFILE_POSITION && feedback.word.set_point_acknowledge();
        self.edge = match self.edge {
            // Every way back to operation enabled is ordered with the bit low.
            _ if feedback.word.state() != DriveState::OperationEnabled => ControlwordEdge::Low,
            ControlwordEdge::Leaving => ControlwordEdge::Leaving,
            // So is every change of mode.
            _ if is_low && before.is_some_and(|before| before != feedback.mode) => ControlwordEdge::Low,
            ControlwordEdge::Raised if acknowledged => ControlwordEdge::Acknowledged,
            ControlwordEdge::Acknowledged if is_low && !acknowledged => ControlwordEdge::Low,
            edge => edge,
        };
    }

    pub(super) fn advance(&mut self, now: Tick) {
        self.now = now;
        self.step(now);
        if self.phase == DrivePhase::Homed {
            // The same output may demand a target next.
            self.step(now);
        }
        let failed = self.feedback.is_some_and(|feedback| feedback.word.state() == DriveState::Fault);
        let resettable = failed && self.phase == DrivePhase::Resting;
        self.failed_since = resettable.then(|| self.failed_since.unwrap_or(now));
    }

    fn step(&mut self, now: Tick) {
        self.phase = match self.binding.wanted(self.image) {
            DriveDemand::Nothing => DrivePhase::Resting,
            _ if matches!(self.phase, DrivePhase::Refused(_)) => self.phase,
            DriveDemand::Several(one, other) => DrivePhase::Refused(DriveInhibit::Several(one, other)),
            DriveDemand::Home => self.pursue(now, DriveGoal::Home),
            DriveDemand::HomeIfLost if self.knows_zero() => DrivePhase::Resting,
            DriveDemand::HomeIfLost => self.pursue(now, DriveGoal::Home),
            DriveDemand::Target(at) if self.knows_zero() => self.pursue(now, DriveGoal::Target(at)),
            DriveDemand::Target(at) => match &self.binding.home {
                // An endless axis is homed by an order of its own, which a person holds.
                Some(home) if self.binding.index.is_none() && home.output == self.binding.targets[at].output => {
                    self.pursue(now, DriveGoal::Home)
                }
                _ => DrivePhase::Refused(DriveInhibit::NotHomed),
            },
        };
    }

    fn pursue(&mut self, now: Tick, goal: DriveGoal) -> DrivePhase {
        let Some(feedback) = self.feedback else { return DrivePhase::Preparing(goal) };
        let state = feedback.word.state();
        if matches!(state, DriveState::Fault | DriveState::FaultReactionActive) {
            return DrivePhase::Refused(DriveInhibit::Failed);
        }
        let enabled = state == DriveState::OperationEnabled && feedback.mode == self.mode_for(goal);
        if let Some(phase) = self.on_circle(goal, feedback, enabled) {
            return phase;
        }
        match (self.phase, goal) {
            (DrivePhase::Preparing(before), _) if before == goal => self.prepared(now, goal, feedback, enabled),
            (DrivePhase::Offered(at) | DrivePhase::Moving(at), DriveGoal::Target(wanted)) if at == wanted => {
                match (enabled, self.edge) {
                    (false, _) => DrivePhase::Refused(DriveInhibit::Interrupted(feedback.word)),
                    (true, ControlwordEdge::Acknowledged) => DrivePhase::Moving(at),
                    (true, _) => self.phase,
                }
            }
            (DrivePhase::Homing { open, since }, DriveGoal::Home) => {
                if !enabled {
                    return DrivePhase::Refused(DriveInhibit::Interrupted(feedback.word));
                }
                self.home(now, feedback, open, since)
            }
            (DrivePhase::Homed, DriveGoal::Home) => DrivePhase::Homed,
            // A first order, or another one than before.
            _ => DrivePhase::Preparing(goal),
        }
    }

    /// Of an endless axis that has not been ordered to go: it is there already, or must not be ordered to.
    fn on_circle(&self, goal: DriveGoal, feedback: DriveFeedback, enabled: bool) -> Option<DrivePhase> {
        let (Some(places), DriveGoal::Target(at)) = (&self.binding.index, goal) else { return None };
        match self.phase {
            DrivePhase::Offered(under_way) | DrivePhase::Moving(under_way) if under_way == at => None,
            // One that coasts through its window is not there: it has to stand, and say so, before anything comes of it.
            DrivePhase::There if places.has(at, feedback.actual) => Some(DrivePhase::There),
            _ if places.has(at, feedback.actual) => (enabled && self.stands(feedback)).then_some(DrivePhase::There),
            _ if places.is_next(at, feedback.actual) => None,
            _ => Some(DrivePhase::Refused(DriveInhibit::NotNext { at, from: feedback.actual })),
        }
    }

    /// Whether everything is as it must be before the drive is ordered to move.
    fn prepared(&self, now: Tick, goal: DriveGoal, feedback: DriveFeedback, enabled: bool) -> DrivePhase {
        if !enabled || self.edge != ControlwordEdge::Low {
            return DrivePhase::Preparing(goal);
        }
        match (goal, self.binding.mode) {
            (DriveGoal::Target(at), DriveMode::Velocity) => DrivePhase::Moving(at),
            (DriveGoal::Target(at), DriveMode::Position) => {
                // Halted it says so when it stands. One that coasts past its place would go round for it.
                let stands = self.binding.index.is_none() || self.stands(feedback);
                let ready = stands && !feedback.word.set_point_acknowledge() && self.slow_or_fast(at).is_none();
                if ready { DrivePhase::Offered(at) } else { DrivePhase::Preparing(goal) }
            }
            (DriveGoal::Home, _) => DrivePhase::Homing { open: !feedback.word.homing_attained(), since: now },
        }
    }

    /// Whether the drive reports standstill, which it does only after an order to halt.
    fn stands(&self, feedback: DriveFeedback) -> bool {
        self.sent.is_some_and(|sent| sent.word & HALT != 0) && feedback.word.target_reached()
    }

    fn home(&mut self, now: Tick, feedback: DriveFeedback, open: bool, since: Tick) -> DrivePhase {
        let word = feedback.word;
        let open = open || !word.homing_attained();
        if word.homing_error() {
            self.homed = false;
            return DrivePhase::Refused(DriveInhibit::HomingFailed);
        }
        let new = open || now.since(since) >= HOMING_SETTLE;
        if word.homing_attained() && word.target_reached() && new {
            self.homed = true;
            return DrivePhase::Homed;
        }
        DrivePhase::Homing { open, since }
    }

    /// The profile velocity that has to be written before the drive goes to this target.
    pub(super) fn slow_or_fast(&self, at: usize) -> Option<u32> {
        let wanted = self.binding.targets[at].velocity;
        (self.binding.mode == DriveMode::Position && self.velocity != Some(wanted)).then_some(wanted)
    }

    pub(super) fn mode_for(&self, goal: DriveGoal) -> i8 {
        match goal {
            DriveGoal::Target(_) => self.binding.profile(),
            DriveGoal::Home => HOMING,
        }
    }

    /// The word for the present phase.
    pub(super) fn command(&self) -> DriveCommand {
        let mode = self.sent.map_or(self.binding.profile(), |sent| sent.mode);
        let immediately = match self.binding.mode {
            DriveMode::Position => CHANGE_IMMEDIATELY,
            DriveMode::Velocity => 0,
        };
        let to = |at: usize| self.binding.targets[at].to;
        let profile = self.binding.profile();
        match self.phase {
            DrivePhase::Resting | DrivePhase::There | DrivePhase::Refused(_) => {
                DriveCommand { word: self.rest_word(), mode, target: self.rest_target() }
            }
            DrivePhase::Preparing(goal) => self.prepare(goal, mode),
            DrivePhase::Offered(at) => {
                DriveCommand { word: ENABLE_OPERATION | NEW_SET_POINT | immediately, mode: profile, target: to(at) }
            }
            DrivePhase::Moving(at) => {
                DriveCommand { word: ENABLE_OPERATION | immediately, mode: profile, target: to(at) }
            }
            DrivePhase::Homing { .. } => {
                DriveCommand { word: ENABLE_OPERATION | HOMING_START, mode: HOMING, target: self.rest_target() }
            }
            DrivePhase::Homed => {
                DriveCommand { word: ENABLE_OPERATION | HALT, mode: HOMING, target: self.rest_target() }
            }
        }
    }

    /// The one target that moves nothing: no velocity. A position is not taken without its edge; it is left as it was.
    fn rest_target(&self) -> i32 {
        match self.binding.mode {
            DriveMode::Velocity => 0,
            DriveMode::Position => self.sent.map_or(0, |sent| sent.target),
        }
    }

    fn rest_word(&self) -> u16 {
        let state = self.feedback.map(|feedback| feedback.word.state());
        match (state, self.binding.at_rest) {
            (Some(DriveState::Fault), _) => match self.failed_since {
                Some(since) if RESET_HIGH.contains(&self.round_time(since)) => FAULT_RESET,
                _ => DISABLE_VOLTAGE,
            },
            (Some(DriveState::OperationEnabled), AtRest::Hold) => ENABLE_OPERATION | HALT,
            _ => QUICK_STOP,
        }
    }

    fn round_time(&self, since: Tick) -> std::time::Duration {
        let micros = self.now.since(since).as_micros() % RESET_ROUND.as_micros();
        std::time::Duration::from_micros(micros as u64)
    }

    /// The next step towards operation enabled, in the mode of `goal`, with bit 4 low and halt set.
    fn prepare(&self, goal: DriveGoal, sent_mode: i8) -> DriveCommand {
        let target = match goal {
            DriveGoal::Target(at) if self.binding.mode == DriveMode::Position => self.binding.targets[at].to,
            _ => self.rest_target(),
        };
        let Some(feedback) = self.feedback else { return DriveCommand { word: QUICK_STOP, mode: sent_mode, target } };
        let state = feedback.word.state();
        let wanted = self.mode_for(goal);
        // A mode is not changed under a drive that may still be moving.
        let known = [PROFILE_POSITION, PROFILE_VELOCITY, HOMING].contains(&feedback.mode);
        let stands = !matches!(state, DriveState::OperationEnabled | DriveState::QuickStopActive)
            || feedback.word.target_reached();
        let mode = if stands || !known { wanted } else { feedback.mode };
        let word = match (state, self.binding.at_rest) {
            (DriveState::SwitchOnDisabled, _) => SHUTDOWN,
            (DriveState::ReadyToSwitchOn, _) => SWITCH_ON,
            (DriveState::SwitchedOn, _) | (DriveState::QuickStopActive, AtRest::Hold) => ENABLE_OPERATION | HALT,
            (DriveState::OperationEnabled, at_rest) => {
                // Nothing shows whether it has seen bit 4 low: it has to leave this state, for that shows it.
                let unclear = match self.edge {
                    ControlwordEdge::Leaving => true,
                    ControlwordEdge::Raised => feedback.mode == wanted,
                    ControlwordEdge::Low | ControlwordEdge::Acknowledged => false,
                };
                match (unclear, at_rest) {
                    (false, _) => ENABLE_OPERATION | HALT,
                    (true, AtRest::Hold) => DISABLE_OPERATION,
                    (true, AtRest::Off) => QUICK_STOP,
                }
            }
            _ => QUICK_STOP,
        };
        DriveCommand { word, mode, target }
    }
}
