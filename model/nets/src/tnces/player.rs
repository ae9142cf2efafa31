//! One run of a system: a token player with a clock of its own, for a simulated plant.
//!
//! The time is an argument; the player reads no clock. Where several transitions could fire at one instant it takes the
//! one with the lowest number, and of its maximal steps the first, so that a run is determined by the system, the policy
//! and the calls.

use std::borrow::Borrow;

use thiserror::Error;

use super::engine::Engine;
use super::{TimedState, Tnces};
use crate::{FireError, Marking, NamedId, PlaceId, TransitionId};

/// Time at which the player fires transitions that need not fire at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Policy {
    /// As soon as the intervals allow.
    #[default]
    Soonest,
    /// When no more time may pass; what may wait for ever is left to [`TncesPlayer::fire`].
    WhenDue,
}

/// A step that has been fired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FiredStep {
    /// Time of firing, in units of the net.
    pub time: u64,
    /// The spontaneous transition, then what it forced.
    pub step: Box<[TransitionId]>,
}

/// Reason why a transition does not fire now. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotEnabled {
    /// Only other transitions make it fire.
    #[error("{transition} fires only when it is forced")]
    Forced { transition: NamedId<TransitionId> },
    /// Too few tokens, or too many to count.
    #[error(transparent)]
    Tokens(#[from] FireError),
    /// A condition does not hold.
    #[error("{transition} waits for {place}: it has {has} of the {needs} tokens needed")]
    Condition {
        transition: NamedId<TransitionId>,
        place: NamedId<PlaceId>,
        /// Tokens on the place.
        has: u32,
        needs: u32,
    },
    /// Its time has not come.
    #[error("{transition} can fire from time {from} on; it is {now}")]
    Early {
        transition: NamedId<TransitionId>,
        /// The first instant at which it can, if nothing else happens.
        from: u64,
        /// The time.
        now: u64,
    },
    /// Its time has passed.
    #[error("{transition} could have fired before time {now}; its tokens are too old now")]
    Late {
        transition: NamedId<TransitionId>,
        /// The time.
        now: u64,
    },
}

/// A run went on for more steps than allowed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Restless {
    /// The bound was met; what has been fired is done, and the run can be continued.
    #[error("stopped at time {time} after {} steps, the most allowed", fired.len())]
    Limit {
        /// Where the run stands.
        time: u64,
        /// Steps fired.
        fired: Vec<FiredStep>,
    },
    /// A place would hold more tokens than can be counted.
    #[error("stopped at time {time}: {error}")]
    Overflow {
        /// Where the run stands.
        time: u64,
        /// Cause.
        error: FireError,
        /// Steps fired.
        fired: Vec<FiredStep>,
    },
}

/// One run. `T` is a [`Tnces`], a reference to one, or an `Arc`.
#[derive(Clone, Debug)]
pub struct TncesPlayer<T> {
    engine: Engine<T>,
    state: TimedState,
    now: u64,
    policy: Policy,
}

impl<T: Borrow<Tnces>> TncesPlayer<T> {
    /// At time 0, in the initial state.
    pub fn new(system: T, policy: Policy) -> Self {
        let engine = Engine::new(system, Some(1));
        TncesPlayer { state: engine.initial(), engine, now: 0, policy }
    }

    /// The system that is played.
    pub fn system(&self) -> &Tnces {
        self.engine.system()
    }

    /// The time.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Where the tokens are.
    pub fn marking(&self) -> &Marking {
        self.state.marking()
    }

    /// Every step that is possible now, those of external transitions among them.
    pub fn steps(&self) -> Vec<Box<[TransitionId]>> {
        self.engine.steps(&self.state)
    }

    /// When [`TncesPlayer::advance`] fires next, if nothing is fired by hand before; never earlier than now.
    pub fn next_time(&self) -> Option<u64> {
        self.next().map(|(delay, _)| self.now.saturating_add(u64::from(delay)))
    }

    /// Fires a spontaneous transition now, and what it forces.
    pub fn fire(&mut self, transition: TransitionId) -> Result<FiredStep, NotEnabled> {
        self.admit(transition)?;
        let steps = self.engine.steps_of(&self.state, transition);
        let step = steps.into_iter().next().expect("a ripe transition has a step");
        self.state = self.engine.fire(&self.state, &step)?;
        Ok(FiredStep { time: self.now, step })
    }

    /// Lets time pass until `until`, firing what the policy fires on the way, that very instant included. At most
    /// `most` steps. A time that has passed already changes nothing but what is ripe now.
    pub fn advance(&mut self, until: u64, most: usize) -> Result<Vec<FiredStep>, Restless> {
        let mut fired = Vec::new();
        while let Some((delay, transition)) = self.next() {
            let time = self.now.saturating_add(u64::from(delay));
            if time > until.max(self.now) {
                break;
            }
            if fired.len() == most {
                return Err(Restless::Limit { time: self.now, fired });
            }
            self.wait(u64::from(delay));
            match self.fire(transition) {
                Ok(step) => fired.push(step),
                Err(NotEnabled::Tokens(error)) => return Err(Restless::Overflow { time: self.now, error, fired }),
                Err(refusal) => unreachable!("{refusal}"),
            }
        }
        self.wait(until.saturating_sub(self.now));
        Ok(fired)
    }

    /// The lowest of the transitions that fire next, and how long until then.
    fn next(&self) -> Option<(u32, TransitionId)> {
        let own = self.engine.spontaneous().iter().filter(|&&t| !self.system().is_external(t));
        let due = own.filter_map(|&t| {
            let delay = match self.policy {
                Policy::Soonest => self.engine.until_ripe(&self.state, t),
                Policy::WhenDue => self.engine.until_due(&self.state, t),
            };
            delay.map(|delay| (delay, t))
        });
        due.min()
    }

    fn wait(&mut self, delay: u64) {
        if delay > 0 {
            // Clocks stop far below 32 bits' worth of waiting more.
            self.state = self.engine.aged(&self.state, u32::try_from(delay).unwrap_or(u32::MAX));
            self.now = self.now.saturating_add(delay);
        }
    }

    fn admit(&self, t: TransitionId) -> Result<(), NotEnabled> {
        let net = self.system().net();
        let marking = self.state.marking();
        if self.system().is_forced(t) {
            return Err(NotEnabled::Forced { transition: net.transition(t) });
        }
        if let Some(&(place, needs)) = net.preset(t).iter().find(|&&(place, needs)| marking.tokens(place) < needs) {
            let (transition, has) = (net.transition(t), marking.tokens(place));
            return Err(FireError::Lacking { transition, place: net.place(place), has, needs }.into());
        }
        let lacking = |&&(place, needs): &&(PlaceId, u32)| marking.tokens(place) < needs;
        if let Some(&(place, needs)) = self.system().conditions(t).iter().find(lacking) {
            let (transition, has) = (net.transition(t), marking.tokens(place));
            return Err(NotEnabled::Condition { transition, place: net.place(place), has, needs });
        }
        match self.engine.until_ripe(&self.state, t) {
            Some(0) => Ok(()),
            Some(delay) => {
                let from = self.now.saturating_add(u64::from(delay));
                Err(NotEnabled::Early { transition: net.transition(t), from, now: self.now })
            }
            None => Err(NotEnabled::Late { transition: net.transition(t), now: self.now }),
        }
    }
}
