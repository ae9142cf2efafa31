//! Watchdog: ends a node whose loop stands still.
//!
//! The middleware is called from the loop, and a call into it may not come back: three of its locks and queues can wait
//! for each other while many nodes start at once (see `TAKE_IN` in `participant.rs`). Such a process is alive for its
//! supervisor, and of no use. Its outputs are off by then, or go off: the devices watch the heartbeat that the loop
//! sends, stations the age of the mode order; for devices without a heartbeat [`Watchdog::before_the_end`] lets go. So
//! nothing is lost by ending it, and it can be started again.
//!
//! Time is counted in pieces without a feed, each slept by itself: of a process that was stopped for an hour and goes
//! on, one piece is over.

use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread;
use std::time::Duration;

use sd_notify::NotifyState;

/// Exit code of a process whose loop stands still: an internal error, as `sysexits.h` numbers it.
const STANDS_STILL: i32 = 70;
/// Number of pieces of the limit that have to pass without a feed.
const PIECES: u32 = 10;

type LastFeed = Mutex<Vec<Box<dyn FnOnce() + Send>>>;

/// Ends the process when it is not fed. Dropping it ends the watch, and not the process.
pub struct Watchdog {
    fed: Arc<AtomicBool>,
    last: Arc<LastFeed>,
}

impl Watchdog {
    /// Most time for which the loop of a node may stand still. Much longer than a slow disk or a busy machine holds it
    /// up.
    pub const LIMIT: Duration = Duration::from_secs(10);
    /// Period at which an idle loop should feed it.
    pub const FEED: Duration = Duration::from_secs(1);

    /// Watches from now on; `name` is its name in the log. Where the operating system gives no thread for that, it is
    /// logged, and no process is ended.
    pub fn start(name: &str, limit: Duration) -> Self {
        Watchdog::watch(name, limit, false)
    }

    /// The same of the loop of a node, which a service manager is informed of: ready when it is fed for the first time, and then that it
    /// is alive in each tenth of the limit in which it was fed. Nothing is sent where none asks for it (`NOTIFY_SOCKET`, sd_notify(3)).
    pub fn start_of_node(name: &str, limit: Duration) -> Self {
        Watchdog::watch(name, limit, true)
    }

    fn watch(name: &str, limit: Duration, is_of_node: bool) -> Self {
        let fed = Arc::new(AtomicBool::new(true));
        let last: Arc<LastFeed> = Arc::default();
        let (seen, at_the_end, name) = (Arc::downgrade(&fed), last.clone(), name.to_owned());
        let spawned = thread::Builder::new().name("watchdog".to_owned()).spawn(move || {
            let manager = if is_of_node { informs_manager() } else { None };
            let fed = || {
                if let Some(manager) = &manager {
                    // One that waits still stands for this one too.
                    let _ = manager.try_send(());
                }
            };
            if stands_still(&seen, limit / PIECES, fed) {
                // First of all: a log without a reader may hold this thread up.
                let acts = std::mem::take(&mut *at_the_end.lock().unwrap_or_else(PoisonError::into_inner));
                acts.into_iter().for_each(|act| act());
                tracing::error!("{name} has stood still for {} s; it ends", limit.as_secs_f64());
                crate::flush_stderr();
                exit(STANDS_STILL);
            }
        });
        if let Err(error) = spawned {
            tracing::error!("watchdog of the node's loop not started: {error}");
        }
        Watchdog { fed, last }
    }

    /// Adds an action of its thread before it ends the process. It must wait for nothing that the loop may hold.
    pub fn before_the_end(&self, act: impl FnOnce() + Send + 'static) {
        self.last.lock().unwrap_or_else(PoisonError::into_inner).push(Box::new(act));
    }

    /// Feeds it: the loop goes round.
    pub fn feed(&self) {
        self.fed.store(true, Ordering::Relaxed);
    }
}

/// Informs the service manager of each message that the node is alive, and of the first one that it is ready; in a thread of its own, since a
/// manager that does not read holds up what is sent to it. None where the operating system gives no thread.
fn informs_manager() -> Option<SyncSender<()>> {
    let (to, from) = sync_channel(1);
    let inform = move || {
        let states = [NotifyState::Watchdog, NotifyState::Ready];
        let mut number = states.len();
        for () in from {
            match sd_notify::notify(&states[..number]) {
                Ok(()) => number = 1,
                Err(error) => tracing::debug!("the service manager was not informed: {error}"),
            }
        }
    };
    thread::Builder::new().name("service manager".to_owned()).spawn(inform).is_ok().then_some(to)
}

/// Waits until it was not fed for [`PIECES`] in a row, or no feeder is left; true in the first case. Calls `alive` after each piece in which
/// it was fed, but for the first one: there it counts as fed from the start.
fn stands_still(fed: &Weak<AtomicBool>, piece: Duration, mut alive: impl FnMut()) -> bool {
    let (mut missed, mut is_first) = (0, true);
    while missed < PIECES {
        thread::sleep(piece);
        let Some(fed) = fed.upgrade() else { return false };
        missed = if fed.swap(false, Ordering::Relaxed) { 0 } else { missed + 1 };
        if missed == 0 && !is_first {
            alive();
        }
        is_first = false;
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
    const LETS_GO: &str = "it lets go of its outputs";

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
    fn who_stands_still_is_ended_and_lets_go_before_that() {
        if std::env::var_os(CHILD).is_some() {
            let watchdog = Watchdog::start("a child", LIMIT);
            watchdog.before_the_end(|| println!("{LETS_GO}"));
            thread::sleep(Duration::from_secs(60));
            exit(0);
        }
        let this = std::env::current_exe().expect("this program");
        let name = "watchdog::tests::who_stands_still_is_ended_and_lets_go_before_that";
        let output =
            Command::new(this).args(["--exact", "--nocapture", name]).env(CHILD, "1").output().expect("it starts");
        assert_eq!(output.status.code(), Some(STANDS_STILL));
        assert!(String::from_utf8_lossy(&output.stdout).contains(LETS_GO), "{output:?}");
    }
}
