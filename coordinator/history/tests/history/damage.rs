//! Files that are not what they should be.

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use linewright_history::{History, HistoryError, HistoryReader, set_aside};
use linewright_line::Tick;
use linewright_simulation::Rng;
use rusqlite::Connection;

use crate::played::{c1, scratch};

fn read(path: &std::path::Path) -> Result<usize, HistoryError> {
    let mut count = 0;
    HistoryReader::open(path)?.each(Tick::NEVER, |_| count += 1)?;
    Ok(count)
}

#[test]
fn what_is_no_database_of_a_cell_is_said_to_be_none() {
    let (dir, path) = scratch();
    assert!(matches!(HistoryReader::open(&path), Err(HistoryError::File { .. })), "there is none");
    assert!(matches!(
        HistoryReader::open(dir.path()),
        Err(HistoryError::NotOurs { .. } | HistoryError::Refused { .. })
    ));
    std::fs::write(&path, "").unwrap();
    let why = HistoryReader::open(&path).map(|_| ()).unwrap_err().to_string();
    assert!(why.ends_with("is no database of a cell or line (it is empty)"), "{why}");
    std::fs::write(&path, "name = \"workcell_c1\"\n".repeat(100)).unwrap();
    let why = HistoryReader::open(&path).map(|_| ()).unwrap_err().to_string();
    assert!(why.ends_with("is no database of a cell or line"), "{why}");
    assert!(matches!(History::open(&path, &c1().about), Err(HistoryError::NotOurs { .. })));
    std::fs::remove_file(&path).unwrap();
    Connection::open(&path).unwrap().execute_batch("CREATE TABLE event (id INTEGER)").unwrap();
    let why = HistoryReader::open(&path).map(|_| ()).unwrap_err().to_string();
    assert!(why.ends_with("is no database of a cell or line (another program's)"), "{why}");
    assert!(matches!(History::open(&path, &c1().about), Err(HistoryError::NotOurs { .. })));
}

#[test]
fn a_database_of_another_form_and_rows_that_are_none_are_said_to_be_so() {
    let of = c1();
    let broken = |sql: &str| {
        let (_dir, path) = scratch();
        History::create(&path, &of.about).unwrap().feed(1, &of.log).unwrap();
        let db = Connection::open(&path).unwrap();
        db.execute_batch(sql).unwrap();
        drop(db);
        read(&path).unwrap_err().to_string()
    };
    assert!(broken("PRAGMA user_version = 7").contains("has form 7, this program reads form 1"));
    assert!(broken("DELETE FROM about").contains("no cell or line named in its header"));
    assert!(broken("UPDATE about SET data = '{}'").contains("cell or line (its header cannot be read"));
    assert!(broken("UPDATE event SET kind = 'eaten' WHERE log = 7").contains("event 7 of kind `eaten` is none"));
    assert!(
        broken("UPDATE event SET data = '{}' WHERE kind = 'started'").contains("of kind `started` is none: missing")
    );
    assert!(broken("DELETE FROM event WHERE log = 7").contains("record 8 of the log follows on record 6"));
    assert!(broken("UPDATE event SET at = at + 1000000000 WHERE log = 7").contains("record 8 of the log follows on"));
    assert!(broken("UPDATE event SET at = -1 WHERE log = 7").contains("is damaged"));
}

/// Bytes are overwritten anywhere: all events are read, or the file is refused; nothing panics.
#[test]
fn a_file_with_other_bytes_is_read_to_its_end_or_refused() {
    let of = c1();
    let (_dir, path) = scratch();
    History::create(&path, &of.about).unwrap().feed(1, &of.log).unwrap();
    let sound = std::fs::read(&path).unwrap();
    assert_eq!(read(&path).unwrap(), of.log.len());
    let (mut rng, mut refused) = (Rng::new(6), 0);
    for _ in 0..150 {
        let mut bytes = sound.clone();
        let (at, length) = (rng.below(sound.len() as u64) as usize, 1 + rng.below(300) as usize);
        let end = (at + length).min(bytes.len());
        bytes[at..end].iter_mut().for_each(|byte| *byte = rng.below(256) as u8);
        std::fs::write(&path, &bytes).unwrap();
        match read(&path) {
            Ok(count) => assert_eq!(count, of.log.len()),
            Err(_) => refused += 1,
        }
        _ = History::open(&path, &of.about).and_then(|mut history| history.feed(1, &of.log));
    }
    for _ in 0..50 {
        let cut = rng.below(sound.len() as u64) as usize;
        std::fs::write(&path, &sound[..cut]).unwrap();
        assert!(read(&path).is_err(), "cut off at {cut} of {}", sound.len());
    }
    assert!(refused > 30, "{refused}");
}

#[test]
fn a_damaged_database_is_kept_with_its_time_and_all_that_belongs_to_it_and_none_is_overwritten() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("line.db");
    let at = SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_000_000);
    for nth in ["", "-2"] {
        for end in ["", "-wal"] {
            std::fs::write(dir.path().join(format!("line.db{end}")), format!("{nth}{end}")).expect("written");
        }
        let kept = set_aside(&path, at).expect("renamed");
        let name = kept.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        assert_eq!(name, format!("line.db.damaged-20261118T110640Z{nth}"));
        for end in ["", "-wal"] {
            let text = std::fs::read_to_string(dir.path().join(format!("{name}{end}"))).expect("it is kept");
            assert_eq!(text, format!("{nth}{end}"));
        }
        assert!(!path.exists());
    }
}

#[test]
fn of_many_damaged_databases_the_first_and_the_newest_are_kept() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("line.db");
    for nth in 0..9_u64 {
        for end in ["", "-wal"] {
            std::fs::write(dir.path().join(format!("line.db{end}")), nth.to_string()).expect("written");
        }
        set_aside(&path, SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_000_000 + nth)).expect("renamed");
    }
    let files = |end: &str| {
        let mut names: Vec<PathBuf> = std::fs::read_dir(dir.path())
            .expect("a directory")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.to_str().is_some_and(|name| name.ends_with(end)))
            .collect();
        names.sort();
        names.iter().map(|name| std::fs::read_to_string(name).expect("it is there")).collect::<Vec<_>>()
    };
    for end in ["Z", "-wal"] {
        assert_eq!(files(end), ["0", "5", "6", "7", "8"], "{end}");
    }
}
