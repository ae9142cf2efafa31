//! The rotary table turned by a drive: the shipped example, whole, by images and over frames, with what goes wrong.
//!
//! What a switch leaves in doubt the drive measures: no restart and no stop half-way needs a person who confirms the place.

use linewright_line::{Line, parse};
use linewright_simulation::{RunEnd, SimOptions};

use crate::common::*;

fn line(direction: &str) -> Line {
    let text = include_str!("../../examples/driven-table.toml");
    let text = text.replace("turn = 360,", &format!("turn = 360, direction = \"{direction}\","));
    parse("driven-table.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

/// Plays a scenario that goes as it expects, both ways round, by images and over frames; gives how often the table was turned.
fn goes(text: &str) -> u64 {
    let mut turned = None;
    for (frames, direction) in [(true, "positive"), (true, "negative"), (false, "positive"), (false, "negative")] {
        let (sim, end) = play_line(&line(direction), text, SimOptions { frames, ..logged() });
        assert_eq!(end, RunEnd::Done, "frames: {frames}, {direction}\n{}", sim.log().tail(sim.line(), 60));
        assert_eq!(sim.conflicts(), []);
        assert_eq!(counted(&sim), indexes(&sim), "frames: {frames}, {direction}");
        assert_eq!(sim.controller(TABLE).expect("it runs").position_lost(), None);
        assert_eq!(*turned.get_or_insert(indexes(&sim)), indexes(&sim), "frames: {frames}, {direction}");
    }
    turned.expect("it was played")
}

#[test]
fn over_more_than_two_turns_each_cycle_brings_the_parts_on_by_one_place() {
    assert_eq!(goes("cycles = 9"), 9);
}

/// With a switch this is the doubt that a person has to end.
#[test]
fn its_process_dies_as_it_sets_out_and_it_is_known_to_stand_where_it_began() {
    let turned = goes(
        r#"
        cycles = 2
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
        after_s = 1.5
        expect = "table is incomplete"
        [[step]]
        command = "manual"
        [[step]]
        when = "all obey manual"
        jog = "table: advance"
        expect = "table: index is done"
        [[step]]
        command = "auto"
        "#,
    );
    assert_eq!(turned, 2);
}
