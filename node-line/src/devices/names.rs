//! Names of a device in ROS 2.

use linewright_line::{Device, Line, Owner};

/// A device's name as a part of a ROS name: `clamp 1 io` becomes `clamp_1_io`. A name that another device, a station or
/// the coordinator has as well gets its node id: `mill_1_41`, in hexadecimal. Where that is another's too, since a node
/// id is one device's on its own bus only, it gets its station as well: `io_04_mill_1`.
pub fn device_names(line: &Line, devices: &[&Device]) -> Vec<String> {
    let mut names: Vec<(usize, String)> = line.devices.iter().map(|device| (0, form(line, device, 0))).collect();
    loop {
        let taken = |name: &String| {
            let same = names.iter().filter(|(_, other)| other == name).count();
            same > 1 || name == "coordinator" || line.stations.iter().any(|station| station.name == *name)
        };
        let met = |(_, (form, name)): &(usize, &(usize, String))| *form < 2 && taken(name);
        let met: Vec<usize> = names.iter().enumerate().filter(met).map(|(at, _)| at).collect();
        if met.is_empty() {
            break;
        }
        for at in met {
            let next = names[at].0 + 1;
            names[at] = (next, form(line, &line.devices[at], next));
        }
    }
    let of = |device: &&Device| {
        let known = line.devices.iter().position(|other| other.name == device.name);
        known.map_or_else(|| form(line, device, 2), |at| names[at].1.clone())
    };
    devices.iter().map(of).collect()
}

/// A device's name, the shortest first; the longest is the third.
fn form(line: &Line, device: &Device, form: usize) -> String {
    let name = plain_name(&device.name);
    let owner = match device.owner {
        Owner::Station(id) => &line.station(id).name,
        Owner::Console => "console",
    };
    let number = device.node_id().map_or(String::new(), |node| format!("_{node:02x}"));
    match form {
        0 => name,
        1 => format!("{name}{number}"),
        _ => format!("{name}{number}_{}", plain_name(owner)),
    }
}

/// Letters, digits and single underscores; no digit first.
fn plain_name(name: &str) -> String {
    let mut plain = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => plain.push(c.to_ascii_lowercase()),
            _ if plain.ends_with('_') || plain.is_empty() => {}
            _ => plain.push('_'),
        }
    }
    let plain = plain.trim_end_matches('_');
    if plain.starts_with(|c: char| c.is_ascii_digit()) || plain.is_empty() {
        format!("device_{plain}").trim_end_matches('_').to_owned()
    } else {
        plain.to_owned()
    }
}
