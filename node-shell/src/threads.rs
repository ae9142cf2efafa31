//! Whether the middleware still works, by its threads.
//!
//! They can end without a report. The known case: a process that is stopped for a moment, by Ctrl-Z or by a debugger,
//! and goes on. The wait of the middleware's event loop is interrupted then, and the loop takes that for its end.
//! Nothing fails from there on: messages to be sent are taken and never leave, and none arrive. The others see the node
//! as silent and stop; the node itself would stay so for ever. So it checks whether those threads are there, and ends
//! when one is not: its supervisor starts it again.
//!
//! A participant does not receive its own messages over loopback, so a node that sends to itself would not detect it.
//! The threads are found where Linux shows them, by the name that the middleware gives them; on other systems nothing
//! is concluded.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::subscription::Forward;

/// Beginning of the name of every thread that moves messages.
const NAME: &str = "RustDDS";
/// Directory of the threads of this process in Linux.
const THREADS: &str = "/proc/self/task";
/// A participant has one for its messages and one that finds the others.
const OF_A_PARTICIPANT: usize = 2;
/// Period of the checks, and delay of the first: a thread names itself.
const EVERY: Duration = Duration::from_millis(500);

/// A task that is finished when a thread of the middleware has ended, within half a second; it is logged. For a process
/// with at least one participant, all of which stay open as long as the task is used. Must be called inside a tokio
/// runtime.
pub fn watch_middleware() -> Forward {
    Forward::spawn(async {
        tokio::time::sleep(EVERY).await;
        let Some(begun) = threads(Path::new(THREADS)) else {
            // This system does not show them.
            return std::future::pending().await;
        };
        while has_all(&begun, threads(Path::new(THREADS)).as_ref()) {
            tokio::time::sleep(EVERY).await;
        }
        tracing::error!(
            "middleware thread ended (after the process was stopped, by Ctrl-Z or a debugger): no messages in or out; \
             the node ends, restart it"
        );
    })
}

/// Whether every thread required is there now. A failed read is not taken for an end.
fn has_all(begun: &BTreeSet<String>, now: Option<&BTreeSet<String>>) -> bool {
    begun.len() >= OF_A_PARTICIPANT && now.is_none_or(|now| begun.is_subset(now))
}

/// The middleware's threads, by number.
fn threads(directory: &Path) -> Option<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(directory).ok()?.flatten() {
        // One that ends meanwhile has no name any more.
        let name = fs::read_to_string(entry.path().join("comm")).unwrap_or_default();
        if name.starts_with(NAME) {
            found.insert(entry.file_name().to_string_lossy().into_owned());
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(threads: &[(&str, &str)]) -> tempfile::TempDir {
        let directory = tempfile::tempdir().expect("a directory");
        for (number, name) in threads {
            fs::create_dir(directory.path().join(number)).expect("a directory");
            fs::write(directory.path().join(number).join("comm"), format!("{name}\n")).expect("a file");
        }
        directory
    }

    #[test]
    fn one_that_has_ended_is_missed_and_others_are_not() {
        let all = [("7", "linewright"), ("8", "RustDDS Partici"), ("9", "RustDDS discove"), ("10", "cell")];
        let begun = threads(shown(&all).path()).expect("shown");
        assert_eq!(begun, ["8", "9"].map(str::to_owned).into());
        let now = |left: &[(&str, &str)]| threads(shown(left).path());
        assert!(has_all(&begun, now(&all).as_ref()));
        assert!(has_all(&begun, now(&all[..3]).as_ref()), "another's thread may end");
        assert!(!has_all(&begun, now(&all[..2]).as_ref()));
        assert!(
            !has_all(&begun, now(&[("9", "RustDDS discove"), ("11", "RustDDS Partici")]).as_ref()),
            "not the same one"
        );
        assert!(has_all(&begun, None), "not shown just now");
        assert!(!has_all(&now(&all[..2]).expect("shown"), now(&all[..2]).as_ref()), "one was gone from the beginning");
    }

    #[test]
    fn a_system_that_shows_none_is_told_from_one_that_has_none() {
        assert_eq!(threads(Path::new("/nowhere/at/all")), None);
        assert_eq!(threads(shown(&[]).path()), Some(BTreeSet::new()));
    }
}
