//! `linewright recover`: what an operator has to do until the line is in auto again, from what is heard of it now.
//!
//! The plan is made anew whenever the line has changed. What was the first step before and is none any more is shown as done.

mod json;
mod publish;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args as ClapArgs;
use linewright_line::Line;
use linewright_msgs::CellState;
use linewright_node_line::{mode_from_code, report_from_message};
use linewright_node_shell::RosArgs;
use linewright_recovery::{
    LineSituation, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, StandingAlarm, plan,
};

use crate::cell::CellClient;
use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::watch::Screen;
use json::RecoveryJson;

/// Time within which all are to be received.
const HEARD_WITHIN: Duration = Duration::from_secs(5);
/// Period of the picture, and of the look at what has changed.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// Show what has to be done until the line is in auto again.
#[derive(Debug, ClapArgs)]
#[command(
    after_help = "Each line is one thing to do: a command, a button to hold at the panel of a station, a position to confirm, or what no command does. It moves nothing by itself. The plan is made anew after every change; it ends when auto is in force."
)]
pub struct Args {
    /// The directory of a line or cell, or its description file.
    line: PathBuf,
    /// Print the plan for what is heard now, and end.
    #[arg(long)]
    once: bool,
    /// Print the plan as one JSON object, and end.
    #[arg(long)]
    json: bool,
    /// Publish the plan on `~/recovery_plan`, and answer requests for it, until Ctrl-C. For consoles.
    #[arg(long, conflicts_with_all = ["once", "json"])]
    publish: bool,
}

/// `linewright recover`
pub async fn run(args: Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    let mut client = OperatorClient::open(&line, ros, "recover")?;
    let mut cell = is_cell.then(|| CellClient::open(&line, ros, "recover_cell")).transpose()?;
    if args.publish {
        return publish::run(&mut client, cell, &args.line.display().to_string()).await;
    }
    let is_all = client.until_all_heard(HEARD_WITHIN).await?;
    if let Some(cell) = cell.as_mut().filter(|_| client.coordinator().is_some()) {
        cell.until_heard(HEARD_WITHIN).await?;
    }
    let path = args.line.display().to_string();
    if args.once || args.json {
        client.listen(line.timing.refresh * 4).await?;
        let found = found_now(&client, cell.as_ref());
        if args.json {
            crate::out::json(&RecoveryJson::of(&client, &path, found.as_ref()))?;
        } else {
            crate::out::say!("{}", picture(&client, &path, &[], found.as_ref()).join("\n"));
        }
        if !is_all {
            let coordinator = client.coordinator().is_none().then_some("the coordinator");
            let missing: Vec<&str> = coordinator.into_iter().chain(client.unheard()).collect();
            crate::out::complain!("not heard within {} s: {}", HEARD_WITHIN.as_secs(), missing.join(", "));
        }
        // What an alarm asks for a person decides.
        let leads_there = found.is_some_and(|plan| plan.end == RecoveryEnd::Auto && !plan.has_alarms());
        return Ok(if is_all && leads_there { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    follow(&mut client, cell, &path).await
}

/// Shows the plan until auto is in force.
async fn follow(client: &mut OperatorClient, mut cell: Option<CellClient>, path: &str) -> miette::Result<ExitCode> {
    let mut screen = if std::io::stdout().is_terminal() { Some(Screen::open()?) } else { None };
    let mut interrupts = Interrupts::listen()?;
    let mut looks = tokio::time::interval(LOOK_EVERY);
    let (mut done, mut shown, mut before): (Vec<String>, Vec<String>, Option<RecoveryPlan>) = Default::default();
    let mut has_changed = true;
    loop {
        tokio::select! {
            heard = client.next() => has_changed |= !matches!(heard?, StateUpdate::Event(..)),
            heard = next_of(&mut cell) => {
                heard?;
                has_changed = true;
            }
            _ = looks.tick() => if std::mem::take(&mut has_changed) {
                let found = found_now(client, cell.as_ref());
                if let (Some(before), Some(now)) = (&before, &found) {
                    done.extend(newly_done(client.line(), before, now));
                }
                let lines = picture(client, path, &done, found.as_ref());
                match &mut screen {
                    Some(screen) => screen.show(&lines)?,
                    None if lines != shown => crate::out::say!("{}\n", lines.join("\n")),
                    None => {}
                }
                shown = lines;
                if found.as_ref().is_some_and(|plan| plan.end == RecoveryEnd::Auto && plan.steps.is_empty()) {
                    drop(screen);
                    crate::out::say!("auto is in force");
                    return Ok(ExitCode::SUCCESS);
                }
                before = found.or(before);
            },
            () = interrupts.next() => return Ok(ExitCode::FAILURE),
        }
    }
}

async fn next_of(cell: &mut Option<CellClient>) -> miette::Result<()> {
    match cell {
        Some(cell) => cell.next().await.map(drop),
        None => std::future::pending().await,
    }
}

/// The first steps of a plan that its successor does not have any more, if the rest is the same.
fn newly_done(line: &Line, before: &RecoveryPlan, now: &RecoveryPlan) -> Vec<String> {
    let actions =
        |plan: &RecoveryPlan| plan.steps.iter().map(|step| step.action.clone()).collect::<Vec<RecoveryAction>>();
    let (old, new) = (actions(before), actions(now));
    if new.len() >= old.len() || !old.ends_with(&new) {
        return Vec::new();
    }
    before.steps[..old.len() - new.len()].iter().map(|step| step.text(line)).collect()
}

/// The plan for what is heard now; none where the coordinator is not heard.
fn found_now(client: &OperatorClient, cell: Option<&CellClient>) -> Option<RecoveryPlan> {
    let line = client.line();
    let state = client.coordinator()?;
    let mode = mode_from_code(state.mode).ok()?;
    let report =
        |id| client.station(id).and_then(|state| report_from_message(line, state).ok()).map(|(_, report)| report);
    let stations = line.station_ids().map(report).collect();
    let mut situation = LineSituation::read(line, mode, state.enabled, &state.text, stations);
    situation.alarms = cell.and_then(CellClient::heard_lately).map(alarms).unwrap_or_default();
    Some(plan(line, &situation))
}

fn alarms(cell: &CellState) -> Vec<StandingAlarm> {
    let alarm = |alarm: &linewright_msgs::AlarmState| StandingAlarm {
        id: alarm.id,
        text: alarm.text.clone(),
        answers: alarm.answers.to_vec(),
    };
    cell.alarms.as_slice().iter().map(alarm).collect()
}

/// The command for a step, if there is one.
fn typed(line: &Line, path: &str, step: &RecoveryStep) -> Option<String> {
    let quoted = |word: String| match word.as_str() {
        "LINE" => path.to_owned(),
        _ if word.contains(' ') => format!("\"{word}\""),
        _ => word,
    };
    let words: Vec<String> = step.arguments(line)?.into_iter().map(quoted).collect();
    Some(format!("linewright {}", words.join(" ")))
}

/// The plan as lines of text.
fn picture(client: &OperatorClient, path: &str, done: &[String], found: Option<&RecoveryPlan>) -> Vec<String> {
    let line = client.line();
    let mut lines = match client.coordinator() {
        Some(state) => vec![format!("{} — mode: {}", line.title, state.text)],
        None => vec![format!("{}: no state received from the coordinator: start it", line.title)],
    };
    if let Some(state) = client.coordinator().filter(|state| !state.refusal.is_empty()) {
        lines.push(format!("last refusal: {}", state.refusal));
    }
    lines.extend(done.iter().map(|text| format!(" done  {text}")));
    let Some(plan) = found else { return lines };
    for (at, step) in plan.steps.iter().enumerate() {
        lines.push(format!("{:>5}. {}", at + 1, step.text(line)));
        if at == 0 {
            lines.extend(typed(line, path, step).map(|typed| format!("       {typed}")));
            lines.extend(refused(client, step).map(|why| format!("       refused: {why}")));
        }
    }
    lines.extend(plan.end_text(line));
    if !plan.is_shortest {
        lines.push("there may be a shorter way: the search was ended".to_owned());
    }
    if plan.steps.is_empty() && plan.end == RecoveryEnd::Auto {
        lines.push("nothing to do".to_owned());
    }
    lines
}

/// Why the station of a press does not agree or may not move, in its own words.
fn refused(client: &OperatorClient, step: &RecoveryStep) -> Option<String> {
    let RecoveryAction::Press(station, _) = step.action else { return None };
    let waits = &client.station(station)?.blocked_by;
    waits.iter().find(|why| why.contains("agreement") || why.starts_with("interlock")).cloned()
}
