//! Commands in words: a mode for the line, or manual and auto for one station of it.

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::CoordinatorArrival;
use linewright_line::{Line, suggestion};
use linewright_msgs::SetModeRequest as Request;
use linewright_node_line::quoted;

/// The command of these words: `auto`, or `manual robot` for the station of that name.
///
/// # Errors
/// What is unknown in it, and what is known.
pub fn command_of(line: &Line, words: &str) -> Result<CoordinatorArrival, String> {
    if let Some(command) = ModeCommand::parse(words) {
        return Ok(CoordinatorArrival::Command(command));
    }
    let known = || ModeCommand::ALL.map(ModeCommand::name).join(", ");
    let unknown = || format!("unknown command '{}'; commands: {}", quoted(words.trim()), known());
    let (word, station) = words.trim().split_once(char::is_whitespace).ok_or_else(unknown)?;
    let is_manual = match ModeCommand::parse(word) {
        Some(ModeCommand::Manual) => true,
        Some(ModeCommand::Auto) => false,
        Some(_) => {
            return Err(format!("'{}' is no command for one station; manual and auto are", quoted(words.trim())));
        }
        None => return Err(unknown()),
    };
    let name = station.trim();
    let id = line.station_named(name).ok_or_else(|| {
        let names = || line.stations.iter().map(|station| station.name.as_str());
        let all = || format!("stations: {}", names().collect::<Vec<_>>().join(", "));
        format!("no station '{}'; {}", quoted(name), suggestion(name, names()).unwrap_or_else(all))
    })?;
    Ok(CoordinatorArrival::Single(id, is_manual))
}

/// The command of a request of `set_mode`, as it is written on the topic `mode_cmd`, e.g. `manual robot`.
///
/// # Errors
/// When its number is none of a command.
pub fn words_of(request: &Request) -> Result<String, String> {
    let command = match request.command {
        Request::START => ModeCommand::Start,
        Request::STOP => ModeCommand::Stop,
        Request::AUTO => ModeCommand::Auto,
        Request::HAND => ModeCommand::Hand,
        Request::MANUAL => ModeCommand::Manual,
        Request::ESTOP => ModeCommand::EStop,
        Request::RESET => ModeCommand::Reset,
        other => {
            let (first, last) = (Request::START, Request::RESET);
            return Err(format!("unknown command {other}; commands: START ({first}) to RESET ({last})"));
        }
    };
    // The emergency stop is the line's, whatever stands beside it.
    let station = if command == ModeCommand::EStop { "" } else { request.station.trim() };
    Ok(if station.is_empty() { command.name().to_owned() } else { format!("{} {station}", command.name()) })
}
