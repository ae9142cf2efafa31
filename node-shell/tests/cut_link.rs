//! A link that is really cut: commands that the middleware has kept meanwhile are not obeyed when it is there again, but the stop and
//! releases are.
//!
//! ```text
//!   a namespace of this test             one more, with the publisher
//!   ┌───────────────┐     lwcut0 — lwcut1     ┌───────────────┐
//!   │ forward_timely │◀──── set down, and up ────│   publisher   │
//!   └───────────────┘                         └───────────────┘
//! ```
//!
//! Neither namespace has another interface but loopback. Without the right to make them the test is skipped, with a message on the
//! terminal.

use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use linewright_msgs::{Flag, Text};
use linewright_node_shell::{Participant, Publisher, Range, RosArgs, RosNode, forward_timely, qos};
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};

use crate::namespace::{Ended, OtherNamespace, is_alone, run_inside, shell, skip, up};

/// Later than what is still obeyed, by far less than the middleware keeps it.
const CUT: Duration = Duration::from_secs(5);
const PATIENCE: Duration = Duration::from_secs(40);

#[test]
fn what_was_kept_for_a_cut_link_is_not_obeyed_but_the_stop_and_releases_are() {
    run_inside("a link that is cut", "cut_link::inside_the_namespace");
}

/// The publisher in the other namespace.
struct PublisherBeside {
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    _ended: Ended,
    _namespace: OtherNamespace,
}

impl PublisherBeside {
    fn start() -> Self {
        let namespace = OtherNamespace::start();
        let mut beside = namespace.test("cut_link::beside_it");
        beside.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = beside.spawn().expect("started");
        let (to, from) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
        PublisherBeside { to, from: BufReader::new(from), _ended: Ended(child), _namespace: namespace }
    }

    /// Has it send one message, and waits until that is done.
    fn send(&mut self, what: &str) {
        writeln!(self.to, "{what}").expect("it reads");
        let mut line = String::new();
        while line.trim() != "sent" {
            line.clear();
            assert_ne!(self.from.read_line(&mut line).expect("it writes"), 0, "the publisher has ended");
        }
    }
}

fn node(name: &str) -> RosNode {
    let args = RosArgs { range: Some(Range::Subnet), ..RosArgs::default() };
    Participant::open(&args).expect("a participant").node("/line", name).expect("a node")
}

#[ignore = "started by inside_the_namespace"]
#[test]
fn beside_it() {
    if !is_alone() {
        return skip("not in a namespace of its own");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().expect("runtime");
    let _in_it = runtime.enter();
    let mut node = node("operator");
    let commands: Publisher<Text> = node.publisher("mode_cmd", qos::command()).expect("a publisher");
    let held: Publisher<Flag> = node.publisher("resume", qos::command()).expect("a publisher");
    for line in std::io::stdin().lines() {
        match line.expect("text").as_str() {
            "hold" => held.send(Flag { data: true }),
            "release" => held.send(Flag { data: false }),
            word => commands.send(Text::from(word)),
        }
        println!("sent");
    }
}

#[ignore = "started by what_was_kept_for_a_cut_link_is_not_obeyed_but_the_stop_and_releases_are"]
#[test]
fn inside_the_namespace() {
    if !is_alone() {
        return skip("not in a namespace of its own");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().expect("runtime");
    runtime.block_on(cut());
}

async fn cut() {
    let mut beside = PublisherBeside::start();
    let mut node = node("coordinator");
    let (to, mut obeyed) = mpsc::channel(1000);
    let commands = node.subscription("mode_cmd", qos::event()).expect("a subscription");
    let held = node.subscription("resume", qos::command()).expect("a subscription");
    let _commands = forward_timely(commands, to.clone(), |m: &Text| m.data == "estop", |m, _| Some(m.data));
    let word = |m: Flag| Some(if m.data { "hold" } else { "release" }.to_owned());
    let _held = forward_timely(held, to, |m: &Flag| !m.data, move |m, _| word(m));
    let mut next = async |within| timeout(within, obeyed.recv()).await.ok().flatten();

    // Until both topics are discovered; what comes gives the delay of the fastest.
    let end = Instant::now() + PATIENCE;
    let (mut has_command, mut has_release) = (false, false);
    while !(has_command && has_release) {
        assert!(Instant::now() < end, "the two find each other");
        beside.send("before");
        beside.send("release");
        while let Some(word) = next(Duration::from_millis(300)).await {
            has_command |= word == "before";
            has_release |= word == "release";
        }
    }
    beside.send("hold");
    assert_eq!(next(PATIENCE).await.as_deref(), Some("hold"));
    beside.send("release");
    assert_eq!(next(PATIENCE).await.as_deref(), Some("release"));

    shell("ip link set lwcut0 down");
    for word in ["start", "hold", "hold", "estop", "auto", "release"] {
        beside.send(word);
        sleep(Duration::from_millis(50)).await;
    }
    let cut_at = Instant::now();
    assert_eq!(next(CUT).await, None, "nothing passes");
    println!("the link is there again after {:?}", cut_at.elapsed());
    shell(&up("lwcut0", "10.77.0.1"));
    let mut words = Vec::new();
    while !(words.iter().any(|word| word == "estop") && words.iter().any(|word| word == "release")) {
        words.push(next(PATIENCE).await.unwrap_or_else(|| panic!("the stop and the release: {words:?}")));
    }
    // What else was kept has come by now too.
    while let Some(word) = next(Duration::from_secs(3)).await {
        words.push(word);
    }
    assert!(words.iter().all(|word| word == "estop" || word == "release"), "{words:?}");
    beside.send("after");
    assert_eq!(next(PATIENCE).await.as_deref(), Some("after"), "what is given now is obeyed");
    beside.send("hold");
    assert_eq!(next(PATIENCE).await.as_deref(), Some("hold"));
}
