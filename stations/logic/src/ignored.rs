//! Why an input was ignored.

/// The result of [`crate::Controller::handle`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handled {
    /// The controller has taken it.
    Taken,
    /// Nothing has changed; a task has its refusal in [`crate::StationOutbox::replies`] all the same.
    Ignored(Ignored),
}

/// Why an input does not apply.
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
    /// A confirmation of the position for a task-driven station, which needs none.
    NoRejoin,
    /// A confirmation of the position while a motion is driven.
    Moving,
    /// A confirmation of the position of a station whose position is known.
    NotLost,
    /// A confirmation of a position that the switches contradict, or that does not follow from them.
    PositionUnclear,
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

impl Ignored {
    /// For the log.
    pub const fn text(self) -> &'static str {
        match self {
            Ignored::OlderEpoch => "a mode command with an older epoch than the one in force",
            Ignored::NotAPeer => "a report of a station on which no operation here depends",
            Ignored::Misfit => "a report that does not fit the line description: is it the same on all hosts?",
            Ignored::NoTasks => "a task for a station that is not task-driven",
            Ignored::EpochTooHigh => "a mode command or a task with an epoch too far above the last one",
            Ignored::LeaseTooLong => "a mode command with a longer lease than the line description gives",
            Ignored::NoRejoin => "rejoin: a task-driven station needs none",
            Ignored::Moving => "rejoin: the station is moving",
            Ignored::NotLost => "rejoin: the position of the station is known",
            Ignored::PositionUnclear => "rejoin: the switches contradict the position, or do not determine it",
        }
    }
}
