//! Where stations stand when an answer is given, and when their resources are counted on again.

use linewright_coordinator_cell::dispatch::{Reasons, ShortestRoutes, why_not, why_resource};
use linewright_coordinator_cell::exception::{
    AlarmAnswerRefusal, AlarmSubject, ExceptionStep, LeadDirection, OutOfServiceReason, ResourceRequest,
};
use linewright_coordinator_cell::texts::{AnswerFit, AnswerRemark};
use linewright_coordinator_cell::{PartId, PlayerInput, Presence, StationUnavailable, TaskReport};
use linewright_line::RestId;

use super::bench::{CellBench, workcell};

const OPEN: RestId = RestId(0);
const CLAMPED: RestId = RestId(1);
const LOAD: &str = "load M1<A.new>";

/// A part is taken out of M1 by hand while the clamp is closed on it: the model has room there, and nothing would open the clamp.
#[test]
fn a_machine_that_rests_clamped_without_a_part_is_not_used_before_it_is_open() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    let (part, _) = bench.taken_away_at(LOAD, "m1", "M1.loaded<A.new>", Some(CLAMPED));
    let m1 = bench.resource("M1");
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let (missing, objected) = (bench.alarm().id, bench.objections());
    assert_eq!(objected, [(ResourceRequest::Up(m1), AlarmAnswerRefusal::Contradicted(m1))]);
    bench.answer("gone");
    assert!(bench.steps().iter().any(|step| matches!(step, ExceptionStep::Missing { part: of, .. } if *of == part)));
    assert_eq!(bench.objections(), objected, "the answer itself is taken");
    assert!(bench.alarm().id > missing);
    assert_eq!(
        (bench.alarm().about, bench.alarm().text.as_str()),
        (
            AlarmSubject::Resource(m1),
            "m1 stands at rest \"clamped\", but M1 has no part, and load M1 begins at \"open\": M1 is not used. Bring m1 to \
             \"open\": in hand mode hold PB_clear_1 (task \"clear\") (stop, wait for the standstill, start, hand). \
             Then answer \"up\"."
        )
    );
    let brings = |bench: &CellBench| bench.sim.coordination.alarm_brings(bench.sim.now, bench.alarm());
    assert_eq!(brings(&bench), Some((bench.station("m1"), OPEN)));
    bench.answer("up");
    let asked = ResourceRequest::Answer(bench.alarm().id);
    assert_eq!(bench.objections()[1..], [(asked, AlarmAnswerRefusal::WrongRest(m1))]);
    // Nothing was ordered of it meanwhile.
    assert!(bench.firing(LOAD).is_none() && bench.state().exceptions().is_down(m1).is_some());
    // It is brought there in hand mode, and answered before that ends: the alarm is no longer what was found before.
    bench.at("m1").rest = Some(OPEN);
    bench.at("m1").unable = Some(StationUnavailable::ByHand);
    bench.hear();
    assert_eq!(
        bench.alarm_now(),
        "M1 is out of service, but its station and sensor are as they should be. Answer \"up\"."
    );
    assert_eq!(brings(&bench), None);
    bench.answer("up");
    assert_eq!((bench.down(), bench.state().exceptions().alarms().len()), (vec![], 0));
}

/// A machine is closed on a part that an operator has answered to be *gone*. The alarm did not name what has to be done before *up*, and
/// each *up* that was refused raised the alarm again under another number.
#[test]
fn a_machine_that_is_closed_on_a_part_of_no_record_is_opened_first() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    let (part, _) = bench.taken_away_at(LOAD, "m1", "M1.loaded<A.new>", Some(CLAMPED));
    let m1 = bench.resource("M1");
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    bench.answer("gone");
    bench.sim.truth.put(part, Some(m1));
    bench.hear();
    let brings = |bench: &CellBench| bench.sim.coordination.alarm_brings(bench.sim.now, bench.alarm());
    let listed = |bench: &CellBench| {
        let line = super::bench::workcell_line(|line| line);
        let report = bench.sim.stations[bench.station("m1").index()].heard();
        let (alarm, station) = (bench.alarm().id, bench.station("m1"));
        let verdict = bench.sim.coordination.rehearsed(bench.sim.now, alarm, "up", &[(station, &report)]);
        AnswerRemark::of(&line, bench.state(), alarm, &verdict).expect("it would be refused").fit
    };
    bench.answer("up");
    let (alarm, first) = (bench.alarm().id, "M1: no part expected, sensor on. Bring m1 to \"open\": in hand mode hold");
    let text = bench.alarm_now();
    assert!(text.starts_with(first) && text.ends_with("Take the part out, then answer \"up\"."), "{text}");
    assert_eq!((brings(&bench), listed(&bench)), (Some((bench.station("m1"), OPEN)), AnswerFit::Refused));
    bench.answer("up");
    assert_eq!(bench.alarm().id, alarm, "the same is asked");
    // Opened, it stands between its rests for a while.
    bench.at("m1").rest = None;
    bench.at("m1").unable = Some(StationUnavailable::Incomplete);
    bench.hear();
    assert_eq!(listed(&bench), AnswerFit::Refused, "{}", bench.alarm_now());
    bench.at("m1").rest = Some(OPEN);
    bench.at("m1").unable = None;
    bench.sim.truth.put(part, None);
    bench.hear();
    bench.answer("up");
    assert_eq!((bench.down(), bench.state().exceptions().alarms().len()), (vec![], 0));
}

/// Where the only task that leads to the rest waits for the part that is missing, the button that takes the last task back is named;
/// without one that goes back, the task alone.
#[test]
fn an_alarm_names_a_way_that_does_not_wait_for_the_missing_part() {
    let waiting = |line: String| {
        let clear = "duration_s = 1.0\nwatchdog_s = 2.0\nnormal = { actuator = \"clamp_open\", complete = \"LS_open\" }\n\
                     recovery = { actuator = \"clamp_close\", complete = \"LS_closed\" }\nhand";
        assert!(line.contains(clear));
        line.replacen(clear, &clear.replace("\nhand", "\nwaits = [\"part_present\"]\nwaits_code = 13\nhand"), 1)
    };
    let one_way = |line: String| {
        let close = "hand = { type = 5, forward = \"PB_load_1\", back = \"PB_back_1\" }";
        assert!(line.contains(close));
        let line = waiting(line).replacen(close, "hand = { type = 2, forward = \"PB_load_1\" }", 1);
        let tools = "hand = { type = 3, forward = \"PB_load_1\", back = \"PB_back_1\" }";
        assert!(line.contains(tools));
        line.replacen(tools, "hand = { type = 1, forward = \"PB_load_1\" }", 1)
    };
    let changes: [(&dyn Fn(String) -> String, &str); 2] = [
        (
            &waiting,
            "in hand mode hold PB_back_1 (takes task \"clamp\" back, if that was the last), or PB_unload_1 (task \"release\", \
             which waits for inputs) (stop",
        ),
        (&one_way, "in hand mode hold PB_unload_1 (task \"release\", which waits for inputs) (stop"),
    ];
    for (change, way) in changes {
        let mut bench = CellBench::c1_of_line(change, &[1, 0]);
        let firing = bench.load_fails();
        bench.at("m1").rest = Some(CLAMPED);
        bench.hear();
        bench.answer("in-store");
        bench.closed(firing.id);
        assert!(bench.alarm().text.contains(way), "{}", bench.alarm().text);
    }
}

/// The same after an activity has failed, whatever was answered; and over a restart of the coordinator.
#[test]
fn an_answer_that_leaves_a_station_at_the_wrong_rest_is_followed_by_an_alarm() {
    for (word, crash) in [("in-store", false), ("scrap", false), ("in-store", true)] {
        let mut bench = CellBench::c1_of_its_line(&[1, 0]);
        let firing = bench.load_fails();
        bench.at("m1").rest = Some(CLAMPED);
        bench.hear();
        if crash {
            bench.sim.options.crash_at = vec![bench.sim.steps + 1];
        }
        if word == "scrap" {
            bench.sim.truth.take_away(firing.id);
        }
        bench.answer(word);
        if crash {
            bench.hear();
            bench.answer(word);
        }
        bench.closed(firing.id);
        assert_eq!(bench.sim.lives, 1 + usize::from(crash));
        assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Rest)], "{word}");
        let text = bench.alarm().text.clone();
        assert!(text.starts_with("m1 stands at rest \"clamped\", but M1 has no part"), "{word}: {text}");
        let why = why_resource(&bench.sim.coordination, bench.sim.now, bench.resource("M1"));
        assert!(
            why[0].ends_with("station at another rest than its next task begins at.") && why[1].contains(&text),
            "{why:?}"
        );
    }
}

/// At the rest that the model has nothing is asked: with a part at the one where it is worked on.
#[test]
fn a_station_at_the_rest_of_the_model_is_left_in_service() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    let firing = bench.load_fails();
    bench.sim.truth.put(PartId(1), Some(bench.resource("M1")));
    bench.at("m1").rest = Some(CLAMPED);
    bench.hear();
    bench.answer("in-machine");
    bench.closed(firing.id);
    assert_eq!(bench.down(), []);
}

/// Whoever leads a station on from between two rests may lead the part with it: until then every answer but `carrier` is a guess.
#[test]
fn no_answer_closes_an_activity_whose_station_stands_half_way() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("robot").holds = true;
    let firing = bench.load_fails();
    let text = bench.alarm().text.clone();
    assert!(
        text.starts_with(
            "First lead robot to a rest in manual, as `linewright recover` lists it: back to where the task began if there is a way, \
             since m1 stands where its order began. R came to M1"
        ),
        "{text}"
    );
    let (robot, asked) = (bench.station("robot"), ResourceRequest::Answer(bench.alarm().id));
    for word in ["in-store", "in-machine", "scrap"] {
        bench.answer(word);
        assert_eq!(bench.objections().last(), Some(&(asked, AlarmAnswerRefusal::NotAtRest(robot))), "{word}");
    }
    bench.hear();
    assert!(bench.firing(LOAD).is_some() && bench.count("M1.available-capacity") == 0, "M1 is kept");
    let now = bench.sim.now;
    bench.at("robot").holds = false;
    bench.at("robot").bring_to_rest(now);
    bench.hear();
    let text = bench.alarm_now();
    assert!(text.starts_with("R came to M1"), "as it stands now: {text}");
    bench.answer("in-store");
    bench.closed(firing.id);
    assert_eq!(bench.down(), []);
    bench.all_leave(1);
}

/// In manual mode a station stands at its rests as in auto. Nothing is ordered of it before that ends.
#[test]
fn an_answer_in_manual_leaves_no_station_out() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    let firing = bench.load_fails();
    let all = ["robot", "m1", "m2", "m3"];
    all.into_iter().for_each(|name| bench.at(name).unable = Some(StationUnavailable::ByHand));
    bench.hear();
    bench.answer("in-store");
    bench.closed(firing.id);
    bench.hear();
    assert_eq!((bench.down(), bench.state().firings().len()), (vec![], 0));
    all.into_iter().for_each(|name| bench.at(name).unable = None);
    bench.all_leave(1);
}

/// What a sensor says against an answer is put right with the station at a rest; until then that is what has to be done.
#[test]
fn a_station_half_way_is_named_before_what_a_sensor_contradicts() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("robot").holds = true;
    bench.load_fails();
    bench.sim.truth.put(PartId(1), Some(bench.resource("R")));
    bench.hear();
    assert_eq!(bench.presence("robot"), Presence::On, "it is contradicted as well");
    let (robot, asked) = (bench.station("robot"), ResourceRequest::Answer(bench.alarm().id));
    bench.answer("in-store");
    assert_eq!(bench.objections(), [(asked, AlarmAnswerRefusal::NotAtRest(robot))]);
}

/// Of several inputs those that are off are named; all where none is known to be.
#[test]
fn of_inputs_that_were_waited_for_the_missing_ones_are_named() {
    let two = |line: String| {
        assert!(line.contains("waits = [\"m1_clamped\"]"));
        line.replacen("waits = [\"m1_clamped\"]", "waits = [\"m1_clamped\", \"part_in_hand\"]", 1)
    };
    let mut bench = CellBench::c1_of_line(two, &[1, 0]);
    bench.at("robot").fails_with = Some(22);
    bench.at("m1").is_stuck = true;
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let (all, robot) = (bench.alarm_now(), bench.station("robot"));
    assert!(all.contains("(code 22): m1_clamped at `let go at m1`, part_in_hand at `let go at m1`, after"), "{all}");
    let line = linewright_line::parse("line.toml", linewright_testkit::cells::C1_LINE).expect("it is sound").line;
    let in_hand = line.station(robot).inputs.iter().position(|input| input == "part_in_hand").expect("an input");
    let report = TaskReport { off: 1 << in_hand, ..bench.at("robot").heard() };
    bench.say(PlayerInput::Station(robot, &report));
    let missing = bench.alarm_now();
    assert!(missing.contains("(code 22): part_in_hand at `let go at m1`, after"), "{missing}");
}

/// A code may be that of several tasks: the inputs are those of the one that was ordered. The other order's failure is reported as well.
#[test]
fn an_alarm_names_the_inputs_that_were_waited_for() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.at("robot").fails_with = Some(22);
    bench.at("m1").waits_to_begin = true;
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let text = bench.alarm().text.clone();
    assert!(
        text.contains("robot: awaited input not on in time (code 22): m1_clamped at `let go at m1`, after"),
        "{text}"
    );
}

/// A station whose order is ended because another station has failed has not exceeded its own time limit; its sensor is not reported as late.
#[test]
fn an_order_left_while_it_waited_is_not_called_late() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.at("robot").fails_with = Some(22);
    bench.at("m1").waits_to_begin = true;
    bench.at("m1").waits_code = Some(12);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let text = bench.alarm().text.clone();
    assert!(
        text.contains("robot: awaited input not on in time (code 22): m1_clamped at `let go at m1`, after"),
        "{text}"
    );
    assert!(
        text.contains(
            "; m1 (Machine M1): its order was ended while it waited for part_present at `clamp-close` (code 12)"
        ),
        "{text}"
    );
}

#[test]
fn a_station_stands_for_its_only_resource() {
    let bench = CellBench::c1(&[1, 0]);
    let handling = bench.table.handling();
    let (m1, r) = (bench.resource("M1"), bench.resource("R"));
    let named = ["M1", "m1", "robot"].map(|name| handling.resource_or_station_named(name));
    assert_eq!(named, [Ok(m1), Ok(m1), Ok(r)]);
    assert_eq!(handling.resource_or_station_named("m9"), Err(vec![]));
    let mut both = handling.clone();
    both.resources[r.index()].station = both.resources[m1.index()].station;
    let mut several = vec![m1, r];
    several.sort_unstable();
    assert_eq!(both.resource_or_station_named("m1"), Err(several));
}

/// The robot stands inside M1 and its node dies: M1 is not given free until it is heard at a rest again, or people take it out of
/// service; then all that the activity has used is left out.
#[test]
fn no_answer_closes_an_activity_whose_station_is_not_heard() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.at("robot").holds = true;
    let firing = bench.load_fails();
    bench.at("robot").is_away = true;
    bench.hear();
    bench.hear();
    let (robot, of, m1) = (bench.station("robot"), bench.resource("R"), bench.resource("M1"));
    let asked = ResourceRequest::Answer(bench.alarm().id);
    for word in ["in-store", "in-machine", "scrap"] {
        bench.answer(word);
        assert_eq!(bench.objections().last(), Some(&(asked, AlarmAnswerRefusal::Unheard(robot, of))), "{word}");
    }
    bench.hear();
    assert!(bench.firing(LOAD).is_some() && bench.count("M1.available-capacity") == 0, "M1 is kept");
    bench.say(PlayerInput::Resource { resource: of, up: false });
    bench.answer("in-store");
    bench.closed(firing.id);
    let unheard = |name: &str| (name.to_owned(), OutOfServiceReason::Unheard(firing.id));
    let by_hand = ("R".to_owned(), OutOfServiceReason::ByHand { text: String::new() });
    let mut down = bench.down();
    down.sort_by(|one, other| one.0.cmp(&other.0));
    assert_eq!(down, [unheard("M1"), by_hand, unheard("ST")]);
    bench.hear();
    assert_eq!(bench.state().firings().len(), 0);
    // It is brought back.
    let now = bench.sim.now;
    (bench.at("robot").is_away, bench.at("robot").holds) = (false, false);
    bench.at("robot").bring_to_rest(now);
    bench.hear();
    for resource in [of, m1, bench.resource("ST")] {
        bench.say(PlayerInput::Resource { resource, up: true });
    }
    assert_eq!(bench.down(), []);
    bench.all_leave(1);
}

/// A station that dies when its activity was answered already is not heard when that is closed.
#[test]
fn a_station_that_dies_after_the_answer_leaves_all_out_as_well() {
    let mut bench = CellBench::c1(&[1, 0]);
    let firing = bench.load_fails();
    bench.answer("in-store");
    bench.at("robot").is_away = true;
    bench.closed(firing.id);
    assert_eq!(bench.down().len(), 3, "{:?}", bench.down());
}

/// A coordinator without its log: a station that was heard before its sensor was read leaves the comparison open, also where the
/// activity orders nothing of it.
#[test]
fn nothing_starts_at_a_machine_whose_sensor_was_not_read_yet() {
    let order = "  { station = \"m1\", task = \"clamp\", max_s = 26 },\n";
    assert!(workcell().contains(order));
    let mut bench = CellBench::new(&workcell().replacen(order, "", 1), &[1, 0]);
    bench.sim.senses = false;
    for name in ["robot", "m1", "m2", "m3"] {
        bench.at(name).presence = if name == "m1" { Presence::Unread } else { Presence::Off };
    }
    bench.at("m2").unable = Some(StationUnavailable::ByHand);
    bench.until(20.0);
    assert_eq!(bench.state().firings().len(), 0);
    let ways = ShortestRoutes::new(&bench.table);
    let why = why_not(&ways, &Reasons::default(), &bench.sim.coordination, bench.sim.now, PartId(1));
    assert_eq!(
        why[1],
        "`load M1`: M1: its presence sensor is compared with the model first, after a restart and where it differs when an activity has \
         ended."
    );
    // Read at last, it sees a part that no log knows.
    bench.at("m1").presence = Presence::On;
    bench.hear();
    assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Mismatch)]);
    bench.at("m1").presence = Presence::Off;
    bench.hear();
    let up = PlayerInput::Resource { resource: bench.resource("M1"), up: true };
    bench.say(up);
    bench.hear();
    assert!(bench.firing(LOAD).is_some());
}

/// An answer that the part is somewhere else is refused while the gripper, at a rest, has one.
#[test]
fn a_part_in_the_hand_is_not_in_store() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.load_fails();
    let (robot, alarm) = (bench.resource("R"), bench.alarm().id);
    bench.sim.truth.put(PartId(1), Some(robot));
    bench.seconds_later(1.0);
    for word in ["in-store", "in-machine"] {
        bench.answer(word);
        let refusal = (ResourceRequest::Answer(alarm), AlarmAnswerRefusal::HasPart(robot));
        assert_eq!(bench.objections().last(), Some(&refusal), "{word}");
    }
}

/// Which way a station is led follows from how the others of its activity stand: it is done at all of them, or at none.
#[test]
fn an_alarm_gives_the_way_on_which_its_stations_are_led() {
    let way = |bench: &CellBench| {
        let leads = bench.sim.coordination.alarm_leads(bench.sim.now, bench.alarm());
        leads.reason.map(|reason| (leads.lead.len(), reason.direction()))
    };
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.at("robot").is_stuck = true;
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let text = bench.alarm_now();
    // Whether presses lead on is not known here: a way that is not there is not ordered.
    let first = "First lead robot to a rest in manual, as `linewright recover` lists it: to the end of the task if there is a way, since \
                 m1 has completed its order. ";
    assert!(text.starts_with(first), "{text}");
    assert_eq!(way(&bench), Some((1, LeadDirection::On)));
    for (rest, direction) in [(OPEN, LeadDirection::Back), (CLAMPED, LeadDirection::On)] {
        bench.at("m1").rest = Some(rest);
        bench.hear();
        assert_eq!(way(&bench), Some((1, direction)), "led away from where its order left it: {}", bench.alarm_now());
    }

    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    (bench.at("robot").is_stuck, bench.at("m1").is_stuck) = (true, true);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let first =
        "First lead robot and m1 to a rest in manual, as `linewright recover` lists it: all to the end or all back. ";
    assert!(bench.alarm_now().starts_with(first), "{}", bench.alarm_now());
    assert_eq!(way(&bench), None);
    let now = bench.sim.now;
    bench.at("m1").bring_to_rest(now);
    // Led by hand: its rest shows which way.
    for (rest, direction) in [(CLAMPED, LeadDirection::On), (OPEN, LeadDirection::Back)] {
        bench.at("m1").rest = Some(rest);
        bench.hear();
        assert_eq!(way(&bench), Some((1, direction)), "{}", bench.alarm_now());
    }
}

/// A motion that a fault has ended: the alarm names the station with its title, the operation and the switch, also when the station has
/// been led on since, and after a restart.
#[test]
fn an_alarm_names_the_operation_and_the_switch_of_a_fault() {
    const FAULT: &str = "mill: watchdog: LS_out (m1 io, node 12h, 6000h:01 bit 1) not on within 2 s";
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    bench.at("m1").fails_with = Some(linewright_orders::TaskFailure::Fault.code());
    bench.at("m1").fault = FAULT.to_owned();
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let cause = format!("m1 (Machine M1): station fault: {FAULT}, after");
    assert!(bench.alarm().text.contains(&cause), "{}", bench.alarm().text);
    bench.at("m1").fault.clear();
    bench.hear();
    assert!(bench.alarm_now().contains(&cause), "{}", bench.alarm_now());
    bench.at("m1").fault = "another".to_owned();
    bench.hear();
    assert!(bench.alarm_now().contains(&cause), "{}", bench.alarm_now());
}
