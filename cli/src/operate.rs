//! The operator's commands: `mode` and `press`.
//!
//! Each does once, from a shell, what a console does with a finger. The answer is printed: what the line did, or why
//! it refused.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::{Line, StationId};
use linewright_msgs::{Flag, Text};
use linewright_node_shell::RosArgs;
use miette::miette;

use crate::client::OperatorClient;
use crate::load;

/// How long to wait for a line to be heard.
const CONNECT: Duration = Duration::from_secs(5);
/// How long an answer may take: several refresh periods.
const ANSWER: Duration = Duration::from_millis(500);
/// How often a held button is repeated: well within the time after which it counts as released.
const REPEAT: Duration = Duration::from_millis(50);

/// Give an operator's command.
#[derive(Debug, Args)]
pub struct ModeArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// start, stop, auto, hand, manual, estop or reset; none shows the mode.
    command: Option<String>,
}

/// `linewright mode`
pub async fn mode(args: ModeArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let command = match &args.command {
        Some(word) => Some(ModeCommand::parse(word).ok_or_else(|| {
            let known: Vec<&str> = ModeCommand::ALL.iter().map(|command| command.name()).collect();
            miette!("unknown command '{word}'; commands: {}", known.join(", "))
        })?),
        None => None,
    };
    let mut client = OperatorClient::open(&line, ros, "operator")?;
    client.until_connected(CONNECT).await?;
    if let Some(command) = command {
        let refusals = client.coordinator().map_or(0, |state| state.refusals);
        client.command(command.name());
        let deadline = tokio::time::Instant::now() + ANSWER;
        while let Ok(heard) = tokio::time::timeout_at(deadline, client.next()).await {
            heard?;
            if let Some(state) = client.coordinator()
                && state.refusals > refusals
            {
                crate::out::complain!("{}", state.refusal);
                return Ok(ExitCode::FAILURE);
            }
        }
    }
    crate::out::say!("{}", client.coordinator().map_or("no state received from the coordinator", |state| &state.text));
    Ok(ExitCode::SUCCESS)
}

/// Hold buttons for a while.
#[derive(Debug, Args)]
#[command(
    after_help = "Without --station, BUTTON is a hand-mode push button of the main console (PB_2). With it, BUTTON is advance or return, held, or manual or auto, which turns the station's selector."
)]
pub struct PressArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// What to press.
    #[arg(required = true)]
    buttons: Vec<String>,
    /// At this station's panel.
    #[arg(long)]
    station: Option<String>,
    /// How long to hold, in seconds.
    #[arg(long = "for", default_value_t = 1.0)]
    seconds: f64,
}

/// `linewright press`
pub async fn press(args: PressArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    if !(0.0..=3600.0).contains(&args.seconds) {
        return Err(miette!("--for {}: expected 0 to 3600 seconds", args.seconds));
    }
    match &args.station {
        Some(station) => press_panel(&line, &args, station, ros).await,
        None => press_console(&line, &args, ros).await,
    }
}

async fn press_console(line: &Line, args: &PressArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    if let Some(unknown) = args.buttons.iter().find(|name| !line.buttons.contains(name)) {
        return Err(miette!("'{unknown}' is no button; buttons are {}", line.buttons.join(", ")));
    }
    let mut client = OperatorClient::open(line, ros, "operator")?;
    client.until_connected(CONNECT).await?;
    let names = args.buttons.join(" ");
    hold(&mut client, args.seconds, |client, held| client.hold(if held { &names } else { "" })).await?;
    for id in line.station_ids() {
        print_station(&client, id);
    }
    Ok(ExitCode::SUCCESS)
}

async fn press_panel(line: &Line, args: &PressArgs, station: &str, ros: &RosArgs) -> miette::Result<ExitCode> {
    let id = load::station(line, station)?;
    let [button] = args.buttons.as_slice() else {
        return Err(miette!("one button of a panel at a time: advance, return, manual or auto"));
    };
    let mut client = OperatorClient::open(line, ros, "operator")?;
    match button.as_str() {
        "advance" | "return" => {
            let publisher = client.panel_button(id, button)?;
            client.until_connected(CONNECT).await?;
            hold(&mut client, args.seconds, |_, held| publisher.send(Flag { data: held })).await?;
        }
        "manual" | "auto" => {
            let publisher = client.panel_selector(id)?;
            client.until_connected(CONNECT).await?;
            publisher.send(Text::from(button.as_str()));
            client.listen(ANSWER).await?;
        }
        other => return Err(miette!("'{other}' is not on a panel; it has advance, return, manual and auto")),
    }
    print_station(&client, id);
    Ok(ExitCode::SUCCESS)
}

/// Confirm where a station stands.
#[derive(Debug, Args)]
#[command(
    after_help = "A station that started without its journal does not move. Check the machine first: this sets its marking from its limit switches. Between two switches, name the operation it was stopped in. Then lead all stations home in manual and give auto."
)]
pub struct RejoinArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// The station.
    station: String,
    /// The operation it was stopped in.
    #[arg(long, value_name = "OPERATION")]
    within: Option<String>,
}

/// `linewright rejoin`
pub async fn rejoin(args: RejoinArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let id = load::station(&line, &args.station)?;
    let station = line.station(id);
    if let Some(unknown) = args.within.as_ref().filter(|name| station.operation_named(name).is_none()) {
        let names: Vec<&str> = station.operations.iter().map(|operation| operation.name.as_str()).collect();
        return Err(miette!("unknown operation '{unknown}' of {}; operations: {}", station.name, names.join(", ")));
    }
    let mut client = OperatorClient::open(&line, ros, "operator")?;
    let publisher = client.rejoin(id)?;
    client.until_connected(CONNECT).await?;
    client.listen(ANSWER).await?;
    let before = client.station(id).map(|state| (state.places.clone(), state.fault.clone()));
    publisher.send(Text::from(args.within.as_deref().unwrap_or_default()));
    client.listen(ANSWER).await?;
    print_station(&client, id);
    let after = client.station(id).map(|state| (state.places.clone(), state.fault.clone()));
    if before == after {
        let state = client.station(id);
        let advice = state.and_then(|state| state.blocked_by.iter().find_map(|why| why.strip_prefix("rejoin: ")));
        let why = match (state, advice) {
            (None, _) => "no state received from the station".to_owned(),
            (Some(state), _) if !state.stopped => "rejected: station moving; rejoin needs standstill".to_owned(),
            (Some(_), None) => "no effect: station position already known, or its switches match no place".to_owned(),
            (Some(_), Some(advice)) => match &args.within {
                Some(op) => format!("its switches do not fit `{op}`: {advice}"),
                None => advice.to_owned(),
            },
        };
        crate::out::complain!("nothing changed: {why}");
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

/// Sends "released", then "held" repeatedly for so many seconds, then "released", and receives what follows.
async fn hold(client: &mut OperatorClient, seconds: f64, say: impl Fn(&OperatorClient, bool)) -> miette::Result<()> {
    // The release of an earlier press may have been lost, and silence is no release.
    release(client, &say).await?;
    let until = tokio::time::Instant::now() + Duration::from_secs_f64(seconds);
    while tokio::time::Instant::now() < until {
        say(client, true);
        client.listen(REPEAT.min(until - tokio::time::Instant::now())).await?;
    }
    release(client, &say).await?;
    client.listen(ANSWER).await
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
