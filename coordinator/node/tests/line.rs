//! Notes on a station from one of its states to the next, and those in the database of a line.

use std::path::Path;

use linewright_coordinator_logic::CompletedCycle;
use linewright_coordinator_node::line::{LineHistory, StationObserver, not_recorded};
use linewright_coordinator_node::{LineSituation, fault_note};
use linewright_history::{About, EventKind, History, HistoryReader, LineAbout, MotionOutcome, Note, TimeBase};
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};
use linewright_msgs::StationState;
use linewright_testkit::built::transfer_line;

const AT: fn(u64) -> Tick = Tick::from_millis;

fn state(places: [u8; 2], started: [i32; 2]) -> StationState {
    StationState {
        boot_id: 1,
        generation: 5,
        mode: StationState::MODE_AUTO,
        places: places.to_vec(),
        started: started.to_vec(),
        ..StationState::default()
    }
}

fn motion(operation: u16, cycle: i32, (from, to): (u64, u64), end: MotionOutcome) -> Note {
    Note::Motion { station: 3, operation, cycle, from: AT(from), to: AT(to), end }
}

/// All notes of these states, each at its time.
fn notes(observer: &mut StationObserver, states: &[(u64, StationState)]) -> Vec<Note> {
    let mut out = Vec::new();
    states.iter().for_each(|(at, state)| observer.state(3, AT(*at), state, &mut out));
    out
}

#[test]
fn a_motion_is_from_the_state_that_has_it_to_the_one_that_has_not() {
    let mut observer = StationObserver::new(2);
    let seen = [
        (10, state([0, 3], [0, 0])),
        (20, state([1, 0], [1, 0])),
        (25, state([1, 0], [1, 0])),
        (40, state([3, 0], [1, 0])),
        (50, state([0, 1], [1, 1])),
        (60, state([0, 2], [1, 1])),
        (70, state([0, 4], [1, 1])),
        (80, state([0, 6], [1, 1])),
    ];
    let expected = [
        motion(0, 1, (20, 40), MotionOutcome::Done),
        motion(1, 1, (50, 60), MotionOutcome::Stopped),
        motion(1, 1, (70, 80), MotionOutcome::Undone),
    ];
    assert_eq!(notes(&mut observer, &seen), expected);
}

#[test]
fn a_motion_between_two_states_is_counted_without_times() {
    let mut observer = StationObserver::new(2);
    let whole = [(10, state([0, 3], [0, 0])), (90, state([3, 0], [1, 0]))];
    assert_eq!(notes(&mut observer, &whole), [motion(0, 1, (90, 90), MotionOutcome::Unseen)]);
    // The end of one and the beginning of the next.
    let mut observer = StationObserver::new(2);
    let again = [(10, state([1, 0], [1, 0])), (90, state([1, 0], [2, 0])), (95, state([3, 0], [2, 0]))];
    let expected = [motion(0, 1, (90, 90), MotionOutcome::Unseen), motion(0, 2, (90, 95), MotionOutcome::Done)];
    assert_eq!(notes(&mut observer, &again), expected);
    // The counts of another life, or of another generation, do not matter to this.
    let other = StationState { boot_id: 2, ..state([3, 0], [7, 0]) };
    assert_eq!(notes(&mut observer, &[(99, other)]), []);
}

#[test]
fn a_wait_is_as_long_as_it_has_one_reason_in_auto() {
    let mut observer = StationObserver::new(2);
    let waits =
        |why: &str| StationState { blocked_by: vec![why.to_owned(), "its lock".to_owned()], ..state([0, 3], [0, 0]) };
    let waited = |why: &str, from, to| Note::Waited { station: 3, why: why.to_owned(), from: AT(from), to: AT(to) };
    let manual = StationState { mode: StationState::MODE_MANUAL, ..waits("a") };
    let seen = [
        (10, waits("a")),
        (15, StationState { blocked_by: vec!["a".to_owned()], ..waits("a") }),
        (20, waits("b")),
        (30, manual),
        (40, waits("b")),
    ];
    assert_eq!(notes(&mut observer, &seen), [waited("a", 10, 20), waited("b", 20, 30)]);
    // What goes on is noted now and then, and begins anew there.
    let mut out = Vec::new();
    observer.flush(3, AT(50), &mut out);
    observer.lost(3, AT(55), &mut out);
    observer.flush(3, AT(60), &mut out);
    assert_eq!(out, [waited("b", 40, 50), waited("b", 50, 55)]);
}

#[test]
fn a_fault_comes_and_goes_and_is_said_anew_where_the_observation_begins() {
    let mut observer = StationObserver::new(2);
    let failed = StationState { fault: "watchdog".to_owned(), ..state([2, 0], [1, 0]) };
    let fault = |text: &str| Note::Fault { station: 3, text: text.to_owned() };
    assert_eq!(notes(&mut observer, &[(10, failed.clone()), (20, failed)]), [fault("watchdog")]);
    let mut out = Vec::new();
    observer.begin(3, AT(30), &mut out);
    assert_eq!(out, [fault("watchdog")]);
    assert_eq!(notes(&mut observer, &[(40, state([3, 0], [1, 0]))]), [fault("")]);
}

#[test]
fn a_state_of_another_description_is_not_looked_at() {
    let mut observer = StationObserver::new(3);
    assert_eq!(notes(&mut observer, &[(10, state([1, 0], [1, 0])), (20, state([3, 0], [1, 0]))]), []);
}

fn in_auto(line: &Line) -> LineSituation {
    let all = vec![true; line.stations.len()];
    LineSituation { starts: true, mode: ControlMode::Auto, heard: all.clone(), devices: all, ..LineSituation::new(0) }
}

/// A second life goes on behind the first, with the whole situation first.
#[test]
fn the_database_of_a_line_begins_with_how_everything_stands_in_each_life() {
    let (dir, line) = (tempfile::tempdir().expect("a directory"), transfer_line());
    let mut now = in_auto(&line);
    let mut history = LineHistory::begin(dir.path(), &line, AT(5), None);
    assert!(history.situation(AT(10), &now), "it is written");
    assert!(history.situation(AT(11), &now), "nothing has changed");
    history.cycle(AT(20), CompletedCycle { number: 7, took: Some(std::time::Duration::from_millis(3600)) });
    history.end(AT(30));
    now.heard[1] = false;
    let mut history = LineHistory::begin(dir.path(), &line, AT(0), None);
    let state = StationState { sequence: 1, fault: "stuck".to_owned(), ..of(&line, 2) };
    // Before it has begun: it is written with everything else.
    history.state(AT(0), StationId(2), &state);
    assert!(history.situation(AT(1), &now), "it is written");
    // The same once more, late: nothing new.
    history.state(AT(2), StationId(2), &state);
    history.end(AT(3));

    let reader = HistoryReader::open(&dir.path().join("line.db")).expect("opens");
    let About::Line(about) = reader.about() else { panic!("of a line") };
    assert!(about.cycle_us > 0 && about.stations[0].operations.iter().all(|of| of.planned_us.is_some()), "{about:?}");
    let mut notes = Vec::new();
    let note = |event: linewright_history::HistoryEvent| match event.what {
        EventKind::Note(note) => notes.push(note),
        EventKind::Fact(..) => panic!("a line has no log"),
    };
    reader.each(Tick::NEVER, note).expect("reads");
    let mode = || Note::Mode { name: "auto".to_owned(), starts: true };
    let expected = [
        Note::Began {},
        mode(),
        Note::Cycle { number: 7, took_us: Some(3_600_000) },
        Note::Observed {},
        Note::Began {},
        mode(),
        Note::Station { station: 1, lost: true },
        Note::Fault { station: 2, text: "stuck".to_owned() },
        Note::Observed {},
    ];
    assert_eq!(notes, expected);
    drop(reader);
    another_is_not_recorded_in_it(dir.path(), line);
}

/// Names of operations are what rows mean: with others it is not gone on with.
fn another_is_not_recorded_in_it(dir: &Path, mut line: Line) {
    line.stations[0].operations[0].duration *= 2;
    assert_eq!(not_recorded(dir, &line), None, "planned times may differ");
    line.stations[0].operations[0].name = "1st raise".to_owned();
    assert_eq!(not_recorded(&dir.join("new"), &line), None, "one is begun there");
    let expected = format!(
        "nothing of this run is recorded: database {} is about line `{}` with other stations or operations, not about its description; \
         move it away to begin a new one",
        dir.join("line.db").display(),
        line.name
    );
    assert_eq!(not_recorded(dir, &line), Some(expected));
}

fn of(line: &Line, station: u16) -> StationState {
    let operations = line.station(StationId(station)).operations.len();
    StationState { boot_id: 1, places: vec![0; operations], started: vec![0; operations], ..StationState::default() }
}

/// Another line's database cannot be used. When it is moved away while the line runs, the observation begins in a new one.
#[test]
fn a_line_goes_on_while_its_database_cannot_be_used_and_is_recorded_when_it_can() {
    let (dir, line) = (tempfile::tempdir().expect("a directory"), transfer_line());
    let path = dir.path().join("line.db");
    let other = LineAbout {
        line: "other".to_owned(),
        title: String::new(),
        clock: TimeBase::Unix,
        stations: vec![],
        cycle_us: 0,
    };
    drop(History::open(&path, &other).expect("opens"));
    let mut history = LineHistory::begin(dir.path(), &line, AT(0), None);
    let now = in_auto(&line);
    assert!(history.situation(AT(1), &now), "the line is observed");
    history.cycle(AT(2), CompletedCycle { number: 7, took: Some(std::time::Duration::from_millis(3600)) });
    std::thread::sleep(std::time::Duration::from_millis(300));
    std::fs::rename(&path, dir.path().join("other.db")).expect("moved away");
    let mut is_recorded = |at: &u64| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert!(history.situation(AT(10 + at), &now), "the line is observed");
        let mut notes = Vec::new();
        if path.is_file()
            && let Ok(reader) = HistoryReader::open(&path)
        {
            reader.each(Tick::NEVER, |event| notes.push(event.what)).expect("reads");
        }
        let is_gap = |of: &EventKind| matches!(of, EventKind::Note(Note::Gap { lost: 3, .. }));
        notes.iter().any(is_gap) && notes.contains(&EventKind::Note(Note::Began {}))
    };
    assert!((0..500_u64).any(|at| is_recorded(&at)), "a gap, and the whole situation behind it");
}

/// A disk that hangs: when it takes notes again, the observation begins anew, a second after the note that found no room.
#[test]
fn a_database_that_hangs_leaves_a_gap_and_the_observation_begins_anew_a_second_later() {
    let (dir, line) = (tempfile::tempdir().expect("a directory"), transfer_line());
    let path = dir.path().join("line.db");
    let about = LineAbout {
        line: line.name.clone(),
        title: String::new(),
        clock: TimeBase::Unix,
        stations: vec![],
        cycle_us: 0,
    };
    drop(History::open(&path, &about).expect("opens"));
    let ((goes_on, hangs), its) = (std::sync::mpsc::channel::<()>(), path.clone());
    let open = move || {
        hangs.recv().expect("it goes on");
        History::open(&its, &about)
    };
    let mut history = LineHistory::with(open, &line, AT(0));
    let mut now = in_auto(&line);
    // More notes than there is room for, within a second.
    for micros in 0..3000 {
        now.starts = !now.starts;
        assert!(history.situation(Tick::from_micros(10_000 + micros), &now), "nothing has failed");
    }
    goes_on.send(()).expect("it hangs");
    let begun = || {
        let mut begun = Vec::new();
        let mut count = 0;
        let reader = HistoryReader::open(&path).expect("opens");
        let take = |event: linewright_history::HistoryEvent| {
            count += 1;
            if matches!(event.what, EventKind::Note(Note::Began {})) {
                begun.push(event.at);
            }
        };
        reader.each(Tick::NEVER, take).expect("reads");
        (begun, count)
    };
    let written = (0..1000).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        begun().1 >= 1000
    });
    assert!(written, "the queue is written");
    for millis in [500, 1000, 1100] {
        assert!(history.situation(AT(millis), &now), "nothing has failed");
    }
    history.end(AT(1200));
    let (begun, _) = begun();
    assert_eq!(begun.len(), 2);
    assert_eq!(begun[1].since(begun[0]), std::time::Duration::from_millis(1090));
}

#[test]
fn since_the_opposite_all_of_it_is_noted_also_what_was_lost_meanwhile() {
    let now = LineSituation { heard: vec![true, false], devices: vec![true, false], ..LineSituation::new(2) };
    let notes: Vec<Note> = now.notes_since(&now.opposite()).collect();
    let device = |station, lost| Note::Device { station, device: String::new(), lost };
    let expected = [
        Note::Mode { name: "stand-by".to_owned(), starts: false },
        Note::EmergencyStop { on: false },
        Note::Station { station: 0, lost: false },
        Note::Station { station: 1, lost: true },
        device(0, false),
        device(1, true),
    ];
    assert_eq!(notes, expected);
}

#[test]
fn only_what_has_changed_is_noted() {
    let before = LineSituation { heard: vec![true; 2], devices: vec![true; 2], ..LineSituation::new(2) };
    assert_eq!(before.notes_since(&before).count(), 0);
    let mut after = before.clone();
    (after.mode, after.heard[1], after.devices[0]) = (ControlMode::EStop, false, false);
    let notes: Vec<Note> = after.notes_since(&before).collect();
    let expected = [
        Note::Mode { name: "e-stop".to_owned(), starts: false },
        Note::EmergencyStop { on: true },
        Note::Station { station: 1, lost: true },
        Note::Device { station: 0, device: String::new(), lost: true },
    ];
    assert_eq!(notes, expected);
    let notes: Vec<Note> = before.notes_since(&after).collect();
    assert!(notes.contains(&Note::Station { station: 1, lost: false }), "{notes:?}");
}

#[test]
fn a_fault_is_noted_when_it_comes_and_when_it_goes() {
    let mut last = None;
    let watchdog = "cut: watchdog: motion not complete in time (LS_100 off)";
    let note = |text: &str| Some(Note::Fault { station: 1, text: text.to_owned() });
    for (fault, noted) in [("", note("")), ("", None), (watchdog, note(watchdog)), (watchdog, None), ("", note(""))] {
        assert_eq!(fault_note(&mut last, 1, fault), noted, "{fault}");
    }
}
