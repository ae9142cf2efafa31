//! More participants on the loopback address than the DDS library probes for.

use linewright_msgs::Text;
use linewright_node_shell::{Participant, RosArgs, qos};
use std::time::Duration;
use tokio::time::timeout;

/// The library probes twelve; the last three of these are beyond.
const PARTICIPANTS: usize = 15;

#[tokio::test]
async fn the_last_participants_find_each_other() {
    // Domains 28 to 32, away from those of the other tests.
    let args = RosArgs { domain_id: 28 + (std::process::id() % 5) as u16, ..RosArgs::default() };
    let mut nodes = Vec::new();
    for number in 0..PARTICIPANTS {
        let participant = Participant::open(&args).expect("participant");
        let mut node = participant.node("/crowd", &format!("n{number}")).expect("node");
        let publisher = node.publisher::<Text>(&format!("t{number}"), qos::latched_state()).expect("publisher");
        publisher.send(Text { data: number.to_string() });
        nodes.push((participant.number(), node, publisher));
    }
    let numbers: Vec<u16> = nodes.iter().map(|(number, ..)| *number).collect();
    assert!(numbers.iter().filter(|number| **number >= 12).count() >= 3, "{numbers:?}");
    assert!(!numbers.contains(&11), "the relay has this place: {numbers:?}");
    for (reader, writer) in [(PARTICIPANTS - 1, PARTICIPANTS - 2), (PARTICIPANTS - 3, PARTICIPANTS - 1)] {
        let (_, node, _) = &mut nodes[reader];
        let mut texts = node.subscription::<Text>(&format!("t{writer}"), qos::latched_state()).expect("subscription");
        let (text, _) = timeout(Duration::from_secs(25), texts.recv()).await.expect("in time").expect("received");
        assert_eq!(text.data, writer.to_string());
    }
}
