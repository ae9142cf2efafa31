//! Texts about another manager on the bus.

use std::time::Duration;

use crate::manager::MANAGER_NODE;

/// Why no device is asked before it is certain that the bus is free.
pub(in crate::manager) const STILL_LISTENING: &str = "this manager still listens whether another one drives the bus";

/// That another manager has been there for this time.
pub(in crate::manager) fn other_manager(since: Duration) -> String {
    let since = since.as_millis();
    format!(
        "another CANopen manager (node {MANAGER_NODE}) has sent its heartbeat (77Fh) on this bus for {since} ms: \
         every output is let go and nothing moves; end one of the two"
    )
}

/// Why a device is not asked, behind `the device`.
pub(in crate::manager) fn not_asked(why: &str) -> String {
    format!("is not asked: {why}")
}
