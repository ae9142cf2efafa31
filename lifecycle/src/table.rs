//! The transitions, with their numbers and labels in ROS 2.

use crate::state::LifecycleState as S;

/// A transition: what begins it is a request where it leads out of a primary state, and else the outcome of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LifecycleStep {
    /// Its number in `lifecycle_msgs/Transition`.
    pub code: u8,
    /// Its label, as ROS 2 shows it. Those of outcomes, and of shutdown, are the same out of several states.
    pub label: &'static str,
    pub from: S,
    pub to: S,
}

const fn step(code: u8, label: &'static str, from: S, to: S) -> LifecycleStep {
    LifecycleStep { code, label, from, to }
}

/// Labels of the outcomes.
pub(crate) const SUCCESS: &str = "transition_success";
pub(crate) const FAILURE: &str = "transition_failure";
pub(crate) const ERROR: &str = "transition_error";

/// All transitions, as ROS 2 publishes them.
pub const LIFECYCLE_TABLE: [LifecycleStep; 25] = [
    step(1, "configure", S::Unconfigured, S::Configuring),
    step(10, SUCCESS, S::Configuring, S::Inactive),
    step(11, FAILURE, S::Configuring, S::Unconfigured),
    step(12, ERROR, S::Configuring, S::ErrorProcessing),
    step(2, "cleanup", S::Inactive, S::CleaningUp),
    step(20, SUCCESS, S::CleaningUp, S::Unconfigured),
    step(21, FAILURE, S::CleaningUp, S::Inactive),
    step(22, ERROR, S::CleaningUp, S::ErrorProcessing),
    step(3, "activate", S::Inactive, S::Activating),
    step(30, SUCCESS, S::Activating, S::Active),
    step(31, FAILURE, S::Activating, S::Inactive),
    step(32, ERROR, S::Activating, S::ErrorProcessing),
    step(4, "deactivate", S::Active, S::Deactivating),
    step(40, SUCCESS, S::Deactivating, S::Inactive),
    step(41, FAILURE, S::Deactivating, S::Active),
    step(42, ERROR, S::Deactivating, S::ErrorProcessing),
    step(5, "shutdown", S::Unconfigured, S::ShuttingDown),
    step(6, "shutdown", S::Inactive, S::ShuttingDown),
    step(7, "shutdown", S::Active, S::ShuttingDown),
    step(50, SUCCESS, S::ShuttingDown, S::Finalized),
    step(51, FAILURE, S::ShuttingDown, S::Finalized),
    step(52, ERROR, S::ShuttingDown, S::ErrorProcessing),
    step(60, SUCCESS, S::ErrorProcessing, S::Unconfigured),
    step(61, FAILURE, S::ErrorProcessing, S::Finalized),
    step(62, ERROR, S::ErrorProcessing, S::Finalized),
];

/// The transitions that lead out of a state.
pub fn steps_from(state: S) -> impl Iterator<Item = &'static LifecycleStep> {
    LIFECYCLE_TABLE.iter().filter(move |step| step.from == state)
}
