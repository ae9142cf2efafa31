//! The stations of one failed activity of a cell are led to the same end of it.
//!
//! An activity is done at every station or at none. Led one by one on the shortest way, one station would finish its part of a transfer
//! and the other take its part back: no answer is true then. So the ends of all are one goal of the search. A station that has
//! completed its order, or one that stands where its order began, decides for the others. Where that end cannot be reached the other one is
//! taken, and where neither can, the stations end differently, which the plan reports ([`LedActivity`]).

use std::collections::BTreeMap;
use std::rc::Rc;

use linewright_line::net::StationPlace;
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::StationReport;

use crate::situation::{ActivityEnd, DecidedEnd, LineSituation, StandingAlarm};
use crate::texts;
use crate::units::{PlayedStation, PlayedStations};

/// How strictly ends are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KeptEnds {
    /// One for each activity, and the one that is decided.
    Decided,
    /// One for each activity.
    Common,
    /// Any.
    Any,
}

/// Stations of an alarm that are led, and to which end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LedActivity {
    pub alarm: u64,
    pub stations: Vec<StationId>,
    /// None where they end differently.
    pub end: Option<ActivityEnd>,
    /// What is decided; none where either end will do.
    pub decided: Option<DecidedEnd>,
    /// Every way was tried that keeps ends more strictly than this list does.
    pub is_certain: bool,
}

/// A station in a task that was stopped half-way.
#[derive(Clone, Copy, Debug)]
struct TaskUnderWay {
    station: StationId,
    /// The operation that ends the task, and how often it was done before.
    last: OpId,
    done: i32,
}

/// The activities of which stations are led.
#[derive(Default)]
pub(crate) struct CommonEnds {
    activities: Vec<(u64, Option<DecidedEnd>, Vec<TaskUnderWay>)>,
}

impl CommonEnds {
    pub fn of(line: &Line, situation: &LineSituation, led: &[StationId]) -> Self {
        let report = |id: StationId| situation.stations.get(id.index())?.as_ref();
        let task = |&id: &StationId| under_way(line, id, report(id)?);
        let led = |alarm: &StandingAlarm| -> Vec<TaskUnderWay> {
            alarm.lead.iter().filter(|id| led.contains(id)).filter_map(task).collect()
        };
        let all = situation.alarms.iter().map(|alarm| (alarm.id, alarm.end.clone(), led(alarm)));
        CommonEnds { activities: all.filter(|(.., tasks)| !tasks.is_empty()).collect() }
    }

    /// Whether the stations, which stand at rests, stand at ends that belong together, as each activity keeps them.
    pub fn agree(&self, units: &PlayedStations, kept: &[KeptEnds]) -> bool {
        self.activities.iter().zip(kept).all(|((_, decided, tasks), kept)| {
            let common = common_end(units, tasks);
            match kept {
                KeptEnds::Decided => common.is_some_and(|end| decided.as_ref().is_none_or(|of| of.end == end)),
                KeptEnds::Common => common.is_some(),
                KeptEnds::Any => true,
            }
        })
    }

    /// How ends are kept, for each activity, from the strictest on: where no way keeps them all, one activity gives way, and only then
    /// all do. One that cannot be led to its end turns no other round.
    pub fn kept(&self) -> Vec<Vec<KeptEnds>> {
        let strict = vec![KeptEnds::Decided; self.activities.len()];
        let mut all = vec![strict.clone()];
        for looser in [KeptEnds::Common, KeptEnds::Any] {
            for (at, (_, decided, tasks)) in self.activities.iter().enumerate() {
                let is_looser = if looser == KeptEnds::Common { decided.is_some() } else { tasks.len() > 1 };
                if is_looser {
                    let mut kept = strict.clone();
                    kept[at] = looser;
                    all.push(kept);
                }
            }
        }
        if self.activities.len() > 1 {
            all.extend([KeptEnds::Common, KeptEnds::Any].map(|looser| vec![looser; self.activities.len()]));
        }
        all
    }

    /// Where the stations stand at last.
    pub fn led(&self, last: &PlayedStations, is_certain: bool) -> Vec<LedActivity> {
        let led = |(alarm, decided, tasks): &(u64, Option<DecidedEnd>, Vec<TaskUnderWay>)| LedActivity {
            alarm: *alarm,
            stations: tasks.iter().map(|task| task.station).collect(),
            end: common_end(last, tasks),
            decided: decided.clone(),
            is_certain,
        };
        self.activities.iter().map(led).collect()
    }
}

/// The ends that stations were seen to reach since an alarm stands: a report at a rest where a task begins and ends alike does not
/// have which of the two it is. To be kept from one plan to the next.
#[derive(Default)]
pub struct EndsReached(BTreeMap<u64, Vec<TaskUnderWay>>);

impl EndsReached {
    /// An alarm without a decided end has that at which one of its stations has arrived.
    pub fn complete(&mut self, line: &Line, situation: &mut LineSituation) {
        self.0.retain(|id, _| situation.alarms.iter().any(|alarm| alarm.id == *id));
        let stations = &situation.stations;
        let report = |id: StationId| stations.get(id.index())?.as_ref();
        for alarm in &mut situation.alarms {
            let known = self.0.entry(alarm.id).or_default();
            for &id in &alarm.lead {
                let is_new = known.iter().all(|task| task.station != id);
                known.extend(report(id).filter(|_| is_new).and_then(|report| under_way(line, id, report)));
            }
            let arrived = known.iter().filter(|task| !alarm.lead.contains(&task.station));
            let mut reached = arrived.filter_map(|task| {
                let report = report(task.station).filter(|report| report.at_home && report.incomplete.is_empty())?;
                Some((task.station, task.end(report)))
            });
            if let (None, Some((station, end))) = (&alarm.end, reached.next_back()) {
                alarm.end = Some(DecidedEnd { end, because: texts::reached(line, station, end) });
            }
        }
    }
}

impl TaskUnderWay {
    /// The end at which the station is, now that it rests.
    fn end(&self, report: &StationReport) -> ActivityEnd {
        if report.done[self.last.index()] > self.done { ActivityEnd::Done } else { ActivityEnd::TakenBack }
    }
}

/// The task in which a station stands half-way; none at a rest.
fn under_way(line: &Line, id: StationId, report: &StationReport) -> Option<TaskUnderWay> {
    let station = line.station(id);
    let number = |op: OpId| report.places.get(op.index()).copied().unwrap_or_default();
    let op = station.op_ids().find(|&op| number(op) != 0)?;
    let last = station.last_of(station.task_of(op)?);
    let is_at_end = StationPlace::from_number(last, number(last)) == Some(StationPlace::completed(last));
    let done = report.done.get(last.index()).copied()?;
    (!is_at_end).then_some(TaskUnderWay { station: id, last, done })
}

fn common_end(units: &[Rc<PlayedStation>], tasks: &[TaskUnderWay]) -> Option<ActivityEnd> {
    let mut ends = tasks.iter().map(|task| task.end(&units[task.station.index()].report));
    let first = ends.next()?;
    ends.all(|end| end == first).then_some(first)
}
