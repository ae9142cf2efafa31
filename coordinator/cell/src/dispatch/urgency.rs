//! No part waits for ever: precedence and reservations of a part that has waited too long.
//!
//! No rule but first come, first served is fair. With any other one a part can wait as long as better ones come, and even
//! the fair one starves a part that needs two things which others take in turns. So a part that has been where it is for
//! longer than the *patience* is **urgent**, and
//! 1. urgent parts come before all others, the one that has waited longest first (then the smaller number);
//! 2. **reservation**: if the first of them cannot start, and all it lacks will come back from activities in progress, then
//!    what it needs is kept, and no other starts with it: capacities and parts at once, and what always comes back by
//!    itself (robots) as soon as nothing else is lacking, so that robots work on as long as they can;
//! 3. **inheritance**: if something it lacks does *not* come back from what is in progress (the store is full, a machine is
//!    to be unloaded or cleaned), what would bring it back is pursued in its place, and so on: a *chain* of modes down to a
//!    *helper* that can start, or will. The helper starts before all others (1) or has what it needs kept (2). Of the rest of
//!    the chain, the capacities that are there are kept as well.
//!
//! # Why no part waits for ever
//! Assume that the cell can always go on (that it has no deadlock is checked beforehand), that plans end, that an activity
//! in progress ends or fails within its limit, and that a mode needs, beside its part and robots, one capacity: the place
//! its part goes to. Let *u* be the first urgent part. It stays the first until it moves, since a part that moves has waited
//! for no time at all.
//! - *u can start.* Then it does, now: it is the first of all, and only modes that have all they need are candidates.
//! - *u lacks what comes back.* Capacities and parts arrive within the limits of what is in progress, and stay, since they
//!   are kept. Then only robots are lacking; each comes back within the limits of what is in progress, and stays. So after
//!   at most twice that time u starts. Where there are several such ways, only one of a smaller number replaces the one that
//!   is kept for, and that one stays good as long as it is kept for: this happens at most as often as there are ways.
//! - *u lacks what does not come back.* Then there is a chain, since the cell can go on. The search takes a shortest one, by
//!   layers: what can start, or will, is in layer 0, and a mode is in the layer above the last of what it lacks. A chain goes
//!   down layer by layer, so it never comes back to itself. By the two cases above the helper starts within a bound. While
//!   it is in progress, what it will give is on its way to the mode above it in the chain, which lacks nothing else that
//!   does not come back: so it is the next helper, and u is nearer by one. As a distance is at most the number of modes, and
//!   what is kept does not become less, u starts.
//!
//! So u moves within a bound B that depends on the cell alone. Only parts that have waited longer come before a part; they
//! are finitely many, none is added, and each moves within B: it moves within patience + (1 + number of those) × B. Plans end,
//! so every part is finished.
//!
//! This is an argument for cells of that kind, not a proof for every net: where a mode needs two capacities at once (the
//! top of a stack and a place elsewhere), what is kept for the chain is meant to serve as well, but two modes of one chain
//! may need the same one. A cell that gives its *newest* part first is not fair by itself: a part beneath has no way
//! before the part upon it, and others may be put on top. Where no mode would help (a machine waits for a person), a part
//! has no chain: it is passed over and keeps nothing from others, and the next urgent part is the first.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::Tick;

use super::super::firing::ActivityPhase;
use super::super::ids::{CellId, ModeId, PartId};
use super::super::question::Question;
use super::super::state::PartPlace;
use super::rule::RuleInputs;
use super::ways::ShortestRoutes;

/// Measures against waiting for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fairness {
    /// Waiting time after which a part is urgent. `None`: parts never become urgent.
    pub patience: Option<Duration>,
    /// Tokens that an urgent part needs are kept for it. Without this, parts can wait for ever.
    pub reserves: bool,
    /// Modes that clear the way of an urgent part are pursued in its place. Without this, parts can wait for ever.
    pub inherits: bool,
}

impl Fairness {
    /// With all that it takes.
    pub fn after(patience: Duration) -> Self {
        Fairness { patience: Some(patience), reserves: true, inherits: true }
    }

    /// By the rules alone, whatever waits.
    pub const OFF: Fairness = Fairness { patience: None, reserves: false, inherits: false };
}

/// A part that has waited too long.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Urgent {
    pub(super) since: Tick,
    pub(super) part: Option<PartId>,
    /// Modes that it could start next, if their tokens were there.
    pub(super) options: Vec<ModeId>,
}

/// Progress of an urgent part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UrgencyProgress {
    /// Urgent part; `None`: one outside.
    pub(super) part: Option<PartId>,
    /// Modes from that of the part down to the helper.
    chain: Vec<ModeId>,
    /// The helper can start now.
    is_ready: bool,
}

/// Obstacle between a mode and its start.
enum UrgencyStatus {
    /// It can start now.
    Ready,
    /// All it lacks comes back by itself.
    Pending,
    /// These do not.
    Lacks(Vec<CellId>),
    /// It cannot start for a reason that no decision here changes.
    Stuck,
}

/// The urgent parts, the first first. A part that the timetable makes wait is not.
pub(super) fn urgent(facts: &RuleInputs<'_>, patience: Duration) -> Vec<Urgent> {
    let table = facts.state.table();
    let is_over = |since: Tick| since + patience <= facts.now;
    let inside = facts.state.waiting().take_while(|part| is_over(part.since)).filter_map(|part| match part.place {
        PartPlace::On { cell, arrival: _ } => {
            let moves = table.consumers(cell).iter().copied();
            let mut options: Vec<_> = moves.filter(|&mode| table.part_in(mode) == Some(cell)).collect();
            options.retain(|&mode| !table.is_immediate(mode));
            Some(Urgent { since: part.since, part: Some(part.id), options })
        }
        PartPlace::In(_) => None,
    });
    let waiting = facts.jobs.outside.iter().filter(|(mode, of)| mode.index() < table.mode_count() && is_over(of.since));
    let outside = waiting.map(|(&mode, of)| Urgent { since: of.since, part: None, options: vec![mode] });
    let mut all: Vec<Urgent> = inside.chain(outside).collect();
    for urgent in &mut all {
        let part = urgent.part;
        urgent.options.retain(|&mode| facts.holds(part, mode).is_none());
    }
    all.retain(|urgent| !urgent.options.is_empty());
    // Parts outside come after parts inside.
    all.sort_unstable_by_key(|urgent| (urgent.since, urgent.part.is_none(), urgent.part, urgent.options[0]));
    all
}

/// Measures for the first of them that has any; nothing if it can start itself.
pub(super) fn pursue(
    question: &Question<'_>,
    ways: &ShortestRoutes,
    fairness: Fairness,
    all: &[Urgent],
) -> Option<UrgencyProgress> {
    if all.is_empty() {
        // What is in progress need not be looked at.
        return None;
    }
    let search = UrgencySearch::new(question, ways, fairness);
    for urgent in all {
        let is_first = |&part: &PartId| urgent.part == Some(part);
        let starts = |&mode: &ModeId| {
            search.is_candidate(mode)
                && (urgent.part.is_none() || question.state.takeable(mode).any(|part| is_first(&part)))
        };
        if urgent.options.iter().any(starts) {
            return None;
        }
        if let Some(chain) = search.chain(&urgent.options) {
            let is_ready = chain.last().is_some_and(|&mode| search.is_candidate(mode));
            return Some(UrgencyProgress { part: urgent.part, chain, is_ready });
        }
    }
    None
}

impl UrgencyProgress {
    /// Mode that starts before all others, if it can; tokens are kept for others in any case.
    pub(super) fn helper(&self) -> Option<ModeId> {
        self.chain.last().copied().filter(|_| self.is_ready)
    }

    /// Tokens to be kept, and for which mode.
    pub(super) fn claims(&self, question: &Question<'_>, ways: &ShortestRoutes) -> BTreeMap<CellId, (u64, ModeId)> {
        let mut claims = BTreeMap::new();
        let (last, table) = (self.chain.len() - 1, question.state.table());
        // Where it waits for nothing but robots, what has come of these is kept as well.
        let is_there = |&(cell, weight): &(CellId, u32)| question.state.marking().count(cell) >= u64::from(weight);
        let waits_for_carriers =
            !self.is_ready && table.takes(self.chain[last]).iter().all(|of| is_there(of) || ways.comes_back(of.0));
        let waits_at = waits_for_carriers.then_some(last);
        for (at, &mode) in self.chain.iter().enumerate() {
            for &(cell, weight) in table.takes(mode) {
                if waits_at == Some(at) || ((at < last || !self.is_ready) && !ways.comes_back(cell)) {
                    claims.entry(cell).or_insert((0, mode)).0 += u64::from(weight);
                }
            }
        }
        claims
    }
}

/// A search from a mode down to one that can start.
struct UrgencySearch<'a> {
    question: &'a Question<'a>,
    ways: &'a ShortestRoutes,
    fairness: Fairness,
    /// Tokens that activities in progress will give.
    returning: BTreeMap<CellId, u64>,
    /// Modes in progress that will end.
    running: BTreeSet<ModeId>,
}

impl<'a> UrgencySearch<'a> {
    fn new(question: &'a Question<'a>, ways: &'a ShortestRoutes, fairness: Fairness) -> Self {
        let (mut returning, mut running) = (BTreeMap::new(), BTreeSet::new());
        for firing in question.state.firings() {
            match firing.phase {
                ActivityPhase::Running => {
                    running.insert(firing.mode);
                    for &(cell, weight) in question.state.table().gives(firing.mode) {
                        *returning.entry(cell).or_insert(0) += u64::from(weight);
                    }
                }
                // Its tokens come back after an operator's answer.
                ActivityPhase::Failed(_) => (),
            }
        }
        UrgencySearch { question, ways, fairness, returning, running }
    }

    fn is_candidate(&self, mode: ModeId) -> bool {
        self.question.candidates.binary_search_by_key(&mode, |candidate| candidate.mode).is_ok()
    }

    fn status(&self, mode: ModeId) -> UrgencyStatus {
        let state = self.question.state;
        if state.enabling().is_enabled(mode) {
            return if self.is_candidate(mode) {
                UrgencyStatus::Ready
            } else if state.table().is_immediate(mode) || self.running.contains(&mode) {
                UrgencyStatus::Pending
            } else {
                UrgencyStatus::Stuck
            };
        }
        if state.needs_down(mode).is_some() {
            return UrgencyStatus::Stuck;
        }
        let comes = |cell: CellId| state.marking().count(cell) + self.returning.get(&cell).copied().unwrap_or(0);
        let lacked = state.table().takes(mode).iter().filter(|&&(cell, weight)| comes(cell) < u64::from(weight));
        let lacked: Vec<CellId> = lacked.map(|&(cell, _)| cell).collect();
        if lacked.is_empty() { UrgencyStatus::Pending } else { UrgencyStatus::Lacks(lacked) }
    }

    /// The shortest chain from one of these modes to one that can start, or will; of equally short ones that of the
    /// smallest numbers.
    fn chain(&self, options: &[ModeId]) -> Option<Vec<ModeId>> {
        let SearchScope { mut first, lacks } = self.relevant(options);
        let mut missing: BTreeMap<ModeId, usize> = lacks.iter().map(|(&mode, cells)| (mode, cells.len())).collect();
        let mut lackers: BTreeMap<CellId, Vec<ModeId>> = BTreeMap::new();
        for (&mode, cells) in &lacks {
            cells.iter().for_each(|&cell| lackers.entry(cell).or_default().push(mode));
        }
        // Modes that bring a cell back, first those that can start and then those that will.
        let mut by: BTreeMap<CellId, ModeId> = BTreeMap::new();
        first.sort_unstable_by_key(|&mode| (!self.is_candidate(mode), mode));
        let mut layer = first;
        while !layer.is_empty() {
            if let Some(&option) = layer.iter().find(|mode| options.contains(mode)) {
                return Some(self.walk(option, &lacks, &by));
            }
            let mut next = BTreeSet::new();
            for &mode in &layer {
                for &(cell, _) in self.question.state.table().gives(mode) {
                    if by.contains_key(&cell) {
                        continue;
                    }
                    for &lacker in lackers.get(&cell).into_iter().flatten() {
                        by.insert(cell, mode);
                        if let Some(count) = missing.get_mut(&lacker) {
                            *count -= 1;
                            if *count == 0 {
                                next.insert(lacker);
                            }
                        }
                    }
                }
            }
            layer = next.into_iter().collect();
        }
        None
    }

    fn walk(
        &self,
        option: ModeId,
        lacks: &BTreeMap<ModeId, Vec<CellId>>,
        by: &BTreeMap<CellId, ModeId>,
    ) -> Vec<ModeId> {
        let mut chain = vec![option];
        let mut at = option;
        // Each is in a lower layer than the one before.
        while let Some(&below) = lacks.get(&at).and_then(|cells| by.get(cells.first()?)) {
            chain.push(below);
            at = below;
        }
        chain
    }

    /// Search scope: the modes pursued, those that bring back what they lack, and so on.
    fn relevant(&self, options: &[ModeId]) -> SearchScope {
        let (mut first, mut lacks) = (Vec::new(), BTreeMap::new());
        let mut seen: BTreeSet<ModeId> = options.iter().copied().collect();
        let mut open: Vec<ModeId> = options.to_vec();
        while let Some(mode) = open.pop() {
            match self.status(mode) {
                UrgencyStatus::Ready | UrgencyStatus::Pending => first.push(mode),
                UrgencyStatus::Lacks(cells) if self.fairness.inherits => {
                    let producers = cells.iter().flat_map(|&cell| self.ways.producers(cell));
                    open.extend(producers.copied().filter(|&mode| seen.insert(mode)));
                    lacks.insert(mode, cells);
                }
                UrgencyStatus::Lacks(_) | UrgencyStatus::Stuck => (),
            }
        }
        SearchScope { first, lacks }
    }
}

/// Scope of a search.
struct SearchScope {
    /// Modes that can start, or will.
    first: Vec<ModeId>,
    /// Modes that cannot, and what they lack that does not come back.
    lacks: BTreeMap<ModeId, Vec<CellId>>,
}
