//! Activities taken apart into the transitions that they are.
//!
//! A piece has the activity's actions that begin in it and that end, and the places of what is in progress before and
//! after it. The tokens that each action takes when it begins and gives when it ends are in [`super::instance`].
//!
//! One transition moves all stages that it allows on by the same number of tones, since arc functions have no constants;
//! an activity that changes stages by different numbers is several transitions, `M1.process` and `M1.process/2`. So is work
//! on parts that are loaded for it, and on parts that stay where they were worked on: `M1.process/stays`.

use std::collections::BTreeMap;

use super::{Detail, TransitionPhase};
use crate::{Activity, ActivityId, Cell, Prototype, Role, StageId, StageMove, Use};

/// A transition to be.
pub(super) struct PlannedTransition {
    pub name: String,
    pub activity: ActivityId,
    pub phase: TransitionPhase,
    /// The actions that begin here.
    pub begins: Vec<Use>,
    /// The actions that end here.
    pub ends: Vec<Use>,
    /// Distance to the stage afterwards, in tones.
    pub shift: u32,
    /// Work on a part that stays after work before.
    pub stays: bool,
    /// The stages it is for, where it is the first of its activity; none where those before it have seen to that.
    pub allowed: Option<Vec<StageId>>,
    /// Activity in progress before, and afterwards: a place's name, and those on whose stacks it stands.
    pub from: Option<ProgressPlace>,
    pub to: Option<ProgressPlace>,
    /// Where nothing else keeps one stage from being moved twice at a time: the variant's name, and whether it begins.
    pub server: Option<(String, bool)>,
}

/// A place of an activity in progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ProgressPlace {
    pub place: String,
    /// The actions that have begun and not ended.
    pub uses: Vec<Use>,
}

/// All pieces of all activities, in their order; but first the work on parts that stay. Where rules leave it equal whether a
/// part stays or is unloaded, the first mode decides.
pub(super) fn pieces(cell: &Cell, detail: Detail) -> Vec<PlannedTransition> {
    let mut pieces = Vec::new();
    for stays in [true, false] {
        for id in cell.activity_ids() {
            let activity = cell.activity(id);
            for (number, (shift, stages)) in variants(cell, activity, stays).into_iter().enumerate() {
                let mut name = activity.name.clone();
                if stays {
                    name.push_str("/stays");
                }
                if number > 0 {
                    name.push_str(&format!("/{}", number + 1));
                }
                Variant { cell, id, activity, name, shift, stays, stages }.pieces(detail, &mut pieces);
            }
        }
    }
    pieces
}

/// The stages that an activity is for, by how many tones they are moved on.
fn variants(cell: &Cell, activity: &Activity, stays: bool) -> Vec<(u32, Vec<StageId>)> {
    let ring = cell.stages.len();
    let mut found: BTreeMap<usize, Vec<StageId>> = BTreeMap::new();
    let is_one = |of: &&StageMove| if stays { of.stays.allows_ready() } else { of.stays.allows_loaded() };
    for of in activity.moves.iter().filter(is_one) {
        found.entry((of.to.index() + ring - of.from.index()) % ring).or_default().push(of.from);
    }
    // The parser bounds stages far below 32 bits.
    found.into_iter().map(|(shift, stages)| (shift as u32, stages)).collect()
}

struct Variant<'c> {
    cell: &'c Cell,
    id: ActivityId,
    activity: &'c Activity,
    name: String,
    shift: u32,
    stays: bool,
    stages: Vec<StageId>,
}

impl Variant<'_> {
    fn pieces(&self, detail: Detail, pieces: &mut Vec<PlannedTransition>) {
        let uses = &self.activity.uses;
        let of = |roles: &[Role]| -> Vec<Use> {
            uses.iter().copied().filter(|part| roles.contains(&part.action.role())).collect()
        };
        let is_whole = self.cell.limits.reserve || self.activity.used(Role::Carrier).is_none();
        let is_seen = detail == Detail::Expanded && !self.activity.is_logical();
        match (is_whole, is_seen) {
            (true, false) => {
                pieces.push(PlannedTransition {
                    allowed: self.allowed(),
                    ..self.piece("", TransitionPhase::Whole, uses, uses)
                });
            }
            (true, true) => {
                let server = |begins| self.needs_server().then(|| (self.name.clone(), begins));
                let progress = Some(self.progress("", uses));
                let start = self.piece(".start", TransitionPhase::Start, uses, &[]);
                let end = self.piece(".end", TransitionPhase::End, &[], uses);
                let allowed = self.allowed();
                pieces.push(PlannedTransition { to: progress.clone(), server: server(true), allowed, ..start });
                pieces.push(PlannedTransition { from: progress, server: server(false), ..end });
            }
            (false, _) => {
                let (source, target) = (of(&[Role::Source]), of(&[Role::Target]));
                let (grasp, put) = (of(&[Role::Source, Role::Carrier]), of(&[Role::Target, Role::Carrier]));
                let held = Some(self.progress(".held", &[]));
                if is_seen {
                    let (grasping, putting) = (self.progress(".grasp", &source), self.progress(".put", &target));
                    let start = self.piece(".grasp.start", TransitionPhase::GraspStart, &grasp, &[]);
                    pieces.push(PlannedTransition { to: Some(grasping.clone()), allowed: self.allowed(), ..start });
                    let end = self.piece(".grasp.end", TransitionPhase::GraspEnd, &[], &source);
                    pieces.push(PlannedTransition { from: Some(grasping), to: held.clone(), ..end });
                    let start = self.piece(".put.start", TransitionPhase::PutStart, &target, &[]);
                    pieces.push(PlannedTransition { from: held, to: Some(putting.clone()), ..start });
                    let end = self.piece(".put.end", TransitionPhase::PutEnd, &[], &put);
                    pieces.push(PlannedTransition { from: Some(putting), ..end });
                } else {
                    let first = self.piece(".grasp", TransitionPhase::Grasp, &grasp, &source);
                    pieces.push(PlannedTransition { to: held.clone(), allowed: self.allowed(), ..first });
                    pieces.push(PlannedTransition {
                        from: held,
                        ..self.piece(".put", TransitionPhase::Put, &target, &put)
                    });
                }
            }
        }
    }

    fn piece(&self, suffix: &str, phase: TransitionPhase, begins: &[Use], ends: &[Use]) -> PlannedTransition {
        PlannedTransition {
            name: format!("{}{suffix}", self.name),
            activity: self.id,
            phase,
            begins: begins.to_vec(),
            ends: ends.to_vec(),
            shift: self.shift,
            stays: self.stays,
            allowed: None,
            from: None,
            to: None,
            server: None,
        }
    }

    fn allowed(&self) -> Option<Vec<StageId>> {
        Some(self.stages.clone())
    }

    fn progress(&self, suffix: &str, uses: &[Use]) -> ProgressPlace {
        ProgressPlace { place: format!("{}{suffix}", self.name), uses: uses.to_vec() }
    }

    /// Single server for each mode (seed 000, proposition 15, L2385), unless a resource of it has its own limit.
    fn needs_server(&self) -> bool {
        self.activity.uses.iter().all(|part| match part.of.map(|id| self.cell.resource(id)) {
            None => true,
            Some(resource) => match resource.prototype {
                Prototype::RandomAccessStore => resource.capacity > 1,
                Prototype::Machine
                | Prototype::Human
                | Prototype::FifoBuffer
                | Prototype::LifoBuffer
                | Prototype::Robot
                | Prototype::Conveyor => false,
            },
        })
    }
}

impl PlannedTransition {
    /// Those of its actions that are a resource's, each with whether it begins and ends here.
    pub fn actions_of(&self, resource: Option<crate::ResourceId>) -> Vec<(Use, bool, bool)> {
        let mut found: Vec<(Use, bool, bool)> = Vec::new();
        let here = |part: &&Use| part.of == resource;
        found.extend(self.begins.iter().filter(here).map(|&part| (part, true, false)));
        for &part in self.ends.iter().filter(here) {
            match found.iter_mut().find(|(known, ..)| *known == part) {
                Some((_, _, ends)) => *ends = true,
                None => found.push((part, false, true)),
            }
        }
        found
    }
}
