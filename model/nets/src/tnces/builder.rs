//! Builder of the tables beside a net, and their one check.
//!
//! Like [`crate::NetBuilder`], a builder accepts everything, and [`TncesBuilder::build`] reports all errors or returns
//! a [`Tnces`] that need not be checked again.

use std::collections::BTreeMap;

use super::chain::{self, Chain};
use super::system::TransitionRow;
use super::{EventMode, Interval, Semantics, Tnces, TncesError};
use crate::{NamedId, Net, PlaceId, TransitionId};

/// The most transitions forced by one trigger that may compete for tokens.
const CONTESTED_MAX: usize = 12;

/// The most entries of all chains together.
const FORCED_MAX: usize = 1 << 24;

/// The largest bound of an interval: a clock and a delay can be added without a carry.
pub const TIME_MAX: u32 = 1 << 30;

/// The tables beside a net, under construction.
#[derive(Clone, Debug)]
pub struct TncesBuilder {
    net: Net,
    semantics: Semantics,
    conditions: Vec<(TransitionId, PlaceId, u32)>,
    /// Target and sources, one of which must fire; an event arc is a set of one.
    events: Vec<(TransitionId, Vec<TransitionId>)>,
    modes: Vec<(TransitionId, EventMode)>,
    intervals: Vec<(TransitionId, PlaceId, Interval)>,
    external: Vec<TransitionId>,
    ages: Vec<(PlaceId, u32)>,
}

impl TncesBuilder {
    /// A system with nothing beside the net yet.
    pub fn new(net: Net) -> Self {
        TncesBuilder {
            net,
            semantics: Semantics::default(),
            conditions: Vec::new(),
            events: Vec::new(),
            modes: Vec::new(),
            intervals: Vec::new(),
            external: Vec::new(),
            ages: Vec::new(),
        }
    }

    /// Chooses the reading of time.
    pub fn semantics(&mut self, semantics: Semantics) -> &mut Self {
        self.semantics = semantics;
        self
    }

    /// A condition arc: `transition` fires only while `place` has at least `weight` tokens, and takes none of them.
    pub fn condition(&mut self, transition: TransitionId, place: PlaceId, weight: u32) -> &mut Self {
        self.conditions.push((transition, place, weight));
        self
    }

    /// An event arc: the firing of `from` calls `to`.
    pub fn event(&mut self, from: TransitionId, to: TransitionId) -> &mut Self {
        self.event_of(vec![from], to)
    }

    /// An event signal with several origins: the firing of any of them calls `to`. In mode *all* the signal counts once.
    pub fn event_of(&mut self, origins: Vec<TransitionId>, to: TransitionId) -> &mut Self {
        self.events.push((to, origins));
        self
    }

    /// Combination of the event arcs into a transition; *any* by default, and the last call counts.
    pub fn event_mode(&mut self, transition: TransitionId, mode: EventMode) -> &mut Self {
        self.modes.push((transition, mode));
        self
    }

    /// [DR, DL] on the input arc from `place` to `transition`.
    pub fn interval(&mut self, transition: TransitionId, place: PlaceId, interval: Interval) -> &mut Self {
        self.intervals.push((transition, place, interval));
        self
    }

    /// Leaves it to the environment when `transition` fires, within its intervals: nothing makes it fire.
    pub fn external(&mut self, transition: TransitionId) -> &mut Self {
        self.external.push(transition);
        self
    }

    /// D₀: age of the tokens on a place at the beginning; 0 by default, and the last call counts. A transition clock
    /// begins with the least age of the input places.
    pub fn initial_age(&mut self, place: PlaceId, age: u32) -> &mut Self {
        self.ages.push((place, age));
        self
    }

    /// The system, or all its errors.
    pub fn build(mut self) -> Result<Tnces, Vec<TncesError>> {
        self.conditions.sort_unstable();
        self.intervals.sort_unstable();
        let mut problems = Vec::new();
        self.check_ids(&mut problems);
        if !problems.is_empty() {
            // What follows looks at names and arcs of these ids.
            self.drop_unknown();
        }
        self.check_conditions(&mut problems);
        self.check_intervals(&mut problems);
        self.check_events(&mut problems);
        let mut rows = vec![TransitionRow::default(); self.net.transition_count()];
        self.fill(&mut rows);
        for t in self.net.transitions().filter(|t| rows[t.index()].external && !rows[t.index()].groups.is_empty()) {
            problems.push(TncesError::ExternalForced { transition: self.net.transition(t) });
        }
        let chains = self.chains(&rows, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let mut ages = vec![0; self.net.place_count()];
        self.ages.iter().for_each(|&(place, age)| ages[place.index()] = age);
        Ok(Tnces { net: self.net, semantics: self.semantics, rows, ages, chains })
    }

    fn check_ids(&self, problems: &mut Vec<TncesError>) {
        let (places, transitions) = (self.net.place_count(), self.net.transition_count());
        let mut place = |what: &str, place: PlaceId| {
            if place.index() >= places {
                problems.push(TncesError::UnknownPlace { what: what.to_owned(), place, places });
            }
        };
        self.conditions.iter().for_each(|&(_, p, _)| place("a condition arc", p));
        self.intervals.iter().for_each(|&(_, p, _)| place("an interval", p));
        self.ages.iter().for_each(|&(p, _)| place("an initial age", p));
        let mut transition = |what: &str, transition: TransitionId| {
            if transition.index() >= transitions {
                problems.push(TncesError::UnknownTransition { what: what.to_owned(), transition, transitions });
            }
        };
        self.conditions.iter().for_each(|&(t, _, _)| transition("a condition arc", t));
        self.intervals.iter().for_each(|&(t, _, _)| transition("an interval", t));
        self.events.iter().for_each(|(to, from)| {
            from.iter().chain([to]).for_each(|&t| transition("an event arc", t));
        });
        self.modes.iter().for_each(|&(t, _)| transition("an event mode", t));
        self.external.iter().for_each(|&t| transition("the list of external transitions", t));
    }

    fn drop_unknown(&mut self) {
        let (places, transitions) = (self.net.place_count(), self.net.transition_count());
        let (p_ok, t_ok) = (|p: &PlaceId| p.index() < places, |t: &TransitionId| t.index() < transitions);
        self.conditions.retain(|(t, p, _)| t_ok(t) && p_ok(p));
        self.intervals.retain(|(t, p, _)| t_ok(t) && p_ok(p));
        self.events.retain(|(to, from)| t_ok(to) && from.iter().all(t_ok));
        self.modes.retain(|(t, _)| t_ok(t));
        self.external.retain(t_ok);
        self.ages.retain(|(p, _)| p_ok(p));
    }

    fn check_conditions(&self, problems: &mut Vec<TncesError>) {
        let name = |t, p| (self.net.transition(t), self.net.place(p));
        for &(t, p, _) in self.conditions.iter().filter(|&&(_, _, weight)| weight == 0) {
            let (transition, place) = name(t, p);
            problems.push(TncesError::ZeroWeight { place, transition });
        }
        for same in self.conditions.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|same| same.len() > 1) {
            let (transition, place) = name(same[0].0, same[0].1);
            problems.push(TncesError::DuplicateCondition { place, transition, times: same.len() });
        }
    }

    fn check_intervals(&self, problems: &mut Vec<TncesError>) {
        for &(t, p, interval) in &self.intervals {
            let (transition, place) = (self.net.transition(t), self.net.place(p));
            if self.net.preset(t).binary_search_by_key(&p, |&(place, _)| place).is_err() {
                problems.push(TncesError::NoSuchArc { place, transition, interval });
            } else if interval.latest.is_some_and(|latest| latest < interval.earliest) {
                problems.push(TncesError::Reversed { place, transition, interval });
            } else if interval.latest.unwrap_or(interval.earliest) > TIME_MAX {
                problems.push(TncesError::TooLong { place, transition, interval, limit: TIME_MAX });
            }
        }
        for same in self.intervals.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|same| same.len() > 1) {
            let (transition, place) = (self.net.transition(same[0].0), self.net.place(same[0].1));
            problems.push(TncesError::DuplicateInterval { place, transition, times: same.len() });
        }
    }

    fn check_events(&self, problems: &mut Vec<TncesError>) {
        for (to, _) in self.events.iter().filter(|(_, from)| from.is_empty()) {
            problems.push(TncesError::NoSource { transition: self.net.transition(*to) });
        }
        // One origin may be in two signals; the same arc twice, or twice in one signal, is a slip.
        let mut times: BTreeMap<(TransitionId, &[TransitionId], TransitionId), usize> = BTreeMap::new();
        for (to, signal) in &self.events {
            signal.iter().for_each(|&from| *times.entry((*to, signal, from)).or_default() += 1);
        }
        for ((to, _, from), times) in times.into_iter().filter(|&(_, times)| times > 1) {
            let (from, to) = (self.net.transition(from), self.net.transition(to));
            problems.push(TncesError::DuplicateEvent { from, to, times });
        }
    }

    fn fill(&self, rows: &mut [TransitionRow]) {
        for t in self.net.transitions() {
            let row = &mut rows[t.index()];
            let start = self.conditions.partition_point(|&(of, _, _)| of < t);
            let conditions = self.conditions[start..].iter().take_while(|&&(of, _, _)| of == t);
            row.conditions = conditions.map(|&(_, place, weight)| (place, weight)).collect();
            row.intervals = vec![Interval::ANY; self.net.preset(t).len()].into();
        }
        for &(t, p, interval) in &self.intervals {
            if let Ok(at) = self.net.preset(t).binary_search_by_key(&p, |&(place, _)| place) {
                rows[t.index()].intervals[at] = interval;
            }
        }
        let modes: BTreeMap<_, _> = self.modes.iter().copied().collect();
        let mut groups: BTreeMap<TransitionId, Vec<Box<[TransitionId]>>> = BTreeMap::new();
        for (to, from) in &self.events {
            groups.entry(*to).or_default().push(from.clone().into());
        }
        for (to, groups) in groups {
            let any = modes.get(&to).copied().unwrap_or_default() == EventMode::Any;
            rows[to.index()].groups = if any {
                let mut all = groups.concat();
                all.sort_unstable();
                all.dedup();
                [all.into()].into()
            } else {
                groups.into()
            };
        }
        self.external.iter().for_each(|t| rows[t.index()].external = true);
    }

    fn chains(&self, rows: &[TransitionRow], problems: &mut Vec<TncesError>) -> Vec<Chain> {
        let mut targets = vec![Vec::new(); rows.len()];
        for (to, row) in self.net.transitions().zip(rows) {
            row.groups.iter().flatten().for_each(|from| targets[from.index()].push(to));
        }
        let rank = match chain::rank(&targets) {
            Ok(rank) => rank,
            Err(cycle) => {
                let cycle: Vec<NamedId<_>> = cycle.into_iter().map(|t| self.net.transition(t)).collect();
                problems.push(TncesError::EventCycle { cycle });
                return Vec::new();
            }
        };
        let mut chains = vec![Chain::default(); rows.len()];
        let mut entries = 0;
        for t in self.net.transitions().filter(|t| rows[t.index()].groups.is_empty()) {
            let chain = Chain::new(&self.net, t, &targets, &rank);
            entries += chain.members.len();
            if entries > FORCED_MAX {
                problems.push(TncesError::TooManyForced { limit: FORCED_MAX });
                break;
            }
            if chain.choices() > CONTESTED_MAX {
                let (trigger, limit) = (self.net.transition(t), CONTESTED_MAX);
                problems.push(TncesError::TooManyChoices { trigger, contested: chain.choices(), limit });
            }
            chains[t.index()] = chain;
        }
        chains
    }
}
