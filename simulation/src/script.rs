//! A scenario as it is played: steps one after the other, each when its moment has come.
//!
//! A step waits for a time, for a condition, or for both, in this order, and then for a delay; it then does its action
//! and checks what it expects. A command that is refused is given again for a while, as people do; a jog holds a panel
//! button until the motion it began has ended.

use std::ops::Range;
use std::time::Duration;

use linewright_coordinator_logic::Command;
use linewright_line::{StationId, Tick};

use crate::condition::Condition;
use crate::operator::Action;
use crate::sim::Sim;

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Deed {
    /// Nothing: it waits, or expects.
    Nothing,
    /// This, at once.
    Act(Action),
    /// A command that must be obeyed in the end.
    Order(Command),
    /// A command that must be refused.
    Refused(Command),
    /// Holds a panel button until the motion it began has ended; advance rather than return.
    Jog(StationId, bool),
    /// Holds a panel button for a time.
    Press(StationId, bool, Duration),
}

/// A step of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Not before this time.
    pub at: Option<Tick>,
    /// Not before this holds.
    pub when: Option<Condition>,
    /// This much later still.
    pub after: Duration,
    /// What it does.
    pub deed: Deed,
    /// What must hold when it is done.
    pub expect: Option<Condition>,
    /// The same in words.
    pub expect_text: String,
    /// Where the text says so.
    pub span: Range<usize>,
}

/// Steps in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// The steps.
    pub steps: Vec<Step>,
}

/// Why a scenario could not be played to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Which step, from 0.
    pub step: usize,
    /// What went wrong.
    pub why: String,
}

/// For how long a refused command is given again, and how often; beyond the time that messages take.
const PATIENCE: Duration = Duration::from_secs(5);
const AGAIN: Duration = Duration::from_millis(100);
/// A press that moves nothing for this long will not.
const PRESS_PATIENCE: Duration = Duration::from_secs(2);

#[derive(Clone, Debug)]
enum Phase {
    /// For its time and its condition.
    Waits,
    /// For its delay.
    Delayed(Tick),
    /// For an answer to its command, first given then; given again at the second.
    Asked { since: Tick, again: Tick, answers: usize },
    /// For the motion that a held button begins.
    Jogs { since: Tick, begun: bool, before: usize },
    /// Until a button goes up.
    Holds(Tick),
}

/// Plays a script.
#[derive(Clone, Debug)]
pub(crate) struct Player {
    script: Script,
    at: usize,
    phase: Phase,
}

impl Player {
    pub(crate) fn new(script: Script) -> Self {
        Player { script, at: 0, phase: Phase::Waits }
    }

    pub(crate) fn is_done(&self) -> bool {
        self.at == self.script.steps.len()
    }

    /// The step that is waited for, from 0.
    pub(crate) fn step(&self) -> usize {
        self.at
    }

    /// When it wants to be played next, whatever happens.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        let Some(step) = self.script.steps.get(self.at) else { return Tick::NEVER };
        match self.phase {
            Phase::Waits => step.at.filter(|at| *at > now).unwrap_or(Tick::NEVER),
            Phase::Delayed(at) | Phase::Holds(at) | Phase::Asked { again: at, .. } => at,
            Phase::Jogs { since, .. } => since + PRESS_PATIENCE,
        }
    }

    /// Goes as far as it can now.
    pub(crate) fn play(&mut self, sim: &mut Sim) -> Result<(), Failure> {
        while !self.is_done() && self.advance(sim).map_err(|why| Failure { step: self.at, why })? {}
        Ok(())
    }

    fn advance(&mut self, sim: &mut Sim) -> Result<bool, String> {
        let now = sim.now();
        let step = &self.script.steps[self.at];
        match self.phase {
            Phase::Waits => {
                if step.at.is_some_and(|at| now < at) || step.when.as_ref().is_some_and(|when| !when.holds(sim)) {
                    return Ok(false);
                }
                self.phase = Phase::Delayed(now + step.after);
                Ok(true)
            }
            Phase::Delayed(at) if now < at => Ok(false),
            Phase::Delayed(_) => {
                let deed = step.deed.clone();
                self.begin(sim, deed)
            }
            Phase::Asked { since, again, answers } => self.asked(sim, since, again, answers),
            Phase::Jogs { since, begun, before } => self.jogs(sim, since, begun, before),
            Phase::Holds(at) if now < at => Ok(false),
            Phase::Holds(_) => {
                if let Deed::Press(station, advance, _) = step.deed {
                    act(sim, Action::Panel { station, advance, down: false })?;
                }
                self.finish(sim)
            }
        }
    }

    fn begin(&mut self, sim: &mut Sim, deed: Deed) -> Result<bool, String> {
        let now = sim.now();
        match deed {
            Deed::Nothing => return self.finish(sim),
            Deed::Act(action) => {
                if let Some(why) = sim.idle(&action) {
                    return Err(why);
                }
                act(sim, action)?;
                return self.finish(sim);
            }
            Deed::Order(command) | Deed::Refused(command) => {
                self.phase = Phase::Asked { since: now, again: now + again(sim), answers: sim.answers.len() };
                act(sim, Action::Command(command))?;
            }
            Deed::Jog(station, advance) => {
                self.phase = Phase::Jogs { since: now, begun: false, before: sim.record().begun(station) };
                act(sim, Action::Panel { station, advance, down: true })?;
            }
            Deed::Press(station, advance, time) => {
                self.phase = Phase::Holds(now + time);
                act(sim, Action::Panel { station, advance, down: true })?;
            }
        }
        Ok(true)
    }

    fn asked(&mut self, sim: &mut Sim, since: Tick, at: Tick, answers: usize) -> Result<bool, String> {
        let now = sim.now();
        let (command, wants) = match self.script.steps[self.at].deed {
            Deed::Order(command) => (command, true),
            Deed::Refused(command) => (command, false),
            Deed::Nothing | Deed::Act(_) | Deed::Jog(..) | Deed::Press(..) => return self.finish(sim),
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
        self.phase = Phase::Asked { since, again: now + again(sim), answers: sim.answers.len() };
        act(sim, Action::Command(command))?;
        Ok(true)
    }

    fn jogs(&mut self, sim: &mut Sim, since: Tick, begun: bool, before: usize) -> Result<bool, String> {
        let Deed::Jog(station, advance) = self.script.steps[self.at].deed else { return self.finish(sim) };
        let begun = begun || sim.record().begun(station) > before;
        self.phase = Phase::Jogs { since, begun, before };
        let moves = sim.controller(station).is_some_and(|c| c.marking().any(|place| place.is_operating()));
        let waits = !begun && sim.now().since(since) < PRESS_PATIENCE;
        if waits || (begun && moves) {
            // Once it moves, its end is an event; the watchdog sees to it that there is one.
            if begun {
                self.phase = Phase::Jogs { since: sim.now(), begun, before };
            }
            return Ok(false);
        }
        act(sim, Action::Panel { station, advance, down: false })?;
        if !begun {
            let reasons = sim.controller(station).map(|c| c.blocked_by(sim.line(), sim.now())).unwrap_or_default();
            let name = &sim.line().station(station).name;
            return Err(format!("nothing of {name} moved; it waits for {}", reasons.join("; ")));
        }
        self.finish(sim)
    }

    fn finish(&mut self, sim: &mut Sim) -> Result<bool, String> {
        let step = &self.script.steps[self.at];
        if let Some(expected) = &step.expect
            && !expected.holds(sim)
        {
            return Err(format!("expected {}, which does not hold at {}", step.expect_text, sim.now()));
        }
        self.at += 1;
        self.phase = Phase::Waits;
        sim.answers.clear();
        Ok(true)
    }
}

/// Nobody asks again before the first word can have been heard.
fn again(sim: &Sim) -> Duration {
    AGAIN + sim.options.network.delay + sim.options.network.jitter
}

fn act(sim: &mut Sim, action: Action) -> Result<(), String> {
    sim.act(action).map_err(|error| error.to_string())
}
