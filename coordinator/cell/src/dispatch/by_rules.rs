//! The dispatcher with rules: all that could start stands in one line, and is started as long as there are tokens.
//!
//! The line is sorted by urgency ([`super::urgency`]), then parts inside before parts outside, then by the chain of rules,
//! then by the longest wait, part and mode. The first in the line starts unless one before it has taken what it needs. In
//! a group of candidates that compete none is left that could still start; candidates of different groups never take
//! anything from each other, so one line for all of them is as good as one for each. Structural conflicts and those of the
//! moment (seed 000, L2777-2782, L2849) are both conflicts for tokens here.
//!
//! A rule orders candidates and holds none back: only [`DispatchRule::Schedule`] does, until its window opens, and an urgent
//! part's reservation.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ids::{CellId, ModeId, PartId};
use super::super::plan::{CellKind, PartPick};
use super::super::question::{DispatchDecision, Dispatcher, HeldCandidate, Question, Start};
use super::super::reason::{DecidingRule, HoldReason, LostDecision};
use super::super::state::PlayerState;
use super::super::table::CellTable;
use linewright_cell::DispatchRule;

use super::measure::Measure;
use super::priorities::{Admission, PartPriorities, Timetable};
use super::rule::RuleInputs;
use super::urgency::{Fairness, Urgent, pursue, urgent};
use super::ways::ShortestRoutes;

/// Decides by rules. It keeps nothing from one question to the next: the same question has the same answer.
#[derive(Clone, Debug)]
pub struct RuleDispatcher {
    /// The first decides, what it leaves equal the next does. Where there are none, the longest wait is first.
    pub rules: Vec<DispatchRule>,
    /// Measures against waiting for ever.
    pub fairness: Fairness,
    /// Due dates and priorities of parts.
    pub jobs: PartPriorities,
    /// Planned starts. They count only with [`DispatchRule::Schedule`].
    pub timetable: Timetable,
    ways: Arc<ShortestRoutes>,
}

impl RuleDispatcher {
    /// For a cell, with these rules, and this patience with a part that could do something and does not.
    pub fn new(table: &CellTable, rules: &[DispatchRule], patience: Duration) -> Self {
        RuleDispatcher {
            rules: rules.to_vec(),
            fairness: Fairness::after(patience),
            jobs: PartPriorities::default(),
            timetable: Timetable::default(),
            ways: Arc::new(ShortestRoutes::new(table)),
        }
    }

    /// Shortest routes of parts, by the table.
    pub fn ways(&self) -> &ShortestRoutes {
        &self.ways
    }

    /// All that could start and that nothing holds, in the order in which the rules would have it, whether there is enough
    /// for all of it or not.
    pub fn preference(&self, question: &Question<'_>) -> Vec<Start> {
        let facts = self.facts(question.now, question.state);
        let (line, _) = self.line(question, &facts, &[], None);
        line.into_iter().map(|entry| Start { candidate: entry.candidate, part: entry.part }).collect()
    }

    fn facts<'a>(&'a self, now: Tick, state: &'a PlayerState) -> RuleInputs<'a> {
        let timetable = if self.rules.contains(&DispatchRule::Schedule) { &self.timetable } else { &NO_TIMETABLE };
        RuleInputs { now, state, ways: &self.ways, jobs: &self.jobs, timetable }
    }

    /// Whether a part has waited longer than `patience`: then urgency alone decides.
    pub fn is_pressed(&self, now: Tick, state: &PlayerState) -> bool {
        self.fairness.patience.is_some_and(|patience| !urgent(&self.facts(now, state), patience).is_empty())
    }

    /// The queue of candidates, the next to start first; and for each candidate held independently of the others, the reason.
    fn line(
        &self,
        question: &Question<'_>,
        facts: &RuleInputs<'_>,
        late: &[Urgent],
        helper: Option<(ModeId, Option<PartId>)>,
    ) -> (Vec<QueueEntry>, HeldCandidates) {
        let late: BTreeMap<_, Rank> = late.iter().map(Urgent::rank).collect();
        let (mut line, mut asleep) = (Vec::new(), BTreeMap::new());
        for (candidate, of) in question.candidates.iter().enumerate() {
            let mode = of.mode;
            // A helper is always one of the candidates, with the first of its parts.
            let mut helps = helper.filter(|(helper, _)| *helper == mode).map(|(_, of)| Rank::Helper(of));
            let outside = (!question.takes_part(of)).then_some(None);
            for part in question.parts(of).map(Some).chain(outside) {
                let helps = helps.take();
                // What makes way for another does not wait for a window. Nothing enters to make way.
                let counts = |(reason, _): &(HoldReason, _)| helps.is_none() || *reason == HoldReason::NotOrdered;
                if let Some(holds) = facts.holds(part, mode).filter(counts) {
                    let first = asleep.entry(candidate).or_insert(holds);
                    let sooner = holds.1.is_some_and(|until| first.1.is_none_or(|first| until < first));
                    *first = if sooner { holds } else { *first };
                    continue;
                }
                let usual = if part.is_some() { Rank::Inside } else { Rank::Outside };
                let late = late.get(&(part, part.is_none().then_some(mode))).copied();
                let rank = helps.or(late).unwrap_or(usual);
                let since = facts.since(part, mode).unwrap_or(Tick::NEVER);
                let measures = self.rules.iter().map(|&rule| facts.measure(rule, part, mode)).collect();
                line.push(QueueEntry { candidate, mode, part, rank, since, measures });
            }
        }
        line.sort_unstable_by(QueueEntry::compare);
        (line, asleep)
    }
}

/// Of candidates that are held whatever the others do, why, and until when, if that is known.
type HeldCandidates = BTreeMap<usize, (HoldReason, Option<Tick>)>;

/// A candidate in the line.
struct QueueEntry {
    candidate: usize,
    mode: ModeId,
    part: Option<PartId>,
    rank: Rank,
    since: Tick,
    measures: Vec<Measure>,
}

/// Rank before all rules, the first first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    /// It makes way for the first that has waited too long; none if that is outside.
    Helper(Option<PartId>),
    /// It has waited too long, since then; parts inside first.
    Urgent(Tick, bool, Option<PartId>),
    Inside,
    /// It would enter, or is no part at all.
    Outside,
}

impl QueueEntry {
    fn compare(&self, other: &QueueEntry) -> Ordering {
        let key = |of: &QueueEntry| (of.since, of.part, of.mode);
        let by_rules = || self.by_rules(other).map_or(Ordering::Equal, |(_, order)| order);
        self.rank.cmp(&other.rank).then_with(by_rules).then_with(|| key(self).cmp(&key(other)))
    }

    /// The first rule that distinguishes the two.
    fn by_rules(&self, other: &QueueEntry) -> Option<(usize, Ordering)> {
        let pairs = self.measures.iter().zip(&other.measures).map(|(ours, theirs)| ours.compare(theirs));
        pairs.enumerate().find(|&(_, order)| order != Ordering::Equal)
    }

    /// Reason why it comes before another.
    fn deciding_rule(&self, other: &QueueEntry) -> DecidingRule {
        if self.rank != other.rank {
            return match self.rank {
                Rank::Helper(part) => DecidingRule::Helps { part },
                Rank::Urgent(..) => DecidingRule::Waited,
                // Outside is before none.
                Rank::Inside | Rank::Outside => DecidingRule::Inside,
            };
        }
        match self.by_rules(other) {
            Some((at, _)) => {
                let (theirs, ours) = (self.measures[at], other.measures[at]);
                DecidingRule::Rule { rule: theirs.rule, theirs, ours }
            }
            None => DecidingRule::Order,
        }
    }
}

impl Dispatcher for RuleDispatcher {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let facts = self.facts(question.now, question.state);
        let late = self.fairness.patience.map(|patience| urgent(&facts, patience)).unwrap_or_default();
        let pursuit = pursue(question, &self.ways, self.fairness, &late);
        let helper = pursuit.as_ref().and_then(|pursuit| Some((pursuit.helper()?, pursuit.part)));
        let (line, asleep) = self.line(question, &facts, &late, helper);
        let reserves = pursuit.filter(|_| self.fairness.reserves);
        let claims = reserves.as_ref().map(|pursuit| pursuit.claims(question, &self.ways)).unwrap_or_default();
        let claimed_by = reserves.and_then(|pursuit| pursuit.part);
        let admission = facts.jobs.admission.as_ref();
        let mut taking =
            QueueScan { question, line: &line, taken: RuleTaken::default(), claims, claimed_by, admission };
        taking.answer(&asleep)
    }
}

static NO_TIMETABLE: Timetable = Timetable::EMPTY;

impl Urgent {
    /// Part, or mode outside, and its place in the line.
    fn rank(&self) -> ((Option<PartId>, Option<ModeId>), Rank) {
        let outside = self.part.is_none().then(|| self.options.first().copied()).flatten();
        ((self.part, outside), Rank::Urgent(self.since, self.part.is_none(), self.part))
    }
}

/// Tokens given away so far, and the takers' positions in the line.
#[derive(Default)]
struct RuleTaken {
    tokens: BTreeMap<CellId, (u64, usize)>,
    parts: BTreeMap<PartId, usize>,
    /// Cells that give one part after the other.
    ordered: BTreeMap<CellId, usize>,
    /// Of each product how many enter.
    entered: BTreeMap<usize, u32>,
}

/// Going along the line.
struct QueueScan<'a> {
    question: &'a Question<'a>,
    line: &'a [QueueEntry],
    taken: RuleTaken,
    claims: BTreeMap<CellId, (u64, ModeId)>,
    claimed_by: Option<PartId>,
    admission: Option<&'a Admission>,
}

impl QueueScan<'_> {
    fn answer(&mut self, asleep: &HeldCandidates) -> DispatchDecision {
        let mut answer = DispatchDecision::default();
        let mut started = vec![0; self.question.candidates.len()];
        let (mut reasons, mut elsewhere) = (vec![None; started.len()], vec![None; started.len()]);
        for (at, entry) in self.line.iter().enumerate() {
            let times = &mut started[entry.candidate];
            if *times >= self.question.candidates[entry.candidate].times {
                continue;
            }
            if let Some(&winner) = entry.part.and_then(|part| self.taken.parts.get(&part)) {
                elsewhere[entry.candidate].get_or_insert(self.lost(entry, winner));
                continue;
            }
            match self.in_the_way(entry) {
                None => {
                    *times += 1;
                    self.take(at, entry);
                    answer.start.push(Start { candidate: entry.candidate, part: entry.part });
                }
                // It holds for all parts; it is given with the best of them.
                Some(reason) => _ = reasons[entry.candidate].get_or_insert(reason),
            }
        }
        for (candidate, reason) in reasons.into_iter().enumerate().filter(|&(at, _)| started[at] == 0) {
            let held = asleep.get(&candidate);
            let reason = reason.or(held.map(|&(reason, _)| reason)).or(elsewhere[candidate]);
            let until = held.and_then(|&(_, until)| until);
            answer.held.extend(reason.map(|reason| HeldCandidate { candidate, reason, until }));
        }
        answer
    }

    /// Reason why a mode cannot start with any part any more.
    fn in_the_way(&self, entry: &QueueEntry) -> Option<HoldReason> {
        let (state, table) = (self.question.state, self.question.state.table());
        let lane = table.part_in(entry.mode).and_then(|cell| self.taken.ordered.get(&cell));
        if let Some(&winner) = lane {
            return Some(self.lost(entry, winner));
        }
        for &(cell, weight) in table.takes(entry.mode) {
            let has = state.marking().count(cell);
            let gone = self.taken.tokens.get(&cell);
            let needed = gone.map_or(0, |(gone, _)| *gone) + u64::from(weight);
            if let Some(&(_, winner)) = gone.filter(|_| needed > has) {
                return Some(self.lost(entry, winner));
            }
        }
        if entry.part.is_none() && table.part_out(entry.mode).is_some() {
            let is_full = |admission: &&Admission| admission.room(entry.mode, &self.taken.entered) == 0;
            if self.admission.is_some_and(|admission| is_full(&admission)) {
                return Some(HoldReason::NotOrdered);
            }
        }
        match entry.rank {
            Rank::Helper(_) => return None,
            Rank::Urgent(..) | Rank::Inside | Rank::Outside => (),
        }
        table.takes(entry.mode).iter().find_map(|&(cell, weight)| {
            let &(claim, mode) = self.claims.get(&cell)?;
            let gone = self.taken.tokens.get(&cell).map_or(0, |(gone, _)| *gone);
            let is_short = gone + u64::from(weight) + claim > state.marking().count(cell);
            is_short.then_some(HoldReason::ReservedFor { part: self.claimed_by, mode })
        })
    }

    fn lost(&self, entry: &QueueEntry, winner: usize) -> HoldReason {
        let winner = &self.line[winner];
        HoldReason::LostTo(LostDecision {
            to: winner.mode,
            with: winner.part,
            own: entry.part,
            by: winner.deciding_rule(entry),
        })
    }

    fn take(&mut self, at: usize, entry: &QueueEntry) {
        let table = self.question.state.table();
        for &(cell, weight) in table.takes(entry.mode) {
            let (gone, by) = self.taken.tokens.entry(cell).or_insert((0, at));
            *gone += u64::from(weight);
            *by = at;
        }
        self.taken.parts.extend(entry.part.map(|part| (part, at)));
        let product = self.admission.and_then(|admission| admission.product.get(&entry.mode));
        product.into_iter().for_each(|&product| *self.taken.entered.entry(product).or_default() += 1);
        if let Some(cell) = table.part_in(entry.mode) {
            match table.kind(cell) {
                CellKind::Parts(PartPick::Oldest | PartPick::Newest) => _ = self.taken.ordered.insert(cell, at),
                CellKind::Tokens | CellKind::Parts(PartPick::Any) => (),
            }
        }
    }
}
