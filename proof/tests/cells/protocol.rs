//! The order protocol of the shipped cells, with the real player and the real controllers; and without each of its rules.

use std::path::Path;

use linewright_cell::Cell;
use linewright_line::Line;
use linewright_proof::cell::Verdict;
use linewright_proof::cell::protocol::{
    ANSWERED, ActivityExplored, GIVEN, ProtocolSetting, RESTORED, STOPPED, TWICE, check_protocol, properties,
};

fn shipped(name: &str) -> (Cell, Line) {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines").join(name);
    let text = |file: &str| std::fs::read_to_string(dir.join(file)).expect("it is there");
    let line = linewright_line::parse("line.toml", &text("line.toml")).unwrap_or_else(|why| panic!("{why:#}")).line;
    let cell = linewright_cell::parse("cell.toml", &text("cell.toml"), Some(&line));
    (cell.unwrap_or_else(|why| panic!("{why:#}")).cell, line)
}

fn told(of: &[ActivityExplored]) -> String {
    let all = of.iter().map(|one| {
        let mut text = format!(
            "{} ({}): {} states, {}\n",
            one.name,
            one.stations.join(", "),
            one.states,
            if one.exhausted { "all" } else { "not all" }
        );
        if let Some(wrong) = &one.wrong {
            text += &format!("  NOT: {}\n", wrong.rule);
            wrong.steps.iter().for_each(|step| text += &format!("  - {step}\n"));
            text += &format!("  and so: {}\n", wrong.end);
        }
        text
    });
    all.collect()
}

#[test]
fn every_activity_of_c1_keeps_the_rules() {
    let (cell, line) = shipped("workcell-c1");
    let found = check_protocol(&ProtocolSetting::new(&cell, &line)).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(found.len(), 9, "loading, working and unloading at each machine: {}", told(&found));
    assert!(properties(&found).iter().all(|property| property.verdict == Verdict::Holds), "{}", told(&found));
}

/// With a fault, a restart, a lost memory, an alarm, a late report, and any two of them.
#[test]
fn working_in_c1_keeps_the_rules_whatever_disturbs_it() {
    let (cell, line) = shipped("workcell-c1");
    for disturbances in 1..=2 {
        let setting = ProtocolSetting { disturbances, only: Some("M1.process"), ..ProtocolSetting::new(&cell, &line) };
        let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
        println!("{}", told(&found));
        assert_eq!(found.len(), 1);
        assert!(properties(&found).iter().all(|property| property.verdict == Verdict::Holds), "{}", told(&found));
    }
}

/// What is found of the loading with some rules off.
fn without(disturbances: u8, change: impl Fn(&mut ProtocolSetting<'_>)) -> ActivityExplored {
    let (cell, line) = shipped("workcell-c1");
    let mut setting = ProtocolSetting::new(&cell, &line);
    (setting.only, setting.disturbances) = (Some("load M1"), disturbances);
    change(&mut setting);
    let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
    println!("{}", told(&found));
    found.into_iter().find(|one| one.wrong.is_some()).unwrap_or_else(|| panic!("nothing is found"))
}

fn rule(of: &ActivityExplored) -> &'static str {
    of.wrong.as_ref().expect("it is wrong").rule
}

/// The race: the station says that an order has ended as soon as its time is over, then it goes back, and who hears that
/// takes it for standing.
#[test]
fn an_order_that_has_ended_while_its_station_moves_is_answered_too_soon() {
    let found = without(0, |setting| {
        setting.order_rules.ends_standing = false;
        setting.rules.slot_counts = false;
    });
    assert!([ANSWERED, RESTORED, GIVEN].contains(&rule(&found)), "{}", told(&[found]));
}

#[test]
fn somebody_who_is_asked_before_the_stations_stand_is_answered_too_soon() {
    let found = without(0, |setting| {
        setting.rules.stands_first = false;
    });
    assert!([ANSWERED, RESTORED].contains(&rule(&found)), "{}", told(&[found]));
}

#[test]
fn a_station_that_does_what_it_has_done_does_it_twice() {
    let found = without(0, |setting| {
        setting.order_rules.does_once = false;
    });
    assert_eq!(rule(&found), TWICE);
}

#[test]
fn an_order_for_another_memory_is_done_twice() {
    let found = without(1, |setting| setting.order_rules.own_memory = false);
    assert_eq!(rule(&found), TWICE);
}

/// Two stations, and somebody who gives alarm, or one other disturbance. That is too much to see all of it; what is broken
/// has so far been found among the first twenty thousand states.
#[test]
fn loading_in_c1_keeps_the_rules_when_alarm_is_given_as_far_as_is_looked() {
    let (cell, line) = shipped("workcell-c1");
    let all = ProtocolSetting::new(&cell, &line);
    let setting = ProtocolSetting { disturbances: 1, states: 300_000, only: Some("load M1"), ..all };
    let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!((found.len(), &found[0].wrong, found[0].states >= 300_000), (1, &None, true), "{}", told(&found));
}

#[test]
fn told_to_go_back_after_an_alarm_a_station_moves_on() {
    let found = without(1, |setting| setting.rules.stops = false);
    assert_eq!(rule(&found), STOPPED);
}

#[test]
fn a_station_that_goes_back_when_it_is_told_to_stop_moves_on() {
    let found = without(1, |setting| setting.order_rules.stops_at_once = false);
    assert_eq!(rule(&found), STOPPED);
}

#[test]
fn somebody_is_asked_after_an_alarm_before_the_stations_stand() {
    let found = without(1, |setting| setting.rules.stands_first = false);
    assert_eq!(rule(&found), STOPPED);
}
