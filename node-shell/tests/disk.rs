//! Logs on a disk that fails at any of its operations, and fills up.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use linewright_node_shell::log::{Disk, DiskFaults, DiskOperation, LogEntry, LogError, RecordLog};

/// Fails from one operation on, for so many.
#[derive(Debug)]
struct FailsAt {
    first: usize,
    count: usize,
    done: AtomicUsize,
}

impl FailsAt {
    fn disk(first: usize, count: usize) -> (Disk, Arc<Self>) {
        let faults = Arc::new(FailsAt { first, count, done: AtomicUsize::new(0) });
        (Disk::with_faults(faults.clone()), faults)
    }
}

impl DiskFaults for FailsAt {
    fn before(&self, _: DiskOperation, _: &File) -> io::Result<()> {
        let nth = self.done.fetch_add(1, Ordering::Relaxed);
        let fails = nth >= self.first && nth - self.first < self.count;
        if fails { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }
}

/// Snapshot and records as numbers: a snapshot is the number of the last record that it replaces.
fn numbers(path: &Path) -> Vec<u64> {
    let (mut all, number) = (Vec::new(), |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("a number")));
    let read = |entry: LogEntry<'_>| {
        match entry {
            LogEntry::Identity(_) => {}
            LogEntry::Snapshot(bytes) => all = (1..=number(bytes)).collect(),
            LogEntry::Record(bytes) => all.push(number(bytes)),
        }
        Ok(())
    };
    drop(RecordLog::open(path, b"numbers", read).expect("it opens"));
    all
}

/// Each number is a record. One that is on the disk is acknowledged; one that could not be written is tried again, or replaced by a
/// snapshot where the content of the file is unknown. Every seventh is followed by a snapshot.
fn scenario(disk: Disk, path: &Path) -> u64 {
    let Ok((mut log, _)) = RecordLog::open_on(disk, path, b"numbers", |_| Ok(())) else { return 0 };
    let _ = log.make_room(2_000);
    let mut acknowledged = 0;
    for number in 1..=20_u64 {
        let bytes = number.to_le_bytes();
        let is_kept = (0..3).any(|_| {
            let is_unknown = log.has_failed();
            let kept =
                if is_unknown { log.begin_anew(&bytes) } else { log.append([&bytes[..]]).and_then(|()| log.sync()) };
            kept.is_ok()
        });
        if !is_kept {
            return acknowledged;
        }
        acknowledged = number;
        if number % 7 == 0 {
            // Where it fails the log goes on as it is, or the next record mends it.
            let _ = log.begin_anew(&bytes);
        }
    }
    acknowledged
}

#[test]
fn whichever_operation_of_a_disk_fails_nothing_acknowledged_is_lost_and_nothing_else_is_believed() {
    let (disk, counted) = FailsAt::disk(usize::MAX, 0);
    let dir = tempfile::tempdir().expect("a directory");
    assert_eq!(scenario(disk, &dir.path().join("log")), 20);
    let operations = counted.done.load(Ordering::Relaxed);
    assert!(operations > 50, "{operations}");
    for (count, survives) in [(1, true), (2, true), (usize::MAX, false)] {
        for first in 0..operations {
            let dir = tempfile::tempdir().expect("a directory");
            let path = dir.path().join("log");
            let (disk, _) = FailsAt::disk(first, count);
            let acknowledged = scenario(disk, &path);
            let found = numbers(&path);
            let complete: Vec<u64> = (1..=found.len() as u64).collect();
            assert_eq!(found, complete, "{first} {count}");
            // What was written and not acknowledged may be there, of one step.
            let more = found.len() as u64 - acknowledged.min(found.len() as u64);
            assert!(found.len() as u64 >= acknowledged && more <= 1, "{first} {count}: {acknowledged} {}", found.len());
            let began = acknowledged > 0;
            assert!(!survives || !began || acknowledged == 20, "{first} {count}: it goes on after {acknowledged}");
        }
    }
}

#[test]
fn room_is_used_before_the_disk_is_asked_for_more_and_a_restart_keeps_it() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("log");
    let (mut log, _) = RecordLog::open(&path, b"numbers", |_| Ok(())).expect("it opens");
    log.make_room(10_000).expect("there is room");
    let (room, length) = (log.room(), std::fs::metadata(log.name()).expect("it is there").len());
    assert!(room >= 10_000);
    for number in 1..=100_u64 {
        log.append([&number.to_le_bytes()[..]]).expect("it is written");
    }
    assert_eq!(std::fs::metadata(log.name()).expect("it is there").len(), length);
    assert_eq!(log.room(), room - 100 * (32 + 8));
    drop(log);
    let (log, cut) = RecordLog::open(&path, b"numbers", |_| Ok(())).expect("it opens");
    assert_eq!((cut, log.room()), (0, room - 100 * (32 + 8)));
    drop(log);
    assert_eq!(numbers(&path).len(), 100);
}

/// A log with room, after these steps, on a disk whose next operation fails.
fn on_a_disk_that_fails_next(path: &Path, steps: impl Fn(&mut RecordLog)) -> RecordLog {
    let begun = |first: usize, count: usize| {
        let (disk, counted) = FailsAt::disk(first, count);
        let (mut log, _) = RecordLog::open_on(disk, path, b"numbers", |_| Ok(())).expect("it opens");
        log.make_room(1_000).expect("there is room");
        steps(&mut log);
        (log, counted.done.load(Ordering::Relaxed))
    };
    let (log, operations) = begun(usize::MAX, 0);
    drop(log);
    std::fs::remove_dir_all(path.parent().expect("a directory")).expect("it is removed");
    begun(operations, 1).0
}

#[test]
fn a_write_that_fails_once_leaves_the_room_for_the_next() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("log");
    let mut log = on_a_disk_that_fails_next(&path, |_| {});
    let (room, length) = (log.room(), std::fs::metadata(log.name()).expect("it is there").len());
    // Half of it is in the file then.
    assert!(matches!(log.append([&[255; 100][..]]), Err(LogError::File { .. })));
    assert!(!log.has_failed());
    assert_eq!((log.room(), std::fs::metadata(log.name()).expect("it is there").len()), (room, length));
    log.append([&1_u64.to_le_bytes()[..]]).and_then(|()| log.sync()).expect("it goes on");
    drop(log);
    assert_eq!(numbers(&path), [1]);
}

#[test]
fn a_snapshot_that_cannot_be_written_leaves_the_log_as_it_is_with_its_room() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("log");
    let mut log = on_a_disk_that_fails_next(&path, |log| {
        log.append([&1_u64.to_le_bytes()[..]]).expect("it is written");
    });
    let room = log.room();
    assert!(matches!(log.begin_anew(&1_u64.to_le_bytes()), Err(LogError::File { .. })));
    assert!(!log.has_failed() && log.room() == room && !path.with_extension("new").exists());
    log.append([&2_u64.to_le_bytes()[..]]).and_then(|()| log.sync()).expect("it goes on");
    drop(log);
    assert_eq!(numbers(&path), [1, 2]);
}
