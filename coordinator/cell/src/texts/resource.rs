//! Alarms of a resource that is left out: what is so at it, and how that is put right.

use linewright_line::{RestId, StationId};
use linewright_orders::TaskRefusal;

use crate::exception::{AlarmAnswerRefusal, OtherRest, RecoveryPolicy, ResourceRequest, SensorMismatch, WrongRest};
use crate::firing::OngoingActivity;
use crate::ids::{PartId, ResourceId};
use crate::player::Coordination;
use crate::record::OrderFailure;
use crate::state::PlayerState;
use crate::texts::alarm::AlarmText;

/// A sensor that contradicts the model. `first`: the station is closed on a part that the model has not.
pub(crate) fn mismatch(
    state: &PlayerState,
    found: &SensorMismatch,
    missing: Option<PartId>,
    first: Option<&WrongRest>,
) -> String {
    let missing = missing.map(|part| super::part(state, part));
    let (found, bring) = (difference(state.table().handling(), found), first.map(|first| bring(state, &of(first))));
    AlarmText::Mismatch { found: &found, missing: missing.as_deref(), bring: bring.as_deref() }.text()
}

/// The part that was missing is given up, and its resource cannot be counted on.
pub(crate) fn given_up(state: &PlayerState, resource: ResourceId, why: AlarmAnswerRefusal) -> String {
    let handling = state.table().handling();
    let name = |id: ResourceId| handling.resource_name(id).to_owned();
    let why = why.text(ResourceRequest::Up(resource), |id| handling.station_name(id), name, |_| String::new());
    let found = part_given_up(state, resource);
    AlarmText::GivenUp { found: &found, resource: handling.resource_name(resource), why: &why }.text()
}

/// That the missing part of a resource is given up.
pub(crate) fn part_given_up(state: &PlayerState, resource: ResourceId) -> String {
    AlarmText::PartGivenUp { resource: state.table().handling().resource_name(resource) }.text()
}

/// A station at another rest than its next task begins at.
pub(crate) fn wrong_rest(state: &PlayerState, found: &WrongRest) -> String {
    let handling = state.table().handling();
    AlarmText::WrongRest {
        resource: handling.resource_name(found.resource),
        station: &handling.station_name(found.station),
        stands: rest_name(handling, found.station, found.stands),
        wanted: rest_name(handling, found.station, found.wanted),
        next: state.table().called(found.next),
        has_part: found.has_part,
        bring: &bring(state, &of(found)),
    }
    .text()
}

fn of(found: &WrongRest) -> OtherRest {
    OtherRest { station: found.station, stands: found.stands, wanted: found.wanted }
}

/// A station that stands at another rest than the task begins at that an order is for, and how it is brought there.
pub(crate) fn other_rest(state: &PlayerState, found: &OtherRest) -> String {
    let handling = state.table().handling();
    AlarmText::OtherRest {
        station: &handling.station_name(found.station),
        stands: rest_name(handling, found.station, found.stands),
        wanted: rest_name(handling, found.station, found.wanted),
        bring: &bring(state, found),
    }
    .text()
}

/// The same of a station that has refused its order for it, as it stands now.
pub(crate) fn refused_there(
    of: &Coordination,
    firing: &OngoingActivity,
    station: StationId,
    failure: OrderFailure,
) -> Option<String> {
    let found = of.other_rest(firing.mode).filter(|found| found.station == station);
    let found = found.filter(|_| failure == OrderFailure::Refused(TaskRefusal::NotThere))?;
    Some(other_rest(of.state(), &found))
}

fn rest_name(handling: &RecoveryPolicy, station: StationId, rest: RestId) -> &str {
    let rests = handling.rests.iter().find(|of| of.station == station);
    rests.and_then(|of| of.names.get(rest.index())).map_or("?", |name| name)
}

/// How the station is brought to the other rest.
fn bring(state: &PlayerState, found: &OtherRest) -> String {
    let handling = state.table().handling();
    let rests = handling.rests.iter().find(|of| of.station == found.station);
    let tasks = rests.map(|of| &of.tasks[..]).unwrap_or_default();
    let (way, back) = rests.map(|of| of.ways(found.stands, found.wanted)).unwrap_or_default();
    let held = [way.map(|task| &*task.button), back.map(|(button, _)| button)];
    let all = tasks.iter().flat_map(|task| &task.shared).filter(|(button, _)| held.contains(&Some(&**button)));
    let mut too: Vec<String> = all.map(|(button, station)| AlarmText::MovesToo { button, station }.text()).collect();
    too.sort_unstable();
    too.dedup();
    AlarmText::Bring {
        station: &handling.station_name(found.station),
        wanted: rest_name(handling, found.station, found.wanted),
        way: way.map(|task| (&*task.button, &*task.name, task.waits)),
        back,
        too: &too,
    }
    .text()
}

pub(super) fn difference(handling: &RecoveryPolicy, found: &SensorMismatch) -> String {
    let resource = handling.resource_name(found.resource);
    if found.model { AlarmText::PartMissing { resource }.text() } else { AlarmText::PartUnexpected { resource }.text() }
}
