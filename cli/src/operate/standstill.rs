//! `mode stop --wait`: until a stop has ended.
//!
//! A stop in auto ends the round, and that takes as long as it takes: so nothing here gives up because of the time. It ends at
//! home, or in stand-by with every station that is heard standing. It ends without that where *start* takes the stop back, or
//! another command is given, and where the coordinator is not heard any more.

use linewright_msgs::StationState;
use miette::miette;
use tokio::time::Instant;

use super::{ANSWER, CONNECT, REPEAT};
use crate::client::OperatorClient;
use crate::run::stopping::{StopStep, next_step};
use crate::states::mode_name;

/// What the states that were heard last say of the stop.
enum StopProgress {
    UnderWay,
    /// At home, or in stand-by and nothing that is heard moves.
    Ended,
    /// Something else was commanded since.
    Overridden(String),
}

/// Waits until the stop has ended. False if it was overridden; why is printed.
pub(super) async fn until_stopped(client: &mut OperatorClient) -> miette::Result<bool> {
    // The command may have been obeyed a moment ago, and its first state be on its way.
    client.listen(ANSWER).await?;
    let (mut heard, mut shown) = (Instant::now(), String::new());
    loop {
        if let Some(state) = client.coordinator() {
            heard = Instant::now();
            let progress = progress(client);
            if state.text != shown {
                shown.clone_from(&state.text);
                if matches!(progress, StopProgress::UnderWay) {
                    crate::out::complain!("{shown}");
                }
            }
            match progress {
                StopProgress::UnderWay => {}
                StopProgress::Ended => {
                    for name in client.unheard() {
                        crate::out::complain!("{name}: no state received; whether it stands is unknown");
                    }
                    return Ok(true);
                }
                StopProgress::Overridden(why) => {
                    crate::out::complain!("{why}");
                    return Ok(false);
                }
            }
        } else if heard.elapsed() >= CONNECT {
            return Err(miette!("no state received from the coordinator; whether the line has stopped is unknown"));
        }
        client.listen(REPEAT).await?;
    }
}

fn progress(client: &OperatorClient) -> StopProgress {
    let Some(state) = client.coordinator() else { return StopProgress::UnderWay };
    let heard: Vec<_> = client.line().station_ids().filter_map(|id| client.station(id)).map(Some).collect();
    match (state.mode, next_step(Some(state), &heard)) {
        (StationState::MODE_HOME, _) | (StationState::MODE_STANDBY, StopStep::Stands | StopStep::Command) => {
            StopProgress::Ended
        }
        (StationState::MODE_STANDBY, _) | (StationState::MODE_AUTO, StopStep::Wait) => StopProgress::UnderWay,
        (StationState::MODE_AUTO, _) => {
            StopProgress::Overridden("stop taken back by start; give stop again".to_owned())
        }
        (mode, _) => StopProgress::Overridden(format!("stop overridden: the mode is {}", mode_name(mode))),
    }
}
