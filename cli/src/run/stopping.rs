//! End of a run: the line is stopped at home if it can be.
//!
//! In auto and hand a master stop leads home, and in stand-by where every station is there already. After a fault, in manual
//! and in an emergency stop only an operator can lead home: the run ends as soon as everything stands. A time limit holds for
//! all of it.

use linewright_msgs::{LineState, StationState};

/// Next step of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopStep {
    /// Give the command `stop`.
    Command,
    /// Wait for stations.
    Wait,
    /// Every station is at home: the run is over.
    Home,
    /// Nothing moves, and nothing leads home without an operator: the run is over.
    Stands,
}

/// The next step, from the coordinator's state and those of all stations; `None` of one that is not heard.
pub fn next_step(line: Option<&LineState>, stations: &[Option<&StationState>]) -> StopStep {
    let all = |holds: &dyn Fn(&StationState) -> bool| stations.iter().all(|state| state.is_some_and(holds));
    let Some(line) = line else { return StopStep::Wait };
    match line.mode {
        StationState::MODE_AUTO if line.master_stop => StopStep::Wait,
        StationState::MODE_AUTO | StationState::MODE_HAND => StopStep::Command,
        // The coordinator may be heard before the states that it has decided by.
        StationState::MODE_HOME if all(&|state| state.mode == StationState::MODE_HOME || rests(state)) => {
            StopStep::Home
        }
        StationState::MODE_HOME => StopStep::Wait,
        StationState::MODE_STANDBY if is_at_home(stations) => StopStep::Command,
        // One that has not heard of the mode may still start something.
        mode if all(&|state| state.stopped && obeys(state.mode, mode)) => StopStep::Stands,
        _ => StopStep::Wait,
    }
}

/// Whether all stations are at home, at the end of one round, and none of their selectors is in the way of a stop.
fn is_at_home(stations: &[Option<&StationState>]) -> bool {
    let round = stations.first().copied().flatten().map(|state| state.round);
    let is_there = |state: &StationState| state.at_home && state.stopped && Some(state.round) == round;
    stations.iter().all(|state| state.is_some_and(|state| is_there(state) && !state.selector_manual))
}

/// A station whose node is not active follows no mode.
fn rests(state: &StationState) -> bool {
    state.lifecycle != StationState::LIFECYCLE_ACTIVE && state.at_home && state.stopped
}

/// A station may be in an emergency stop of its own.
fn obeys(station: u8, line: u8) -> bool {
    station == line || station == StationState::MODE_ESTOP
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_leads_home_or_ends_where_everything_stands() {
        let auto = StationState::MODE_AUTO;
        let (home, stand_by, stop) = (StationState::MODE_HOME, StationState::MODE_STANDBY, StationState::MODE_ESTOP);
        // Mode and master stop of the line; mode of a station, and whether it stands.
        for (mode, master_stop, of_station, stands, expected) in [
            (auto, false, auto, false, StopStep::Command),
            (StationState::MODE_HAND, false, StationState::MODE_HAND, true, StopStep::Command),
            (auto, true, auto, false, StopStep::Wait),
            (home, true, auto, true, StopStep::Wait),
            (home, true, home, true, StopStep::Home),
            (home, false, stand_by, true, StopStep::Wait),
            (stand_by, false, stand_by, false, StopStep::Wait),
            (stand_by, false, stand_by, true, StopStep::Stands),
            (stand_by, false, auto, true, StopStep::Wait),
            (stand_by, false, stop, true, StopStep::Stands),
            (stop, false, stop, true, StopStep::Stands),
            (StationState::MODE_MANUAL, false, StationState::MODE_MANUAL, true, StopStep::Stands),
        ] {
            let line = LineState { mode, master_stop, ..LineState::default() };
            let lifecycle = StationState::LIFECYCLE_ACTIVE;
            let station = StationState { mode: of_station, stopped: stands, lifecycle, ..StationState::default() };
            assert_eq!(next_step(Some(&line), &[Some(&station)]), expected, "{mode} {master_stop} {stands}");
        }
        for (selector_manual, round, expected) in
            [(false, 3, StopStep::Command), (true, 3, StopStep::Stands), (false, 4, StopStep::Stands)]
        {
            let line = LineState { mode: stand_by, ..LineState::default() };
            let at =
                |round| StationState { mode: stand_by, stopped: true, at_home: true, round, ..StationState::default() };
            let stations = [StationState { selector_manual, ..at(3) }, at(round)];
            assert_eq!(
                next_step(Some(&line), &[Some(&stations[0]), Some(&stations[1])]),
                expected,
                "{selector_manual} {round}"
            );
        }
        for (at_home, expected) in [(true, StopStep::Home), (false, StopStep::Wait)] {
            let line = LineState { mode: home, ..LineState::default() };
            let lifecycle = StationState::LIFECYCLE_UNCONFIGURED;
            let station = StationState { mode: stand_by, stopped: true, at_home, lifecycle, ..StationState::default() };
            assert_eq!(next_step(Some(&line), &[Some(&station)]), expected, "not active, {at_home}");
        }
        let line = LineState { mode: stand_by, ..LineState::default() };
        assert_eq!(next_step(Some(&line), &[None]), StopStep::Wait, "not heard");
        assert_eq!(next_step(None, &[]), StopStep::Wait);
    }
}
