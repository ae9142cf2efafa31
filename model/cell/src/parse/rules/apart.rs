//! Tasks that reach into a place of another station, and conflicts of the line that keep them apart.

use std::collections::HashSet;

use linewright_line::{Grip, Line, StateSpan, StationId, TaskId};
use linewright_text::{Problem, Report};

use super::orders::ordered;
use crate::parse::draft::{DraftCell, DraftOrder};

/// A task of a station.
type StationTask = (StationId, TaskId);

/// Where a conflict keeps one task of a hand apart from what a machine does, each other task that reaches into that machine needs one too:
/// it is forgotten when a task is added. Tasks that one activity orders together are joined by their waits.
pub(super) fn tasks_that_reach_alike_are_kept_apart(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(line) = draft.line else { return };
    let task_of = |span: StateSpan| Some((span.station, line.station(span.station).task_of(span.from)?));
    let apart: HashSet<(StationTask, StationTask)> = line
        .conflicts
        .iter()
        .filter_map(|conflict| Some((task_of(conflict.a)?, task_of(conflict.b)?)))
        .flat_map(|(a, b)| [(a, b), (b, a)])
        .collect();
    let orders = || draft.activities.iter().flat_map(|activity| &activity.orders);
    for (hand, owner, reach) in hands_in_machines(line) {
        let reaching: Vec<TaskId> = reaching(line, hand, reach).collect();
        for other in line.station(owner).task_ids() {
            let is_apart = |task: &TaskId| apart.contains(&((hand, *task), (owner, other)));
            let Some(&like) = reaching.iter().find(|task| is_apart(task)) else { continue };
            let is_joined = |task: TaskId| {
                draft.activities.iter().any(|activity| {
                    let has = |of: StationTask| activity.orders.iter().any(|order| ordered(line, order) == Some(of));
                    has((hand, task)) && has((owner, other))
                })
            };
            for &task in reaching.iter().filter(|task| !is_apart(task) && !is_joined(**task)) {
                let is_of_it = |order: &&DraftOrder<'_>| ordered(line, order) == Some((hand, task));
                let Some(place) = orders().find(is_of_it).and_then(|order| order.raw.task.as_ref()) else { continue };
                let of = |(station, task): StationTask| {
                    (line.station(station).name.as_str(), line.station(station).task(task).name.as_str())
                };
                let (_, like) = of((hand, like));
                let ((hand, task), (owner, other)) = (of((hand, task)), of((owner, other)));
                let message = format!(
                    "`{task}` of `{hand}` reaches into `{owner}`, and no `[[conflict]]` keeps it apart from `{other}` of `{owner}`"
                );
                report.add(Problem::warning(place.at.clone(), message).hint(format!(
                    "`{like}` reaches there too and has one: write the like in the line's description, with \
                     a = {{ station = \"{hand}\", task = \"{task}\" }} and b = {{ station = \"{owner}\", task = \"{other}\" }}"
                )));
            }
        }
    }
}

/// Each station with a hand that reaches into a place of another station, with that one and the number of the reach.
fn hands_in_machines(line: &Line) -> impl Iterator<Item = (StationId, StationId, usize)> + '_ {
    line.handling.reaches.iter().enumerate().filter_map(|(at, reach)| {
        let Grip::Hand(stand) = line.handling.holder(reach.hand).grip else { return None };
        let (owner, _) = line.handling.holder(reach.to).name.split_once('.')?;
        let owner = line.station_named(owner)?;
        (owner != stand.station).then_some((stand.station, owner, at))
    })
}

/// The tasks of a station whose motions bring its axes to where it reaches.
fn reaching(line: &Line, hand: StationId, reach: usize) -> impl Iterator<Item = TaskId> + '_ {
    let station = line.station(hand);
    station.task_ids().filter(move |task| {
        let mut own = line.handling.reaches[reach].when.iter().filter(|stand| stand.station == hand).peekable();
        own.peek().is_some()
            && own.all(|stand| {
                let comes = |motion: &linewright_line::Motion| motion.axis == stand.axis && motion.to == stand.at;
                station.operations_of(*task).any(|op| comes(&station.operations[op.index()].motion))
            })
    })
}
