//! `linewright recover`: what an operator has to do until the line is in auto again, from what is heard of it now.
//!
//! The plan is made anew whenever the line has changed. What was the first step before and is none any more is shown as done.

mod json;
mod newest;
mod parts;
mod progress;
mod publish;
mod service;
mod shown;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args as ClapArgs;
use linewright_console_view::refusal;
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_msgs::{LineState, StationState};
use linewright_node_line::mode_from_code;
use linewright_node_shell::RosArgs;
use linewright_recovery::{LedBack, Need, RecoveryAction, RecoveryPlan, RecoveryStep};

use crate::cell::CellClient;
use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::watch::{Screen, next_of};
use json::RecoveryJson;
pub use newest::NewestPlan;
use newest::ReasonedPlan;
use progress::{DoneSteps, PressFailures};
use shown::ShownList;

/// Time within which all are to be received.
const HEARD_WITHIN: Duration = Duration::from_secs(5);
/// Period of the picture, and of the look at what has changed.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// Show what has to be done until the line is in auto again.
#[derive(Debug, ClapArgs)]
#[command(
    after_help = "Each line is one thing to do: a command, a button to hold at the panel of a station, a position to confirm, or what no command does. It moves nothing by itself. The plan is made anew after every change; it ends when auto is in force, at once where it is already: with --wait it waits for a fault first."
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
    /// Where auto is in force, wait for a fault, until Ctrl-C; then show the plan until auto is in force again.
    #[arg(long, conflicts_with_all = ["once", "json", "publish"])]
    wait: bool,
    /// Lead this station on where it could be led back as well; may be given several times.
    #[arg(long, value_name = "STATION")]
    on: Vec<String>,
}

/// `linewright recover`
pub async fn run(args: Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    let lead_on: Vec<StationId> = args.on.iter().map(|name| load::station(&line, name)).collect::<Result<_, _>>()?;
    let mut newest = NewestPlan::leading_on(lead_on);
    let mut client = OperatorClient::open(&line, &args.line, ros, "recover")?;
    let mut cell = is_cell.then(|| CellClient::open(&line, ros, "recover_cell")).transpose()?;
    if args.publish {
        return publish::run(&mut client, cell, newest, &args.line.display().to_string()).await;
    }
    let path = args.line.display().to_string();
    // Without a sound description of the cell each station that is left out is named.
    let described = load::cell_of(&args.line, &line).ok().flatten();
    let stations = described.map_or_else(Vec::new, |cell| service::stations_of(&cell));
    let place = PlanPlace { path: &path, stations: &stations };
    let is_all = match client.until_all_heard(HEARD_WITHIN).await {
        Err(error) if args.json => {
            crate::out::json(&RecoveryJson::of(&client, &path, None))?;
            return Err(error);
        }
        heard => heard?,
    };
    if let Some(cell) = cell.as_mut().filter(|_| client.coordinator().is_some()) {
        cell.until_heard(HEARD_WITHIN).await?;
    }
    if args.once || args.json {
        client.listen(line.timing.refresh * 4).await?;
        newest.settle(&mut client, &mut cell).await?;
        let found = newest.look(&client, cell.as_ref());
        if args.json {
            crate::out::json(&RecoveryJson::of(&client, &path, found))?;
        } else {
            crate::out::say!("{}", picture(&client, cell.as_ref(), &place, &PictureOf::once(found)).lines().join("\n"));
        }
        let leads_there = found.is_some_and(|found| found.plan.leads_to_auto());
        if let Some(searched) = newest.searching() {
            crate::out::complain!(
                "no list within {} s: the states that it follows from keep changing, or the search takes longer. Try again; what changes is shown by {}",
                searched.as_secs(),
                typed_words(&["watch", &path].map(str::to_owned)),
            );
        }
        if !is_all {
            let coordinator = client.coordinator().is_none().then_some("the coordinator");
            let missing: Vec<&str> = coordinator.into_iter().chain(client.unheard()).collect();
            crate::out::complain!("not heard within {} s: {}", HEARD_WITHIN.as_secs(), missing.join(", "));
        }
        return Ok(if is_all && leads_there { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    follow(&mut client, cell, newest, &place, args.wait).await
}

/// How long the plan before stays shown while another one is searched for; after it the list has a line that a search is going on.
const SHOWN_AFTER: Duration = Duration::from_secs(1);

/// Shows the plan until auto is in force; with `waits`, until it is again after a fault.
async fn follow(
    client: &mut OperatorClient,
    mut cell: Option<CellClient>,
    mut newest: NewestPlan,
    place: &PlanPlace<'_>,
    mut waits: bool,
) -> miette::Result<ExitCode> {
    let mut screen = if std::io::stdout().is_terminal() { Some(Screen::open()?) } else { None };
    let mut interrupts = Interrupts::listen()?;
    let mut looks = tokio::time::interval(LOOK_EVERY);
    let (mut done, mut shown, mut failures) = (DoneSteps::default(), ShownList::default(), PressFailures::default());
    let (mut has_changed, mut is_at_once) = (true, true);
    loop {
        tokio::select! {
            heard = client.next() => has_changed |= !matches!(heard?, StateUpdate::Event(..)),
            heard = next_of(&mut cell) => {
                heard?;
                has_changed = true;
            }
            _ = looks.tick() => if std::mem::take(&mut has_changed) {
                let found = newest.look(client, cell.as_ref()).cloned();
                let is_searching = newest.searching().is_some();
                if let Some(searching) = newest.searching() {
                    has_changed = true;
                    if searching < SHOWN_AFTER || shown.is_searching() {
                        continue;
                    }
                }
                if let Some(found) = &found {
                    done.note(client.line(), &found.plan);
                }
                let next = found.as_ref().and_then(|found| found.plan.steps.get(found.plan.behind_signals()?));
                failures.note(next, |id| newest.moves(id), |id| client.station(id).is_some_and(comes_again));
                let commands = if screen.is_some() { Commands::First } else { Commands::AllAgain };
                let of = PictureOf { done: done.texts(), found: found.as_ref(), commands, failed: failures.count() };
                let mut now = picture(client, cell.as_ref(), place, &of);
                let is_done = found.as_ref().is_some_and(ReasonedPlan::is_done);
                if is_done && waits {
                    now.tail.push("waits for a fault, until Ctrl-C".to_owned());
                }
                if is_searching {
                    // Of a printed list the steps stay what the next one is compared with.
                    let steps = if screen.is_none() { shown.steps.clone() } else { Vec::new() };
                    now.search(steps);
                }
                match &mut screen {
                    Some(screen) => screen.show(&now.lines())?,
                    None => {
                        let new = now.changes(&shown);
                        if !new.is_empty() {
                            crate::out::say!("{}\n", new.join("\n"));
                        }
                    }
                }
                shown = now;
                if is_done && !waits {
                    drop(screen);
                    crate::out::say!("{}", if is_at_once { nothing_to_recover(place.path) } else { "auto is in force".to_owned() });
                    return Ok(ExitCode::SUCCESS);
                }
                if let Some(found) = found.filter(|_| !is_done) {
                    is_at_once = false;
                    waits &= !client.coordinator().is_some_and(|state| is_fault(state, &found.plan));
                }
            },
            () = interrupts.next() => return Ok(ExitCode::FAILURE),
        }
    }
}

/// Whether a plan that leads somewhere is for a fault, by the coordinator's state: one for a station that is not received here alone is
/// none, since messages may be lost on the way.
fn is_fault(state: &LineState, plan: &RecoveryPlan) -> bool {
    let is_auto = mode_from_code(state.mode).is_ok_and(|mode| mode == ControlMode::Auto);
    !is_auto || !state.left_out.is_empty() || plan.has_alarms()
}

/// Text for a line in which auto was in force when the command was started.
fn nothing_to_recover(path: &str) -> String {
    let wait = typed_words(&["recover", path, "--wait"].map(str::to_owned));
    format!("auto is in force, so there is nothing to recover; `{wait}` waits for a fault and lists then what to do")
}

/// The arguments of each command for a step, for a line in the directory `path`.
fn commands(line: &Line, path: &str, step: &RecoveryStep) -> Vec<Vec<String>> {
    let named = |word: String| if word == "LINE" { path.to_owned() } else { word };
    step.commands(line).into_iter().map(|words| words.into_iter().map(named).collect()).collect()
}

/// The commands for a step as they are typed; for devices that are lost the one that shows which and why.
fn typed(line: &Line, path: &str, step: &RecoveryStep) -> Vec<String> {
    let is_lost = matches!(step.action, RecoveryAction::First(Need::Devices(_) | Need::Console));
    let shows = is_lost.then(|| ["can", "status", path].map(str::to_owned).to_vec());
    let all = commands(line, path, step).into_iter().chain(shows);
    // What is only looked at does not do the step.
    let look = if is_lost { "see: " } else { "" };
    all.map(|of| format!("{look}{}", typed_words(&of))).collect()
}

/// The arguments of the command that lists the other way of a station that is led back, for a line in the directory `path`.
fn led_on(line: &Line, path: &str, back: &LedBack) -> Vec<String> {
    ["recover", path, "--on", &line.station(back.station).name].map(str::to_owned).to_vec()
}

fn typed_words(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(|word| crate::out::shell_word(word)).collect();
    format!("linewright {}", words.join(" "))
}

/// The steps below which their commands stand.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Commands {
    /// Of a picture that is drawn again after each step.
    First,
    All,
    /// Of a list that is printed again whenever it is another one.
    AllAgain,
}

/// Known causes, by station.
fn causes<'a>(
    line: &'a Line,
    state: impl Fn(StationId) -> Option<&'a StationState>,
) -> Vec<(&'a str, &'a StationState)> {
    let named = |id| Some((line.station(id).name.as_str(), state(id).filter(|state| !state.fault.is_empty())?));
    line.station_ids().filter_map(named).collect()
}

/// Whether what led to a station's fault leads to it again if it is not removed. A stop by command or by a restart, with or without its
/// journal, does not, nor do devices that are there again.
fn comes_again(state: &StationState) -> bool {
    let by_itself = |code: &u8| match *code {
        StationState::CAUSE_RESTART
        | StationState::CAUSE_RELEASED
        | StationState::CAUSE_ESTOP
        | StationState::CAUSE_ORDERED
        | StationState::CAUSE_NOT_AT_HOME => false,
        StationState::CAUSE_DEVICES => !state.devices_valid,
        _ => true,
    };
    state.position_lost || state.stop_causes.iter().any(by_itself)
}

/// Whether a station was stopped by lost devices alone, which are there again.
fn is_over_again(state: &StationState) -> bool {
    state.stop_causes.contains(&StationState::CAUSE_DEVICES) && state.devices_valid && !comes_again(state)
}

/// The causes, with what is to be done about them before the next motion. `signals_off`: stations that a fault signal has stopped which
/// is off now: its cause may be there still.
fn cause_lines(line: &Line, causes: &[(&str, &StationState)], signals_off: &[StationId]) -> Vec<String> {
    const STILL_SO: &str =
        "       first put right what still causes it: otherwise the next motion ends in the same fault";
    const OFF: &str = "       look at the mechanism: the signal has gone off; its cause may still be there";
    let is_off = |name: &str| line.station_named(name).is_some_and(|id| signals_off.contains(&id));
    let lines_of = |&(station, state): &(&str, &StationState)| {
        let over = if is_over_again(state) { " (over: they are there again)" } else { "" };
        let cause = format!("cause: {station}: {}{over}", state.fault);
        std::iter::once(cause).chain(is_off(station).then(|| OFF.to_owned()))
    };
    let mut lines: Vec<String> = causes.iter().flat_map(lines_of).collect();
    if causes.iter().any(|(station, state)| comes_again(state) && !is_off(station)) {
        lines.push(STILL_SO.to_owned());
    }
    lines
}

/// What a plan is for.
struct PlanPlace<'p> {
    /// The directory of the line or cell, or its description file.
    path: &'p str,
    /// The station of each resource of a cell.
    stations: &'p [(String, String)],
}

/// What a picture shows.
struct PictureOf<'p> {
    /// Steps that were done.
    done: &'p [String],
    found: Option<&'p ReasonedPlan>,
    commands: Commands,
    /// How often the press that is the first step has failed.
    failed: u32,
}

impl<'p> PictureOf<'p> {
    /// The plan by itself.
    fn once(found: Option<&'p ReasonedPlan>) -> Self {
        PictureOf { done: &[], found, commands: Commands::All, failed: 0 }
    }
}

/// The plan as lines of text.
fn picture(client: &OperatorClient, cell: Option<&CellClient>, place: &PlanPlace<'_>, of: &PictureOf<'_>) -> ShownList {
    let (line, path, &PictureOf { done, found, commands, failed }) = (client.line(), place.path, of);
    let cell = cell.and_then(CellClient::heard_lately);
    let mut head = match client.coordinator() {
        Some(state) => vec![format!("{} — mode: {}", line.title, state.text)],
        None => vec![format!("{}: no state received from the coordinator: start it", line.title)],
    };
    head.extend(client.coordinator().and_then(|state| match commands {
        Commands::AllAgain if state.refusal.is_empty() => None,
        // Without its age, which makes no other list.
        Commands::AllAgain => Some(format!("last refusal: {}", state.refusal)),
        Commands::First | Commands::All => refusal(state),
    }));
    let is_over = found.is_some_and(ReasonedPlan::is_done);
    let causes = if is_over { Vec::new() } else { causes(line, |id| client.station(id)) };
    head.extend(cause_lines(line, &causes, found.map_or(&[], |found| &found.signals_off)));
    head.extend(done.iter().map(|text| format!(" done  {text}")));
    head.extend(client.other_descriptions());
    let (mut steps, mut tail) = (Vec::new(), Vec::new());
    let Some(found) = found else { return ShownList { head, steps, tail } };
    let (plan, next) = (&found.plan, found.plan.behind_signals());
    head.extend(parts::lines(plan, cell));
    head.extend(plan.led.iter().map(|led| led.text(line)));
    head.extend(plan.begin_text(line));
    head.extend(plan.led_back.iter().flat_map(|back| {
        let other_way = back.presses_on.map(|_| format!("   other way: {}", typed_words(&led_on(line, path, back))));
        std::iter::once(back.text(line)).chain(other_way)
    }));
    for (at, (step, why)) in plan.steps.iter().zip(&found.reasons).enumerate() {
        let mut lines = vec![step.text(line)];
        lines.extend(why.iter().map(|why| format!("       since {why}")));
        lines.extend(lost_devices(client, step).map(|what| format!("       {what}")));
        let failed = if Some(at) == next { failed_again(client, (step, found.returns_home), failed) } else { None };
        if failed.is_none() && (at == 0 || commands != Commands::First) {
            // Of several places each stands below the command that confirms it.
            let mut stands = step.stands(line).into_iter();
            lines.extend(typed(line, path, step).into_iter().flat_map(|typed| {
                let stands = stands.next().map(|stands| format!("         if it stands so: {stands}"));
                std::iter::once(format!("       {typed}")).chain(stands)
            }));
        }
        lines.extend(failed.map(|why| format!("       {why}")));
        if at == 0 {
            lines.extend(refused(client, step).map(|why| format!("       refused: {why}")));
        }
        steps.push(lines);
    }
    tail.extend(plan.end_text(line));
    tail.extend(plan.shorter_text().map(str::to_owned));
    let down = cell.map_or(&[][..], |cell| cell.down.as_slice());
    if is_over {
        tail.push("nothing to do".to_owned());
        let left_out = client.coordinator().map_or(&[][..], |state| state.left_out.as_slice());
        tail.extend(service::left_out(path, left_out, down, place.stations));
    }
    tail.extend(service::out_of_service(path, down));
    ShownList { head, steps, tail }
}

/// What stands in place of the command of a press that has failed twice: the cause.
fn failed_again(client: &OperatorClient, (step, returns_home): (&RecoveryStep, bool), failed: u32) -> Option<String> {
    let id = step.action.station()?;
    let way_home = returns_home.then(|| client.line().station(id).name.as_str());
    progress::instead_of_again(failed, &client.station(id)?.fault, way_home)
}

/// Lost devices with their diagnostics, as the station reports them; none of a step that waits for no devices of a station.
fn lost_devices(client: &OperatorClient, step: &RecoveryStep) -> Option<String> {
    let RecoveryAction::First(Need::Devices(station)) = step.action else { return None };
    let waits = &client.station(station)?.blocked_by;
    waits.iter().find(|why| why.contains("I/O devices: ")).cloned()
}

/// Missing agreement or interlock of a press, as the station reports it.
fn refused(client: &OperatorClient, step: &RecoveryStep) -> Option<String> {
    let RecoveryAction::Press(station, _) = step.action else { return None };
    let waits = &client.station(station)?.blocked_by;
    waits.iter().find(|why| why.contains("agreement") || why.starts_with("interlock")).cloned()
}

#[cfg(test)]
mod tests {
    use linewright_coordinator_cell::texts::ListedAnswer;
    use linewright_node_line::mode_to_code;
    use linewright_recovery::{RecoveryEnd, StandingAlarm};

    use super::*;
    use linewright_coordinator_logic::ModeCommand;
    use linewright_line::TransferLine;

    fn line() -> Line {
        linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line
    }

    fn step(action: RecoveryAction) -> RecoveryStep {
        RecoveryStep { action, moves: Vec::new(), mode: ControlMode::StandBy, after: None, is_doubtful: false }
    }

    #[test]
    fn a_command_can_be_pasted_into_a_shell() {
        let auto = step(RecoveryAction::Command(ModeCommand::Auto));
        let typed = |path: &str, step: &RecoveryStep| typed(&line(), path, step).join("\n");
        assert_eq!(typed("my-line", &auto), "linewright mode my-line auto");
        assert_eq!(typed("my line", &auto), "linewright mode \"my line\" auto");
        assert_eq!(typed("l$x", &auto), "linewright mode \"l\\$x\" auto");
        let lost = step(RecoveryAction::First(Need::Devices(StationId(1))));
        assert_eq!(typed("my line", &lost), "see: linewright can status \"my line\"");
    }

    #[test]
    fn of_several_answers_each_has_its_command() {
        let alarm = StandingAlarm {
            id: 3,
            text: "M1 failed.".to_owned(),
            answers: ["as-done", "as-before"].map(ListedAnswer::from).to_vec(),
            lead: Vec::new(),
            reset: Vec::new(),
            at_order: Vec::new(),
            end: None,
            bring: None,
        };
        let answer = step(RecoveryAction::First(Need::Answer(alarm)));
        assert_eq!(typed(&line(), "l", &answer), ["linewright answer l 3 as-done", "linewright answer l 3 as-before"]);
    }

    /// A message that is lost on the way to this command ends no waiting.
    #[test]
    fn a_station_that_is_not_received_here_alone_is_no_fault() {
        let unheard =
            RecoveryPlan::ends(vec![step(RecoveryAction::First(Need::Heard(StationId(1))))], RecoveryEnd::Auto);
        let state = |mode| LineState { mode: mode_to_code(mode), ..LineState::default() };
        assert!(!is_fault(&state(ControlMode::Auto), &unheard));
        assert!(is_fault(&state(ControlMode::StandBy), &unheard));
        let left_out = vec!["clamp_1".to_owned()];
        assert!(is_fault(&LineState { left_out, ..state(ControlMode::Auto) }, &unheard));
    }

    #[test]
    fn a_plan_begins_with_the_causes_that_are_known() {
        let line = line();
        let fault = "LS_open and LS_closed are both on: check both switches and the mechanism";
        let broken = StationState { fault: fault.to_owned(), ..StationState::default() };
        let well = StationState::default();
        let state = |id| match id {
            StationId(0) => None,
            StationId(1) => Some(&broken),
            _ => Some(&well),
        };
        let name = line.stations[1].name.as_str();
        assert_eq!(causes(&line, state), [(name, &broken)]);
        assert!(!comes_again(&broken));
        for (code, again) in [(StationState::CAUSE_RESTART, false), (StationState::CAUSE_SIGNAL, true)] {
            let stopped = StationState { stop_causes: vec![code], ..broken.clone() };
            let state = |id| (id == StationId(1)).then_some(&stopped);
            assert_eq!(causes(&line, state), [(name, &stopped)]);
            assert_eq!(comes_again(&stopped), again);
        }
        let stopped = StationState { stop_causes: vec![StationState::CAUSE_SIGNAL], ..broken.clone() };
        let [cause, advice] = &cause_lines(&line, &[(name, &stopped)], &[])[..] else { panic!("two lines") };
        assert_eq!(cause, &format!("cause: {name}: {fault}"));
        assert!(advice.contains("first put right what still causes it"), "{advice}");
        let off = cause_lines(&line, &[(name, &stopped)], &[StationId(1)]);
        let advice = "       look at the mechanism: the signal has gone off; its cause may still be there";
        assert_eq!(off, [cause.as_str(), advice]);
        let lost = StationState { stop_causes: vec![StationState::CAUSE_DEVICES], ..broken.clone() };
        assert!(comes_again(&lost) && !is_over_again(&lost));
        let there = StationState { devices_valid: true, ..lost };
        assert!(!comes_again(&there) && is_over_again(&there));
    }
}
