//! Alarm given by hand: stations of the resource stop, and are put right like others that stand half-way. Answers each time.

use linewright_coordinator_cell::dispatch::why_resource;
use linewright_coordinator_cell::exception::{AlarmAnswerRefusal, OutOfServiceReason, ResourceRequest, Strategy};
use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, OngoingActivity, PlayerInput, StationUnavailable, TaskOutcome,
};
use linewright_orders::TaskFailure;

use super::bench::{CellBench, workcell};

#[test]
fn a_person_can_give_alarm_of_a_machine() {
    let mut bench = CellBench::c1(&[1, 1]);
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    let m1 = bench.resource("M1");
    bench.say(PlayerInput::Alarm { resource: m1, text: "smoke" });
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    let firing = bench.firing("M1.process<A.new>").expect("it has failed").clone();
    assert_eq!(firing.phase, ActivityPhase::Failed(ActivityFailure::ByHand { resource: m1 }));
    assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Alarm { text: "smoke".to_owned() })]);
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    assert_eq!(bench.objections(), [(ResourceRequest::Up(m1), AlarmAnswerRefusal::Open(m1))]);
    let text = &bench.alarm().text;
    assert!(text.starts_with("First lead m1 to a rest in manual") && !text.contains("between two rests"), "{text}");
    // The other part is made meanwhile: B needs M3 and M2 only.
    bench.until_that(|bench| bench.state().left() == 1);
    bench.answer("as-before");
    let (station, asked) = (bench.station("m1"), ResourceRequest::Answer(bench.alarm().id));
    assert_eq!(bench.objections().last(), Some(&(asked, AlarmAnswerRefusal::NotAtRest(station))));
    // It was stopped where it was: a person leads it to a rest.
    let now = bench.sim.now;
    bench.at("m1").bring_to_rest(now);
    bench.seconds_later(2.0);
    bench.answer("as-before");
    bench.closed(firing.id);
    // Led away again it is not up.
    bench.at("m1").is_held = true;
    bench.seconds_later(2.0);
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Up(m1), AlarmAnswerRefusal::NotAtRest(station))));
    bench.at("m1").is_held = false;
    bench.seconds_later(2.0);
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    bench.all_leave(2);
}

/// After an alarm a station on its way back stops as well, whatever had failed before, and in whichever life of the
/// coordinator.
#[test]
fn an_alarm_stops_what_goes_back_from_another_failure() {
    for crash in [false, true] {
        let mut bench = CellBench::c1(&[1, 0]);
        bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
        bench.at("m1").is_stuck = true;
        bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some_and(has_failed));
        let back = |bench: &CellBench| bench.sim.stations[bench.station("m1").index()].doing().is_some();
        bench.until_that(|bench| bench.steps().is_empty() && back(bench));
        let m1 = bench.resource("M1");
        if crash {
            // The record of the alarm is written, and nothing was sent yet.
            bench.sim.options.crash_at = vec![bench.sim.steps + 1];
        }
        bench.say(PlayerInput::Alarm { resource: m1, text: "" });
        assert_eq!(bench.sim.lives, 1 + usize::from(crash));
        bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
        let (_, outcome, _) = bench.at("m1").ended.last().copied().expect("it has ended");
        assert_eq!(
            (outcome, bench.at("m1").is_held),
            (TaskOutcome::Failed(TaskFailure::Stopped), true),
            "crash: {crash}"
        );
        assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Alarm { text: String::new() })]);
    }
}

fn has_failed(firing: &OngoingActivity) -> bool {
    firing.phase != ActivityPhase::Running
}

/// An alarm can be given of a resource that is left out already. It is given once, and the time counts from the
/// beginning.
#[test]
fn alarm_can_be_given_of_what_is_left_out() {
    let mut bench = CellBench::c1(&[1, 0]);
    let m1 = bench.resource("M1");
    bench.say(PlayerInput::Resource { resource: m1, up: false });
    let since = bench.state().exceptions().is_down(m1).expect("it is").since;
    bench.until(1.0);
    for text in ["smoke", "fire"] {
        bench.say(PlayerInput::Alarm { resource: m1, text });
        assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Alarm { text: "smoke".to_owned() })]);
    }
    assert_eq!(bench.state().exceptions().is_down(m1).expect("it is").since, since);
}

/// That a resource is counted on says nothing of its station, nor of what has failed there.
#[test]
fn why_of_a_resource_in_service_names_what_its_station_has_and_what_has_failed() {
    let mut bench = CellBench::c1(&[1, 0]);
    let (robot, m3) = (bench.resource("R"), bench.resource("M3"));
    bench.load_fails();
    bench.at("robot").unable = Some(StationUnavailable::Incomplete);
    bench.seconds_later(1.0);
    let (alarm, now) = (bench.alarm().clone(), bench.sim.now);
    assert_eq!(
        why_resource(&bench.sim.coordination, now, robot),
        [
            "R in service.".to_owned(),
            "An activity of its station failed: the line works without that station, which is given no work until the alarm \
             is answered."
                .to_owned(),
            "robot: operation incomplete; complete or undo it in manual.".to_owned(),
            format!(
                "It takes part in `load M1` with part 1, which has failed and waits for an answer to {}.",
                alarm.id
            ),
            format!("{}: {}", alarm.id, alarm.text),
        ]
    );
    assert_eq!(why_resource(&bench.sim.coordination, now, m3), ["M3 in service."]);
}

/// What the alarm asks for can be answered each time: the part is back where it was, also when it is not tried again.
#[test]
fn a_word_that_may_not_be_tried_again_decides_anew() {
    let mut bench = CellBench::new(&workcell().replace("retries = 2", "retries = 1\ndown = [\"to\"]"), &[1, 0]);
    // What is decided anew goes to M1 again.
    let m2 = bench.resource("M2");
    bench.say(PlayerInput::Resource { resource: m2, up: false });
    let first = bench.load_fails();
    let ruling = |bench: &CellBench| {
        let rulings = bench.sim.coordination.rulings(bench.alarm().id);
        rulings.into_iter().map(|ruling| (ruling.word, ruling.then)).collect::<Vec<_>>()
    };
    assert_eq!(ruling(&bench)[0], ("in-store".to_owned(), Strategy::Redo));
    bench.answer("in-store");
    bench.closed(first.id);
    let m1 = bench.resource("M1");
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    let again = bench.load_fails();
    let words: Vec<_> =
        [("in-store", Strategy::Backward), ("in-machine", Strategy::Forward), ("scrap", Strategy::Backward)]
            .into_iter()
            .map(|(word, then)| (word.to_owned(), then))
            .collect();
    assert_eq!(ruling(&bench), words);
    bench.answer("in-store");
    bench.closed(again.id);
    bench.hear();
    assert_eq!(bench.down()[0].0, "M1", "what the rule leaves out is left out all the same");
    assert!(bench.state().parts().len() == 1, "the part is kept");
    // Decided for the same again, it is not tried by itself as often as at first.
    bench.say(PlayerInput::Resource { resource: m1, up: true });
    bench.load_fails();
    assert_eq!(ruling(&bench), words);
}

/// A person who has taken the part out was refused that until the station could work again. Nothing begins there before `up`.
#[test]
fn a_part_is_given_up_whatever_its_station_can_do() {
    for is_away in [false, true] {
        let mut bench = CellBench::c1(&[1, 0]);
        bench.taken_away("load M1<A.new>", "m1", "M1.loaded<A.new>");
        match is_away {
            true => bench.at("m1").is_away = true,
            false => bench.at("m1").unable = Some(StationUnavailable::Devices),
        }
        bench.hear();
        bench.hear();
        let (m1, missing, objected) = (bench.station("m1"), bench.alarm().id, bench.objections().len());
        bench.answer("gone");
        assert_eq!((bench.objections().len(), bench.state().exceptions().scrapped()), (objected, 1), "{is_away}");
        let (alarm, words) = (bench.alarm().id, bench.alarm().words.clone());
        assert!(alarm > missing && words == ["up"], "the part is no more, and nothing else is asked: {words:?}");
        assert!(bench.alarm_now().starts_with("The part of M1 is given up. M1 stays out of service: m1: "));
        let why = match is_away {
            true => AlarmAnswerRefusal::NotHeard(m1),
            false => AlarmAnswerRefusal::CannotWork(m1, StationUnavailable::Devices),
        };
        bench.answer("up");
        assert_eq!(bench.objections().last(), Some(&(ResourceRequest::Answer(alarm), why)));
        assert_eq!((bench.alarm().id, bench.down().len()), (alarm, 1), "it keeps its number");
        // What keeps the station from work is another reason by now.
        let before = bench.alarm_now();
        bench.at("m1").is_away = false;
        bench.at("m1").unable = Some(StationUnavailable::Incomplete);
        bench.hear();
        let now = bench.alarm_now();
        assert!(now != before && now.contains("stays out of service: m1: operation incomplete"), "{before} {now}");
        assert_eq!(bench.alarm().id, alarm, "it keeps its number");
        bench.works("m1");
        bench.answer("up");
        assert_eq!((bench.down(), bench.state().exceptions().scrapped()), (vec![], 1));
        bench.all_leave(1);
    }
}
