//! The time of an order is over at its station and at the coordinator at the same moment, and messages take any time:
//! whichever is first, it means the same, and no answer is taken before all of it stands.

use std::time::Duration;

use linewright_coordinator_cell::exception::ExceptionStep;
use linewright_coordinator_cell::{ActivityFailure, ActivityPhase, OrderFailure, PlayerInput, RecordKind, TaskOutcome};
use linewright_line::{Owner, StationId, Tick};
use linewright_plant::MotionFault;
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, CellSimOptions};

use super::{LONG, Shipped, dispatcher, grasps, is_machined, options, shipped};

const MILLIS: fn(u64) -> Duration = Duration::from_millis;

/// Whether a station has an order, or moves anything.
fn moves(of: &Shipped, sim: &CellSim, station: StationId) -> bool {
    let floor = sim.floor.as_ref().expect("real stations");
    let numbers = of.line.station(station).tasks.iter().flat_map(|task| &task.parameters);
    let numbers = numbers.flat_map(|parameter| &parameter.bits).fold(0, |bits, output| bits | output.bit());
    let has_order = floor.controller(station).report().order.is_some_and(|order| order.slot.is_some());
    has_order || floor.plant().outputs(Owner::Station(station)) & !numbers != 0
}

/// The loading whose grasp fails (seed 001, L229), with an operator that answers as soon as there is an alarm, and again
/// until the answer is taken. Whether the robot's time was over first.
fn run(of: &Shipped, options: CellSimOptions, fast: Duration) -> bool {
    let seed = options.seed;
    let mut sim = of.sim(options, 0.0);
    sim.floor.as_mut().expect("real stations").fast = fast;
    let mut dispatcher = dispatcher(&of.cell, &of.table);
    let robot = of.line.station_named("robot").expect("there");
    grasps(of, &mut sim, Some(MotionFault::Miss));
    let (mut now, mut station_first, mut told) = (Tick::ZERO, None, None);
    loop {
        now = now + MILLIS(5);
        sim.run_on(&mut dispatcher, now);
        let report = sim.floor.as_ref().expect("real").controller(robot).report().order.expect("it is task-driven");
        let raised = sim.state().firings().any(|firing| firing.phase != ActivityPhase::Running);
        let gives_up = report.results.last().is_some_and(|(_, end)| *end != TaskOutcome::Done);
        if station_first.is_none() && (raised || gives_up) {
            station_first = Some(gives_up && !raised);
        }
        assert!(now < Tick::from_millis(120_000), "{seed}: nobody is told");
        let Some(alarm) = sim.state().exceptions().alarms().next().cloned() else { continue };
        if told.is_none() {
            let firing =
                sim.state().firings().find(|firing| firing.phase != ActivityPhase::Running).expect("it has failed");
            let ActivityPhase::Failed(ActivityFailure::Order { key: _, failure }) = firing.phase else {
                panic!("{seed}: {firing:?}")
            };
            assert_eq!(failure, OrderFailure::Code(22), "{seed}: what the robot waited for");
            assert!(alarm.text.contains("Put the part back into slot 1 of ST"), "{seed}: {}", alarm.text);
            assert_eq!(alarm.words, ["in-store", "in-machine", "scrap"], "{seed}");
            told = Some(alarm.id);
        }
        let moving: Vec<StationId> = of.line.station_ids().filter(|&station| moves(of, &sim, station)).collect();
        grasps(of, &mut sim, None);
        sim.say(&mut dispatcher, &[PlayerInput::Answer { alarm: alarm.id, word: "in-store" }]);
        if sim.state().exceptions().alarm(alarm.id).is_none() {
            assert_eq!(moving, [], "{seed}: it was taken at {} while these move", sim.now);
            break;
        }
    }
    sim.run(&mut dispatcher, LONG);
    // No alarm is even raised before.
    of.is_done(&sim);
    is_machined(of, &sim, [1, 0]);
    let answered =
        sim.log.iter().filter(|of| matches!(of.fact, RecordKind::Exception(ExceptionStep::Answered { .. }))).count();
    assert_eq!(answered, 1, "{seed}");
    station_first == Some(true)
}

#[test]
fn whichever_time_is_over_first_nobody_is_answered_before_all_of_it_stands() {
    let mut of = shipped("workcell-c1", &[1, 0]);
    // Without a look into the hand the robot comes to the machine empty, and both wait.
    let robot = of.line.station_named("robot").expect("there");
    of.line.stations[robot.index()].operations.iter_mut().for_each(|op| op.result = None);
    let mut rng = Rng::new(22);
    let mut firsts = [0, 0];
    for seed in 0..100 {
        let most = rng.within(1, 300);
        let delay = (MILLIS(rng.below(most)), MILLIS(most));
        // Some messages are lost, some come twice, some very late.
        let bad_luck = [0, 0, 12][rng.below(3) as usize];
        let fast = MILLIS(rng.below(2 * most));
        let station_first = run(&of, CellSimOptions { delay, bad_luck, ..options(seed, 0, Vec::new()) }, fast);
        firsts[usize::from(station_first)] += 1;
    }
    assert!(firsts.iter().all(|&times| times >= 5), "each was first: {firsts:?}");
}
