//! The states, with their numbers and labels in ROS 2.

/// State of a managed node. The first five are called primary, in the others the work of a transition is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LifecycleState {
    /// No node is ever in it; it is in the published list of states.
    Unknown,
    /// Started, and nothing of its own is made yet.
    #[default]
    Unconfigured,
    /// It has what it needs, and does nothing.
    Inactive,
    /// It works.
    Active,
    /// Its work is over; it answers as long as its process lives.
    Finalized,
    /// Between unconfigured and inactive.
    Configuring,
    /// Between inactive and unconfigured.
    CleaningUp,
    /// On the way to finalized.
    ShuttingDown,
    /// Between inactive and active.
    Activating,
    /// Between active and inactive.
    Deactivating,
    /// The work of a transition had an error.
    ErrorProcessing,
}

impl LifecycleState {
    /// All states, in the order of their numbers.
    pub const ALL: [LifecycleState; 11] = [
        LifecycleState::Unknown,
        LifecycleState::Unconfigured,
        LifecycleState::Inactive,
        LifecycleState::Active,
        LifecycleState::Finalized,
        LifecycleState::Configuring,
        LifecycleState::CleaningUp,
        LifecycleState::ShuttingDown,
        LifecycleState::Activating,
        LifecycleState::Deactivating,
        LifecycleState::ErrorProcessing,
    ];

    /// Its number in `lifecycle_msgs/State`.
    pub const fn code(self) -> u8 {
        match self {
            LifecycleState::Unknown => 0,
            LifecycleState::Unconfigured => 1,
            LifecycleState::Inactive => 2,
            LifecycleState::Active => 3,
            LifecycleState::Finalized => 4,
            LifecycleState::Configuring => 10,
            LifecycleState::CleaningUp => 11,
            LifecycleState::ShuttingDown => 12,
            LifecycleState::Activating => 13,
            LifecycleState::Deactivating => 14,
            LifecycleState::ErrorProcessing => 15,
        }
    }

    /// The state with this number, if it is one.
    pub fn of_code(code: u8) -> Option<Self> {
        LifecycleState::ALL.into_iter().find(|state| state.code() == code)
    }

    /// Its label, as ROS 2 shows it.
    pub const fn label(self) -> &'static str {
        match self {
            LifecycleState::Unknown => "unknown",
            LifecycleState::Unconfigured => "unconfigured",
            LifecycleState::Inactive => "inactive",
            LifecycleState::Active => "active",
            LifecycleState::Finalized => "finalized",
            LifecycleState::Configuring => "configuring",
            LifecycleState::CleaningUp => "cleaningup",
            LifecycleState::ShuttingDown => "shuttingdown",
            LifecycleState::Activating => "activating",
            LifecycleState::Deactivating => "deactivating",
            LifecycleState::ErrorProcessing => "errorprocessing",
        }
    }

    /// Whether a request is taken in it, or it is where a node comes to rest.
    pub const fn is_primary(self) -> bool {
        self.code() < 10
    }

    /// What leads on to activity, for operators: a plain statement that follows the state's name.
    pub const fn way_to_active(self) -> &'static str {
        match self {
            LifecycleState::Active | LifecycleState::Activating => "it works",
            LifecycleState::Inactive | LifecycleState::Configuring | LifecycleState::Deactivating => {
                "activate it (ros2 lifecycle set)"
            }
            LifecycleState::Unknown
            | LifecycleState::Unconfigured
            | LifecycleState::CleaningUp
            | LifecycleState::ErrorProcessing => "configure it, then activate it (ros2 lifecycle set)",
            LifecycleState::Finalized | LifecycleState::ShuttingDown => "start its process again",
        }
    }
}
