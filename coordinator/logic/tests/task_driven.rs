//! Task-driven stations among others: they have no rounds, and are at home at any rest.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;

use crate::common::CoordinatorBench;

#[test]
fn after_master_stop_home_is_entered_when_the_others_have_ended_their_round() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        assert_eq!(bench.command(command), None);
    }
    for station in [0, 2] {
        bench.heard[station].round = 3;
    }
    bench.heard[1].round = 99;
    bench.beat();
    bench.command(ModeCommand::Stop);
    bench.beat();
    assert_eq!(bench.coordinator.mode(), ControlMode::Home);
}

#[test]
fn away_from_its_rests_it_keeps_the_line_from_home_mode_and_it_is_said_so() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    bench.command(ModeCommand::Start);
    bench.heard[1].at_home = false;
    bench.heard[2].round = 1;
    bench.beat();
    let refusal = bench.command(ModeCommand::Stop).expect("it is refused");
    assert_eq!(
        refusal,
        "stop refused in stand-by: transfer: at home one cycle behind the others; give auto, then stop; clamp_1: not at home"
    );
}
