//! Files that are not what they should be.

use linewright_history::{History, HistoryError, HistoryReader};
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
