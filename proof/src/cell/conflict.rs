//! Whether tasks that are in conflict can be under way at once, by what the cell's net lets start.
//!
//! An activity orders its tasks when it starts, and what has been ordered is under way until it is over at the latest. So two
//! tasks are under way at once exactly if one activity orders both, or if two activities that order one each are in progress
//! at once. What has started takes its tokens and gives nothing before its end. So a start can be put off until right before
//! the marking in question, and other ends moved forward as everywhere here: two activities can be in progress at once if,
//! and only if, a marking is reached that holds what both take together.
//!
//! An activity that has failed keeps its tokens until it is closed. The property holds until then; afterwards its
//! stations may stand in the midst of their tasks.

use linewright_line::{Line, StateSpan};
use linewright_nets::explicit::{ExplorationLimits, find};

use super::counterexample::{CellPath, tell};
use super::group::{ResourceGroup, groups};
use super::verdict::limit_in_words;
use super::words::moved;
use super::{CellExploration, CellNotExplorable, CellProperty, Detail, Nets, Verdict};

/// Name of the property.
pub const APART: &str = "tasks in conflict are never under way at once";

/// A transition of a group that orders a task.
struct Ordering<'n> {
    group: usize,
    transition: usize,
    activity: &'n str,
}

/// The answer for each conflict of tasks in the cell's line, in its order.
///
/// # Errors
/// When there is no net to explore.
pub fn check_conflicts(setting: &CellExploration<'_>, line: &Line) -> Result<Vec<CellProperty>, CellNotExplorable> {
    let conflicts: Vec<_> = line.conflicts.iter().filter(|conflict| line.is_of_tasks(conflict)).collect();
    if conflicts.is_empty() {
        return Ok(Vec::new());
    }
    let cell = setting.cell;
    if !cell.limits.reserve {
        let reason = "without reserved grasps a cell is not played: nothing is ordered".to_owned();
        return Ok(conflicts.iter().map(|_| property(Verdict::Remark, reason.clone(), None)).collect());
    }
    let nets = Nets::of(setting, Detail::Coordination)?;
    let groups = groups(&nets);
    let search =
        ConflictSearch { nets: &nets, groups: &groups, line, wip_max: cell.limits.wip_max, limits: &setting.limits };
    Ok(conflicts.iter().map(|conflict| search.judge(&conflict.why, [&conflict.a, &conflict.b])).collect())
}

fn property(verdict: Verdict, reason: String, counterexample: Option<CellPath>) -> CellProperty {
    CellProperty { name: APART, verdict, reason, help: None, counterexample }
}

struct ConflictSearch<'s> {
    nets: &'s Nets<'s>,
    groups: &'s [ResourceGroup],
    line: &'s Line,
    wip_max: u32,
    limits: &'s ExplorationLimits,
}

impl ConflictSearch<'_> {
    /// The transitions of activities that order a task.
    fn orders(&self, span: &StateSpan) -> Vec<Ordering<'_>> {
        let station = self.line.station(span.station);
        let Some(task) = station.task_of(span.from) else { return Vec::new() };
        let (cell, task) = (self.nets.cell, &station.task(task).name);
        let mut found = Vec::new();
        for (group, of) in self.groups.iter().enumerate() {
            for (transition, &t) in of.transitions.iter().enumerate() {
                let Some((activity, _, _)) = moved(self.nets, t) else { continue };
                let is_it = activity
                    .orders
                    .iter()
                    .any(|order| cell.controllers[order.controller.index()] == station.name && order.task == *task);
                if is_it {
                    found.push(Ordering { group, transition, activity: &activity.name });
                }
            }
        }
        found
    }

    fn judge(&self, why: &str, spans: [&StateSpan; 2]) -> CellProperty {
        let [a, b] = spans.map(|span| self.orders(span));
        let name = |span: &StateSpan| {
            let station = self.line.station(span.station);
            let task = station.task_of(span.from).map_or("?", |task| station.task(task).name.as_str());
            format!("`{task}` of {}", station.name)
        };
        let names = format!("{} and {}", name(spans[0]), name(spans[1]));
        if a.is_empty() || b.is_empty() {
            let none = name(spans[usize::from(!a.is_empty())]);
            return property(Verdict::Holds, format!("{why}: no activity orders {none}"), None);
        }
        let mut open = None;
        for (index, group) in self.groups.iter().enumerate() {
            let pairs: Vec<_> = pairs(&a, &b).filter(|(a, b)| a.group == index && b.group == index).collect();
            let Some(net) = group.net(self.wip_max).filter(|_| !pairs.is_empty()) else { continue };
            let taken = |a: &Ordering<'_>, b: &Ordering<'_>| {
                let mut sum = group.takes(a.transition).to_vec();
                if a.transition != b.transition {
                    sum.extend(group.takes(b.transition));
                }
                sum.sort_unstable();
                sum.chunk_by(|x, y| x.0 == y.0).map(|same| (same[0].0, same.iter().map(|(_, n)| n).sum())).collect()
            };
            let sums: Vec<Vec<(_, u32)>> = pairs.iter().map(|(a, b)| taken(a, b)).collect();
            let mut which = 0;
            let found = find(&net, self.limits, |view| {
                let holds = |sum: &Vec<(_, u32)>| sum.iter().all(|&(place, n)| view.tokens(place) >= n);
                sums.iter().position(holds).is_some_and(|at| {
                    which = at;
                    true
                })
            });
            match found {
                Ok(None) => (),
                Ok(Some(found)) => {
                    let (a, b) = pairs[which];
                    let end = if a.transition == b.transition {
                        format!("`{}` orders {names} at once: {why}", a.activity)
                    } else {
                        format!(
                            "`{}` and `{}` can both start here, and {names} are under way at once: {why}",
                            a.activity, b.activity
                        )
                    };
                    let steps = found.path.len();
                    let story = tell(self.nets, group, &found, &end);
                    return property(Verdict::Fails, format!("{why}: after {steps} steps"), Some(story));
                }
                Err(why) => open = Some(limit_in_words(&why)),
            }
        }
        // Resources of different groups do not wait for each other: each part comes to its place independently.
        if let Some((a, b)) = pairs(&a, &b).find(|(a, b)| a.group != b.group).filter(|_| self.wip_max > 1) {
            let end = format!(
                "`{}` and `{}` have no resource in common, and {names} may be under way at once: {why}",
                a.activity, b.activity
            );
            let story = CellPath { steps: Vec::new(), end, resources: Vec::new() };
            return property(Verdict::Fails, format!("{why}: nothing joins the two"), Some(story));
        }
        match open {
            Some(reason) => property(Verdict::Undecided, format!("{why}: {reason}"), None),
            None => {
                let reason = format!("{why}: no activities that order {names} can be in progress at once");
                property(Verdict::Holds, reason, None)
            }
        }
    }
}

fn pairs<'p>(
    a: &'p [Ordering<'p>],
    b: &'p [Ordering<'p>],
) -> impl Iterator<Item = (&'p Ordering<'p>, &'p Ordering<'p>)> {
    a.iter().flat_map(move |a| b.iter().map(move |b| (a, b)))
}
