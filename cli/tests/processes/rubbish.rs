//! Whatever anybody sends, on ROS topics and on the bus, while the line runs: it keeps to its chart.
//!
//! Malformed (bytes that are no message), meaningless (modes, stations, words that do not exist), too large, and late
//! (true messages of a minute ago, sent again).

use std::time::{Duration, Instant};

use linewright_msgs::{ModeOrder, ProcessImage, StationEvent, StationState, Text};
use linewright_node_shell::{Participant, Publisher, RosArgs, RosNode, qos};

use super::rubbish_senders::{Vandal, commander, litter};
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
    let bytes = Bytes::open(&mut node);
    let words = Words::open(&mut node);
    let member = rig.member();
    let late: Vec<StationState> = STATIONS.iter().map(|name| operator.station(name)).collect();
    operator.order("auto", StationState::MODE_AUTO);
    pause(500);

    let until = Instant::now() + Duration::from_secs(6);
    let mut round = 0;
    while Instant::now() < until {
        bytes.send();
        words.send(round, &late);
        litter(&member, round);
        round += 1;
        pause(100);
    }
    let boots = |operator: &Operator| STATIONS.map(|name| operator.station(name).boot_id);
    assert!(STATIONS.iter().zip(&late).zip(boots(&operator)).all(|((_, then), now)| then.boot_id == now));
    is_reported(&rig, &operator);
    assert!(operator.heard().in_mode(StationState::MODE_AUTO), "{}", operator.picture());
    operator.cycles(1);
    operator.go_home();
    let ran = usize::try_from(*operator.station("mill_1").done.last().expect("a count")).expect("a number");
    assert!(ran >= 3, "it has kept running: {ran}");
    {
        let seen = rig.eye.seen();
        assert_eq!(seen.conflicts(), [""; 0]);
        starts_follow_the_chart(seen.starts(), ran);
    }
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!((code, &report["restarts"]), (0, &0.into()), "{report}");
}

fn is_reported(rig: &Rig, operator: &Operator) {
    // As long as a message may be: an answer that repeated it would be longer, and nobody would hear it.
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

/// Bytes that are no message, on every kind of topic that is listened to.
struct Bytes {
    orders: Vandal<ModeOrder>,
    texts: Vec<Vandal<Text>>,
    states: Vec<Vandal<StationState>>,
    images: Vec<Vandal<ProcessImage>>,
}

impl Bytes {
    fn open(node: &mut RosNode) -> Self {
        let mut texts: Vec<Vandal<Text>> =
            ["mode_cmd", "buttons"].iter().map(|topic| Vandal::open(node, topic, qos::command())).collect();
        let (mut states, mut images) = (Vec::new(), Vec::new());
        for station in STATIONS {
            texts.push(Vandal::open(node, &format!("{station}/selector"), qos::command()));
            states.push(Vandal::open(node, &format!("{station}/state"), qos::latched_state()));
            for side in ["inputs", "outputs"] {
                images.push(Vandal::open(node, &format!("{station}/{side}"), qos::repeated()));
            }
        }
        Bytes { orders: Vandal::open(node, "mode", qos::command()), texts, states, images }
    }

    fn send(&self) {
        self.orders.send();
        self.texts.iter().for_each(Vandal::send);
        self.states.iter().for_each(Vandal::send);
        self.images.iter().for_each(Vandal::send);
    }
}

/// Messages of the right form that mean nothing, or mean what is over.
struct Words {
    orders: Publisher<ModeOrder>,
    commands: Publisher<Text>,
    buttons: Publisher<Text>,
    selectors: Vec<Publisher<Text>>,
    states: Vec<Publisher<StationState>>,
    images: Vec<Publisher<ProcessImage>>,
}

impl Words {
    fn open(node: &mut RosNode) -> Self {
        let mut images = Vec::new();
        for (station, side) in STATIONS.iter().flat_map(|station| [(station, "inputs"), (station, "outputs")]) {
            images.push(node.publisher(&format!("{station}/{side}"), qos::repeated()).expect("a topic"));
        }
        let state = |node: &mut RosNode, station: &&str| {
            node.publisher(&format!("{station}/state"), qos::latched_state()).expect("a topic")
        };
        Words {
            orders: commander(node, "mode"),
            commands: commander(node, "mode_cmd"),
            buttons: commander(node, "buttons"),
            selectors: STATIONS.iter().map(|station| commander(node, &format!("{station}/selector"))).collect(),
            states: STATIONS.iter().map(|station| state(node, station)).collect(),
            images,
        }
    }

    fn send(&self, round: u32, late: &[StationState]) {
        let long = "x".repeat(TEXT_MAX);
        let too_long = "x".repeat(TEXT_MAX + 1);
        for word in ["", "launch", "auto; hand", "\u{1b}[2J", &long, &too_long] {
            self.commands.send(Text::from(word));
            self.selectors.iter().for_each(|selector| selector.send(Text::from(word)));
        }
        for names in ["PB_99", "PB_2 PB_99", &long, &too_long] {
            self.buttons.send(Text::from(names));
        }
        // Newer than anything, but of no mode there is, or of no process.
        let order = ModeOrder { boot_id: 1, sequence: u64::MAX, epoch: u64::MAX, mode: 200, ..ModeOrder::default() };
        self.orders.send(order.clone());
        self.orders.send(ModeOrder { boot_id: 0, mode: StationState::MODE_MANUAL, manual_all: true, ..order });
        for (publisher, state) in self.states.iter().zip(late) {
            for wrong in wrong_states(state, round) {
                publisher.send(wrong);
            }
            // What it said at home, before the first cycle: true once, and late now.
            publisher.send(state.clone());
        }
        for publisher in &self.images {
            let mut image = ProcessImage { boot_id: 0, sequence: u64::MAX, valid: true, ..ProcessImage::default() };
            image.set_word(u128::MAX);
            publisher.send(image);
        }
    }
}

/// States that cannot be: each newer than any true one.
fn wrong_states(state: &StationState, round: u32) -> Vec<StationState> {
    let newer = StationState { boot_id: 77, sequence: u64::from(round) + 1, ..state.clone() };
    let mut longer = newer.clone();
    longer.done.push(9);
    longer.started.push(9);
    longer.places.push(0);
    let large = vec![0; TEXT_MAX + 1];
    vec![
        longer,
        StationState { done: Vec::new(), started: Vec::new(), places: Vec::new(), ..newer.clone() },
        StationState { station: "mill_9".to_owned(), ..newer.clone() },
        StationState { mode: 200, ..newer.clone() },
        StationState { places: vec![99; state.places.len()], ..newer.clone() },
        StationState { boot_id: 0, ..newer.clone() },
        StationState { incomplete: vec![500], ..newer.clone() },
        StationState { fault: "y".repeat(TEXT_MAX + 1), ..newer.clone() },
        StationState { done: large.clone(), started: large, places: vec![0; TEXT_MAX + 1], ..newer },
    ]
}
