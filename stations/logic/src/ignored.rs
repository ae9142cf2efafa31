//! Reasons why an input was ignored.

/// The result of [`crate::Controller::handle`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handled {
    /// The controller has taken it.
    Taken,
    /// Nothing has changed; a task has its refusal in [`crate::StationOutbox::replies`] all the same.
    Ignored(Ignored),
}

/// Reason why an input does not apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ignored {
    /// A mode command with a lower epoch than the one in force.
    OlderEpoch,
    /// A report of a station on which no operation of this one depends.
    NotAPeer,
    /// A report whose operations do not fit the description.
    Misfit,
    /// A task for a station that is not task-driven.
    NoTasks,
    /// A mode command or a task with an epoch too far above the last one.
    EpochTooHigh,
    /// A mode command with a longer lease than the description gives.
    LeaseTooLong,
    /// A mode command that was decided before this start of the station was received.
    OtherLife,
    /// A confirmation of the position while a motion is driven.
    Moving,
    /// A confirmation of the position of a station whose position is known.
    NotLost,
    /// A confirmation of the position of a station in manual by itself.
    InSingleManual,
    /// A confirmation of a position that the switches contradict, or that does not follow from them.
    PositionUnclear,
    /// A confirmation within a task without the number of each of its parameters.
    NumberMissing,
    /// A confirmation with a number for a parameter that the task does not have, or where no task is.
    NoSuchNumber,
    /// A confirmation with a number that the outputs of its parameter cannot carry.
    NumberOutOfRange,
    /// A confirmation with numbers for a task whose parameters are known from its order.
    NumbersKnown,
}

impl Handled {
    /// Whether the controller has taken the input.
    pub const fn is_taken(self) -> bool {
        matches!(self, Handled::Taken)
    }
}

impl From<Result<(), Ignored>> for Handled {
    fn from(taken: Result<(), Ignored>) -> Self {
        match taken {
            Ok(()) => Handled::Taken,
            Err(why) => Handled::Ignored(why),
        }
    }
}
