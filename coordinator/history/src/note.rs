//! What happens to a cell and is no record of its log.
//!
//! Nothing of the cell's state follows from these, so nobody has to remember them over a crash: one that was not written
//! when the power went is missing.

use linewright_coordinator_cell::FiringId;
use linewright_line::Tick;
use serde::{Deserialize, Serialize};

/// What has happened beside the records.
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
        /// Which of the two.
        on: bool,
    },
    /// A station is not heard any more, or is heard again.
    Station {
        /// Index of the station in the description.
        station: u16,
        /// Which of the two.
        lost: bool,
    },
    /// A device of a station is lost, or is there again.
    Device {
        /// The station's number.
        station: u16,
        device: String,
        /// Which of the two.
        lost: bool,
    },
    /// When an activity that has started was planned to start and to end.
    Planned {
        firing: FiringId,
        #[serde(with = "micros")]
        from: Tick,
        #[serde(with = "micros")]
        to: Tick,
    },
    /// Records of the log that are not in the database, since the log had forgotten them when it was read.
    Missing {
        /// The first.
        from: u64,
        /// The last.
        to: u64,
    },
    /// Anything that people should know.
    Said {
        /// Text of the log line.
        text: String,
    },
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
