//! No sequence of requests and outcomes leads out of the table, or to activity by another way than configure and activate.

use linewright_lifecycle::{
    LIFECYCLE_TABLE, LifecycleOutcome, LifecycleRequest, LifecycleState, LifecycleStep, NodeLifecycle, steps_from,
};
use proptest::prelude::*;

/// One thing that happens to a node.
#[derive(Clone, Debug)]
enum Act {
    Label(String),
    Code(u8),
    End(LifecycleOutcome),
}

fn act() -> impl Strategy<Value = Act> {
    let labels: Vec<&str> = LIFECYCLE_TABLE.iter().map(|step| step.label).collect();
    let outcomes = [LifecycleOutcome::Success, LifecycleOutcome::Failure, LifecycleOutcome::Error];
    prop_oneof![
        4 => prop::sample::select(labels).prop_map(|label| Act::Label(label.to_owned())),
        1 => ".{0,12}".prop_map(Act::Label),
        2 => any::<u8>().prop_map(Act::Code),
        3 => (0u8..8).prop_map(Act::Code),
        8 => prop::sample::select(outcomes.to_vec()).prop_map(Act::End),
    ]
}

fn play(node: &mut NodeLifecycle, act: &Act) -> Option<&'static LifecycleStep> {
    match act {
        Act::Label(label) => node.begin(LifecycleRequest::Label(label)),
        Act::Code(code) => node.begin(LifecycleRequest::Code(*code)),
        Act::End(outcome) => node.conclude(*outcome),
    }
}

proptest! {
    #[test]
    fn every_step_is_of_the_table_and_nothing_else_changes_the_state(acts in prop::collection::vec(act(), 0..200)) {
        let mut node = NodeLifecycle::default();
        // Since the node was unconfigured last: the steps that have been taken.
        let mut since: Vec<u8> = Vec::new();
        for act in &acts {
            let before = node.state();
            match play(&mut node, act) {
                None => {
                    prop_assert_eq!(node.state(), before);
                    let is_asked = |step: &LifecycleStep| match act {
                        Act::Label(label) => before.is_primary() && step.label == label,
                        Act::Code(code) => before.is_primary() && step.code == *code,
                        Act::End(_) => !before.is_primary(),
                    };
                    prop_assert!(!steps_from(before).any(is_asked), "{:?} is not taken in {:?}", act, before);
                }
                Some(step) => {
                    prop_assert!(LIFECYCLE_TABLE.contains(step));
                    prop_assert_eq!((step.from, step.to), (before, node.state()));
                    // A request leads out of a primary state, an outcome out of one between.
                    prop_assert_eq!(matches!(act, Act::End(_)), !before.is_primary());
                    let is_error = matches!(act, Act::End(LifecycleOutcome::Error));
                    let is_processing = step.to == LifecycleState::ErrorProcessing;
                    prop_assert_eq!(is_processing, is_error && before != LifecycleState::ErrorProcessing);
                    since.push(step.code);
                    if step.to == LifecycleState::Unconfigured {
                        since.clear();
                    }
                    if step.to == LifecycleState::Active {
                        let has = |code| since.contains(&code);
                        prop_assert!(has(1) && has(10) && has(3) && has(30), "active by {:?}", since);
                    }
                    prop_assert!(before != LifecycleState::Finalized, "finalized is left by {:?}", step);
                    prop_assert!(node.state() != LifecycleState::Unknown);
                }
            }
        }
    }
}

#[test]
fn an_outcome_without_a_transition_and_a_request_within_one_change_nothing() {
    let mut node = NodeLifecycle::default();
    assert_eq!(node.conclude(LifecycleOutcome::Success), None);
    node.begin(LifecycleRequest::Code(1)).expect("configure");
    for code in 0..=u8::MAX {
        assert_eq!(node.begin(LifecycleRequest::Code(code)), None, "{code}");
    }
    for step in LIFECYCLE_TABLE {
        assert_eq!(node.begin(LifecycleRequest::Label(step.label)), None, "{}", step.label);
    }
    assert_eq!(node.state(), LifecycleState::Configuring);
}

#[test]
fn a_label_comes_before_a_number() {
    let mut node = NodeLifecycle::default();
    assert_eq!(node.begin(LifecycleRequest::of(1, "cleanup")), None, "as rclcpp has it");
    assert_eq!(node.begin(LifecycleRequest::of(4, "configure")).map(|step| step.code), Some(1));
}

#[test]
fn an_error_is_processed_and_the_node_is_unconfigured_or_finalized() {
    let ends = [
        (LifecycleOutcome::Success, LifecycleState::Unconfigured),
        (LifecycleOutcome::Failure, LifecycleState::Finalized),
        (LifecycleOutcome::Error, LifecycleState::Finalized),
    ];
    for (outcome, end) in ends {
        let mut node = NodeLifecycle::default();
        node.begin(LifecycleRequest::Label("configure")).expect("a transition");
        let error = node.conclude(LifecycleOutcome::Error).expect("an end");
        assert_eq!(error.to, LifecycleState::ErrorProcessing);
        assert_eq!(node.conclude(outcome).map(|step| step.to), Some(end));
    }
}
