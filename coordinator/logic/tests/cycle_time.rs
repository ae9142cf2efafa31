//! The cycle time of the line: from end to end, and none where a beginning or an end was not received.

use std::time::Duration;

use linewright_coordinator_logic::{CompletedCycle, Coordinator, ModeCommand, ModeInput};
use linewright_line::net::ControlMode;

use crate::common::CoordinatorBench;

/// Time passes in which all stations are received.
fn pass(bench: &mut CoordinatorBench, millis: u64) {
    for _ in 0..millis / 100 {
        bench.wait(Duration::from_millis(100));
        bench.beat();
    }
}

/// A station leaves home in this round.
fn leaves(bench: &mut CoordinatorBench, station: usize, round: i32) {
    (bench.heard[station].round, bench.heard[station].at_home, bench.heard[station].stopped) = (round, false, false);
    bench.say(station);
}

/// A station comes home, at the end of its round.
fn comes(bench: &mut CoordinatorBench, station: usize) {
    (bench.heard[station].at_home, bench.heard[station].stopped) = (true, true);
    bench.say(station);
}

/// All stations do this round together.
fn all_do(bench: &mut CoordinatorBench, round: i32, millis: u64) {
    let stations = 0..bench.heard.len();
    stations.clone().for_each(|station| leaves(bench, station, round));
    pass(bench, millis);
    stations.for_each(|station| comes(bench, station));
}

/// The number of each completed cycle with what it took, in ms.
fn ended(bench: &mut CoordinatorBench) -> Vec<(i32, Option<u128>)> {
    let ended = |CompletedCycle { number, took }: CompletedCycle| (number, took.map(|took| took.as_millis()));
    bench.out.cycles.drain(..).map(ended).collect()
}

/// The same where each has a time.
fn told(bench: &mut CoordinatorBench) -> Vec<(i32, u128)> {
    let timed = |(number, took): (i32, Option<u128>)| (number, took.expect("its beginning was received"));
    ended(bench).into_iter().map(timed).collect()
}

#[test]
fn a_cycle_ends_with_its_last_station_and_takes_the_time_since_the_end_before() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    (0..3).for_each(|station| leaves(&mut bench, station, 1));
    pass(&mut bench, 1000);
    comes(&mut bench, 0);
    leaves(&mut bench, 0, 2);
    comes(&mut bench, 1);
    pass(&mut bench, 500);
    assert_eq!(told(&mut bench), []);
    comes(&mut bench, 2);
    assert_eq!(told(&mut bench), [(1, 1500)]);
    leaves(&mut bench, 1, 2);
    leaves(&mut bench, 2, 2);
    pass(&mut bench, 300);
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(told(&mut bench), [(2, 300)], "the first station had begun it 800 ms before");
    pass(&mut bench, 300);
    assert_eq!(told(&mut bench), [], "said once");
}

#[test]
fn a_stay_at_home_is_no_part_of_a_cycle_but_a_stop_on_the_way_is() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    all_do(&mut bench, 1, 1000);
    bench.command(ModeCommand::Stop);
    assert_eq!(bench.mode(), ControlMode::Home);
    pass(&mut bench, 60_000);
    bench.command(ModeCommand::Start);
    bench.command(ModeCommand::Auto);
    all_do(&mut bench, 2, 700);
    assert_eq!(told(&mut bench), [(1, 1000), (2, 700)]);
    (0..3).for_each(|station| leaves(&mut bench, station, 3));
    pass(&mut bench, 200);
    bench.heard[1].incomplete = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
    pass(&mut bench, 5000);
    bench.heard[1].incomplete = false;
    bench.beat();
    bench.command(ModeCommand::Auto);
    pass(&mut bench, 300);
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(told(&mut bench), [(3, 5500)]);
}

#[test]
fn a_coordinator_that_starts_within_a_cycle_gives_no_time_for_it() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    all_do(&mut bench, 1, 400);
    assert_eq!(told(&mut bench), [(1, 400)]);
    (0..3).for_each(|station| leaves(&mut bench, station, 2));
    pass(&mut bench, 300);
    bench.coordinator = Coordinator::new(bench.line.clone(), 2, bench.coordinator.epoch());
    bench.input(ModeInput::Console { bits: 0, valid: true });
    bench.beat();
    bench.command(ModeCommand::Start);
    bench.command(ModeCommand::Auto);
    assert_eq!(bench.mode(), ControlMode::Auto, "{}", bench.coordinator.text());
    pass(&mut bench, 500);
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(ended(&mut bench), [(2, None)], "its beginning was not heard, and the one before is not given again");
    all_do(&mut bench, 3, 400);
    assert_eq!(told(&mut bench), [(3, 400)]);
}

#[test]
fn a_cycle_that_ended_unheard_has_no_time_and_nor_has_the_next() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    (0..3).for_each(|station| leaves(&mut bench, station, 1));
    pass(&mut bench, 500);
    bench.wait(Duration::from_secs(1));
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(ended(&mut bench), [(1, None)], "it ended some time in that second");
    all_do(&mut bench, 2, 400);
    assert_eq!(ended(&mut bench), [(2, None)], "and this one began then");
    all_do(&mut bench, 3, 300);
    assert_eq!(told(&mut bench), [(3, 300)]);
}

#[test]
fn a_station_unheard_in_the_middle_of_a_cycle_does_not_spoil_its_time() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    (0..3).for_each(|station| leaves(&mut bench, station, 1));
    bench.wait(Duration::from_secs(1));
    pass(&mut bench, 500);
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(told(&mut bench), [(1, 1500)]);
}

#[test]
fn a_cycle_that_is_taken_back_is_not_completed() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    all_do(&mut bench, 1, 400);
    (0..3).for_each(|station| leaves(&mut bench, station, 2));
    pass(&mut bench, 200);
    // Home by a recovery path: at the end of the round before.
    bench.heard[2].round = 1;
    comes(&mut bench, 2);
    pass(&mut bench, 100);
    leaves(&mut bench, 2, 2);
    pass(&mut bench, 300);
    (0..3).for_each(|station| comes(&mut bench, station));
    assert_eq!(told(&mut bench), [(1, 400), (2, 600)]);
}

#[test]
fn rounds_that_leap_or_are_of_different_generations_end_no_cycle() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    all_do(&mut bench, 1, 400);
    assert_eq!(told(&mut bench), [(1, 400)]);
    for round in [4, i32::MAX, i32::MIN, 0] {
        for heard in &mut bench.heard {
            (heard.round, heard.at_home) = (round, false);
        }
        bench.beat();
    }
    bench.heard[0].generation = 2;
    all_do(&mut bench, 1, 400);
    assert_eq!(told(&mut bench), []);
}

#[test]
fn task_driven_stations_have_no_part_in_it() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    bench.command(ModeCommand::Start);
    bench.command(ModeCommand::Auto);
    [0, 2].into_iter().for_each(|station| leaves(&mut bench, station, 1));
    pass(&mut bench, 400);
    [0, 2].into_iter().for_each(|station| comes(&mut bench, station));
    assert_eq!(told(&mut bench), [(1, 400)]);
}
