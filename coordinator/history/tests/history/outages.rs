//! A database that cannot be written for a while, is damaged, or is replaced under its writer.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use linewright_history::{
    EventKind, History, HistoryError, HistoryFeed, HistoryNews, HistoryReader, LineAbout, LostNotes, Note, Outages,
    TimeBase,
};
use linewright_line::Tick;
use rusqlite::Connection;

use crate::feeding::Log;
use crate::played::{c1, events, scratch};

const AT: fn(u64) -> Tick = Tick::from_millis;

fn about() -> LineAbout {
    LineAbout { line: "line".to_owned(), title: String::new(), clock: TimeBase::Unix, stations: vec![], cycle_us: 0 }
}

fn feed(path: &Path) -> HistoryFeed {
    let path = path.to_owned();
    HistoryFeed::of_notes(move || History::open(&path, &about()))
}

fn said(text: &str) -> Note {
    Note::Said { text: text.to_owned() }
}

fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < Duration::from_secs(30), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn notes(path: &Path) -> Vec<(Tick, Note)> {
    let note = |of: linewright_history::HistoryEvent| match of.what {
        EventKind::Note(note) => (of.at, note),
        EventKind::Fact(..) => panic!("notes alone"),
    };
    events(path).into_iter().map(note).collect()
}

/// The number of notes in a database that may not be complete yet.
fn count(path: &Path) -> usize {
    let mut count = 0;
    HistoryReader::open(path).and_then(|reader| reader.each(Tick::NEVER, |_| count += 1)).map_or(0, |()| count)
}

fn all_news(feed: &HistoryFeed) -> Vec<HistoryNews> {
    std::iter::from_fn(|| feed.news()).collect()
}

/// Every insertion fails from here on, as on a full disk.
fn fail_writes(path: &Path) -> Connection {
    let db = Connection::open(path).unwrap();
    db.busy_timeout(Duration::from_secs(5)).unwrap();
    db.execute_batch(
        "CREATE TRIGGER full BEFORE INSERT ON event BEGIN SELECT RAISE(FAIL, 'database or disk is full'); END",
    )
    .unwrap();
    db
}

#[test]
fn after_failed_writes_it_goes_on_by_itself_and_the_gap_is_noted() {
    let (_dir, path) = scratch();
    let mut feed = feed(&path);
    feed.offer_note(AT(1), said("before"));
    wait_for("it is written", || count(&path) == 1);
    let db = fail_writes(&path);
    for at in 10..60 {
        assert!(feed.offer_note(AT(at), said("lost")));
        std::thread::sleep(Duration::from_millis(1));
    }
    wait_for("it fails", || feed.is_failing());
    assert!(feed.failed().is_some_and(|why| why.contains("disk is full")), "{:?}", feed.failed());
    // More than there is room for: none waits, and all are counted.
    for at in 60..10_000 {
        wait_for("it takes notes", || feed.offer_note(AT(at), said("lost")));
    }
    assert_eq!(feed.resumed(), 0);
    db.execute_batch("DROP TRIGGER full").unwrap();
    wait_for("it is written again", || !feed.is_failing());
    assert_eq!(feed.resumed(), 1);
    feed.offer_note(AT(20_000), said("after"));
    let news = all_news(&feed);
    feed.end_within(Duration::from_secs(20));
    let [HistoryNews::Failed { .. }, HistoryNews::Resumed { lost, .. }] = &news[..] else {
        panic!("once each: {news:?}")
    };
    let LostNotes { count, span: Some((from, to)) } = *lost else { panic!("{lost:?}") };
    assert_eq!((from, count), (AT(10), to.since(AT(9)).as_millis() as u64));
    // What was still in the queue when it went on is written.
    let behind = (to.since(AT(0)).as_millis() as u64 + 1..10_000).map(|at| (AT(at), said("lost")));
    let mut expected = vec![(AT(1), said("before")), (to, Note::Gap { from, to, lost: count })];
    expected.extend(behind);
    expected.push((AT(20_000), said("after")));
    assert!(notes(&path) == expected, "lost {count} until {to:?}, {} notes", notes(&path).len());
}

#[test]
fn a_file_that_cannot_be_opened_is_tried_again() {
    let (_dir, path) = scratch();
    let (trials, its) = (Arc::new(AtomicUsize::new(0)), path.clone());
    let counted = trials.clone();
    let mut feed = HistoryFeed::of_notes(move || match counted.fetch_add(1, Ordering::Relaxed) {
        0 | 1 => Err(HistoryError::Refused { path: its.clone(), why: "disk I/O error".to_owned() }),
        _ => History::open(&its, &about()),
    });
    feed.offer_note(AT(5), said("lost"));
    wait_for("it is written", || trials.load(Ordering::Relaxed) == 3 && !feed.is_failing());
    feed.offer_note(AT(6), said("after"));
    feed.end_within(Duration::from_secs(20));
    let gap = Note::Gap { from: AT(5), to: AT(5), lost: 1 };
    assert_eq!(notes(&path), [(AT(5), gap), (AT(6), said("after"))]);
}

/// Files that were set aside, without what belongs to them.
fn kept(dir: &Path) -> Vec<PathBuf> {
    let names = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path());
    names.filter(|path| path.to_str().is_some_and(|name| name.contains(".damaged-") && name.ends_with('Z'))).collect()
}

#[test]
fn a_damaged_database_is_kept_and_a_new_one_begun() {
    let (dir, path) = scratch();
    std::fs::write(&path, [7; 4096]).unwrap();
    let mut feed = feed(&path);
    feed.offer_note(AT(5), said("first"));
    wait_for("it is written", || count(&path) == 1);
    let news = all_news(&feed);
    assert!(matches!(&news[..], [HistoryNews::SetAside { .. }]), "{news:?}");
    feed.end_within(Duration::from_secs(20));
    assert_eq!(notes(&path), [(AT(5), said("first"))]);
    let kept = kept(dir.path());
    assert_eq!(kept.iter().map(|kept| std::fs::read(kept).unwrap()).collect::<Vec<_>>(), [[7; 4096]]);
}

/// Moved away, and a backup in its place, while it is written: nothing of the one gets into the other.
#[test]
fn a_file_that_is_replaced_is_opened_again_and_the_old_one_is_whole() {
    let (dir, path) = scratch();
    let backup = dir.path().join("backup.db");
    {
        let mut history = History::create(&backup, &about()).unwrap();
        history.note(AT(1), &said("backup")).unwrap();
    }
    let mut feed = feed(&path);
    let moved = dir.path().join("moved.db");
    feed.offer_note(AT(5), said("old"));
    wait_for("it is written", || count(&path) == 1);
    std::fs::rename(&path, &moved).unwrap();
    std::fs::rename(&backup, &path).unwrap();
    feed.offer_note(AT(6), said("new"));
    wait_for("it is written", || feed.resumed() == 1);
    assert!(matches!(&all_news(&feed)[..], [HistoryNews::Replaced { .. }]));
    feed.end_within(Duration::from_secs(20));
    assert_eq!(notes(&path), [(AT(1), said("backup")), (AT(6), said("new"))]);
    assert_eq!(notes(&moved), [(AT(5), said("old"))]);
}

/// A backup is copied over the file while it is written: what the write-ahead log has of the old one does not get into it.
#[test]
fn a_backup_that_is_copied_over_the_file_stays_what_it_is() {
    let (dir, path) = scratch();
    let backup = dir.path().join("backup.db");
    {
        let mut history = History::create(&backup, &about()).unwrap();
        (1..200).for_each(|at| history.note(AT(at), &said("backup")).unwrap());
    }
    let mut feed = feed(&path);
    for at in 1000..1400 {
        wait_for("it takes notes", || feed.offer_note(AT(at), said("old")));
    }
    wait_for("it is written", || count(&path) == 400);
    std::fs::write(&path, std::fs::read(&backup).unwrap()).unwrap();
    feed.offer_note(AT(2000), said("new"));
    wait_for("it goes on", || feed.resumed() == 1);
    assert!(matches!(&all_news(&feed)[..], [HistoryNews::Replaced { .. }]));
    feed.end_within(Duration::from_secs(20));
    let mut expected: Vec<_> = (1..200).map(|at| (AT(at), said("backup"))).collect();
    expected.push((AT(2000), said("new")));
    assert!(notes(&path) == expected, "{:?}", notes(&path).len());
}

#[test]
fn a_file_that_is_removed_or_cut_off_is_begun_anew() {
    for cut in [None, Some(0), Some(5000)] {
        let (dir, path) = scratch();
        let mut feed = feed(&path);
        feed.offer_note(AT(5), said("old"));
        wait_for("it is written", || count(&path) == 1);
        // What is in the write-ahead log alone is in the file as well.
        Connection::open(&path).unwrap().query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(())).unwrap();
        feed.offer_note(AT(6), said("old"));
        wait_for("it is written", || count(&path) == 2);
        match cut {
            None => std::fs::remove_file(&path).unwrap(),
            Some(length) => std::fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap(),
        }
        feed.offer_note(AT(7), said("new"));
        wait_for(&format!("it goes on, cut {cut:?}"), || feed.resumed() > 0 && !feed.is_failing());
        feed.offer_note(AT(8), said("after"));
        feed.end_within(Duration::from_secs(20));
        let notes = notes(&path);
        assert_eq!(notes.last(), Some(&(AT(8), said("after"))), "{cut:?}");
        let is_old = |of: &&(Tick, Note)| of.1 == said("old");
        assert_eq!(notes.iter().filter(is_old).count(), 0, "{cut:?}: {notes:?}");
        assert_eq!(kept(dir.path()).len(), usize::from(cut == Some(5000)), "{cut:?}");
        assert!(HistoryReader::open(&path).is_ok());
    }
}

/// Records are read from the log when there is room again; only notes are lost.
#[test]
fn records_of_a_log_are_caught_up_after_an_outage() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log::default();
    let mut recorder = log.begin(&path, &of, 1000);
    log.write(&of.log[..20]);
    recorder.offer(1, &of.log[..20]);
    wait_for("it is written", || recorder.newest() == 20);
    let db = fail_writes(&path);
    log.write(&of.log[20..40]);
    recorder.offer(21, &of.log[20..40]);
    wait_for("it fails", || recorder.is_failing());
    recorder.note(of.log[39].at, said("lost"));
    log.write(&of.log[40..50]);
    recorder.offer(41, &of.log[40..50]);
    std::thread::sleep(Duration::from_millis(50));
    db.execute_batch("DROP TRIGGER full").unwrap();
    wait_for("it is written again", || !recorder.is_failing());
    assert_eq!(recorder.newest(), 50);
    log.write(&of.log[50..]);
    recorder.offer(51, &of.log[50..]);
    recorder.close().unwrap();
    let all = events(&path);
    let gaps = all.iter().filter(|event| matches!(event.what, EventKind::Note(Note::Gap { lost: 1, .. })));
    assert_eq!((gaps.count(), all.len()), (1, of.log.len() + 1));
    assert_eq!(all.iter().filter_map(|event| event.record()).collect::<Vec<_>>(), of.log);
}

const SECONDS: fn(u64) -> Tick = |seconds| Tick::from_millis(seconds * 1000);

#[test]
fn waits_double_up_to_half_a_minute_and_one_failure_begins_it() {
    let mut outages = Outages::default();
    assert_eq!((outages.is_on(), outages.left(SECONDS(0))), (false, None));
    let mut now = SECONDS(100);
    assert!(outages.failed(now), "it begins");
    let mut waits = Vec::new();
    for _ in 0..8 {
        let left = outages.left(now).expect("an outage");
        waits.push(left.as_secs());
        assert_eq!(outages.left(now + left * 2), Some(Duration::ZERO));
        now = now + left;
        assert!(!outages.failed(now), "it goes on");
    }
    assert_eq!(waits, [1, 2, 4, 8, 16, 30, 30, 30]);
}

#[test]
fn a_relapse_goes_on_with_longer_waits_and_a_later_outage_begins_anew() {
    let mut outages = Outages::default();
    outages.failed(SECONDS(0));
    outages.failed(SECONDS(1));
    assert_eq!(outages.end(SECONDS(3)), Some(LostNotes::default()));
    assert_eq!(outages.end(SECONDS(3)), None);
    assert!(outages.failed(SECONDS(62)), "another outage");
    assert_eq!(outages.left(SECONDS(62)), Some(Duration::from_secs(4)));
    outages.end(SECONDS(70));
    outages.failed(SECONDS(130));
    assert_eq!(outages.left(SECONDS(130)), Some(Duration::from_secs(1)));
}

#[test]
fn what_is_lost_is_counted_from_the_first_to_the_last_of_one_outage() {
    let mut outages = Outages::default();
    let mut lost = LostNotes::default();
    assert_eq!(lost.gap(), None);
    lost.add(SECONDS(7));
    lost.add(SECONDS(5));
    outages.failed(SECONDS(0));
    outages.lose(lost);
    lost.add(SECONDS(9));
    outages.lose(LostNotes { count: 1, span: Some((SECONDS(9), SECONDS(9))) });
    assert_eq!(outages.lost(), lost);
    let ended = outages.end(SECONDS(1)).expect("it was on");
    assert_eq!(ended.gap(), Some((SECONDS(9), Note::Gap { from: SECONDS(5), to: SECONDS(9), lost: 3 })));
    assert_eq!(outages.lost(), LostNotes::default());
}

#[test]
fn a_failure_names_file_reason_consequence_and_remedy() {
    let path = PathBuf::from("/s/line.db");
    let error = HistoryError::Refused { path: path.clone(), why: "database or disk is full".to_owned() };
    let news = [
        HistoryNews::Failed { why: error.to_string(), remedy: error.remedy() },
        HistoryNews::Resumed { path, lost: LostNotes { count: 7, span: None } },
    ];
    assert_eq!(
        news.each_ref().map(ToString::to_string),
        [
            "cannot use database /s/line.db: database or disk is full; until it is written again reports may lack what \
             happens, control goes on; make room on the disk, or make file and directory writable; writing is tried again by itself",
            "database /s/line.db is written again; 7 notes were lost, which reports show",
        ]
    );
    assert_eq!(news.map(|news| news.is_warning()), [true, false]);
}
