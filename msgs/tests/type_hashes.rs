//! Type hashes, compared with those that `rosidl_generator_type_description` of ROS 2 computes from the same files.

use linewright_msgs::INTERFACES;

/// A line of the file is a name and the hash. A message that is changed has another one: take the new hash from the output, and compare one of
/// them with what a ROS 2 workspace writes into `share/linewright_msgs/msg/*.json` when it builds this package.
#[test]
fn hashes_are_those_that_ros_computes() {
    let mut ours: Vec<String> = INTERFACES.iter().map(|of| format!("{} {}", of.name, of.type_hash)).collect();
    ours.sort();
    let theirs: Vec<&str> = include_str!("type_hashes.txt").lines().collect();
    assert_eq!(ours, theirs, "ours:\n{}\n", ours.join("\n"));
}

/// As published with ROS 2 Jazzy.
#[test]
fn the_hash_of_a_published_type_is_the_published_one() {
    let hash = |name: &str| INTERFACES.iter().find(|of| of.name == name).map(|of| of.type_hash);
    let text = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
    assert_eq!(hash("std_msgs/msg/String"), Some(text));
}
