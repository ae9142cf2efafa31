//! Forward simulation of a cell.
//!
//! It begins as the real one is, and goes on as if every activity took its nominal time and every station did its orders.
//! An activity that already takes longer than that is assumed to take as long again as it is late: so what hangs is waited
//! for less and less, without a limit to be set. A failed one stays failed and keeps what it has: a machine that is down
//! is assumed never to come back.

use std::collections::BTreeMap;
use std::sync::Arc;

use linewright_line::Tick;

use super::super::dispatch::PartPriority;
use super::super::dispatch::time;
use super::super::firing::ActivityPhase;
use super::super::ids::{FiringId, ModeId, PartId};
use super::super::question::{Candidate, ConflictGroup, DispatchDecision, Question, check, pose};
use super::super::record::{ActivityStep, Record, RecordKind};
use super::super::state::PlayerState;
use super::super::table::CellTable;
use super::rollout_policy::RolloutPolicy;

/// An activity that was started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimulatedActivity {
    pub mode: ModeId,
    /// Its part; a new one has the number that it would have.
    pub part: Option<PartId>,
    pub from: Tick,
    /// End; none if that was not played any more, or it has failed.
    pub to: Option<Tick>,
    /// It was in progress when the simulation began.
    pub was_running: bool,
}

/// Reason why playing has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Nothing is in progress, and nothing will start: either all is done, or nothing can be.
    Still,
    /// The horizon was reached.
    Horizon,
    /// More firings would have been needed than were allowed.
    Worn,
}

/// Forward simulation of a cell.
#[derive(Clone, Debug)]
pub struct ForwardSimulation {
    state: PlayerState,
    began: Tick,
    now: Tick,
    acts: Vec<SimulatedActivity>,
    running: BTreeMap<FiringId, usize>,
    left: Vec<(PartPriority, Tick)>,
    firings: usize,
    first: Option<usize>,
}

impl ForwardSimulation {
    pub fn new(state: &PlayerState, table: &Arc<CellTable>, now: Tick) -> Self {
        let quiet = table;
        let mut state = state.clone();
        state.table = quiet.clone();
        state.orders.clear();
        state.unheard.clear();
        state.due.clear();
        state.settled.clear();
        let (mut acts, mut running) = (Vec::new(), BTreeMap::new());
        for firing in state.firings.values_mut() {
            firing.orders.clear();
            firing.spared_until = Tick::ZERO;
            let began = firing.began;
            let to = match firing.phase {
                ActivityPhase::Running => {
                    let time = time(quiet, firing.mode);
                    let end = began + time;
                    let believed = if end > now { end } else { now + now.since(end) };
                    firing.began = believed - time;
                    firing.due(quiet.activity(firing.mode))
                }
                ActivityPhase::Failed(_) => None,
            };
            state.due.extend(to.map(|to| (to, firing.id)));
            running.insert(firing.id, acts.len());
            acts.push(SimulatedActivity { mode: firing.mode, part: firing.part, from: began, to, was_running: true });
        }
        let now = now.max(state.now);
        ForwardSimulation { state, began: now, now, acts, running, left: Vec::new(), firings: 0, first: None }
    }

    /// The state it has come to.
    pub fn state(&self) -> &PlayerState {
        &self.state
    }

    pub fn began(&self) -> Tick {
        self.began
    }

    /// Time reached.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// All starts, in their order, after the activities in progress before.
    pub fn acts(&self) -> &[SimulatedActivity] {
        &self.acts
    }

    /// The parts that have left: due date and priority of each, and time.
    pub(in super::super) fn left(&self) -> &[(PartPriority, Tick)] {
        &self.left
    }

    /// Number of activities that were started or have happened.
    pub fn firings(&self) -> usize {
        self.firings
    }

    /// Number of activities that had been started, those in progress before among them, after the first question was
    /// answered.
    pub(super) fn first(&self) -> Option<usize> {
        self.first
    }

    fn write(&mut self, fact: RecordKind, policy: &mut (impl RolloutPolicy + ?Sized)) {
        let record = Record { at: self.now, fact };
        let moved = match record.fact.activity_step() {
            Some(ActivityStep::Ended { firing }) => self.state.firing(firing).map(|firing| (firing.mode, firing.part)),
            Some(ActivityStep::Fired { mode, part }) => Some((mode, part)),
            // The simulation decides no other activity, or this one takes no part out.
            Some(ActivityStep::Started { .. } | ActivityStep::Raised { .. } | ActivityStep::Closed { .. }) | None => {
                None
            }
        };
        let leaving = moved.and_then(|(mode, part)| part.filter(|_| self.state.table.part_out(mode).is_none()));
        self.left.extend(leaving.map(|part| (policy.desk().job(part), self.now)));
        // Only what was looked at in this very state is written, as the player does it.
        self.state.apply(&record).expect("only what fits is simulation");
        policy.note(&record);
    }

    /// Ends activities that are due, and fires modes that happen by themselves; false if those were more than allowed.
    pub(in super::super) fn settle(&mut self, policy: &mut (impl RolloutPolicy + ?Sized), most: usize) -> bool {
        loop {
            while let Some(&(_, firing)) = self.state.due.first().filter(|(due, _)| *due <= self.now) {
                if let Some(act) = self.running.remove(&firing) {
                    self.acts[act].to = Some(self.now);
                }
                self.write(RecordKind::Ended { firing }, policy);
            }
            let Some(mode) = self.state.enabling.immediate().iter().copied().min() else { return true };
            if self.firings >= most {
                return false;
            }
            self.firings += 1;
            let part = self.state.part_for(mode);
            self.write(RecordKind::Fired { mode, part }, policy);
        }
    }

    /// Modes that could start now.
    pub(in super::super) fn candidates(&self) -> (Vec<Candidate>, Vec<ConflictGroup>) {
        pose(&self.state, self.state.enabling.decided().iter().copied())
    }

    /// Starts something that could start.
    pub(in super::super) fn start(
        &mut self,
        mode: ModeId,
        part: Option<PartId>,
        policy: &mut (impl RolloutPolicy + ?Sized),
    ) {
        let part = part.or_else(|| self.state.part_for(mode));
        let firing = FiringId(self.state.last_firing + 1);
        self.running.insert(firing, self.acts.len());
        let to = Some(self.now + time(&self.state.table, mode));
        self.acts.push(SimulatedActivity { mode, part, from: self.now, to, was_running: false });
        self.firings += 1;
        self.write(RecordKind::Started { firing, mode, part, orders: Vec::new() }, policy);
    }

    /// Time of the next end.
    pub(in super::super) fn next_end(&self) -> Option<Tick> {
        self.state.due.first().map(|&(due, _)| due)
    }

    /// Lets time go on.
    pub(in super::super) fn advance(&mut self, to: Tick) {
        self.now = self.now.max(to);
    }

    /// Goes on until a time, or until so many firings.
    pub fn play(&mut self, policy: &mut (impl RolloutPolicy + ?Sized), until: Tick, most: usize) -> Ending {
        loop {
            if !self.settle(policy, most) || self.firings >= most {
                return Ending::Worn;
            }
            let (candidates, groups) = self.candidates();
            let mut answer = DispatchDecision::default();
            if !candidates.is_empty() {
                let question = Question { now: self.now, state: &self.state, candidates: &candidates, groups: &groups };
                answer = policy.decide(&question);
                if check(&question, &answer).is_err() {
                    answer = DispatchDecision::default();
                }
            }
            for start in &answer.start {
                self.start(candidates[start.candidate].mode, start.part, policy);
            }
            self.first.get_or_insert(self.acts.len());
            if !answer.start.is_empty() {
                continue;
            }
            let wakes = answer.held.iter().filter_map(|held| held.until).filter(|&until| until > self.now);
            match wakes.chain(self.next_end()).min() {
                // What is held until the end of time is not waited for.
                None | Some(Tick::NEVER) => return Ending::Still,
                Some(next) if next > until => {
                    self.advance(until);
                    return Ending::Horizon;
                }
                Some(next) => self.advance(next),
            }
        }
    }
}
