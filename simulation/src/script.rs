//! A scenario as it is played: steps one after the other, each when its moment has come.
//!
//! A step waits for a time, for a condition, or for both, in this order, and then for a delay; it then does its action
//! and checks what it expects. A command that is refused is given again for a while, as people do; a jog holds a panel
//! button until the motion it began has ended.

use std::ops::Range;
use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{StationId, Tick};

use crate::condition::ScenarioCondition;
use crate::operator::OperatorAction;
use crate::sim::LineSim;

/// Action of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum ScriptAction {
    /// Nothing: it waits, or expects.
    Nothing,
    /// This, at once.
    Act(OperatorAction),
    /// A command that must be obeyed in the end.
    Order(ModeCommand),
    /// A command that must be refused.
    Refused(ModeCommand),
    /// Holds a panel button until the motion it began has ended; advance rather than return.
    Jog(StationId, bool),
    /// Holds a panel button for a time.
    Press(StationId, bool, Duration),
}

/// A step of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptStep {
    /// Not before this time.
    pub at: Option<Tick>,
    /// Not before this holds.
    pub when: Option<ScenarioCondition>,
    /// This much later still.
    pub after: Duration,
    /// Action.
    pub deed: ScriptAction,
    /// Condition that must hold when it is done.
    pub expect: Option<ScenarioCondition>,
    /// The same in words.
    pub expect_text: String,
    /// Its place in the text.
    pub span: Range<usize>,
}

/// Steps in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    pub steps: Vec<ScriptStep>,
}

/// Reason why a scenario could not be played to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptFailure {
    /// The step, from 0.
    pub step: usize,
    /// Reason, in words.
    pub why: String,
}

/// Time for which a refused command is repeated, and the period; beyond the time that messages take.
const PATIENCE: Duration = Duration::from_secs(5);
const AGAIN: Duration = Duration::from_millis(100);
/// A press that moves nothing for this long will not.
const PRESS_PATIENCE: Duration = Duration::from_secs(2);

#[derive(Clone, Debug)]
enum ScriptPhase {
    /// For its time and its condition.
    Waits,
    Delayed(Tick),
    /// For an answer to its command, first given then; given again at the second.
    Asked {
        since: Tick,
        again: Tick,
        answers: usize,
    },
    /// For the motion that a held button begins.
    Jogs {
        since: Tick,
        begun: bool,
        before: usize,
    },
    /// Until a button goes up.
    Holds(Tick),
}

/// Plays a script.
#[derive(Clone, Debug)]
pub(crate) struct ScriptPlayer {
    script: Script,
    at: usize,
    phase: ScriptPhase,
}

impl ScriptPlayer {
    pub(crate) fn new(script: Script) -> Self {
        ScriptPlayer { script, at: 0, phase: ScriptPhase::Waits }
    }

    pub(crate) fn is_done(&self) -> bool {
        self.at == self.script.steps.len()
    }

    /// The step that is waited for, from 0.
    pub(crate) fn step(&self) -> usize {
        self.at
    }

    /// Time at which it is played next, whatever happens.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        let Some(step) = self.script.steps.get(self.at) else { return Tick::NEVER };
        match self.phase {
            ScriptPhase::Waits => step.at.filter(|at| *at > now).unwrap_or(Tick::NEVER),
            ScriptPhase::Delayed(at) | ScriptPhase::Holds(at) | ScriptPhase::Asked { again: at, .. } => at,
            ScriptPhase::Jogs { since, .. } => since + PRESS_PATIENCE,
        }
    }

    /// Goes as far as it can now.
    pub(crate) fn play(&mut self, sim: &mut LineSim) -> Result<(), ScriptFailure> {
        while !self.is_done() && self.advance(sim).map_err(|why| ScriptFailure { step: self.at, why })? {}
        Ok(())
    }

    fn advance(&mut self, sim: &mut LineSim) -> Result<bool, String> {
        let now = sim.now();
        let step = &self.script.steps[self.at];
        match self.phase {
            ScriptPhase::Waits => {
                if step.at.is_some_and(|at| now < at) || step.when.as_ref().is_some_and(|when| !when.holds(sim)) {
                    return Ok(false);
                }
                self.phase = ScriptPhase::Delayed(now + step.after);
                Ok(true)
            }
            ScriptPhase::Delayed(at) if now < at => Ok(false),
            ScriptPhase::Delayed(_) => {
                let deed = step.deed.clone();
                self.begin(sim, deed)
            }
            ScriptPhase::Asked { since, again, answers } => self.asked(sim, since, again, answers),
            ScriptPhase::Jogs { since, begun, before } => self.jogs(sim, since, begun, before),
            ScriptPhase::Holds(at) if now < at => Ok(false),
            ScriptPhase::Holds(_) => {
                if let ScriptAction::Press(station, advance, _) = step.deed {
                    act(sim, OperatorAction::Panel { station, advance, down: false })?;
                }
                self.finish(sim)
            }
        }
    }

    fn begin(&mut self, sim: &mut LineSim, deed: ScriptAction) -> Result<bool, String> {
        let now = sim.now();
        match deed {
            ScriptAction::Nothing => return self.finish(sim),
            ScriptAction::Act(action) => {
                if let Some(why) = sim.idle(&action) {
                    return Err(why);
                }
                act(sim, action)?;
                return self.finish(sim);
            }
            ScriptAction::Order(command) | ScriptAction::Refused(command) => {
                self.phase = ScriptPhase::Asked { since: now, again: now + again(sim), answers: sim.answers.len() };
                act(sim, OperatorAction::Command(command))?;
            }
            ScriptAction::Jog(station, advance) => {
                self.phase = ScriptPhase::Jogs { since: now, begun: false, before: sim.record().begun(station) };
                act(sim, OperatorAction::Panel { station, advance, down: true })?;
            }
            ScriptAction::Press(station, advance, time) => {
                self.phase = ScriptPhase::Holds(now + time);
                act(sim, OperatorAction::Panel { station, advance, down: true })?;
            }
        }
        Ok(true)
    }

    fn asked(&mut self, sim: &mut LineSim, since: Tick, at: Tick, answers: usize) -> Result<bool, String> {
        let now = sim.now();
        let (command, wants) = match self.script.steps[self.at].deed {
            ScriptAction::Order(command) => (command, true),
            ScriptAction::Refused(command) => (command, false),
            ScriptAction::Nothing | ScriptAction::Act(_) | ScriptAction::Jog(..) | ScriptAction::Press(..) => {
                return self.finish(sim);
            }
        };
        let patience = PATIENCE + again(sim);
        let answer = sim.answers[answers..].iter().find(|answer| answer.command == command).cloned();
        match answer {
            Some(answer) if answer.refusal.is_none() == wants => return self.finish(sim),
            Some(_) if !wants => return Err(format!("{} was obeyed", command.name())),
            _ if now < at => return Ok(false),
            Some(answer) if now.since(since) >= patience => {
                let text = answer.refusal.map(|refusal| refusal.text(sim.line())).unwrap_or_default();
                return Err(format!("not obeyed: {text}"));
            }
            None if now.since(since) >= patience => return Err(format!("{}: no answer", command.name())),
            Some(_) | None => {}
        }
        self.phase = ScriptPhase::Asked { since, again: now + again(sim), answers: sim.answers.len() };
        act(sim, OperatorAction::Command(command))?;
        Ok(true)
    }

    fn jogs(&mut self, sim: &mut LineSim, since: Tick, begun: bool, before: usize) -> Result<bool, String> {
        let ScriptAction::Jog(station, advance) = self.script.steps[self.at].deed else { return self.finish(sim) };
        let begun = begun || sim.record().begun(station) > before;
        self.phase = ScriptPhase::Jogs { since, begun, before };
        let moves = sim.controller(station).is_some_and(|c| c.marking().any(|place| place.is_operating()));
        let waits = !begun && sim.now().since(since) < PRESS_PATIENCE;
        if waits || (begun && moves) {
            // Once it moves, its end is an event; the watchdog sees to it that there is one.
            if begun {
                self.phase = ScriptPhase::Jogs { since: sim.now(), begun, before };
            }
            return Ok(false);
        }
        act(sim, OperatorAction::Panel { station, advance, down: false })?;
        if !begun {
            let reasons = sim.controller(station).map(|c| c.blocked_by(sim.line(), sim.now())).unwrap_or_default();
            let name = &sim.line().station(station).name;
            return Err(format!("nothing of {name} moved; it waits for {}", reasons.join("; ")));
        }
        self.finish(sim)
    }

    fn finish(&mut self, sim: &mut LineSim) -> Result<bool, String> {
        let step = &self.script.steps[self.at];
        if let Some(expected) = &step.expect
            && !expected.holds(sim)
        {
            return Err(format!("expected {}, which does not hold at {}", step.expect_text, sim.now()));
        }
        self.at += 1;
        self.phase = ScriptPhase::Waits;
        sim.answers.clear();
        Ok(true)
    }
}

/// Time before a repetition, so that the first message can have been received.
fn again(sim: &LineSim) -> Duration {
    AGAIN + sim.options.network.delay + sim.options.network.jitter
}

fn act(sim: &mut LineSim, action: OperatorAction) -> Result<(), String> {
    sim.act(action).map_err(|error| error.to_string())
}
