//! Mode, stations and alarms: what is received is shown, what is not is unknown.

use linewright_console_view::{LIST_MAX, StationHealth, TEXT_MAX};
use linewright_msgs::{LineState, StationState};

use crate::bench::ViewBench;

#[test]
fn before_anything_is_received_all_is_unknown_and_none_of_it_is_well() {
    let mut bench = ViewBench::new(false);
    let page = bench.page(5_000);
    assert_eq!((page.mode.is_known, page.mode.word), (false, "unknown"));
    assert_eq!(page.mode.text, "no state received from the coordinator");
    for station in &page.stations {
        assert_eq!((station.health, station.unknown.as_deref()), (StationHealth::Unknown, Some("no state received")));
        assert_eq!((station.mode, station.cycle, &station.operation), (None, None, &None));
    }
    // An empty list would look like a line without alarms.
    assert_eq!(page.alarms.len(), 1 + bench.line.stations.len());
    assert_eq!((page.alarms[0].priority, &*page.alarms[0].source), (1, "line"));
}

#[test]
fn a_state_is_shown_until_it_is_too_old_and_never_longer() {
    let mut bench = ViewBench::received(1_000);
    let last = 1_000 + bench.fresh() - 1;
    let page = bench.page(last);
    assert_eq!((page.mode.is_known, page.mode.word), (true, "auto"));
    assert!(page.alarms.is_empty(), "{:?}", page.alarms);
    assert!(page.stations.iter().all(|of| of.health == StationHealth::Ok && of.operation.is_some()));
    bench.stations[0].as_mut().expect("received").0.devices_valid = false;
    assert_eq!(bench.page(last).stations[0].health, StationHealth::NotReady);
    let page = bench.page(last + 1);
    assert_eq!((page.mode.is_known, page.mode.word, page.mode.is_enabled), (false, "unknown", None));
    assert!(page.stations.iter().all(|of| of.health == StationHealth::Unknown && of.operation.is_none()));
    let page = bench.page(13_700);
    assert_eq!(page.mode.text, "no state received from the coordinator for 12 s");
    assert_eq!(page.stations[0].unknown.as_deref(), Some("no state received for 12 s"));
    assert_eq!(page.alarms[0].text, page.mode.text);
}

#[test]
fn a_coordinator_that_is_started_again_is_unknown_until_its_first_state() {
    let mut bench = ViewBench::received(0);
    assert_eq!(bench.page(100).mode.word, "auto");
    let gap = bench.fresh() + 500;
    for station in bench.stations.iter_mut().flatten() {
        station.1 = gap;
    }
    let page = bench.page(gap);
    assert!(!page.mode.is_known && page.stations.iter().all(|of| of.health == StationHealth::Ok));
    assert_eq!(page.alarms.iter().map(|of| &*of.source).collect::<Vec<_>>(), ["line"]);
    let again =
        LineState { mode: StationState::MODE_STANDBY, boot_id: 2, text: "stand-by".to_owned(), ..LineState::default() };
    bench.coordinator = Some((again, gap + 100));
    let page = bench.page(gap + 100);
    assert_eq!((page.mode.is_known, &*page.mode.text), (true, "stand-by"));
    assert!(page.alarms.is_empty(), "{:?}", page.alarms);
}

#[test]
fn health_is_the_worst_that_is_reported() {
    let mut bench = ViewBench::received(0);
    let names: Vec<String> = bench.line.stations.iter().map(|of| of.name.clone()).collect();
    let mut health = |change: fn(&mut StationState), left_out: bool| {
        bench.coordinator.as_mut().expect("received").0.left_out =
            if left_out { vec![names[0].clone()] } else { Vec::new() };
        let mut state = bench.at_rest(bench.line.station_ids().next().expect("one"));
        change(&mut state);
        bench.stations[0] = Some((state, 0));
        bench.page(1).stations[0].health
    };
    assert_eq!(health(|_| {}, false), StationHealth::Ok);
    assert_eq!(health(|of| of.selector_manual = true, false), StationHealth::Manual);
    assert_eq!(health(|of| of.selector_manual = true, true), StationHealth::LeftOut);
    assert_eq!(health(|of| of.fault = "watchdog".to_owned(), true), StationHealth::Fault);
    let stopped = |of: &mut StationState| (of.mode, of.fault) = (StationState::MODE_ESTOP, "watchdog".to_owned());
    assert_eq!(health(stopped, true), StationHealth::EmergencyStop);
}

#[test]
fn alarms_have_priorities_and_ages_since_they_were_first_shown() {
    let mut bench = ViewBench::received(0);
    bench.page(0);
    bench.coordinator.as_mut().expect("received").0.left_out = vec!["mill_1".to_owned()];
    bench.page(0);
    let faulty = StationState {
        fault: "advance clamp: watchdog".to_owned(),
        ..bench.at_rest(bench.line.station_ids().nth(1).expect("two"))
    };
    bench.stations[1] = Some((faulty, 0));
    bench.coordinator.as_mut().expect("received").0.console_lost = true;
    bench.page(60);
    for at in [Some(&mut bench.coordinator.as_mut().expect("received").1)].into_iter().flatten() {
        *at = 62_060;
    }
    bench.stations.iter_mut().flatten().for_each(|of| of.1 = 62_060);
    let page = bench.page(62_060);
    let found: Vec<_> = page.alarms.iter().map(|of| (of.priority, of.priority_text, &*of.source, &*of.age)).collect();
    let clamp = &*bench.line.stations[1].name;
    assert_eq!(
        found,
        [
            (1, "high", clamp, "shown for 1 min 2 s"),
            (2, "medium", "line", "shown for 1 min 2 s"),
            (3, "low", "line", "shown for 1 min 2 s"),
        ]
    );
    assert_eq!(page.alarms[0].text, "advance clamp: watchdog");
    // Gone, and there again: it is another one.
    bench.coordinator.as_mut().expect("received").0.console_lost = false;
    bench.page(62_061);
    bench.coordinator.as_mut().expect("received").0.console_lost = true;
    assert_eq!(bench.page(62_062).alarms[1].age, "shown for 0 s");
}

#[test]
fn a_page_is_bounded_whatever_a_node_sends() {
    let mut bench = ViewBench::received(0);
    let many = || vec!["ä".repeat(TEXT_MAX * 3); LIST_MAX * 3];
    let state = StationState {
        blocked_by: many(),
        fault: "x".repeat(TEXT_MAX * 3),
        ..bench.at_rest(bench.line.station_ids().next().expect("one"))
    };
    bench.stations[0] = Some((state, 0));
    let line = &mut bench.coordinator.as_mut().expect("received").0;
    (line.waiting_for, line.left_out, line.obstacles, line.text) = (many(), many(), many(), "y".repeat(TEXT_MAX * 3));
    let page = bench.page(1);
    let longest = |of: &[String]| of.iter().map(|text| text.chars().count()).max();
    for list in [&page.stations[0].waits_for, &page.mode.waiting_for, &page.mode.left_out] {
        assert_eq!((list.len(), longest(list)), (LIST_MAX, Some(TEXT_MAX)));
    }
    assert!(page.stations[0].waits_for[0].ends_with('…'));
    assert!(page.alarms.iter().all(|alarm| alarm.text.chars().count() <= TEXT_MAX));
    assert_eq!(page.mode.text.chars().count(), TEXT_MAX);
}

#[test]
fn a_line_that_stands_by_until_a_person_does_something_is_an_alarm_with_what_to_do() {
    let mut bench = ViewBench::received(0);
    let mut shown = |text: &str, change: fn(&mut LineState)| {
        let mut line = LineState { mode: StationState::MODE_STANDBY, text: text.to_owned(), ..LineState::default() };
        change(&mut line);
        bench.coordinator = Some((line, 0));
        bench.page(1).alarms.into_iter().map(|of| of.text).collect::<Vec<_>>()
    };
    assert!(shown("stand-by", |_| {}).is_empty());
    let waiting = |of: &mut LineState| of.waiting_for = vec!["mill_1".to_owned()];
    assert!(shown("stand-by, waiting for mill_1", waiting).is_empty(), "that comes by itself");
    let without = |of: &mut LineState| of.left_out = vec!["mill_1".to_owned()];
    assert_eq!(shown("stand-by. Left out: mill_1", without), ["left out of the mode decision: mill_1"]);
    for text in
        ["stand-by: mill_1: restarted; give start", "stand-by, coordinator started with stations away from home"]
    {
        let of = shown(text, |_| {});
        let why = text.trim_start_matches("stand-by").trim_start_matches([',', ':']);
        assert_eq!(of, [format!("the line stands by:{why}; the steps back: Operate, or `linewright recover`")]);
    }
    let both = shown("stand-by. Left out: mill_1. clamp_1: restarted; give start", without);
    assert_eq!(both.len(), 2);
    assert!(both.iter().any(|text| text.starts_with("the line stands by: clamp_1: restarted; ")), "{both:?}");
    // Nor is such a station ready.
    let mut bench = ViewBench::received(0);
    let name = bench.line.stations[0].name.clone();
    bench.coordinator.as_mut().expect("received").0.restarted = vec![name];
    bench.stations[1].as_mut().expect("received").0.incomplete = vec![0];
    bench.stations[2].as_mut().expect("received").0.blocked_by = vec!["rejoin: confirm it".to_owned()];
    assert!(bench.page(1).stations.iter().all(|of| of.health == StationHealth::NotReady));
}

#[test]
fn an_emergency_stop_stands_above_newer_alarms_of_its_priority() {
    let mut bench = ViewBench::received(0);
    let line = &mut bench.coordinator.as_mut().expect("received").0;
    (line.mode, line.text) = (StationState::MODE_ESTOP, "emergency stop".to_owned());
    bench.page(0);
    bench.stations[1].as_mut().expect("received").0.fault = "watchdog".to_owned();
    let texts: Vec<String> = bench.page(60).alarms.into_iter().map(|of| of.text).collect();
    assert_eq!(texts, ["emergency stop", "watchdog"]);
}

/// Cards, lanes and alarms name a station by its name, which commands take, and add its title where that differs.
#[test]
fn a_title_stands_beside_the_name() {
    let mut bench = ViewBench::new(false);
    bench.line.stations[0].title = "Transfer bar".to_owned();
    bench.line.stations[1].title = "Clamp 1".to_owned();
    bench.retitled();
    let page = bench.page(0);
    let [name, label] =
        [bench.line.stations[0].name.clone(), format!("{} (Transfer bar)", bench.line.stations[0].name)];
    assert_eq!((&page.stations[0].name, &page.stations[0].label), (&name, &label));
    assert_eq!((&page.lanes[0].station, &page.lanes[0].label), (&name, &label));
    assert!(page.alarms.iter().any(|alarm| alarm.source == label), "{:?}", page.alarms);
    assert_eq!(page.stations[1].label, "clamp_1", "a title that says no more is none");
}
