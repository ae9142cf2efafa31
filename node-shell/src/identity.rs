//! Identity of this process, and the time.

use linewright_msgs::{Header, Time};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

/// A number that is new with every start of the process and never 0. Readers use it to distinguish a restarted writer
/// from a late message.
pub fn boot_id() -> u64 {
    static BOOT_ID: OnceLock<u64> = OnceLock::new();
    *BOOT_ID.get_or_init(fresh_boot_id)
}

/// A new boot id with every call, for several nodes in one process and for tests.
pub fn fresh_boot_id() -> u64 {
    loop {
        // The standard library seeds this hasher from the operating system's random numbers.
        let mut hasher = RandomState::new().build_hasher();
        hasher.write_u128(since_epoch().as_nanos());
        hasher.write_u32(std::process::id());
        match hasher.finish() {
            0 => continue,
            id => return id,
        }
    }
}

/// A number that is drawn for one thing and never again, as the key of a request that may be sent more than once.
pub fn fresh_key() -> u128 {
    u128::from(fresh_boot_id()) << 64 | u128::from(fresh_boot_id())
}

/// A header with the present time. The wire format's seconds end in 2038; later times stay there.
pub fn stamp() -> Header {
    let now = since_epoch();
    let sec = i32::try_from(now.as_secs()).unwrap_or(i32::MAX);
    Header { stamp: Time { sec, nanosec: now.subsec_nanos() }, frame_id: String::new() }
}

/// Time of the host in ns since 1970.
pub(crate) fn nanoseconds() -> u64 {
    u64::try_from(since_epoch().as_nanos()).unwrap_or(u64::MAX)
}

fn since_epoch() -> std::time::Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boot_ids_are_kept_and_fresh_ones_differ() {
        assert_eq!(boot_id(), boot_id());
        assert_ne!(boot_id(), 0);
        assert_ne!(fresh_boot_id(), fresh_boot_id());
        assert_ne!(fresh_key(), fresh_key());
        assert!(stamp().stamp.sec > 1_700_000_000);
    }
}
