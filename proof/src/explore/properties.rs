//! Properties of a state that the search keeps: violations in one of those it stands for, whether home is among them,
//! and their number. Judged from the description alone, by the facts of each situation.

use super::classes::LocalClass;
use super::facts::SituationFacts;
use super::state::ComposedState;
use super::system::{FixedSituation, System};

/// Largest difference of the cycles of two neighbours. A pair of arrows, one of lag 0 and one of lag 1, lets the one be
/// a cycle ahead; operations listed before the arrow's end may have begun another.
const CYCLES_APART_MAX: i32 = 2;

/// Number of states, of moves from them, and of states without successors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StateTally {
    pub states: u64,
    pub arcs: u64,
    pub deadlocks: u64,
}

impl StateTally {
    pub fn add(&mut self, more: StateTally) {
        self.states = self.states.saturating_add(more.states);
        self.arcs = self.arcs.saturating_add(more.arcs);
        self.deadlocks = self.deadlocks.saturating_add(more.deadlocks);
    }
}

/// State that must never be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Violation {
    /// Both states of a conflict hold.
    Conflict(usize),
    /// Something about one station by itself.
    Station(usize),
    /// The least and the greatest cycle of a station.
    Apart(i32, i32),
}

impl System {
    /// Whether this very state violates the property. A kept state also represents states that are not kept; those are not judged here.
    pub fn shows(&self, state: &ComposedState, wrong: Violation) -> bool {
        let facts = |station: usize| &self.stations[station].facts[state.situations[station] as usize];
        let all = (0..self.stations.len()).map(facts);
        let (in_a, in_b) = all.fold((0, 0), |(in_a, in_b), of| (in_a | of.in_a, in_b | of.in_b));
        match wrong {
            Violation::Conflict(nth) => in_a & in_b & (1 << nth) != 0,
            Violation::Station(station) => facts(station).wrong.is_some(),
            Violation::Apart(least, most) => {
                let ends = state.cycles.iter().min().zip(state.cycles.iter().max());
                ends.is_some_and(|(min, max)| max - min == most - least)
            }
        }
    }

    /// The first thing that is wrong in one of the states this one stands for, and in which.
    pub fn wrong(&self, state: &ComposedState) -> Option<(Violation, Vec<FixedSituation>)> {
        let (mut in_a, mut in_b, mut station_wrong) = (0, 0, false);
        for station in 0..self.stations.len() {
            let class = self.class(state, station);
            (in_a, in_b, station_wrong) = (in_a | class.in_a, in_b | class.in_b, station_wrong | class.wrong);
        }
        let mut both = in_a & in_b;
        while both != 0 {
            let conflict = both.trailing_zeros() as usize;
            if let Some(pins) = self.meeting(state, 1 << conflict) {
                return Some((Violation::Conflict(conflict), pins));
            }
            both &= both - 1;
        }
        if station_wrong {
            let wrong = |facts: &SituationFacts| facts.wrong.is_some();
            let pin = (0..self.stations.len()).find_map(|station| self.member(state, station, wrong))?;
            return Some((Violation::Station(pin.station), vec![pin]));
        }
        self.cycles_apart(state).map(|(least, most)| (Violation::Apart(least, most), Vec::new()))
    }

    /// Two stations, or one by itself, that are in both states of a conflict.
    fn meeting(&self, state: &ComposedState, conflict: u64) -> Option<Vec<FixedSituation>> {
        let stations = || 0..self.stations.len();
        let in_a = stations().filter_map(|station| self.member(state, station, |facts| facts.in_a & conflict != 0));
        let in_b = |a: FixedSituation| {
            let others = stations().filter(move |&station| station != a.station);
            others.filter_map(|station| self.member(state, station, |facts| facts.in_b & conflict != 0)).next()
        };
        let alone = |station| self.member(state, station, |facts| facts.in_a & facts.in_b & conflict != 0);
        let two = in_a.filter_map(|a| in_b(a).map(|b| vec![a, b])).next();
        two.or_else(|| stations().find_map(alone).map(|pin| vec![pin]))
    }

    /// A situation of a station's class that is like this.
    fn member(
        &self,
        state: &ComposedState,
        station: usize,
        is: impl Fn(&SituationFacts) -> bool,
    ) -> Option<FixedSituation> {
        let members = self.class(state, station).members.iter();
        let member = members.copied().find(|&member| is(&self.stations[station].facts[member as usize]))?;
        Some(FixedSituation { station, member })
    }

    /// Tally of the states that this one stands for.
    pub fn tally(&self, state: &ComposedState) -> StateTally {
        let classes = || (0..self.stations.len()).map(|station| self.class(state, station));
        let product =
            |of: fn(&LocalClass) -> u64| classes().fold(1, |product: u64, class| product.saturating_mul(of(class)));
        let states = product(|class| class.members.len() as u64);
        let waiting: usize = (0..self.setting.links.len()).map(|link| self.waiting(state, link)).sum();
        let grants = self.grants(state).count();
        let acts = classes().map(|class| (states / class.members.len() as u64).saturating_mul(class.possible));
        let arcs = states.saturating_mul(waiting as u64);
        let arcs = acts.fold(arcs, u64::saturating_add);
        let arcs = arcs.saturating_add(product(|class| class.idle.len() as u64).saturating_mul(grants as u64));
        let still = product(|class| class.stuck) - if grants > 0 { product(|class| class.stuck_idle) } else { 0 };
        StateTally { states, arcs, deadlocks: if waiting > 0 { 0 } else { still } }
    }

    /// A violation, in words.
    pub fn wrong_text(&self, state: &ComposedState, wrong: Violation) -> String {
        match wrong {
            Violation::Conflict(nth) => self.setting.line.conflicts[nth].why.clone(),
            Violation::Station(station) => {
                let facts = &self.stations[station].facts[state.situations[station] as usize];
                let what = facts.wrong.as_deref().unwrap_or("nothing is wrong");
                format!("{}: {what}", self.setting.line.stations[station].name)
            }
            Violation::Apart(least, most) => {
                // The way there may count from another cycle than the state that was found.
                let (cycles, stations) = (&state.cycles, &self.setting.line.stations);
                let ahead = (0..stations.len()).max_by_key(|&at| cycles[at]).map_or("", |at| &stations[at].name);
                let behind = (0..stations.len()).min_by_key(|&at| cycles[at]).map_or("", |at| &stations[at].name);
                format!("{ahead} is {} cycles ahead of {behind}, too far", most - least)
            }
        }
    }

    fn cycles_apart(&self, state: &ComposedState) -> Option<(i32, i32)> {
        let (least, most) = (state.cycles.iter().min()?, state.cycles.iter().max()?);
        let neighbours = self.stations.len() as i32 - 1;
        (most - least > CYCLES_APART_MAX * neighbours).then_some((*least, *most))
    }

    /// Whether every station is at home, in one of the states that this one stands for.
    pub fn all_at_home(&self, state: &ComposedState) -> bool {
        (0..self.stations.len()).all(|station| self.class(state, station).at_home)
    }
}

/// A count in words. Counts end at what 64 bits hold; one that has is a lower bound.
pub fn counted(count: u64) -> String {
    if count == u64::MAX { format!("at least {count}") } else { count.to_string() }
}
