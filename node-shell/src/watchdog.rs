//! A node whose loop stands still ends.
//!
//! The middleware is called from the loop, and a call into it may not come back: three of its locks and queues can wait for
//! each other while many nodes start at once (see `TAKE_IN` in `participant.rs`). Such a process is alive for whoever
//! supervises it, and of no use. Its outputs are off by then, or go off: the devices watch the heartbeat that the loop
//! sends, stations the age of the coordinator's word. So nothing is lost by ending it, and it can be started again.
//!
//! Time is counted in pieces in which the loop has said nothing, each slept by itself: of a process that was stopped for an
//! hour and goes on, one piece is over.

use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::Duration;

/// What a process ends with whose loop stands still: an internal error, as `sysexits.h` numbers it.
const STANDS_STILL: i32 = 70;
/// How many pieces of the limit have to pass without a word.
const PIECES: u32 = 10;

/// Ends the process when it is not fed. Dropping it ends the watch, and not the process.
#[derive(Debug)]
pub struct Watchdog {
    fed: Arc<AtomicBool>,
}

impl Watchdog {
    /// How long the loop of a node may stand still. Much longer than a slow disk or a busy machine holds it up.
    pub const LIMIT: Duration = Duration::from_secs(10);
    /// How often a loop that has nothing to do should feed it.
    pub const FEED: Duration = Duration::from_secs(1);

    /// Watches from now on; `name` is what the log calls it. Where the operating system gives no thread for that, the log
    /// says so, and nobody is ended.
    pub fn start(name: &str, limit: Duration) -> Self {
        let fed = Arc::new(AtomicBool::new(true));
        let (seen, name) = (Arc::downgrade(&fed), name.to_owned());
        let spawned = thread::Builder::new().name("watchdog".to_owned()).spawn(move || {
            if stands_still(&seen, limit / PIECES) {
                tracing::error!("{name} has stood still for {} s; it ends", limit.as_secs_f64());
                exit(STANDS_STILL);
            }
        });
        if let Err(error) = spawned {
            tracing::error!("nobody watches whether the node stands still: {error}");
        }
        Watchdog { fed }
    }

    /// Says that the loop goes round.
    pub fn feed(&self) {
        self.fed.store(true, Ordering::Relaxed);
    }
}

/// Waits until it was not fed for so many pieces in a row, or nobody is left who could feed it; true in the first case.
fn stands_still(fed: &Weak<AtomicBool>, piece: Duration) -> bool {
    let mut missed = 0;
    while missed < PIECES {
        thread::sleep(piece);
        let Some(fed) = fed.upgrade() else { return false };
        missed = if fed.swap(false, Ordering::Relaxed) { 0 } else { missed + 1 };
    }
    true
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    /// Long for a thread that sleeps, and short for a test.
    const LIMIT: Duration = Duration::from_millis(200);
    const CHILD: &str = "LINEWRIGHT_WATCHDOG_TEST";

    #[test]
    fn who_is_fed_goes_on_and_who_lets_go_is_not_ended() {
        let watchdog = Watchdog::start("a test", LIMIT);
        for _ in 0..40 {
            thread::sleep(LIMIT / 20);
            watchdog.feed();
        }
        drop(watchdog);
        // Were it watched still, this process would end here.
        thread::sleep(LIMIT * 2);
    }

    /// Plays itself as a child: what ends is a process.
    #[test]
    fn who_stands_still_is_ended() {
        if std::env::var_os(CHILD).is_some() {
            let _watchdog = Watchdog::start("a child", LIMIT);
            thread::sleep(Duration::from_secs(60));
            exit(0);
        }
        let this = std::env::current_exe().expect("this program");
        let name = "watchdog::tests::who_stands_still_is_ended";
        let status = Command::new(this).args(["--exact", name]).env(CHILD, "1").status().expect("it starts");
        assert_eq!(status.code(), Some(STANDS_STILL));
    }
}
