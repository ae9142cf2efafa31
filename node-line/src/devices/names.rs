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

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::TransferLine;

    #[test]
    fn names_are_what_ros_allows_and_nobody_elses() {
        for (name, expected) in [
            ("clamp 1 io", "clamp_1_io"),
            ("Mill/1  (slides)", "mill_1_slides"),
            ("2nd", "device_2nd"),
            ("_a_", "a"),
            ("Ä", "device"),
        ] {
            assert_eq!(plain_name(name), expected);
            linewright_node_shell::names::expand(&plain_name(name), "/line", "n").expect("allowed");
        }
        let mut line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let names = |line: &Line| device_names(line, &line.devices.iter().collect::<Vec<_>>());
        assert!(names(&line).contains(&"clamp_1_io".to_owned()), "{:?}", names(&line));
        line.devices[1].name = "clamp 1".to_owned();
        line.devices[2].name = "Coordinator".to_owned();
        line.devices[3].name = "console-io".to_owned();
        let ids: Vec<u8> = line.devices.iter().filter_map(Device::node_id).collect();
        let with = |name: &str, at: usize| format!("{name}_{:02x}", ids[at]);
        let expected = [with("console_io", 0), with("clamp_1", 1), with("coordinator", 2), with("console_io", 3)];
        assert_eq!(names(&line)[..4], expected);
    }

    #[test]
    fn devices_of_different_buses_with_one_node_id_have_names_of_their_own() {
        let mut line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        for (at, (name, node_id)) in
            [("Io", 4), ("io", 4), ("a b", 5), ("a-b", 6), ("a b 05", 7)].into_iter().enumerate()
        {
            let device = &mut line.devices[at];
            name.clone_into(&mut device.name);
            device.canopen_mut().expect("CANopen").node_id = node_id;
            device.owner = Owner::Station(linewright_line::StationId(at as u16 % 3));
        }
        let names = device_names(&line, &line.devices.iter().collect::<Vec<_>>());
        let station = |at: usize| &line.stations[at].name;
        let expected = [
            format!("io_04_{}", station(0)),
            format!("io_04_{}", station(1)),
            format!("a_b_05_{}", station(2)),
            "a_b_06".to_owned(),
            "a_b_05_07".to_owned(),
        ];
        assert_eq!(names[..5], expected);
        let mut one_each = names.clone();
        one_each.sort();
        one_each.dedup();
        assert_eq!(one_each.len(), names.len(), "{names:?}");
    }
}
