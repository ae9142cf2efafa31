//! Events of a cell or a line that are no records of a log.
//!
//! Nothing of the cell's state follows from these, so none is kept over a crash: one that was not written when the power
//! went is missing.

use std::time::Duration;

use linewright_coordinator_cell::FiringId;
use linewright_line::Tick;
use serde::{Deserialize, Serialize};

/// Event beside the records.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Note {
    /// The mode has changed, or whether anything may start.
    Mode {
        name: String,
        /// Whether activities may start.
        starts: bool,
    },
    /// An emergency stop has come, or is over.
    EmergencyStop {
        /// True for on.
        on: bool,
    },
    /// A station is not received any more, or is received again.
    Station {
        /// Index of the station in the description.
        station: u16,
        /// True for lost.
        lost: bool,
    },
    /// A device of a station is lost, or is there again.
    Device {
        /// The station's number.
        station: u16,
        device: String,
        /// True for lost.
        lost: bool,
    },
    /// Planned start and end of an activity that has started.
    Planned {
        firing: FiringId,
        #[serde(with = "micros")]
        from: Tick,
        #[serde(with = "micros")]
        to: Tick,
    },
    /// A station's fault has come, with its cause and place as operators read it, or is over if the text is empty.
    Fault { station: u16, text: String },
    /// Records of the log that are not in the database, since the log had forgotten them when it was read.
    Missing {
        /// The first.
        from: u64,
        /// The last.
        to: u64,
    },
    /// Notes that are not in the database, since it could not be written.
    Gap {
        /// Time of the first of them.
        #[serde(with = "micros")]
        from: Tick,
        /// Time of the last.
        #[serde(with = "micros")]
        to: Tick,
        /// Number of lost notes.
        lost: u64,
    },
    /// Of a line, as all below: the observation begins here, or goes on after a gap. The whole situation follows.
    Began {},
    /// An operation was in motion.
    Motion {
        station: u16,
        /// Index of the operation in its station.
        operation: u16,
        /// The cycle in which it started.
        cycle: i32,
        #[serde(with = "micros")]
        from: Tick,
        #[serde(with = "micros")]
        to: Tick,
        end: MotionOutcome,
    },
    /// A station stood in auto and waited.
    Waited {
        station: u16,
        /// Reason of the wait.
        why: String,
        #[serde(with = "micros")]
        from: Tick,
        #[serde(with = "micros")]
        to: Tick,
    },
    /// The line has completed a cycle; without a time if its beginning or its end may have passed unheard.
    Cycle { number: i32, took_us: Option<u64> },
    /// There was no other note for a while, and the line is still observed.
    Observed {},
    /// Information for operators.
    Said {
        /// Text of the log line.
        text: String,
    },
}

impl Note {
    /// The note with its times moved on by `by`.
    pub(crate) fn later(mut self, by: Duration) -> Self {
        match &mut self {
            Note::Motion { from, to, .. }
            | Note::Waited { from, to, .. }
            | Note::Planned { from, to, .. }
            | Note::Gap { from, to, lost: _ } => {
                (*from, *to) = (*from + by, *to + by);
            }
            Note::Mode { .. }
            | Note::EmergencyStop { .. }
            | Note::Station { .. }
            | Note::Device { .. }
            | Note::Missing { .. }
            | Note::Began {}
            | Note::Fault { .. }
            | Note::Cycle { .. }
            | Note::Observed {}
            | Note::Said { .. } => {}
        }
        self
    }
}

/// Outcome of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionOutcome {
    Done,
    /// The motion back was completed.
    Undone,
    /// On its way: by a fault, a stop, or since the station was not received any more.
    Stopped,
    /// It is over, and neither its beginning nor its end was seen: no times.
    Unseen,
}

/// A time, in microseconds.
mod micros {
    use linewright_line::Tick;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(tick: &Tick, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u64(tick.as_micros())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Tick, D::Error> {
        u64::deserialize(from).map(Tick::from_micros)
    }
}
