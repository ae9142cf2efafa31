//! The description as an observer needs it: which name is which bit of which frame.
//!
//! Read from the text with a plain TOML reader, not with the project's own parser: if that one mixed up bits, the
//! controllers and their observer must not be wrong in the same way.

use toml_edit::{DocumentMut, Table};

/// A CAN device.
#[derive(Clone, Debug)]
pub struct Device {
    pub node: u8,
    /// Its station; the console has none.
    pub station: Option<String>,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
}

/// An operation: what drives it, and the switch at its end.
#[derive(Clone, Debug)]
pub struct Operation {
    pub station: String,
    pub name: String,
    pub actuator: String,
    pub complete: String,
    /// What drives it back, if it is reversible.
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
        let device = |table: &Table| Device {
            node: u8::try_from(table["node"].as_integer().expect("a node id")).expect("a node id"),
            station: table.get("station").and_then(|s| s.as_str()).map(str::to_owned),
            inputs: names(table, "inputs"),
            outputs: names(table, "outputs"),
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

    /// The device of a station.
    pub fn device(&self, station: &str) -> &Device {
        let found = self.devices.iter().find(|device| device.station.as_deref() == Some(station));
        found.unwrap_or_else(|| panic!("{station} has a device"))
    }

    /// Whether an output moves something (a lamp does not).
    pub fn moves(&self, station: &str, output: &str) -> bool {
        let drives = |o: &Operation| o.actuator == output || o.back.as_deref() == Some(output);
        self.operations.iter().any(|o| o.station == station && drives(o))
    }

    /// The output bit, from 0, that drives an operation.
    pub fn output_bit(&self, station: &str, operation: &str) -> u8 {
        let found = self.operations.iter().find(|o| o.station == station && o.name == operation);
        let actuator = &found.unwrap_or_else(|| panic!("{station} has {operation}")).actuator;
        let bit = self.device(station).outputs.iter().position(|output| output == actuator);
        u8::try_from(bit.expect("a bound output")).expect("few outputs")
    }
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
