//! Verdicts on the cell from the searches of all groups.

use linewright_cell::{Cell, StageId};
use linewright_nets::explicit::{ExplorationLimit, ExplorationUndecided};
use rustc_hash::FxHashSet;

use super::counterexample::{CellPath, tell};
use super::group::ResourceGroup;
use super::play::{Excess, GroupSearch, Size};
use super::words::moved;
use super::{CellExploration, Nets};
use crate::explore::Verdict;

/// One property of the cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellProperty {
    /// Name of the property.
    pub name: &'static str,
    /// The answer.
    pub verdict: Verdict,
    /// Why, in words.
    pub reason: String,
    /// Remedy, where one is known.
    pub help: Option<String>,
    /// Path to the violation.
    pub counterexample: Option<CellPath>,
}

/// One group of resources and what was seen of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupExplored {
    /// The resources' names.
    pub resources: Vec<String>,
    /// With so many parts in the cell at a time; the figures are those of this search. None came to an end if it is 0.
    pub parts: u32,
    /// Markings.
    pub states: u64,
    /// Steps between them.
    pub arcs: u64,
    /// Memory it took, about.
    pub bytes: usize,
    /// With so many parts at a time nothing is wrong.
    pub sound: u32,
    /// All that can happen with as many parts as are let in was seen; or something wrong was.
    pub exhausted: bool,
}

/// Result of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    pub groups: Vec<GroupExplored>,
    pub properties: Vec<CellProperty>,
    /// With so many parts at a time nothing is wrong in any group.
    pub sound: u32,
}

impl Checked {
    /// Whether every property holds; a remark counts as holding.
    pub fn holds(&self) -> bool {
        self.properties.iter().all(|property| matches!(property.verdict, Verdict::Holds | Verdict::Remark))
    }
}

/// The name of the first property.
pub(super) const STUCK: &str = "no part gets stuck";
/// Of the second.
pub(super) const FINISHED: &str = "every part can always be finished and leave";
/// Of the third.
pub(super) const HAPPENS: &str = "everything described can happen";

pub(super) fn judge(
    setting: &CellExploration<'_>,
    nets: &Nets<'_>,
    groups: &[ResourceGroup],
    plays: &[GroupSearch],
) -> Checked {
    let summary = Summary::new(setting.cell, groups, plays);
    Checked {
        groups: groups.iter().zip(plays).map(|(group, play)| explored(setting.cell, group, play)).collect(),
        properties: vec![
            summary.stuck(nets),
            summary.finished(nets),
            happens(setting, nets, groups, plays, summary.limit()),
        ],
        sound: summary.sound,
    }
}

fn explored(cell: &Cell, group: &ResourceGroup, play: &GroupSearch) -> GroupExplored {
    let Size { parts, states, arcs, bytes } = play.size;
    GroupExplored {
        resources: group.resources.iter().map(|&id| cell.resource(id).name.clone()).collect(),
        parts,
        states,
        arcs,
        bytes,
        sound: play.sound,
        exhausted: !matches!(play.end, Excess::Limit(_)),
    }
}

/// All groups together.
struct Summary<'p> {
    cell: &'p Cell,
    all: Vec<(&'p ResourceGroup, &'p GroupSearch)>,
    sound: u32,
    states: u64,
}

impl<'p> Summary<'p> {
    fn new(cell: &'p Cell, groups: &'p [ResourceGroup], plays: &'p [GroupSearch]) -> Self {
        Summary {
            cell,
            all: groups.iter().zip(plays).collect(),
            sound: plays.iter().map(|play| play.sound).min().unwrap_or(cell.limits.wip_max),
            states: plays.iter().map(|play| play.size.states).sum(),
        }
    }

    /// The first group that could not be seen to the end, by how far it was.
    fn limit(&self) -> Option<(u32, &'p ExplorationUndecided)> {
        let open = self.all.iter().filter_map(|(_, play)| match &play.end {
            Excess::Limit(why) => Some((play.sound, why)),
            Excess::Sound | Excess::Stuck(_) | Excess::Endless(_) | Excess::Wrong(_) => None,
        });
        open.min_by_key(|(sound, _)| *sound)
    }

    /// The violation with the fewest parts.
    fn worst(&self) -> Option<(&'p ResourceGroup, &'p GroupSearch)> {
        let is_wrong = |play: &GroupSearch| match play.end {
            Excess::Stuck(_) | Excess::Endless(_) | Excess::Wrong(_) => true,
            Excess::Sound | Excess::Limit(_) => false,
        };
        self.all.iter().copied().filter(|(_, play)| is_wrong(play)).min_by_key(|(_, play)| play.sound)
    }

    fn stuck(&self, nets: &Nets<'_>) -> CellProperty {
        let stuck = self.all.iter().filter_map(|(group, play)| match &play.end {
            Excess::Stuck(found) => Some((group, play, found)),
            Excess::Sound | Excess::Endless(_) | Excess::Wrong(_) | Excess::Limit(_) => None,
        });
        if let Some((group, play, found)) = stuck.min_by_key(|(_, play, _)| play.sound) {
            let story = tell(nets, group, found, "no activity of this group can start again");
            return self.failed(STUCK, play, Some(story));
        }
        let open = self.all.iter().find_map(|(_, play)| match &play.end {
            Excess::Wrong(why) => Some(format!("not looked for to the end: {}", limit_in_words(why))),
            Excess::Endless(_) => Some(format!("not met with up to {}", with_parts(play.size.parts))),
            Excess::Sound | Excess::Stuck(_) | Excess::Limit(_) => None,
        });
        match (open, self.limit()) {
            (Some(reason), _) => property(STUCK, Verdict::Undecided, reason),
            (None, Some(limit)) => property(STUCK, Verdict::Undecided, undecided(limit)),
            (None, None) => property(STUCK, Verdict::Holds, self.everywhere()),
        }
    }

    fn finished(&self, nets: &Nets<'_>) -> CellProperty {
        let Some((group, play)) = self.worst() else {
            return match self.limit() {
                Some(limit) => property(FINISHED, Verdict::Undecided, undecided(limit)),
                None => property(FINISHED, Verdict::Holds, self.everywhere()),
            };
        };
        match &play.end {
            Excess::Endless(found) => {
                let end = "something can still move, but never again will all that is here be finished";
                self.failed(FINISHED, play, Some(tell(nets, group, found, end)))
            }
            // Reported already.
            Excess::Stuck(_) => CellProperty {
                help: None,
                reason: format!("not those that are stuck, with {}", with_parts(play.size.parts)),
                ..self.failed(FINISHED, play, None)
            },
            Excess::Sound | Excess::Wrong(_) | Excess::Limit(_) => self.failed(FINISHED, play, None),
        }
    }

    fn everywhere(&self) -> String {
        format!("in all {} states, with up to {}", self.states, with_parts(self.cell.limits.wip_max))
    }

    fn failed(&self, name: &'static str, play: &GroupSearch, story: Option<CellPath>) -> CellProperty {
        let parts = play.size.parts;
        let after = story.as_ref().map(|story| format!(", after {} steps", story.steps.len())).unwrap_or_default();
        let below = match parts - 1 {
            0 => String::new(),
            below => format!("; with up to {below} it holds"),
        };
        let reason = format!("not with {}{after}{below}", with_parts(parts));
        CellProperty { name, verdict: Verdict::Fails, reason, help: self.help(), counterexample: story }
    }

    /// Change of the description that helps.
    fn help(&self) -> Option<String> {
        let reserve = "`reserve = true` in `[cell]`: a part is then grasped only if the place for it is reserved";
        let less = |sound: u32| format!("`wip_max = {sound}` in `[cell]`: with no more parts at once nothing is wrong");
        let ways =
            [(!self.cell.limits.reserve).then(|| reserve.to_owned()), (self.sound > 0).then(|| less(self.sound))];
        let ways: Vec<String> = ways.into_iter().flatten().collect();
        (!ways.is_empty()).then(|| ways.join("; or "))
    }
}

fn property(name: &'static str, verdict: Verdict, reason: String) -> CellProperty {
    CellProperty { name, verdict, reason, help: None, counterexample: None }
}

fn with_parts(parts: u32) -> String {
    if parts == 1 { "1 part in the cell".to_owned() } else { format!("{parts} parts in the cell at once") }
}

fn undecided((sound, why): (u32, &ExplorationUndecided)) -> String {
    match sound {
        0 => limit_in_words(why),
        sound => format!("it holds with up to {}; with more it is {}", with_parts(sound), limit_in_words(why)),
    }
}

/// Why a search stopped. A cell's net is always bounded, so that is no reason here.
pub(super) fn limit_in_words(why: &ExplorationUndecided) -> String {
    let what = match &why.cause {
        ExplorationLimit::States { limit } => format!("there are more than the {limit} allowed"),
        ExplorationLimit::Bytes { .. } | ExplorationLimit::Overflow(_) => why.cause.to_string(),
    };
    format!("undecided after {} states: {what}", why.states)
}

/// Whether each activity happens for each stage that it is described for. An activity possible for one part alone is
/// possible among others, and the other way round; so one exhausted search decides.
fn happens(
    setting: &CellExploration<'_>,
    nets: &Nets<'_>,
    groups: &[ResourceGroup],
    plays: &[GroupSearch],
    limit: Option<(u32, &ExplorationUndecided)>,
) -> CellProperty {
    if let Some((0, why)) = limit {
        return property(HAPPENS, Verdict::Undecided, limit_in_words(why));
    }
    let mut seen: FxHashSet<(&str, StageId, StageId)> = FxHashSet::default();
    for (group, play) in groups.iter().zip(plays) {
        let fired = group.transitions.iter().zip(&play.fires).filter(|(_, fires)| **fires);
        // The last part of an activity; it cannot fire without the others.
        let ends = fired.filter_map(|(&t, _)| moved(nets, t)).filter(|(_, _, phase)| phase.ends());
        seen.extend(ends.map(|(activity, of, _)| (activity.name.as_str(), of.from, of.to)));
    }
    let cell = setting.cell;
    let comes = |stage: StageId| {
        let of = cell.stages[stage.index()].part_type;
        setting.parts.as_ref().is_none_or(|parts| parts.get(of.index()).is_some_and(|&count| count > 0))
    };
    let described = cell.activities.iter().flat_map(|activity| activity.moves.iter().map(move |of| (activity, of)));
    let described: Vec<_> = described.filter(|(_, of)| comes(of.from)).collect();
    let never = described.iter().filter(|(activity, of)| !seen.contains(&(&activity.name, of.from, of.to)));
    let never: Vec<String> =
        never.map(|(activity, of)| format!("`{}` of {}", activity.name, cell.stages[of.from.index()].name)).collect();
    match never.as_slice() {
        [] => property(HAPPENS, Verdict::Holds, format!("all {} moves of parts", described.len())),
        never => property(HAPPENS, Verdict::Remark, format!("never: {}", never.join(", "))),
    }
}
