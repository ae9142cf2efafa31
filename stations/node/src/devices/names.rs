//! What a device is called in ROS 2, and its network management state in the words of `ros2_canopen`.

use linewright_fieldbus::codec::NmtState;
use linewright_line::{Device, Line};

/// A device's name as a part of a ROS name: `clamp 1 io` becomes `clamp_1_io`. A name that another device, a station
/// or the coordinator has as well gets its node id: `mill_1_41`, in hexadecimal.
pub fn device_names(line: &Line, devices: &[&Device]) -> Vec<String> {
    let plain: Vec<String> = devices.iter().map(|device| plain_name(&device.name)).collect();
    let taken = |name: &String| {
        let others = line.devices.iter().filter(|other| plain_name(&other.name) == *name).count();
        others > 1 || name == "coordinator" || line.stations.iter().any(|station| station.name == *name)
    };
    let names = plain.iter().zip(devices);
    names.map(|(name, d)| if taken(name) { format!("{name}_{:02x}", d.node_id) } else { name.clone() }).collect()
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

/// As `ros2_canopen` writes it. A device that is not heard has no state: `ERROR`, its word for an unknown one.
pub fn state_word(state: Option<NmtState>) -> &'static str {
    match state {
        Some(NmtState::BootUp) => "BOOTUP",
        Some(NmtState::PreOperational) => "PREOP",
        Some(NmtState::Operational) => "START",
        Some(NmtState::Stopped) => "STOP",
        Some(NmtState::Unknown(_)) | None => "ERROR",
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
        let ids: Vec<u8> = line.devices.iter().map(|device| device.node_id).collect();
        let with = |name: &str, at: usize| format!("{name}_{:02x}", ids[at]);
        let expected = [with("console_io", 0), with("clamp_1", 1), with("coordinator", 2), with("console_io", 3)];
        assert_eq!(names(&line)[..4], expected);
    }
}
