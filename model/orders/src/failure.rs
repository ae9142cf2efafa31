//! Failures of an order, and their codes.

/// Failure of an order. Each has a code (seed 001, L131-185: the error code of an abnormal end).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskFailure {
    /// Its time was over while an operation waited for its inputs, and the description gives this code for that.
    Waiting(u16),
    /// Its time was over.
    TimedOut,
    /// An operation was stopped by a fault.
    Fault,
    /// The mode was changed to one without automatic motion of the station.
    Interrupted,
    /// The station's controller was restarted.
    Restarted,
    /// It was ordered to leave it, and had not begun it, or is back where the task began.
    Cancelled,
    /// It was ordered to leave it, and stands between two rests: it was to hold, or could not go back further by itself.
    Held,
    /// It was ordered to stop, and stands where it was then.
    Stopped,
    /// A code that this version does not have.
    Other(u16),
}

impl TaskFailure {
    /// Its code: up to 999 those of the description, from 1000 these.
    pub const fn code(self) -> u16 {
        match self {
            TaskFailure::Waiting(code) | TaskFailure::Other(code) => code,
            TaskFailure::TimedOut => 1000,
            TaskFailure::Fault => 1001,
            TaskFailure::Interrupted => 1002,
            TaskFailure::Restarted => 1003,
            TaskFailure::Cancelled => 1004,
            TaskFailure::Held => 1005,
            TaskFailure::Stopped => 1006,
        }
    }

    /// The failure with this code.
    pub const fn from_code(code: u16) -> Self {
        match code {
            1..=linewright_line::CODE_MAX => TaskFailure::Waiting(code),
            1000 => TaskFailure::TimedOut,
            1001 => TaskFailure::Fault,
            1002 => TaskFailure::Interrupted,
            1003 => TaskFailure::Restarted,
            1004 => TaskFailure::Cancelled,
            1005 => TaskFailure::Held,
            1006 => TaskFailure::Stopped,
            _ => TaskFailure::Other(code),
        }
    }

    /// In words, for the operator.
    pub fn text(self) -> String {
        match self {
            TaskFailure::Waiting(code) => format!("awaited input not on in time (code {code})"),
            TaskFailure::TimedOut => "time limit exceeded".to_owned(),
            TaskFailure::Fault => "station fault".to_owned(),
            TaskFailure::Interrupted => "interrupted by an emergency stop or a change of mode".to_owned(),
            TaskFailure::Restarted => "station controller restarted during the task".to_owned(),
            TaskFailure::Cancelled => "left on request".to_owned(),
            TaskFailure::Held => "left on request, stands between two rests".to_owned(),
            TaskFailure::Stopped => "stopped on request between two rests; lead it to a rest in manual".to_owned(),
            TaskFailure::Other(code) => format!("code {code}"),
        }
    }
}
