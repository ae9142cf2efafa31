//! Policies that decide in a forward simulation.
//!
//! All of them fall back to the rules when they have nothing more to decide, so that a simulation is always played to its end.

use std::collections::{BTreeSet, VecDeque};

use linewright_line::Tick;

use super::super::ids::{ModeId, PartId};
use super::super::production::DispatchConfiguration;
use super::super::question::{DispatchDecision, Dispatcher, HeldCandidate, Question, Start, pose};
use super::super::reason::HoldReason;
use super::super::record::Record;

/// A dispatcher within a forward simulation.
pub trait RolloutPolicy: Dispatcher {
    /// Its data on parts and orders.
    fn desk(&self) -> &DispatchConfiguration;
}

impl RolloutPolicy for DispatchConfiguration {
    fn desk(&self) -> &DispatchConfiguration {
        self
    }
}

/// One decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PolicyChoice {
    /// This starts, and nothing else before it.
    Start(ModeId, Option<PartId>),
    /// None of these starts at this moment.
    Wait(BTreeSet<ModeId>, Tick),
    /// This never starts: its part goes another way, or waits for one.
    Without(ModeId),
}

/// One other decision, and then the rules.
#[derive(Clone, Debug)]
pub struct DeviatingPolicy {
    desk: DispatchConfiguration,
    choice: Option<PolicyChoice>,
}

impl DeviatingPolicy {
    /// First this choice.
    pub fn new(desk: DispatchConfiguration, choice: PolicyChoice) -> Self {
        DeviatingPolicy { desk, choice: Some(choice) }
    }
}

impl DeviatingPolicy {
    /// Decision by rules where some modes cannot start.
    fn decide_without(&mut self, question: &Question<'_>, is_out: impl Fn(ModeId) -> bool) -> DispatchDecision {
        let modes = question.candidates.iter().map(|candidate| candidate.mode);
        let (candidates, groups) = pose(question.state, modes.filter(|&mode| !is_out(mode)));
        let mut answer = self.desk.decide(&Question { candidates: &candidates, groups: &groups, ..*question });
        // Candidates are in the order of their modes, both here and there.
        let index = |at: usize| question.candidates.partition_point(|other| other.mode < candidates[at].mode);
        answer.start.iter_mut().for_each(|start| start.candidate = index(start.candidate));
        answer.held.iter_mut().for_each(|held| held.candidate = index(held.candidate));
        answer
    }
}

impl Dispatcher for DeviatingPolicy {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        match self.choice.take() {
            Some(PolicyChoice::Start(mode, part)) => {
                match question.candidates.iter().position(|candidate| candidate.mode == mode) {
                    Some(candidate) => DispatchDecision { start: vec![Start { candidate, part }], held: Vec::new() },
                    None => self.desk.decide(question),
                }
            }
            Some(PolicyChoice::Wait(modes, at)) if at == question.now => {
                let answer = self.decide_without(question, |mode| modes.contains(&mode));
                self.choice = Some(PolicyChoice::Wait(modes, at));
                answer
            }
            Some(PolicyChoice::Without(out)) => {
                self.choice = Some(PolicyChoice::Without(out));
                self.decide_without(question, |mode| mode == out)
            }
            Some(PolicyChoice::Wait(..)) | None => self.desk.decide(question),
        }
    }

    fn note(&mut self, record: &Record) {
        self.desk.note(record);
    }
}

impl RolloutPolicy for DeviatingPolicy {
    fn desk(&self) -> &DispatchConfiguration {
        &self.desk
    }
}

/// Something that is to be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedStart {
    /// Not before.
    pub at: Tick,
    pub mode: ModeId,
    /// Its part; none for one that enters, or that takes none.
    pub part: Option<PartId>,
}

/// A plan, one start after the other, each not before its time and not before the one ahead of it; and then the rules. In a
/// cell that has gone as planned so far it starts as planned; in another one as much later as it must. If the cell comes to
/// stand still, the rest of the plan is dropped.
#[derive(Clone, Debug)]
pub struct PlanPolicy {
    desk: DispatchConfiguration,
    plan: VecDeque<PlannedStart>,
}

impl PlanPolicy {
    /// This plan, in this order.
    pub fn new(desk: DispatchConfiguration, plan: VecDeque<PlannedStart>) -> Self {
        PlanPolicy { desk, plan }
    }

    /// The head of the plan, if it can start now.
    fn ready(&self, question: &Question<'_>) -> Option<Start> {
        let head = self.plan.front().filter(|head| head.at <= question.now)?;
        let candidate = question.candidates.iter().position(|candidate| candidate.mode == head.mode)?;
        let able = match head.part {
            Some(part) => question.parts(&question.candidates[candidate]).any(|able| able == part),
            None => !question.takes_part(&question.candidates[candidate]) && self.desk.admits(question, head.mode),
        };
        able.then_some(Start { candidate, part: head.part })
    }
}

impl Dispatcher for PlanPolicy {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.desk.refresh(question.now);
        loop {
            let Some(head) = self.plan.front() else { return self.desk.decide(question) };
            if let Some(start) = self.ready(question) {
                self.plan.pop_front();
                return DispatchDecision { start: vec![start], held: Vec::new() };
            }
            let wake = (head.at > question.now).then_some(head.at);
            if wake.is_some() || !question.state.due.is_empty() {
                let held = HeldCandidate { candidate: 0, reason: HoldReason::NotYet(head.at), until: wake };
                return DispatchDecision { start: Vec::new(), held: vec![held] };
            }
            self.plan.clear();
        }
    }

    fn note(&mut self, record: &Record) {
        self.desk.note(record);
    }
}

impl RolloutPolicy for PlanPolicy {
    fn desk(&self) -> &DispatchConfiguration {
        &self.desk
    }
}
