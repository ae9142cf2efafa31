//! The operator's commands: `mode`, `press` and `rejoin`.
//!
//! Each does once, from a shell, what a console does with a finger. The answer is printed: what the line did, or why
//! it refused, with exit code 1.

mod held;
mod in_force;
mod rejoin;
mod resume;
mod single;
mod standstill;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_console_view::{HAND_ONLY, PANEL_ONLY, PUBLISH_EVERY, RESUME, stations_of};
use linewright_coordinator_logic::{ModeCommand, OperatorCommand};
use linewright_line::{ButtonId, Line, StationId};
use linewright_msgs::{Flag, LineState, StationState, Text};
use linewright_node_shell::RosArgs;
use miette::miette;

pub use held::HeldMotions;
pub use rejoin::{RejoinArgs, rejoin};

use crate::client::OperatorClient;
use crate::load;
use crate::states::{ModeJson, StationJson, mode_name};

/// Most time until a line is received.
const CONNECT: Duration = Duration::from_secs(5);
/// Most time for an answer: several refresh periods.
const ANSWER: Duration = Duration::from_millis(500);
/// Most time until a mode that was given is in force at every station.
const MODE: Duration = Duration::from_secs(1);
/// Period at which a held button is repeated: well within the time after which it counts as released.
const REPEAT: Duration = PUBLISH_EVERY;
/// Periods for which a station has to stand at the end of what was led: one button may lead one operation after another.
const ARRIVED: u32 = 8;

/// Give an operator's command.
#[derive(Debug, Args)]
pub struct ModeArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Mode command: start, stop, auto, hand, manual, estop or reset [default: show the mode].
    command: Option<String>,
    /// With stop: return when nothing moves any more, at home or in stand-by. Manual follows from both.
    #[arg(long)]
    wait: bool,
    /// With manual or auto: for this station of a cell alone, while the others are in auto.
    #[arg(long)]
    station: Option<String>,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// `linewright mode`
pub async fn mode(args: ModeArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let command = match &args.command {
        Some(word) => Some(ModeCommand::parse(word).ok_or_else(|| {
            let known = ModeCommand::ALL.map(ModeCommand::name);
            load::or_meant(miette!("unknown command '{word}'; commands: {}", known.join(", ")), word, known)
        })?),
        None => None,
    };
    if args.wait && command != Some(ModeCommand::Stop) {
        let line = crate::out::shell_word(&args.line.display().to_string());
        let text = format!("--wait goes with stop: linewright mode {line} stop --wait");
        return Err(load::WrongArgument::new(text).into());
    }
    let single = args.station.as_deref().map(|name| single::meant(&line, name, command)).transpose()?;
    let mut client = OperatorClient::open(&line, &args.line, ros, "operator")?;
    client.until_connected(CONNECT).await?;
    let mut is_so = false;
    if let Some(command) = command {
        let refusals = client.coordinator().map_or(0, |state| state.refusals);
        let known = client.coordinator().filter(|_| single.is_none());
        let before = known.and_then(|state| in_force::already(state, command));
        // Obeyed, and nothing comes of it.
        is_so = before.is_some() && known.is_some_and(|state| in_force::is_idle(state, command));
        let words = single.map_or(command.name().to_owned(), |single| single.words(&line));
        client.command(&words);
        let deadline = tokio::time::Instant::now() + ANSWER;
        while let Ok(heard) = tokio::time::timeout_at(deadline, client.next()).await {
            heard?;
            if let Some(state) = client.coordinator().filter(|state| is_refused(state, &words, refusals)) {
                is_so = before == Some(state.epoch);
                if is_so {
                    break;
                }
                crate::out::complain!("{}", state.refusal);
                // What stands by already, or is at home, has nothing to stop.
                if args.wait && matches!(state.mode, StationState::MODE_STANDBY | StationState::MODE_HOME) {
                    break;
                }
                if args.json {
                    crate::out::json(&ModeJson::of(state))?;
                }
                return Ok(ExitCode::FAILURE);
            }
        }
    }
    let has_stopped = if args.wait { standstill::until_stopped(&mut client).await? } else { true };
    let missed = match command {
        Some(_) if single.is_some() => single::until_in_force(&mut client, single).await?,
        Some(command) if !args.wait => in_force::until_in_force(&mut client, command).await?,
        _ => None,
    };
    let state = client.coordinator();
    match state {
        Some(state) if args.json => crate::out::json(&ModeJson::of(state))?,
        Some(state) => crate::out::say!("{}", state.text),
        None => crate::out::complain!("no state received from the coordinator"),
    }
    if is_so && missed.is_none() {
        let name = command.map_or("it", ModeCommand::name);
        crate::out::complain!("{name}: so it was already, nothing has changed");
    }
    if let Some(why) = &missed {
        crate::out::complain!("{why}");
    }
    Ok(if state.is_some() && has_stopped && missed.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Whether this command was refused after the coordinator had counted so many refusals. A refusal of another console's command is
/// none, unless it is the same command.
fn is_refused(state: &LineState, words: &str, refusals: u64) -> bool {
    state.refusals > refusals && state.refused == words
}

/// Buttons and positions of the selector at the panel of a station.
const PANEL: [&str; 4] = ["advance", "return", "manual", "auto"];

/// Hold buttons for a while.
#[derive(Debug, Args)]
#[command(
    after_help = "Without --station, BUTTON is a hand-mode push button of the main console (PB_2), or resume: in manual, while it is held, every operation that was stopped before its end goes on. With it, BUTTON is advance or return, held, or manual or auto, which turns the station's selector."
)]
pub struct PressArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Buttons to press.
    #[arg(required = true)]
    buttons: Vec<String>,
    /// Station whose panel has the buttons.
    #[arg(long)]
    station: Option<String>,
    /// Time to hold them, in seconds: above 0, up to 3600.
    #[arg(long = "for", default_value_t = 1.0, value_parser = held_for)]
    seconds: f64,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

fn held_for(word: &str) -> Result<f64, String> {
    let seconds = word.parse().ok().filter(|seconds| *seconds > 0.0 && *seconds <= 3600.0);
    seconds.ok_or_else(|| "expected seconds above 0, up to 3600, without a unit, e.g. 0.8".to_owned())
}

/// `linewright press`
pub async fn press(args: PressArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    match &args.station {
        Some(station) => press_panel(&line, &args, station, ros).await,
        None if args.buttons == [RESUME] && !line.buttons.iter().any(|name| name == RESUME) => {
            resume::press(&line, &args, ros).await
        }
        None => press_console(&line, &args, ros).await,
    }
}

async fn press_console(line: &Line, args: &PressArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    if let Some(unknown) = args.buttons.iter().find(|name| !line.buttons.contains(name)) {
        let stations: Vec<&str> = line.stations.iter().map(|station| station.name.as_str()).collect();
        let known = line.buttons.join(", ");
        return Err(match PANEL.contains(&unknown.as_str()) {
            true => miette!(
                help = format!("--station NAME, of {}", stations.join(", ")),
                "'{unknown}' is at the panel of a station, and no station is named; buttons of the main console are {known}"
            ),
            false => miette!("'{unknown}' is no button of the main console; it has {known}"),
        });
    }
    let mut client = OperatorClient::open(line, &args.line, ros, "operator")?;
    client.until_connected(CONNECT).await?;
    let names = args.buttons.join(" ");
    let pressed =
        |name: &String| line.buttons.iter().position(|known| known == name).and_then(|at| u16::try_from(at).ok());
    let ids: Vec<ButtonId> = args.buttons.iter().filter_map(pressed).map(ButtonId).collect();
    let stations = stations_of(line, &ids);
    if let Err(mode) = until_mode(&mut client, stations[0], StationState::MODE_HAND).await? {
        let why = format!("{HAND_ONLY} {mode}");
        return answer(&client, args, &stations, PressOutcome::Refused(why));
    }
    let say = |client: &OperatorClient, held| client.hold(if held { &names } else { "" });
    let before = client.coordinator().map_or(0, |state| state.refusals);
    let outcome = hold(&mut client, (args.seconds, false), &stations, say).await?;
    // After `Obeyed` a refusal was of a later message.
    let refused = client
        .coordinator()
        .filter(|state| is_refused(state, OperatorCommand::Buttons.name(), before) && outcome != PressOutcome::Obeyed);
    let outcome = refused.map_or(outcome, |state| PressOutcome::Refused(state.refusal.clone()));
    answer(&client, args, &stations, outcome)
}

async fn press_panel(line: &Line, args: &PressArgs, station: &str, ros: &RosArgs) -> miette::Result<ExitCode> {
    let id = load::station(line, station)?;
    let [button] = args.buttons.as_slice() else {
        return Err(miette!("one button of a panel at a time: advance, return, manual or auto"));
    };
    let mut client = OperatorClient::open(line, &args.line, ros, "operator")?;
    let outcome = match button.as_str() {
        "advance" | "return" => {
            let publisher = client.panel_button(id, button)?;
            client.until_connected(CONNECT).await?;
            match until_mode(&mut client, id, StationState::MODE_MANUAL).await? {
                Err(mode) => PressOutcome::Refused(no_manual(client.coordinator(), args, station, mode)),
                Ok(()) => {
                    let say = |_: &OperatorClient, held| publisher.send(Flag { data: held });
                    hold(&mut client, (args.seconds, true), &[id], say).await?
                }
            }
        }
        "manual" | "auto" => {
            let publisher = client.panel_selector(id)?;
            client.until_connected(CONNECT).await?;
            publisher.send(Text::from(button.as_str()));
            client.listen(ANSWER).await?;
            let stands = client.station(id).map(|state| if state.selector_manual { "manual" } else { "auto" });
            let stays = stands.filter(|stands| stands != button);
            stays.map_or(PressOutcome::Obeyed, |stands| {
                PressOutcome::Refused(format!("the selector stays at {stands}: its wired switch stands there"))
            })
        }
        other => return Err(miette!("'{other}' is not on a panel; it has advance, return, manual and auto")),
    };
    answer(&client, args, &[id], outcome)
}

/// Why a station is not in manual. In an emergency stop of its own no command to the line leads there.
fn no_manual(line: Option<&LineState>, args: &PressArgs, station: &str, mode: &str) -> String {
    let of_its_own =
        mode == mode_name(StationState::MODE_ESTOP) && line.is_some_and(|line| line.mode != StationState::MODE_ESTOP);
    if of_its_own {
        let cell = crate::out::shell_word(&args.line.display().to_string());
        return format!(
            "{station} is in an emergency stop of its own; clear the cause, then give `linewright resource {cell} {station} reset`"
        );
    }
    format!("{PANEL_ONLY} {mode}")
}

/// Waits until a mode is in force at a station: it may have been given a moment ago. The error is the mode that is.
async fn until_mode(
    client: &mut OperatorClient,
    station: StationId,
    mode: u8,
) -> miette::Result<Result<(), &'static str>> {
    let deadline = tokio::time::Instant::now() + MODE;
    loop {
        let now = client.station(station).map(|state| state.mode);
        if now == Some(mode) {
            return Ok(Ok(()));
        }
        if tokio::time::Instant::now() >= deadline {
            return Ok(Err(now.map_or("unknown: no state received", mode_name)));
        }
        client.listen(REPEAT).await?;
    }
}

/// What has become of a press.
#[derive(Debug, PartialEq, Eq)]
enum PressOutcome {
    Obeyed,
    /// It has moved nothing; why.
    Refused(String),
    /// It has moved something that ended in a fault.
    Fault(String),
    /// It was let go before a motion had ended; which, and where it is to be looked.
    LetGo(String),
}

/// State that changes with every motion that starts: places, cycles started, cycles done, and whether something moves: a hand-mode
/// motion that goes on changes no place, and the homing of a drive at a rest marks none.
type Motions = Vec<Option<(Vec<u8>, Vec<i32>, Vec<i32>, bool)>>;

fn motions(client: &OperatorClient, stations: &[StationId]) -> Motions {
    let of =
        |state: &StationState| (state.places.to_vec(), state.started.to_vec(), state.done.to_vec(), !state.stopped);
    stations.iter().map(|id| client.station(*id).map(of)).collect()
}

/// Why a button that was held has moved nothing.
fn refusal(client: &OperatorClient, stations: &[StationId]) -> String {
    let why = |id: &StationId| {
        let name = &client.line().station(*id).name;
        match client.station(*id) {
            Some(state) => format!("{name} waits for {}", state.blocked_by.join("; ")),
            None => format!("no state received from {name}"),
        }
    };
    stations.iter().map(why).collect::<Vec<_>>().join("\n")
}

/// Prints what has become of a press.
fn answer(
    client: &OperatorClient,
    args: &PressArgs,
    stations: &[StationId],
    outcome: PressOutcome,
) -> miette::Result<ExitCode> {
    let buttons = args.buttons.join(" ");
    let is_heard = stations.iter().all(|id| client.station(*id).is_some());
    let is_obeyed = outcome == PressOutcome::Obeyed;
    let (refusal, fault, let_go) = match outcome {
        PressOutcome::Obeyed => (None, None, None),
        PressOutcome::Refused(why) => (Some(why), None, None),
        PressOutcome::Fault(what) => (None, Some(what), None),
        PressOutcome::LetGo(what) => (None, None, Some(what)),
    };
    if let Some(why) = &refusal {
        crate::out::complain!("{buttons} refused: {why}");
    }
    if let Some(what) = &fault {
        crate::out::complain!("{buttons} ended in a fault: {what}");
    }
    if let Some(what) = &let_go {
        crate::out::complain!("{buttons} let go before the end: {what}");
    }
    if args.json {
        let name = |id: &StationId| &client.line().station(*id).name;
        let states: Vec<_> = stations.iter().map(|id| StationJson::of(name(id), client.station(*id))).collect();
        let object = serde_json::json!({
            "buttons": args.buttons, "refusal": refusal, "fault": fault, "let_go": let_go, "stations": states,
        });
        crate::out::json(&object)?;
    } else if refusal.is_none() {
        stations.iter().for_each(|id| print_station(client, *id));
    }
    // Whether a station that is not received has obeyed is unknown.
    Ok(if is_obeyed && is_heard { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Sends "released", then "held" repeatedly for so many seconds, then "released", and receives what follows.
/// Gives what has moved meanwhile: a motion that was let go half-way stands at the end as it stood before. A button that leads
/// one motion is released at its end (`until_arrival`).
async fn hold(
    client: &mut OperatorClient,
    (seconds, until_arrival): (f64, bool),
    stations: &[StationId],
    say: impl Fn(&OperatorClient, bool),
) -> miette::Result<PressOutcome> {
    // The release of an earlier press may have been lost, and silence is no release.
    release(client, &say).await?;
    let before = motions(client, stations);
    let mut moved = vec![false; stations.len()];
    let mut held: Vec<HeldMotions> = stations.iter().map(|id| HeldMotions::before(client.station(*id))).collect();
    let until = tokio::time::Instant::now() + Duration::from_secs_f64(seconds);
    let mut arrived = 0;
    while tokio::time::Instant::now() < until && arrived < ARRIVED {
        say(client, true);
        client.listen(REPEAT.min(until - tokio::time::Instant::now())).await?;
        follow(&mut moved, &before, &motions(client, stations));
        held.iter_mut().zip(stations).for_each(|(held, id)| held.look(client.station(*id)));
        let has_arrived =
            held.iter().zip(stations).all(|(held, id)| client.station(*id).is_some_and(|of| held.has_arrived(of)));
        arrived = if has_arrived && until_arrival { arrived + 1 } else { 0 };
    }
    release(client, &say).await?;
    client.listen(ANSWER).await?;
    follow(&mut moved, &before, &motions(client, stations));
    held.iter_mut().zip(stations).for_each(|(held, id)| held.look(client.station(*id)));
    if !moved.contains(&true) {
        return Ok(PressOutcome::Refused(refusal(client, stations)));
    }
    let faults = stations.iter().zip(&moved).filter(|(_, moved)| **moved).filter_map(|(id, _)| {
        let fault = standing_fault(client.station(*id)?)?;
        Some(format!("{}: {fault}", client.line().station(*id).name))
    });
    let faults: Vec<String> = faults.collect();
    if !faults.is_empty() {
        return Ok(PressOutcome::Fault(faults.join("\n")));
    }
    let stopped = stations.iter().zip(&held).filter_map(|(id, held)| {
        let state = client.station(*id)?;
        let text = held.let_go(state)?;
        Some(format!("{}: {}; {text}", client.line().station(*id).name, state.operation))
    });
    let stopped: Vec<String> = stopped.collect();
    Ok(if stopped.is_empty() { PressOutcome::Obeyed } else { PressOutcome::LetGo(stopped.join("\n")) })
}

/// Notes the stations that stand otherwise than before.
fn follow(moved: &mut [bool], before: &Motions, now: &Motions) {
    for (moved, (before, now)) in moved.iter_mut().zip(before.iter().zip(now)) {
        *moved |= before != now;
    }
}

/// The fault that a station stands in. One that stands where it was sent has none, whatever it says of a switch.
fn standing_fault(state: &StationState) -> Option<&str> {
    let stands_in_it = !state.incomplete.is_empty() || state.position_lost;
    (stands_in_it && !state.fault.is_empty()).then_some(state.fault.as_str())
}

/// Sends "released" more than once: one message can get lost.
async fn release(client: &mut OperatorClient, say: impl Fn(&OperatorClient, bool)) -> miette::Result<()> {
    for _ in 0..3 {
        say(client, false);
        client.listen(REPEAT).await?;
    }
    Ok(())
}

fn print_station(client: &OperatorClient, id: StationId) {
    let name = &client.line().station(id).name;
    match client.station(id) {
        Some(state) if state.blocked_by.is_empty() => crate::out::say!("{name}: {}", state.operation),
        Some(state) => crate::out::say!("{name}: {}; waits for {}", state.operation, state.blocked_by.join("; ")),
        None => crate::out::say!("{name}: no state received"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_that_was_let_go_is_no_fault_and_one_that_its_watchdog_stopped_is() {
        let stands = |incomplete: &[u16], position_lost, fault: &str| {
            let fault = fault.to_owned();
            StationState { incomplete: incomplete.to_vec(), position_lost, fault, ..StationState::default() }
        };
        for (state, expected) in [
            (stands(&[2], false, ""), None),
            (stands(&[2], false, "press: watchdog"), Some("press: watchdog")),
            (stands(&[], true, "index in doubt"), Some("index in doubt")),
            (stands(&[], false, "press: done by LS_up off alone"), None),
        ] {
            assert_eq!(standing_fault(&state), expected);
        }
    }
}
