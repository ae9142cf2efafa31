//! The coordinator's own node: what its transitions do to the mode, the record and what is sent.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::{CoordinatorEffect, CoordinatorRecord};
use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;

use crate::rig::Rig;

#[test]
fn the_end_of_activity_is_ordered_at_once_in_an_epoch_that_is_written_before() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let epoch = rig.shell.order().epoch;
    rig.shell.follow_lifecycle(rig.now, LifecycleState::Inactive);
    let done = rig.act();
    let order = rig.shell.order();
    assert_eq!((order.mode, rig.mode()), (ControlMode::StandBy, ControlMode::StandBy));
    assert!(order.epoch > epoch && rig.record.epoch == order.epoch);
    let place = |what: fn(&CoordinatorEffect) -> bool| done.iter().position(what);
    let written = place(|effect| matches!(effect, CoordinatorEffect::Remember(_)));
    let ordered = place(|effect| matches!(effect, CoordinatorEffect::Order { .. }));
    assert!(written.is_some() && written < ordered, "{done:?}");
    // Emergency stop is obeyed, and written down.
    rig.command(ModeCommand::EStop);
    rig.act();
    assert!(rig.mode() == ControlMode::EStop && rig.record.estop);
}

#[test]
fn a_request_to_activate_from_before_a_standstill_is_refused() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.shell.follow_lifecycle(rig.now, LifecycleState::Inactive);
    rig.act();
    assert_eq!(rig.shell.against_requests(rig.now), None);
    rig.now = rig.now + Duration::from_secs(60);
    assert!(rig.shell.against_requests(rig.now).is_some());
    for _ in 0..20 {
        rig.refresh();
    }
    assert_eq!(rig.shell.against_requests(rig.now), None);
}

#[test]
fn it_is_not_configured_while_its_journal_cannot_be_written() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    assert_eq!(rig.shell.against_configuring(), None);
    let record = rig.shell.to_remember();
    rig.shell.remembered(rig.now, record, false);
    assert!(rig.shell.against_configuring().is_some());
    rig.shell.remembered(rig.now, record, true);
    assert_eq!(rig.shell.against_configuring(), None);
}
