//! Place of a signal: device, node, object and bit that carry it. The one place where this is put into words, for the
//! search for the switch.

use std::time::Duration;

use crate::{DeviceKind, Drive, DriveMode, InputId, Io, Line, Owner};

impl Line {
    /// An input of a station or of the console, with where it is: `LS_closed (clamp 1 io, node 21h, 6000h:01 bit 1)`.
    /// The name alone where no device carries it, as in a line without devices.
    pub fn input_text(&self, owner: Owner, input: InputId) -> String {
        let names = match owner {
            Owner::Station(id) => &self.station(id).inputs,
            Owner::Console => &self.console.inputs,
        };
        let name = names.get(input.index()).map_or("an input", String::as_str);
        match self.input_place(owner, input) {
            Some(place) => format!("{name} ({place})"),
            None => name.to_owned(),
        }
    }

    /// The station's name, or `console`.
    pub fn owner_name(&self, owner: Owner) -> &str {
        match owner {
            Owner::Station(id) => &self.station(id).name,
            Owner::Console => "console",
        }
    }

    /// Device, node id, object and bit of an input.
    fn input_place(&self, owner: Owner, input: InputId) -> Option<String> {
        self.devices.iter().filter(|device| device.owner == owner).find_map(|device| {
            let (node, object) = match &device.kind {
                DeviceKind::Io(canopen, io) => (canopen.node_id, io_object(io, input)?),
                DeviceKind::Drive(canopen, drive) => (canopen.node_id, drive_object(drive, input)?.to_owned()),
                DeviceKind::Frames(frames) => {
                    return frames.source(input).map(|source| format!("{}, {source}", device.name));
                }
                DeviceKind::Modbus(modbus) => {
                    return modbus.source(input).map(|source| format!("{}, {source}", device.name));
                }
            };
            Some(format!("{}, node {node:02X}h, {object}", device.name))
        })
    }
}

/// The object of an I/O device (CiA 401) that an input is made of: eight digital inputs in each subindex.
fn io_object(io: &Io, input: InputId) -> Option<String> {
    match io.inputs.iter().position(|carried| *carried == Some(input)) {
        Some(bit) => Some(format!("6000h:{:02X} bit {}", bit / 8 + 1, bit % 8)),
        None => io.analogue.source(input),
    }
}

/// The object of a drive (CiA 402) that an input is made of.
fn drive_object(drive: &Drive, input: InputId) -> Option<&'static str> {
    let is_number = drive.index.as_ref().is_some_and(|index| index.place.contains(&input));
    if is_number || drive.targets.iter().any(|target| target.at == input) {
        return Some(match drive.mode {
            DriveMode::Position => "position 6064h",
            DriveMode::Velocity => "velocity 606Ch",
        });
    }
    if drive.fault == Some(input) {
        return Some("statusword 6041h bit 3");
    }
    (drive.homing.and_then(|homing| homing.done) == Some(input)).then_some("statusword 6041h bit 12")
}

/// A time in words: `1 s`, `1.5 s`, `250 ms`.
pub fn duration_text(span: Duration) -> String {
    if span < Duration::from_secs(1) {
        format!("{} ms", span.as_millis())
    } else {
        format!("{} s", span.as_millis() as f64 / 1000.0)
    }
}
