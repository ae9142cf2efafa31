//! Two participants on the loopback address of this machine: what one sends arrives in the other, late readers and
//! rubbish included.
//!
//! Each test takes a domain of its own, away from the usual ones.

use linewright_msgs::{Invalid, ProcessImage, RosField, RosMessage, StationState, Text};
use linewright_node_shell::{
    MessagePace, Participant, Range, RosArgs, RosNode, Subscription, forward, forward_present, fresh_boot_id, qos,
    stamp,
};
use serde::{Deserialize, Serialize};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};

const PATIENCE: Duration = Duration::from_secs(20);

/// Domains 33 to 88, different for tests of one process and mostly so for concurrent processes. Above 101 the ports are
/// in the range from which Linux gives ports to any process.
fn args(test: u16) -> RosArgs {
    let domain_id = 33 + (std::process::id() % 8) as u16 * 7 + test;
    RosArgs { domain_id, ..RosArgs::default() }
}

fn node(test: u16, name: &str) -> RosNode {
    let participant = Participant::open(&args(test)).expect("participant");
    participant.node("/line", name).expect("node")
}

async fn next<T: RosMessage>(subscription: &mut Subscription<T>) -> T {
    timeout(PATIENCE, subscription.recv()).await.expect("in time").expect("received").0
}

async fn until_matched(writer: &RosNode, topic: &str) {
    timeout(PATIENCE, async {
        while writer.subscription_count(topic).expect("name") == 0 {
            sleep(Duration::from_millis(5)).await;
        }
        // The writer's side has discovered the reader; the reader discovers the writer at about the same time.
        sleep(Duration::from_millis(200)).await;
    })
    .await
    .expect("matched in time");
}

fn state(sequence: u64) -> StationState {
    let mut state = StationState { header: stamp(), boot_id: fresh_boot_id(), sequence, ..Default::default() };
    state.station = "s1".to_owned();
    state.lifecycle = StationState::LIFECYCLE_ACTIVE;
    state
}

#[tokio::test]
async fn a_latched_state_reaches_a_late_reader() {
    let mut writer = node(0, "writer");
    let publisher = writer.publisher::<StationState>("s1/state", qos::latched_state()).expect("publisher");
    for sequence in 1..=3 {
        publisher.send(state(sequence));
    }
    let mut reader = node(0, "reader");
    let mut states = reader.subscription::<StationState>("/line/s1/state", qos::latched_state()).expect("subscription");
    let mut newest = next(&mut states).await;
    while newest.sequence < 3 {
        newest = next(&mut states).await;
    }
    assert_eq!((publisher.sent(), publisher.failed()), (3, 0));
}

/// The middleware keeps all states as long as some reader has not acknowledged them, or none has come yet, and sends them to
/// whoever joins.
#[tokio::test]
async fn of_states_kept_by_the_middleware_none_is_taken_for_the_present_one() {
    const REFRESH: Duration = Duration::from_millis(50);
    let mut writer = node(7, "writer");
    let publisher = writer.publisher::<StationState>("s1/state", qos::latched_state()).expect("publisher");
    let mut reader = node(7, "reader");
    let (mut sequence, mut joined) = (0, None);
    let (to, mut all) = mpsc::channel(1000);
    let (to_present, mut present) = mpsc::channel(1000);
    let mut tasks = Vec::new();
    while joined.is_none_or(|at| sequence < at + 40) {
        sequence += 1;
        publisher.send(state(sequence));
        sleep(REFRESH).await;
        if sequence == 60 {
            joined = Some(sequence);
            let states = reader.subscription::<StationState>("s1/state", qos::latched_state()).expect("subscription");
            tasks.push(forward(states, to.clone(), |state, _| Some(state.sequence)));
            let states = reader.subscription::<StationState>("s1/state", qos::latched_state()).expect("subscription");
            let pace = MessagePace::new(REFRESH, REFRESH * 5);
            tasks.push(forward_present(states, to_present.clone(), pace, |state, _| Some(state.sequence)));
        }
    }
    let mut heard = || all.try_recv().ok();
    assert!(heard().is_some_and(|first| first < 30), "what was kept is sent");
    assert!(std::iter::from_fn(heard).last() > Some(90));
    let taken: Vec<u64> = std::iter::from_fn(|| present.try_recv().ok()).collect();
    assert!(taken.first().is_some_and(|&first| first > 60), "{taken:?}");
    assert!(taken.last().is_some_and(|&last| last > 90), "{taken:?}");
}

#[tokio::test]
async fn a_command_is_not_repeated_to_a_late_reader() {
    let mut writer = node(1, "writer");
    let publisher = writer.publisher::<Text>("mode_cmd", qos::command()).expect("publisher");
    publisher.send(Text::from("auto"));
    let mut reader = node(1, "reader");
    let mut commands = reader.subscription::<Text>("mode_cmd", qos::command()).expect("subscription");
    until_matched(&writer, "mode_cmd").await;
    publisher.send(Text::from("hand"));
    assert_eq!(next(&mut commands).await.data, "hand");
}

/// Claims to be a process image and is one byte long.
#[derive(Serialize, Deserialize)]
struct Impostor(u8);

impl RosField for Impostor {
    fn check_bounds(&self, _path: &str) -> Result<(), Invalid> {
        Ok(())
    }
}

impl RosMessage for Impostor {
    const PACKAGE: &'static str = ProcessImage::PACKAGE;
    const NAME: &'static str = ProcessImage::NAME;
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

#[tokio::test]
async fn rubbish_is_counted_and_the_next_message_arrives() {
    let mut writer = node(2, "writer");
    let publisher = writer.publisher::<ProcessImage>("s1/inputs", qos::command()).expect("publisher");
    let impostor = writer.publisher::<Impostor>("s1/inputs", qos::command()).expect("publisher");
    let mut reader = node(2, "reader");
    let mut images = reader.subscription::<ProcessImage>("s1/inputs", qos::command()).expect("subscription");
    until_matched(&writer, "s1/inputs").await;
    let both = async {
        while reader.publisher_count("s1/inputs").expect("name") < 2 {
            sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(PATIENCE, both).await.expect("both writers are known in time");
    // Does not decode.
    impostor.send(Impostor(1));
    sleep(Duration::from_millis(100)).await;
    // Decodes, but no writer has boot id 0.
    publisher.send(ProcessImage::default());
    let mut good = ProcessImage { boot_id: 1, ..Default::default() };
    good.set_word(5);
    publisher.send(good.clone());
    assert_eq!(next(&mut images).await, good);
    // Of two writers, one message may come later than the other one's.
    let end = tokio::time::Instant::now() + PATIENCE;
    while images.rejected() < 2 && tokio::time::Instant::now() < end {
        let more = timeout(Duration::from_millis(50), images.recv()).await;
        assert!(more.is_err(), "nothing else was sent");
    }
    assert_eq!((images.received(), images.rejected()), (1, 2));
}

#[tokio::test]
async fn with_discovery_off_nobody_is_found() {
    let mut reader = node(6, "reader");
    let off = RosArgs { range: Some(Range::Off), ..args(6) };
    let mut alone = Participant::open(&off).expect("participant").node("/line", "alone").expect("node");
    let publisher = alone.publisher::<Text>("t", qos::latched_state()).expect("publisher");
    publisher.send(Text::from("anybody?"));
    let mut texts = reader.subscription::<Text>("t", qos::latched_state()).expect("subscription");
    assert!(timeout(Duration::from_millis(1500), texts.recv()).await.is_err(), "heard through discovery that is off");
}

#[tokio::test]
async fn many_subscriptions_merge_into_one_channel_and_stop_with_it() {
    let mut writer = node(3, "writer");
    let mut reader = node(3, "reader");
    let (to, mut from) = mpsc::channel(8);
    let mut publishers = Vec::new();
    let mut forwards = Vec::new();
    for station in ["s1", "s2"] {
        let topic = format!("{station}/selector");
        publishers.push(writer.publisher::<Text>(&topic, qos::command()).expect("publisher"));
        let subscription = reader.subscription::<Text>(&topic, qos::command()).expect("subscription");
        forwards.push(forward(subscription, to.clone(), move |text, _| Some((station, text.data))));
        until_matched(&writer, &topic).await;
    }
    for publisher in &publishers {
        publisher.send(Text::from("manual"));
    }
    let mut seen = Vec::new();
    for _ in 0..2 {
        seen.push(timeout(PATIENCE, from.recv()).await.expect("in time").expect("open"));
    }
    seen.sort();
    assert_eq!(seen, [("s1", "manual".to_owned()), ("s2", "manual".to_owned())]);
    drop(from);
    timeout(PATIENCE, async {
        while !forwards.iter().all(|f| f.is_finished()) {
            sleep(Duration::from_millis(5)).await;
        }
    })
    .await
    .expect("tasks end with the channel");
}

#[tokio::test]
async fn a_receive_that_is_cancelled_loses_nothing() {
    let mut writer = node(4, "writer");
    let publisher = writer.publisher::<Text>("log", qos::event()).expect("publisher");
    let mut reader = node(4, "reader");
    let mut texts = reader.subscription::<Text>("log", qos::event()).expect("subscription");
    until_matched(&writer, "log").await;
    let mut got = Vec::new();
    for number in 0..50 {
        publisher.send(Text { data: number.to_string() });
        // Cancelled at arbitrary moments; half of these time out before anything has come.
        if let Ok(received) = timeout(Duration::from_micros(100), texts.recv()).await {
            got.push(received.expect("received").0.data);
        }
    }
    while got.len() < 50 {
        got.push(next(&mut texts).await.data);
    }
    assert_eq!(got, (0..50).map(|n| n.to_string()).collect::<Vec<_>>());
}

#[tokio::test]
async fn names_are_remapped_on_the_wire() {
    let line = "--ros-args -r __ns:=/other -r __node:=n -r mode_cmd:=/other/cmd";
    let (mut args_here, _) =
        RosArgs::parse(line.split(' ').map(str::to_owned), |_| None, |_| Ok(String::new())).expect("arguments");
    args_here.domain_id = args(5).domain_id;
    let participant = Participant::open(&args_here).expect("participant");
    let mut node = participant.node("/line", "given").expect("node");
    assert_eq!((node.namespace(), node.name()), ("/other", "n"));
    let publisher = node.publisher::<Text>("mode_cmd", qos::command()).expect("publisher");
    assert_eq!(publisher.topic(), "/other/cmd");
    let own = node.publisher::<Text>("~/text", qos::command()).expect("publisher");
    assert_eq!(own.topic(), "/other/n/text");
}

/// Nodes keep these in tasks and share them between threads.
#[test]
fn handles_can_be_sent_and_shared() {
    fn both<T: Send + Sync>() {}
    both::<Participant>();
    both::<RosNode>();
    both::<linewright_node_shell::Publisher<Text>>();
    both::<Subscription<Text>>();
}
