//! Latency between two processes on the loopback address.
//!
//! `oneway [count] [period_us] [reliable|best-effort] [shell|bare]` starts a second process that sends
//! every message back, and prints the round trip and both one-way times (the processes share a clock).
//! `bare` uses the client library directly, `shell` the wrappers of this crate; the difference is what
//! the shell costs.

use linewright_msgs::{Header, ProcessImage, RosMessage};
use linewright_node_shell::{MessageSource, Participant, RosArgs, boot_id, qos, stamp};
use ros2_client::{Context, MessageTypeName, Name, NodeName, NodeOptions, QosProfile};
use std::error::Error;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Not measured: discovery and first touches of memory.
const WARM_UP: u64 = 100;

fn main() -> Result<()> {
    let (args, rest) = RosArgs::from_process()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let word = |at: usize| rest.get(at).map(String::as_str);
    let reliable = word(2) != Some("best-effort");
    let bare = word(3) == Some("bare");
    if word(0) == Some("echo") {
        return runtime.block_on(echo(Link::open(&args, "echo", "ping", "pong", reliable, bare)?));
    }
    let count = word(0).unwrap_or("2000").parse()?;
    let period = Duration::from_micros(word(1).unwrap_or("1000").parse()?);
    let mut peer = Command::new(std::env::current_exe()?)
        .args(["echo", "", if reliable { "reliable" } else { "best-effort" }, if bare { "bare" } else { "shell" }])
        .stdin(Stdio::null())
        .spawn()?;
    let link = Link::open(&args, "ping", "pong", "ping", reliable, bare)?;
    let result = runtime.block_on(measure(link, count, period));
    peer.kill()?;
    peer.wait()?;
    result
}

/// One topic in, one topic out, through the shell or without it.
enum Link {
    Shell {
        _node: Box<linewright_node_shell::RosNode>,
        out: linewright_node_shell::Publisher<ProcessImage>,
        into: linewright_node_shell::Subscription<ProcessImage>,
    },
    Bare {
        _node: Box<ros2_client::Node>,
        out: ros2_client::Publisher<ProcessImage>,
        into: ros2_client::Subscription<ProcessImage>,
    },
}

impl Link {
    fn open(args: &RosArgs, name: &str, from: &str, to: &str, reliable: bool, bare: bool) -> Result<Self> {
        let qos = if reliable { qos::command() } else { qos::repeated() };
        if bare { Self::bare(args, name, from, to, &qos) } else { Self::shell(args, name, from, to, &qos) }
    }

    fn shell(args: &RosArgs, name: &str, from: &str, to: &str, qos: &QosProfile) -> Result<Self> {
        let mut node = Participant::open(args)?.node("/oneway", name)?;
        let out = node.publisher(to, qos.clone())?;
        let into = node.subscription(from, qos.clone())?;
        Ok(Self::Shell { _node: Box::new(node), out, into })
    }

    fn bare(args: &RosArgs, name: &str, from: &str, to: &str, qos: &QosProfile) -> Result<Self> {
        let participant = rustdds::DomainParticipantBuilder::new(args.domain_id)
            .with_only_networks([std::net::Ipv4Addr::LOCALHOST])
            .build()?;
        let context = Context::from_domain_participant(participant)?;
        let mut node = context.new_node(NodeName::new("/oneway", name)?, NodeOptions::new())?;
        let topic = |node: &ros2_client::Node, name: &str| {
            let type_name = MessageTypeName::new(ProcessImage::PACKAGE, ProcessImage::NAME);
            node.create_topic(&Name::new("/oneway", name)?, type_name, qos).map_err(Box::<dyn Error>::from)
        };
        let (topic_out, topic_in) = (topic(&node, to)?, topic(&node, from)?);
        let out = node.create_publisher(&topic_out, Some(qos.clone()))?;
        let into = node.create_subscription(&topic_in, Some(qos.clone()))?;
        Ok(Self::Bare { _node: Box::new(node), out, into })
    }

    fn send(&self, message: ProcessImage) -> Result<()> {
        match self {
            Self::Shell { out, .. } => Ok(out.try_send(message)?),
            Self::Bare { out, .. } => out.publish(message).map_err(|e| e.to_string().into()),
        }
    }

    async fn receive(&mut self) -> Result<ProcessImage> {
        match self {
            Self::Shell { into, .. } => {
                into.recv().await.map(|(message, _): (_, MessageSource)| message).map_err(Into::into)
            }
            Self::Bare { into, .. } => into.async_take().await.map(|(message, _)| message).map_err(Into::into),
        }
    }
}

/// Sends everything back, with the time of arrival in the last eight bytes of the image.
async fn echo(mut link: Link) -> Result<()> {
    loop {
        let mut message = link.receive().await?;
        message.set_word(u128::from(nanoseconds(&stamp())));
        link.send(message)?;
    }
}

async fn measure(mut link: Link, count: u64, period: Duration) -> Result<()> {
    let (mut round_trips, mut there, mut back) = (Vec::new(), Vec::new(), Vec::new());
    let mut lost = 0;
    for sequence in 1..=count + WARM_UP {
        tokio::time::sleep(period).await;
        let sent = Instant::now();
        let header = stamp();
        let out = nanoseconds(&header);
        link.send(ProcessImage { header, boot_id: boot_id(), sequence, valid: true, ..Default::default() })?;
        let answer = tokio::time::timeout(Duration::from_millis(500), async {
            loop {
                let answer = link.receive().await?;
                if answer.sequence == sequence {
                    return Ok::<_, Box<dyn Error>>(answer);
                }
            }
        });
        let Ok(answer) = answer.await else {
            lost += u64::from(sequence > WARM_UP);
            continue;
        };
        let (round_trip, home) = (sent.elapsed(), nanoseconds(&stamp()));
        let turned = answer?.word() as u64;
        if sequence > WARM_UP {
            round_trips.push(round_trip.as_nanos() as u64);
            there.push(turned.saturating_sub(out));
            back.push(home.saturating_sub(turned));
        }
    }
    println!("{count} messages, {lost} lost; microseconds");
    print("round trip", round_trips);
    print("there", there);
    print("back", back);
    Ok(())
}

fn print(what: &str, mut times: Vec<u64>) {
    times.sort_unstable();
    let Some(last) = times.len().checked_sub(1) else { return println!("{what:10} nothing came back") };
    let at = |percent: usize| times[last * percent / 100] / 1000;
    println!("{what:10} p50 {:5}  p90 {:5}  p99 {:5}  max {:6}", at(50), at(90), at(99), at(100));
}

fn nanoseconds(header: &Header) -> u64 {
    header.stamp.sec.unsigned_abs() as u64 * 1_000_000_000 + u64::from(header.stamp.nanosec)
}
