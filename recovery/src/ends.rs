//! The stations of one failed activity of a cell are led to the same end of it.
//!
//! An activity is done at every station or at none. Led one by one on the shortest way, one station would finish its part of a transfer
//! and the other take its part back: no answer is true then. So the ends of all are one goal of the search. A station that has
//! completed its order, or one that stands where its order began, decides for the others. Where that end cannot be reached the other one is
//! taken, and where neither can, the stations end differently, which the plan reports ([`LedActivity`]).
//!
//! On the way there each operation that another station has waited for stays done as long as what waited for it is not undone
//! ([`order`]), and none is led on before what it waited for is done: so one of the two stations holds the part all the time. Where no way
//! keeps that, it is given up last, and the plan reports it.

use std::collections::BTreeMap;
use std::rc::Rc;

use linewright_line::net::{Block, MotionStage, StationPlace};
use linewright_line::{Line, OpId, StationId, TaskId};
use linewright_station_logic::StationReport;

use crate::order::{self, OrderedPair};
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

/// What a search keeps.
#[derive(Clone, Debug)]
pub(crate) struct KeptWay {
    /// By activity.
    ends: Vec<KeptEnds>,
    /// Operations are undone in the reverse of the order in which they are done.
    is_ordered: bool,
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
    pub order: LedOrder,
}

/// Whether what a station has waited for is undone after what has waited for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LedOrder {
    Kept,
    /// No way was found that keeps it.
    GivenUp,
    /// The description does not tell it.
    Unknown,
}

/// A station in a task that was stopped half-way.
#[derive(Clone, Copy, Debug)]
struct TaskUnderWay {
    station: StationId,
    task: TaskId,
    /// The operation that ends the task, and how often it was done before.
    last: OpId,
    done: i32,
}

/// How far an operation of a task is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum OpProgress {
    NotBegun,
    Begun,
    Done,
}

/// The led stations of one activity.
struct ActivityUnderWay {
    alarm: u64,
    decided: Option<DecidedEnd>,
    tasks: Vec<TaskUnderWay>,
    /// None where the order is not known.
    pairs: Option<Vec<OrderedPair>>,
}

/// The activities of which stations are led.
#[derive(Default)]
pub(crate) struct CommonEnds {
    activities: Vec<ActivityUnderWay>,
}

impl CommonEnds {
    pub fn of(line: &Line, situation: &LineSituation, led: &[StationId]) -> Self {
        let report = |id: StationId| situation.stations.get(id.index())?.as_ref();
        let task = |&id: &StationId| under_way(line, id, report(id)?);
        let of = |alarm: &StandingAlarm| {
            let tasks: Vec<TaskUnderWay> = alarm.lead.iter().filter(|id| led.contains(id)).filter_map(task).collect();
            let named: Vec<(StationId, TaskId)> = tasks.iter().map(|of| (of.station, of.task)).collect();
            let pairs = order::pairs(line, &named);
            let is_asked = tasks.iter().any(|of| situation.lead_on.contains(&of.station));
            let asked = || DecidedEnd { end: ActivityEnd::Done, because: "it was asked for".to_owned() };
            let decided = alarm.end.clone().or_else(|| is_asked.then(asked));
            ActivityUnderWay { alarm: alarm.id, decided, tasks, pairs }
        };
        CommonEnds { activities: situation.alarms.iter().map(of).filter(|of| !of.tasks.is_empty()).collect() }
    }

    /// Whether the stations, which stand at rests, stand at ends that belong together, as each activity keeps them.
    pub fn agree(&self, units: &PlayedStations, kept: &KeptWay) -> bool {
        self.activities.iter().zip(&kept.ends).all(|(of, kept)| {
            let common = common_end(units, &of.tasks);
            match kept {
                KeptEnds::Decided => common.is_some_and(|end| of.decided.as_ref().is_none_or(|is| is.end == end)),
                KeptEnds::Common => common.is_some(),
                KeptEnds::Any => true,
            }
        })
    }

    /// Whether a move keeps the order: nothing is led on before what it waits for is done, and nothing is undone before all is
    /// that has waited for it.
    pub fn permit(&self, line: &Line, before: &PlayedStations, after: &PlayedStations, kept: &KeptWay) -> bool {
        !kept.is_ordered || self.activities.iter().all(|of| of.is_in_order(line, before, after))
    }

    /// What is kept, from the strictest on: where no way keeps all ends, one activity gives way, and only then
    /// all do. One that cannot be led to its end turns no other round. The order is given up after that.
    pub fn kept(&self) -> Vec<KeptWay> {
        let is_any_ordered = self.activities.iter().any(|of| of.pairs().next().is_some());
        let orders = [true, false].into_iter().take(1 + usize::from(is_any_ordered));
        orders
            .flat_map(|is_ordered| self.kept_ends().into_iter().map(move |ends| KeptWay { ends, is_ordered }))
            .collect()
    }

    fn kept_ends(&self) -> Vec<Vec<KeptEnds>> {
        let strict = vec![KeptEnds::Decided; self.activities.len()];
        let mut all = vec![strict.clone()];
        for looser in [KeptEnds::Common, KeptEnds::Any] {
            for (at, of) in self.activities.iter().enumerate() {
                let is_looser = if looser == KeptEnds::Common { of.decided.is_some() } else { of.tasks.len() > 1 };
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
    pub fn led(&self, last: &PlayedStations, kept: &KeptWay, is_certain: bool) -> Vec<LedActivity> {
        let led = |of: &ActivityUnderWay| LedActivity {
            alarm: of.alarm,
            stations: of.tasks.iter().map(|task| task.station).collect(),
            end: common_end(last, &of.tasks),
            decided: of.decided.clone(),
            is_certain,
            order: match of.pairs {
                None => LedOrder::Unknown,
                Some(_) if kept.is_ordered || of.pairs().next().is_none() => LedOrder::Kept,
                Some(_) => LedOrder::GivenUp,
            },
        };
        self.activities.iter().map(led).collect()
    }
}

impl ActivityUnderWay {
    fn pairs(&self) -> impl Iterator<Item = &OrderedPair> {
        self.pairs.iter().flatten()
    }

    fn is_in_order(&self, line: &Line, before: &PlayedStations, after: &PlayedStations) -> bool {
        let progress = |units: &PlayedStations, (station, op): (StationId, OpId)| {
            let task = self.tasks.iter().find(|task| task.station == station)?;
            Some(task.progress(line, &units[station.index()], op))
        };
        self.pairs().all(|pair| {
            let now = |of| progress(before, of).zip(progress(after, of));
            let (Some((first, first_then)), Some((then, then_next))) = (now(pair.first), now(pair.then)) else {
                return true;
            };
            let is_led_on = then_next > then;
            let is_undone = first_then < first;
            (!is_led_on || first == OpProgress::Done) && (!is_undone || then == OpProgress::NotBegun)
        })
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

    /// How far an operation of the task is done. At a rest the marking does not show whether the task has ended or was taken back.
    fn progress(&self, line: &Line, unit: &PlayedStation, op: OpId) -> OpProgress {
        let (station, report) = (line.station(self.station), &unit.report);
        if report.at_home && report.incomplete.is_empty() {
            return match self.end(report) {
                ActivityEnd::Done => OpProgress::Done,
                ActivityEnd::TakenBack => OpProgress::NotBegun,
            };
        }
        let step = station.step_of(op);
        let marked: Vec<StationPlace> = unit.controller.marking().collect();
        let own = marked.iter().find(|place| place.op == op);
        match (own, marked.first().map(|place| station.step_of(place.op))) {
            (Some(place), _) => match (place.stage, place.block) {
                (MotionStage::Completed, Block::Normal) => OpProgress::Done,
                (MotionStage::Completed, Block::Recovery) => OpProgress::NotBegun,
                (MotionStage::Operating | MotionStage::Incomplete, _) => OpProgress::Begun,
            },
            (None, Some(at)) if step < at => OpProgress::Done,
            (None, _) => OpProgress::NotBegun,
        }
    }
}

/// The task in which a station stands half-way; none at a rest.
fn under_way(line: &Line, id: StationId, report: &StationReport) -> Option<TaskUnderWay> {
    let station = line.station(id);
    let number = |op: OpId| report.places.get(op.index()).copied().unwrap_or_default();
    let op = station.op_ids().find(|&op| number(op) != 0)?;
    let task = station.task_of(op)?;
    let last = station.last_of(task);
    let is_at_end = StationPlace::from_number(last, number(last)) == Some(StationPlace::completed(last));
    let done = report.done.get(last.index()).copied()?;
    (!is_at_end).then_some(TaskUnderWay { station: id, task, last, done })
}

fn common_end(units: &[Rc<PlayedStation>], tasks: &[TaskUnderWay]) -> Option<ActivityEnd> {
    let mut ends = tasks.iter().map(|task| task.end(&units[task.station.index()].report));
    let first = ends.next()?;
    ends.all(|end| end == first).then_some(first)
}
