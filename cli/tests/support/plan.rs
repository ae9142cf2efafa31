//! The description as an observer needs it: which name is which bit of which frame.
//!
//! Read from the text with a plain TOML reader, not with the project's own parser: if that one mixed up bits, the
//! controllers and their observer must not be wrong in the same way.

use toml_edit::{DocumentMut, InlineTable, Item, Table};

/// A CAN device.
#[derive(Clone, Debug)]
pub struct Device {
    /// 0 for one without CANopen.
    pub node: u8,
    /// Its station; the console has none.
    pub station: Option<String>,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    /// A drive has no bits on the bus: bit n of both is its target n here.
    pub drive: Option<Drive>,
}

/// Positions of a drive's targets, in its increments.
#[derive(Clone, Debug)]
pub struct Drive {
    pub places: Vec<i32>,
    pub window: i32,
}

/// An operation: what drives it, and the switch at its end.
#[derive(Clone, Debug)]
pub struct Operation {
    pub station: String,
    pub name: String,
    pub actuator: String,
    pub complete: String,
    /// Output that drives it back, if it is reversible.
    pub back: Option<String>,
}

/// The line.
#[derive(Clone, Debug)]
pub struct Plan {
    pub devices: Vec<Device>,
    pub operations: Vec<Operation>,
}

impl Plan {
    /// Reads a description.
    pub fn of(text: &str) -> Self {
        let document: DocumentMut = text.parse().expect("a description is TOML");
        let tables = |key: &str| document[key].as_array_of_tables().expect("an array of tables").iter();
        let device = |table: &Table| {
            let (inputs, outputs, drive) = match table.get("drive").and_then(|drive| drive.as_table()) {
                Some(drive) => of_drive(drive),
                None => (names(table, "inputs"), names(table, "outputs"), None),
            };
            Device {
                node: u8::try_from(table.get("node").map_or(Some(0), Item::as_integer).expect("a number"))
                    .expect("a node id"),
                station: table.get("station").and_then(|s| s.as_str()).map(str::to_owned),
                inputs,
                outputs,
                drive,
            }
        };
        let mut operations = Vec::new();
        for station in tables("station") {
            let listed = station["operation"].as_array_of_tables().expect("operations");
            operations.extend(listed.iter().map(|operation| Operation {
                station: word(station, "name"),
                name: word(operation, "name"),
                actuator: inner(operation, "normal", "actuator").expect("an actuator"),
                complete: inner(operation, "normal", "complete").expect("a limit switch"),
                back: inner(operation, "recovery", "actuator"),
            }));
        }
        Plan { devices: tables("device").map(device).collect(), operations }
    }

    /// The device of a station that has this output, and which one it is there.
    pub fn with_output(&self, station: &str, output: &str) -> (&Device, usize) {
        self.found(station, output, |device| &device.outputs)
    }

    /// The device of a station that has this input, and which one it is there.
    pub fn with_input(&self, station: &str, input: &str) -> (&Device, usize) {
        self.found(station, input, |device| &device.inputs)
    }

    fn found(&self, station: &str, name: &str, of: impl Fn(&Device) -> &Vec<String>) -> (&Device, usize) {
        let own = self.devices.iter().filter(|device| device.station.as_deref() == Some(station));
        let mut found = own.filter_map(|device| Some((device, of(device).iter().position(|other| other == name)?)));
        found.next().unwrap_or_else(|| panic!("{station} has {name}"))
    }

    /// Whether an output moves something (a lamp does not).
    pub fn moves(&self, station: &str, output: &str) -> bool {
        let drives = |o: &Operation| o.actuator == output || o.back.as_deref() == Some(output);
        self.operations.iter().any(|o| o.station == station && drives(o))
    }

    /// Node id, and subindex of the fault object, of what drives an operation: one for each output bit, or the axis.
    pub fn fault_object(&self, station: &str, operation: &str) -> (u8, u8) {
        let found = self.operations.iter().find(|o| o.station == station && o.name == operation);
        let actuator = &found.unwrap_or_else(|| panic!("{station} has {operation}")).actuator;
        let (device, bit) = self.with_output(station, actuator);
        let sub = if device.drive.is_some() { 1 } else { u8::try_from(bit + 1).expect("few outputs") };
        (device.node, sub)
    }
}

/// Its targets as inputs and outputs, and their places.
fn of_drive(drive: &Table) -> (Vec<String>, Vec<String>, Option<Drive>) {
    let number = |item: &Item| item.as_float().or(item.as_integer().map(|n| n as f64)).expect("a number");
    let units = number(&drive["units_per_mm"]);
    let targets: Vec<&InlineTable> =
        drive["targets"].as_array().expect("targets").iter().flat_map(|t| t.as_inline_table()).collect();
    let named = |key: &str| targets.iter().map(|t| t[key].as_str().expect("a name").to_owned()).collect();
    let place = |t: &&InlineTable| (number(&Item::Value(t["to"].clone())) * units).round() as i32;
    let places = targets.iter().map(place).collect();
    let window = (number(&drive["window"]) * units).round() as i32;
    (named("at"), named("output"), Some(Drive { places, window }))
}

fn word(table: &Table, key: &str) -> String {
    table[key].as_str().expect("a text").to_owned()
}

fn inner(table: &Table, key: &str, field: &str) -> Option<String> {
    table.get(key)?.as_inline_table()?.get(field)?.as_str().map(str::to_owned)
}

fn names(table: &Table, key: &str) -> Vec<String> {
    let listed = table.get(key).and_then(|list| list.as_array());
    listed.map(|l| l.iter().map(|name| name.as_str().expect("a name").to_owned()).collect()).unwrap_or_default()
}
