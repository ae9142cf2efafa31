//! Rows written are the rows read.

use linewright_coordinator_cell::tracking::Activities;
use linewright_coordinator_cell::{FiringId, RecordKind};
use linewright_history::{EventKind, History, HistoryError, HistoryEvent, HistoryReader, Note, TimeBase};
use linewright_line::Tick;
use rusqlite::Connection;

use crate::played::{c1, events, played, records, scratch};

#[test]
fn records_are_what_they_were() {
    for of in [c1(), played("assembly-cell", &[2, 2, 1], 4, 3)] {
        let (_dir, path) = scratch();
        let mut history = History::create(&path, &of.about).unwrap();
        // In batches of several sizes.
        let (mut first, mut sizes) = (0, [1, 2, 40, 7].into_iter().cycle());
        while first < of.log.len() {
            let end = (first + sizes.next().unwrap()).min(of.log.len());
            history.feed(first as u64 + 1, &of.log[first..end]).unwrap();
            first = end;
        }
        assert_eq!(history.newest(), of.log.len() as u64);
        assert_eq!(records(&path), of.log, "while it is open for writing");
        drop(history);
        assert_eq!(records(&path), of.log);
        let reader = HistoryReader::open(&path).unwrap();
        assert_eq!(reader.about(), &(&of.about).into());
        let [first, last] = [&of.log[0], &of.log[of.log.len() - 1]].map(|record| record.at);
        assert_eq!(reader.span().unwrap(), Some((first, last)));
    }
}

#[test]
fn a_record_that_is_fed_twice_is_there_once_and_another_under_its_number_is_refused() {
    let of = c1();
    let (_dir, path) = scratch();
    let mut history = History::open(&path, &of.about).unwrap();
    history.feed(1, &of.log).unwrap();
    history.feed(5, &of.log[4..30]).unwrap();
    drop(history);
    let mut history = History::open(&path, &of.about).unwrap();
    history.feed(1, &of.log).unwrap();
    assert_eq!(records(&path), of.log);
    // One whose other log differs: nothing of what comes with it is written.
    let mut other = of.log[9].clone();
    other.at = Tick::from_micros(other.at.as_micros() + 1);
    let batch = [of.log[8].clone(), other, of.log[10].clone()];
    assert!(matches!(history.feed(9, &batch), Err(HistoryError::OtherLog { number: 10, .. })));
    assert_eq!((records(&path), history.newest()), (of.log.clone(), of.log.len() as u64));
    history.forget_after(12).unwrap();
    assert_eq!((&records(&path)[..], history.newest()), (&of.log[..12], 12));
    history.feed(9, &of.log[8..]).unwrap();
    assert_eq!(records(&path), of.log);
}

#[test]
fn notes_lie_between_the_records_of_their_time() {
    let of = c1();
    let (_dir, path) = scratch();
    let mut history = History::create(&path, &of.about).unwrap();
    history.feed(1, &of.log).unwrap();
    let middle = of.log[of.log.len() / 2].at;
    let notes = [
        (middle, Note::Mode { name: "auto".to_owned(), starts: true }),
        (middle, Note::EmergencyStop { on: true }),
        (Tick::ZERO, Note::Station { station: 1, lost: true }),
        (middle, Note::Device { station: 1, device: "m1 \"left\"".to_owned(), lost: false }),
        (middle, Note::Planned { firing: FiringId(3), from: middle, to: Tick::from_millis(100) }),
        (middle, Note::Said { text: "\":{\"".to_owned() }),
    ];
    notes.iter().for_each(|(at, note)| history.note(*at, note).unwrap());
    let events = events(&path);
    let times: Vec<Tick> = events.iter().map(|event| event.at).collect();
    assert!(times.is_sorted());
    let read = events.into_iter().filter_map(|event| match event.what {
        EventKind::Note(note) => Some((event.at, note)),
        EventKind::Fact(..) => None,
    });
    let mut expected = notes.to_vec();
    expected.sort_by_key(|(at, _)| *at);
    assert_eq!(read.collect::<Vec<_>>(), expected);
    assert_eq!(records(&path), of.log);
    let epoch = HistoryEvent { at: middle, what: EventKind::Fact(1, RecordKind::Epoch { epoch: 3 }) };
    assert_eq!(epoch.parts(), ("epoch".to_owned(), "{\"epoch\":3}".to_owned()));
    let mut until = 0;
    HistoryReader::open(&path).unwrap().each(middle, |event| until += usize::from(event.at <= middle)).unwrap();
    let of_log = of.log.iter().filter(|record| record.at <= middle).count();
    assert_eq!(until, of_log + notes.len(), "nothing that is later");
}

#[test]
fn a_database_is_about_one_cell_and_one_description() {
    let of = c1();
    let (_dir, path) = scratch();
    drop(History::create(&path, &of.about).unwrap());
    assert!(matches!(History::create(&path, &of.about), Err(HistoryError::Exists { .. })));
    let refused = |change: &dyn Fn(&mut linewright_history::CellAbout)| {
        let mut about = of.about.clone();
        change(&mut about);
        History::open(&path, &about).map(|_| ()).unwrap_err().to_string()
    };
    let why = refused(&|about| about.cell = "another".to_owned());
    assert!(why.contains("is about cell `workcell_c1`, not about cell `another`; move it away"), "{why}");
    assert!(refused(&|about| about.table += 1).contains("another description of cell `workcell_c1`"));
    assert!(
        refused(&|about| about.clock = TimeBase::Simulated).contains("that has run, not about a simulation of cell")
    );
    // Other times do not make another cell: the newest are those that reports go by.
    let mut about = of.about.clone();
    about.sheet.modes[0].nominal *= 2;
    drop(History::open(&path, &about).unwrap());
    assert_eq!(HistoryReader::open(&path).unwrap().about(), &(&about).into());
}

/// The views are for people; they must agree with the folds.
#[test]
fn whoever_asks_in_sql_is_told_the_same() {
    let of = played("workcell-c1", &[3, 3], 2, 6);
    let (_dir, path) = scratch();
    History::create(&path, &of.about).unwrap().feed(1, &of.log).unwrap();
    let mut activities = Activities::default();
    of.log.iter().for_each(|record| activities.take(record));
    let db = Connection::open(&path).unwrap();
    let mut select = db.prepare("SELECT firing, name, activity, part, began, failed, ended FROM activity").unwrap();
    type Row = (u64, String, String, Option<u64>, u64, Option<u64>, Option<u64>);
    let rows = select.query_map([], |row| {
        Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?, row.get(5)?, row.get(6)?))
    });
    let mut rows: Vec<Row> = rows.unwrap().collect::<Result<_, _>>().unwrap();
    rows.sort_unstable();
    let expected = activities.all().iter().map(|done| {
        let entry = &of.about.sheet.modes[done.mode.index()];
        let failed = done.failed.as_ref().map(|failed| failed.at.as_micros());
        let (part, ended) = (done.part.map(|part| part.0), done.ended.map(Tick::as_micros));
        (done.firing.0, entry.name.clone(), entry.activity.clone(), part, done.began.as_micros(), failed, ended)
    });
    assert_eq!(rows, expected.collect::<Vec<_>>());
    assert!(rows.iter().any(|row| row.5.is_some()), "some have failed");
    let number = |sql: &str| db.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(number("SELECT capacity FROM resource WHERE name = 'ST'"), 6);
    let with_part = of.log.iter().filter(|record| match &record.fact {
        RecordKind::Started { part, .. } | RecordKind::Fired { part, .. } => part.is_some_and(|part| part.0 == 2),
        _ => false,
    });
    assert_eq!(number("SELECT count(*) FROM event WHERE part = 2"), with_part.count() as i64);
}
