//! The thread that feeds a database: full queues, killed processes, readers beside it.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use linewright_coordinator_cell::Record;
use linewright_history::{EventKind, History, HistoryError, HistoryFeed, HistoryReader, Note, RecordSource};
use linewright_line::Tick;
use linewright_simulation::Rng;

use crate::played::{Played, c1, events, played, records, scratch};

/// A log in memory: its records from a number on, and how often it was read.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<(u64, Vec<Record>, usize)>>);

impl Log {
    pub fn write(&self, records: &[Record]) {
        self.0.lock().unwrap().1.extend_from_slice(records);
    }

    fn reads(&self) -> usize {
        self.0.lock().unwrap().2
    }

    pub fn begin(&self, path: &Path, of: &Played, queue: usize) -> HistoryFeed {
        let last = self.0.lock().map(|log| log.0 + log.1.len() as u64).unwrap();
        HistoryFeed::with_queue(open(path, of), Box::new(self.clone()), last, queue)
    }
}

fn open(path: &Path, of: &Played) -> impl FnMut() -> Result<History, HistoryError> + Send + 'static {
    let (path, about) = (path.to_owned(), of.about.clone());
    move || History::open(&path, &about)
}

impl RecordSource for Log {
    fn read(&mut self, take: &mut dyn FnMut(u64, Record)) -> Result<(), String> {
        let mut log = self.0.lock().unwrap();
        log.2 += 1;
        (log.0 + 1..).zip(&log.1).for_each(|(number, record)| take(number, record.clone()));
        Ok(())
    }
}

/// With room for one batch most are dropped, and read from the log.
#[test]
fn what_finds_the_queue_full_is_caught_up_from_the_log() {
    let of = played("workcell-c1", &[20, 20], 1, 0);
    for queue in [1, 3, 1000] {
        let (_dir, path) = scratch();
        let log = Log::default();
        let mut recorder = log.begin(&path, &of, queue);
        for (at, record) in of.log.iter().enumerate() {
            log.write(std::slice::from_ref(record));
            recorder.offer(at as u64 + 1, std::slice::from_ref(record));
        }
        recorder.note(Tick::ZERO, Note::Said { text: "over".to_owned() });
        let history = recorder.close().unwrap();
        assert_eq!(history.newest(), of.log.len() as u64);
        assert_eq!(records(&path), of.log);
        assert_eq!(events(&path).len(), of.log.len() + 1);
        assert!(log.reads() > 1 || queue == 1000, "with room for {queue} nothing was dropped");
    }
}

/// The process is killed at random steps: some of what was offered has not been written. Power cuts take the end of the log.
#[test]
fn after_crashes_the_database_is_the_log() {
    let of = played("workcell-c1", &[8, 8], 1, 0);
    let mut rng = Rng::new(12);
    for power_cuts in [false, true] {
        let (_dir, path) = scratch();
        let log = Log::default();
        let mut written = 0;
        while written < of.log.len() {
            let mut recorder = log.begin(&path, &of, 1 + rng.below(4) as usize);
            for _ in 0..1 + rng.below(60) {
                let end = (written + 1 + rng.below(5) as usize).min(of.log.len());
                log.write(&of.log[written..end]);
                // Killed between the two, or before the thread came to it.
                if rng.below(20) > 0 {
                    recorder.offer(written as u64 + 1, &of.log[written..end]);
                }
                written = end;
            }
            drop(recorder);
            if power_cuts {
                written -= (rng.below(6) as usize).min(written / 2);
                log.0.lock().unwrap().1.truncate(written);
            }
        }
        let newest = log.begin(&path, &of, 1).close().unwrap().newest();
        assert_eq!((newest, records(&path)), (of.log.len() as u64, of.log.clone()));
    }
}

/// On what counts as written the log is cut off: its records would be in neither.
#[test]
fn records_that_a_power_cut_took_never_count_as_written() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log::default();
    log.write(&of.log);
    log.begin(&path, &of, 8).close().unwrap();
    log.0.lock().unwrap().1.truncate(10);
    let recorder = log.begin(&path, &of, 8);
    let since = Instant::now();
    let newest = loop {
        match recorder.newest() {
            0 => assert!(since.elapsed() < Duration::from_secs(20), "{:?}", recorder.failed()),
            newest => break newest,
        }
    };
    assert_eq!(newest, 10);
}

/// A power cut has taken the end of the log, and what this life writes there comes before the database was compared.
#[test]
fn what_a_power_cut_took_is_replaced_by_what_came_instead() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log::default();
    log.write(&of.log[..50]);
    log.begin(&path, &of, 8).close().unwrap();
    log.0.lock().unwrap().1.truncate(40);
    let later = |record: &Record| Record { at: record.at + Duration::from_secs(9), fact: record.fact.clone() };
    let instead: Vec<Record> = of.log[40..].iter().map(later).collect();
    log.write(&instead[..5]);
    let mut recorder = HistoryFeed::of_log(open(&path, &of), Box::new(log.clone()), 40);
    recorder.offer(41, &instead[..5]);
    log.write(&instead[5..]);
    recorder.offer(46, &instead[5..]);
    recorder.close().unwrap();
    assert_eq!(records(&path), [&of.log[..40], &instead].concat());
}

#[test]
fn what_the_log_has_forgotten_is_said_to_be_missing() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log(Arc::new(Mutex::new((40, of.log[40..].to_vec(), 0))));
    log.begin(&path, &of, 8).close().unwrap();
    let events = events(&path);
    assert_eq!(events[0].what, EventKind::Note(Note::Missing { from: 1, to: 40 }));
    assert_eq!(events.len(), of.log.len() - 40 + 1);
    log.begin(&path, &of, 8).close().unwrap();
    assert_eq!(crate::played::events(&path), events, "and nothing is missing twice");
}

/// After a removal of the log the database begins anew, and nothing before is overwritten.
#[test]
fn another_log_of_the_same_cell_is_refused_and_changes_nothing() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log::default();
    log.write(&of.log);
    log.begin(&path, &of, 8).close().unwrap();
    let anew = Log::default();
    let mut first = of.log[0].clone();
    first.at = Tick::from_millis(1);
    anew.write(&[first]);
    let mut recorder = anew.begin(&path, &of, 8);
    recorder.offer(2, &of.log[1..2]);
    let error = recorder.close().map(|_| ()).unwrap_err();
    assert!(matches!(error, HistoryError::OtherLog { number: 1, .. }), "{error}");
    assert_eq!(records(&path), of.log);
}

/// Reads again and again while a thread writes: each time the beginning of the log, as far as one step or another.
#[test]
fn a_report_is_read_while_a_writer_writes() {
    let of = played("workcell-c1", &[40, 40], 1, 0);
    let (_dir, path) = scratch();
    let log = Log::default();
    let mut recorder = log.begin(&path, &of, 16);
    let mut seen = Vec::new();
    for (at, batch) in of.log.chunks(20).enumerate() {
        log.write(batch);
        recorder.offer(at as u64 * 20 + 1, batch);
        let since = Instant::now();
        while at % 4 == 0 && recorder.newest() <= at as u64 * 15 {
            assert!(since.elapsed() < Duration::from_secs(20), "{:?}", recorder.failed());
            std::thread::yield_now();
        }
        if at % 4 == 0 {
            let reader = HistoryReader::open(&path).unwrap();
            let mut records = Vec::new();
            reader.each(Tick::NEVER, |event| records.extend(event.record())).unwrap();
            assert_eq!(records, of.log[..records.len()]);
            // Whatever is written now, this reader does not see.
            let mut again = 0;
            reader.each(Tick::NEVER, |_| again += 1).unwrap();
            assert_eq!(again, records.len());
            seen.push(records.len());
        }
    }
    assert_eq!(recorder.failed(), None);
    recorder.close().unwrap();
    assert_eq!(records(&path), of.log);
    assert!(seen.is_sorted() && seen.len() > 3 && seen[0] < seen[seen.len() - 1], "{seen:?}");
}
