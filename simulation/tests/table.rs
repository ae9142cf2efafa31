//! A rotary table with three stations around it: the shipped example, whole, with faults of its index.
//!
//! ```text
//!   table  ──index──┐           ┌──index──
//!   load            └─ on, back ┤
//!   drill           └─ down, up ┤
//!   unload          └─ over, back
//! ```
//!
//! Every run is watched by the observer that looks at positions alone: the table turns under nothing.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{AxisId, Line, OpId, parse};
use linewright_simulation::{LineSim, OperatorAction, RunEnd, SimOptions};
use linewright_station_logic::StopCause;

use crate::common::*;

fn line() -> Line {
    let text = include_str!("../../examples/rotary-table.toml");
    parse("rotary-table.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

/// Plays a scenario that goes as it expects, with images at once and over frames.
fn goes(text: &str) -> LineSim {
    let line = line();
    let play = |frames| {
        let (sim, end) = play_line(&line, text, SimOptions { frames, ..logged() });
        assert_eq!(end, RunEnd::Done, "frames: {frames}\n{}", sim.log().tail(sim.line(), 60));
        assert_eq!(sim.conflicts(), []);
        // Unless it is in doubt, its controller has counted what the table has done.
        if sim.controller(TABLE).is_some_and(|table| table.position_lost().is_none()) {
            assert_eq!(counted(&sim), indexes(&sim), "frames: {frames}");
        }
        sim
    };
    play(true);
    play(false)
}

fn causes(sim: &LineSim) -> Vec<StopCause> {
    sim.record().faults().iter().filter(|fault| fault.station == TABLE).map(|fault| fault.cause).collect()
}

fn fault(sim: &LineSim) -> String {
    sim.controller(TABLE).expect("it runs").fault_text(sim.line())
}

fn act(sim: &mut LineSim, action: OperatorAction, ms: u64) {
    sim.act(action).expect("nothing is started");
    sim.run_to(sim.now() + Duration::from_millis(ms));
}

/// A person has looked, and confirms; an index that is half-way is led on. Then all goes on, and is counted as it is done.
fn confirmed(sim: &mut LineSim, within: Option<OpId>) {
    assert!(fault(sim).contains("index in doubt: LS_in_place"), "{}", fault(sim));
    act(sim, OperatorAction::Rejoin(TABLE, within), 300);
    if within.is_some() {
        act(sim, OperatorAction::Command(ModeCommand::Manual), 300);
        for (down, ms) in [(true, 1500), (false, 100)] {
            act(sim, OperatorAction::Panel { station: TABLE, advance: true, down }, ms);
        }
    }
    assert_eq!(fault(sim), "");
    let before = indexes(sim);
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        act(sim, OperatorAction::Command(command), 300);
    }
    sim.run_to(sim.now() + Duration::from_secs(8));
    assert!(counted(sim) >= 2, "{}", sim.log().tail(sim.line(), 60));
    assert_eq!(counted(sim), indexes(sim) - before);
    assert_eq!(sim.conflicts(), []);
}

#[test]
fn cycle_for_cycle_the_table_brings_the_parts_on_by_one_place() {
    let sim = goes("cycles = 5\nvariation_percent = 20");
    assert_eq!(indexes(&sim), 5);
    // At rest it stands at the one place that the description has.
    assert!(sim.position(TABLE, AxisId(0)).abs() < 0.3, "{}", sim.position(TABLE, AxisId(0)));
}

#[test]
fn a_table_that_jams_half_way_is_named_and_led_on_to_the_next_place() {
    let mut sim = goes(
        r#"
        cycles = 1
        [[step]]
        when = "cycles >= 1 and table: index is operating"
        after_s = 0.5
        stick = "table: index"
        [[step]]
        when = "line is stand-by and all are stopped"
        expect = "table is incomplete and load is home and drill is home and unload is home"
        [[step]]
        refused = "auto"
        [[step]]
        clear = "table: index"
        [[step]]
        command = "manual"
        [[step]]
        when = "all obey manual"
        press = "table: advance"
        for_s = 0.3
        [[step]]
        after_s = 0.1
        expect = "table is incomplete"
        [[step]]
        press = "drill: advance"
        for_s = 1.0
        [[step]]
        after_s = 0.1
        expect = "drill is home"
        "#,
    );
    assert_eq!(causes(&sim), [StopCause::Watchdog]);
    let before = indexes(&sim);
    assert_eq!(counted(&sim), before);
    confirmed(&mut sim, Some(INDEX));
}

/// The table comes to its next place and its controller does not see it: it is not turned on once more.
#[test]
fn a_table_whose_switch_is_stuck_as_it_turns_is_in_doubt() {
    let mut sim = goes(
        r#"
        cycles = 1
        [[step]]
        when = "cycles >= 1 and table: index is operating"
        stuck-on = "table: LS_in_place"
        [[step]]
        when = "line is stand-by and all are stopped"
        after_s = 0.2
        expect = "table is incomplete and table is blocked"
        [[step]]
        clear = "table: LS_in_place"
        [[step]]
        command = "manual"
        [[step]]
        when = "all obey manual"
        press = "table: advance"
        for_s = 1.5
        [[step]]
        after_s = 0.1
        expect = "table is incomplete and table is blocked"
        "#,
    );
    assert_eq!(causes(&sim), [StopCause::SwitchStuck]);
    assert_eq!(indexes(&sim), counted(&sim) + 1, "one index, which is not counted, and no other after it");
    confirmed(&mut sim, None);
}

/// Its switch is on, and the controller has seen neither that the table left nor that it came.
#[test]
fn its_process_dies_as_it_sets_out_and_only_a_person_who_has_looked_ends_the_doubt() {
    let mut sim = goes(
        r#"
        cycles = 1
        [[step]]
        when = "cycles >= 1"
        stick = "table: index"
        [[step]]
        when = "table: index is operating"
        kill = "table"
        [[step]]
        after_s = 1
        restart = "table"
        [[step]]
        clear = "table: index"
        [[step]]
        when = "all are heard and all are stopped"
        after_s = 0.3
        expect = "table is incomplete and table is blocked"
        [[step]]
        refused = "auto"
        "#,
    );
    confirmed(&mut sim, None);
}
