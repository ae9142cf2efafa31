//! Possible firings in a state, and their results.
//!
//! An engine is a system with its bounds in one unit of time, or without time. It serves exploration and the player
//! alike: there is one rule of enabling and one of firing. It chooses nothing.

use std::borrow::Borrow;

use super::state::{self, AgedTokens};
use super::{ArcClock, Deadline, FiringPolicy, Interval, TimedState, Tnces};
use crate::{FireError, Marking, PlaceId, TransitionId};

/// A system ready to be played.
#[derive(Clone, Debug)]
pub(super) struct Engine<T> {
    system: T,
    /// In the engine's unit, per transition, in the order of the preset.
    intervals: Vec<Box<[Interval]>>,
    spontaneous: Vec<TransitionId>,
    /// The places with a clock, ascending, and where each stops; none in the readings with transition clocks.
    pub(super) places: Vec<(PlaceId, u32)>,
    place_slot: Vec<Option<usize>>,
    /// The transitions with a clock, ascending, and where each stops; none for token ages.
    pub(super) transitions: Vec<(TransitionId, u32)>,
    transition_slot: Vec<Option<usize>>,
    unit: Option<u32>,
}

impl<T: Borrow<Tnces>> Engine<T> {
    /// With all bounds divided by `unit`, or without time.
    pub(super) fn new(system: T, unit: Option<u32>) -> Self {
        let sys: &Tnces = system.borrow();
        let scale = |interval: &Interval| match unit {
            None => Interval::ANY,
            Some(unit) => Interval { earliest: interval.earliest / unit, latest: interval.latest.map(|dl| dl / unit) },
        };
        let intervals: Vec<Box<[Interval]>> =
            sys.rows.iter().map(|row| row.intervals.iter().map(scale).collect()).collect();
        let horizon = |t: TransitionId| intervals[t.index()].iter().map(|i| i.horizon()).max().unwrap_or(0);
        let of_place = |p: PlaceId| {
            let bound = |&(t, _): &(TransitionId, u32)| {
                let at = sys.net.preset(t).binary_search_by_key(&p, |&(place, _)| place);
                at.map_or(0, |at| intervals[t.index()][at].horizon())
            };
            sys.net.consumers(p).iter().map(bound).max().unwrap_or(0)
        };
        let (mut places, mut transitions) = (Vec::new(), Vec::new());
        if sys.counts_tokens() {
            places = sys.net.places().map(|p| (p, of_place(p))).filter(|&(_, cap)| cap > 0).collect();
        } else {
            transitions = sys.net.transitions().map(|t| (t, horizon(t))).filter(|&(_, cap)| cap > 0).collect();
        }
        let mut place_slot = vec![None; sys.net.place_count()];
        places.iter().enumerate().for_each(|(slot, (p, _))| place_slot[p.index()] = Some(slot));
        let mut transition_slot = vec![None; sys.net.transition_count()];
        transitions.iter().enumerate().for_each(|(slot, (t, _))| transition_slot[t.index()] = Some(slot));
        let spontaneous = sys.spontaneous().collect();
        Engine { intervals, spontaneous, places, place_slot, transitions, transition_slot, unit, system }
    }

    pub(super) fn system(&self) -> &Tnces {
        self.system.borrow()
    }

    pub(super) fn spontaneous(&self) -> &[TransitionId] {
        &self.spontaneous
    }

    /// m₀ with D₀.
    pub(super) fn initial(&self) -> TimedState {
        let sys = self.system();
        let marking = sys.net.initial_marking();
        let age = |p: PlaceId| self.unit.map_or(0, |unit| sys.ages[p.index()] / unit);
        let of_place = |&(p, cap): &(PlaceId, u32)| match marking.tokens(p) {
            0 => Vec::new(),
            count => vec![AgedTokens { age: age(p).min(cap), count }],
        };
        let of_transition = |&(t, cap): &(TransitionId, u32)| {
            let age = sys.net.preset(t).iter().map(|&(p, _)| age(p)).min().unwrap_or(0);
            if self.runs(&marking, t) { age.min(cap) } else { 0 }
        };
        TimedState {
            ages: self.places.iter().map(of_place).collect(),
            clocks: self.transitions.iter().map(of_transition).collect(),
            marking,
        }
    }

    /// Whether the input places have enough tokens, whatever their age.
    pub(super) fn is_marked(&self, marking: &Marking, t: TransitionId) -> bool {
        self.system().net.preset(t).iter().all(|&(place, weight)| marking.tokens(place) >= weight)
    }

    pub(super) fn conditions_hold(&self, marking: &Marking, t: TransitionId) -> bool {
        self.system().rows[t.index()].conditions.iter().all(|&(place, weight)| marking.tokens(place) >= weight)
    }

    /// Whether a transition clock runs.
    fn runs(&self, marking: &Marking, t: TransitionId) -> bool {
        self.is_marked(marking, t)
            && (self.system().semantics.clock != ArcClock::SinceEnabled || self.conditions_hold(marking, t))
    }

    /// The input arcs of a transition: place, weight, interval, and the ages of the tokens there if they count.
    fn arcs<'s>(
        &'s self,
        state: &'s TimedState,
        t: TransitionId,
    ) -> impl Iterator<Item = (PlaceId, u32, Interval, Option<&'s Vec<AgedTokens>>)> {
        let preset = self.system().net.preset(t).iter();
        preset.zip(&self.intervals[t.index()]).map(|(&(place, weight), &interval)| {
            (place, weight, interval, self.place_slot[place.index()].map(|slot| &state.ages[slot]))
        })
    }

    /// DL as far as it bars a token from being taken.
    fn bar(&self, interval: Interval) -> Option<u32> {
        interval.latest.filter(|_| self.system().semantics.deadline == Deadline::Expires)
    }

    fn clock(&self, state: &TimedState, t: TransitionId) -> Option<u32> {
        self.transition_slot[t.index()].map(|slot| state.clocks[slot])
    }

    /// Whether the transition could fire by itself `shift` later, if nothing else happens: tokens, conditions, time.
    pub(super) fn is_ripe(&self, state: &TimedState, t: TransitionId, shift: u32) -> bool {
        let clock = self.clock(state, t).map(|clock| clock.saturating_add(shift));
        self.conditions_hold(&state.marking, t)
            && self.arcs(state, t).all(|(place, weight, interval, ages)| {
                let in_time = clock.is_none_or(|clock| {
                    clock >= interval.earliest && self.bar(interval).is_none_or(|latest| clock <= latest)
                });
                let tokens = ages.map_or(u64::from(state.marking.tokens(place)), |ages| {
                    state::within(ages, interval.earliest, self.bar(interval), shift)
                });
                in_time && tokens >= u64::from(weight)
            })
    }

    /// Whether no time may pass before the transition fires or is disabled, `shift` later.
    pub(super) fn is_due(&self, state: &TimedState, t: TransitionId, shift: u32) -> bool {
        let sys = self.system();
        if sys.rows[t.index()].external || !self.is_ripe(state, t, shift) {
            return false;
        }
        match (sys.semantics.firing, sys.semantics.deadline) {
            (FiringPolicy::Earliest, _) => true,
            (FiringPolicy::Window, Deadline::Expires) => false,
            (FiringPolicy::Window, Deadline::Must) => self.arcs(state, t).any(|(_, _, interval, ages)| {
                let oldest = ages.and_then(|ages| ages.first()).map(|oldest| oldest.age);
                let clock = self.clock(state, t).or(oldest).unwrap_or(0).saturating_add(shift);
                interval.latest.is_some_and(|latest| clock >= latest)
            }),
        }
    }

    /// The delays, ascending, at which the transition may become ripe or due: now, and where a clock meets a bound.
    pub(super) fn moments(&self, state: &TimedState, t: TransitionId) -> Vec<u32> {
        let mut moments = vec![0];
        let clock = self.clock(state, t);
        for (_, _, interval, ages) in self.arcs(state, t) {
            let clocks = ages.into_iter().flatten().map(|run| run.age).chain(clock);
            for clock in clocks {
                let bounds = [Some(interval.earliest), interval.latest].into_iter().flatten();
                moments.extend(bounds.filter_map(|bound| bound.checked_sub(clock)));
            }
        }
        moments.sort_unstable();
        moments.dedup();
        moments
    }

    /// Takes what a transition takes, if its clock allows it and the tokens are there; all or nothing.
    pub(super) fn take(&self, state: &mut TimedState, t: TransitionId) -> bool {
        let enough = self.arcs(state, t).all(|(place, weight, interval, ages)| {
            let tokens = ages.map_or(u64::from(state.marking.tokens(place)), |ages| {
                state::within(ages, interval.earliest, self.bar(interval), 0)
            });
            tokens >= u64::from(weight)
        });
        if !enough {
            return false;
        }
        for (&(place, weight), &interval) in self.system().net.preset(t).iter().zip(&self.intervals[t.index()]) {
            state.marking.set(place, state.marking.tokens(place) - weight);
            if let Some(slot) = self.place_slot[place.index()] {
                state::take(&mut state.ages[slot], interval.earliest, self.bar(interval), weight);
            }
        }
        true
    }

    /// The state after a step: the trigger, then what it forces, as [`Engine::steps`] lists them.
    pub(super) fn fire(&self, before: &TimedState, step: &[TransitionId]) -> Result<TimedState, FireError> {
        let sys = self.system();
        let mut after = before.clone();
        for &t in step {
            let taken = self.take(&mut after, t);
            debug_assert!(taken, "a step has its tokens");
        }
        let between = after.marking.clone();
        for &t in step {
            for &(place, gets) in sys.net.postset(t) {
                let has = after.marking.tokens(place);
                let Some(sum) = has.checked_add(gets) else {
                    let (transition, place) = (sys.net.transition(t), sys.net.place(place));
                    return Err(FireError::Overflow { transition, place, has, gets });
                };
                after.marking.set(place, sum);
                if let Some(slot) = self.place_slot[place.index()] {
                    state::give(&mut after.ages[slot], gets);
                }
            }
        }
        for (slot, &(t, _)) in self.transitions.iter().enumerate() {
            // A token that is taken and given back is a new one, and so is an enabling that rests on it.
            let stays = !step.contains(&t)
                && self.runs(&before.marking, t)
                && self.is_marked(&between, t)
                && self.runs(&after.marking, t);
            if !stays {
                after.clocks[slot] = 0;
            }
        }
        Ok(after)
    }

    /// The state after `delay` in which nothing fires.
    pub(super) fn aged(&self, state: &TimedState, delay: u32) -> TimedState {
        let mut later = state.clone();
        for (runs, &(_, cap)) in later.ages.iter_mut().zip(&self.places) {
            state::grow(runs, delay, cap);
        }
        for (clock, &(t, cap)) in later.clocks.iter_mut().zip(&self.transitions) {
            if self.runs(&state.marking, t) {
                *clock = clock.saturating_add(delay).min(cap);
            }
        }
        later
    }

    /// Whether a forced transition that is called may take part in a step, tokens apart.
    pub(super) fn is_willing(&self, state: &TimedState, t: TransitionId) -> bool {
        // Its own tokens are checked too; that they suffice for all is seen when they are taken.
        self.is_ripe(state, t, 0)
    }
}
