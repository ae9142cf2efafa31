//! Verdicts on state machines: exact for every one of them.
//!
//! Each token walks on its own through the graph whose nodes are the places and whose edges are the transitions.
//! [`crate::state_machine_verdict`] has the argument; here every answer gets its evidence, and every place its bound:
//! the number of tokens that can walk there.

use std::collections::HashMap;

use super::evidence::{Component, Dead, Evidence, NetProperty, NoReturn, RepeatedFiring, Sums};
use super::{CertificateAnswer, NetClass, StructuralVerdict, TokenBound};
use crate::components::Components;
use crate::{Net, PlaceId, TransitionId};

/// The most entries in the sums that bound places; with more, all places share the sum of all tokens.
const SUMS_MAX: usize = 20_000_000;

/// The places that a walk has found, each with the step by which; those where it began have none.
type Steps = HashMap<usize, Option<TransitionId>>;

struct StateMachineProof<'net> {
    net: &'net Net,
    /// Per transition, where it leads from and to.
    steps: Vec<(usize, usize)>,
    parts: Components,
    tokens: Vec<u32>,
}

/// The verdict on a state machine; the caller has checked that it is one.
pub(super) fn decide(net: &Net) -> StructuralVerdict {
    let steps: Vec<(usize, usize)> =
        net.transitions().map(|t| (net.preset(t)[0].0.index(), net.postset(t)[0].0.index())).collect();
    let parts = Components::new(net.place_count(), steps.iter().copied());
    let machine = StateMachineProof { net, steps, parts, tokens: net.initial_marking().as_slice().to_vec() };
    let (bounds, bounded, safe) = machine.bounds();
    StructuralVerdict {
        class: NetClass::StateMachine,
        deadlock_free: machine.deadlock_free(),
        live: machine.live(),
        bounded,
        safe,
        reversible: machine.reversible(),
        bounds,
    }
}

fn id(place: usize) -> PlaceId {
    PlaceId(place as u32)
}

impl StateMachineProof<'_> {
    /// The places that can be reached, in the order of discovery, and the steps by which they are found.
    fn ahead(&self, start: usize) -> (Vec<usize>, Steps) {
        self.walk(vec![start], |place| self.leading_on(place).collect())
    }

    /// The places from which one of these can be reached, nearest first, and the steps that lead on from there.
    fn behind(&self, starts: Vec<usize>) -> (Vec<usize>, Steps) {
        self.walk(starts, |place| self.leading_here(place).collect())
    }

    fn leading_on(&self, place: usize) -> impl Iterator<Item = (TransitionId, usize)> {
        self.net.consumers(id(place)).iter().map(|&(t, _)| (t, self.steps[t.index()].1))
    }

    fn leading_here(&self, place: usize) -> impl Iterator<Item = (TransitionId, usize)> {
        self.net.producers(id(place)).iter().map(|&(t, _)| (t, self.steps[t.index()].0))
    }

    /// Takes time and memory for what it finds, not for the whole net.
    fn walk(&self, starts: Vec<usize>, next: impl Fn(usize) -> Vec<(TransitionId, usize)>) -> (Vec<usize>, Steps) {
        let mut by: Steps = starts.iter().map(|&start| (start, None)).collect();
        let mut found = starts;
        let mut at = 0;
        while at < found.len() {
            for (t, other) in next(found[at]) {
                by.entry(other).or_insert_with(|| {
                    found.push(other);
                    Some(t)
                });
            }
            at += 1;
        }
        (found, by)
    }

    /// Sends tokens from a place along the steps of [`Self::behind`] to a start.
    fn send(&self, from: usize, times: u64, on: &Steps, run: &mut Vec<RepeatedFiring>) {
        let mut at = from;
        while let Some(transition) = on[&at] {
            run.push(RepeatedFiring { transition, times });
            at = self.steps[transition.index()].1;
        }
    }

    /// Sends all tokens there are to the starts of [`Self::behind`]: from the farthest places first, so that each step
    /// is taken by all tokens together.
    fn gather(&self, found: &[usize], on: &Steps) -> Vec<RepeatedFiring> {
        let mut run = Vec::new();
        let mut brought: HashMap<usize, u64> = HashMap::new();
        for place in found.iter().rev() {
            let times = brought.get(place).copied().unwrap_or(0) + u64::from(self.tokens[*place]);
            if let (Some(transition), 1..) = (on[place], times) {
                run.push(RepeatedFiring { transition, times });
                *brought.entry(self.steps[transition.index()].1).or_default() += times;
            }
        }
        run
    }

    fn component(&self, root: usize) -> Component {
        let inside = |(_, other): &(TransitionId, usize)| self.parts.of(*other) == self.parts.of(root);
        let steps = |(found, by): (Vec<usize>, Steps)| found.into_iter().filter_map(|place| by[&place]).collect();
        Component {
            root: id(root),
            out: steps(self.walk(vec![root], |place| self.leading_on(place).filter(inside).collect())),
            back: steps(self.walk(vec![root], |place| self.leading_here(place).filter(inside).collect())),
        }
    }

    /// A component for each of the given places, none twice.
    fn components(&self, places: impl Iterator<Item = usize>) -> Evidence {
        let mut done = vec![false; self.parts.count()];
        let new = |&place: &usize| !std::mem::replace(&mut done[self.parts.of(place)], true);
        Evidence::Components(places.filter(new).map(|place| self.component(place)).collect())
    }

    fn live(&self) -> CertificateAnswer {
        let leaves = |t: &TransitionId| {
            let (from, to) = self.steps[t.index()];
            self.parts.of(from) != self.parts.of(to)
        };
        let mut marked = vec![false; self.parts.count()];
        (0..self.tokens.len()).filter(|&p| self.tokens[p] > 0).for_each(|p| marked[self.parts.of(p)] = true);
        let empty = |t: &TransitionId| !marked[self.parts.of(self.steps[t.index()].0)];
        let transition = self.net.transitions().find(leaves).or_else(|| self.net.transitions().find(empty));
        let Some(transition) = transition else {
            return CertificateAnswer::yes(NetProperty::Live, self.components(self.steps.iter().map(|step| step.0)));
        };
        // All tokens that could ever come to the transition go through it, and none comes back.
        let (mut siphon, on) = self.behind(vec![self.steps[transition.index()].0]);
        let mut run = self.gather(&siphon, &on);
        let times = siphon.iter().map(|&place| u64::from(self.tokens[place])).sum();
        if times > 0 {
            run.push(RepeatedFiring { transition, times });
        }
        siphon.sort_unstable();
        let siphon = siphon.into_iter().map(id).collect();
        CertificateAnswer::no(NetProperty::Live, Evidence::Dead(Dead { run, siphon, transition }))
    }

    fn deadlock_free(&self) -> CertificateAnswer {
        let ends = (0..self.tokens.len()).filter(|&place| self.net.consumers(id(place)).is_empty()).collect();
        let (found, on) = self.behind(ends);
        match (0..self.tokens.len()).find(|place| self.tokens[*place] > 0 && !on.contains_key(place)) {
            Some(place) => {
                let mut trap = self.ahead(place).0;
                trap.sort_unstable();
                CertificateAnswer::yes(NetProperty::DeadlockFree, Evidence::Trap(trap.into_iter().map(id).collect()))
            }
            None => CertificateAnswer::no(NetProperty::DeadlockFree, Evidence::Deadlock(self.gather(&found, &on))),
        }
    }

    fn reversible(&self) -> CertificateAnswer {
        let marked = (0..self.tokens.len()).filter(|&place| self.tokens[place] > 0);
        let Some(place) = marked.clone().find(|&place| !self.parts.is_terminal(self.parts.of(place))) else {
            return CertificateAnswer::yes(NetProperty::Reversible, self.components(marked));
        };
        let home = self.parts.of(place);
        let leads_out = |t: &TransitionId| {
            let (from, to) = self.steps[t.index()];
            self.parts.of(from) == home && self.parts.of(to) != home
        };
        let exit = self.net.transitions().find(leads_out).expect("an edge leaves a component that is not terminal");
        let (from, to) = self.steps[exit.index()];
        let mut run = Vec::new();
        self.send(place, 1, &self.behind(vec![from]).1, &mut run);
        run.push(RepeatedFiring { transition: exit, times: 1 });
        let mut beyond = self.ahead(to).0;
        beyond.sort_unstable();
        let weights = beyond.into_iter().map(|place| (id(place), 1)).collect();
        CertificateAnswer::no(NetProperty::Reversible, Evidence::NoReturn(NoReturn { run, dead: Vec::new(), weights }))
    }

    fn bounds(&self) -> (Vec<TokenBound>, CertificateAnswer, CertificateAnswer) {
        let mut sums = Sums::default();
        let mut of_part: Vec<Option<(usize, u128)>> = vec![None; self.parts.count()];
        let mut size = 0;
        let total: u128 = self.tokens.iter().map(|&count| u128::from(count)).sum();
        for place in 0..self.tokens.len() {
            let part = self.parts.of(place);
            if of_part[part].is_none() && size < SUMS_MAX {
                let mut behind = self.behind(vec![place]).0;
                behind.sort_unstable();
                size += behind.len();
                let bound = behind.iter().map(|&place| u128::from(self.tokens[place])).sum();
                of_part[part] = Some((sums.sums.len(), bound));
                sums.sums.push(behind.into_iter().map(|place| (id(place), 1)).collect());
            }
        }
        if of_part.contains(&None) {
            sums.sums.push((0..self.tokens.len()).map(|place| (id(place), 1)).collect());
        }
        let all = (sums.sums.len().saturating_sub(1), total);
        sums.bounds = (0..self.tokens.len()).map(|place| of_part[self.parts.of(place)].unwrap_or(all)).collect();
        let exact = |place: usize| match of_part[self.parts.of(place)] {
            Some((_, bound)) => TokenBound::Exactly(bound),
            None => TokenBound::AtMost(total),
        };
        let bounds = (0..self.tokens.len()).map(exact).collect();
        let over = (0..self.tokens.len()).find(|&p| of_part[self.parts.of(p)].is_some_and(|(_, bound)| bound > 1));
        let safe = match over {
            Some(place) => CertificateAnswer::no(NetProperty::Safe, Evidence::Overfull(self.two_on(place), id(place))),
            None if sums.bounds.iter().all(|&(_, bound)| bound <= 1) => {
                CertificateAnswer::yes(NetProperty::Safe, Evidence::Sums(sums.clone()))
            }
            None => CertificateAnswer::Unknown(super::Unknown::TooLong),
        };
        (bounds, CertificateAnswer::yes(NetProperty::Bounded, Evidence::Sums(sums)), safe)
    }

    fn two_on(&self, place: usize) -> Vec<RepeatedFiring> {
        let (found, on) = self.behind(vec![place]);
        let (mut run, mut missing) = (Vec::new(), 2);
        for from in found {
            let times = u64::from(self.tokens[from]).min(missing);
            if times > 0 {
                self.send(from, times, &on, &mut run);
                missing -= times;
            }
        }
        run
    }
}
