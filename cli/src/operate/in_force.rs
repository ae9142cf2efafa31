//! Whether a mode command has led where it leads: what was accepted may have ended again at once.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::Line;
use linewright_msgs::{LineState, StationState};
use tokio::time::Instant;

use super::{MODE, REPEAT};
use crate::client::OperatorClient;
use crate::states::mode_name;

/// Waits until the mode commanded is in force or under way, for a moment; what is instead, and why, where it is not.
pub async fn until_in_force(client: &mut OperatorClient, command: ModeCommand) -> miette::Result<Option<String>> {
    let deadline = Instant::now() + MODE;
    loop {
        let missed = client.coordinator().and_then(|state| missed(client.line(), command, state, &at_manual(client)));
        if missed.is_none() || Instant::now() >= deadline {
            return Ok(missed);
        }
        client.listen(REPEAT).await?;
    }
}

/// The stations whose selectors stand at manual.
fn at_manual(client: &OperatorClient) -> Vec<usize> {
    let is_manual = |id| client.station(id).is_some_and(|state| state.selector_manual);
    client.line().station_ids().filter(|&id| is_manual(id)).map(linewright_line::StationId::index).collect()
}

/// The epoch in which a command that leads where the line is already is given; none where it leads elsewhere.
pub fn already(state: &LineState, command: ModeCommand) -> Option<u64> {
    is_there(state, command).then_some(state.epoch)
}

/// Whether a command that is obeyed changes nothing: `start` in auto that is not being stopped.
pub fn is_idle(state: &LineState, command: ModeCommand) -> bool {
    command == ModeCommand::Start && state.mode == StationState::MODE_AUTO && !state.master_stop
}

/// Whether the line is where a command leads to.
fn is_there(state: &LineState, command: ModeCommand) -> bool {
    use StationState as S;
    match command {
        ModeCommand::Start => matches!(state.mode, S::MODE_STANDBY | S::MODE_AUTO) && !state.master_stop,
        // Under way in auto; in stand-by where a station is away from home.
        ModeCommand::Stop => {
            matches!(state.mode, S::MODE_HOME | S::MODE_STANDBY) || (state.mode == S::MODE_AUTO && state.master_stop)
        }
        ModeCommand::Auto => state.mode == S::MODE_AUTO,
        ModeCommand::Hand => state.mode == S::MODE_HAND,
        ModeCommand::Manual => state.mode == S::MODE_MANUAL,
        ModeCommand::EStop => state.mode == S::MODE_ESTOP,
        ModeCommand::Reset => state.mode != S::MODE_ESTOP || !state.estop_latched,
    }
}

fn missed(line: &Line, command: ModeCommand, state: &LineState, at_manual: &[usize]) -> Option<String> {
    use StationState as S;
    if is_there(state, command) {
        return None;
    }
    let mode = mode_name(state.mode);
    let name = command.name();
    if state.mode == S::MODE_MANUAL && !at_manual.is_empty() {
        let names: Vec<&str> = at_manual.iter().map(|&at| line.stations[at].name.as_str()).collect();
        let selectors = if names.len() == 1 { "its selector" } else { "their selectors" };
        return Some(format!(
            "{name} not in force: the mode is {mode}, by the selector of {}; turn {selectors} to auto, then give {name} again",
            names.join(", ")
        ));
    }
    Some(format!("{name} not in force: the mode is {}", state.text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_that_is_not_in_force_is_missed_with_the_reason() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let state = |mode, master_stop, text: &str| LineState {
            mode,
            master_stop,
            text: text.to_owned(),
            ..LineState::default()
        };
        let ended = "stand-by, auto ended (clamp_1: operation incomplete)";
        let why = missed(&line, ModeCommand::Auto, &state(StationState::MODE_STANDBY, false, ended), &[]);
        assert_eq!(why.as_deref(), Some(format!("auto not in force: the mode is {ended}").as_str()));
        let why = missed(&line, ModeCommand::Start, &state(StationState::MODE_MANUAL, false, "manual"), &[1]);
        let why = why.expect("start leads to stand-by");
        assert!(why.contains("by the selector of clamp_1; turn its selector to auto"), "{why}");
        for (command, mode, master_stop, text) in [
            (ModeCommand::Auto, StationState::MODE_AUTO, false, "auto"),
            (ModeCommand::Stop, StationState::MODE_AUTO, true, "auto, stopping at home"),
            (ModeCommand::Stop, StationState::MODE_STANDBY, false, "stand-by"),
            (ModeCommand::Reset, StationState::MODE_ESTOP, false, "e-stop, reset; select manual"),
            (ModeCommand::Reset, StationState::MODE_MANUAL, false, "manual"),
        ] {
            assert_eq!(missed(&line, command, &state(mode, master_stop, text), &[]), None, "{}", command.name());
        }
        let text = "e-stop (command estop), not reset; give reset, then manual";
        let latched = LineState { estop_latched: true, ..state(StationState::MODE_ESTOP, false, text) };
        assert!(missed(&line, ModeCommand::Reset, &latched, &[]).is_some());
    }
}
