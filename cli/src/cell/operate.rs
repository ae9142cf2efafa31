//! Commands of an operator on a running cell: `order`, `answer` and `resource`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use clap::{Args, Subcommand};
use linewright_console_view::{answers, permitted, verdict};
use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_cell::texts::alarm::takes_back;
use linewright_msgs::{AlarmState, CellState, ProductionState, SetResourceRequest, Time};
use linewright_node_shell::RosArgs;
use miette::miette;
use serde::Serialize;
use serde_json::{Value, json};

use super::{CellClient, request};
use crate::load;
use crate::out::{self, say};

/// How long to wait for a cell to be heard.
pub(super) const CONNECT: Duration = Duration::from_secs(5);

/// Time in which an answer is compared with the sensors, usually: a state of the stations that is newer than the answer.
const COMPARED: Duration = Duration::from_millis(1500);

/// Submit, list, cancel or withdraw production orders of a running cell.
#[derive(Debug, Args)]
pub struct OrderArgs {
    /// The cell's directory.
    cell: PathBuf,
    /// One JSON object on standard output.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    what: Option<OrderOperation>,
}

#[derive(Debug, Subcommand)]
enum OrderOperation {
    /// Submit a production order.
    Submit(Submit),
    /// List the production orders; the default without a subcommand.
    List,
    /// Cancel a production order: no more of its parts enter; parts inside are finished.
    Cancel {
        /// The order's name.
        name: String,
    },
    /// Withdraw a production order of which no part has entered; its name is free again.
    Withdraw {
        /// The order's name.
        name: String,
    },
}

#[derive(Debug, Args)]
struct Submit {
    /// Part type to make.
    product: String,
    /// Number of parts, from 1.
    #[arg(default_value_t = 1)]
    quantity: u32,
    /// Name of the order [default: the part type and the time].
    #[arg(long)]
    name: Option<String>,
    /// Due date, in seconds from now.
    #[arg(long)]
    due: Option<f64>,
    /// Release, in seconds from now: no part of it enters before.
    #[arg(long)]
    release: Option<f64>,
    /// Priority; the greater number comes first.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    priority: i32,
    /// Order that has to be over before; repeat it for several.
    #[arg(long)]
    after: Vec<String>,
}

/// `linewright order`
pub async fn order(args: OrderArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line_of_cell(&args.cell)?;
    let mut client = CellClient::open(&line, ros, "order")?;
    let state = client.until_heard(CONNECT).await?;
    match args.what {
        None | Some(OrderOperation::List) if args.json => out::json(&CellJson::of(state))?,
        None | Some(OrderOperation::List) => say!("{}", list(state)),
        Some(OrderOperation::Submit(submit)) => {
            let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            let name = submit.name.clone().unwrap_or_else(|| usual_name(&submit.product, wall));
            let mut wanted = request(&name, &submit.product, submit.quantity);
            wanted.release = moment(wall, submit.release, "--release")?;
            wanted.due = moment(wall, submit.due, "--due")?;
            (wanted.priority, wanted.after) = (submit.priority, submit.after);
            let ids = client.submit(vec![wanted]).await?;
            let numbers: Vec<String> = ids.iter().map(u64::to_string).collect();
            let text = format!("production order {}: `{name}`", numbers.join(", "));
            done(args.json, &text, json!({ "ids": ids, "name": name }))?;
        }
        Some(OrderOperation::Cancel { name }) => {
            client.cancel(&name).await?;
            done(args.json, &format!("`{name}` is cancelled"), json!({ "name": name, "state": "cancelled" }))?;
        }
        Some(OrderOperation::Withdraw { name }) => {
            client.withdraw(&name).await?;
            done(args.json, &format!("`{name}` is withdrawn"), json!({ "name": name, "state": "withdrawn" }))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Name of an order that is given none: the part type and the time, to the millisecond, so that two in a second have two names.
pub(super) fn usual_name(product: &str, wall: Duration) -> String {
    format!("{product} {}.{:03}", wall.as_secs(), wall.subsec_millis())
}

/// Prints what was done, as text or as JSON.
fn done(as_json: bool, text: &str, object: Value) -> miette::Result<()> {
    if as_json {
        return out::json(&object);
    }
    say!("{text}");
    Ok(())
}

pub(super) fn moment(now: Duration, after: Option<f64>, option: &str) -> miette::Result<Time> {
    let Some(seconds) = after else { return Ok(Time::default()) };
    let span = Duration::try_from_secs_f64(seconds).ok().filter(|span| span.as_secs() < 1_000_000_000);
    let span = span.ok_or_else(|| miette!("{option} {seconds}: expected seconds from now, 0 to 1000000000"))?;
    let at = now + span;
    Ok(Time { sec: i32::try_from(at.as_secs()).unwrap_or(i32::MAX), nanosec: at.subsec_nanos() })
}

/// Production orders, and their obstacles.
#[derive(Serialize)]
pub struct CellJson {
    parts_inside: u32,
    parts_left: u64,
    /// Activities may start.
    starting: bool,
    orders: Vec<OrderJson>,
    alarms: Vec<Value>,
}

#[derive(Serialize)]
struct OrderJson {
    id: u64,
    name: String,
    product: String,
    quantity: u32,
    entered: u32,
    done: u32,
    lost: u32,
    /// The state as operators read it.
    text: String,
}

impl CellJson {
    pub fn of(state: &CellState) -> Self {
        let order = |order: &ProductionState| OrderJson {
            id: order.id,
            name: order.name.clone(),
            product: order.product.clone(),
            quantity: order.quantity,
            entered: order.entered,
            done: order.done,
            lost: order.lost,
            text: order.text.clone(),
        };
        CellJson {
            parts_inside: state.parts_inside,
            parts_left: state.parts_left,
            starting: state.starting,
            orders: state.orders.as_slice().iter().map(order).collect(),
            alarms: alarms(state),
        }
    }
}

fn alarms(state: &CellState) -> Vec<Value> {
    let alarm = |alarm: &AlarmState| {
        let remark = |of: ListedAnswer| of.remark.map(|remark| verdict(remark.fit));
        let verdicts: Vec<Option<&str>> = permitted(alarm).into_iter().map(remark).collect();
        let AlarmState { id, text, answers, meanings, verdict_reasons, .. } = alarm;
        json!({
            "id": id, "text": text, "answers": answers, "meanings": meanings, "verdicts": verdicts, "verdict_reasons": verdict_reasons
        })
    };
    state.alarms.as_slice().iter().map(alarm).collect()
}

fn list(state: &CellState) -> String {
    let orders = state.orders.as_slice();
    let mut lines = vec![format!(
        "parts: {} inside, {} have left; {}",
        state.parts_inside,
        state.parts_left,
        if state.starting { "activities may start" } else { "nothing starts: the cell is not in auto" }
    )];
    if orders.is_empty() {
        lines.push("no production orders".to_owned());
    }
    let width = |of: fn(&ProductionState) -> usize| orders.iter().map(of).max().unwrap_or(0);
    let (names, products) = (width(|order| order.name.chars().count()), width(|order| order.product.chars().count()));
    for order in orders {
        let lost = if order.lost > 0 { format!(", {} lost", order.lost) } else { String::new() };
        lines.push(format!(
            "{:>4}  {:names$}  {:products$}  {:>5} of {:<5}  {}{lost}",
            order.id, order.name, order.product, order.done, order.quantity, order.text
        ));
    }
    lines.extend(state.alarms.as_slice().iter().map(|alarm| format!("alarm {}: {}", alarm.id, alarm.text)));
    lines.join("\n")
}

/// Answer an alarm of a running cell, or show the alarms that stand.
#[derive(Debug, Args)]
pub struct AnswerArgs {
    /// The cell's directory.
    cell: PathBuf,
    /// Number of the alarm [default: show the alarms].
    alarm: Option<String>,
    /// One of the alarm's answers.
    word: Option<String>,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// `linewright answer`
pub async fn answer(args: AnswerArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line_of_cell(&args.cell)?;
    let mut client = CellClient::open(&line, ros, "answer")?;
    let state = client.until_heard(CONNECT).await?;
    let Some(said) = args.alarm else {
        if args.json {
            out::json(&json!({ "alarms": alarms(state) }))?;
            return Ok(ExitCode::SUCCESS);
        }
        if state.alarms.as_slice().is_empty() {
            say!("no active alarm");
        }
        standing(state).iter().for_each(|alarm| say!("{alarm}"));
        return Ok(ExitCode::SUCCESS);
    };
    let (Ok(alarm), Some(word)) = (said.parse::<u64>(), args.word) else {
        let mut lines = vec![format!("expected the number of an alarm and one of its answers, not `{said}` alone")];
        if said.parse::<u64>().is_err() {
            lines = vec![format!("expected the number of an alarm, then one of its answers; `{said}` is no number")];
        }
        lines.extend(if state.alarms.as_slice().is_empty() {
            vec!["no active alarm".to_owned()]
        } else {
            standing(state)
        });
        return Err(miette!("{}", lines.join("\n")));
    };
    let before = state.clone();
    client.answer(alarm, &word).await?;
    match compared(&mut client, &before, &word).await? {
        Compared::Taken { left_out } => {
            let text = answered(alarm, &word, &left_out, &args.cell.display().to_string());
            done(args.json, &text, json!({ "alarm": alarm, "answer": word, "left_out": left_out }))?;
            Ok(ExitCode::SUCCESS)
        }
        Compared::TakenBack { now } => {
            out::complain!("answer \"{word}\" to alarm {alarm} is not taken; now alarm {}: {}", now.id, now.text);
            if args.json {
                out::json(&json!({ "alarm": alarm, "answer": word, "not_taken": { "id": now.id, "text": now.text } }))?;
            }
            Ok(ExitCode::FAILURE)
        }
    }
}

fn answered(alarm: u64, word: &str, left_out: &[String], cell: &str) -> String {
    let mut text = format!("alarm {alarm} is answered: {word}");
    for name in left_out {
        text.push_str(&format!(
            "\n{name} is out of service now; `linewright why {cell} {name}` says why, `linewright resource {cell} {name} up` \
             counts on it again"
        ));
    }
    text
}

/// The alarms that stand, with their answers.
fn standing(state: &CellState) -> Vec<String> {
    let alarms = state.alarms.as_slice().iter();
    alarms.map(|alarm| format!("alarm {}: {} Answers: {}", alarm.id, alarm.text, answers(alarm))).collect()
}

/// What has become of an answer that was compared with the sensors.
#[derive(Debug, PartialEq)]
enum Compared {
    Taken {
        left_out: Vec<String>,
    },
    /// Another alarm says why.
    TakenBack {
        now: Box<AlarmState>,
    },
}

/// Waits until an answer was compared with the sensors, usually.
async fn compared(client: &mut CellClient, before: &CellState, word: &str) -> miette::Result<Compared> {
    let until = tokio::time::Instant::now() + COMPARED;
    while let Ok(state) = tokio::time::timeout_at(until, client.next()).await {
        if let Some(found) = comparison(before, state?, word) {
            return Ok(found);
        }
    }
    Ok(Compared::Taken { left_out: Vec::new() })
}

/// What a state shows of an answer that was given after another state; none if nothing yet.
fn comparison(before: &CellState, state: &CellState, word: &str) -> Option<Compared> {
    let is_new = |alarm: &&AlarmState| before.alarms.as_slice().iter().all(|had| had.id < alarm.id);
    let back = state.alarms.as_slice().iter().filter(is_new).find(|alarm| takes_back(&alarm.text, word));
    if let Some(now) = back {
        return Some(Compared::TakenBack { now: Box::new(now.clone()) });
    }
    let had = before.down.as_slice();
    let left_out: Vec<String> = state.down.as_slice().iter().filter(|name| !had.contains(name)).cloned().collect();
    // Those of one answer are left out in one step.
    (!left_out.is_empty()).then_some(Compared::Taken { left_out })
}

/// Show which resources of a running cell are left out, or say how one is.
#[derive(Debug, Args)]
pub struct ResourceArgs {
    /// The cell's directory.
    cell: PathBuf,
    /// Name of the resource [default: show those out of service].
    resource: Option<String>,
    /// One JSON object on standard output.
    #[arg(long, global = true)]
    json: bool,
    /// What to do with it.
    #[command(subcommand)]
    is: Option<ResourceService>,
}

#[derive(Debug, Subcommand)]
enum ResourceService {
    /// Stop the activities of the resource: all their stations stand at once, also half-way; the activities have
    /// failed, and the resource is out of service. This is no emergency stop.
    Alarm {
        /// Reason.
        text: Vec<String>,
    },
    /// Put the resource out of service; activities in progress are finished.
    Down,
    /// Put the resource back into service.
    Up,
    /// Reset the resource's station, or a named station, that a recovery rule has put into emergency stop. It follows
    /// the line's mode again; a motion that was stopped half-way is led on in manual.
    Reset,
    /// Anything else.
    #[command(external_subcommand)]
    Unknown(Vec<String>),
}

/// Commands for a resource.
const COMMANDS: [&str; 4] = ["alarm", "down", "up", "reset"];

fn unknown_command(words: &[String]) -> miette::Report {
    let word = words.first().map_or("", String::as_str);
    load::or_meant(miette!("unknown command '{word}'; commands: {}", COMMANDS.join(", ")), word, COMMANDS)
}

/// `linewright resource`
pub async fn resource(args: ResourceArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    if let Some(ResourceService::Unknown(words)) = &args.is {
        return Err(unknown_command(words));
    }
    let line = load::line_of_cell(&args.cell)?;
    let mut client = CellClient::open(&line, ros, "resource")?;
    let state = client.until_heard(CONNECT).await?;
    let (name, is) = match (args.resource, args.is) {
        (Some(name), Some(is)) => (name, is),
        (None, None) => {
            let down = state.down.clone();
            if args.json {
                let mut list = Vec::new();
                for name in down.as_slice() {
                    list.push(json!({ "resource": name, "reasons": client.why(name).await? }));
                }
                out::json(&json!({ "out_of_service": list }))?;
                return Ok(ExitCode::SUCCESS);
            }
            if down.as_slice().is_empty() {
                say!("no resource is out of service");
            }
            for failed in state.activities.as_slice().iter().filter(|of| !of.running) {
                say!("{}: {}; its stations are given no work until then", failed.name, failed.text);
            }
            for name in down.as_slice() {
                client.why(name).await?.iter().for_each(|reason| say!("{reason}"));
            }
            return Ok(ExitCode::SUCCESS);
        }
        (Some(name), None) => return Err(miette!("missing command for {name}: alarm, down, up or reset")),
        (None, Some(_)) => return Err(miette!("missing resource name")),
    };
    let (what, text, state) = match is {
        ResourceService::Alarm { text } => (
            SetResourceRequest::ALARM,
            text.join(" "),
            "is out of service; its activities were stopped and have failed",
        ),
        ResourceService::Down => (SetResourceRequest::DOWN, String::new(), "is out of service"),
        ResourceService::Up => (SetResourceRequest::UP, String::new(), "is in service again"),
        ResourceService::Reset => (SetResourceRequest::RESET, String::new(), "is reset"),
        ResourceService::Unknown(words) => return Err(unknown_command(&words)),
    };
    client.resource(&name, what, &text).await?;
    done(args.json, &format!("{name} {state}"), json!({ "resource": name, "state": state }))?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_msgs::Bounded;

    fn cell(alarms: &[(u64, &str)], down: &[&str]) -> CellState {
        let alarm = |&(id, text): &(u64, &str)| AlarmState { id, text: text.into(), ..AlarmState::default() };
        CellState {
            alarms: Bounded::new(alarms.iter().map(alarm).collect()).expect("few"),
            down: Bounded::new(down.iter().map(|name| (*name).to_owned()).collect()).expect("few"),
            ..CellState::default()
        }
    }

    const CONTRADICTED: &str =
        "Answer \"as-before\" contradicts the sensors: lathe: no part expected, sensor on. load failed.";

    #[test]
    fn an_answer_that_sensors_contradict_is_not_called_taken() {
        let before = cell(&[(15, CONTRADICTED)], &["M2"]);
        let found = |alarms: &[(u64, &str)], down: &[&str]| comparison(&before, &cell(alarms, down), "as-before");
        assert_eq!(found(&[(15, CONTRADICTED)], &["M2"]), None, "that was another one");
        assert_eq!(found(&[(16, "load failed.")], &["M2"]), None);
        for text in [CONTRADICTED, "gantry moved after the answer \"as-before\". load failed."] {
            let Some(Compared::TakenBack { now }) = found(&[(16, text)], &["M2"]) else { panic!("{text}") };
            assert_eq!(now.id, 16);
        }
        assert_eq!(found(&[], &["M2", "lathe"]), Some(Compared::Taken { left_out: vec!["lathe".to_owned()] }));
    }

    #[test]
    fn two_orders_of_one_second_have_two_usual_names() {
        let at = |millis| usual_name("A", Duration::from_millis(millis));
        assert_eq!(
            (at(1_700_000_000_007), at(1_700_000_000_008)),
            ("A 1700000000.007".into(), "A 1700000000.008".into())
        );
    }

    #[test]
    fn what_an_answer_left_out_is_a_whole_sentence() {
        let text = answered(15, "gone", &["lathe".to_owned()], "gear");
        assert_eq!(
            text,
            "alarm 15 is answered: gone\nlathe is out of service now; `linewright why gear lathe` says why, \
             `linewright resource gear lathe up` counts on it again"
        );
    }
}
