//! A completed cycle is published once, and never with a time in which the process stood still.

use std::time::Duration;

use linewright_coordinator_logic::{CompletedCycle, ModeCommand};
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
    assert_eq!(told[1].took, Some(Duration::from_millis(550)));
}

/// The last report of the cycle and the command that ends production are taken in at once, and the record of the mode takes
/// longer than a period, or fails: the effects after it are dropped.
#[test]
fn a_cycle_that_ends_as_a_slow_record_is_written_is_an_effect_once() {
    for (command, disk_takes, disk_is_full) in [
        (ModeCommand::Stop, Duration::from_millis(80), false),
        (ModeCommand::Stop, Duration::ZERO, true),
        (ModeCommand::EStop, Duration::from_millis(80), false),
    ] {
        let mut rig = Rig::new(CoordinatorRecord::default());
        rig.in_auto();
        stand(&mut rig, 1, false);
        rig.refresh();
        stand(&mut rig, 1, true);
        (rig.disk_takes, rig.disk_is_full) = (disk_takes, disk_is_full);
        rig.hear_all();
        rig.command(command);
        let mut told = cycles(&rig.act());
        (0..3).for_each(|_| told.extend(cycles(&rig.refresh())));
        let numbers: Vec<i32> = told.iter().map(|cycle| cycle.number).collect();
        assert_eq!(numbers, [1], "{command:?}, {disk_takes:?}, {disk_is_full}");
    }
}

#[test]
fn a_cycle_that_ended_while_the_process_stood_still_has_no_time() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    stand(&mut rig, 1, false);
    rig.refresh();
    stand(&mut rig, 1, true);
    rig.now = rig.now + Duration::from_secs(2);
    let ended: Vec<CompletedCycle> = (0..5).flat_map(|_| cycles(&rig.refresh())).collect();
    assert_eq!(ended, [CompletedCycle { number: 1, took: None }]);
}
