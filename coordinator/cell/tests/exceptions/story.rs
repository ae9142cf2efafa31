//! The exception of seed 001 §6 (L214-229), line by line, on its cell.

use linewright_coordinator_cell::exception::{
    AlarmSubject, AnsweredBy, ExceptionStep, RecoveryDecision, SecuredState, Strategy, Whereabouts,
};
use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, OrderFailure, PartId, PartPlace, Presence, RecordKind,
};
use linewright_line::Tick;

use super::bench::{CellBench, workcell, workcell_line};

const LOAD: &str = "load M1<A.new>";
const P1_01: PartId = PartId(1);

#[test]
fn the_robot_comes_without_the_part_and_the_load_is_tried_again_and_succeeds() {
    let mut bench = CellBench::c1(&[1, 0]);
    // "the robot grasping operation fails and the approach to M1 is made with no part. Both controllers, from machine and
    // robot, reach a deadlock" (L229): neither ends.
    bench.at("robot").is_stuck = true;
    bench.at("m1").waits_to_begin = true;
    // "Loading part P1-01 on machine M1 involves the firing of transition load-M1 and the execution of the task"; "the
    // interpreter removes the involved tokens from the input places"; "orders to the robot and M1 controllers are sent by
    // the task" (L218).
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    let firing = bench.firing(LOAD).unwrap().clone();
    let tokens =
        |bench: &CellBench| ["R.free", "M1.available-capacity", "ST.stored-parts<A.new>"].map(|name| bench.count(name));
    assert_eq!((firing.part, tokens(&bench)), (Some(P1_01), [0, 0, 0]));
    let told: Vec<_> = firing.orders.iter().map(|order| order.station).collect();
    assert_eq!(told, [bench.station("robot"), bench.station("m1")]);
    // "a watchdog can be included in the corresponding active task. When the maximum time of an operation has been reached
    // (detection)" (L229): 24 s for the robot, which is less than the 26 s for M1.
    let limit = firing.began.as_secs_f64() + 24.0;
    bench.until(limit - 0.01);
    assert_eq!(bench.firing(LOAD).map(|firing| firing.phase), Some(ActivityPhase::Running));
    bench.news();
    bench.until(limit + 0.001);
    // "the associated task communicates the error to the exception handling module and finishes its execution" (L229).
    let cause = ActivityFailure::Order { key: firing.orders[0].key, failure: OrderFailure::TimedOut };
    assert_eq!(
        bench.news(),
        [
            RecordKind::OrderFailed { key: firing.orders[0].key, failure: OrderFailure::TimedOut },
            RecordKind::Raised { firing: firing.id, cause },
        ]
    );
    // "First, orders will be sent to the local controllers to conduct the resources to a secure state" (L229).
    bench.until_that(|bench| bench.at_rest(&["robot", "m1"]));
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let secured: Vec<_> = bench.steps().into_iter().take(2).cloned().collect();
    for order in &firing.orders {
        let of = ExceptionStep::Secured {
            firing: firing.id,
            key: order.key,
            standing: SecuredState::AtRest,
            fault: String::new(),
        };
        assert!(secured.contains(&of), "{secured:?}");
    }
    // "After that, an alarm signal will be sent to the production plant to notify the operator about the arisen error. This
    // notification is a request for the operator to provide the adequate correcting actions" (L229).
    let alarm = bench.alarm().clone();
    assert_eq!(alarm.about, AlarmSubject::Firing(firing.id));
    assert_eq!(
        alarm.text,
        "R came to M1 without part 1. Put the part back into slot 1 of ST. (load M1: robot: time limit exceeded: 24 s, \
         `max_s` of its order in cell.toml, after 24 s)"
    );
    assert_eq!(alarm.words, ["in-store", "in-machine", "scrap"]);
    // It stands until there is an answer; nothing else happens to the part meanwhile.
    let later = bench.sim.now.as_secs_f64() + 600.0;
    bench.news();
    bench.until(later);
    assert_eq!((bench.news(), bench.alarm().id, tokens(&bench)), (vec![], alarm.id, [0, 0, 0]));
    // "In this case, the operator must place the part correctly. Additionally, the exception handling module must be notified
    // about the exception origin (diagnosis)" (L229).
    assert_eq!((bench.sim.truth.at(P1_01), bench.presence("m1")), (Some(bench.resource("ST")), Presence::Off));
    bench.at("robot").is_stuck = false;
    bench.at("m1").waits_to_begin = false;
    bench.answer("in-store");
    let ruling = RecoveryDecision { word: "in-store".to_owned(), part: Whereabouts::From, then: Strategy::Redo };
    let answered = ExceptionStep::Answered { firing: firing.id, ruling: ruling.clone(), by: AnsweredBy::Operator };
    assert_eq!(bench.news(), [RecordKind::Exception(answered)]);
    // "recovering the previous marking to the exception which represents the cell actual state (robot free, machine M1 free
    // and part P1-01 in the store). At this point, the interpreter will try to fire the transition again" (L229).
    bench.until_that(|bench| bench.firing(LOAD).is_some_and(|again| again.id != firing.id));
    let news = bench.news();
    let closed =
        ExceptionStep::Closed { firing: firing.id, mode: firing.mode, part: Some(P1_01), ruling, unchecked: vec![] };
    assert_eq!(news[0], RecordKind::Exception(closed));
    let between = bench.state_after(&news[0]);
    for (name, count) in [("R.free", 1), ("M1.available-capacity", 1), ("ST.stored-parts<A.new>", 1)] {
        assert_eq!(between.marking().count(bench.cell(name)), count, "{name}");
    }
    assert!(
        matches!(between.part(P1_01).unwrap().place, PartPlace::On { cell, .. } if cell == bench.cell("ST.stored-parts<A.new>"))
    );
    let [RecordKind::Decided { started, .. }, RecordKind::Started { mode, part, .. }] = &news[1..3] else {
        panic!("{news:?}")
    };
    assert_eq!((&started[..], *mode, *part), (&[(firing.mode, Some(P1_01))][..], firing.mode, Some(P1_01)));
    assert_eq!(bench.state().exceptions().times(firing.mode, Some(P1_01)), 1);
    // "On finishing transition load-M1 firing (...) part P1-01 will be loaded on machine M1 and the robot will become free"
    // (L226); "to continue in normal operation" (L229).
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    assert_eq!((bench.count("R.free"), bench.presence("m1")), (1, Presence::On));
    bench.until(3600.0);
    assert_eq!((bench.state().left(), bench.state().parts().len(), bench.state().exceptions().scrapped()), (1, 0, 0));
    assert!(bench.state().exceptions().open().next().is_none() && bench.sim.events.is_empty());
    assert!(bench.sim.now < Tick::from_millis(3_600_000));
}

impl CellBench {
    fn at_rest(&self, names: &[&str]) -> bool {
        names.iter().all(|name| {
            let station = &self.sim.stations[self.station(name).index()];
            station.doing().is_none() && !station.is_held
        })
    }

    /// State of the cell by the records up to one.
    fn state_after(&self, fact: &RecordKind) -> linewright_coordinator_cell::PlayerState {
        let at = self.sim.log.iter().rposition(|record| record.fact == *fact).expect("it was written");
        linewright_coordinator_cell::PlayerState::replay(self.table.clone(), &self.sim.log[..=at]).expect("it fits")
    }
}

/// The normal course (L214, L218, L226): nothing of all this.
#[test]
fn without_a_fault_nobody_is_told_anything() {
    let mut bench = CellBench::c1(&[3, 3]);
    bench.until(7200.0);
    assert_eq!((bench.state().left(), bench.steps().len()), (6, 0));
    let orders = bench.sim.stations.iter().flat_map(|station| &station.ended);
    assert!(orders.clone().all(|(_, outcome, _)| *outcome == linewright_coordinator_cell::TaskOutcome::Done));
    assert_eq!(orders.count(), 6 * 10);
}

/// Where it is left out `time_s` is no key of the file: the alarm names the operations.
#[test]
fn the_alarm_of_an_order_without_a_limit_names_what_its_time_is_of() {
    let alarm_of = |time_s: &str| {
        let text = workcell().replacen(", max_s = 24", "", 1).replacen(", max_s = 26", ", max_s = 100", 1);
        let text = text.replacen("time_s = 12 # as planned", time_s, 1);
        let mut bench = CellBench::beside(&text, &workcell_line(|line| line), &[1, 0]);
        bench.at("robot").is_stuck = true;
        bench.at("m1").waits_to_begin = true;
        bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
        bench.alarm().text.clone()
    };
    let (written, left_out) = (alarm_of("time_s = 12"), alarm_of(""));
    let limit = "robot: time limit exceeded: 24 s, in cell.toml `safety` = 2 times `time_s` = 12,";
    assert!(written.contains(limit), "{written}");
    let limit =
        "robot: time limit exceeded: 30 s, in cell.toml `safety` = 2 times the 15 s of the operations of its tasks,";
    assert!(left_out.contains(limit), "{left_out}");
}
