//! The states and transitions against those that ROS 2 publishes.

use std::collections::HashSet;

use linewright_lifecycle::{LIFECYCLE_TABLE, LifecycleState, steps_from};

/// Numbers of `lifecycle_msgs/State`, and the labels that `rcl_lifecycle` registers with them.
const STATES: &str = "0 unknown, 1 unconfigured, 2 inactive, 3 active, 4 finalized, 10 configuring, 11 cleaningup, 12 shuttingdown, \
                      13 activating, 14 deactivating, 15 errorprocessing";

/// Numbers of `lifecycle_msgs/Transition`, and the labels and states that `rcl_lifecycle` registers with them.
const TRANSITIONS: [&str; 25] = [
    "1 configure: unconfigured to configuring",
    "10 transition_success: configuring to inactive",
    "11 transition_failure: configuring to unconfigured",
    "12 transition_error: configuring to errorprocessing",
    "2 cleanup: inactive to cleaningup",
    "20 transition_success: cleaningup to unconfigured",
    "21 transition_failure: cleaningup to inactive",
    "22 transition_error: cleaningup to errorprocessing",
    "3 activate: inactive to activating",
    "30 transition_success: activating to active",
    "31 transition_failure: activating to inactive",
    "32 transition_error: activating to errorprocessing",
    "4 deactivate: active to deactivating",
    "40 transition_success: deactivating to inactive",
    "41 transition_failure: deactivating to active",
    "42 transition_error: deactivating to errorprocessing",
    "5 shutdown: unconfigured to shuttingdown",
    "6 shutdown: inactive to shuttingdown",
    "7 shutdown: active to shuttingdown",
    "50 transition_success: shuttingdown to finalized",
    "51 transition_failure: shuttingdown to finalized",
    "52 transition_error: shuttingdown to errorprocessing",
    "60 transition_success: errorprocessing to unconfigured",
    "61 transition_failure: errorprocessing to finalized",
    "62 transition_error: errorprocessing to finalized",
];

#[test]
fn states_are_the_published_ones() {
    let ours = LifecycleState::ALL.map(|state| format!("{} {}", state.code(), state.label()));
    assert_eq!(ours.join(", "), STATES);
    for code in 0..=u8::MAX {
        let known = LifecycleState::of_code(code);
        assert!(known.is_none_or(|state| state.code() == code));
        assert_eq!(known.is_some(), code <= 4 || (10..=15).contains(&code), "{code}");
    }
}

#[test]
fn transitions_are_the_published_ones() {
    let ours = LIFECYCLE_TABLE.map(|step| {
        let (from, to) = (step.from.label(), step.to.label());
        format!("{} {}: {from} to {to}", step.code, step.label)
    });
    assert_eq!(ours, TRANSITIONS);
}

#[test]
fn out_of_a_state_a_label_is_that_of_one_transition() {
    for state in LifecycleState::ALL {
        let labels: Vec<&str> = steps_from(state).map(|step| step.label).collect();
        assert_eq!(labels.iter().collect::<HashSet<_>>().len(), labels.len(), "{state:?}: {labels:?}");
    }
}

#[test]
fn a_state_that_is_not_active_has_a_way_to_activity() {
    assert!(LifecycleState::Inactive.way_to_active().contains("activate it"));
    assert!(LifecycleState::Unconfigured.way_to_active().contains("configure it, then activate it"));
    assert!(LifecycleState::Finalized.way_to_active().contains("process again"));
}
