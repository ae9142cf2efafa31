//! Axes that a person has to bring onto a switch by hand: no motion leads there, or none may begin.

use linewright_line::{AxisId, InputId, Line, OpId, OperationModule, Station, StationId};
use linewright_station_logic::{RejoinAt, StationInput, StationReport, StopCause};

use crate::image;
use crate::restore::{is_unknown, unit};
use crate::step::Need;

/// A switch of an axis, and the operation that ends or begins there.
struct AxisSwitch {
    op: OpId,
    input: InputId,
    at: f64,
}

/// The axis of a station that was started without its memory, and whose switches fit no operation, that is brought onto a switch
/// by hand. One between switches goes before one that stands at a switch away from home. A place at which no other station is
/// in its way goes first, then one after which an operation fits, then home.
pub(crate) fn unplaced(line: &Line, id: StationId, reports: &[StationReport]) -> Option<(OpId, InputId)> {
    let (station, report) = (line.station(id), &reports[id.index()]);
    if !is_unknown(station, report) || !report.devices_valid || is_confirmable(line, id, report, report.measured) {
        return None;
    }
    let is_on = |switch: &AxisSwitch| report.measured & switch.input.bit() != 0;
    let axis = |switch: &AxisSwitch| station.operations[switch.op.index()].motion.axis;
    let home = |switch: &AxisSwitch| station.axes[axis(switch).index()].home == switch.at;
    let all = || station.op_ids().filter(|&op| station.index_of(op).is_none()).flat_map(|op| switches(station, op));
    let stands = |axis_id: AxisId| all().any(|switch| axis(&switch) == axis_id && is_on(&switch));
    let at_home = |axis_id: AxisId| all().any(|switch| axis(&switch) == axis_id && is_on(&switch) && home(&switch));
    let mut places: Vec<AxisSwitch> = all().filter(|switch| !stands(axis(switch))).collect();
    let claims_nothing = report.incomplete.iter().any(|&(_, cause)| cause == StopCause::NotAtHome);
    if places.is_empty() && claims_nothing {
        places = all().filter(|switch| home(switch) && !at_home(axis(switch))).collect();
    }
    places.sort_by_cached_key(|switch| {
        let image = image::put_onto(station, report.measured, switch.input.bit());
        let passing = passed(station, report.measured, switch.input);
        let meets = |images: &[u128]| !in_the_way(line, (id, images), reports).is_empty();
        // Where it may meet one at the end is worse than on the way: it stays there.
        (meets(&[image]), meets(&[passing]), !is_confirmable(line, id, report, image), !home(switch))
    });
    places.first().map(|switch| (switch.op, switch.input))
}

/// The step in which an axis is brought onto a switch, with the conflicts in which another station may be in its way there or on the way.
pub(crate) fn need(line: &Line, (station, op, input): (StationId, OpId, InputId), reports: &[StationReport]) -> Need {
    let (described, measured) = (line.station(station), reports[station.index()].measured);
    let images = [image::put_onto(described, measured, input.bit()), passed(described, measured, input)];
    Need::Axis { station, op, input, conflicts: in_the_way(line, (station, &images), reports) }
}

/// The image on the way onto a switch: its axis is at none. A state that the axis is in anywhere between its switches is not excluded then.
fn passed(station: &Station, measured: u128, switch: InputId) -> u128 {
    image::put_onto(station, measured, switch.bit()) & !switch.bit()
}

/// The conflicts of a station that no measurement excludes in one of these images of its own: neither it nor the other one is
/// measured outside its state.
fn in_the_way(line: &Line, (id, images): (StationId, &[u128]), reports: &[StationReport]) -> Vec<usize> {
    let is_clear = |span: &linewright_line::StateSpan| {
        let report = &reports[span.station.index()];
        let clear = |measured: u128| line.clearance(span).is_ok_and(|inputs| inputs.hold(measured));
        report.devices_valid
            && if span.station == id { images.iter().all(|&image| clear(image)) } else { clear(report.measured) }
    };
    let of = line.conflicts.iter().enumerate().filter(|(_, of)| of.a.station == id || of.b.station == id);
    of.filter(|(_, of)| !is_clear(&of.a) && !is_clear(&of.b)).map(|(conflict, _)| conflict).collect()
}

/// The switches of an operation.
fn switches(station: &Station, op: OpId) -> impl Iterator<Item = AxisSwitch> + use<> {
    let operation = &station.operations[op.index()];
    let back = match &operation.module {
        OperationModule::Reversible { recovery, .. } => {
            Some(AxisSwitch { op, input: recovery.complete, at: operation.motion.from })
        }
        OperationModule::Irreversible { .. } => None,
    };
    std::iter::once(AxisSwitch { op, input: operation.normal.complete, at: operation.motion.to }).chain(back)
}

/// Whether a person can confirm where the station stands with this image.
fn is_confirmable(line: &Line, id: StationId, report: &StationReport, measured: u128) -> bool {
    let Ok(unit) = unit(line, id, &StationReport { measured, ..report.clone() }) else { return false };
    let within = line.station(id).op_ids().map(RejoinAt::Within);
    let is_taken = |at| unit.clone().take(StationInput::Rejoin(at, &unit.any_numbers(at))).0.is_taken();
    std::iter::once(RejoinAt::Measured).chain(within).any(is_taken)
}
