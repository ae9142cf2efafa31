//! `linewright press LINE resume`: held, what was stopped before its end goes on at every station.

use std::process::ExitCode;

use linewright_console_view::{NOTHING_INCOMPLETE, RESUME, RESUME_ONLY};
use linewright_line::{Line, StationId};
use linewright_msgs::{Flag, StationState};
use linewright_node_shell::RosArgs;

use super::{CONNECT, PressArgs, PressOutcome, answer, hold, is_refused, until_mode};
use crate::client::OperatorClient;

pub async fn press(line: &Line, args: &PressArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let mut client = OperatorClient::open(line, &args.line, ros, "operator")?;
    let publisher = client.resume()?;
    client.until_connected(CONNECT).await?;
    // A station that is not received yet may stand half-way all the same.
    let is_all_heard = client.until_all_heard(CONNECT).await?;
    let all: Vec<StationId> = line.station_ids().collect();
    if let Err(mode) = until_mode(&mut client, all[0], StationState::MODE_MANUAL).await? {
        let why = format!("{RESUME_ONLY} {mode}");
        return answer(&client, args, &all, PressOutcome::Refused(why));
    }
    let is_stopped = |id: &StationId| client.station(*id).is_some_and(|state| !state.incomplete.is_empty());
    let stations: Vec<StationId> = all.iter().copied().filter(is_stopped).collect();
    if stations.is_empty() {
        let unheard: Vec<&str> = client.unheard().collect();
        let why = match is_all_heard {
            true => NOTHING_INCOMPLETE.to_owned(),
            false => format!("nothing is received of {}; at the others {NOTHING_INCOMPLETE}", unheard.join(", ")),
        };
        return answer(&client, args, &all, PressOutcome::Refused(why));
    }
    let before = client.coordinator().map_or(0, |state| state.refusals);
    let say = |_: &OperatorClient, held| publisher.send(Flag { data: held });
    let outcome = hold(&mut client, (args.seconds, true), &stations, say).await?;
    let outcome = match client.coordinator().filter(|state| is_refused(state, RESUME, before)) {
        Some(state) => PressOutcome::Refused(state.refusal.clone()),
        None => outcome,
    };
    answer(&client, args, &stations, outcome)
}
