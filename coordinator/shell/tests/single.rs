//! The orders of a station in manual by itself: each change is written down before it is given, and the others are in auto.

use linewright_coordinator_logic::ManualPermit;
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord};
use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};

use crate::rig::Rig;

const ROBOT: StationId = StationId(1);
const OTHER: StationId = StationId(0);

/// In auto, one station left out between two rests.
fn left_out() -> Rig {
    let mut rig = Rig::with_one_task_driven(CoordinatorRecord::default());
    rig.shell.plays_cell([].into_iter(), [].into_iter());
    rig.in_auto();
    rig.shell.plays_cell([ROBOT].into_iter(), [].into_iter());
    let heard = &mut rig.heard[ROBOT.index()];
    (heard.at_home, heard.stands_in, heard.incomplete) = (false, Some(OpId(0)), true);
    rig.shell.permit_manual(|_| Some(ManualPermit::LeftOut { tasks: 1, kept_in: None }));
    rig.refresh();
    rig
}

#[test]
fn it_stands_by_until_all_have_acknowledged_and_is_led_then() {
    let mut rig = left_out();
    let before = rig.shell.order().epoch;
    rig.shell.handle(rig.now, CoordinatorArrival::Single(ROBOT, true));
    let effects = rig.act();
    let of = |rig: &Rig, id| {
        let order = rig.shell.order_for(id);
        (order.mode, order.manual_all, order.single)
    };
    assert_eq!(of(&rig, ROBOT), (ControlMode::StandBy, false, true));
    assert_eq!(of(&rig, OTHER), (ControlMode::Auto, false, false));
    assert_eq!((rig.shell.order_for(ROBOT).epoch, rig.record.epoch), (before + 1, before + 1));
    let at = |is_it: fn(&CoordinatorEffect) -> bool| effects.iter().position(is_it).expect("it is done");
    let written = at(|effect| matches!(effect, CoordinatorEffect::Remember(_)));
    assert!(written < at(|effect| matches!(effect, CoordinatorEffect::Order { .. })));
    rig.refresh();
    assert_eq!(of(&rig, ROBOT), (ControlMode::StandBy, false, true));
    let kept_in = Some(rig.shell.coordinator().single_epoch(ROBOT));
    rig.shell.permit_manual(|_| Some(ManualPermit::LeftOut { tasks: 1, kept_in }));
    rig.refresh();
    assert_eq!(of(&rig, ROBOT), (ControlMode::Manual, true, true));
    let order = rig.shell.order_for(OTHER);
    assert_eq!((order.mode, order.enabled, order.single, order.manual_all), (ControlMode::Auto, true, false, false));
    rig.shell.handle(rig.now, CoordinatorArrival::Single(ROBOT, false));
    rig.act();
    assert_eq!(of(&rig, ROBOT), (ControlMode::Auto, false, false));
    assert_eq!(rig.record.epoch, before + 2);
}

/// A change that cannot be written down is not carried out: the line is in emergency stop.
#[test]
fn without_a_journal_there_is_none() {
    let mut rig = left_out();
    rig.disk_is_full = true;
    rig.shell.handle(rig.now, CoordinatorArrival::Single(ROBOT, true));
    let effects = rig.act();
    let written = effects.iter().position(|effect| matches!(effect, CoordinatorEffect::Remember(_))).expect("tried");
    let given = effects.iter().position(|effect| matches!(effect, CoordinatorEffect::Order { .. }));
    assert!(given.is_none_or(|given| given > written), "{effects:?}");
    assert_eq!((rig.mode(), rig.shell.order_for(ROBOT).mode), (ControlMode::EStop, ControlMode::EStop));
    assert!(!rig.shell.coordinator().is_single(ROBOT));
}

/// A refusal is shown until a command is obeyed or the mode changes: not by a change of the same step.
#[test]
fn a_refusal_stands_after_a_change_of_mode_of_the_same_step() {
    let mut rig = left_out();
    rig.shell.handle(rig.now, CoordinatorArrival::Single(OTHER, true));
    rig.shell.handle(rig.now, CoordinatorArrival::Console { bits: 0, valid: false });
    let effects = rig.act();
    let at = |is_it: fn(&CoordinatorEffect) -> bool| effects.iter().rposition(is_it).expect("it is done");
    let entered = at(|effect| matches!(effect, CoordinatorEffect::Entered(ControlMode::EStop)));
    assert!(entered < at(|effect| matches!(effect, CoordinatorEffect::Refused(_))));
}
