//! The order protocol of the shipped cells, with the real player and the real controllers; and without each of its rules.

use linewright_cell::Cell;
use linewright_line::Line;
use linewright_proof::cell::Verdict;
use linewright_proof::cell::protocol::{
    ANSWERED, ActivityExplored, BACK, BrokenRule, ENDED, GIVEN, ProtocolSetting, RESTORED, STOPPED, TWICE,
    check_protocol, properties,
};
use linewright_proof::explore::LimitReached;

use super::described;

fn shipped(name: &str) -> (Cell, Line) {
    described(name, "")
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

/// Those of one machine; `cli/tests/check_cell.rs` has all of both shipped cells.
#[test]
fn the_activities_at_a_machine_of_c1_keep_the_rules() {
    let (cell, line) = shipped("workcell-c1");
    let setting = ProtocolSetting::new(&cell, &line);
    let begun = check_protocol(&ProtocolSetting { states: 1, ..setting }).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(begun.len(), 9, "loading, working and unloading at each machine: {}", told(&begun));
    for only in [LOAD, PROCESS, "unload M1"] {
        let setting = ProtocolSetting { only: Some(only), ..ProtocolSetting::new(&cell, &line) };
        let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(found.len(), 1);
        assert!(properties(&found).iter().all(|property| property.verdict == Verdict::Holds), "{}", told(&found));
    }
}

/// With a fault, a restart, a lost memory, an alarm, a late report, a person who leads the station, and any two of
/// them.
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

/// The same of the loading, by two stations: 4,871,376 states.
#[test]
#[ignore = "half a minute and some gigabytes"]
fn loading_in_c1_keeps_the_rules_whatever_disturbs_it_once() {
    let (cell, line) = shipped("workcell-c1");
    let new = ProtocolSetting::new(&cell, &line);
    let setting = ProtocolSetting { disturbances: 1, only: Some(LOAD), states: 10_000_000, ..new };
    let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
    println!("{}", told(&found));
    assert!(properties(&found).iter().all(|property| property.verdict == Verdict::Holds), "{}", told(&found));
}

/// The first 100,000 states of the ignored test above; every rule broken below is found among the first 50,000.
#[test]
fn loading_in_c1_keeps_the_rules_when_alarm_is_given_as_far_as_is_looked() {
    let (cell, line) = shipped("workcell-c1");
    let all = ProtocolSetting::new(&cell, &line);
    let setting = ProtocolSetting { disturbances: 1, states: 100_000, only: Some(LOAD), ..all };
    let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!((found.len(), &found[0].wrong, found[0].states >= 100_000), (1, &None, true), "{}", told(&found));
    assert_eq!(found[0].limit, Some(LimitReached::States));
}

#[test]
fn the_limit_that_ends_an_exploration_is_named_and_leaves_every_rule_undecided() {
    let (cell, line) = shipped("workcell-c1");
    let all = ProtocolSetting::new(&cell, &line);
    for (states, bytes, limit, text) in [
        (100, usize::MAX, LimitReached::States, "the limit of states was reached"),
        (1_000_000, 10_000, LimitReached::Memory, "the limit of memory was reached"),
    ] {
        let setting = ProtocolSetting { states, bytes, only: Some(LOAD), ..all.clone() };
        let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!((found.len(), found[0].limit), (1, Some(limit)), "{}", told(&found));
        let properties = properties(&found);
        assert!(properties.iter().all(|property| property.verdict == Verdict::Undecided), "{properties:?}");
        assert!(properties.iter().all(|property| property.reason.ends_with(text)), "{properties:?}");
    }
}

/// The broken rule found with some rules off.
fn without(only: &'static str, disturbances: u8, change: impl Fn(&mut ProtocolSetting<'_>)) -> BrokenRule {
    let (cell, line) = shipped("workcell-c1");
    let mut setting = ProtocolSetting::new(&cell, &line);
    (setting.only, setting.disturbances) = (Some(only), disturbances);
    change(&mut setting);
    let found = check_protocol(&setting).unwrap_or_else(|why| panic!("{why}"));
    println!("{}", told(&found));
    found.into_iter().find_map(|one| one.wrong).unwrap_or_else(|| panic!("nothing is found"))
}

const LOAD: &str = "load M1";
const PROCESS: &str = "M1.process";

/// The race: the station reports the end of an order as soon as its time is over, then it goes back; the player takes
/// it for standing, raises an alarm, is answered, and starts the loading again while the arm moves.
#[test]
fn an_order_that_has_ended_while_its_station_moves_is_answered_and_started_again_too_soon() {
    let race = |asked| {
        without(LOAD, 0, |setting| {
            (setting.order_rules.ends_standing, setting.rules.slot_counts) = (false, false);
            setting.asked = Some(asked);
        })
    };
    let answered = race(ANSWERED);
    assert_eq!(answered.end, "the answer is taken while robot is at order 1, and moves");
    let again = race(GIVEN);
    assert_eq!(again.end, "robot is given the next order while it is at order 1");
    assert_eq!(
        again.steps.last().map(String::as_str),
        Some("the operator answers \"in-store\""),
        "which starts it again"
    );
    assert!(
        again.steps.iter().any(|step| step.contains("order 1 in progress; order 1 failed with code 1000")),
        "{again:?}"
    );
}

/// An order ended by a fault or a person is gone back from, while its result reports the end all the time.
#[test]
fn a_slot_that_does_not_count_is_answered_while_the_station_goes_back() {
    let found = without(LOAD, 1, |setting| setting.rules.slot_counts = false);
    assert_eq!(found.rule, ANSWERED);
    assert!(found.steps.iter().any(|step| step.contains("order 1 in progress; order 1 failed")), "{found:?}");
}

#[test]
fn somebody_who_is_asked_before_the_stations_stand_is_answered_too_soon() {
    let found = without(LOAD, 0, |setting| setting.rules.stands_first = false);
    assert!([ANSWERED, RESTORED].contains(&found.rule), "{found:?}");
}

/// Each without one rule, and the property that is then found broken.
#[test]
fn without_a_rule_its_property_is_broken() {
    type Change = fn(&mut ProtocolSetting<'_>);
    let broken: [(&str, u8, Change, &str); 9] = [
        // It says that it has ended before it stands.
        (PROCESS, 0, |of| of.order_rules.ends_standing = false, ENDED),
        // An order that has ended by itself is secured with each message about it: the message to stop makes the station move.
        (LOAD, 1, |of| of.order_rules.secures_once = false, STOPPED),
        (LOAD, 0, |of| (of.order_rules.does_once, of.asked) = (false, Some(TWICE)), TWICE),
        // An order for another memory is done as well.
        (LOAD, 1, |of| of.order_rules.own_memory = false, TWICE),
        // After an alarm it is ordered back.
        (LOAD, 1, |of| of.rules.stops = false, STOPPED),
        // Ordered to stop, it goes back.
        (LOAD, 1, |of| of.order_rules.stops_at_once = false, STOPPED),
        // Somebody is asked after an alarm before the stations stand.
        (LOAD, 1, |of| (of.rules.stands_first, of.asked) = (false, Some(STOPPED)), STOPPED),
        // The robot goes back from the clamp, which may have closed: by order, and by itself.
        (LOAD, 0, |of| of.rules.goes_back_alone = false, BACK),
        (LOAD, 0, |of| (of.order_rules.ends_standing, of.asked) = (false, Some(BACK)), BACK),
    ];
    for (at, (only, disturbances, change, rule)) in broken.into_iter().enumerate() {
        assert_eq!(without(only, disturbances, change).rule, rule, "the {at}th");
    }
}
