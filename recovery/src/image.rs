//! Input images of a station whose motions go as they should: the switches of its axes, and nothing that fails.

use std::time::Duration;

use linewright_line::net::{Block, StationPlace};
use linewright_line::{
    AxisId, Device, Grip, Line, MotionSignals, OpId, OperationModule, Owner, Sensor, Sign, Stand, Station, StationId,
};
use linewright_station_logic::StationReport;

/// Coordinates nearer than this are one place.
const SAME_PLACE: f64 = 1e-6;

/// The signals of a motion, and its time without faults.
pub(crate) fn motion(station: &Station, place: StationPlace) -> (MotionSignals, Duration) {
    let operation = &station.operations[place.op.index()];
    match (place.block, &operation.module) {
        (Block::Recovery, OperationModule::Reversible { recovery, recovery_duration, .. }) => {
            (*recovery, *recovery_duration)
        }
        (Block::Normal | Block::Recovery, _) => (operation.normal, operation.duration),
    }
}

fn goes(station: &Station, op: OpId) -> bool {
    let motion = station.operations[op.index()].motion;
    station.index_of(op).is_some() || (motion.from - motion.to).abs() >= SAME_PLACE
}

/// Whether the switch that ends this motion is on before it starts. An index begins on its switch.
pub(crate) fn is_at_end(station: &Station, image: u128, place: StationPlace) -> bool {
    let moves = goes(station, place.op) && station.index_of(place.op).is_none();
    moves && image & motion(station, place).0.complete.bit() != 0
}

/// Where each motion of an operation's axis ends, with its completion input.
fn ends(station: &Station, of: OpId) -> impl Iterator<Item = (f64, u128)> + '_ {
    let axis = station.operations[of.index()].motion.axis;
    let ops = station.op_ids().filter(move |&op| goes(station, op));
    ops.filter(move |op| station.operations[op.index()].motion.axis == axis).flat_map(move |op| {
        let operation = &station.operations[op.index()];
        let back = match &operation.module {
            OperationModule::Reversible { recovery, .. } => Some((operation.motion.from, recovery.complete.bit())),
            OperationModule::Irreversible { .. } => None,
        };
        std::iter::once((operation.motion.to, operation.normal.complete.bit())).chain(back)
    })
}

/// The switches that measure an axis.
pub(crate) fn switches_of(station: &Station, axis: AxisId) -> u128 {
    let ops = station.operations.iter().filter(|op| op.motion.axis == axis);
    ops.fold(0, |bits, op| {
        let back = match &op.module {
            OperationModule::Reversible { recovery, .. } => recovery.complete.bit(),
            OperationModule::Irreversible { .. } => 0,
        };
        bits | op.normal.complete.bit() | back
    })
}

/// The image while these motions are under way: their axes are at no switch, and no fault signal of theirs is on.
pub(crate) fn under_way(station: &Station, image: u128, places: &[StationPlace]) -> u128 {
    places.iter().fold(image, |image, &place| {
        let (signals, _) = motion(station, place);
        let own = signals.complete.bit() | signals.fault.map_or(0, |fault| fault.bit());
        let all =
            if goes(station, place.op) { ends(station, place.op).fold(0, |bits, (_, end)| bits | end) } else { 0 };
        image & !(own | all)
    })
}

/// The image when they have arrived.
pub(crate) fn arrived(line: &Line, id: StationId, image: u128, places: &[StationPlace]) -> u128 {
    let station = line.station(id);
    places.iter().fold(under_way(station, image, places), |image, &place| {
        let (signals, _) = motion(station, place);
        let way = station.operations[place.op.index()].motion;
        let at = if place.block == Block::Normal { way.to } else { way.from };
        let here = ends(station, place.op).filter(|(end, _)| (end - at).abs() < SAME_PLACE);
        let here = if goes(station, place.op) { here.fold(0, |bits, (_, end)| bits | end) } else { 0 };
        let image = image | signals.complete.bit() | here;
        if station.index_of(place.op).is_some() { at_next_place(line, id, image) } else { image }
    })
}

/// The image when the drive of an index has been homed at a rest: it stands at its first place, where its reference is.
pub(crate) fn homed(line: &Line, id: StationId, image: u128, index: OpId) -> u128 {
    let switch = line.operation((id, index)).normal.complete.bit();
    at_next_place(line, id, image) | switch
}

/// The numbered place that an image has for the axis of an index; none without a drive that numbers them.
pub(crate) fn place(line: &Line, id: StationId, image: u128) -> Option<u16> {
    let mut drives = line.devices_of(Owner::Station(id)).filter_map(Device::drive);
    drives.find_map(|drive| Some(drive.index.as_ref()?.reported(image))).filter(|&place| place != 0)
}

/// A drive that numbers the places of an endless axis says the next one.
fn at_next_place(line: &Line, id: StationId, image: u128) -> u128 {
    let drives = line.devices_of(Owner::Station(id)).filter_map(Device::drive);
    drives.filter_map(|drive| drive.index.as_ref()).fold(image, |image, index| {
        let next = match index.reported(image) {
            // A drive that is being homed stands at its first place then.
            0 => 1,
            place => index.next(place),
        };
        (image & !index.report(u16::MAX)) | index.report(next)
    })
}

/// The image with an axis back on a switch, and on no other.
pub(crate) fn put_onto(station: &Station, image: u128, switch: u128) -> u128 {
    let ops = station.op_ids().filter(|&op| goes(station, op));
    let same = ops.filter(|&op| ends(station, op).any(|(_, end)| end == switch));
    same.fold(image, |image, op| image & !ends(station, op).fold(0, |bits, (_, end)| bits | end)) | switch
}

/// The switches of the axes that stand still by the chart while a place is marked, all of them on.
pub(crate) fn at_rest(station: &Station, place: StationPlace) -> u128 {
    station.rest_alternatives(place).into_iter().fold(station.rest_inputs(place), |bits, any| bits | any)
}

/// The report of a task-driven station when it has ended the task under way, as by its order in auto.
pub(crate) fn end_task(station: &Station, report: &mut StationReport) {
    let marked = station.op_ids().find(|op| report.places.get(op.index()).is_some_and(|&number| number != 0));
    let Some(task) = marked.and_then(|op| station.task_of(op)).filter(|_| !report.at_home) else { return };
    let last = StationPlace::completed(station.last_of(task));
    for &op in station.steps[station.task(task).steps.clone()].iter().flatten() {
        (report.done[op.index()], report.started[op.index()]) = (report.cycle, report.cycle);
    }
    report.places.fill(0);
    report.places[last.op.index()] = last.number();
    let ops = station.op_ids().filter(|&op| goes(station, op));
    let switches = ops.fold(0, |bits, op| ends(station, op).fold(bits, |bits, (_, end)| bits | end));
    let (complete, _) = motion(station, last);
    report.measured = (report.measured & !switches) | at_rest(station, last) | complete.complete.bit();
    report.incomplete.clear();
    (report.at_home, report.stopped, report.position_lost) = (true, true, None);
}

/// An input that is on while axes stand at their switches, as far as switches show it: those of other stations, or of its own, as that of
/// its hand.
pub(crate) struct SeenAxes {
    /// Station of the input.
    pub reader: StationId,
    pub input: u128,
    /// By station: the switches that are on then.
    when: Vec<(StationId, u128)>,
}

impl SeenAxes {
    /// All of a line. A part in a hand is taken to be there while the hand is closed, one in a nest to be there.
    pub fn of_line(line: &Line) -> Vec<Self> {
        let switch = |stand: &Stand| match line.station(stand.station).switches_at(stand.axis, stand.at) {
            0 => None,
            switch => Some((stand.station, switch)),
        };
        let stand = |sign: &Sign| match sign {
            Sign::Stands(stand) => Some(*stand),
            Sign::Part(holder) => match line.handling.holder(*holder).grip {
                Grip::Hand(stand) => Some(stand),
                Grip::Clamp(_) | Grip::Loose => None,
            },
        };
        let seen = |sensor: &Sensor| {
            let stands = sensor.when.iter().filter_map(stand);
            let when: Vec<(StationId, u128)> = stands.map(|stand| switch(&stand)).collect::<Option<_>>()?;
            (!when.is_empty()).then(|| SeenAxes { reader: sensor.station, input: sensor.input.bit(), when })
        };
        line.handling.sensors.iter().filter_map(seen).collect()
    }

    /// Whether its axes stand so.
    pub fn is_on(&self, measured: impl Fn(StationId) -> u128) -> bool {
        self.when.iter().all(|&(station, switch)| measured(station) & switch != 0)
    }
}
