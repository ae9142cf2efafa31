//! From what is wanted and what the drive says to what it is told next.
//!
//! `advance` moves the phase, on evidence from the drive alone: what was sent proves nothing. `command` is the word for
//! a phase.

use linewright_line::{AtRest, DriveMode, Tick};

use super::binding::Wanted;
use super::word::{
    CHANGE_IMMEDIATELY, DISABLE_OPERATION, DISABLE_VOLTAGE, ENABLE_OPERATION, FAULT_RESET, HALT, HOMING, HOMING_START,
    NEW_SET_POINT, PROFILE_POSITION, PROFILE_VELOCITY, QUICK_STOP, SHUTDOWN, SWITCH_ON,
};
use super::{Command, Drive, Edge, Goal, HOMING_SETTLE, Heard, Phase, RESET_HIGH, RESET_ROUND, Refusal, State};

impl Drive {
    /// What a statusword proves about bit 4: see [`Edge`].
    pub(super) fn see_edge(&mut self, heard: Heard) {
        let before = self.heard.map(|heard| heard.mode);
        let is_low = self.sent.is_some_and(|sent| sent.word & NEW_SET_POINT == 0);
        let acknowledged = heard.mode == PROFILE_POSITION && heard.word.set_point_acknowledge();
        self.edge = match self.edge {
            // Every way back to operation enabled is ordered with the bit low.
            _ if heard.word.state() != State::OperationEnabled => Edge::Low,
            Edge::Leaving => Edge::Leaving,
            // So is every change of mode.
            _ if is_low && before.is_some_and(|before| before != heard.mode) => Edge::Low,
            Edge::Raised if acknowledged => Edge::Acknowledged,
            Edge::Acknowledged if is_low && !acknowledged => Edge::Low,
            edge => edge,
        };
    }

    pub(super) fn advance(&mut self, now: Tick) {
        self.now = now;
        self.step(now);
        if self.phase == Phase::Homed {
            // The same output may want a target next.
            self.step(now);
        }
        let failed = self.heard.is_some_and(|heard| heard.word.state() == State::Fault);
        let resettable = failed && self.phase == Phase::Resting;
        self.failed_since = resettable.then(|| self.failed_since.unwrap_or(now));
    }

    fn step(&mut self, now: Tick) {
        self.phase = match self.binding.wanted(self.image) {
            Wanted::Nothing => Phase::Resting,
            _ if matches!(self.phase, Phase::Refused(_)) => self.phase,
            Wanted::Several(one, other) => Phase::Refused(Refusal::Several(one, other)),
            Wanted::Home => self.pursue(now, Goal::Home),
            Wanted::Target(at) if self.knows_zero() => self.pursue(now, Goal::Target(at)),
            Wanted::Target(at) => match &self.binding.home {
                Some(home) if home.output == self.binding.targets[at].output => self.pursue(now, Goal::Home),
                _ => Phase::Refused(Refusal::NotHomed),
            },
        };
    }

    fn pursue(&mut self, now: Tick, goal: Goal) -> Phase {
        let Some(heard) = self.heard else { return Phase::Preparing(goal) };
        let state = heard.word.state();
        if matches!(state, State::Fault | State::FaultReactionActive) {
            return Phase::Refused(Refusal::Failed);
        }
        let enabled = state == State::OperationEnabled && heard.mode == self.mode_for(goal);
        match (self.phase, goal) {
            (Phase::Preparing(before), _) if before == goal => self.prepared(now, goal, heard, enabled),
            (Phase::Offered(at) | Phase::Moving(at), Goal::Target(wanted)) if at == wanted => {
                match (enabled, self.edge) {
                    (false, _) => Phase::Refused(Refusal::Interrupted(heard.word)),
                    (true, Edge::Acknowledged) => Phase::Moving(at),
                    (true, _) => self.phase,
                }
            }
            (Phase::Homing { open, since }, Goal::Home) => {
                if !enabled {
                    return Phase::Refused(Refusal::Interrupted(heard.word));
                }
                self.home(now, heard, open, since)
            }
            (Phase::Homed, Goal::Home) => Phase::Homed,
            // A first order, or another one than before.
            _ => Phase::Preparing(goal),
        }
    }

    /// Whether everything is as it must be before the drive is told to move.
    fn prepared(&self, now: Tick, goal: Goal, heard: Heard, enabled: bool) -> Phase {
        if !enabled || self.edge != Edge::Low {
            return Phase::Preparing(goal);
        }
        match (goal, self.binding.mode) {
            (Goal::Target(at), DriveMode::Velocity) => Phase::Moving(at),
            (Goal::Target(at), DriveMode::Position) => {
                let ready = !heard.word.set_point_acknowledge() && self.slow_or_fast(at).is_none();
                if ready { Phase::Offered(at) } else { Phase::Preparing(goal) }
            }
            (Goal::Home, _) => Phase::Homing { open: !heard.word.homing_attained(), since: now },
        }
    }

    fn home(&mut self, now: Tick, heard: Heard, open: bool, since: Tick) -> Phase {
        let word = heard.word;
        let open = open || !word.homing_attained();
        if word.homing_error() {
            self.homed = false;
            return Phase::Refused(Refusal::HomingFailed);
        }
        let new = open || now.since(since) >= HOMING_SETTLE;
        if word.homing_attained() && word.target_reached() && new {
            self.homed = true;
            return Phase::Homed;
        }
        Phase::Homing { open, since }
    }

    /// The profile velocity that has to be written before the drive goes to this target.
    pub(super) fn slow_or_fast(&self, at: usize) -> Option<u32> {
        let wanted = self.binding.targets[at].velocity;
        (self.binding.mode == DriveMode::Position && self.velocity != Some(wanted)).then_some(wanted)
    }

    pub(super) fn mode_for(&self, goal: Goal) -> i8 {
        match goal {
            Goal::Target(_) => self.binding.profile(),
            Goal::Home => HOMING,
        }
    }

    /// The word for the present phase.
    pub(super) fn command(&self) -> Command {
        let mode = self.sent.map_or(self.binding.profile(), |sent| sent.mode);
        let immediately = match self.binding.mode {
            DriveMode::Position => CHANGE_IMMEDIATELY,
            DriveMode::Velocity => 0,
        };
        let to = |at: usize| self.binding.targets[at].to;
        let profile = self.binding.profile();
        match self.phase {
            Phase::Resting | Phase::Refused(_) => Command { word: self.rest_word(), mode, target: self.rest_target() },
            Phase::Preparing(goal) => self.prepare(goal, mode),
            Phase::Offered(at) => {
                Command { word: ENABLE_OPERATION | NEW_SET_POINT | immediately, mode: profile, target: to(at) }
            }
            Phase::Moving(at) => Command { word: ENABLE_OPERATION | immediately, mode: profile, target: to(at) },
            Phase::Homing { .. } => {
                Command { word: ENABLE_OPERATION | HOMING_START, mode: HOMING, target: self.rest_target() }
            }
            Phase::Homed => Command { word: ENABLE_OPERATION | HALT, mode: HOMING, target: self.rest_target() },
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
        let state = self.heard.map(|heard| heard.word.state());
        match (state, self.binding.at_rest) {
            (Some(State::Fault), _) => match self.failed_since {
                Some(since) if RESET_HIGH.contains(&self.round_time(since)) => FAULT_RESET,
                _ => DISABLE_VOLTAGE,
            },
            (Some(State::OperationEnabled), AtRest::Hold) => ENABLE_OPERATION | HALT,
            _ => QUICK_STOP,
        }
    }

    fn round_time(&self, since: Tick) -> std::time::Duration {
        let micros = self.now.since(since).as_micros() % RESET_ROUND.as_micros();
        std::time::Duration::from_micros(micros as u64)
    }

    /// The next step towards operation enabled, in the mode of `goal`, with bit 4 low and halt set.
    fn prepare(&self, goal: Goal, sent_mode: i8) -> Command {
        let target = match goal {
            Goal::Target(at) if self.binding.mode == DriveMode::Position => self.binding.targets[at].to,
            _ => self.rest_target(),
        };
        let Some(heard) = self.heard else { return Command { word: QUICK_STOP, mode: sent_mode, target } };
        let state = heard.word.state();
        let wanted = self.mode_for(goal);
        // A mode is not changed under a drive that may still be moving.
        let known = [PROFILE_POSITION, PROFILE_VELOCITY, HOMING].contains(&heard.mode);
        let stands = !matches!(state, State::OperationEnabled | State::QuickStopActive) || heard.word.target_reached();
        let mode = if stands || !known { wanted } else { heard.mode };
        let word = match (state, self.binding.at_rest) {
            (State::SwitchOnDisabled, _) => SHUTDOWN,
            (State::ReadyToSwitchOn, _) => SWITCH_ON,
            (State::SwitchedOn, _) | (State::QuickStopActive, AtRest::Hold) => ENABLE_OPERATION | HALT,
            (State::OperationEnabled, at_rest) => {
                // Nothing shows whether it has seen bit 4 low: it has to leave this state, for that shows it.
                let unclear = match self.edge {
                    Edge::Leaving => true,
                    Edge::Raised => heard.mode == wanted,
                    Edge::Low | Edge::Acknowledged => false,
                };
                match (unclear, at_rest) {
                    (false, _) => ENABLE_OPERATION | HALT,
                    (true, AtRest::Hold) => DISABLE_OPERATION,
                    (true, AtRest::Off) => QUICK_STOP,
                }
            }
            _ => QUICK_STOP,
        };
        Command { word, mode, target }
    }
}
