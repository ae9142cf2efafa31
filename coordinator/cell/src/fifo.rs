//! First come, first served: the dispatcher that is always there.
//!
//! The part that has been where it is for the longest time goes first, ties by the part's number and then by the mode; it
//! holds nothing back. Modes that let parts enter come after all that move one, so that a part inside is never kept from
//! going on by one outside. It also answers where another dispatcher's answer cannot be followed.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use linewright_line::Tick;

use super::ids::{CellId, ModeId, PartId};
use super::question::{DispatchDecision, Dispatcher, HeldCandidate, Question, Start};
use super::reason::{DecidingRule, HoldReason, LostDecision};

/// First come, first served.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fifo;

/// Entry of a candidate in the line: its next part, or how often it can still start.
type FifoCandidate = Reverse<(Tick, Option<PartId>, ModeId, usize)>;

impl Dispatcher for Fifo {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let mut answer = DispatchDecision::default();
        let mut taken = FifoTaken::default();
        let mut parts: Vec<_> = question.candidates.iter().map(|candidate| question.parts(candidate)).collect();
        let mut started = vec![0; question.candidates.len()];
        let mut line: BinaryHeap<FifoCandidate> = BinaryHeap::new();
        for (index, parts) in parts.iter_mut().enumerate() {
            line.extend(next(question, parts, index, &taken.parts));
        }
        while let Some(Reverse((_, part, mode, index))) = line.pop() {
            if part.is_some_and(|part| taken.parts.contains(&part)) {
                line.extend(next(question, &mut parts[index], index, &taken.parts));
                continue;
            }
            if taken.in_the_way(question, mode).is_some() {
                // Tokens only become fewer, so there will be none for its other parts either.
                continue;
            }
            taken.take(question, mode, part);
            answer.start.push(Start { candidate: index, part });
            started[index] += 1;
            if started[index] < question.candidates[index].times {
                line.extend(next(question, &mut parts[index], index, &taken.parts));
            }
        }
        let idle = started.iter().zip(question.candidates).enumerate().filter(|(_, (times, _))| **times == 0);
        answer.held.extend(idle.filter_map(|(candidate, (_, lost))| {
            let (to, with) = taken.in_the_way(question, lost.mode)?;
            let own = question.parts(lost).next();
            let reason = HoldReason::LostTo(LostDecision { to, with, own, by: DecidingRule::Order });
            Some(HeldCandidate { candidate, reason, until: None })
        }));
        answer
    }
}

fn next(
    question: &Question<'_>,
    parts: &mut impl Iterator<Item = PartId>,
    index: usize,
    gone: &BTreeSet<PartId>,
) -> Option<FifoCandidate> {
    let candidate = &question.candidates[index];
    if !question.takes_part(candidate) {
        return Some(Reverse((Tick::NEVER, None, candidate.mode, index)));
    }
    let part = parts.find(|part| !gone.contains(part))?;
    let since = question.state.part(part)?.since;
    Some(Reverse((since, Some(part), candidate.mode, index)))
}

/// Tokens given away so far, and to which first.
#[derive(Default)]
struct FifoTaken {
    parts: BTreeSet<PartId>,
    tokens: BTreeMap<CellId, (u64, (ModeId, Option<PartId>))>,
}

impl FifoTaken {
    /// The start that took tokens the mode would need.
    fn in_the_way(&self, question: &Question<'_>, mode: ModeId) -> Option<(ModeId, Option<PartId>)> {
        let short = |&(cell, weight): &(CellId, u32)| {
            let &(gone, by) = self.tokens.get(&cell)?;
            (gone + u64::from(weight) > question.state.marking().count(cell)).then_some(by)
        };
        question.state.table().takes(mode).iter().find_map(short)
    }

    fn take(&mut self, question: &Question<'_>, mode: ModeId, part: Option<PartId>) {
        self.parts.extend(part);
        for &(cell, weight) in question.state.table().takes(mode) {
            self.tokens.entry(cell).or_insert((0, (mode, part))).0 += u64::from(weight);
        }
    }
}
