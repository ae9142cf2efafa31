//! Deadlocks without the whole graph: at each marking only a stubborn set of transitions is fired.
//!
//! A set of transitions is *stubborn* at a marking if nothing that the others do can enable or disable a member, and a
//! member that fires takes nothing from the others (Valmari, "Stubborn sets for reduced state space generation", 1989).
//! Whatever the others are going to do can then be done after a member as well, so firing the members alone still leads
//! to every reachable deadlock. The set is closed under two rules:
//! - a member that is not enabled lacks tokens on some place: every transition that adds to that place is a member;
//! - a member that is enabled: every transition that uses one of its input places is a member, unless neither of the
//!   two takes anything away from that place.
//!
//! Nothing but deadlocks is preserved. Counts, bounds and liveness are [`super::decide`]'s business.

use super::encoding::MarkingEncoding;
use super::facts::WitnessMarking;
use super::limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided};
use super::on_table::found;
use super::table::MarkingTable;
use crate::{Net, PlaceId, TransitionId};

/// What a reduced search came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StubbornResult {
    /// A reachable marking at which nothing is enabled and a way to it, not always a shortest one; none if there is no
    /// such marking.
    pub deadlock: Option<WitnessMarking>,
    /// How many markings were visited.
    pub states: u64,
}

/// Looks for a reachable marking at which nothing is enabled.
///
/// # Errors
/// As [`super::decide`], for the markings that the reduced search visits. It may end on a net that is unbounded.
pub fn find_deadlock(net: &Net, limits: &ExplorationLimits) -> Result<StubbornResult, ExplorationUndecided> {
    if limits.states == 0 {
        return Err(ExplorationUndecided { states: 0, cause: ExplorationLimit::States { limit: 0 } });
    }
    let encoding = MarkingEncoding::of(net);
    let mut table = MarkingTable::new(net, &encoding, limits)?;
    let mut scratch = table.scratch();
    let transitions = table.transitions();
    let mut stubborn = Stubborn::new(net);
    let mut next = 0;
    while (next as usize) < table.len() {
        let choose = |digits: &[u32], enabled: &mut Vec<u32>| {
            stubborn.tokens.clear();
            stubborn.tokens.extend(encoding.forms.iter().map(|form| form.value(digits) as u32));
            stubborn.reduce(enabled, &transitions);
        };
        if table.expand_some(next, &mut scratch, choose, |_, _, _| {})? == 0 {
            let deadlock = Some(found(&table, next));
            return Ok(StubbornResult { deadlock, states: table.len() as u64 });
        }
        next += 1;
    }
    Ok(StubbornResult { deadlock: None, states: table.len() as u64 })
}

/// Per transition, what belongs to a stubborn set together with it.
struct Stubborn<'n> {
    net: &'n Net,
    /// If it is enabled.
    rivals: Vec<Vec<TransitionId>>,
    /// By place: the transitions that add to it.
    feeders: Vec<Vec<TransitionId>>,
    /// The marking at hand.
    tokens: Vec<u32>,
    member: Vec<bool>,
    stack: Vec<TransitionId>,
}

impl<'n> Stubborn<'n> {
    fn new(net: &'n Net) -> Self {
        let rivals = |t: TransitionId| {
            let of_place = |&(place, _): &(PlaceId, u32)| {
                let takes = gain(net, place, t) < 0;
                let others = net.consumers(place).iter().map(|&(other, _)| other);
                others.filter(move |&other| takes || gain(net, place, other) < 0)
            };
            let mut rivals: Vec<TransitionId> = net.preset(t).iter().flat_map(of_place).collect();
            rivals.sort_unstable();
            rivals.dedup();
            rivals
        };
        let feeders = |place: PlaceId| {
            let all = net.producers(place).iter().map(|&(t, _)| t);
            all.filter(|&t| gain(net, place, t) > 0).collect()
        };
        Stubborn {
            net,
            rivals: net.transitions().map(rivals).collect(),
            feeders: net.places().map(feeders).collect(),
            tokens: Vec::new(),
            member: vec![false; net.transition_count()],
            stack: Vec::new(),
        }
    }

    /// Leaves of the enabled rules those in a stubborn set: of the sets that grow from one of them, one with the fewest.
    fn reduce(&mut self, enabled: &mut Vec<u32>, transitions: &[TransitionId]) {
        let of = |rule: u32| transitions[rule as usize];
        let mut best: Option<Vec<u32>> = None;
        for &seed in enabled.iter() {
            if best.as_ref().is_some_and(|best| best.len() == 1) {
                break;
            }
            self.close(of(seed));
            let set: Vec<u32> = enabled.iter().copied().filter(|&rule| self.member[of(rule).index()]).collect();
            if best.as_ref().is_none_or(|best| set.len() < best.len()) {
                best = Some(set);
            }
        }
        if let Some(best) = best {
            *enabled = best;
        }
    }

    /// The least set with this member that the two rules allow, with a fixed choice of what a transition lacks.
    fn close(&mut self, seed: TransitionId) {
        self.member.fill(false);
        self.member[seed.index()] = true;
        self.stack.push(seed);
        while let Some(t) = self.stack.pop() {
            let lacking = self.net.preset(t).iter().filter(|&&(place, weight)| self.tokens[place.index()] < weight);
            // Few feeders make small sets.
            let scapegoat = lacking.map(|&(place, _)| place).min_by_key(|place| self.feeders[place.index()].len());
            let next = match scapegoat {
                Some(place) => &self.feeders[place.index()],
                None => &self.rivals[t.index()],
            };
            for &other in next {
                if !std::mem::replace(&mut self.member[other.index()], true) {
                    self.stack.push(other);
                }
            }
        }
    }
}

/// What firing a transition adds to a place.
fn gain(net: &Net, place: PlaceId, t: TransitionId) -> i64 {
    let weight = |side: &[(PlaceId, u32)]| {
        side.binary_search_by_key(&place, |&(place, _)| place).map_or(0, |at| i64::from(side[at].1))
    };
    weight(net.postset(t)) - weight(net.preset(t))
}
