//! A completed cycle is published once, and never with a time in which the process stood still.

use std::time::Duration;

use linewright_coordinator_logic::CompletedCycle;
use linewright_coordinator_shell::{CoordinatorEffect, CoordinatorRecord};

use crate::rig::Rig;

/// All stations are in this round, or at home at the end of it.
fn stand(rig: &mut Rig, round: i32, at_home: bool) {
    for heard in &mut rig.heard {
        (heard.round, heard.at_home, heard.stopped) = (round, at_home, at_home);
    }
}

fn cycles(effects: &[CoordinatorEffect]) -> Vec<CompletedCycle> {
    let cycle = |effect: &CoordinatorEffect| match effect {
        CoordinatorEffect::Completed(cycle) => Some(*cycle),
        _ => None,
    };
    effects.iter().filter_map(cycle).collect()
}

#[test]
fn a_completed_cycle_is_an_effect_once() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let mut told = Vec::new();
    for round in 1..=2 {
        stand(&mut rig, round, false);
        (0..9).for_each(|_| told.extend(cycles(&rig.refresh())));
        stand(&mut rig, round, true);
        (0..2).for_each(|_| told.extend(cycles(&rig.refresh())));
    }
    let numbers: Vec<i32> = told.iter().map(|cycle| cycle.number).collect();
    assert_eq!(numbers, [1, 2]);
    // Eleven periods of 50 ms from end to end.
    assert_eq!(told[1].took, Duration::from_millis(550));
}

#[test]
fn a_cycle_that_ended_while_the_process_stood_still_has_no_time() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    stand(&mut rig, 1, false);
    rig.refresh();
    stand(&mut rig, 1, true);
    rig.now = rig.now + Duration::from_secs(2);
    for _ in 0..5 {
        assert_eq!(cycles(&rig.refresh()), []);
    }
}
