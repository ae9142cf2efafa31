//! Devices of a node in ROS 2: their names, numbers of their objects, and what is said of their faults.

use linewright_fieldbus_seam::{
    Answer, BusRequest, BusTarget, Diagnosis, Fieldbus, InputImage, Joined, LastOrders, NextNews,
};
use linewright_line::{Device, Line, Owner, StationId};
use linewright_node_line::devices::numbers::{bytes_of, low_bytes, number};
use linewright_node_line::devices::{TROUBLE_BYTES_MAX, device_names, in_words, since_start};
use linewright_testkit::built::transfer_line;

const OWNER: Owner = Owner::Station(StationId(0));

/// A bus with these faults, and nothing else.
struct Faulty(Vec<String>);

impl Fieldbus for Faulty {
    fn describe(&self) -> String {
        "a bus".to_owned()
    }
    fn next(&mut self) -> NextNews<'_> {
        Box::pin(std::future::pending())
    }
    fn inputs(&self, _: Owner) -> Option<InputImage> {
        None
    }
    fn set_outputs(&mut self, _: Owner, _: u128) {}
    fn release_outputs(&mut self) {}
    fn last_orders(&self) -> LastOrders {
        Box::new(|| {})
    }
    fn trouble(&self, _: Owner) -> Vec<String> {
        self.0.clone()
    }
    fn diagnoses(&self) -> Vec<Diagnosis> {
        Vec::new()
    }
    fn states(&self, _: &mut dyn FnMut(&str, &'static str)) {}
    fn ask(&mut self, _: &BusTarget, _: BusRequest) -> Option<u64> {
        None
    }
    fn take_answers(&mut self) -> Vec<(u64, Answer)> {
        Vec::new()
    }
}

fn trouble(sentences: Vec<String>) -> Joined {
    Joined::new(vec![Box::new(Faulty(sentences))], [OWNER])
}

fn names(line: &Line) -> Vec<String> {
    device_names(line, &line.devices.iter().collect::<Vec<_>>())
}

#[test]
fn names_are_what_ros_allows_and_nobody_elses() {
    for (name, expected) in [
        ("clamp 1 io", "clamp_1_io"),
        ("Mill/1  (slides)", "mill_1_slides"),
        ("2nd", "device_2nd"),
        ("_a_", "a"),
        ("Ä", "device"),
    ] {
        let mut line = transfer_line();
        name.clone_into(&mut line.devices[2].name);
        assert_eq!(names(&line)[2], expected);
        linewright_node_shell::names::expand(&names(&line)[2], "/line", "n").expect("allowed");
    }
    let mut line = transfer_line();
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
    let mut line = transfer_line();
    for (at, (name, node_id)) in [("Io", 4), ("io", 4), ("a b", 5), ("a-b", 6), ("a b 05", 7)].into_iter().enumerate() {
        let device = &mut line.devices[at];
        name.clone_into(&mut device.name);
        device.canopen_mut().expect("CANopen").node_id = node_id;
        device.owner = Owner::Station(StationId(at as u16 % 3));
    }
    let names = names(&line);
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

#[test]
fn numbers_are_as_long_as_their_type() {
    assert_eq!(number(&[0x34, 0x12]), Some(0x1234));
    assert_eq!(number(&[]), Some(0));
    assert_eq!(number(&[0; 5]), None);
    assert_eq!((bytes_of(2), bytes_of(6), bytes_of(7), bytes_of(8)), (Some(1), Some(2), Some(4), None));
    // −1 as one byte, whether its sign was extended or not; 300 stays too large for one.
    assert_eq!(low_bytes(u32::MAX, Some(1)), 0xFF);
    assert_eq!(low_bytes(0xFF, Some(1)), 0xFF);
    assert_eq!(low_bytes(0xFFFF_8000, Some(2)), 0x8000);
    assert_eq!(low_bytes(0xFFFF_0000, Some(2)), 0xFFFF_0000, "not a negative number of two bytes");
    assert_eq!(low_bytes(300, Some(1)), 300);
    assert_eq!(low_bytes(u32::MAX, Some(4)), u32::MAX);
}

#[test]
fn what_was_not_received_since_the_start_is_told_from_a_loss() {
    let never = || "io: never heard".to_owned();
    assert_eq!(since_start("coordinator", false, never()), "coordinator was started, since then io: never heard");
    assert_eq!(since_start("coordinator", true, never()), "io: never heard");
    assert_eq!(since_start("coordinator", false, String::new()), "");
    assert_eq!(since_start("coordinator", false, "x".repeat(TROUBLE_BYTES_MAX)).len(), TROUBLE_BYTES_MAX);
}

#[test]
fn devices_that_were_never_heard_are_one_sentence() {
    let never =
        |name: &str, id: &str| format!("{name} (node {id}h): never heard: no boot-up and no heartbeat (7{id}h, 1017h)");
    let silent = "valves (node 07h): silent for 90 ms".to_owned();
    let all = in_words(&trouble(vec![never("io", "04"), silent.clone(), never("drive", "05")]), OWNER);
    assert_eq!(all, "never heard: io (node 04h), drive (node 05h); valves (node 07h): silent for 90 ms");
    let one = never("io", "04");
    assert_eq!(in_words(&trouble(vec![one.clone(), silent.clone()]), OWNER), format!("{one}; {silent}"));
}

#[test]
fn of_many_devices_the_first_are_named_and_the_rest_counted() {
    let of = |number: usize| {
        in_words(&trouble((0..number).map(|at| format!("device {at:03} is not heard")).collect()), OWNER)
    };
    assert_eq!(of(0), "");
    assert_eq!(of(2), "device 000 is not heard; device 001 is not heard");
    let many = of(200);
    assert!(many.len() <= TROUBLE_BYTES_MAX && many.ends_with(" more"), "{many}");
    let named = many.matches("device ").count();
    assert!(many.ends_with(&format!("; and {} more", 200 - named)), "{many}");
    let long = in_words(&trouble(vec!["x".repeat(9000), "y".to_owned()]), OWNER);
    assert!(long.len() <= TROUBLE_BYTES_MAX && long.ends_with('…'), "{long}");
}
