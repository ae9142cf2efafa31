//! Every answer in whole runs of random cells, judged from the coloured net and by definition: it can be started together,
//! it leaves nothing that could start as well, and it is always the same.

use std::collections::BTreeSet;
use std::time::Duration;

use linewright_coordinator_cell::dispatch::{
    DispatchRule, EntryCandidate, Fairness, PartPriority, RuleDispatcher, Window,
};
use linewright_coordinator_cell::{
    Candidate, ConflictGroup, DispatchDecision, Dispatcher, Fifo, HoldReason, ModeId, PartPlace, Question, Start,
};
use linewright_line::Tick;
use linewright_nets::Marking;
use linewright_nets::coloured::ColouredNet;

use crate::player::enabled::moves;
use crate::player::plans::Compiled;
use crate::player::printed::{Variant, compiled};
use crate::player::workcell::{self, Workcell};
use crate::player::world::World;
use linewright_random::Random as Dice;

/// Puts questions to a dispatcher and checks its answers.
struct Judge {
    inner: RuleDispatcher,
    dice: Dice,
    net: ColouredNet,
    long: linewright_nets::coloured::Unfolding,
    /// Tokens that each mode takes, by the coloured net.
    takes: Vec<Vec<(usize, u32)>>,
    asked: usize,
    started: usize,
    kept: usize,
    several: usize,
}

impl Judge {
    fn new(it: &Compiled, inner: RuleDispatcher, seed: u64) -> Self {
        let takes = moves(it).into_iter().map(|[takes, _]| takes).collect();
        let (net, long) = (it.net.clone(), it.long.clone());
        Judge { inner, dice: Dice::new(seed), net, long, takes, asked: 0, started: 0, kept: 0, several: 0 }
    }

    /// Parts that come get due dates and priorities by chance, and some of them windows.
    fn tell(&mut self, question: &Question<'_>) {
        for part in question.state.parts() {
            if self.inner.jobs.parts.contains_key(&part.id) {
                continue;
            }
            let due = (!self.dice.one_in(4)).then(|| Tick::from_millis(self.dice.below(60_000) as u64));
            self.inner.jobs.parts.insert(part.id, PartPriority { due, priority: self.dice.below(3) as i32 });
            if let PartPlace::On { cell, .. } = part.place {
                for &mode in question.state.table().consumers(cell) {
                    let from = question.now + Duration::from_millis(self.dice.below(4000) as u64);
                    let until = from + Duration::from_millis(self.dice.below(4000) as u64);
                    self.inner.timetable.windows.insert((Some(part.id), mode), Window { from, until });
                }
            }
        }
        for candidate in question.candidates.iter().filter(|of| !question.takes_part(of)) {
            let job = PartPriority { due: None, priority: self.dice.below(3) as i32 };
            let waiting = EntryCandidate { job, since: question.now };
            self.inner.jobs.outside.entry(candidate.mode).or_insert(waiting);
        }
    }

    fn judge(&mut self, question: &Question<'_>, answer: &DispatchDecision) {
        let on_cells = question.state.parts().filter(|part| matches!(part.place, PartPlace::On { .. }));
        let mut waiting: Vec<_> = on_cells.collect();
        waiting.sort_by_key(|part| (part.since, part.id));
        assert!(question.state.waiting().eq(waiting), "those that wait, the longest first");
        let has = question.state.marking().counts();
        let coloured = self.long.coloured(&Marking::from_tokens(has.iter().map(|&count| count as u32)));
        let enabled: BTreeSet<_> =
            self.net.enabled(&coloured).iter().map(|&mode| ModeId(self.long.transition_of(mode).unwrap().0)).collect();
        let mut needed = vec![0_u64; has.len()];
        let mut parts = BTreeSet::new();
        let mut times = vec![0; question.candidates.len()];
        for start in &answer.start {
            let mode = question.candidates[start.candidate].mode;
            assert!(enabled.contains(&mode), "{mode}");
            self.takes[mode.index()].iter().for_each(|&(cell, weight)| needed[cell] += u64::from(weight));
            times[start.candidate] += 1;
            let takeable: Vec<_> = question.parts(&question.candidates[start.candidate]).collect();
            assert_eq!(start.part.is_none(), takeable.is_empty());
            assert!(start.part.is_none_or(|part| takeable.contains(&part) && parts.insert(part)), "{start:?}");
        }
        assert!(needed.iter().zip(has).all(|(needed, has)| needed <= has), "what starts has its tokens");
        for (at, candidate) in question.candidates.iter().enumerate() {
            let held: Vec<_> = answer.held.iter().filter(|held| held.candidate == at).collect();
            assert_eq!(held.len(), usize::from(times[at] == 0), "started or held for a reason");
            let free = |&(cell, weight): &(usize, u32)| needed[cell] + u64::from(weight) <= has[cell];
            let could = times[at] < candidate.times && self.takes[candidate.mode.index()].iter().all(free);
            match held.first().map(|held| held.reason) {
                Some(HoldReason::LostTo(lost)) => {
                    assert!(!could, "{lost:?}");
                    let winner = |start: &Start| question.candidates[start.candidate].mode == lost.to;
                    assert!(answer.start.iter().any(|start| winner(start) && start.part == lost.with));
                }
                Some(HoldReason::ReservedFor { .. }) => {
                    assert!(self.inner.fairness.patience.is_some() && self.inner.fairness.reserves);
                    // A later one may have taken something else that it needs.
                    self.kept += usize::from(could);
                }
                Some(HoldReason::NotYet(until)) => {
                    assert!(self.inner.rules.contains(&DispatchRule::Schedule) && until > question.now);
                    assert_eq!(held[0].until, Some(until));
                }
                Some(
                    reason @ (HoldReason::NotOrdered | HoldReason::PlannedOtherwise(_) | HoldReason::LooksWorse(_)),
                ) => {
                    panic!("nobody told it of anything like {reason:?}")
                }
                None => assert!(!could || self.may_hold(), "{candidate:?} could start once more"),
            }
        }
    }

    /// Whether anything but a lost conflict can keep something back.
    fn may_hold(&self) -> bool {
        self.inner.rules.contains(&DispatchRule::Schedule) || self.inner.fairness.patience.is_some()
    }

    /// Decisions about each group alone, together.
    fn one_by_one(&mut self, question: &Question<'_>) -> BTreeSet<(ModeId, Option<u64>)> {
        let mut all = BTreeSet::new();
        for group in question.groups {
            let alone = |&at: &usize| Candidate { group: 0, ..question.candidates[at] };
            let candidates: Vec<Candidate> = group.candidates.iter().map(alone).collect();
            let groups =
                [ConflictGroup { candidates: (0..candidates.len()).collect(), contested: group.contested.clone() }];
            let answer = self.inner.decide(&Question { candidates: &candidates, groups: &groups, ..*question });
            all.extend(
                answer.start.iter().map(|start| (candidates[start.candidate].mode, start.part.map(|part| part.0))),
            );
        }
        all
    }
}

impl Dispatcher for Judge {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.tell(question);
        let answer = self.inner.decide(question);
        assert_eq!(answer, self.inner.clone().decide(question), "the same question has the same answer");
        self.judge(question, &answer);
        if !self.may_hold() {
            let started =
                answer.start.iter().map(|start| (question.candidates[start.candidate].mode, start.part.map(|p| p.0)));
            assert_eq!(
                started.collect::<BTreeSet<_>>(),
                self.one_by_one(question),
                "groups do not matter to each other"
            );
        }
        if self.inner.rules.is_empty() && !self.may_hold() && self.inner.jobs.outside.is_empty() {
            assert_eq!(answer.start, Fifo.decide(question).start, "without rules, first come first served");
        }
        self.asked += 1;
        self.started += answer.start.len();
        self.several += usize::from(question.groups.len() > 1);
        answer
    }
}

fn rules(dice: &mut Dice) -> Vec<DispatchRule> {
    (0..dice.below(4)).map(|_| dice.pick(&DispatchRule::ALL).1).collect()
}

fn fairness(dice: &mut Dice) -> Fairness {
    match dice.below(3) {
        0 => Fairness::OFF,
        1 => Fairness::after(Duration::from_millis(100 + dice.below(3000) as u64)),
        _ => Fairness::after(Duration::ZERO),
    }
}

#[test]
fn every_answer_of_random_workcells_stands_before_the_net_and_all_parts_are_finished() {
    let (mut asked, mut started, mut kept, mut several) = (0, 0, 0, 0);
    for seed in 0..150 {
        let mut dice = Dice::new(seed);
        let cell = Workcell::random(&mut dice);
        let it = workcell::compiled(&cell);
        let mut inner = RuleDispatcher::new(&it.table, &rules(&mut dice), Duration::ZERO);
        inner.fairness = fairness(&mut dice);
        let mut judge = Judge::new(&it, inner, seed);
        let mut world = World::new(it, cell.stations(), seed);
        world.run(&mut judge, Tick::from_millis(600_000));
        assert_eq!(world.state().left(), u64::from(cell.parts()), "{seed}: {:?}", judge.inner.rules);
        asked += judge.asked;
        started += judge.started;
        kept += judge.kept;
        several += judge.several;
    }
    assert!(asked > 2000 && started > 2000 && kept > 50 && several > 500, "{asked} {started} {kept} {several}");
}

/// The cell of seed 000, whose parts come back for ever.
#[test]
fn every_answer_of_the_printed_cell_stands_before_its_net() {
    let mut kept = 0;
    for seed in 0..20 {
        let mut dice = Dice::new(seed);
        let it = compiled(&Variant { outside: [2, 2, 1], ..Variant::default() });
        let mut inner = RuleDispatcher::new(&it.table, &rules(&mut dice), Duration::ZERO);
        inner.fairness = fairness(&mut dice);
        let mut judge = Judge::new(&it, inner, seed);
        let mut world = World::new(it, 3, seed);
        world.run(&mut judge, Tick::from_millis(120_000));
        assert!(world.state().left() > 20, "{seed}: {}", world.state().left());
        kept += judge.kept;
    }
    assert!(kept > 20, "{kept}");
}
