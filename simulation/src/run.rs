//! A run from switching on to its end.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, Tick};

use crate::condition::{ScenarioCondition, StationCondition};
use crate::error::StartError;
use crate::options::SimOptions;
use crate::script::{Script, ScriptAction, ScriptFailure, ScriptPlayer, ScriptStep};
use crate::sim::LineSim;

/// Goal of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunGoal {
    /// Cycles of the line.
    pub cycles: usize,
    /// Give start and auto first.
    pub starts: bool,
    /// And this to its end.
    pub script: Script,
}

impl RunGoal {
    /// Start, auto, and `cycles` cycles.
    pub fn cycles(cycles: usize) -> Self {
        RunGoal { cycles, starts: true, script: Script::default() }
    }
}

/// End of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEnd {
    /// Its goal is reached.
    Done,
    /// A conflict of the description happened, or drives both ways of an axis came on at once: see [`LineSim::conflicts`].
    Conflict,
    /// A station lost or doubled a cycle: see [`crate::RunRecord::errors`].
    Miscounted,
    /// Nothing has happened for so long that nothing will. With what each station waits for.
    Stuck(Vec<String>),
    /// A step of the scenario failed; from 0, not counting start and auto. `None` is start and auto themselves.
    Failed {
        step: Option<usize>,
        /// Reason of the failure.
        why: String,
    },
    /// Something happens again and again and no time passes: a bug.
    Spins,
}

/// Events at one moment that no line needs.
const SPIN_MAX: u32 = 1_000_000;
/// No line needs longer, beyond twice its longest watchdog and some messages, to do the next thing.
const PATIENCE: Duration = Duration::from_secs(10);
/// Messages that may follow each other before a station has an event: a mode is ordered, acknowledged and put in force;
/// a withdrawal is announced, agreed to and done.
const MESSAGES_IN_A_ROW: u32 = 4;

/// Runs a line towards a goal.
///
/// # Errors
/// When the line cannot be started.
pub fn run(line: &Line, options: SimOptions, goal: &RunGoal) -> Result<(LineSim, RunEnd), StartError> {
    let mut sim = LineSim::new(line, options)?;
    let end = sim.run(goal);
    Ok((sim, end))
}

impl LineSim {
    /// Runs towards a goal.
    pub fn run(&mut self, goal: &RunGoal) -> RunEnd {
        let opening = if goal.starts { opening() } else { Vec::new() };
        let skipped = opening.len();
        let steps = opening.into_iter().chain(goal.script.steps.iter().cloned()).collect();
        let mut player = ScriptPlayer::new(Script { steps });
        let watchdogs = longest_watchdog(self.line()) * 2;
        let (mut spins, mut last) = (0, self.now());
        loop {
            if !player.is_done()
                && let Err(ScriptFailure { step, why }) = player.play(self)
            {
                return RunEnd::Failed { step: step.checked_sub(skipped), why };
            }
            if player.is_done() && self.record().cycles() >= goal.cycles {
                return RunEnd::Done;
            }
            let deadline = player.deadline(self.now());
            let next = self.next_event();
            let network = self.options.network;
            let patience = PATIENCE + watchdogs + (network.delay + network.jitter) * MESSAGES_IN_A_ROW;
            if next.min(deadline) > self.last_event.max(self.waited_for(deadline)) + patience {
                return self.stuck(&player, skipped);
            }
            if deadline <= next {
                self.now = deadline.max(self.now);
            } else {
                self.step();
            }
            if !self.conflicts().is_empty() || self.alarms() > 0 {
                return RunEnd::Conflict;
            }
            if !self.record().errors().is_empty() {
                return RunEnd::Miscounted;
            }
            spins = if self.now() == last { spins + 1 } else { 0 };
            last = self.now();
            if spins > SPIN_MAX {
                return RunEnd::Spins;
            }
        }
    }

    /// A scenario that waits for a time is no reason to give up before that.
    fn waited_for(&self, deadline: Tick) -> Tick {
        if deadline == Tick::NEVER { Tick::ZERO } else { deadline }
    }

    fn stuck(&self, player: &ScriptPlayer, skipped: usize) -> RunEnd {
        if !player.is_done() {
            let why = format!("waited in vain until {}; {}", self.now(), self.reasons().join("; "));
            return RunEnd::Failed { step: player.step().checked_sub(skipped), why };
        }
        RunEnd::Stuck(self.reasons())
    }

    /// Mode of the line and the coordinator's text when it was entered; then, for each station that does not move, what
    /// it waits for, in words.
    pub fn reasons(&self) -> Vec<String> {
        let (since, why) = &self.entered;
        let mode = format!("the line is in {} since {since}", if why.is_empty() { self.mode().name() } else { why });
        let station = |id: linewright_line::StationId| {
            let name = &self.line().station(id).name;
            let Some(controller) = self.controller(id) else { return Some(format!("{name} is down")) };
            let reasons = controller.blocked_by(self.line(), self.now());
            (!reasons.is_empty()).then(|| format!("{name} waits for {}", reasons.join("; ")))
        };
        [mode].into_iter().chain(self.line().station_ids().filter_map(station)).collect()
    }
}

fn longest_watchdog(line: &Line) -> Duration {
    let all = line.stations.iter().flat_map(|station| &station.operations);
    let longest = |operation: &linewright_line::Operation| match &operation.module {
        linewright_line::OperationModule::Reversible { recovery_watchdog, .. } => {
            operation.watchdog.max(*recovery_watchdog)
        }
        linewright_line::OperationModule::Irreversible { .. } => operation.watchdog,
    };
    all.map(longest).max().unwrap_or_default()
}

/// Start as soon as all stations are received, then auto.
fn opening() -> Vec<ScriptStep> {
    let step = |when: ScenarioCondition, command: ModeCommand| ScriptStep {
        at: None,
        when: Some(when),
        after: Duration::ZERO,
        deed: ScriptAction::Order(command),
        expect: None,
        expect_text: String::new(),
        span: 0..0,
    };
    vec![
        step(ScenarioCondition::Every(StationCondition::Heard), ModeCommand::Start),
        step(ScenarioCondition::Mode(ControlMode::StandBy), ModeCommand::Auto),
    ]
}
