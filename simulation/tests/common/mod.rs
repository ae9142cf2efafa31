//! Functions shared by the tests.
#![allow(dead_code)]

use linewright_line::{Line, OpId, StationId, TransferLine, parse};
use linewright_simulation::{LineSim, RunEnd, RunGoal, Scenario, Script, SimOptions, run};

/// The shipped transfer line with so many machines.
pub fn transfer_line(machines: usize) -> Line {
    let text = TransferLine { machines, time_scale: 1.0 }.text();
    parse("line.toml", &text).unwrap_or_else(|problems| panic!("{problems:?}")).line
}

/// An operation by name.
pub fn op(line: &Line, station: &str, operation: &str) -> (StationId, OpId) {
    let id = line.station_named(station).unwrap_or_else(|| panic!("no {station}"));
    (id, line.station(id).operation_named(operation).unwrap_or_else(|| panic!("no {operation}")))
}

/// Options that keep the log.
pub fn logged() -> SimOptions {
    SimOptions { keeps_log: true, ..SimOptions::default() }
}

/// Plays a scenario of the transfer line.
pub fn play(text: &str) -> (LineSim, RunEnd) {
    play_with(text, logged())
}

/// Actions of people by a scenario's text.
pub fn script(line: &Line, text: &str) -> Script {
    Scenario::parse(line, "test.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).script
}

/// Plays a scenario of the transfer line; its network and variation are the scenario's.
pub fn play_with(text: &str, options: SimOptions) -> (LineSim, RunEnd) {
    let line = transfer_line(1);
    let scenario = Scenario::parse(&line, "test.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
    let options = SimOptions { network: scenario.network, variation: scenario.variation, ..options };
    let goal = RunGoal { cycles: scenario.cycles.unwrap_or(1), starts: scenario.starts, script: scenario.script };
    run(&line, options, &goal).expect("the line compiles")
}

/// Plays a scenario that goes as it expects.
pub fn played(text: &str) -> LineSim {
    let (sim, end) = play(text);
    assert_eq!(end, RunEnd::Done, "{}", sim.log().tail(sim.line(), 60));
    assert_eq!(sim.conflicts(), []);
    sim
}
