//! Reasons why an input was ignored, for the log.

use crate::ignored::Ignored;

impl Ignored {
    /// The input ignored, and why.
    pub const fn text(self) -> &'static str {
        match self {
            Ignored::OlderEpoch => "mode command with an older epoch than the one in force",
            Ignored::NotAPeer => "report of a station that no operation here depends on",
            Ignored::Misfit => "report that does not fit the line description; use the same one on all hosts",
            Ignored::NoTasks => "task order for a station that is not task-driven",
            Ignored::OtherLife => {
                "mode command that does not name this start of the station: the coordinator does not receive it, or it runs twice"
            }
            Ignored::EpochTooHigh => "mode command or task order with an epoch too far above the last one",
            Ignored::LeaseTooLong => "mode command with a longer lease than the line description gives",
            Ignored::Moving => "rejoin: station moving",
            Ignored::NotLost => "rejoin: station position is known",
            Ignored::InSingleManual => {
                "rejoin: station in manual by itself, the others rely on its place; give auto to it, rejoin, then manual again"
            }
            Ignored::PositionUnclear => "rejoin: limit switches contradict the position, or do not determine it",
            Ignored::NumberMissing => "rejoin: the task has parameters, and not all of their numbers are given",
            Ignored::NoSuchNumber => {
                "rejoin: a number for a parameter that the task does not have, or outside of a task"
            }
            Ignored::NumberOutOfRange => "rejoin: a number that the outputs of its parameter cannot carry",
            Ignored::NumbersKnown => {
                "rejoin: the numbers of the task are known from its order; confirm the place without numbers"
            }
        }
    }
}
