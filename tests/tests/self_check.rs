//! Does the harness itself see what it should, and is it the same every time?
//!
//! A checker that has never complained has not been tested: here outputs are energised past every controller.

use std::time::Duration;

use linewright_line::{Owner, Tick};
use linewright_plant::{Plant, PlantOptions};
use linewright_tests::{IndependentObserver, ROUGH, WatchedLine, transfer_line};

/// Energises outputs for a while, one after the other, and gives what the observer did not like.
fn drive(outputs: &[(&str, &str, u64)]) -> Vec<String> {
    let line = transfer_line(1.0);
    let mut plant = Plant::new(&line, PlantOptions::default());
    let mut observer = IndependentObserver::new(&line);
    let mut now = Tick::ZERO;
    for &(station, output, millis) in outputs {
        let id = line.station_named(station).expect("a station");
        let at = line.station(id).outputs.iter().position(|name| name == output).expect("an output");
        plant.set_outputs(now, Owner::Station(id), 1 << at);
        now = now + Duration::from_millis(millis);
        plant.advance(now);
        observer.look(&plant);
        plant.set_outputs(now, Owner::Station(id), 0);
    }
    observer.violations().to_vec()
}

#[test]
fn the_observer_sees_a_bar_off_its_rest_under_a_clamp_that_is_not_open() {
    assert!(
        drive(&[("transfer", "lift_to_50", 200), ("transfer", "lower_to_0", 200), ("clamp_1", "close", 50)])[..]
            .is_empty()
    );
    let seen = drive(&[("transfer", "lift_to_50", 200), ("clamp_1", "close", 50)]);
    assert!(seen[0].contains("off its rest"), "{seen:?}");
    let seen = drive(&[("clamp_1", "close", 50), ("transfer", "lift_to_50", 20)]);
    assert!(seen[0].contains("off its rest"), "{seen:?}");
}

#[test]
fn the_observer_sees_a_tool_on_a_clamp_that_is_not_closed() {
    let seen = drive(&[("mill_1", "rapid_advance", 50)]);
    assert!(seen[0].contains("tool 1"), "{seen:?}");
    assert!(drive(&[("clamp_1", "close", 250), ("mill_1", "rapid_advance", 400)]).is_empty());
    let seen = drive(&[("clamp_1", "close", 250), ("mill_1", "rapid_advance", 400), ("clamp_1", "open", 20)]);
    assert!(seen[0].contains("tool 1"), "{seen:?}");
}

#[test]
fn the_observer_sees_a_part_carried_away_unfinished() {
    let lift = [("transfer", "lift_to_50", 200), ("transfer", "advance", 600), ("transfer", "lower_to_0", 200)];
    let back = [("transfer", "return", 600)];
    assert!(drive(&[&lift[..], &back, &lift[..2]].concat())[0].contains("without having been machined"));
    let machine = [
        ("clamp_1", "close", 250),
        ("mill_1", "rapid_advance", 400),
        ("mill_1", "slow_advance", 200),
        ("mill_1", "feed", 800),
        ("mill_1", "rapid_return", 400),
        ("mill_1", "reset", 400),
        ("clamp_1", "open", 250),
    ];
    assert_eq!(drive(&[&lift[..], &back, &machine, &lift[..2]].concat()), Vec::<String>::new());
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_seed_another() {
    let run = |seed: u64| {
        let mut sim = WatchedLine::with(&transfer_line(0.3), seed, ROUGH, 0.1);
        sim.start_auto();
        sim.run_for(Duration::from_secs(10));
        (sim.events(), sim.log().entries().to_vec())
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}
