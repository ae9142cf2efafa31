//! Checks as statuses, and the groups that they fall into.

use linewright_line::Line;
use linewright_msgs::{DiagnosticStatus, RosMessage, TEXT_BYTES_MAX};
use linewright_node_line::{aggregator_file, diagnostic_groups, status_message};
use linewright_station_shell::{HealthCheck, HealthLevel, STATION_CHECKS};
use linewright_testkit::built::transfer_line;

const OF_COORDINATOR: [&str; 2] = ["mode", "stations"];

#[test]
fn a_check_becomes_a_status_that_readers_take() {
    let check = HealthCheck::new("operation", HealthLevel::Warn, "x".repeat(TEXT_BYTES_MAX + 1)).with("mode", "auto");
    let status = status_message("mill_1", "transfer_line/mill_1", check);
    assert_eq!((status.level, status.name.as_str()), (DiagnosticStatus::WARN, "mill_1: operation"));
    assert_eq!(status.hardware_id, "transfer_line/mill_1");
    assert_eq!((status.values[0].key.as_str(), status.values[0].value.as_str()), ("mode", "auto"));
    assert!(status.validate().is_ok() && status.message.ends_with('…'), "a text that is too long would be dropped");
}

/// Names as nodes publish them: the node, and what is checked.
fn published(line: &Line) -> Vec<String> {
    let stations =
        line.stations.iter().flat_map(|station| STATION_CHECKS.map(|check| format!("{}: {check}", station.name)));
    let devices = line.devices.iter().map(|device| format!("coordinator: {}", device.name));
    OF_COORDINATOR.iter().map(|check| format!("coordinator: {check}")).chain(stations).chain(devices).collect()
}

#[test]
fn each_published_name_is_in_one_group_and_no_other_is_expected() {
    let line = transfer_line();
    let groups = diagnostic_groups(&line, &OF_COORDINATOR);
    let mut expected: Vec<&str> = groups.iter().flat_map(|group| &group.expected).map(String::as_str).collect();
    let published = published(&line);
    let mut names: Vec<&str> = published.iter().map(String::as_str).collect();
    expected.sort_unstable();
    names.sort_unstable();
    assert_eq!(expected, names);
    let named: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(named, ["coordinator", "transfer", "clamp_1", "mill_1"]);
}

#[test]
fn the_file_is_what_the_aggregator_of_ros_reads() {
    let mut line = transfer_line();
    line.devices[0].name = "it's".to_owned();
    let text = aggregator_file(&line, &OF_COORDINATOR);
    let begin = "\
analyzers:
  ros__parameters:
    path: transfer_line
    pub_rate: 1.0
    coordinator:
      type: diagnostic_aggregator/GenericAnalyzer
      path: coordinator
      timeout: 5.0
      expected:
        - 'coordinator: mode'
";
    assert!(text.starts_with(begin), "{text}");
    assert!(text.contains("        - 'coordinator: it''s'\n"), "{text}");
}
