//! Logs that are cut off, damaged, replaced and made up.

use std::fs;
use std::path::{Path, PathBuf};

use linewright_node_shell::log::{LogEntry, LogError, RECORD_BYTES_MAX, RecordLog};
use proptest::prelude::*;
use tempfile::TempDir;

const IDENTITY: &[u8] = b"a cell";
/// Bytes before a record.
const HEAD_BYTES: usize = 32;

/// Content of a log besides its identity, and number of bytes cut off.
#[derive(Debug, Default, PartialEq)]
struct Contents {
    snapshot: Option<Vec<u8>>,
    records: Vec<Vec<u8>>,
    cut: u64,
}

fn open(path: &Path) -> Result<(RecordLog, Contents), LogError> {
    let mut contents = Contents::default();
    let (log, cut) = RecordLog::open(path, IDENTITY, |entry| {
        match entry {
            LogEntry::Identity(identity) => assert_eq!(identity, IDENTITY),
            LogEntry::Snapshot(snapshot) => contents.snapshot = Some(snapshot.to_vec()),
            LogEntry::Record(record) => contents.records.push(record.to_vec()),
        }
        Ok(())
    })?;
    contents.cut = cut;
    Ok((log, contents))
}

fn scratch() -> (TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("state").join("cell.log");
    (dir, path)
}

fn append(log: &mut RecordLog, records: &[&[u8]]) {
    log.append(records.iter().copied()).expect("appends");
}

/// A log of these records; all of it is on the disk, each record before the next was written if `each`.
fn written(path: &Path, records: &[&[u8]], each: bool) -> PathBuf {
    let (mut log, _) = open(path).expect("opens");
    for record in records {
        append(&mut log, &[record]);
        if each {
            log.sync().expect("syncs");
        }
    }
    log.name()
}

const RECORDS: [&[u8]; 6] = [b"first", b"", b"a longer third record, with LWL1 in it", b"4", b"the fifth", b"last"];

#[test]
fn records_come_back_in_their_order() {
    let (_dir, path) = scratch();
    let (mut log, contents) = open(&path).expect("opens");
    assert_eq!(contents, Contents::default());
    append(&mut log, &RECORDS[..2]);
    append(&mut log, &RECORDS[2..]);
    append(&mut log, &[]);
    drop(log);
    for _ in 0..2 {
        let (_, contents) = open(&path).expect("opens");
        assert_eq!(contents, Contents { records: RECORDS.map(<[u8]>::to_vec).to_vec(), ..Contents::default() });
    }
}

/// Killed while writing, at every byte: the whole records are there, the torn one is not, and the next goes behind them.
#[test]
fn a_log_that_is_cut_off_at_any_byte_has_the_records_before_it() {
    let (_dir, path) = scratch();
    let name = written(&path, &RECORDS, false);
    let whole = fs::read(&name).expect("reads");
    let all: usize = RECORDS.iter().map(|record| HEAD_BYTES + record.len()).sum();
    let begin = whole.len() - all;
    for length in begin..=whole.len() {
        fs::write(&name, &whole[..length]).expect("writes");
        let (mut end, mut count) = (begin, 0);
        while count < RECORDS.len() && end + HEAD_BYTES + RECORDS[count].len() <= length {
            end += HEAD_BYTES + RECORDS[count].len();
            count += 1;
        }
        let mut expected: Vec<Vec<u8>> = RECORDS[..count].iter().map(|record| record.to_vec()).collect();
        let (mut log, contents) = open(&path).expect("opens");
        let cut = whole[end..length].iter().rposition(|&byte| byte != 0).map_or(0, |last| last as u64 + 1);
        assert_eq!(contents, Contents { records: expected.clone(), cut, snapshot: None }, "{length}");
        append(&mut log, &[b"next"]);
        drop(log);
        expected.push(b"next".to_vec());
        assert_eq!(open(&path).expect("opens").1, Contents { records: expected, ..Contents::default() }, "{length}");
    }
    // In what was on the disk before the log had its name nothing can be torn.
    for length in 0..begin {
        fs::write(&name, &whole[..length]).expect("writes");
        assert!(matches!(open(&path), Err(LogError::Damaged { .. })), "{length}");
    }
}

/// One byte of a log is another: nothing that was on the disk is passed over in silence, except at the very end, where
/// damage looks like a torn record.
#[test]
fn a_damaged_record_that_later_ones_count_on_is_found() {
    let (_dir, path) = scratch();
    let name = written(&path, &RECORDS, true);
    let whole = fs::read(&name).expect("reads");
    let last = whole.len() - HEAD_BYTES - RECORDS[5].len();
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        fs::write(&name, &bytes).expect("writes");
        match open(&path) {
            Ok((_, contents)) => {
                assert!(at >= last, "{at}");
                assert_eq!((contents.records.len(), contents.cut), (5, (whole.len() - last) as u64));
            }
            Err(LogError::Damaged { path: file, offset }) => {
                assert!(at < last && file == name && offset as usize <= at, "{at} {offset}");
                assert!(at - (offset as usize) < HEAD_BYTES + RECORDS[2].len(), "{at} {offset}");
                assert_eq!(fs::read(&name).expect("reads"), bytes, "nothing is changed");
            }
            Err(other) => panic!("{at}: {other}"),
        }
    }
}

/// Data that were not synced can reach the disk in any order when the power goes.
#[test]
fn a_hole_in_what_was_not_synced_ends_the_log() {
    let (_dir, path) = scratch();
    let name = written(&path, &RECORDS, false);
    let mut bytes = fs::read(&name).expect("reads");
    let all: usize = RECORDS.iter().map(|record| HEAD_BYTES + record.len()).sum();
    let second = bytes.len() - all + HEAD_BYTES + RECORDS[0].len();
    bytes[second..second + HEAD_BYTES].fill(0);
    fs::write(&name, &bytes).expect("writes");
    let (_, contents) = open(&path).expect("opens");
    assert_eq!((contents.records, contents.cut), (vec![RECORDS[0].to_vec()], (bytes.len() - second) as u64));
}

#[test]
fn a_snapshot_stands_in_the_place_of_what_was_before() {
    let (_dir, path) = scratch();
    let (mut log, _) = open(&path).expect("opens");
    append(&mut log, &RECORDS);
    let first = log.name();
    log.begin_anew(b"all six").expect("begins anew");
    assert!(!first.exists() && log.name().exists());
    append(&mut log, &[b"seventh"]);
    drop(log);
    let expected =
        Contents { snapshot: Some(b"all six".to_vec()), records: vec![b"seventh".to_vec()], ..Contents::default() };
    let (mut log, contents) = open(&path).expect("opens");
    assert_eq!(contents, expected);
    log.begin_anew(b"all seven").expect("begins anew");
    drop(log);
    assert_eq!(
        open(&path).expect("opens").1,
        Contents { snapshot: Some(b"all seven".to_vec()), ..Contents::default() }
    );
}

/// Killed while beginning anew: before the new file has its name the old one counts, and after that the new one.
#[test]
fn killed_at_any_step_of_a_snapshot_a_log_is_the_old_or_the_new_one() {
    let (_dir, path) = scratch();
    let (mut log, _) = open(&path).expect("opens");
    append(&mut log, &RECORDS);
    let (old_name, old) = (log.name(), fs::read(log.name()).expect("reads"));
    log.begin_anew(b"all six").expect("begins anew");
    let (new_name, new) = (log.name(), fs::read(log.name()).expect("reads"));
    drop(log);
    fs::remove_file(&new_name).expect("removes");
    let unfinished = path.with_extension("log.new");
    for length in 0..=new.len() {
        fs::write(&old_name, &old).expect("writes");
        fs::write(&unfinished, &new[..length]).expect("writes");
        let (_, contents) = open(&path).expect("opens");
        assert_eq!((contents.records.len(), contents.snapshot), (6, None), "{length}");
        assert!(!unfinished.exists());
    }
    fs::write(&new_name, &new).expect("writes");
    assert_eq!(open(&path).expect("opens").1.snapshot, Some(b"all six".to_vec()));
    assert!(!old_name.exists());
}

#[test]
fn a_second_process_is_kept_away() {
    let (_dir, path) = scratch();
    let (log, _) = open(&path).expect("opens");
    assert!(matches!(open(&path), Err(LogError::InUse { .. })));
    drop(log);
    assert!(open(&path).is_ok());
}

#[test]
fn a_record_that_is_too_large_is_refused_and_nothing_of_its_batch_is_written() {
    let (_dir, path) = scratch();
    let (mut log, _) = open(&path).expect("opens");
    append(&mut log, &[b"before"]);
    let large = vec![0; RECORD_BYTES_MAX + 1];
    assert!(matches!(log.append([&b"beside"[..], &large]), Err(LogError::TooLarge { .. })));
    assert!(matches!(log.begin_anew(&large), Err(LogError::TooLarge { .. })));
    append(&mut log, &[b"after"]);
    drop(log);
    assert_eq!(open(&path).expect("opens").1.records, [b"before".to_vec(), b"after".to_vec()]);
}

#[test]
fn what_its_owner_refuses_is_not_opened_and_not_changed() {
    let (_dir, path) = scratch();
    let name = written(&path, &RECORDS, false);
    let before = fs::read(&name).expect("reads");
    let refuses =
        |entry: LogEntry<'_>| if entry == LogEntry::Record(b"4") { Err("not four".to_owned()) } else { Ok(()) };
    let refused = RecordLog::open(&path, IDENTITY, refuses).expect_err("is refused").to_string();
    assert!(refused.ends_with(": not four") && refused.contains("cell.log.1"), "{refused}");
    assert_eq!(fs::read(&name).expect("reads"), before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever stands in the file, there is an answer, and what is opened can be gone on with.
    #[test]
    fn any_bytes_are_a_log_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let (_dir, path) = scratch();
        let name = written(&path, &[], false);
        fs::write(&name, &bytes).expect("writes");
        prop_assert!(open(&path).is_err());
    }

    /// The same for logs in which something was overwritten, cut out or put in: what comes back are records that were
    /// written, from the first one on.
    #[test]
    fn a_log_that_somebody_has_edited_gives_what_was_written_or_an_error(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0..40_usize, any::<Vec<u8>>()), 1..4),
        each: bool,
    ) {
        let (_dir, path) = scratch();
        let name = written(&path, &RECORDS, each);
        let mut bytes = fs::read(&name).expect("reads");
        for (at, removed, put) in edits {
            let from = at.index(bytes.len() + 1);
            let to = (from + removed).min(bytes.len());
            bytes.splice(from..to, put);
        }
        fs::write(&name, &bytes).expect("writes");
        if let Ok((mut log, contents)) = open(&path) {
            let count = contents.records.len();
            prop_assert!(contents.records.iter().eq(RECORDS[..count].iter()));
            append(&mut log, &[b"next"]);
            drop(log);
            prop_assert_eq!(open(&path).expect("opens").1.records.len(), count + 1);
        }
    }
}
