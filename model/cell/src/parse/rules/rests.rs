//! Rests of a machine's station, beside the line that describes them: whether each task begins at the rest that the task before
//! it ends at, and whether a machine whose part was taken away can be made ready for the next one. Without a line nothing is
//! checked here.
//!
//! Only of resources for one part: where there are several, loading follows loading.

use linewright_line::{RestId, Station, StationId, Task};
use linewright_text::{Problem, Report};

use super::orders::expected;
use crate::parse::draft::{DraftActivity, DraftCell, DraftOrder, DraftResource};
use crate::{ControllerId, ResourceId, Role};

/// What happens with a part of a machine, in this order and again from the beginning.
const PHASES: [Role; 3] = [Role::Target, Role::Worker, Role::Source];

/// A machine with a task-driven station.
struct Machine<'d, 'a> {
    id: ResourceId,
    of: &'d DraftResource<'a>,
    controller: ControllerId,
    station: &'d Station,
}

/// A task that is ordered, with the activity and the order.
struct Ordered<'d, 'a> {
    activity: &'d DraftActivity<'a>,
    order: &'d DraftOrder<'a>,
    task: &'d Task,
}

/// Applies the rules to each machine.
pub(super) fn machines_come_from_rest_to_rest(draft: &DraftCell<'_>, report: &mut Report) {
    for machine in machines(draft) {
        tasks_begin_where_others_end(draft, &machine, report);
        an_empty_machine_can_be_made_ready(draft, &machine, report);
    }
}

fn machines<'d, 'a>(draft: &'d DraftCell<'a>) -> impl Iterator<Item = Machine<'d, 'a>> {
    draft.resources.iter().enumerate().filter_map(|(at, of)| {
        of.prototype.filter(|prototype| prototype.processes() && of.capacity == Some(1))?;
        let (line, controller, name) = (draft.line?, of.controller?, of.raw.station.as_ref()?);
        let station: StationId = line.station_named(&name.value)?;
        let station = Some(line.station(station)).filter(|station| station.is_task_driven())?;
        Some(Machine { id: ResourceId::at(at), of, controller, station })
    })
}

impl<'d, 'a> Machine<'d, 'a> {
    fn is_used_by(&self, activity: &DraftActivity<'_>, role: Role) -> bool {
        activity.used(role).any(|part| part.value.of == Some(self.id))
    }

    /// The order of an activity to its station.
    fn order_in<'o, 'b>(&self, activity: &'o DraftActivity<'b>) -> Option<&'o DraftOrder<'b>> {
        activity.orders.iter().find(|order| order.controller == Some(self.controller))
    }

    /// The order of an activity to its station, with the task.
    fn ordered_by(&self, activity: &'d DraftActivity<'a>) -> Option<Ordered<'d, 'a>> {
        let order = self.order_in(activity)?;
        let task = self.station.task_named(&order.raw.task.as_ref()?.value)?;
        Some(Ordered { activity, order, task: self.station.task(task) })
    }

    /// The tasks of a phase; none unless each of its activities orders one.
    fn tasks_of(&self, draft: &'d DraftCell<'a>, role: Role) -> Option<Vec<Ordered<'d, 'a>>> {
        let all = draft.activities.iter().filter(|activity| self.is_used_by(activity, role));
        all.map(|activity| self.ordered_by(activity)).collect()
    }

    /// Whether nothing is ordered in a phase.
    fn is_without_order(&self, draft: &DraftCell<'_>, role: Role) -> bool {
        let mut used = draft.activities.iter().filter(|activity| self.is_used_by(activity, role));
        !used.any(|activity| self.order_in(activity).is_some())
    }

    /// Whether its station is ordered to do something that is none of these phases, or of two: it may stand anywhere then.
    fn does_other_things(&self, draft: &DraftCell<'_>) -> bool {
        let phases =
            |activity: &DraftActivity<'_>| PHASES.iter().filter(|role| self.is_used_by(activity, **role)).count();
        let mut ordering = draft.activities.iter().filter(|activity| self.order_in(activity).is_some());
        ordering.any(|activity| phases(activity) != 1)
    }

    fn rest(&self, rest: RestId) -> &'d str {
        &self.station.rests[rest.index()].name
    }
}

impl Ordered<'_, '_> {
    fn problem(&self, message: String) -> Option<Problem> {
        self.order.raw.task.as_ref().map(|task| Problem::error(task.at.clone(), message))
    }
}

/// An order whose task begins at another rest is refused, each time.
fn tasks_begin_where_others_end(draft: &DraftCell<'_>, machine: &Machine<'_, '_>, report: &mut Report) {
    // An order for it that names another station is an error of that order.
    let is_missed = |activity: &DraftActivity<'_>| {
        let tasks = activity.orders.iter().filter_map(|order| order.raw.task.as_ref());
        let mut meant = tasks.filter_map(|task| expected(draft, activity, &task.value));
        meant.any(|(of, _)| of.controller == Some(machine.controller))
    };
    if machine.does_other_things(draft) || draft.activities.iter().any(is_missed) {
        return;
    }
    let phases = PHASES.iter().filter(|role| !machine.is_without_order(draft, **role));
    let phases: Vec<_> = phases.map(|role| machine.tasks_of(draft, *role)).collect();
    for (at, before) in phases.iter().enumerate() {
        let (Some(before), Some(after)) = (before, &phases[(at + 1) % phases.len()]) else { continue };
        let Some(next) = after.first() else { continue };
        for ended in before.iter().filter(|ended| after.iter().all(|next| next.task.from != ended.task.to)) {
            let (station, stands) = (&machine.station.name, machine.rest(ended.task.to));
            let message = format!(
                "task `{}` of `{station}` ends at rest `{stands}`, and `{}`, which comes next, begins at `{}`",
                ended.task.name,
                next.task.name,
                machine.rest(next.task.from)
            );
            let hint = format!(
                "`{}` is not taken on at `{stands}`; order a task that begins there, or one that ends at `{}`",
                next.activity.name,
                machine.rest(next.task.from)
            );
            let problem = ended.problem(message).map(|problem| match &next.order.raw.task {
                Some(task) => problem.hint(hint).also(&task.at, "comes next"),
                None => problem.hint(hint),
            });
            problem.into_iter().for_each(|problem| report.add(problem));
        }
    }
}

/// Where its part is taken away by hand, a machine stays as it is; a task that waits for a part leads nowhere then.
fn an_empty_machine_can_be_made_ready(draft: &DraftCell<'_>, machine: &Machine<'_, '_>, report: &mut Report) {
    let Some(loads) = machine.tasks_of(draft, Role::Target).filter(|loads| !loads.is_empty()) else { return };
    let station = machine.station;
    let waits = |task: &&Task| station.task_named(&task.name).is_some_and(|id| station.waits_for_inputs(id));
    let free: Vec<&Task> = station.tasks.iter().filter(|task| !waits(task)).collect();
    let mut ready: Vec<RestId> = loads.iter().map(|load| load.task.from).collect();
    // Each pass finds the rests that are one task further away.
    for _ in 0..station.rests.len() {
        let nearer: Vec<RestId> = free.iter().filter(|task| ready.contains(&task.to)).map(|task| task.from).collect();
        ready.extend(nearer);
    }
    let ordered = draft.activities.iter().filter_map(|activity| machine.ordered_by(activity));
    let mut stands: Vec<RestId> = ordered.flat_map(|of| [of.task.from, of.task.to]).collect();
    stands.sort_unstable();
    stands.dedup();
    for from in stands.into_iter().filter(|rest| !ready.contains(rest)) {
        let (resource, from, to) = (machine.of.name, machine.rest(from), machine.rest(loads[0].task.from));
        let message = format!("`{resource}` cannot be made ready from rest `{from}` without a part");
        let hint = format!(
            "where its part is taken out by hand, nothing leads `{}` from `{from}` to `{to}`: give it such a task whose operations \
             have no `waits`, with a hand-mode button of its own",
            station.name
        );
        report.add(Problem::warning(machine.of.place(), message).hint(hint));
    }
}
