//! Commands in words: a mode for the line, or manual and auto for one station of it.

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::CoordinatorArrival;
use linewright_line::{Line, suggestion};
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

#[cfg(test)]
mod tests {
    use linewright_line::{StationId, TransferLine, parse};

    use super::*;

    #[test]
    fn one_station_is_named_after_manual_or_auto() {
        let line = parse("line.toml", &TransferLine::default().text()).expect("sound").line;
        let command = |words| command_of(&line, words);
        let single = |words| match command(words) {
            Ok(CoordinatorArrival::Single(id, is_manual)) => (id, is_manual),
            other => panic!("{other:?}"),
        };
        assert_eq!(single(" manual  clamp_1 "), (StationId(1), true));
        assert_eq!(single("auto clamp_1"), (StationId(1), false));
        assert!(matches!(command("E-Stop"), Ok(CoordinatorArrival::Command(ModeCommand::EStop))));
        for (words, expected) in [
            ("faster", "unknown command 'faster'; commands: start, stop, auto"),
            ("faster clamp_1", "unknown command 'faster clamp_1'"),
            ("hand clamp_1", "'hand clamp_1' is no command for one station"),
            ("manual clamp_9", "no station 'clamp_9'; "),
        ] {
            let refusal = command(words).expect_err(words);
            assert!(refusal.starts_with(expected), "{refusal}");
        }
    }
}
