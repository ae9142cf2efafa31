//! Timed net condition/event systems once more, slow and obvious: tokens one by one, every subset of transitions tried
//! as a step, time in single units, clocks cut off only far beyond every bound. Shares no code with the crate.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use linewright_nets::tnces::{ArcClock, Deadline, FiringPolicy, Semantics};

/// (place, weight, DR, DL).
pub type Take = (usize, u32, u32, Option<u32>);

/// A transition.
#[derive(Clone, Debug)]
pub struct Transition {
    pub takes: Vec<Take>,
    pub gives: Vec<(usize, u32)>,
    pub reads: Vec<(usize, u32)>,
    /// Of each group one must fire.
    pub groups: Vec<Vec<usize>>,
    pub external: bool,
}

/// A system.
#[derive(Clone, Debug)]
pub struct Plain {
    pub tokens: Vec<u32>,
    pub ages: Vec<u32>,
    pub transitions: Vec<Transition>,
    pub semantics: Semantics,
    pub timed: bool,
}

/// The ages of the tokens of each place, oldest first, and a clock for each transition, 0 if it does not run.
pub type State = (Vec<Vec<u32>>, Vec<u32>);

pub type Marking = Vec<u32>;

impl Plain {
    fn cap(&self) -> u32 {
        let takes = self.transitions.iter().flat_map(|t| &t.takes);
        takes.flat_map(|&(_, _, dr, dl)| [dr, dl.unwrap_or(0)]).max().unwrap_or(0) + 2
    }

    fn by_age(&self) -> bool {
        self.semantics.clock == ArcClock::TokenAge
    }

    pub fn initial(&self) -> State {
        let ages = self.tokens.iter().zip(&self.ages);
        let ages: Vec<Vec<u32>> = ages.map(|(&n, &age)| vec![age.min(self.cap()); n as usize]).collect();
        let clock = |t: &Transition| {
            let least = t.takes.iter().map(|&(p, ..)| self.ages[p]).min().unwrap_or(0);
            if self.runs(&self.tokens, t) { least.min(self.cap()) } else { 0 }
        };
        let clocks = self.transitions.iter().map(clock).collect();
        self.normal((ages, clocks))
    }

    /// Drops what the reading does not use.
    fn normal(&self, (mut ages, mut clocks): State) -> State {
        if !self.timed || !self.by_age() {
            ages.iter_mut().flatten().for_each(|age| *age = 0);
        }
        if !self.timed || self.by_age() {
            clocks.iter_mut().for_each(|clock| *clock = 0);
        }
        (ages, clocks)
    }

    pub fn marking(state: &State) -> Marking {
        state.0.iter().map(|ages| ages.len() as u32).collect()
    }

    fn marked(marking: &[u32], t: &Transition) -> bool {
        t.takes.iter().all(|&(p, n, ..)| marking[p] >= n)
    }

    fn reads(marking: &[u32], t: &Transition) -> bool {
        t.reads.iter().all(|&(p, n)| marking[p] >= n)
    }

    fn runs(&self, marking: &[u32], t: &Transition) -> bool {
        Self::marked(marking, t) && (self.semantics.clock != ArcClock::SinceEnabled || Self::reads(marking, t))
    }

    fn fits(&self, clock: u32, dr: u32, dl: Option<u32>) -> bool {
        clock >= dr && (self.semantics.deadline == Deadline::Must || dl.is_none_or(|dl| clock <= dl))
    }

    fn clock_fits(&self, state: &State, t: usize) -> bool {
        let arcs = &self.transitions[t].takes;
        !self.timed || self.by_age() || arcs.iter().all(|&(_, _, dr, dl)| self.fits(state.1[t], dr, dl))
    }

    /// Takes token after token, the oldest that fits; false if one is missing.
    fn take(&self, ages: &mut [Vec<u32>], t: usize) -> bool {
        for &(p, n, dr, dl) in &self.transitions[t].takes {
            for _ in 0..n {
                let fits = |&age: &u32| !self.timed || !self.by_age() || self.fits(age, dr, dl);
                match ages[p].iter().position(fits) {
                    Some(at) => _ = ages[p].remove(at),
                    None => return false,
                }
            }
        }
        true
    }

    fn depth(&self, t: usize) -> usize {
        self.transitions[t].groups.iter().flatten().map(|&from| self.depth(from) + 1).max().unwrap_or(0)
    }

    fn in_order(&self, step: &[usize]) -> Vec<usize> {
        let mut step = step.to_vec();
        step.sort_by_key(|&t| (self.depth(t), t));
        step
    }

    fn valid(&self, state: &State, step: &[usize]) -> bool {
        let marking = Self::marking(state);
        let spontaneous = step.iter().filter(|&&t| self.transitions[t].groups.is_empty()).count();
        let called = step.iter().all(|&t| {
            let mut groups = self.transitions[t].groups.iter();
            groups.all(|group| group.iter().any(|from| step.contains(from)))
        });
        let willing = step.iter().all(|&t| {
            let mut alone = state.0.clone();
            Self::reads(&marking, &self.transitions[t]) && self.clock_fits(state, t) && self.take(&mut alone, t)
        });
        let mut left = state.0.clone();
        spontaneous == 1 && called && willing && self.in_order(step).into_iter().all(|t| self.take(&mut left, t))
    }

    /// All valid subsets that no other valid subset with the same spontaneous transition contains.
    pub fn steps(&self, state: &State) -> BTreeSet<Vec<usize>> {
        let n = self.transitions.len();
        let subsets = (1_u32..1 << n).map(|bits| (0..n).filter(|t| bits >> t & 1 == 1).collect::<Vec<_>>());
        let valid: Vec<Vec<usize>> = subsets.filter(|step| self.valid(state, step)).collect();
        let within = |a: &Vec<usize>, b: &Vec<usize>| a.len() < b.len() && a.iter().all(|t| b.contains(t));
        valid.iter().filter(|a| !valid.iter().any(|b| within(a, b))).cloned().collect()
    }

    pub fn fire(&self, state: &State, step: &[usize]) -> State {
        let before = Self::marking(state);
        let (mut ages, mut clocks) = state.clone();
        for t in self.in_order(step) {
            assert!(self.take(&mut ages, t));
        }
        let between: Vec<u32> = ages.iter().map(|ages| ages.len() as u32).collect();
        for &t in step {
            for &(p, n) in &self.transitions[t].gives {
                ages[p].extend(vec![0; n as usize]);
            }
        }
        let after: Vec<u32> = ages.iter().map(|ages| ages.len() as u32).collect();
        for (t, transition) in self.transitions.iter().enumerate() {
            let stays = self.runs(&before, transition)
                && Self::marked(&between, transition)
                && self.runs(&after, transition)
                && !step.contains(&t);
            if !stays {
                clocks[t] = 0;
            }
        }
        self.normal((ages, clocks))
    }

    /// Whether a transition alone keeps time from passing.
    fn due(&self, state: &State, t: usize) -> bool {
        let transition = &self.transitions[t];
        let marking = Self::marking(state);
        let mut alone = state.0.clone();
        let ripe = Self::reads(&marking, transition) && self.clock_fits(state, t) && self.take(&mut alone, t);
        if !ripe || transition.external || !transition.groups.is_empty() {
            return false;
        }
        match (self.semantics.firing, self.semantics.deadline) {
            (FiringPolicy::Earliest, _) => true,
            (_, Deadline::Expires) => false,
            _ => transition.takes.iter().any(|&(p, _, _, dl)| {
                let clock = if self.by_age() { state.0[p][0] } else { state.1[t] };
                dl.is_some_and(|dl| clock >= dl)
            }),
        }
    }

    /// One unit later, if time may pass.
    pub fn tick(&self, state: &State) -> Option<State> {
        if (0..self.transitions.len()).any(|t| self.due(state, t)) {
            return None;
        }
        let marking = Self::marking(state);
        let (mut ages, mut clocks) = state.clone();
        ages.iter_mut().flatten().for_each(|age| *age = (*age + 1).min(self.cap()));
        for (t, clock) in clocks.iter_mut().enumerate() {
            if self.runs(&marking, &self.transitions[t]) {
                *clock = (*clock + 1).min(self.cap());
            }
        }
        Some(self.normal((ages, clocks)))
    }
}

/// The whole state space in single units.
pub struct Space {
    pub states: Vec<State>,
    /// Per state: step, or none for a unit of time; and the next state.
    pub next: Vec<Vec<(Option<Vec<usize>>, usize)>>,
}

impl Space {
    pub fn new(plain: &Plain, limit: usize) -> Option<Space> {
        let mut number = BTreeMap::from([(plain.initial(), 0)]);
        let mut space = Space { states: vec![plain.initial()], next: Vec::new() };
        while space.next.len() < space.states.len() {
            let here = space.states[space.next.len()].clone();
            let steps = plain.steps(&here).into_iter().map(|step| (Some(step.clone()), plain.fire(&here, &step)));
            let mut ways: Vec<_> = steps.collect();
            if plain.timed {
                ways.extend(plain.tick(&here).map(|later| (None, later)));
            }
            let mut next = Vec::new();
            for (label, there) in ways {
                let new = space.states.len();
                let to = *number.entry(there.clone()).or_insert(new);
                if to == new {
                    space.states.push(there);
                }
                next.push((label, to));
            }
            space.next.push(next);
            if space.states.len() > limit {
                return None;
            }
        }
        Some(space)
    }

    pub fn marking(&self, state: usize) -> Marking {
        Plain::marking(&self.states[state])
    }

    pub fn moves(&self) -> BTreeSet<(Marking, Vec<usize>, Marking)> {
        let all = self.next.iter().enumerate().flat_map(|(from, next)| next.iter().map(move |way| (from, way)));
        all.filter_map(|(from, (step, to))| Some((self.marking(from), step.clone()?, self.marking(*to)))).collect()
    }

    /// Markings of states after which no step ever comes.
    pub fn dead(&self) -> BTreeSet<Marking> {
        // Walk backwards from steps until nothing is added.
        let mut lives = vec![false; self.states.len()];
        loop {
            let before = lives.clone();
            for (state, next) in self.next.iter().enumerate() {
                lives[state] |= next.iter().any(|(step, to)| step.is_some() || lives[*to]);
            }
            if before == lives {
                break;
            }
        }
        (0..lives.len()).filter(|&state| !lives[state]).map(|state| self.marking(state)).collect()
    }

    /// Units of time until a marking, at best.
    pub fn earliest(&self) -> BTreeMap<Marking, u64> {
        let mut times = vec![u64::MAX; self.states.len()];
        times[0] = 0;
        let mut open = VecDeque::from([0]);
        while let Some(at) = open.pop_front() {
            for (step, to) in &self.next[at] {
                let time = times[at] + u64::from(step.is_none());
                if time < times[*to] {
                    times[*to] = time;
                    open.push_back(*to);
                }
            }
        }
        let mut earliest = BTreeMap::new();
        for (state, &time) in times.iter().enumerate() {
            let known = earliest.entry(self.marking(state)).or_insert(time);
            *known = time.min(*known);
        }
        earliest
    }

    /// Units of time until a marking at worst, or none if it can be avoided for ever.
    pub fn latest(&self, goal: &Marking) -> Option<u64> {
        let is_goal: Vec<bool> = (0..self.states.len()).map(|state| self.marking(state) == *goal).collect();
        // States that can avoid it: all but the goal, until each has a successor among them or none at all.
        let mut avoids: Vec<bool> = is_goal.iter().map(|&is| !is).collect();
        loop {
            let before = avoids.clone();
            for (state, next) in self.next.iter().enumerate() {
                avoids[state] &= next.is_empty() || next.iter().any(|&(_, to)| avoids[to]);
            }
            if avoids == before {
                break;
            }
        }
        if avoids[0] {
            return None;
        }
        // The others cannot but reach it, so their longest ways settle.
        let mut worst = vec![0; self.states.len()];
        loop {
            let before = worst.clone();
            for state in (0..worst.len()).filter(|&state| !avoids[state] && !is_goal[state]) {
                let ways = self.next[state].iter();
                worst[state] = ways.map(|(step, to)| worst[*to] + u64::from(step.is_none())).max().unwrap_or(0);
            }
            if worst == before {
                return Some(worst[0]);
            }
        }
    }
}
