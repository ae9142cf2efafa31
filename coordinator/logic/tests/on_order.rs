//! Stations on order among others: they have no rounds, and are at home at any rest.

#[allow(dead_code)]
mod common;

use std::time::Duration;

use common::{Bench, line};
use linewright_coordinator_logic::Command;
use linewright_line::net::ControlMode;
use linewright_line::{Rest, RestId, Task};

/// The shipped line, with its second station on order. What it can be ordered to do does not matter here.
fn bench() -> Bench {
    let mut line = line();
    let station = &mut line.stations[1];
    station.rests = vec![Rest { name: "home".to_owned(), at: Vec::new() }];
    station.tasks = vec![Task {
        name: "everything".to_owned(),
        steps: 0..station.steps.len(),
        from: RestId(0),
        to: RestId(0),
        limit: Duration::from_secs(1),
        parameters: Vec::new(),
    }];
    Bench::of(line, 0)
}

#[test]
fn after_master_stop_home_is_entered_when_the_others_have_ended_their_round() {
    let mut bench = bench();
    for command in [Command::Start, Command::Auto] {
        assert_eq!(bench.command(command), None);
    }
    for station in [0, 2] {
        bench.heard[station].round = 3;
    }
    bench.heard[1].round = 99;
    bench.beat();
    bench.command(Command::Stop);
    bench.beat();
    assert_eq!(bench.coordinator.mode(), ControlMode::Home);
}

#[test]
fn away_from_its_rests_it_keeps_the_line_from_home_mode_and_it_is_said_so() {
    let mut bench = bench();
    bench.command(Command::Start);
    bench.heard[1].at_home = false;
    bench.heard[2].round = 1;
    bench.beat();
    let refusal = bench.command(Command::Stop).expect("it is refused");
    assert_eq!(
        refusal,
        "stop refused in stand-by: transfer is at home, but a cycle behind: give auto and then stop; clamp_1 is not at home"
    );
}
