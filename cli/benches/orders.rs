//! From a decision of a cell's coordinator to its station's report that it is doing the order.
//!
//! The shipped assembly cell runs as processes, as it would in production, several times as fast so that there are many
//! orders. Its own records have the times at which an activity was started and each order acknowledged, both by the
//! clock of the coordinator: between the two lie the log on disk, a goal over DDS, the station's controller and its
//! journal, and its state over DDS; and before all that the decision itself, which is short by rules and long where a
//! cell looks ahead and plans. Beside it, in the same run: a bare goal of the same action that is answered by a bare
//! state, two participants and nothing else; and a record of the same size brought to disk. A ratio to these is a
//! result; a number of microseconds on a shared machine is not.
//!
//! `cargo bench -p linewright --bench orders [-- PARTS]`; 12 parts by default.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use linewright_coordinator_cell::{OrderKey, RecordKind};
use linewright_history::HistoryReader;
use linewright_line::Tick;
use linewright_msgs::{OrderState, RunTask, RunTaskGoal, RunTaskResult};
use linewright_node_shell::{
    GoalAsked, GoalEnd, GoalRequest, Mapping, Participant, RosArgs, forward, qos, serve_action,
};
use tokio::sync::mpsc;

#[path = "../tests/support/faster.rs"]
mod faster;

use faster::faster;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The cell's times are divided by this; its processes are unaffected.
const FASTER: f64 = 10.0;
const PINGS: usize = 300;
/// A line's rhythm: every thread that is woken has been asleep.
const BETWEEN: Duration = Duration::from_millis(50);

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let parts: u32 = words.first().map_or(Ok(12), |word| word.parse())?;
    let dir = std::env::temp_dir().join(format!("linewright-orders-{}", std::process::id()));
    fs::create_dir_all(&dir)?;
    let measured = measure(&dir, parts);
    fs::remove_dir_all(&dir)?;
    measured
}

fn measure(dir: &Path, parts: u32) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let before = runtime.block_on(ping())?;
    let disk = to_disk(dir)?;
    let (by_rules, as_shipped) = (orders(dir, parts, false)?, orders(dir, parts, true)?);
    let after = runtime.block_on(ping())?;
    let ping: Vec<Duration> = before.into_iter().chain(after).collect();
    let (ping, disk) = (print("bare goal and state", ping), print("record to disk", disk));
    for (what, orders) in [("order, by rules", by_rules), ("order, as shipped", as_shipped)] {
        let median = print(what, orders);
        println!("{what}: {:.1} bare exchanges, {:.1} records to disk", median / ping, median / disk);
    }
    Ok(())
}

/// Prints the spread; gives the median in seconds.
fn print(what: &str, mut all: Vec<Duration>) -> f64 {
    all.sort_unstable();
    let at = |share: f64| all.get((all.len() as f64 * share) as usize).copied().unwrap_or_default().as_secs_f64() * 1e3;
    let (least, median, most) = (at(0.0), at(0.5), at(0.99));
    println!("{what:20} {:5} times: least {least:.2} ms, median {median:.2} ms, 99 % {most:.2} ms", all.len());
    median / 1e3
}

/// The peer: a goal there, a state back.
async fn ping() -> Result<Vec<Duration>> {
    let node = |name: &str| -> Result<_> {
        let participant = Participant::open(&RosArgs { domain_id: 94, ..RosArgs::default() })?;
        Ok(participant.node("/bench", name)?)
    };
    let mut station = node("station")?;
    let (to, mut asked) = mpsc::channel(16);
    let (owner, _serving) = serve_action(station.action::<RunTask>("~/run_task")?, to, |asked| asked);
    let state = station.publisher::<OrderState>("~/order", qos::latched_state())?;
    tokio::spawn(async move {
        let mut sequence = 0;
        while let Some(asked) = asked.recv().await {
            if let GoalRequest { goal: asked, asked: GoalAsked::New(goal), .. } = asked {
                sequence += 1;
                let doing = (goal.epoch, goal.id);
                let mut message =
                    OrderState { boot_id: 1, sequence, station: "bench".into(), memory: 1, ..OrderState::default() };
                (message.doing_epoch, message.doing_id, message.phase) = (doing.0, doing.1, 1);
                state.send(message);
                // No more goals are kept than a station can have.
                let result = RunTaskResult { epoch: goal.epoch, id: goal.id, ..RunTaskResult::default() };
                owner.end(asked, GoalEnd::Succeeded, result);
            }
        }
    });
    let mut coordinator = node("coordinator")?;
    let (to, mut heard) = mpsc::channel(64);
    let subscription = coordinator.subscription("/bench/station/order", qos::latched_state())?;
    let _forward = forward(subscription, to, |message: OrderState, _| Some(message));
    let caller = coordinator.action_caller::<RunTask>("/bench/station/run_task", Mapping::Enhanced)?;
    let mut times = Vec::new();
    let mut id = 0;
    while times.len() < PINGS {
        tokio::time::sleep(BETWEEN).await;
        id += 1;
        let goal =
            RunTaskGoal { memory: 1, epoch: 1, id, task: "work".into(), limit_ms: 1000, ..RunTaskGoal::default() };
        let began = Instant::now();
        if caller.send(goal).is_err() {
            continue;
        }
        // A goal without an answer was sent before discovery.
        let answer = tokio::time::timeout(Duration::from_millis(500), async {
            while heard.recv().await.is_some_and(|state| state.doing_id != id) {}
        });
        if answer.await.is_ok() {
            times.push(began.elapsed());
        } else if id > 2 * PINGS as u64 {
            return Err("the bare exchange does not come about".into());
        }
    }
    Ok(times)
}

/// Time to bring a record of the log to this disk.
fn to_disk(dir: &Path) -> Result<Vec<Duration>> {
    let mut file = File::create(dir.join("record"))?;
    let mut times = Vec::new();
    for _ in 0..PINGS {
        std::thread::sleep(BETWEEN / 10);
        let began = Instant::now();
        file.write_all(&[7; 200])?;
        file.sync_data()?;
        times.push(began.elapsed());
    }
    Ok(times)
}

/// The times of all orders of a production, from the cell's database. As shipped its dispatcher looks ahead and plans, which
/// is part of every decision; otherwise it follows rules alone.
fn orders(dir: &Path, parts: u32, plans: bool) -> Result<Vec<Duration>> {
    let dir = dir.join(if plans { "plans" } else { "rules" });
    let (cell, state) = (dir.join("cell"), dir.join("state"));
    fs::create_dir_all(&cell)?;
    let shipped = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines/assembly-cell");
    for file in ["line.toml", "cell.toml"] {
        let mut text = faster(&fs::read_to_string(shipped.join(file))?, FASTER);
        if !plans {
            text = text.replace("\"schedule\", ", "").replace("look_ahead_s = 30\n", "");
        }
        fs::write(cell.join(file), text)?;
    }
    let wanted = format!("1={},2={}", parts / 2, parts - parts / 2);
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    command.arg("run").arg(&cell).args(["--json", "--parts", &wanted, "--state-dir"]).arg(&state);
    command.env("LINEWRIGHT_BUS_DIR", dir.join("bus")).env("ROS_DOMAIN_ID", "95").stdin(Stdio::null());
    let output = command.output()?;
    if !output.status.success() {
        return Err(format!("the cell did not make its parts: {output:?}").into());
    }
    let mut began: BTreeMap<OrderKey, Tick> = BTreeMap::new();
    let mut times = Vec::new();
    HistoryReader::open(&state.join("cell.db"))?.each(Tick::NEVER, |event| {
        let Some(record) = event.record() else { return };
        match record.fact {
            RecordKind::Started { orders, .. } => began.extend(orders.into_iter().map(|key| (key, record.at))),
            // One that has ended before its station was received again was taken on as well, at an unknown time.
            RecordKind::Acknowledged { key } => times.extend(began.remove(&key).map(|at| record.at.since(at))),
            _ => {}
        }
    })?;
    Ok(times)
}
