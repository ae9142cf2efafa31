//! An observer of the CAN frames: has a conflict ever been reached?
//!
//! It reads the devices' inputs from the bus and nothing else — no state, no mode, no count — so it can see what the
//! controllers got wrong. A conflict's stretch of a station's cycle begins when the mechanism leaves where the
//! stretch's first operation starts and ends when it is where the last one ends; in between, neither of those two
//! switches is on. That is all it looks at.

use linewright_fieldbus::{Frame, Message};
use linewright_line::{Bus, Conflict, InputId, Line, Module, Owner, Span, StationId};

/// The inputs of one station, as its devices last sent them.
#[derive(Clone, Debug)]
struct Seen {
    bits: u128,
    /// For each of its devices, whether it was heard.
    heard: Vec<bool>,
}

/// The observer of all buses of a line.
#[derive(Clone, Debug)]
pub struct Observer {
    line: Line,
    stations: Vec<Seen>,
    /// For each conflict, whether both stretches hold now.
    holds: Vec<bool>,
    seen: Vec<String>,
    frames: u64,
}

impl Observer {
    /// An observer that has seen nothing.
    pub fn new(line: &Line) -> Self {
        let seen = |id| Seen { bits: 0, heard: vec![false; line.devices_of(Owner::Station(id)).count()] };
        Observer {
            stations: line.station_ids().map(seen).collect(),
            holds: vec![false; line.conflicts.len()],
            line: line.clone(),
            seen: Vec::new(),
            frames: 0,
        }
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
    pub fn frame(&mut self, bus: &Bus, frame: &Frame) {
        self.frames += 1;
        let Ok(Message::Tpdo1 { node, payload }) = Message::decode(frame) else { return };
        for id in self.line.station_ids() {
            let devices = self.line.devices_of(Owner::Station(id)).enumerate();
            for (index, device) in devices.filter(|(_, d)| d.bus == *bus && d.node_id == node.get()) {
                // Too short for its inputs: nobody's process data, whatever its identifier says.
                if payload.bytes().len() * 8 < device.inputs.len() {
                    continue;
                }
                let seen = &mut self.stations[id.index()];
                seen.heard[index] = true;
                for (bit, input) in device.inputs.iter().enumerate() {
                    if let Some(input) = input {
                        let on = payload.bits() & (1 << bit) != 0;
                        seen.bits = seen.bits & !(1 << input.0) | u128::from(on) << input.0;
                    }
                }
            }
        }
        self.judge();
    }

    fn judge(&mut self) {
        for (index, conflict) in self.line.conflicts.iter().enumerate() {
            let holds = self.is_inside(&conflict.a) && self.is_inside(&conflict.b);
            if holds && !self.holds[index] {
                self.seen.push(describe(&self.line, conflict));
            }
            self.holds[index] = holds;
        }
    }

    fn is_inside(&self, span: &Span) -> bool {
        let seen = &self.stations[span.station.index()];
        let on = |input: InputId| seen.bits & (1 << input.0) != 0;
        let until = self.line.operation((span.station, span.until)).normal.complete;
        let from = match &self.line.operation((span.station, span.from)).module {
            Module::Reversible { recovery, .. } => Some(recovery.complete),
            Module::Irreversible { .. } => None,
        };
        seen.heard.iter().all(|&heard| heard) && !on(until) && !from.is_some_and(on)
    }
}

fn describe(line: &Line, conflict: &Conflict) -> String {
    let name = |id: StationId| line.station(id).name.as_str();
    format!("{} against {}: {}", name(conflict.a.station), name(conflict.b.station), conflict.why)
}
