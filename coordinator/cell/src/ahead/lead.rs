//! Who decides in thought.
//!
//! All of them fall back to the rules when they have nothing more to say, so that a future is always played to its end.

use std::collections::{BTreeSet, VecDeque};

use linewright_line::Tick;

use super::super::ids::{ModeId, PartId};
use super::super::production::Desk;
use super::super::question::{Answer, Dispatcher, Held, Question, Start, pose};
use super::super::reason::Reason;
use super::super::record::Record;

/// A dispatcher of imagined cells.
pub trait Lead: Dispatcher {
    /// What it knows of parts and orders.
    fn desk(&self) -> &Desk;
}

impl Lead for super::LookAhead {
    fn desk(&self) -> &Desk {
        &self.desk
    }
}

impl Lead for Desk {
    fn desk(&self) -> &Desk {
        self
    }
}

/// One decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// This starts, and nothing else before it.
    Start(ModeId, Option<PartId>),
    /// None of these starts at this moment.
    Wait(BTreeSet<ModeId>, Tick),
    /// This never starts: what it would be for goes another way, or waits for one.
    Without(ModeId),
}

/// One other decision, and then the rules.
#[derive(Clone, Debug)]
pub struct Otherwise {
    desk: Desk,
    choice: Option<Choice>,
}

impl Otherwise {
    /// First this choice.
    pub fn new(desk: Desk, choice: Choice) -> Self {
        Otherwise { desk, choice: Some(choice) }
    }
}

impl Otherwise {
    /// What the rules say where some modes cannot start.
    fn decide_without(&mut self, question: &Question<'_>, is_out: impl Fn(ModeId) -> bool) -> Answer {
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

impl Dispatcher for Otherwise {
    fn decide(&mut self, question: &Question<'_>) -> Answer {
        match self.choice.take() {
            Some(Choice::Start(mode, part)) => {
                match question.candidates.iter().position(|candidate| candidate.mode == mode) {
                    Some(candidate) => Answer { start: vec![Start { candidate, part }], held: Vec::new() },
                    None => self.desk.decide(question),
                }
            }
            Some(Choice::Wait(modes, at)) if at == question.now => {
                let answer = self.decide_without(question, |mode| modes.contains(&mode));
                self.choice = Some(Choice::Wait(modes, at));
                answer
            }
            Some(Choice::Without(out)) => {
                self.choice = Some(Choice::Without(out));
                self.decide_without(question, |mode| mode == out)
            }
            Some(Choice::Wait(..)) | None => self.desk.decide(question),
        }
    }

    fn note(&mut self, record: &Record) {
        self.desk.note(record);
    }
}

impl Lead for Otherwise {
    fn desk(&self) -> &Desk {
        &self.desk
    }
}

/// Something that is to be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedStart {
    /// Not before.
    pub at: Tick,
    /// What.
    pub mode: ModeId,
    /// With which part; none for one that enters, or that takes none.
    pub part: Option<PartId>,
}

/// A plan, one start after the other, each not before its time and not before the one ahead of it; and then the rules. In a
/// cell that has gone as planned so far it does exactly what was planned; in another one as much later as it must be. If it
/// comes to stand still, what is left of it is forgotten.
#[derive(Clone, Debug)]
pub struct Follow {
    desk: Desk,
    plan: VecDeque<PlannedStart>,
}

impl Follow {
    /// This plan, in this order.
    pub fn new(desk: Desk, plan: VecDeque<PlannedStart>) -> Self {
        Follow { desk, plan }
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

impl Dispatcher for Follow {
    fn decide(&mut self, question: &Question<'_>) -> Answer {
        self.desk.refresh(question.now);
        loop {
            let Some(head) = self.plan.front() else { return self.desk.decide(question) };
            if let Some(start) = self.ready(question) {
                self.plan.pop_front();
                return Answer { start: vec![start], held: Vec::new() };
            }
            let wake = (head.at > question.now).then_some(head.at);
            if wake.is_some() || !question.state.due.is_empty() {
                let held = Held { candidate: 0, reason: Reason::NotYet(head.at), until: wake };
                return Answer { start: Vec::new(), held: vec![held] };
            }
            self.plan.clear();
        }
    }

    fn note(&mut self, record: &Record) {
        self.desk.note(record);
    }
}

impl Lead for Follow {
    fn desk(&self) -> &Desk {
        &self.desk
    }
}
