//! The six qualities of service a line uses. Always named, never defaulted.
//!
//! The client library's default subscription is best effort with depth 1, which silently loses what
//! rclcpp's default would not. So every topic takes one of these, and writer and reader of a topic
//! take the same. None of them waits: a full send window is a counted error
//! ([`SendError::WindowFull`](crate::SendError)), not a stalled controller.
//!
//! | | reliability | durability | history | for |
//! |---|---|---|---|---|
//! | [`latched_state`] | reliable | transient local | keep last 1 | whole states |
//! | [`command`] | reliable | volatile | keep last 1 | operator commands |
//! | [`event`] | reliable | volatile | keep last 100 | what happened |
//! | [`log`] | reliable | transient local | keep last 100 | lines of the log, of which late readers see the last |
//! | [`service`] | reliable | volatile | keep last 10 | requests and answers, as rclcpp has them |
//! | [`repeated`] | best effort | volatile | keep last 1 | mode orders, and process images at the scan rate |
//!
//! A reliable writer keeps every sample for a reader that stopped answering, up to 8192 of them or until the reader's
//! lease (50 s) runs out; with the window full it cannot send at all. Measured with a killed reader: at 100 messages a
//! second the lease comes first, without effect, at 900 the writer is mute from the 9th to the 50th second. A reader
//! that lives and never acknowledges has no lease that runs out. That is why images, the one topic that may be sent at
//! scan rate, and mode orders, which carry the emergency stop, are best effort: no reader can keep them from another
//! one, and what gets lost is repeated a period later.

use ros2_client::QosProfile;
use ros2_client::qos::{Durability, History, WhenFull};

const fn reliable(durability: Durability, depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .durability(durability)
        .history(History::KeepLast { depth })
}

/// Whole states, kept for readers that come late.
pub const fn latched_state() -> QosProfile {
    reliable(Durability::TransientLocal, 1)
}

/// Commands. Never latched: a restart must not repeat "auto".
pub const fn command() -> QosProfile {
    reliable(Durability::Volatile, 1)
}

/// Events, with room for a burst.
pub const fn event() -> QosProfile {
    reliable(Durability::Volatile, 100)
}

/// Lines of the log: readers take them by this durability, or none.
pub const fn log() -> QosProfile {
    reliable(Durability::TransientLocal, 100)
}

/// Requests and their answers.
pub const fn service() -> QosProfile {
    reliable(Durability::Volatile, 10)
}

/// For data repeated every period, which must reach each reader whatever the others do.
pub const fn repeated() -> QosProfile {
    QosProfile::subscription_default().reliability_best_effort()
}
