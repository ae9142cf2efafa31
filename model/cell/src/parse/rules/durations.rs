//! Times of activities beside the durations of their stations' operations: both say how long the same thing takes.

use std::time::Duration;

use linewright_line::{Station, Task};
use linewright_text::{Located, Problem, Report};

use super::orders::{ordered, times, works};
use crate::parse::draft::{DraftActivity, DraftCell, DraftOrder};
use crate::{ActivityKind, ParameterSource};

/// Largest difference that is not reported, as a part of the longer time.
const TOLERANCE: f64 = 0.1;
/// Largest difference that is not reported, however short the times.
const LEAST: Duration = Duration::from_millis(100);

/// What the chart says of a task: its operations, one after the other.
pub(super) struct ChartedTask<'d> {
    station: &'d Station,
    task: &'d Task,
}

impl ChartedTask<'_> {
    fn operations(&self) -> impl Iterator<Item = (&str, Duration)> {
        let steps = self.station.steps.get(self.task.steps.clone()).unwrap_or_default();
        let operations = steps.iter().flatten().map(|op| &self.station.operations[op.index()]);
        operations.map(|operation| (operation.name.as_str(), operation.duration))
    }

    /// Its operations one after the other, as they are planned.
    pub(super) fn takes(&self) -> Duration {
        self.operations().map(|(_, duration)| duration).sum()
    }

    /// `task `run` of `washer`: close the door 0.5 s, work 4 s`.
    fn text(&self) -> String {
        let all: Vec<String> =
            self.operations().map(|(name, duration)| format!("{name} {} s", duration.as_secs_f64())).collect();
        format!("task `{}` of `{}`: {}", self.task.name, self.station.name, all.join(", "))
    }
}

/// What the stations of an activity take by their charts: at least the longest of their tasks, and at most all of them one after the other
/// where they wait for each other. With a `time_s` outside of that, plans are made for another cell than the one described. Where a step gives a
/// program its time is the program's. A task that is done for several steps has one duration, around which their times may lie.
pub(super) fn times_are_those_of_the_charts(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    let Some(charted) = charts(draft, activity) else { return };
    let Some(longest) = charted.iter().map(ChartedTask::takes).max() else { return };
    let all: Duration = charted.iter().map(ChartedTask::takes).sum();
    let written: Vec<Located<Duration>> = times(draft, activity).collect();
    let is_shorter = |a: Duration, b: Duration| a + b.mul_f64(TOLERANCE).max(LEAST) < b;
    let too_short = written.iter().all(|time| is_shorter(time.value, longest));
    let too_long = written.iter().all(|time| is_shorter(all, time.value));
    if !too_short && !too_long {
        return;
    }
    let seconds = |time: Duration| time.as_secs_f64();
    let takes = match longest == all {
        true => format!("{} s", seconds(all)),
        false => format!("{} to {} s", seconds(longest), seconds(all)),
    };
    let charts: Vec<String> = charted.iter().map(ChartedTask::text).collect();
    // What fails every order is reported by that.
    let safety = draft.raw.cell.as_ref().map_or(1.0, |cell| cell.safety);
    let is_limited = activity.orders.iter().all(|order| order.raw.limit.is_some());
    let is_possible = |time: &Located<Duration>| {
        let fits = charted.iter().all(|of| time.value <= of.task.limit);
        fits && (is_limited || time.value.mul_f64(safety) > longest)
    };
    for time in written.into_iter().filter(is_possible) {
        let message = format!(
            "`time_s` is {} s, but `{}` takes {takes} by `duration_s` of its operations",
            seconds(time.value),
            activity.name
        );
        let hint =
            format!("in the line's description {}: write here what that takes, or change it there", charts.join("; "));
        report.add(Problem::warning(time.at, message).label("differs by more than a tenth").hint(hint));
    }
}

/// The charts of an activity's tasks; none where one of them is not known, or a program decides how long it takes.
fn charts<'d>(draft: &DraftCell<'d>, activity: &DraftActivity<'_>) -> Option<Vec<ChartedTask<'d>>> {
    let is_programmed =
        |order: &DraftOrder<'_>| order.parameters.iter().any(|(_, source)| matches!(source, ParameterSource::Program));
    if activity.orders.iter().any(is_programmed) {
        return None;
    }
    activity.orders.iter().map(|order| charted(draft, order)).collect()
}

/// Time of an activity that has none written, by the charts of its stations' tasks.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::parse) struct ChartedTime {
    /// The longest of the tasks: its nominal time.
    pub(in crate::parse) longest: Duration,
    /// All of them one after the other, which it takes where its stations wait for each other throughout.
    pub(in crate::parse) sum: Duration,
}

/// The time of an activity by its charts; none where they are not known, or a program decides it.
pub(in crate::parse) fn charted_time(draft: &DraftCell<'_>, activity: &DraftActivity<'_>) -> Option<ChartedTime> {
    let charted = charts(draft, activity)?;
    let longest = charted.iter().map(ChartedTask::takes).max()?;
    let sum = charted.iter().map(ChartedTask::takes).sum();
    (!longest.is_zero()).then_some(ChartedTime { longest, sum })
}

/// The same, only where a time of the activity is left out: of a process, one of those of the steps that it is for.
pub(super) fn time_left_out(draft: &DraftCell<'_>, activity: &DraftActivity<'_>) -> Option<ChartedTime> {
    let is_left_out = match activity.kind {
        ActivityKind::Process => works(draft, activity).any(|raw| !raw.has_time),
        _ => activity.time.is_none(),
    };
    if is_left_out { charted_time(draft, activity) } else { None }
}

/// An order without a limit may take `safety` times the operations of its activity's tasks where no time is written: longer than they take
/// one after the other, otherwise it fails without a fault.
pub(super) fn charted_limits_leave_room(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    let Some(charted) = time_left_out(draft, activity) else { return };
    let Some(order) = activity.orders.iter().find(|order| order.raw.limit.is_none()) else { return };
    if draft.raw.cell.as_ref().is_none_or(|cell| cell.safety > 1.0) {
        return;
    }
    let message = format!(
        "`safety` is 1: an order of `{}` may take no longer than the {} s of the operations of its tasks",
        activity.name,
        charted.sum.as_secs_f64()
    );
    report.add(Problem::warning(order.raw.at.clone(), message).label("too short").hint(
        "orders fail that take what they should: give it `max_s`, twice as long as the motions is usual, or a larger `safety`",
    ));
}

/// Each resource of a step has a time: a written one, or that of its station's chart.
pub(super) fn works_have_times(draft: &DraftCell<'_>, report: &mut Report) {
    for (on, raw) in draft.steps().flat_map(|step| step.on.iter().zip(&step.raw.on)).filter(|(_, raw)| !raw.has_time) {
        let is_its = |of: &&DraftActivity<'_>| {
            of.kind == ActivityKind::Process && on.is_some() && of.uses.first().is_some_and(|part| part.value.of == *on)
        };
        let work = draft.activities.iter().find(is_its);
        if work.and_then(|work| charted_time(draft, work)).is_none() {
            let problem =
                Problem::error(raw.at.clone(), "a resource of a step needs `time_s`").label("its time is not known");
            report.add(problem.hint(
                "write `time_s = …`. Nominal time there, in seconds, up to a day; without it the operations of its station's task have to \
                 be known, and to take no program",
            ));
        }
    }
}

/// The chart of an order's task; none where it is not known, which is another rule's error.
pub(super) fn charted<'d>(draft: &DraftCell<'d>, order: &DraftOrder<'_>) -> Option<ChartedTask<'d>> {
    let line = draft.line?;
    let (station, task) = ordered(line, order)?;
    let station = line.station(station);
    Some(ChartedTask { station, task: station.task(task) })
}
