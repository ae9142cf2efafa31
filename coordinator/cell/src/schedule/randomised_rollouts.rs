//! Random futures: a plan is followed for a while, and then the rules decide, now and then overruled.
//!
//! Where there is too much to look through all of it, trying many futures near the best that is known finds better ones, and
//! can be stopped at any time. Chance is a number that is drawn from the one before: the same cell has the same schedule.

use std::collections::VecDeque;

use super::super::ahead::{PlanPolicy, PlannedStart, RolloutPolicy};
use super::super::dispatch::DispatchRule;
use super::super::production::DispatchConfiguration;
use super::super::question::{DispatchDecision, Dispatcher, Question};
use super::super::record::Record;

/// One in so many questions is decided against the rules.
const OVERRULED: usize = 8;

/// Numbers that look as if they were drawn (xorshift64*, Vigna 2016).
#[derive(Clone, Copy, Debug)]
pub(super) struct Xorshift(u64);

impl Xorshift {
    pub fn new() -> Self {
        Xorshift(0x9E37_79B9_7F4A_7C15)
    }

    /// A number below `bound`, which is at least 1.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let drawn = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33;
        // 31 bits; bounds are counts of a few thousand.
        drawn as usize % bound.max(1)
    }
}

/// Follows the beginning of a plan, and then its rules and chance.
pub(super) struct RandomPolicy {
    follow: PlanPolicy,
    chance: Xorshift,
    /// Number of questions that belong to the plan.
    plan: usize,
}

impl RandomPolicy {
    /// Of a plan, which may be empty; from where on, and by which rule, is drawn.
    pub fn new(desk: &DispatchConfiguration, plan: &[PlannedStart], chance: &mut Xorshift) -> Self {
        let from = chance.below(plan.len() + 1);
        let rules: Vec<DispatchRule> = DispatchRule::ALL
            .into_iter()
            .map(|(_, rule)| rule)
            .filter(|rule| *rule != DispatchRule::Schedule)
            .collect();
        let mut desk = desk.clone();
        if chance.below(2) == 0 {
            desk.rules.rules = vec![rules[chance.below(rules.len())]];
        }
        let follow = PlanPolicy::new(desk, VecDeque::from(plan[..from].to_vec()));
        // Another one for each sample.
        let own = Xorshift(chance.0 ^ (chance.below(1 << 20) as u64 + 1));
        RandomPolicy { follow, chance: own, plan: from }
    }
}

impl Dispatcher for RandomPolicy {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        if self.plan > 0 {
            // It ends when as many have started as there were, or when it stands still and drops the rest.
            let answer = self.follow.decide(question);
            self.plan = self.plan.saturating_sub(answer.start.len());
            return answer;
        }
        let usual = self.follow.decide(question);
        if self.chance.below(OVERRULED) > 0 {
            return usual;
        }
        let all = self.follow.desk().rules.preference(question);
        if all.is_empty() {
            return usual;
        }
        DispatchDecision { start: vec![all[self.chance.below(all.len())]], held: Vec::new() }
    }

    fn note(&mut self, record: &Record) {
        self.follow.note(record);
    }
}

impl RolloutPolicy for RandomPolicy {
    fn desk(&self) -> &DispatchConfiguration {
        self.follow.desk()
    }
}
