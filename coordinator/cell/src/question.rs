//! The question to a dispatcher, and the rules of an answer.
//!
//! The player decides nothing (seed 001, L39, L111, L187-190): whenever activities can start it *poses* a decision problem
//! and starts the modes of the answer. Every start is a question, also where nothing conflicts, because the dispatcher may
//! hold back. An answer is checked before anything is done, so a dispatcher can be wrong without doing harm.
//!
//! *Candidates* are modes that have their tokens and a server (seed 000, definition 43, without the sensors and the
//! dispatcher). Candidates that cannot all have what they need form a *group*: the closure over everything they compete
//! for. What is decided in one group does not matter to another, and of a candidate alone in its group only the time is
//! decided.

use std::collections::{BTreeMap, BTreeSet};

use linewright_line::Tick;

use super::ids::{CellId, ModeId, PartId};
use super::plan::{CellKind, PartPick};
pub use super::reason::HoldReason;
use super::record::Record;
use super::state::PlayerState;

/// Problem to be decided: the modes that could start now.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    pub now: Tick,
    /// The cell.
    pub state: &'a PlayerState,
    /// Modes that could start.
    pub candidates: &'a [Candidate],
    /// Groups of them that compete.
    pub groups: &'a [ConflictGroup],
}

/// A mode that could start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    pub mode: ModeId,
    /// Most starts, if no other took anything; at least 1.
    pub times: u32,
    /// Its group, as an index.
    pub group: usize,
}

/// Candidates that compete, directly or through others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConflictGroup {
    /// They, as indices, ascending.
    pub candidates: Vec<usize>,
    /// The cells that have less than all of them together would take.
    pub contested: Vec<CellId>,
}

impl<'a> Question<'a> {
    /// The parts with which a candidate could start, the one that has been there longest first; none if it takes none.
    pub fn parts(&self, candidate: &Candidate) -> impl Iterator<Item = PartId> + use<'a> {
        self.state.takeable(candidate.mode)
    }

    /// Whether a candidate takes a part from somewhere.
    pub fn takes_part(&self, candidate: &Candidate) -> bool {
        self.state.table().part_in(candidate.mode).is_some()
    }
}

/// Answer of a dispatcher.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DispatchDecision {
    pub start: Vec<Start>,
    /// Candidates held, and reasons. A candidate that is in neither list is held without a reason.
    pub held: Vec<HeldCandidate>,
}

/// A candidate that is to start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    pub candidate: usize,
    /// Its part; none exactly if the mode takes none.
    pub part: Option<PartId>,
}

/// A candidate that is not to start now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeldCandidate {
    pub candidate: usize,
    /// Reason, for operators.
    pub reason: HoldReason,
    /// Time of the next question, if nothing happens before.
    pub until: Option<Tick>,
}

/// Decides which candidates start.
pub trait Dispatcher {
    /// Answers a question. The same question may come again.
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision;

    /// Takes every record that a step writes, in their order, before the next question. What a dispatcher keeps of a cell
    /// can follow from this alone; after a restart its maker passes it the log.
    fn note(&mut self, _record: &Record) {}
}

/// Reason why an answer cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadAnswer {
    /// There is no such candidate.
    NoCandidate(usize),
    /// The part cannot be taken, or there must be none, or one is missing.
    Part { mode: ModeId, part: Option<PartId> },
    /// A part would be in two places.
    PartTwice(PartId),
    /// A mode more often than its servers allow, or more than one part of a cell that gives one after the other.
    TooOften(ModeId),
    /// Not enough tokens for all that is to start.
    NotCovered(CellId),
}

/// The question about these modes; none if nothing could start.
pub(super) fn pose(state: &PlayerState, modes: impl Iterator<Item = ModeId>) -> (Vec<Candidate>, Vec<ConflictGroup>) {
    let with_room = modes.map(|mode| Candidate { mode, times: state.room(mode), group: 0 });
    let mut candidates: Vec<Candidate> = with_room.filter(|candidate| candidate.times > 0).collect();
    candidates.sort_unstable_by_key(|candidate| candidate.mode);
    let mut demand: BTreeMap<CellId, (u64, Vec<usize>)> = BTreeMap::new();
    for (index, candidate) in candidates.iter().enumerate() {
        for &(cell, weight) in state.table().takes(candidate.mode) {
            let (needed, by) = demand.entry(cell).or_default();
            *needed = needed.saturating_add(u64::from(weight) * u64::from(candidate.times));
            by.push(index);
        }
    }
    demand.retain(|&cell, (needed, _)| *needed > state.marking().count(cell));
    let mut leader: Vec<usize> = (0..candidates.len()).collect();
    for (_, by) in demand.values() {
        by.windows(2).for_each(|pair| join(&mut leader, pair[0], pair[1]));
    }
    let mut groups: Vec<ConflictGroup> = Vec::new();
    let mut group_of = BTreeMap::new();
    for (index, candidate) in candidates.iter_mut().enumerate() {
        let at = *group_of.entry(find(&mut leader, index)).or_insert_with(|| {
            groups.push(ConflictGroup { candidates: Vec::new(), contested: Vec::new() });
            groups.len() - 1
        });
        groups[at].candidates.push(index);
        candidate.group = at;
    }
    demand.iter().for_each(|(&cell, (_, by))| groups[candidates[by[0]].group].contested.push(cell));
    (candidates, groups)
}

fn find(leader: &mut [usize], of: usize) -> usize {
    let mut at = of;
    while leader[at] != at {
        leader[at] = leader[leader[at]];
        at = leader[at];
    }
    at
}

/// The smaller leads, so that groups are in the order of their first candidates.
fn join(leader: &mut [usize], a: usize, b: usize) {
    let (a, b) = (find(leader, a), find(leader, b));
    leader[a.max(b)] = a.min(b);
}

/// Whether all that an answer starts can start at once (seed 000, definition 16).
pub fn check(question: &Question<'_>, answer: &DispatchDecision) -> Result<(), BadAnswer> {
    let (state, table) = (question.state, question.state.table());
    let (mut parts, mut ordered) = (BTreeSet::new(), BTreeSet::new());
    let (mut often, mut demand) = (BTreeMap::<ModeId, u32>::new(), BTreeMap::<CellId, u64>::new());
    for start in &answer.start {
        let candidate = question.candidates.get(start.candidate).ok_or(BadAnswer::NoCandidate(start.candidate))?;
        let mode = candidate.mode;
        match (table.part_in(mode), start.part) {
            (None, None) => (),
            (Some(cell), Some(part)) => {
                if !state.can_take(cell, part) {
                    return Err(BadAnswer::Part { mode, part: start.part });
                }
                if !parts.insert(part) {
                    return Err(BadAnswer::PartTwice(part));
                }
                let one_by_one = match table.kind(cell) {
                    CellKind::Tokens | CellKind::Parts(PartPick::Any) => false,
                    CellKind::Parts(PartPick::Oldest | PartPick::Newest) => true,
                };
                if one_by_one && !ordered.insert(cell) {
                    return Err(BadAnswer::TooOften(mode));
                }
            }
            (None, Some(_)) | (Some(_), None) => return Err(BadAnswer::Part { mode, part: start.part }),
        }
        let times = often.entry(mode).or_default();
        *times += 1;
        if *times > candidate.times {
            return Err(BadAnswer::TooOften(mode));
        }
        for &(cell, weight) in table.takes(mode) {
            let needed = demand.entry(cell).or_default();
            *needed += u64::from(weight);
            if *needed > state.marking().count(cell) {
                return Err(BadAnswer::NotCovered(cell));
            }
        }
    }
    match answer.held.iter().find(|held| held.candidate >= question.candidates.len()) {
        Some(held) => Err(BadAnswer::NoCandidate(held.candidate)),
        None => Ok(()),
    }
}
