//! A controller that ends and comes up again from its record.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, StationId};
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
