//! Number of processes on one host that discover each other, and the time it takes.
//!
//! `crowd N [seconds] [hz]` starts N processes that each publish a latched station state and subscribe to those of all
//! others, and prints when each had received all of them. Run it again inside `unshare -n` with multicast switched on
//! for `lo` to see the difference multicast makes.

use linewright_msgs::StationState;
use linewright_node_shell::{Participant, RosArgs, boot_id, forward, qos, stamp};
use std::collections::BTreeSet;
use std::error::Error;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let (args, rest) = RosArgs::from_process()?;
    let number = |at: usize, otherwise: u64| rest.get(at).and_then(|text| text.parse().ok()).unwrap_or(otherwise);
    if rest.first().is_some_and(|word| word == "member") {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        return runtime.block_on(member(&args, number(1, 0), number(2, 2), number(3, 20), number(4, 2)));
    }
    crowd(number(0, 5), number(1, 20), number(2, 2))
}

fn crowd(count: u64, seconds: u64, hz: u64) -> Result<()> {
    let mut members = Vec::new();
    for me in 0..count {
        let arguments = ["member".to_owned(), me.to_string(), count.to_string(), seconds.to_string(), hz.to_string()];
        let child = Command::new(std::env::current_exe()?).args(arguments).stdout(Stdio::piped()).spawn()?;
        members.push(child);
    }
    for member in members {
        print!("{}", String::from_utf8_lossy(&member.wait_with_output()?.stdout));
    }
    Ok(())
}

async fn member(args: &RosArgs, me: u64, count: u64, seconds: u64, hz: u64) -> Result<()> {
    let started = Instant::now();
    let participant = Participant::open(args)?;
    let mut node = participant.node("/crowd", &format!("member_{me}"))?;
    let publisher = node.publisher::<StationState>(&format!("s{me}/state"), qos::latched_state())?;
    let (to, mut heard) = mpsc::channel(256);
    let mut forwards = Vec::new();
    for other in (0..count).filter(|other| *other != me) {
        let subscription = node.subscription::<StationState>(&format!("s{other}/state"), qos::latched_state())?;
        forwards.push(forward(subscription, to.clone(), move |_, _| Some(other)));
    }
    let opened = started.elapsed();
    let mut tick = tokio::time::interval(Duration::from_millis(1000 / hz.max(1)));
    let end = tokio::time::sleep(Duration::from_secs(seconds));
    tokio::pin!(end);
    let (mut seen, mut first, mut all, mut sequence) = (BTreeSet::new(), None, None, 0);
    loop {
        tokio::select! {
            _ = tick.tick() => {
                sequence += 1;
                publisher.send(StationState {
                    header: stamp(), boot_id: boot_id(), sequence, station: format!("s{me}"),
                    lifecycle: StationState::LIFECYCLE_ACTIVE, ..Default::default()
                });
            }
            Some(other) = heard.recv() => {
                seen.insert(other);
                first.get_or_insert_with(|| started.elapsed());
                if seen.len() as u64 == count - 1 { all.get_or_insert_with(|| started.elapsed()); }
            }
            () = &mut end => break,
        }
    }
    let ms = |time: Option<Duration>| time.map_or("never".to_owned(), |t| format!("{} ms", t.as_millis()));
    println!(
        "member {me:2} participant {:2}: opened {}, first {}, heard {:2} of {}, all {}",
        participant.number(),
        ms(Some(opened)),
        ms(first),
        seen.len(),
        count - 1,
        ms(all),
    );
    Ok(())
}
