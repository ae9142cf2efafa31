//! Manual for one station of a cell, and auto again: `linewright mode CELL manual --station robot`.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{Line, StationId};
use linewright_msgs::{LineState, StationState};
use miette::miette;
use tokio::time::Instant;

use super::{MODE, REPEAT};
use crate::client::OperatorClient;
use crate::load;
use crate::states::mode_name;

/// The station, and whether manual is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SingleCommand {
    station: StationId,
    is_manual: bool,
}

/// The command for the station of this name.
pub fn meant(line: &Line, name: &str, command: Option<ModeCommand>) -> miette::Result<SingleCommand> {
    let station = load::station(line, name)?;
    match command {
        Some(ModeCommand::Manual) => Ok(SingleCommand { station, is_manual: true }),
        Some(ModeCommand::Auto) => Ok(SingleCommand { station, is_manual: false }),
        _ => Err(miette!("--station goes with manual and auto: a station has no other mode of its own")),
    }
}

impl SingleCommand {
    /// The command as the coordinator takes it.
    pub fn words(self, line: &Line) -> String {
        let word = if self.is_manual { ModeCommand::Manual } else { ModeCommand::Auto };
        format!("{} {}", word.name(), line.station(self.station).name)
    }
}

/// Waits until the command is in force at its station, for a moment; what is instead, where it is not.
pub async fn until_in_force(
    client: &mut OperatorClient,
    command: Option<SingleCommand>,
) -> miette::Result<Option<String>> {
    let Some(command) = command else { return Ok(None) };
    let deadline = Instant::now() + MODE;
    loop {
        let missed = missed(client.line(), command, client.station(command.station), client.coordinator());
        if missed.is_none() || Instant::now() >= deadline {
            return Ok(missed);
        }
        client.listen(REPEAT).await?;
    }
}

fn missed(
    line: &Line,
    command: SingleCommand,
    station: Option<&StationState>,
    state: Option<&LineState>,
) -> Option<String> {
    let words = command.words(line);
    let Some(station) = station else { return Some(format!("{words} not in force: no state received from it")) };
    let is_there = match command.is_manual {
        true => station.mode == StationState::MODE_MANUAL,
        // With the others, whatever has become of their mode meanwhile.
        false => state.is_some_and(|state| state.mode == station.mode && state.epoch == station.mode_epoch),
    };
    let text = state.map_or("unknown", |state| state.text.as_str());
    (!is_there).then(|| format!("{words} not in force: its mode is {}; the line: {text}", mode_name(station.mode)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_in_force_where_the_station_says_so() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let auto = LineState { mode: StationState::MODE_AUTO, epoch: 7, text: "auto".into(), ..LineState::default() };
        let station = |mode, mode_epoch| StationState { mode, mode_epoch, ..StationState::default() };
        let command = |word, name| meant(&line, name, Some(word)).expect("known");
        let (manual, again) = (command(ModeCommand::Manual, "clamp_1"), command(ModeCommand::Auto, "clamp_1"));
        assert_eq!((manual.words(&line), again.words(&line)), ("manual clamp_1".into(), "auto clamp_1".into()));
        let missed = |command, station: &StationState| missed(&line, command, Some(station), Some(&auto));
        assert_eq!(missed(manual, &station(StationState::MODE_MANUAL, 7)), None);
        let why = missed(manual, &station(StationState::MODE_STANDBY, 7)).expect("not yet");
        assert_eq!(why, "manual clamp_1 not in force: its mode is stand-by; the line: auto");
        assert!(missed(again, &station(StationState::MODE_MANUAL, 6)).is_some());
        assert_eq!(missed(again, &station(StationState::MODE_AUTO, 7)), None);
        assert!(meant(&line, "clamp_1", Some(ModeCommand::Hand)).is_err());
        assert!(meant(&line, "clamp_1", None).is_err());
    }
}
