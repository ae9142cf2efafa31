//! Order of writing and sending, and a line whose coordinator cannot write.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::{CoordinatorEffect, CoordinatorRecord};
use linewright_line::net::ControlMode;

use crate::rig::Rig;

fn place(effects: &[CoordinatorEffect], what: impl Fn(&CoordinatorEffect) -> bool) -> usize {
    effects.iter().position(what).unwrap_or_else(|| panic!("not among {effects:?}"))
}

fn is_record(effect: &CoordinatorEffect) -> bool {
    matches!(effect, CoordinatorEffect::Remember(_))
}

fn is_order(effect: &CoordinatorEffect) -> bool {
    matches!(effect, CoordinatorEffect::Order { .. })
}

#[test]
fn a_mode_is_written_down_before_it_is_ordered_and_the_emergency_stop_after() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.command(ModeCommand::Start);
    let done = rig.act();
    assert!(place(&done, is_record) < place(&done, is_order));
    rig.command(ModeCommand::EStop);
    let done = rig.act();
    assert!(place(&done, is_order) < place(&done, is_record));
    assert!(rig.record.estop);
}

#[test]
fn the_emergency_stop_takes_outputs_off_the_bus_before_anything_is_written() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let station = rig.line.station_named("clamp_1").expect("a clamp");
    rig.outputs(station, 1);
    let on = rig.act();
    assert!(on.contains(&CoordinatorEffect::Energise(station, 1)), "{on:?}");
    rig.command(ModeCommand::EStop);
    let done = rig.act();
    let off = place(&done, |effect| *effect == CoordinatorEffect::Energise(station, 0));
    assert!(off < place(&done, is_record));
}

#[test]
fn an_emergency_stop_that_cannot_be_written_stays_in_force_and_is_written_when_it_can_be() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    rig.disk_is_full = true;
    rig.writes.clear();
    rig.command(ModeCommand::EStop);
    rig.act();
    assert_eq!(rig.mode(), ControlMode::EStop);
    for _ in 0..100 {
        rig.refresh();
        rig.command(ModeCommand::Reset);
        let refused = rig.act();
        let is_refused = |effect: &CoordinatorEffect| match effect {
            CoordinatorEffect::Refused(refusal) => refusal.text(&rig.line).contains("journal not writable"),
            _ => false,
        };
        assert!(refused.iter().any(is_refused), "{refused:?}");
        assert_eq!(rig.mode(), ControlMode::EStop);
    }
    let apart = rig.writes.windows(2).all(|two| two[1].since(two[0]) >= Duration::from_secs(1));
    assert!(apart && rig.writes.len() >= 5, "{:?}", rig.writes);
    assert!(!rig.record.estop);
    rig.disk_is_full = false;
    (0..21).for_each(|_| drop(rig.refresh()));
    assert!(rig.record.estop);
    rig.command(ModeCommand::Reset);
    rig.command(ModeCommand::Manual);
    rig.act();
    assert_eq!(rig.mode(), ControlMode::Manual);
}

/// The order of a mode that could not be written down must not go out: the next coordinator would not have its epoch.
#[test]
fn a_mode_that_cannot_be_written_is_not_ordered_and_becomes_an_emergency_stop() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.command(ModeCommand::Start);
    rig.refresh();
    rig.disk_is_full = true;
    rig.command(ModeCommand::Auto);
    let done = rig.act();
    let (record, order) = (place(&done, is_record), place(&done, is_order));
    assert!(record < order, "{done:?}");
    assert_eq!(rig.shell.order().mode, ControlMode::EStop, "what is ordered after it is the stop");
    assert!(rig.shell.coordinator().text().contains("journal not writable"), "{}", rig.shell.coordinator().text());
}

#[test]
fn outputs_go_off_before_a_record_and_after_a_slow_one_none_goes_on_by_what_was_decided_before_it() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let station = rig.line.station_named("clamp_1").expect("a clamp");
    rig.outputs(station, 0b01);
    rig.act();
    // The epoch of a master stop is to be written down, and another output comes in the same moment.
    rig.disk_takes = Duration::from_secs(1);
    rig.outputs(station, 0b10);
    rig.command(ModeCommand::Stop);
    let done = rig.act();
    let energised = |bits| move |effect: &CoordinatorEffect| *effect == CoordinatorEffect::Energise(station, bits);
    assert!(place(&done, energised(0)) < place(&done, is_record), "{done:?}");
    assert!(!done.iter().any(energised(0b10)), "its image is a second old: {done:?}");
    assert!(!done[..place(&done, is_record)].iter().any(is_order), "{done:?}");
    assert!(done.iter().any(is_order), "it is ordered after the record was decided on anew: {done:?}");
    rig.disk_takes = Duration::ZERO;
    (0..3).for_each(|_| drop(rig.refresh()));
    rig.outputs(station, 0b10);
    assert!(rig.act().iter().any(energised(0b10)));
}

/// Decisions from before the slow record were dropped, and with them the account of what is on the bus.
#[test]
fn outputs_go_off_before_the_record_that_follows_a_slow_one() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let station = rig.line.station_named("clamp_1").expect("a clamp");
    rig.outputs(station, 0b01);
    rig.act();
    rig.command(ModeCommand::Stop);
    let mut effects = Vec::new();
    rig.shell.act(rig.now, &mut effects);
    let Some(CoordinatorEffect::Remember(record)) = effects.iter().find(|effect| is_record(effect)).cloned() else {
        panic!("a master stop is an epoch: {effects:?}");
    };
    rig.now = rig.now + Duration::from_secs(1);
    assert!(!rig.shell.remembered(rig.now, record, true), "a second is late");
    // By now the stations are too old: stand-by, which is written down as well.
    let done = rig.act();
    let off = CoordinatorEffect::Energise(station, 0);
    assert!(place(&done, |effect| *effect == off) < place(&done, is_record), "{done:?}");
}

/// Bit by bit, place 1 would stay on of an order to place 3.
#[test]
fn an_order_to_another_place_is_not_on_the_bus_before_the_record() {
    const TURN: u128 = 0b10;
    let mut rig = Rig::with_a_table(CoordinatorRecord::default());
    rig.in_auto();
    let station = rig.line.station_named("table").expect("a table");
    let order = |number: u128| TURN | number << 2;
    rig.outputs(station, order(3));
    assert!(rig.act().contains(&CoordinatorEffect::Energise(station, order(3))));
    rig.outputs(station, order(1));
    rig.command(ModeCommand::Stop);
    let done = rig.act();
    let (before, after) = done.split_at(place(&done, is_record));
    let turns = |effect: &CoordinatorEffect| matches!(effect, CoordinatorEffect::Energise(id, bits) if *id == station && bits & TURN != 0);
    assert!(!before.iter().any(turns), "{done:?}");
    assert!(after.contains(&CoordinatorEffect::Energise(station, order(1))), "{done:?}");
}
