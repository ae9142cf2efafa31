//! A controller that ends and comes up again from its record.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Motion, OpId, StationId};
use linewright_station_logic::{CompileError, Controller, Restore, StationSnapshot};

use super::rig::Rig;
use linewright_testkit::built::{alone, i, r};

fn restarted(rig: &Rig) -> Rig {
    Rig::of(rig.line.clone(), rig.station, Restore::From(rig.controller.snapshot()))
}

#[test]
fn restarted_in_the_middle_of_an_operation_it_stands_still_and_is_resumed() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.mode(ControlMode::Auto);
    let mut again = restarted(&rig);
    assert_eq!(again.marking(), [StationPlace::incomplete(OpId(0))]);
    assert_eq!(again.controller.fault_text(&again.line), "op 0: controller restarted");
    again.mode(ControlMode::Auto);
    assert_eq!(again.outputs, 0, "a person looks first");
    again.mode(ControlMode::Manual);
    again.advance_through(0);
    assert_eq!(again.report().done, [1, 0]);
}

#[test]
fn restarted_on_its_way_home_it_still_knows_where_it_was_going() {
    let mut rig = Rig::new(alone(2, &[r(1), i(1, &[0]), r(2)]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.advance(false);
    rig.retract(true);
    let mut again = restarted(&rig);
    again.mode(ControlMode::Manual);
    again.retract_through(0);
    again.retract(true);
    again.arrive(2);
    assert!(again.report().at_home);
    assert_eq!(again.report().done, [0, 0, 0]);
}

#[test]
fn a_snapshot_at_rest_brings_back_the_same_state() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.mode(ControlMode::Auto);
    rig.arrive(0);
    rig.arrive(1);
    rig.mode(ControlMode::StandBy);
    rig.arrive(0);
    assert_eq!(restarted(&rig).controller.snapshot(), rig.controller.snapshot());
}

#[test]
fn a_snapshot_of_another_description_is_refused_with_the_reason() {
    let line = alone(2, &[r(1), i(1, &[0]), r(2)]);
    let good = Controller::new(&line, StationId(0), 1, Restore::Fresh).expect("compiles").snapshot();
    let refused = |damage: &dyn Fn(&mut StationSnapshot)| {
        let mut snapshot = good.clone();
        damage(&mut snapshot);
        match Controller::new(&line, StationId(0), 1, Restore::From(snapshot)) {
            Err(CompileError::SnapshotDoesNotFit { why }) => why,
            other => panic!("taken: {other:?}"),
        }
    };
    assert_eq!(refused(&|s| s.done.push(0)), "other number of operations");
    assert_eq!(refused(&|s| s.started.clear()), "other number of operations");
    assert_eq!(refused(&|s| s.marking.clear()), "no marked place");
    assert_eq!(refused(&|s| s.marking[0].op = OpId(9)), "marked place not in the net");
    assert_eq!(refused(&|s| s.marking[0] = StationPlace::undone(OpId(1))), "marked place not in the net");
    assert_eq!(
        refused(&|s| s.marking.push(StationPlace::completed(OpId(0)))),
        "marked places are not those of one step"
    );
    assert_eq!(refused(&|s| s.path = Some(OpId(0))), "recovery path not in the net");
    assert_eq!(refused(&|s| s.done[0] = 1), "counts contradict each other");
    assert_eq!(refused(&|s| s.cycle = i32::MAX), "counts contradict each other");
}

/// Without a switch that measures the home position at rest, nothing but the confirmation stands against the claim.
#[test]
fn from_a_record_that_is_not_certain_it_is_at_home_only_if_the_devices_confirm_it() {
    // Two switches at one place measure nothing at rest.
    let mut line = alone(1, &[r(6), r(6)]);
    let home = line.stations[0].operations[1].motion;
    line.stations[0].operations[0].motion = Motion { from: home.to, to: home.from, ..home };
    // Ended before its devices were received.
    let unconfirmed = Controller::new(&line, StationId(0), 1, Restore::Fresh).expect("compiles").snapshot();
    // Written at home before the host lost its power.
    let outdated = StationSnapshot { generation: 0, placed: false, ..Rig::new(line.clone()).controller.snapshot() };
    for record in [unconfirmed, outdated] {
        let from = || Restore::From(record.clone());
        let away = Rig::standing(line.clone(), StationId(0), 2, from(), 0);
        assert!(!away.report().at_home);
        assert_eq!(away.fault(), "op 1: not at home at power-up");
        assert_eq!(away.report().done, [0, -1]);
        assert!(Rig::of(line.clone(), StationId(0), from()).report().at_home);
    }
    // What was confirmed once is a memory.
    let remembered = Rig::new(line.clone()).controller.snapshot();
    assert!(Rig::standing(line, StationId(0), 2, Restore::From(remembered), 0).report().at_home);
}

/// An axis with two switches at each of its places is there while one of them is on.
#[test]
fn an_axis_that_several_switches_measure_is_at_home_while_one_of_them_is_on() {
    let mut line = alone(3, &[r(6), r(6), r(6), r(6)]);
    for (there, back) in [(0, 1), (2, 3)] {
        let there = line.stations[0].operations[there].motion;
        line.stations[0].operations[back].motion = Motion { from: there.to, to: there.from, ..there };
    }
    let [forward, undone, back, home] = [1 << 0, 1 << 2, 1 << 4, 1 << 12];
    let started = |image| Rig::alone(line.clone(), StationId(0), Restore::Fresh, image);
    let is_lost = |image| started(image).controller.position_lost().is_some();
    assert_eq!([home | back, home | undone, home | forward].map(is_lost), [false, false, true]);
    let mut rig = started(forward);
    assert_eq!(rig.fault(), "op 3: not at home at power-up");
    rig.manual();
    assert!(rig.marking()[0].is_incomplete(), "it is not led home past an axis at its other end");
    rig.advance(false);
    rig.set(forward, false);
    rig.set(back, true);
    rig.advance(true);
    assert!(rig.marking()[0].is_operating());
}
