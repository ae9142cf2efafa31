//! All states of a system, without time and with it.
//!
//! Like [`crate::reach`], exploration stores each state, and stops undecided at a bound.

use std::collections::HashMap;

use super::advance::Pause;
use super::engine::Engine;
use super::graph::{GraphArc, StateGraph, StepId, TimedLabel};
use super::{TimedState, Tnces};
use crate::reach::{ReachLimit, ReachUndecided, StateId};
use crate::{FireError, Marking, TransitionId};

/// A successor: by which step, or after how many units.
enum TimedSuccessor {
    Step(Box<[TransitionId]>),
    Delay(u32),
}

impl Tnces {
    /// Every marking that conditions and events allow, with intervals left out of account: each arc is a step. What
    /// time forbids may be reachable here; what is not reachable here is not with time either, unless a forced
    /// transition has an interval, because time can then keep it out of a step.
    pub fn untimed_space(&self, limit_states: usize) -> Result<StateGraph<Marking>, ReachUndecided> {
        let engine = Engine::new(self, None);
        let graph = explore(&engine, 1, limit_states, |state, ways| {
            ways.extend(engine.steps(state).into_iter().map(TimedSuccessor::Step));
        })?;
        Ok(graph.map(|state| state.marking))
    }

    /// Every reachable marking with its clocks: each arc is a step or a delay, in multiples of [`Tnces::unit`]. Finite
    /// for a bounded net, because clocks stop at the largest bound that matters.
    ///
    /// Times in between in which nothing can fire are no states of their own. See [`Tnces::covers_continuous_time`] for
    /// the meaning of whole numbers for other times.
    pub fn timed_space(&self, limit_states: usize) -> Result<StateGraph<TimedState>, ReachUndecided> {
        let unit = self.unit();
        let engine = Engine::new(self, Some(unit));
        explore(&engine, unit, limit_states, |state, ways| {
            ways.extend(engine.steps(state).into_iter().map(TimedSuccessor::Step));
            if let Pause::Until(delay) = engine.pause(state) {
                ways.push(TimedSuccessor::Delay(delay));
            }
        })
    }
}

/// Breadth first. The limit is the number of states that is still decided.
fn explore(
    engine: &Engine<&Tnces>,
    unit: u32,
    limit_states: usize,
    ways_from: impl Fn(&TimedState, &mut Vec<TimedSuccessor>),
) -> Result<StateGraph<TimedState>, ReachUndecided> {
    let limit = limit_states.min(u32::MAX as usize);
    if limit == 0 {
        return Err(ReachUndecided { states: 0, cause: ReachLimit::Limit });
    }
    let mut states = vec![engine.initial()];
    let mut number_of = HashMap::from([(engine.initial(), StateId::INITIAL)]);
    let mut step_number: HashMap<Box<[TransitionId]>, StepId> = HashMap::new();
    let mut steps = Vec::new();
    let mut arcs = Vec::new();
    let mut ways = Vec::new();
    let mut next = 0;
    while next < states.len() {
        let here = states[next].clone();
        ways_from(&here, &mut ways);
        for way in ways.drain(..) {
            let overflow =
                |error: FireError| ReachUndecided { states: states.len(), cause: ReachLimit::Overflow(error) };
            let (label, there) = match way {
                TimedSuccessor::Delay(delay) => {
                    (TimedLabel::Delay(u64::from(delay) * u64::from(unit)), engine.aged(&here, delay))
                }
                TimedSuccessor::Step(step) => {
                    let there = engine.fire(&here, &step).map_err(overflow)?;
                    let new = StepId(step_number.len() as u32);
                    let id = *step_number.entry(step).or_insert_with_key(|step| {
                        steps.push(step.clone());
                        new
                    });
                    (TimedLabel::Step(id), there)
                }
            };
            let to = match number_of.get(&there) {
                Some(&known) => known,
                None if states.len() == limit => {
                    return Err(ReachUndecided { states: limit, cause: ReachLimit::Limit });
                }
                None => {
                    let new = StateId(states.len() as u32);
                    number_of.insert(there.clone(), new);
                    states.push(there);
                    new
                }
            };
            arcs.push(GraphArc { from: StateId(next as u32), label, to });
        }
        next += 1;
    }
    Ok(StateGraph::new(states, arcs, steps))
}
