//! A station that still moves: no alarm is raised about it, no answer is taken, and both clocks mean the same.

use std::time::Duration;

use linewright_coordinator_cell::dispatch::{Reasons, ShortestRoutes, why_not};
use linewright_coordinator_cell::exception::{AlarmAnswerRefusal, ResourceRequest};
use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, Fifo, OrderFailure, OrderProgress, PartId, PlayerInput, TaskOutcome, TaskReport,
};
use linewright_orders::TaskFailure;

use super::bench::{CellBench, workcell};

const LOAD: &str = "load M1<A.new>";

/// An order that a fault has ended may be gone back from: until that has ended too, nothing of it has come to rest.
#[test]
fn while_a_station_goes_back_nobody_is_asked_and_no_answer_is_taken() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("m1").waits_to_begin = true;
    bench.until_that(|bench| {
        bench.firing(LOAD).is_some_and(|of| of.orders.iter().all(|of| of.state != OrderProgress::Written))
    });
    let (robot, key) = (bench.station("robot"), bench.firing(LOAD).unwrap().orders[0].key);
    bench.at("robot").is_away = true;
    let stands = TaskReport {
        slot: None,
        results: vec![(key, TaskOutcome::Failed(TaskFailure::Fault))],
        ..bench.at("robot").heard()
    };
    let moves = TaskReport { slot: Some(key), ..stands.clone() };
    for _ in 0..20 {
        bench.say(PlayerInput::Station(robot, &moves));
        bench.seconds_later(0.1);
    }
    let failure = OrderFailure::Code(1001);
    assert_eq!(bench.firing(LOAD).unwrap().phase, ActivityPhase::Failed(ActivityFailure::Order { key, failure }));
    assert_eq!(bench.state().exceptions().alarms().len(), 0, "the robot moves");
    bench.say(PlayerInput::Station(robot, &stands));
    let alarm = bench.alarm().clone();
    assert!(!alarm.text.contains("First lead"), "{}", alarm.text);
    // It begins to move again.
    bench.say(PlayerInput::Station(robot, &moves));
    let leads = bench.sim.coordination.alarm_leads(bench.sim.now, &alarm);
    assert_eq!((leads.at_order, leads.lead), (vec![robot], Vec::new()));
    let text = bench.alarm_now();
    assert!(text.contains("robot: still at its order, which it ends in auto"), "{text}");
    bench.answer("as-before");
    assert_eq!(bench.objections(), [(ResourceRequest::Answer(alarm.id), AlarmAnswerRefusal::Moves(robot))]);
    bench.say(PlayerInput::Station(robot, &stands));
    assert_eq!(bench.sim.coordination.alarm_leads(bench.sim.now, &alarm).at_order, []);
    bench.answer("as-before");
    // And once more, before what was answered has been compared.
    bench.say(PlayerInput::Station(robot, &moves));
    assert!(bench.alarm().text.starts_with("robot moved after the answer \"as-before\"."), "{}", bench.alarm().text);
    assert!(bench.firing(LOAD).is_some());
}

/// Its time was over at the coordinator first; the station reports what it waited for, and a rule of its own code
/// counts.
#[test]
fn what_a_station_waited_for_is_why_it_failed_whoever_was_first() {
    let text = workcell().replace("code = \"time-out\"", "code = \"22\"");
    for first in [false, true] {
        let mut bench = CellBench::new(&text, &[1, 0]);
        (bench.at("robot").is_stuck, bench.at("m1").waits_to_begin) = (true, true);
        bench.at("robot").waits_code = Some(22);
        bench.at("robot").fast = if first { Duration::from_secs(1) } else { Duration::ZERO };
        bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
        let of = bench.firing(LOAD).unwrap();
        let cause = ActivityFailure::Order { key: of.orders[0].key, failure: OrderFailure::Code(22) };
        assert_eq!(of.phase, ActivityPhase::Failed(cause), "the station first: {first}");
        assert_eq!(bench.alarm().words, ["in-store", "in-machine", "scrap"]);
    }
}

/// Led away by hand it is received, has its devices and no order, and cannot be given one.
#[test]
fn a_station_between_two_rests_is_named_by_whoever_waits_for_it() {
    let mut bench = CellBench::c1(&[1, 0]);
    for name in ["robot", "m1", "m2", "m3"] {
        bench.at(name).is_held = true;
    }
    bench.seconds_later(60.0);
    assert_eq!((bench.state().firings().len(), bench.state().exceptions().alarms().len()), (0, 0));
    let held: Vec<_> = bench.sim.coordination.held_stations().collect();
    assert_eq!(held.len(), 4);
    let ways = ShortestRoutes::new(&bench.table);
    let why = why_not(&ways, &Reasons::default(), &bench.sim.coordination, bench.sim.now, PartId(1));
    assert_eq!(why[1], "`load M1`: robot: between two rests; lead it to a rest in manual.");
    let now = bench.sim.now;
    for name in ["robot", "m1", "m2", "m3"] {
        bench.at(name).bring_to_rest(now);
    }
    bench.sim.run_on(&mut Fifo, now + Duration::from_secs(2));
    bench.all_leave(1);
}

/// Whether the robot goes back when the time of the loading is over: else it stands between two rests.
fn robot_goes_back(change: impl Fn(&mut CellBench, u64)) -> bool {
    let mut bench = CellBench::c1(&[1, 0]);
    (bench.at("robot").is_stuck, bench.at("m1").waits_to_begin) = (true, true);
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    for tenth in 0..300 {
        change(&mut bench, tenth);
        bench.seconds_later(0.1);
    }
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    !bench.at("robot").is_held
}

/// The robot stands at the clamp when its time is over, after 24 s. It goes back where the clamp has not begun to close, and cannot.
#[test]
fn a_station_goes_back_only_where_the_other_stands_where_its_order_began() {
    assert!(robot_goes_back(|_, _| ()));
    let begins = |at: u64| {
        move |bench: &mut CellBench, tenth: u64| {
            if tenth == at {
                (bench.at("m1").waits_to_begin, bench.at("m1").is_stuck) = (false, true);
            }
        }
    };
    assert!(!robot_goes_back(begins(100)), "it closes");
    let ends = |bench: &mut CellBench, tenth: u64| bench.at("m1").waits_to_begin = tenth < 100;
    assert!(!robot_goes_back(ends), "it has closed");
    let silent = |bench: &mut CellBench, tenth: u64| bench.at("m1").is_away = tenth > 220;
    assert!(!robot_goes_back(silent), "it may have begun since its last report");
    let forgets = |bench: &mut CellBench, tenth: u64| {
        if tenth == 238 {
            bench.at("m1").forget();
        }
    };
    assert!(!robot_goes_back(forgets), "it may have completed its order");
    let restart = |bench: &mut CellBench, tenth: u64| {
        if tenth == 238 {
            bench.sim.options.crash_at = (0..4).map(|step| bench.sim.steps + 20 * step).collect();
        }
    };
    assert!(robot_goes_back(restart), "a later life decides the same");
}

/// While the coordinator's machine sleeps nothing is received: the time to wait for sensors begins when it wakes.
#[test]
fn after_a_standstill_an_answer_waits_for_the_sensors() {
    let mut bench = CellBench::c1(&[1, 0]);
    let firing = bench.load_fails();
    bench.answer("in-machine");
    bench.sim.now = bench.sim.now + Duration::from_secs(3600);
    bench.sim.coordination.stood(bench.sim.now);
    bench.say(PlayerInput::Starts(true));
    assert!(bench.firing(LOAD).is_some_and(|of| of.id == firing.id), "it was compared with nothing");
    bench.seconds_later(5.0);
    let text = &bench.alarm().text;
    assert!(text.starts_with("Answer \"in-machine\" contradicts the sensors: M1"), "{text}");
}
