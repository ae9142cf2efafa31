//! The lifecycle of a running line's nodes, led by a stranger as a lifecycle manager of ROS 2 does it.
//!
//! ```text
//!   auto ── mill_1 deactivate ──▶ its outputs off, stand-by, its reason ── activate ──▶ stand-by still ── an operator ──▶ auto
//!        ── coordinator deactivate ──▶ stand-by, commands refused, emergency stop obeyed
//!   run --no-autostart ──▶ unconfigured ── configure, activate ──▶ start is taken
//! ```

use linewright_msgs::{
    ChangeState, ChangeStateRequest, GetAvailableTransitions, GetAvailableTransitionsRequest, GetState,
    GetStateRequest, NodeTransition, StationState,
};
use linewright_node_shell::Caller;

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};
use crate::support::stranger::Stranger;
use crate::support::wait_for;

/// A node of the line, as a lifecycle manager sees it.
struct Managed {
    change: Caller<ChangeState>,
    state: Caller<GetState>,
}

impl Managed {
    fn of(stranger: &mut Stranger, node: &str) -> Self {
        let change = stranger.caller(&format!("/transfer_line/{node}/change_state"));
        Managed { change, state: stranger.caller(&format!("/transfer_line/{node}/get_state")) }
    }

    fn state(&self, stranger: &Stranger) -> String {
        stranger.ask(&self.state, &GetStateRequest::default()).current_state.label
    }

    /// Asks for a transition; whether it was made, and the state after it. It must know the node already: a request that is repeated
    /// would be another one.
    fn make(&self, stranger: &Stranger, label: &str) -> (bool, String) {
        let transition = NodeTransition { label: label.to_owned(), ..NodeTransition::default() };
        let made = stranger.ask(&self.change, &ChangeStateRequest { transition }).success;
        (made, self.state(stranger))
    }
}

fn after(made: bool, state: &str) -> (bool, String) {
    (made, state.to_owned())
}

/// Has what is discovered one by one discovered: a refused transition changes nothing.
fn meet(stranger: &Stranger, managed: &Managed) {
    assert!(!managed.make(stranger, "none of that name").0);
}

#[test]
fn a_station_is_deactivated_in_auto_and_comes_back_by_an_operator_alone() {
    let mut rig = Rig::new(&line(0.5));
    let operator = rig.in_auto();
    let mut stranger = Stranger::join(&rig);
    let clamp = Managed::of(&mut stranger, "clamp_1");
    meet(&stranger, &clamp);
    assert_eq!(clamp.state(&stranger), "active");
    operator.cycles(1);
    let life = operator.station("clamp_1").boot_id;

    operator.wait("the clamp moves", |h| !h.station("clamp_1").stopped);
    assert_eq!(clamp.make(&stranger, "deactivate"), after(true, "inactive"));
    rig.eye.wait("its outputs are off", |seen| !seen.energised().iter().any(|output| output.contains("clamp_1")));
    operator.wait("auto has ended", |h| h.line.mode == StationState::MODE_STANDBY);
    operator.wait("the reason is named", |h| {
        h.line.text.contains("clamp_1: node inactive; activate it (ros2 lifecycle set)")
            && h.station("clamp_1").lifecycle == StationState::LIFECYCLE_INACTIVE
            && h.station("clamp_1").blocked_by.first().is_some_and(|why| why.starts_with("node inactive: activate"))
    });
    let refusal = operator.refused("auto");
    assert!(refusal.contains("clamp_1: node inactive"), "{refusal}");
    // Once more, and what leads nowhere from there.
    for label in ["deactivate", "configure"] {
        assert_eq!(clamp.make(&stranger, label), after(false, "inactive"), "{label}");
    }
    let graph = stranger.caller::<GetAvailableTransitions>("/transfer_line/clamp_1/get_available_transitions");
    let found = stranger.ask(&graph, &GetAvailableTransitionsRequest::default()).available_transitions;
    let labels: Vec<&str> = found.iter().map(|found| found.transition.label.as_str()).collect();
    assert_eq!(labels, ["cleanup", "activate", "shutdown"]);

    assert_eq!(clamp.make(&stranger, "activate"), after(true, "active"));
    operator.wait("it is taken as started again", |h| {
        h.station("clamp_1").lifecycle == StationState::LIFECYCLE_ACTIVE
            && h.station("clamp_1").boot_id != life
            && h.line.text.contains("clamp_1: operation incomplete")
    });
    assert_eq!(operator.heard().line.mode, StationState::MODE_STANDBY, "{}", operator.picture());
    assert!(!rig.eye.seen().energised().iter().any(|output| output.contains("clamp_1 ")), "activity moves nothing");
    operator.recover();
    operator.cycles(1);
    assert!(rig.eye.seen().conflicts().is_empty(), "{:?}", rig.eye.seen().conflicts());
    operator.go_home();
    rig.ends_well(0);
}

#[test]
fn a_coordinator_that_is_deactivated_grants_no_mode_and_one_that_is_shut_down_never_again() {
    let mut rig = Rig::new(&line(0.5));
    let operator = rig.in_auto();
    let mut stranger = Stranger::join(&rig);
    let coordinator = Managed::of(&mut stranger, "coordinator");
    meet(&stranger, &coordinator);
    assert_eq!(coordinator.make(&stranger, "deactivate"), after(true, "inactive"));
    operator.wait("stand-by", |h| {
        h.line.mode == StationState::MODE_STANDBY && h.line.text.contains("coordinator inactive, no motion")
    });
    operator.wait("everything stands", |h| h.all(|s| s.stopped));
    for word in ["auto", "manual", "start"] {
        let refusal = operator.refused(word);
        assert!(refusal.contains("coordinator inactive, no motion; activate it"), "{word}: {refusal}");
    }
    assert_eq!(coordinator.make(&stranger, "activate"), after(true, "active"));
    operator.wait("the reason is past", |h| h.line.text.contains("auto ended (coordinator inactive, no motion"));
    assert_eq!(operator.heard().line.mode, StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    assert_eq!(coordinator.make(&stranger, "shutdown"), after(true, "finalized"));
    operator.wait("stand-by", |h| h.line.mode == StationState::MODE_STANDBY);
    assert_eq!(coordinator.make(&stranger, "activate"), after(false, "finalized"));
    let refusal = operator.refused("auto");
    assert!(refusal.contains("coordinator finalized, no motion; start its process again"), "{refusal}");
    operator.order("estop", StationState::MODE_ESTOP);
    assert!(rig.eye.seen().conflicts().is_empty());
    rig.signal("INT");
    rig.signal("INT");
    rig.ended();
}

#[test]
fn nodes_that_do_not_start_by_themselves_wait_for_a_manager() {
    let mut rig = Rig::new(&line(0.3));
    rig.start(&["--no-autostart"]);
    let operator = Operator::join(&rig);
    let mut stranger = Stranger::join(&rig);
    let names = ["coordinator", "transfer", "clamp_1", "mill_1"];
    let nodes = names.map(|name| Managed::of(&mut stranger, name));
    nodes.iter().for_each(|node| meet(&stranger, node));
    operator.wait("all are received, and none is active", |h| {
        h.all(|s| s.lifecycle == StationState::LIFECYCLE_UNCONFIGURED && s.devices_valid)
    });
    let refusal = operator.refused("start");
    assert!(refusal.contains("coordinator unconfigured, no motion; configure it, then activate it"), "{refusal}");
    for node in &nodes {
        assert_eq!(node.make(&stranger, "activate"), after(false, "unconfigured"));
        assert_eq!(node.make(&stranger, "configure"), after(true, "inactive"));
        assert_eq!(node.make(&stranger, "cleanup"), after(true, "unconfigured"));
        assert_eq!(node.make(&stranger, "configure"), after(true, "inactive"));
    }
    for node in &nodes {
        assert_eq!(node.make(&stranger, "activate"), after(true, "active"));
    }
    assert!(wait_for(crate::support::PATIENCE, || operator
        .heard()
        .all(|s| s.lifecycle == StationState::LIFECYCLE_ACTIVE)));
    assert_eq!(operator.heard().line.mode, StationState::MODE_HOME, "{}", operator.picture());
    operator.order("start", StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(0);
}
