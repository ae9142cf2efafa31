//! An observer of the CAN frames: has a conflict ever been reached?
//!
//! It reads the devices' inputs from the bus and nothing else — no state, no mode, no count — so it can see what the
//! controllers got wrong. A conflict's stretch of a station's cycle begins when the mechanism leaves where the
//! stretch's first operation starts and ends when it is where the last one ends; in between, neither of those two
//! switches is on. That is all it looks at.

use linewright_canopen::codec::Payload;
use linewright_canopen::profile::drive::DriveBinding;
use linewright_canopen::{CanopenMessage, Frame};
use linewright_line::{Conflict, Device, DeviceBus, InputId, Line, OperationModule, Owner, StateSpan, StationId};

/// The inputs of one station, as its devices last sent them.
#[derive(Clone, Debug)]
struct SeenStationInputs {
    bits: u128,
    /// For each of its devices, whether its process data were received.
    heard: Vec<bool>,
    /// For each of its devices that is a drive, the binding of its process data.
    drives: Vec<Option<DriveBinding>>,
}

impl SeenStationInputs {
    fn of(line: &Line, id: StationId) -> Self {
        let devices = || line.devices_of(Owner::Station(id));
        let drives = devices().map(|device| device.drive().map(DriveBinding::of)).collect();
        // A device without inputs in its first process data need not be received.
        let heard =
            devices().map(|device| device.input_bits().iter().flatten().next().is_none() && device.drive().is_none());
        SeenStationInputs { bits: 0, heard: heard.collect(), drives }
    }

    /// Takes process data of one of its devices. If too short for its inputs they are ignored, whatever their
    /// identifier.
    fn take(&mut self, index: usize, device: &Device, payload: Payload) {
        let said = match &self.drives[index] {
            Some(drive) => drive.places(payload),
            None => (payload.bytes().len() * 8 >= device.input_bits().len()).then(|| bits_of(device, payload)),
        };
        if let Some((known, on)) = said {
            self.heard[index] = true;
            self.bits = self.bits & !known | on;
        }
    }
}

/// The inputs of an I/O device, and those of them that are on.
fn bits_of(device: &Device, payload: Payload) -> (u128, u128) {
    let inputs = device.input_bits().iter().enumerate();
    inputs.filter_map(|(bit, input)| Some((bit, input.as_ref()?))).fold((0, 0), |(known, on), (bit, input)| {
        let one = 1 << input.0;
        (known | one, if payload.bits() & (1 << bit) == 0 { on } else { on | one })
    })
}

/// Whether a switch can be read from the first process data of one of the devices: a limit of an analogue channel
/// cannot, nor a signal of a device without CANopen.
fn is_read(line: &Line, station: StationId, input: InputId) -> bool {
    line.devices_of(Owner::Station(station)).any(|device| {
        let drive = device.drive().into_iter().flat_map(|drive| &drive.targets).map(|target| target.at);
        device.input_bits().iter().flatten().copied().chain(drive).any(|read| read == input)
    })
}

/// The switches at which a stretch ends: where it is left, if that has one, and where it is over.
fn switches(line: &Line, span: &StateSpan) -> (Option<InputId>, InputId) {
    let from = match &line.operation((span.station, span.from)).module {
        OperationModule::Reversible { recovery, .. } => Some(recovery.complete),
        OperationModule::Irreversible { .. } => None,
    };
    (from, line.operation((span.station, span.until)).normal.complete)
}

/// The observer of all buses of a line.
#[derive(Clone, Debug)]
pub struct BusObserver {
    line: Line,
    stations: Vec<SeenStationInputs>,
    /// For each conflict, whether it can be seen at all.
    watched: Vec<bool>,
    /// For each conflict, whether both stretches hold now.
    holds: Vec<bool>,
    seen: Vec<String>,
    frames: u64,
}

impl BusObserver {
    /// An observer that has seen nothing.
    pub fn new(line: &Line) -> Self {
        let is_seen = |span: &StateSpan| {
            let (from, until) = switches(line, span);
            // Switches that the ends of a task leave may be left in other tasks too.
            let is_told = !line.station(span.station).is_task_driven() || line.clearance(span).is_ok();
            is_told && from.into_iter().chain([until]).all(|input| is_read(line, span.station, input))
        };
        BusObserver {
            watched: line.conflicts.iter().map(|conflict| is_seen(&conflict.a) && is_seen(&conflict.b)).collect(),
            stations: line.station_ids().map(|id| SeenStationInputs::of(line, id)).collect(),
            holds: vec![false; line.conflicts.len()],
            line: line.clone(),
            seen: Vec::new(),
            frames: 0,
        }
    }

    /// The conflicts it cannot watch.
    pub fn unwatched(&self) -> Vec<String> {
        let blind = self.line.conflicts.iter().zip(&self.watched).filter(|(_, watched)| !**watched);
        blind.map(|(conflict, _)| describe(&self.line, conflict)).collect()
    }

    /// The conflicts reached so far, each time one began.
    pub fn conflicts(&self) -> &[String] {
        &self.seen
    }

    /// Frames looked at.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Takes a frame of `bus`.
    pub fn frame(&mut self, bus: &DeviceBus, frame: &Frame) {
        self.frames += 1;
        let Ok(CanopenMessage::Tpdo1 { node, payload }) = CanopenMessage::decode(frame) else { return };
        for id in self.line.station_ids() {
            let devices = self.line.devices_of(Owner::Station(id)).enumerate();
            for (index, device) in devices.filter(|(_, d)| d.bus == *bus && d.node_id() == Some(node.get())) {
                self.stations[id.index()].take(index, device, payload);
            }
        }
        self.judge();
    }

    fn judge(&mut self) {
        for (index, conflict) in self.line.conflicts.iter().enumerate() {
            let holds = self.watched[index] && self.is_inside(&conflict.a) && self.is_inside(&conflict.b);
            if holds && !self.holds[index] {
                let off = [&conflict.a, &conflict.b].map(|span| self.switches_off(span)).join("; ");
                self.seen.push(format!(
                    "{}; off on the bus: {off} (or such a switch is wrong)",
                    describe(&self.line, conflict)
                ));
            }
            self.holds[index] = holds;
        }
    }

    /// The switches by which the station is outside, by name.
    fn switches_off(&self, span: &StateSpan) -> String {
        let station = self.line.station(span.station);
        let (from, until) = switches(&self.line, span);
        let mut names: Vec<&str> =
            from.into_iter().chain([until]).map(|input| station.inputs[input.index()].as_str()).collect();
        names.dedup();
        format!("{} of {}", names.join(" and "), station.name)
    }

    fn is_inside(&self, span: &StateSpan) -> bool {
        let seen = &self.stations[span.station.index()];
        let on = |input: InputId| seen.bits & (1 << input.0) != 0;
        let (from, until) = switches(&self.line, span);
        seen.heard.iter().all(|&heard| heard) && !on(until) && !from.is_some_and(on)
    }
}

fn describe(line: &Line, conflict: &Conflict) -> String {
    let name = |id: StationId| line.station(id).name.as_str();
    format!("{} against {}: {}", name(conflict.a.station), name(conflict.b.station), conflict.why)
}
