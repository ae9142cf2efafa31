//! A station's controller, made from its report: as after a restart with memory.
//!
//! The report does not have all of the memory. What is missing is chosen so that the controller reports what the station does:
//! whether it is missed where its chart has it, whether its index is in doubt, and on which recovery path it is.

use linewright_line::net::{ControlMode, MotionStage, StationPlace};
use linewright_line::{Line, OpId, OperationModule, Station, StationId};
use linewright_station_logic::{
    Controller, PanelCommand, Restore, Rules, StationInput, StationReport, StationSnapshot, StopCause,
};

use crate::image;
use crate::units::{PlayedStation, whole_image};

/// A report that is no state of the station of this description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RestoreMisfit(pub StationId);

/// Numbers of requests begin far above those that were used.
const FIRST_REQUEST: u64 = 1 << 40;

/// Times are not measured: an index arrives when it does.
pub(crate) const RULES: Rules = Rules { timely: false, ..Rules::ALL };

/// The unit of a station, with its devices in order and what moves arrived.
pub(crate) fn unit(line: &Line, id: StationId, report: &StationReport) -> Result<PlayedStation, RestoreMisfit> {
    let station = line.station(id);
    let marked: Vec<StationPlace> = places(station, report).ok_or(RestoreMisfit(id))?;
    // A motion of hand mode whose button was let go of does not arrive by itself when that mode has ended.
    let is_paused = report.stopped && matches!(report.mode, Some(ControlMode::StandBy | ControlMode::Manual));
    let moves = |place: &StationPlace| place.is_operating() && !is_paused;
    let moving: Vec<StationPlace> = marked.iter().copied().filter(moves).collect();
    let bits = if report.devices_valid { report.measured } else { expected(station, &marked) };
    let bits = if moving.is_empty() { bits } else { image::arrived(line, id, bits, &moving) };
    let (mut done, mut started) = (report.done.clone(), report.started.clone());
    for place in &moving {
        let op = place.op.index();
        if place.number() == StationPlace::operating(place.op).number() {
            done[op] = started[op];
        } else {
            started[op] = done[op];
        }
    }
    let arrive = |place: StationPlace| StationPlace {
        stage: if place.is_operating() { MotionStage::Completed } else { place.stage },
        ..place
    };
    let snapshot = StationSnapshot {
        marking: marked.iter().copied().map(arrive).collect(),
        generation: report.generation,
        placed: report.placed,
        cycle: report.cycle,
        done,
        started,
        path: None,
        doubtful: None,
        place: report.place,
        next_request: FIRST_REQUEST.max(report.request.map_or(0, |request| request.number)) + 1,
        order: None,
    };
    let paths: Vec<Option<OpId>> =
        if report.recovering_home { paths_through(station, &snapshot.marking) } else { vec![None] };
    let index = station.op_ids().find(|&op| station.index_of(op).is_some());
    let memories = paths.iter().flat_map(|&path| {
        [None, index].map(|doubtful| Restore::From(StationSnapshot { path, doubtful, ..snapshot.clone() }))
    });
    // Switched on away from home: it claims nothing of its axes, as no other stop does.
    let not_at_home = report.incomplete.iter().any(|&(_, cause)| cause == StopCause::NotAtHome);
    let fresh = not_at_home.then_some(Restore::Fresh);
    let (mut fitting, mut any) = (None, None);
    for restore in fresh.into_iter().chain(memories) {
        let is_fresh = restore == Restore::Fresh;
        let Ok(controller) = Controller::new(line, id, report.boot_id, restore) else { continue };
        let mut unit = PlayedStation::new(controller.with_rules(RULES));
        unit.take(whole_image(bits));
        unit.take(StationInput::Panel(PanelCommand::Selector(report.selector_manual)));
        let of = &unit.report;
        let is_same = of.position_lost.is_some() == report.position_lost.is_some() || !report.devices_valid;
        let stands = snapshot.marking.iter().all(|place| of.places[place.op.index()] == place.number());
        if is_same && stands && of.done == snapshot.done {
            fitting = fitting.or(Some(unit));
        } else if !is_fresh {
            any = any.or(Some(unit));
        }
    }
    fitting.or(any).ok_or(RestoreMisfit(id))
}

/// Whether a station was started without its memory away from home, and no person has confirmed since where it stands. Of a cycle
/// the counts show it, which are founded at home; of tasks the cause alone.
pub(crate) fn is_unknown(station: &Station, report: &StationReport) -> bool {
    match station.is_task_driven() {
        true => report.incomplete.iter().any(|&(_, cause)| cause == StopCause::NotAtHome),
        false => report.generation == 0 && !report.incomplete.is_empty(),
    }
}

/// The marked places of a report.
fn places(station: &Station, report: &StationReport) -> Option<Vec<StationPlace>> {
    let count = station.operations.len();
    if report.places.len() != count || report.done.len() != count || report.started.len() != count {
        return None;
    }
    let marked = report.places.iter().enumerate().filter(|&(_, &number)| number != 0);
    let all: Option<Vec<StationPlace>> =
        marked.map(|(op, &number)| StationPlace::from_number(OpId::at(op), number)).collect();
    all.filter(|all| !all.is_empty())
}

/// The image of a station that stands where its chart has it.
fn expected(station: &Station, marked: &[StationPlace]) -> u128 {
    marked.iter().fold(0, |bits, &place| bits | image::at_rest(station, place))
}

/// The irreversible operations whose recovery path leads through these places.
fn paths_through(station: &Station, marked: &[StationPlace]) -> Vec<Option<OpId>> {
    let leads = |op: &OpId| match &station.operations[op.index()].module {
        OperationModule::Irreversible { recovery_path } => {
            let is_on = |place: &StationPlace| place.op == station.home || recovery_path.contains(&place.op);
            !recovery_path.is_empty() && marked.iter().all(is_on)
        }
        OperationModule::Reversible { .. } => false,
    };
    station.op_ids().filter(leads).map(Some).collect()
}
