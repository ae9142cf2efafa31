//! Functions shared by the tests.

use linewright_line::{AxisId, Line, OpId, StationId, TransferLine, parse};
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
    play_line(&transfer_line(1), text, logged())
}

/// Actions of people by a scenario's text.
pub fn script(line: &Line, text: &str) -> Script {
    Scenario::parse(line, "test.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).script
}

/// Plays a scenario of a line; its network and variation are the scenario's.
pub fn play_line(line: &Line, text: &str, options: SimOptions) -> (LineSim, RunEnd) {
    let scenario = Scenario::parse(line, "test.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
    let options = SimOptions { network: scenario.network, variation: scenario.variation, ..options };
    let goal = RunGoal { cycles: scenario.cycles.unwrap_or(1), starts: scenario.starts, script: scenario.script };
    run(line, options, &goal).expect("the line compiles")
}

/// Plays a scenario that goes as it expects.
pub fn played(text: &str) -> LineSim {
    let (sim, end) = play(text);
    assert_eq!(end, RunEnd::Done, "{}", sim.log().tail(sim.line(), 60));
    assert_eq!(sim.conflicts(), []);
    sim
}

/// The table of the rotary examples, and its index.
pub const TABLE: StationId = StationId(0);
pub const INDEX: OpId = OpId(0);

/// By how many places the table has come on, as the mechanism has it and no controller.
pub fn indexes(sim: &LineSim) -> u64 {
    sim.plant_of(TABLE).indexes(TABLE, AxisId(0))
}

/// The same by its controller's counts, since they were founded.
pub fn counted(sim: &LineSim) -> u64 {
    let done = sim.controller(TABLE).expect("it runs").done(INDEX);
    u64::try_from(done).expect("it counts from 0")
}
