//! A rule that puts stations into emergency stop: at once, over restarts, until they are reset.

use linewright_coordinator_cell::exception::{
    Alarm, AlarmAnswerRefusal, AlarmSubject, ExceptionStep, OutOfServiceReason, ResourceRequest, isolated,
};
use linewright_coordinator_cell::{ActivityPhase, PartId, PlayerInput, PlayerState, RecordKind};
use linewright_line::StationId;

use super::bench::{CellBench, workcell};

const LOAD: &str = "load M1<A.new>";

fn stopping(which: &str) -> CellBench {
    let rule = format!("retries = 2\nemergency_stop = [{which}]");
    CellBench::new(&workcell().replace("retries = 2", &rule), &[1, 0])
}

impl CellBench {
    fn stopped(&self) -> Vec<StationId> {
        self.state().exceptions().stopped().collect()
    }

    /// The loading runs out of time.
    fn load_runs_out(&mut self) {
        self.at("robot").is_stuck = true;
        self.at("m1").is_stuck = true;
        self.until_that(|bench| bench.firing(LOAD).is_some_and(|of| of.phase != ActivityPhase::Running));
    }
}

#[test]
fn its_stations_stop_and_the_resources_are_left_out() {
    let mut bench = stopping("\"*\"");
    bench.load_runs_out();
    let [robot, m1] = ["robot", "m1"].map(|name| bench.station(name));
    let firing = bench.firing(LOAD).expect("it has failed").id;
    assert_eq!(bench.stopped().len(), 2);
    let raised =
        bench.sim.log.iter().position(|record| matches!(record.fact, RecordKind::Raised { .. })).expect("it was");
    let next: Vec<_> = bench.sim.log[raised + 1..raised + 3].iter().map(|record| &record.fact).collect();
    assert!(
        next.iter().all(|fact| matches!(fact, RecordKind::Exception(ExceptionStep::Stopped { .. }))),
        "at once: {next:?}"
    );
    assert!(isolated(bench.state()).is_superset(&[robot, m1].into()));
    let because = OutOfServiceReason::EmergencyStop(firing);
    assert_eq!(bench.down(), [("M1".to_owned(), because.clone()), ("R".to_owned(), because)]);

    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let text = bench.alarm().text.clone();
    assert!(text.ends_with("robot: in emergency stop, m1: in emergency stop)"), "{text}");
    assert!(bench.at("m1").is_held && bench.at("robot").is_held);
    let first = ["robot", "m1"].map(|name| format!("`linewright resource … {name} reset`")).join(" and ");
    assert!(
        text.starts_with(&format!("First {first}, then lead robot and m1 to a rest in manual, as `linewright recover` lists it: all to the end or all back. ")),
        "{text}"
    );
    let asked = ResourceRequest::Answer(bench.alarm().id);
    bench.answer("in-store");
    let stopped = AlarmAnswerRefusal::EmergencyStop(robot);
    assert_eq!(bench.objections().last(), Some(&(asked, stopped)), "in manual it would not move");
}

/// Answered, led to a rest and up: none of it is possible without a reset, or instead of one.
#[test]
fn only_a_reset_leads_out() {
    let mut bench = stopping("\"m1\"");
    bench.load_runs_out();
    let (m1, station) = (bench.resource("M1"), bench.station("m1"));
    assert_eq!(bench.stopped(), [station]);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let now = bench.sim.now;
    for name in ["m1", "robot"] {
        bench.at(name).is_stuck = false;
        bench.at(name).bring_to_rest(now);
    }
    bench.seconds_later(2.0);
    let firing = bench.firing(LOAD).expect("it is open").id;
    bench.answer("in-store");
    bench.closed(firing);
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Up(m1), AlarmAnswerRefusal::EmergencyStop(station))));
    assert_eq!(bench.stopped(), [station]);

    bench.say(PlayerInput::Reset(station));
    assert_eq!((bench.stopped(), bench.state().exceptions().is_down(m1).is_some()), (vec![], true));
    bench.say(PlayerInput::Reset(station));
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Reset(station), AlarmAnswerRefusal::AlreadySo)));
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    bench.all_leave(1);
}

/// An alarm about a resource alone names the reset as well: nothing else is taken before it.
#[test]
fn an_alarm_of_a_resource_names_its_station_that_is_to_be_reset() {
    let mut bench = stopping("\"m3\"");
    let m3 = bench.resource("M3");
    (bench.at("robot").is_stuck, bench.at("m1").is_stuck) = (true, true);
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    bench.say(PlayerInput::Resource { resource: m3, up: false });
    bench.sim.truth.put(PartId(99), Some(m3));
    bench.seconds_later(1.0);
    bench.say(PlayerInput::Resource { resource: m3, up: true });
    bench.until_that(|bench| bench.firing(LOAD).is_some_and(|of| of.phase != ActivityPhase::Running));
    let about = |alarm: &&Alarm| alarm.about == AlarmSubject::Resource(m3);
    let alarm = bench.state().exceptions().alarms().find(about).expect("a part too many").clone();
    assert_eq!(bench.sim.coordination.alarm_leads(bench.sim.now, &alarm).reset, [bench.station("m3")]);
}

/// Reset while the activity is still open it does not stop again by the same rule.
#[test]
fn one_failure_stops_a_station_once() {
    let mut bench = stopping("\"m1\"");
    (bench.at("robot").is_stuck, bench.at("m1").is_stuck) = (true, true);
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    bench.seconds_later(23.0);
    // The robot is not known to stand.
    bench.at("robot").is_away = true;
    bench.load_runs_out();
    let station = bench.station("m1");
    bench.seconds_later(0.3);
    assert_eq!(bench.state().exceptions().alarms().len(), 0);
    bench.say(PlayerInput::Reset(station));
    assert_eq!(bench.stopped(), [], "{:?}", bench.objections());
    bench.at("robot").is_away = false;
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    assert_eq!(bench.stopped(), []);
    let times = bench.steps().into_iter().filter(|step| matches!(step, ExceptionStep::Stopped { .. })).count();
    assert_eq!(times, 1);
}

/// A station that has nothing to do with the failure stops as well, and what it is doing fails by that.
#[test]
fn a_station_of_another_activity_can_be_named() {
    let mut bench = stopping("\"m3\"");
    bench.load_runs_out();
    let (m3, station) = (bench.resource("M3"), bench.station("m3"));
    assert_eq!(bench.stopped(), [station]);
    assert!(bench.state().exceptions().is_down(m3).is_some() && isolated(bench.state()).contains(&station));
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    assert!(bench.alarm().text.ends_with("m3: in emergency stop)"), "{}", bench.alarm().text);
}

/// One that is not received, or that was received at its order, is not reset: it may not have stopped.
#[test]
fn a_station_is_reset_when_it_is_known_to_stand() {
    let mut bench = stopping("\"m1\"");
    bench.at("m1").is_stuck = true;
    bench.load_runs_out();
    let station = bench.station("m1");
    bench.say(PlayerInput::Reset(station));
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Reset(station), AlarmAnswerRefusal::Moves(station))));
    bench.at("m1").is_away = true;
    bench.seconds_later(5.0);
    bench.say(PlayerInput::Reset(station));
    assert_eq!(
        bench.objections().last(),
        Some(&(ResourceRequest::Reset(station), AlarmAnswerRefusal::NotHeard(station)))
    );
    assert_eq!(bench.stopped(), [station]);
}

/// Whichever record is the last of its life, the stations are stopped in the next.
#[test]
fn the_stop_outlives_the_coordinator() {
    let mut calm = stopping("\"*\"");
    calm.load_runs_out();
    let first = calm.sim.steps;
    for at in first - 8..first + 2 {
        let mut bench = stopping("\"*\"");
        bench.sim.options.crash_at = vec![at];
        bench.load_runs_out();
        bench.seconds_later(2.0);
        assert_eq!((bench.sim.lives, bench.stopped().len()), (2, 2), "at {at}");
        assert_eq!(bench.down().len(), 2, "at {at}");
        // And over a snapshot.
        let again = PlayerState::restore(bench.table.clone(), bench.state().snapshot()).expect("it is its own");
        assert_eq!(again.exceptions().stopped().count(), 2);
        assert!(again.exceptions() == bench.state().exceptions(), "at {at}");
    }
}
