//! What is older than a database has to keep is removed, and what it leaves is a database.

use std::time::Duration;

use linewright_history::{EventKind, History, HistoryFeed, HistoryReader, LineAbout, Note, TimeBase};
use linewright_line::Tick;

use crate::feeding::Log;
use crate::played::{c1, events, scratch};

const AT: fn(u64) -> Tick = |seconds| Tick::from_millis(seconds * 1000);

fn about() -> LineAbout {
    LineAbout { line: "line".to_owned(), title: String::new(), clock: TimeBase::Unix, stations: vec![], cycle_us: 0 }
}

fn offer(feed: &mut HistoryFeed, at: u64, note: Note) {
    let since = std::time::Instant::now();
    while !feed.offer_note(AT(at), note.clone()) {
        assert!(since.elapsed() < Duration::from_secs(30), "it takes notes");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn of_a_line_the_newest_is_kept_with_the_situation_at_its_beginning() {
    let (_dir, path) = scratch();
    let its = path.clone();
    let keep = Some(Duration::from_secs(100));
    let mut feed = HistoryFeed::of_notes(move || Ok(History::open(&its, &about())?.keeping(keep)));
    let mode = |name: &str, starts| Note::Mode { name: name.to_owned(), starts };
    let mut offer = |at, note| offer(&mut feed, at, note);
    offer(1, Note::Began {});
    offer(1, mode("stand-by", false));
    offer(2, mode("auto", true));
    offer(3, Note::Station { station: 4, lost: true });
    offer(3, Note::Station { station: 5, lost: true });
    offer(4, Note::Station { station: 4, lost: false });
    for at in 5..5_000 {
        offer(at, Note::Observed {});
    }
    feed.end_within(Duration::from_secs(30));
    // One that is opened again removes what the last batch has left.
    let mut history = History::open(&path, &about()).expect("it opens").keeping(keep);
    history.note(AT(5_000), &Note::Observed {}).expect("it is written");
    let reader = HistoryReader::open(&path).expect("it opens");
    let (first, last) = reader.span().expect("it is read").expect("something is there");
    // Steps are bounded, so the last of them may not have taken all.
    assert!(last == AT(5_000) && first >= AT(3_000) && first <= AT(4_900), "{first:?}");
    assert_eq!(reader.removed().expect("it is read").expect("much was").until, first);
    let lasting: Vec<Note> = events(&path)
        .into_iter()
        .take_while(|event| event.at == first)
        .filter_map(|event| match event.what {
            EventKind::Note(Note::Observed {}) | EventKind::Fact(..) => None,
            EventKind::Note(note) => Some(note),
        })
        .collect();
    let lost = |station, lost| Note::Station { station, lost };
    assert_eq!(lasting, [mode("auto", true), lost(5, true), lost(4, false)]);
}

#[test]
fn a_start_with_a_clock_years_ahead_removes_nothing() {
    let (_dir, path) = scratch();
    let written = |times: &mut dyn Iterator<Item = u64>| {
        let its = path.clone();
        let keep = Some(Duration::from_secs(100));
        let mut feed = HistoryFeed::of_notes(move || Ok(History::open(&its, &about())?.keeping(keep)));
        times.for_each(|at| offer(&mut feed, at, Note::Observed {}));
        feed.end_within(Duration::from_secs(30));
        HistoryReader::open(&path).and_then(|reader| reader.span()).expect("it is read").expect("something is there").0
    };
    let before = written(&mut (1..=3_000));
    assert!(before > AT(1), "what is older is removed");
    // Years ahead for half a minute, and back again.
    let years = 1_000_000_000;
    assert_eq!(written(&mut (years..years + 30).chain(3_001..3_050)), before);
    // A clock that stays there is right.
    assert!(written(&mut (years + 30..years + 200)) > before, "the rest goes when half of the time is covered");
}

#[test]
fn of_a_cell_the_oldest_records_are_removed_and_not_taken_from_the_log_again() {
    let of = c1();
    let (_dir, path) = scratch();
    let log = Log::default();
    log.write(&of.log);
    let last = of.log.last().expect("records").at;
    let half = last.since(Tick::ZERO) / 2;
    // One that keeps everything from then on does not bring them back.
    for retention in [Some(half), Some(half), None] {
        let (file, about) = (path.clone(), of.about.clone());
        let open = move || Ok(History::open(&file, &about)?.keeping(retention));
        let mut recorder = HistoryFeed::of_log(open, Box::new(log.clone()), of.log.len() as u64);
        // Its note has the thread remove.
        recorder.note(last, Note::Observed {});
        recorder.close().expect("it is written");
        let all = events(&path);
        let kept: Vec<_> = all.iter().filter_map(|event| event.record()).collect();
        let first = of.log.iter().position(|record| record.at.since(Tick::ZERO) >= half).expect("some are");
        assert_eq!(kept, of.log[first..]);
        let missing = all.iter().filter_map(|event| match event.what {
            EventKind::Note(Note::Missing { from, to }) => Some((from, to)),
            EventKind::Note(_) | EventKind::Fact(..) => None,
        });
        assert_eq!(missing.collect::<Vec<_>>(), [(1, first as u64)]);
        let removed = HistoryReader::open(&path).and_then(|reader| reader.removed()).expect("it is read");
        assert_eq!(removed.expect("some are").log, first as u64);
    }
}
