//! Effect of each answer on marking and parts, and alarms where an answer cannot be.

use std::time::Duration;

use linewright_coordinator_cell::dispatch::why_resource;
use linewright_coordinator_cell::exception::{
    AlarmAnswerRefusal, AlarmSubject, AnsweredBy, ExceptionStep, OutOfServiceReason, ResourceRequest, SecuredState,
    Strategy,
};
use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, CellEvent, FiringId, OngoingActivity, OrderFailure, PartId, PlayerInput,
    PlayerState, Presence, Record, RecordKind, StationUnavailable,
};

use super::bench::{CellBench, workcell};

const LOAD: &str = "load M1<A.new>";
const PART: PartId = PartId(1);
const ANSWERS: &str = "{ word = \"scrap\", part = \"gone\", then = \"backward\" },";

/// The rule of C1 with other answers beside `in-store` and `in-machine`.
fn answering(others: &str) -> String {
    workcell().replace(ANSWERS, others)
}

impl CellBench {
    /// Robot and machine wait for each other until both have come to rest and an alarm is raised.
    pub fn load_fails(&mut self) -> OngoingActivity {
        self.at("robot").is_stuck = true;
        self.at("m1").waits_to_begin = true;
        self.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
        self.at("robot").is_stuck = false;
        self.at("m1").waits_to_begin = false;
        self.firing(LOAD).expect("it has failed").clone()
    }

    pub fn closed(&mut self, firing: FiringId) -> ExceptionStep {
        let is_it = |step: &ExceptionStep| matches!(step, ExceptionStep::Closed { firing: of, .. } if *of == firing);
        self.until_that(|bench| bench.steps().into_iter().any(is_it));
        self.steps().into_iter().find(|step| is_it(step)).expect("it is closed").clone()
    }

    /// The state before a record, and after it.
    pub fn around(&self, is: impl Fn(&RecordKind) -> bool) -> [PlayerState; 2] {
        let at = self.sim.log.iter().position(|record| is(&record.fact)).expect("it was written");
        [at, at + 1].map(|end| PlayerState::replay(self.table.clone(), &self.sim.log[..end]).expect("it fits"))
    }

    /// Changes by an activity from before its start until after its end: of each cell that changed its name.
    pub fn changed(&self, firing: FiringId) -> Vec<(String, i64)> {
        let [before, _] = self.around(|fact| matches!(fact, RecordKind::Started { firing: of, .. } if *of == firing));
        let ends = |fact: &RecordKind| matches!(fact, RecordKind::Exception(ExceptionStep::Closed { firing: of, .. }) if *of == firing);
        let [_, after] = self.around(ends);
        let of = |state: &PlayerState, cell| state.marking().count(cell) as i64;
        let all = self
            .table
            .cells()
            .map(|cell| (self.table.cell_name(cell).to_owned(), of(&after, cell) - of(&before, cell)));
        all.filter(|(_, by)| *by != 0).collect()
    }

    pub fn all_leave(&mut self, parts: u64) {
        self.until_that(|bench| bench.state().left() == parts);
        assert_eq!(self.state().parts().len(), 0);
    }

    pub fn objections(&self) -> Vec<(ResourceRequest, AlarmAnswerRefusal)> {
        let objected = |(_, event): &(_, CellEvent)| match event {
            CellEvent::Objected { to, why } => Some((*to, *why)),
            CellEvent::BadAnswer { .. } | CellEvent::Superseded { .. } | CellEvent::Busy { .. } => None,
        };
        self.sim.events.iter().filter_map(objected).collect()
    }

    pub fn down(&self) -> Vec<(String, OutOfServiceReason)> {
        let name = |id| self.table.handling().resource_name(id).to_owned();
        self.state().exceptions().down().map(|(id, down)| (name(id), down.why.clone())).collect()
    }
}

fn named(list: &[(&str, i64)]) -> Vec<(String, i64)> {
    list.iter().map(|&(name, by)| (name.to_owned(), by)).collect()
}

/// `from`: exactly what the start took. Backward: it is decided anew.
#[test]
fn where_it_was_all_is_as_before_and_it_is_decided_anew() {
    let mut bench = CellBench::new(&answering("{ word = \"back\", part = \"from\", then = \"backward\" },"), &[1, 0]);
    let firing = bench.load_fails();
    bench.answer("back");
    let closed = bench.closed(firing.id);
    assert!(matches!(closed, ExceptionStep::Closed { ref ruling, .. } if ruling.then == Strategy::Backward));
    assert_eq!(bench.changed(firing.id), []);
    assert_eq!(bench.state().exceptions().times(firing.mode, firing.part), 0);
    bench.all_leave(1);
}

/// `to`: exactly what the end gives.
#[test]
fn where_it_was_to_go_all_is_as_if_it_were_done() {
    let mut bench = CellBench::c1(&[1, 0]);
    let firing = bench.load_fails();
    bench.sim.truth.put(PART, Some(bench.resource("M1")));
    bench.seconds_later(1.0);
    bench.answer("in-machine");
    bench.closed(firing.id);
    let expected = [
        ("M1.available-capacity", -1),
        ("M1.loaded<A.new>", 1),
        ("ST.available-capacity", 1),
        ("ST.stored-parts<A.new>", -1),
    ];
    let mut changed = bench.changed(firing.id);
    changed.sort();
    assert_eq!(changed, named(&expected));
    let is_load = |record: &&Record| matches!(record.fact, RecordKind::Started { mode, .. } if mode == firing.mode);
    let loads = bench.sim.log.iter().filter(is_load);
    assert_eq!(loads.count(), 1);
    bench.all_leave(1);
}

/// `gone`: the part is no more, its place, old or new, has room, and another one comes instead.
#[test]
fn where_there_is_no_part_any_more_another_one_comes() {
    let mut bench = CellBench::c1(&[1, 0]);
    let firing = bench.load_fails();
    bench.sim.truth.put(PART, None);
    bench.answer("scrap");
    bench.closed(firing.id);
    let mut changed = bench.changed(firing.id);
    changed.sort();
    let expected = [
        ("ST.available-capacity", 1),
        ("ST.stored-parts<A.new>", -1),
        ("outside.room", 1),
        ("outside.waiting<A.new>", 1),
    ];
    assert_eq!(changed, named(&expected));
    assert_eq!((bench.state().part(PART), bench.state().exceptions().scrapped()), (None, 1));
    bench.all_leave(1);
    assert!(
        bench.sim.log.iter().any(|record| matches!(record.fact, RecordKind::Started { part: Some(PartId(2)), .. }))
    );
}

/// The same for a part that is worked on.
#[test]
fn a_part_that_breaks_while_it_is_worked_on_is_gone() {
    let mut bench = CellBench::c1(&[2, 0]);
    bench.at("m1").fails_with = None;
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    bench.at("m1").fails_with = Some(7);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let firing = bench.firing("M1.process<A.new>").expect("it has failed").clone();
    assert_eq!(bench.alarm().words, ["as-before", "as-done", "gone"]);
    assert!(bench.alarm().text.starts_with(
        "M1.process with part 1 failed. Answer where the part is. (m1: awaited input not on in time (code 7), after "
    ));
    bench.sim.truth.put(PART, None);
    bench.seconds_later(1.0);
    bench.answer("gone");
    bench.closed(firing.id);
    bench.until_that(|bench| bench.state().left() == 2);
    assert_eq!((bench.state().parts().len(), bench.state().exceptions().scrapped()), (0, 1));
}

/// `carrier`: what it was to give is not given, and there is another alarm. Refused unless its gripper has the part.
#[test]
fn a_part_in_the_hand_is_asked_about_until_it_has_been_brought() {
    let mut bench =
        CellBench::new(&answering("{ word = \"in-hand\", part = \"carrier\", then = \"forward\" },"), &[1, 0]);
    bench.at("robot").holds = true;
    let firing = bench.load_fails();
    bench.answer("in-hand");
    let (robot, alarm) = (bench.resource("R"), bench.alarm().id);
    assert_eq!(bench.objections(), [(ResourceRequest::Answer(alarm), AlarmAnswerRefusal::HasNoPart(robot))]);
    bench.sim.truth.put(PART, Some(robot));
    bench.seconds_later(1.0);
    bench.answer("in-store");
    let half_way = (ResourceRequest::Answer(alarm), AlarmAnswerRefusal::NotAtRest(bench.station("robot")));
    assert_eq!(bench.objections().last(), Some(&half_way), "said before anything about the part");
    bench.answer("in-hand");
    bench.until_that(|bench| bench.steps().contains(&&ExceptionStep::Carried { firing: firing.id }));
    assert_eq!(bench.alarm().words, ["as-before", "as-done", "gone"]);
    assert_eq!(bench.alarm().text, "R holds part 1. Move it to M1 or back to ST, then answer which.");
    assert_eq!(bench.firing(LOAD).map(|firing| firing.id), Some(firing.id));
    // Somebody brings it, and leaves the robot where it stands: M1 is not given free with the robot in it.
    bench.sim.truth.put(PART, Some(bench.resource("M1")));
    bench.seconds_later(1.0);
    bench.answer("as-done");
    let (station, asked) = (bench.station("robot"), ResourceRequest::Answer(bench.alarm().id));
    assert_eq!(bench.objections().last(), Some(&(asked, AlarmAnswerRefusal::NotAtRest(station))));
    let now = bench.sim.now;
    bench.at("robot").bring_to_rest(now);
    bench.at("robot").holds = false;
    bench.seconds_later(1.0);
    bench.answer("as-done");
    bench.closed(firing.id);
    assert!(
        bench.steps().iter().any(|step| matches!(step, ExceptionStep::Secured { standing: SecuredState::Held, .. }))
    );
    assert_eq!(bench.down(), []);
    bench.all_leave(1);
}

/// Alternatives of the plan are what is left while a machine is down.
#[test]
fn while_m1_is_down_parts_go_over_m2() {
    let mut bench = CellBench::new(
        &answering("{ word = \"broken\", part = \"from\", then = \"backward\", down = [\"to\"] },"),
        &[3, 0],
    );
    let firing = bench.load_fails();
    bench.answer("broken");
    bench.closed(firing.id);
    assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Rule(firing.id))]);
    assert!(!bench.state().enabling().is_enabled(firing.mode) && bench.count("M1.available-capacity") == 1);
    let from = bench.sim.log.len();
    bench.all_leave(3);
    let started = |record: &Record| match record.fact {
        RecordKind::Started { mode, .. } => Some(bench.table.mode_name(mode)),
        _ => None,
    };
    let later: Vec<_> = bench.sim.log[from..].iter().filter_map(started).collect();
    assert!(later.iter().all(|name| !name.contains("M1")), "{later:?}");
    let all = bench.sim.log.iter().filter_map(started);
    assert_eq!(all.filter(|name| *name == "load M2<A.new>").count(), 3);
    let m1 = bench.resource("M1");
    let since = bench.state().exceptions().is_down(m1).expect("it is down").since;
    let why = why_resource(&bench.sim.coordination, since + Duration::from_secs(9), m1);
    assert_eq!(
        why,
        [
            "M1 out of service for 9 s: taken out by the rule for `load M1` with part 1.",
            "Nothing is against it now: `up` counts on M1 again.",
        ]
    );
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    assert_eq!(bench.steps().last(), Some(&&ExceptionStep::Up { resource: m1, unchecked: false }));
    assert_eq!(why_resource(&bench.sim.coordination, bench.sim.now, m1), ["M1 in service."]);
}

/// What needs no person is done without, as often as the rule has it.
#[test]
fn an_automatic_rule_asks_when_its_retries_are_used_up() {
    let mut bench = CellBench::new(&workcell().replace("retries = 2", "retries = 2\nautomatic = true"), &[1, 0]);
    let firing = bench.load_fails();
    let by: Vec<AnsweredBy> = bench
        .steps()
        .into_iter()
        .filter_map(|step| if let ExceptionStep::Answered { by, .. } = step { Some(*by) } else { None })
        .collect();
    assert_eq!(
        (by, bench.alarm().words.as_slice()),
        (vec![AnsweredBy::Rule; 2], &["in-store", "in-machine", "scrap"].map(str::to_owned)[..])
    );
    assert_eq!(bench.state().exceptions().times(firing.mode, firing.part), 2);
    let text = &bench.alarm().text;
    assert!(text.contains("repeated 2 times already") && text.contains("`retries` of its [[exception]]"), "{text}");
    // An alarm is raised as well where a station is not at rest.
    let mut bench = CellBench::new(&workcell().replace("retries = 2", "retries = 2\nautomatic = true"), &[1, 0]);
    bench.at("robot").holds = true;
    bench.load_fails();
    assert_eq!(bench.alarm().words, ["in-store", "in-machine", "scrap"]);
    assert!(!bench.alarm().text.contains("repeated"), "{}", bench.alarm().text);
}

/// A lie does not go silently, and changes nothing.
#[test]
fn an_answer_that_sensors_contradict_is_asked_about_again() {
    let mut bench = CellBench::c1(&[1, 0]);
    let firing = bench.load_fails();
    let before = bench.state().marking().clone();
    let first = bench.alarm().id;
    bench.answer("in-machine");
    bench.until_that(|bench| bench.steps().iter().any(|step| matches!(step, ExceptionStep::Mismatch { .. })));
    let m1 = bench.resource("M1");
    let Some(ExceptionStep::Mismatch { about, found }) =
        bench.steps().into_iter().find(|step| matches!(step, ExceptionStep::Mismatch { .. }))
    else {
        unreachable!()
    };
    assert_eq!((*about, found.len()), (AlarmSubject::Firing(firing.id), 1));
    assert_eq!((found[0].resource, found[0].model, found[0].plant), (m1, true, false));
    assert!(bench.alarm().id > first && bench.state().marking() == &before);
    assert!(
        bench
            .alarm()
            .text
            .starts_with("Answer \"in-machine\" contradicts the sensors: M1: part expected, sensor off. R came to M1")
    );
    bench.answer("in-store");
    bench.all_leave(1);
}

#[test]
fn where_no_sensor_says_anything_it_is_noted_that_nobody_has_looked() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.sim.senses = false;
    for station in &mut bench.sim.stations {
        station.presence = Presence::NoSensor;
    }
    let firing = bench.load_fails();
    bench.answer("in-store");
    let ExceptionStep::Closed { unchecked, .. } = bench.closed(firing.id) else { unreachable!() };
    assert_eq!(unchecked, [bench.resource("M1"), bench.resource("R")]);
}

/// A station that is not received is not waited for for ever, and it is out of service when the activity is closed.
#[test]
fn a_station_that_is_lost_is_told_of_and_left_out() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    bench.at("robot").is_away = true;
    bench.at("m1").waits_to_begin = true;
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let firing = bench.firing(LOAD).expect("it has failed").clone();
    let lost = ActivityFailure::Order { key: firing.orders[0].key, failure: OrderFailure::Lost };
    assert_eq!(firing.phase, ActivityPhase::Failed(lost));
    assert!(bench.alarm().text.ends_with("; robot: rest not confirmed)"), "{}", bench.alarm().text);
    assert_eq!(bench.alarm().words, ["as-before", "as-done", "gone"], "C1's rule is for what takes too long");
    bench.at("m1").waits_to_begin = false;
    let robot = bench.resource("R");
    bench.answer("as-before");
    let refused = AlarmAnswerRefusal::Unheard(bench.station("robot"), robot);
    assert_eq!(bench.objections(), [(ResourceRequest::Answer(bench.alarm().id), refused)]);
    bench.say(PlayerInput::Resource { resource: robot, up: false });
    bench.answer("as-before");
    bench.closed(firing.id);
    assert_eq!(bench.down().len(), 3, "{:?}", bench.down());
    bench.say(PlayerInput::Resource { resource: robot, up: true });
    assert_eq!(
        bench.objections().last(),
        Some(&(ResourceRequest::Up(robot), AlarmAnswerRefusal::NotHeard(bench.station("robot"))))
    );
    bench.at("robot").is_away = false;
    bench.seconds_later(2.0);
    for resource in ["R", "M1", "ST"].map(|name| bench.resource(name)) {
        bench.say(PlayerInput::Resource { resource, up: true });
    }
    bench.all_leave(1);
}

#[test]
fn a_station_without_its_memory_and_one_without_its_devices_are_told_of() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("m1").waits_to_begin = true;
    bench.until_that(|bench| bench.firing(LOAD).is_some());
    bench.at("robot").forget();
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let text = bench.alarm().text.clone();
    assert!(text.contains("Answer where the part is. (robot: order lost, with its memory of orders,"), "{text}");
    assert!(text.ends_with("robot: restarted without its memory of orders)"), "{text}");
    bench.at("m1").waits_to_begin = false;
    bench.answer("as-before");
    bench.all_leave(1);

    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("m1").waits_to_begin = true;
    bench.until_that(|bench| bench.sim.stations[bench.station("robot").index()].doing().is_some());
    bench.at("robot").unable = Some(StationUnavailable::Devices);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    assert!(bench.alarm().text.contains("(robot: I/O devices lost,"), "{}", bench.alarm().text);
    bench.at("m1").waits_to_begin = false;
    let firing = bench.firing(LOAD).expect("it has failed").id;
    bench.answer("as-before");
    bench.closed(firing);
    assert_eq!(bench.down(), [("R".to_owned(), OutOfServiceReason::Station(firing))]);
    let robot = bench.resource("R");
    bench.say(PlayerInput::Resource { resource: robot, up: true });
    let why = AlarmAnswerRefusal::CannotWork(bench.station("robot"), StationUnavailable::Devices);
    assert_eq!(bench.objections(), [(ResourceRequest::Up(robot), why)]);
    bench.at("robot").unable = None;
    bench.seconds_later(2.0);
    bench.say(PlayerInput::Resource { resource: robot, up: true });
    bench.all_leave(1);
}

/// An alarm by hand stops what the resource is doing, and leaves it out.
/// Each restart compares model and plant; a difference leaves the resource out until it is put right.
#[test]
fn after_a_restart_a_part_too_many_is_found() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    let (m2, foreign) = (bench.resource("M2"), PartId(99));
    bench.sim.truth.put(foreign, Some(m2));
    bench.sim.options.crash_at = vec![bench.sim.steps];
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    assert_eq!((bench.sim.lives, bench.down()), (2, vec![("M2".to_owned(), OutOfServiceReason::Mismatch)]));
    assert_eq!(bench.alarm().about, AlarmSubject::Resource(m2));
    assert_eq!(
        (bench.alarm().text.as_str(), bench.alarm().words.as_slice()),
        ("M2: no part expected, sensor on. Correct it, then answer \"up\".", &["up".to_owned()][..])
    );
    let since = bench.state().exceptions().is_down(m2).expect("it is down").since;
    assert_eq!(
        why_resource(&bench.sim.coordination, since, m2),
        [
            "M2 out of service for 0 s: sensor contradicts the model.".to_owned(),
            format!("{}: {}", bench.alarm().id, bench.alarm().text)
        ]
    );
    let first = bench.alarm().id;
    bench.answer("up");
    assert_eq!(bench.alarm().id, first, "it has not been put right, and the same is asked");
    let contradicted = AlarmAnswerRefusal::Contradicted(m2);
    assert_eq!(bench.objections(), [(ResourceRequest::Answer(first), contradicted)]);
    bench.say(PlayerInput::Resource { resource: m2, up: true });
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Up(m2), contradicted)));
    bench.sim.truth.put(foreign, None);
    bench.seconds_later(1.0);
    bench.answer("up");
    assert_eq!((bench.down(), bench.state().exceptions().alarms().len()), (vec![], 0));
    bench.all_leave(1);
}

/// A part that was taken away is no more, if the operator answers so and the sensor agrees; another is made in its
/// place.
#[test]
fn a_part_that_is_missing_where_it_rested_can_be_given_up() {
    for (activity, idle, stage) in
        [(LOAD, "m1", "M1.loaded<A.new>"), ("M1.process<A.new>", "robot", "M1.unload-ready<A.turn>")]
    {
        let mut bench = CellBench::c1(&[1, 0]);
        let (part, before) = bench.taken_away(activity, idle, stage);
        let m1 = bench.resource("M1");
        assert_eq!(bench.state().marking().counts(), before, "nothing is changed by a sensor");
        assert_eq!(
            (bench.alarm().text.clone(), bench.alarm().words.as_slice()),
            (
                format!(
                    "M1: part expected, sensor off. Correct it, then answer \"up\"; if {part} was removed, answer \
                     \"gone\"."
                ),
                &["up".to_owned(), "gone".to_owned()][..]
            )
        );
        bench.answer("gone");
        let steps = bench.steps();
        assert_eq!(steps.last(), Some(&&ExceptionStep::Up { resource: m1, unchecked: false }));
        assert!(
            matches!(steps[steps.len() - 2], ExceptionStep::Missing { resource, part: of, .. } if (*resource, *of) == (m1, part))
        );
        assert_eq!((bench.down(), bench.count(stage), bench.state().exceptions().scrapped()), (vec![], 0, 1));
        bench.all_leave(1);
    }
}

/// While the sensor sees it, a part is there whatever the answer.
#[test]
fn a_part_that_a_sensor_sees_is_not_given_up() {
    let mut bench = CellBench::c1(&[1, 0]);
    let (part, _) = bench.taken_away(LOAD, "m1", "M1.loaded<A.new>");
    let m1 = bench.resource("M1");
    bench.sim.truth.put(part, Some(m1));
    bench.works("m1");
    let alarm = bench.alarm().id;
    bench.answer("gone");
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Answer(alarm), AlarmAnswerRefusal::HasPart(m1))));
    bench.answer("up");
    bench.all_leave(1);
}

/// A request about what does not exist is refused.
#[test]
fn what_there_is_not_cannot_be_answered() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.load_fails();
    let (alarm, m1) = (bench.alarm().id, bench.resource("M1"));
    let none = linewright_coordinator_cell::ResourceId(77);
    bench.say(PlayerInput::Answer { alarm, word: "in-the-pocket" });
    bench.say(PlayerInput::Answer { alarm: linewright_coordinator_cell::AlarmId(9), word: "in-store" });
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    bench.say(PlayerInput::Alarm { resource: none, text: "" });
    bench.say(PlayerInput::Resource { resource: none, up: false });
    let expected = [
        (ResourceRequest::Answer(alarm), AlarmAnswerRefusal::NoSuchWord),
        (ResourceRequest::Answer(linewright_coordinator_cell::AlarmId(9)), AlarmAnswerRefusal::NoSuchAlarm),
        (ResourceRequest::Up(m1), AlarmAnswerRefusal::AlreadySo),
        (ResourceRequest::Alarm(none), AlarmAnswerRefusal::NoSuchResource),
        (ResourceRequest::Down(none), AlarmAnswerRefusal::NoSuchResource),
    ];
    assert_eq!(bench.objections(), expected);
    assert_eq!(bench.alarm().id, alarm);
}

/// Logs of earlier versions have such a text.
#[test]
fn a_resource_taken_out_by_hand_with_a_text_is_no_alarm() {
    let bench = CellBench::c1(&[1, 0]);
    let (mut state, m1, at) = (bench.state().clone(), bench.resource("M1"), bench.sim.now);
    let why = OutOfServiceReason::ByHand { text: "new tool".to_owned() };
    let fact = RecordKind::Exception(ExceptionStep::Down { resource: m1, why, activity: String::new() });
    state.apply(&Record { at, fact }).expect("it fits");
    let down = state.exceptions().is_down(m1).expect("it is left out");
    assert_eq!(down.why.text(""), "taken out by hand: new tool");
}
