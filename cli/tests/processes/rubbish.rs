//! Whatever is sent on ROS topics and on the bus while the line runs, it keeps to its chart.
//!
//! Malformed (bytes that do not decode: DDS compares type names, not contents), meaningless (unknown modes, stations and
//! commands), too long, and late (a state that was true when the run began). The complete lists of what readers reject are in
//! the tests of `msgs`, `stations/shell` and `canopen`.

use std::marker::PhantomData;
use std::time::{Duration, Instant};

use linewright_msgs::{Invalid, ModeOrder, ProcessImage, RosField, RosMessage, StationEvent, StationState, Text};
use linewright_node_shell::{Participant, Publisher, RosArgs, RosNode, qos};
use ros2_client::QosProfile;
use serde::de::Error as _;
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::support::bus::{Member, frame};
use crate::support::chart::starts_follow_the_chart;
use crate::support::operator::{Operator, STATIONS};
use crate::support::pause;
use crate::support::rig::{Rig, line};

/// Text of this length is still a valid message; one byte more is not.
const TEXT_MAX: usize = 4096;

#[test]
fn rubbish_on_topics_and_on_the_bus_changes_nothing() {
    let mut rig = Rig::new(&line(0.3));
    let operator = rig.in_stand_by();
    let participant = Participant::open(&RosArgs { domain_id: rig.domain(), ..RosArgs::default() }).expect("joins");
    let mut node = participant.node("/transfer_line", "vandal").expect("a node");
    let late = STATIONS.map(|name| operator.station(name));
    let senders = senders(&mut node, &late);
    let member = rig.member();
    operator.order("auto", StationState::MODE_AUTO);
    pause(500);

    let until = Instant::now() + Duration::from_secs(6);
    let mut round = 0;
    while Instant::now() < until {
        senders.iter().for_each(|send| send(round));
        litter(&member, round);
        round += 1;
        pause(100);
    }
    assert!(STATIONS.iter().zip(&late).all(|(name, then)| operator.station(name).boot_id == then.boot_id));
    is_reported(&rig, &operator);
    assert!(operator.heard().in_mode(StationState::MODE_AUTO), "{}", operator.picture());
    operator.cycles(1);
    operator.go_home();
    let ran = usize::try_from(*operator.station("mill_1").done.last().expect("a count")).expect("a number");
    assert!(ran >= 3, "it has kept running: {ran}");
    starts_follow_the_chart(rig.eye.seen().starts(), ran);
    rig.ends_well(0);
}

fn is_reported(rig: &Rig, operator: &Operator) {
    // As long as a message may be: a refusal that repeated it would be longer than a message.
    let refusal = operator.refused(&"x".repeat(TEXT_MAX));
    assert!(refusal.len() < 500 && refusal.contains("unknown command"), "{refusal}");
    let heard = operator.heard();
    assert!(heard.line.refusals > 10, "commands and buttons are refused: {}", heard.line.refusals);
    let ignored = |event: &StationEvent| event.kind == StationEvent::KIND_IGNORED;
    for station in STATIONS {
        assert!(heard.events.iter().any(|event| ignored(event) && event.station == station), "{station} says so");
        assert!(rig.log(station).contains("ignored a message"), "{station}");
    }
    assert!(rig.log("coordinator").contains("ignored a message"));
}

/// Sends one round on a topic.
type Sender = Box<dyn Fn(u32)>;

/// For every kind of topic that is listened to.
fn senders(node: &mut RosNode, late: &[StationState]) -> Vec<Sender> {
    let texts = |_| ["", "auto; hand", "PB_2 PB_99", &"x".repeat(TEXT_MAX + 1)].map(Text::from).to_vec();
    // Newer than anything, but of no mode there is, or of no process.
    let orders = |_| {
        let order = ModeOrder { boot_id: 1, sequence: u64::MAX, epoch: u64::MAX, mode: 200, ..ModeOrder::default() };
        let of_nobody = ModeOrder { boot_id: 0, mode: StationState::MODE_MANUAL, manual_all: true, ..order.clone() };
        vec![order, of_nobody]
    };
    let description = late.first().map_or(0, |state| state.description);
    let image = move |_| {
        let mut image =
            ProcessImage { boot_id: 0, sequence: u64::MAX, description, valid: true, ..ProcessImage::default() };
        image.set_word(u128::MAX);
        vec![image]
    };
    let mut all = vec![bytes::<ModeOrder>(node, "mode", qos::command()), said(node, "mode", qos::command(), orders)];
    for topic in ["mode_cmd", "buttons", "transfer/selector", "clamp_1/selector", "mill_1/selector"] {
        all.push(bytes::<Text>(node, topic, qos::command()));
        all.push(said(node, topic, qos::command(), texts));
    }
    for (station, late) in STATIONS.iter().zip(late.iter().cloned()) {
        let state = format!("{station}/state");
        all.push(bytes::<StationState>(node, &state, qos::latched_state()));
        all.push(said(node, &state, qos::latched_state(), move |round| states(&late, round)));
        for side in ["inputs", "outputs"] {
            all.push(bytes::<ProcessImage>(node, &format!("{station}/{side}"), qos::repeated()));
            all.push(said(node, &format!("{station}/{side}"), qos::repeated(), image));
        }
    }
    all
}

/// Impossible station states with a higher sequence number than any genuine one; and the state that the station published
/// at home, before the first cycle, once more.
fn states(late: &StationState, round: u32) -> Vec<StationState> {
    let newer = StationState { boot_id: 77, sequence: u64::from(round) + 1, ..late.clone() };
    let mut longer = newer.clone();
    longer.done.push(9);
    longer.started.push(9);
    longer.places.push(0);
    let large = vec![0; TEXT_MAX + 1];
    vec![
        longer,
        StationState { station: "mill_9".to_owned(), ..newer.clone() },
        StationState { boot_id: 0, ..newer.clone() },
        StationState { done: large.clone(), started: large, places: vec![0; TEXT_MAX + 1], ..newer },
        late.clone(),
    ]
}

/// Truncated, overlong and false bytes under the true type and quality of service of a topic.
fn bytes<M: RosMessage + 'static>(node: &mut RosNode, topic: &str, qos: QosProfile) -> Sender {
    let publisher: Publisher<Raw<M>> = node.publisher(topic, qos).expect("a topic");
    Box::new(move |_| {
        for bytes in [&[][..], &[1], &[0; 3], &[0; 24], &[0xFF; 64], &[7; 3000]] {
            publisher.send(Raw { bytes: bytes.to_vec(), of: PhantomData });
        }
    })
}

/// Messages of the right form.
fn said<M: RosMessage + 'static>(
    node: &mut RosNode,
    topic: &str,
    qos: QosProfile,
    messages: impl Fn(u32) -> Vec<M> + 'static,
) -> Sender {
    let publisher: Publisher<M> = node.publisher(topic, qos).expect("a topic");
    Box::new(move |round| messages(round).into_iter().for_each(|message| publisher.send(message)))
}

/// Any bytes, sent under the name of `M`.
struct Raw<M> {
    bytes: Vec<u8>,
    of: PhantomData<M>,
}

impl<M> Serialize for Raw<M> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.bytes.len())?;
        for byte in &self.bytes {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

impl<'de, M> Deserialize<'de> for Raw<M> {
    fn deserialize<D: Deserializer<'de>>(_: D) -> Result<Self, D::Error> {
        Err(D::Error::custom("it is only sent"))
    }
}

impl<M> RosField for Raw<M> {
    fn check_bounds(&self, _path: &str) -> Result<(), Invalid> {
        Ok(())
    }
}

impl<M: RosMessage> RosMessage for Raw<M> {
    const PACKAGE: &'static str = M::PACKAGE;
    const NAME: &'static str = M::NAME;
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

/// Frames and datagrams that no device or manager should act upon.
fn litter(member: &Member, round: u32) {
    const EXTENDED: u32 = 0x8000_0000;
    const REMOTE: u32 = 0x4000_0000;
    const ERROR: u32 = 0x2000_0000;
    // Datagrams that are no frames: too short, too long, a length of more than eight bytes.
    for length in [0, 1, 8, 15, 17, 64] {
        member.send(&vec![0xA5; length]);
    }
    let mut overlong = frame(0x211, &[0xFF; 8]);
    overlong[4] = 200;
    member.send(&overlong);
    // Frames that would be outputs, inputs, an emergency stop or a command to stop, were the identifier not extended,
    // or the frame not a request or a kernel's report.
    for flags in [EXTENDED, REMOTE, ERROR, EXTENDED | REMOTE] {
        for identifier in [0x000, 0x201, 0x211, 0x221, 0x222, 0x223, 0x181, 0x191, 0x1A1, 0x1A2, 0x1A4, 0x721] {
            member.send(&frame(flags | identifier, &[0xFF, 0xFF, 0xFF]));
        }
    }
    // Unused identifiers and nodes; wrong lengths.
    for identifier in [0x100, 0x280 + 0x11, 0x380 + 0x21, 0x480 + 0x22, 0x1D5, 0x255, 0x755, 0x0D5, 0x5D5, 0x7E5] {
        member.send(&frame(identifier, &[5]));
    }
    for node in [0x01, 0x11, 0x21, 0x22, 0x24] {
        member.send(&frame(0x180 + node, &[]));
        member.send(&frame(0x200 + node, &[]));
        member.send(&frame(0x700 + node, &[5, 5, 5]));
        member.send(&frame(0x580 + node, &[0x60, 0x00, 0x10]));
        member.send(&frame(0x600 + node, &[0x2F, 0x00]));
        member.send(&frame(0x600 + node, &[0x40, 0x34, 0x12, round as u8, 0, 0, 0, 0]));
    }
    member.send(&frame(0x000, &[1]));
    member.send(&frame(0x000, &[0x77, 0x00]));
}
