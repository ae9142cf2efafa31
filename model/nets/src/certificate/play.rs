//! Turning counts of firings into a sequence that can be played, or searching for one.

use std::collections::{HashSet, VecDeque};

use super::evidence::RepeatedFiring;
use crate::{Marking, Net, TransitionId};

/// The most entries of a sequence: a longer certificate is of no use.
pub(super) const LONGEST: usize = 1_000_000;

/// Plays each transition as often as counted, whenever it is enabled. For nets in which firing one transition never
/// disables another, the order does not matter: if any order works, this one does. None if nothing works, or if the
/// sequence becomes longer than [`LONGEST`].
pub(super) fn play(net: &Net, mut counts: Vec<u64>) -> Option<Vec<RepeatedFiring>> {
    let mut tokens: Vec<u64> = net.initial_marking().as_slice().iter().map(|&count| count.into()).collect();
    let mut ahead: VecDeque<TransitionId> = net.transitions().filter(|t| counts[t.index()] > 0).collect();
    let mut runs: Vec<RepeatedFiring> = Vec::new();
    while let Some(t) = ahead.pop_front() {
        let enough = |&(place, weight): &(crate::PlaceId, u32)| tokens[place.index()] / u64::from(weight);
        let times = net.preset(t).iter().map(enough).min().unwrap_or(u64::MAX).min(counts[t.index()]);
        if times == 0 {
            continue;
        }
        if runs.len() == LONGEST {
            return None;
        }
        counts[t.index()] -= times;
        runs.push(RepeatedFiring { transition: t, times });
        net.preset(t).iter().for_each(|&(place, weight)| tokens[place.index()] -= times * u64::from(weight));
        for &(place, weight) in net.postset(t) {
            let count = &mut tokens[place.index()];
            *count = count.checked_add(times.checked_mul(weight.into())?)?;
            // Transitions that waited for the tokens, this one too, get another turn.
            ahead.extend(net.consumers(place).iter().map(|&(t, _)| t).filter(|t| counts[t.index()] > 0));
        }
    }
    counts.iter().all(|&count| count == 0).then_some(runs)
}

/// The nearest of the first `most` markings with a property, and a shortest sequence to it.
pub(super) fn find(
    net: &Net,
    most: usize,
    wanted: impl Fn(&Marking) -> bool,
) -> Option<(Vec<RepeatedFiring>, Marking)> {
    let mut seen = HashSet::from([net.initial_marking()]);
    let mut found: Vec<(Marking, Option<(usize, TransitionId)>)> = vec![(net.initial_marking(), None)];
    let mut next = 0;
    while next < found.len() {
        if wanted(&found[next].0) {
            let mut run = Vec::new();
            let mut at = next;
            while let Some((before, transition)) = found[at].1 {
                run.push(RepeatedFiring { transition, times: 1 });
                at = before;
            }
            run.reverse();
            return Some((run, found[next].0.clone()));
        }
        for t in net.transitions() {
            let mut marking = found[next].0.clone();
            if found.len() < most && net.fire(&mut marking, t).is_ok() && seen.insert(marking.clone()) {
                found.push((marking, Some((next, t))));
            }
        }
        next += 1;
    }
    None
}
