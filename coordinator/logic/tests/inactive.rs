//! Nodes that are not active: no mode is granted past one, none by one, and activity alone grants none.

use linewright_coordinator_logic::{ModeCommand, ModeInput, ModeOutbox, StationView};
use linewright_lifecycle::LifecycleState;
use linewright_line::StationId;
use linewright_line::net::ControlMode;
use proptest::prelude::*;

use crate::common::CoordinatorBench;

const INACTIVE: Option<LifecycleState> = Some(LifecycleState::Inactive);

/// Deactivates the node of the second station: the last report of its present life has the state inactive.
fn deactivate(bench: &mut CoordinatorBench) {
    bench.heard[1].inactive = INACTIVE;
    bench.say(1);
}

#[test]
fn a_station_that_is_deactivated_ends_every_mode_that_enables_motion_at_once_and_is_named() {
    for mode in [ControlMode::Auto, ControlMode::Hand] {
        let mut bench = CoordinatorBench::in_mode(mode);
        deactivate(&mut bench);
        assert_eq!(bench.mode(), ControlMode::StandBy, "{mode}");
        let text = bench.coordinator.text();
        let reason = "clamp_1: node inactive; activate it (ros2 lifecycle set)";
        assert!(text.contains(reason) && !text.contains("no state received"), "{text}");
        for command in [ModeCommand::Auto, ModeCommand::Hand, ModeCommand::Manual] {
            let refusal = bench.command(command).expect("it is refused");
            assert!(refusal.contains(reason), "{refusal}");
            assert!(!bench.coordinator.order().enabled || !bench.mode().enables_motion());
        }
    }
}

#[test]
fn a_deactivated_station_is_not_received_and_no_order_names_its_next_life_before_it_is_active() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    deactivate(&mut bench);
    // Of its next life nothing is taken while it is not active.
    bench.heard[1] = StationView { boot_id: 8, inactive: INACTIVE, ..bench.heard[1] };
    bench.beat();
    assert!(!bench.coordinator.hears(StationId(1)));
    assert_eq!(bench.coordinator.life_of(StationId(1)), 7);
    // Active, it has been started again, and an operator has to look at it.
    bench.heard[1].inactive = None;
    bench.beat();
    assert_eq!(bench.coordinator.life_of(StationId(1)), 8);
    assert_eq!(bench.mode(), ControlMode::StandBy, "activity grants no mode");
    let refusal = bench.command(ModeCommand::Auto).expect("nobody has looked at it");
    assert!(refusal.contains("clamp_1: restarted; give start"), "{refusal}");
    assert_eq!(bench.command(ModeCommand::Start), None);
    assert_eq!(bench.command(ModeCommand::Auto), None);
    assert_eq!(bench.mode(), ControlMode::Auto);
}

/// The last report of a life may be the only one with an emergency stop that another coordinator has given.
#[test]
fn an_emergency_stop_in_the_last_report_is_not_lost() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[1].estopped = true;
    deactivate(&mut bench);
    assert_eq!(bench.mode(), ControlMode::EStop);
}

/// Its process was killed while it was deactivated.
#[test]
fn a_deactivated_station_that_is_silent_is_one_that_is_not_received() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    deactivate(&mut bench);
    let stale = bench.line.timing.stale;
    for _ in 0..8 {
        bench.now = bench.now + stale / 2;
        [0, 2].into_iter().for_each(|station| bench.say(station));
    }
    let text = bench.coordinator.text();
    assert!(text.contains("clamp_1: no state received") && !text.contains(": clamp_1: node"), "{text}");
}

#[test]
fn one_that_its_cell_leaves_out_stops_nobody_else() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        assert_eq!(bench.command(command), None);
    }
    bench.coordinator.isolate(|id, _| id == StationId(1));
    deactivate(&mut bench);
    bench.beat();
    let reason = "clamp_1: node inactive; activate it (ros2 lifecycle set)";
    assert_eq!(bench.coordinator.text(), format!("auto. Left out: clamp_1. {reason}"));
    assert_eq!(bench.coordinator.standing().obstacles, [reason]);
    assert!(bench.coordinator.order().enabled);
}

#[test]
fn a_coordinator_that_is_deactivated_leads_to_stand_by_and_obeys_emergency_stop_alone() {
    for mode in [ControlMode::Auto, ControlMode::Hand, ControlMode::Manual] {
        let mut bench = CoordinatorBench::in_mode(mode);
        let epoch = bench.coordinator.epoch();
        bench.input(ModeInput::Lifecycle(LifecycleState::Inactive));
        assert_eq!(bench.mode(), ControlMode::StandBy, "{mode}");
        assert!(bench.coordinator.epoch() > epoch, "of an epoch of its own, so that each station acknowledges it");
        let text = bench.coordinator.text();
        assert!(text.contains("coordinator inactive, no motion; activate it (ros2 lifecycle set)"), "{text}");
        for command in ModeCommand::ALL.into_iter().filter(|command| *command != ModeCommand::EStop) {
            let refusal = bench.command(command).expect("it is refused");
            assert!(refusal.contains("coordinator inactive, no motion"), "{refusal}");
        }
        assert_eq!(bench.mode(), ControlMode::StandBy);
        assert_eq!(bench.command(ModeCommand::EStop), None);
        assert_eq!(bench.mode(), ControlMode::EStop);
    }
}

#[test]
fn activity_alone_leads_to_no_mode_and_a_second_request_changes_nothing() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.input(ModeInput::Lifecycle(LifecycleState::Inactive));
    let epoch = bench.coordinator.epoch();
    bench.input(ModeInput::Lifecycle(LifecycleState::Inactive));
    assert_eq!(bench.coordinator.epoch(), epoch);
    for _ in 0..2 {
        bench.input(ModeInput::Lifecycle(LifecycleState::Active));
        bench.beat();
        assert_eq!((bench.mode(), bench.coordinator.epoch()), (ControlMode::StandBy, epoch));
    }
    assert_eq!(bench.command(ModeCommand::Auto), None);
    assert_eq!(bench.mode(), ControlMode::Auto);
}

#[test]
fn a_selector_at_manual_leads_nowhere_while_the_coordinator_is_not_active() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    bench.input(ModeInput::Lifecycle(LifecycleState::Unconfigured));
    bench.heard[0].selector_manual = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
    // As ever, once it is active.
    bench.input(ModeInput::Lifecycle(LifecycleState::Active));
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
}

#[derive(Clone, Copy, Debug)]
enum Act {
    Command(ModeCommand),
    Own(LifecycleState),
    Station(usize, Option<LifecycleState>),
    Restart(usize),
    Selector(usize, bool),
    Silence,
}

fn act() -> impl Strategy<Value = Act> {
    let own = [LifecycleState::Active, LifecycleState::Inactive, LifecycleState::Finalized];
    let state = prop::sample::select(vec![None, INACTIVE, Some(LifecycleState::Unconfigured)]);
    prop_oneof![
        6 => prop::sample::select(ModeCommand::ALL.to_vec()).prop_map(Act::Command),
        2 => prop::sample::select(own.to_vec()).prop_map(Act::Own),
        3 => (0usize..3, state).prop_map(|(station, state)| Act::Station(station, state)),
        1 => (0usize..3).prop_map(Act::Restart),
        1 => (0usize..3, any::<bool>()).prop_map(|(station, is_manual)| Act::Selector(station, is_manual)),
        1 => Just(Act::Silence),
    ]
}

proptest! {
    #[test]
    fn nothing_is_enabled_while_a_node_is_not_active_nor_by_its_activation(acts in prop::collection::vec(act(), 1..60)) {
        let mut bench = CoordinatorBench::new();
        let mut own = LifecycleState::Active;
        for act in acts {
            let before = bench.coordinator.order();
            match act {
                Act::Command(command) => {
                    bench.command(command);
                }
                Act::Own(state) => {
                    own = state;
                    bench.input(ModeInput::Lifecycle(state));
                }
                Act::Station(station, state) => {
                    // A life begins with the end of activity.
                    bench.heard[station].boot_id += u64::from(state.is_some());
                    bench.heard[station].inactive = state;
                    bench.say(station);
                }
                Act::Restart(station) => {
                    bench.heard[station].boot_id += 1;
                    bench.say(station);
                }
                Act::Selector(station, is_manual) => bench.heard[station].selector_manual = is_manual,
                Act::Silence => {
                    let stale = bench.line.timing.stale;
                    bench.wait(stale * 3);
                }
            }
            bench.beat();
            bench.coordinator.step(bench.now, &mut ModeOutbox::default());
            let order = bench.coordinator.order();
            let enables = order.mode.enables_motion() && order.enabled;
            prop_assert!(own == LifecycleState::Active || !enables, "{:?} by {:?}", order, act);
            // In manual a person holds each motion: one that is not received ends it for itself alone.
            let all_active = bench.heard.iter().all(|heard| heard.inactive.is_none());
            prop_assert!(all_active || !enables || order.mode == ControlMode::Manual, "{:?} by {:?}", order, act);
            let enabled_before = before.mode.enables_motion() && before.enabled;
            let is_activation = matches!(act, Act::Own(LifecycleState::Active) | Act::Station(_, None));
            let by_selector = bench.heard.iter().any(|heard| heard.selector_manual);
            prop_assert!(!is_activation || by_selector || enabled_before || !enables, "{:?} by {:?}", order, act);
        }
    }
}
