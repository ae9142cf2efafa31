//! Notes of a line, and reports of them: an example by hand, and that parts sum to the whole whatever the notes.

use std::time::Duration;

use linewright_history::line::{LineReport, LineState, LineTracking, ReportParameters, Spans, StopKind};
use linewright_history::{
    EventKind, History, HistoryEvent, HistoryFeed, HistoryReader, LineAbout, LineOperation, LineStation, MotionOutcome,
    Note, TimeBase,
};
use linewright_line::Tick;
use linewright_simulation::Rng;
use rusqlite::Connection;

use crate::played::scratch;

const AT: fn(u64) -> Tick = Tick::from_millis;
const MS: fn(u64) -> Duration = Duration::from_millis;

fn about() -> LineAbout {
    let operation = |name: &str, planned| LineOperation { name: name.to_owned(), planned_us: Some(planned) };
    let station = |name: &str, operations| LineStation { name: name.to_owned(), operations };
    LineAbout {
        line: "line".to_owned(),
        title: "Line".to_owned(),
        clock: TimeBase::Unix,
        stations: vec![
            station("bar", vec![operation("lift", (0, 3_000_000)), operation("lower", (4_000_000, 6_000_000))]),
            station("clamp", vec![operation("close", (3_000_000, 4_000_000))]),
        ],
        cycle_us: 8_000_000,
    }
}

fn mode(name: &str, starts: bool) -> Note {
    Note::Mode { name: name.to_owned(), starts }
}

fn motion(station: u16, operation: u16, cycle: i32, (from, to): (u64, u64), end: MotionOutcome) -> Note {
    Note::Motion { station, operation, cycle, from: AT(from), to: AT(to), end }
}

fn waited(station: u16, why: &str, from: u64, to: u64) -> Note {
    Note::Waited { station, why: why.to_owned(), from: AT(from), to: AT(to) }
}

fn fault(station: u16, text: &str) -> Note {
    Note::Fault { station, text: text.to_owned() }
}

/// One run with a cycle of 10 s and one of 12 s, a fault, an emergency stop, and a coordinator that was killed.
fn example() -> Vec<(u64, Note)> {
    vec![
        (1_000, Note::Began {}),
        (1_000, mode("home", false)),
        (1_000, Note::Station { station: 1, lost: true }),
        (2_000, Note::Station { station: 1, lost: false }),
        // A start-up until it produces, whatever keeps it from that.
        (4_000, mode("auto", false)),
        (5_000, mode("auto", true)),
        (8_000, motion(0, 0, 1, (5_000, 8_000), MotionOutcome::Done)),
        (8_000, waited(1, "bar: lift (cycle 1), for close", 5_000, 8_000)),
        (10_000, motion(1, 0, 1, (8_000, 10_000), MotionOutcome::Done)),
        (10_000, waited(0, "clamp: close (cycle 1), for lower", 8_000, 10_000)),
        (14_000, motion(0, 1, 1, (10_000, 14_000), MotionOutcome::Done)),
        (14_000, waited(1, "bar: lift (cycle 2), for close", 10_000, 14_000)),
        (15_000, Note::Cycle { number: 1, took_us: Some(10_000_000) }),
        // 5 s of the second cycle: 3 s until the fault, 2 s after it. 7 s of fault.
        (18_000, motion(0, 0, 2, (15_000, 18_000), MotionOutcome::Stopped)),
        (18_000, fault(0, "lift: watchdog")),
        (18_010, mode("stand-by", false)),
        (20_000, mode("manual", false)),
        (21_000, fault(0, "")),
        (24_000, mode("auto", false)),
        (25_000, mode("auto", true)),
        (27_000, Note::Cycle { number: 2, took_us: Some(12_000_000) }),
        // 3 s of emergency stop, reset in manual; then home.
        (30_000, mode("e-stop", false)),
        (31_000, mode("manual", false)),
        (33_000, mode("home", false)),
        (35_000, Note::Observed {}),
        // Killed; 5 s of which nothing is known.
        (40_000, Note::Began {}),
        (40_000, mode("auto", true)),
        // It was under way at the kill.
        (41_500, Note::Cycle { number: 3, took_us: None }),
        (42_000, Note::Observed {}),
    ]
}

fn tracked(notes: &[(u64, Note)]) -> LineTracking {
    let mut tracking = LineTracking::new(about());
    for (at, note) in notes {
        tracking.take(&HistoryEvent { at: AT(*at), what: EventKind::Note(note.clone()) });
    }
    tracking
}

#[test]
fn an_example_by_hand() {
    let tracking = tracked(&example());
    let asked = ReportParameters { planned_busy: Some(MS(40_000)), rejected: Some(1) };
    let report = tracking.report((AT(1_000), AT(42_000)), &asked);
    // 5 to 18, 25 to 30, 40 to 42.
    assert_eq!((report.producing, report.start_up, report.unrecorded), (MS(20_000), MS(4_000), MS(5_000)));
    let stops: Vec<_> =
        report.stops.iter().map(|of| (of.cause.kind, of.cause.text.as_str(), of.times, of.total)).collect();
    let expected = [
        (StopKind::Alarm, "bar: lift: watchdog", 1, MS(7_000)),
        (StopKind::EmergencyStop, "", 1, MS(3_000)),
        // 33 to 35, when it was last received.
        (StopKind::Operator, "", 1, MS(2_000)),
    ];
    assert_eq!(stops, expected);
    let [bar, clamp] = report.stations.as_slice() else { panic!("two stations") };
    // 3 + 4 + 3 s in motion, 2 s for the clamp; of 20 s.
    assert_eq!((bar.busy, bar.other, bar.motions, bar.stopped, bar.faults), (MS(10_000), MS(8_000), 2, 1, 1));
    assert_eq!((bar.waits.len(), bar.waits[0].total), (1, MS(2_000)));
    assert_eq!((clamp.busy, clamp.other), (MS(2_000), MS(11_000)));
    let wait = &clamp.waits[0];
    assert_eq!((wait.why.as_str(), wait.times, wait.total), ("bar: lift, for close", 2, MS(7_000)));
    assert_eq!(report.cycle_time.total, MS(22_000));
    // The first cycle ran 10 s and counts 8, the second 3 + 2, the third 3 before the coordinator was killed and 1.5 after it.
    let of = &report.figures;
    assert_eq!((of.produced, report.without_time()), (3, 1));
    assert_eq!((of.production, of.delay, of.busy()), (MS(20_000), MS(10_000), MS(30_000)));
    assert_eq!(of.utilization_efficiency, Ok(20.0 / 30.0));
    assert_eq!(of.availability, Ok(0.5));
    assert_eq!(of.effectiveness, Ok(17.5 / 20.0));
    assert_eq!(of.quality_ratio, Ok(2.0 / 3.0));
    assert_eq!(of.oee, Ok(0.5 * (17.5 / 20.0) * (2.0 / 3.0)));
}

#[test]
fn what_cannot_be_known_is_left_out_with_its_reason() {
    let tracking = tracked(&example());
    let of = tracking.report((AT(1_000), AT(42_000)), &ReportParameters::default()).figures;
    assert!(of.availability.unwrap_err().contains("PBT"));
    assert!(of.quality_ratio.unwrap_err().contains("GQ"));
    assert!(of.oee.is_err() && of.effectiveness.is_ok());
    let asked = ReportParameters { planned_busy: Some(MS(19_000)), rejected: Some(4) };
    let of = tracking.report((AT(1_000), AT(42_000)), &asked).figures;
    assert!(of.availability.unwrap_err().contains("less than"), "not over 100 %");
    assert!(of.quality_ratio.unwrap_err().contains("more were rejected"));
    let of = tracking.report((AT(1_000), AT(4_000)), &asked).figures;
    assert!(of.effectiveness.unwrap_err().contains("APT is 0"));
}

#[test]
fn a_cycle_is_drawn_as_planned_and_as_measured() {
    let tracking = tracked(&example());
    let chart = tracking.chart(None, (AT(0), AT(42_000))).expect("a cycle");
    assert_eq!((chart.cycle, chart.began), (1, AT(5_000)), "the second is not whole");
    let rows: Vec<_> = chart.rows.iter().map(|row| (row.planned.unwrap(), row.measured.clone())).collect();
    let expected = [
        ((0.0, 3.0), vec![(0.0, 3.0, false)]),
        ((4.0, 6.0), vec![(5.0, 9.0, false)]),
        ((3.0, 4.0), vec![(3.0, 5.0, false)]),
    ];
    assert_eq!(rows, expected);
    let stopped = tracking.chart(Some(2), (AT(0), AT(42_000))).expect("it was begun");
    assert_eq!(stopped.rows[0].measured, [(0.0, 3.0, true)]);
    assert_eq!(tracking.chart(Some(7), (AT(0), AT(42_000))), None);
}

fn sums_to_the_whole(tracking: &LineTracking, report: &LineReport) {
    let stopped: Duration = report.stops.iter().map(|stop| stop.total).sum();
    assert_eq!(report.producing + stopped + report.start_up + report.unrecorded, report.observed());
    for station in &report.stations {
        let waited: Duration = station.waits.iter().map(|wait| wait.total).sum();
        assert_eq!(station.busy + waited + station.other, report.producing, "{station:?}");
    }
    let of = &report.figures;
    for figure in [&of.utilization_efficiency, &of.availability, &of.effectiveness, &of.quality_ratio, &of.oee] {
        assert!(figure.as_ref().is_ok_and(|share| (0.0..=1.0).contains(share)) || figure.is_err(), "{figure:?}");
    }
    // The states follow on each other without a gap.
    let states: Vec<_> = tracking.states(report.span.1).collect();
    assert!(states.windows(2).all(|pair| pair[0].0.1 == pair[1].0.0), "{states:?}");
    let is_joined = |pair: &[(_, &LineState)]| pair[0].1 != pair[1].1;
    assert!(states.windows(2).all(is_joined), "{states:?}");
}

/// Whatever happens, in whatever order, late or twice.
#[test]
fn parts_sum_to_the_whole_and_nothing_is_over_100_percent() {
    let mut rng = Rng::new(41);
    let mut below = |bound: u64| rng.below(bound);
    for _ in 0..500 {
        let (mut now, mut notes) = (0, Vec::new());
        for number in 0..60 {
            now += below(3) * below(900);
            let (station, other) = (below(3) as u16, below(4) as u16);
            let from = now.saturating_sub(below(2_000));
            notes.push((
                now,
                match below(11) {
                    0 => Note::Began {},
                    1..4 => {
                        let name = ["auto", "auto", "auto", "stand-by", "home", "e-stop", "manual"];
                        mode(name[below(7) as usize], below(3) > 0)
                    }
                    4 => Note::Station { station, lost: below(2) == 0 },
                    5 => Note::Device { station, device: String::new(), lost: below(2) == 0 },
                    6 => fault(station, ["", "", "stuck", "watchdog"][usize::from(other)]),
                    7 => motion(station, other, number, (from, now), MotionOutcome::Done),
                    8 => motion(station, other, number, (from, now), MotionOutcome::Stopped),
                    9 => waited(station, ["a", "b", "c", "d"][usize::from(other)], from, now),
                    _ => Note::Cycle { number, took_us: (below(4) > 0).then(|| below(9_000_000)) },
                },
            ));
        }
        let tracking = tracked(&notes);
        let from = below(now + 1);
        let span = (AT(from), AT(from + below(now - from + 1)));
        let asked = ReportParameters { planned_busy: Some(MS(below(40_000))), rejected: Some(below(4)) };
        sums_to_the_whole(&tracking, &tracking.report(span, &asked));
    }
}

/// Causes that follow each other are one wait, for what arrived last; a motion between them makes it two, also one that passed
/// unseen.
#[test]
fn a_wait_is_charged_to_what_arrived_last() {
    let waits = |between: Option<Note>| {
        let mut notes = vec![
            (0, Note::Began {}),
            (0, mode("auto", true)),
            (4_000, waited(0, "a", 1_000, 4_000)),
            (5_000, waited(0, "b", 4_000, 5_000)),
            (8_000, waited(0, "a", 7_000, 8_000)),
            (9_000, waited(1, "c", 5_000, 9_000)),
        ];
        notes.splice(2..2, between.map(|note| (4_000, note)));
        let report = tracked(&notes).report((AT(2_000), AT(9_000)), &ReportParameters::default());
        let waits = report.stations[0].waits.iter().map(|of| (of.why.clone(), of.times, of.total));
        waits.collect::<Vec<_>>()
    };
    let of = |why: &str, total| (why.to_owned(), 1, MS(total));
    assert_eq!(waits(None), [of("b", 3_000), of("a", 1_000)]);
    let unseen = motion(0, 0, 1, (4_000, 4_000), MotionOutcome::Unseen);
    assert_eq!(waits(Some(unseen)), [("a".to_owned(), 2, MS(3_000)), of("b", 1_000)]);
}

/// Times of a gap are not recorded, and what was known before it is not what is known after it.
#[test]
fn a_gap_is_time_that_is_not_recorded() {
    let notes = [
        (1_000, Note::Began {}),
        (1_000, mode("auto", true)),
        (9_000, Note::Gap { from: AT(4_000), to: AT(9_000), lost: 12 }),
        (10_000, Note::Began {}),
        (10_000, mode("auto", true)),
        (12_000, Note::Observed {}),
    ];
    let mut tracking = LineTracking::new(about());
    for (at, note) in notes {
        tracking.take(&HistoryEvent { at: AT(at), what: EventKind::Note(note) });
    }
    let report = tracking.report((AT(0), AT(12_000)), &ReportParameters::default());
    assert_eq!((report.producing, report.unrecorded), (MS(5_000), MS(7_000)));
    let gaps: Vec<_> = report.gaps.iter().map(|gap| (gap.span, gap.lost)).collect();
    assert_eq!(gaps, [((AT(4_000), AT(9_000)), 12)]);
    assert_eq!(tracking.report((AT(9_500), AT(12_000)), &ReportParameters::default()).gaps, []);
}

/// What keeps a line from producing for longer is a stop, and so is what happens while it comes up.
#[test]
fn a_start_up_has_an_end() {
    let stops = |notes: &[(u64, Note)], to: u64| {
        let report = tracked(notes).report((AT(0), AT(to)), &ReportParameters::default());
        let stops: Vec<_> = report.stops.iter().map(|of| (of.cause.kind, of.total)).collect();
        (report.start_up, stops)
    };
    let began = [(0, Note::Began {}), (0, mode("home", false)), (0, Note::Station { station: 1, lost: true })];
    let later = |more: &[(u64, Note)]| [&began[..], more].concat();
    let waits = later(&[(45_000, Note::Station { station: 1, lost: false }), (50_000, mode("auto", true))]);
    let expected = vec![(StopKind::NotHeard, MS(15_000)), (StopKind::Operator, MS(5_000))];
    assert_eq!(stops(&waits, 50_000), (MS(30_000), expected));
    let fails = later(&[(2_000, fault(0, "stuck")), (5_000, fault(0, "")), (6_000, Note::Observed {})]);
    assert_eq!(stops(&fails, 6_000), (MS(2_000), vec![(StopKind::Alarm, MS(4_000))]));
    let lost_later = later(&[
        (1_000, Note::Station { station: 1, lost: false }),
        (2_000, mode("auto", true)),
        (3_000, Note::Station { station: 1, lost: true }),
        (4_000, Note::Observed {}),
    ]);
    assert_eq!(stops(&lost_later, 4_000), (MS(2_000), vec![(StopKind::NotHeard, MS(1_000))]));
}

/// Through the file: what was noted is what is read, a second process goes on behind it, and nothing is held up.
#[test]
fn notes_of_a_line_go_through_the_database() {
    let (_dir, path) = scratch();
    let notes = example();
    let begin = || {
        let path = path.clone();
        HistoryFeed::of_notes(move || History::open(&path, &about()))
    };
    let mut feed = begin();
    assert!(notes.iter().all(|(at, note)| feed.offer_note(AT(*at), note.clone())));
    feed.end_within(Duration::from_secs(20));
    assert_eq!(History::open(&path, &about()).unwrap().last().unwrap(), Some(AT(42_000)));
    // The clock was set back by 2 s meanwhile.
    let mut feed = begin();
    feed.offer_note(AT(40_000), Note::Observed {});
    feed.offer_note(AT(41_000), waited(0, "a", 40_000, 41_000));
    feed.end_within(Duration::from_secs(20));
    let reader = HistoryReader::open(&path).unwrap();
    assert_eq!(reader.about(), &(&about()).into());
    let mut read = Vec::new();
    reader.each(Tick::NEVER, |event| read.push((event.at, event.what))).unwrap();
    let expected = notes.into_iter().chain([(42_000, Note::Observed {}), (43_000, waited(0, "a", 42_000, 43_000))]);
    assert_eq!(read, expected.map(|(at, note)| (AT(at), EventKind::Note(note))).collect::<Vec<_>>());
    // Another line, and other operations, are refused; other planned times are not.
    let refused = |of: &LineAbout| History::open(&path, of).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&LineAbout { line: "other".to_owned(), ..about() }).contains("is about line `line`"));
    let mut other = about();
    other.stations[0].operations.remove(0);
    assert!(refused(&other).contains("line `line` with other stations or operations"));
    History::open(&path, &LineAbout { cycle_us: 9, ..about() }).unwrap();
}

/// A disk that takes nothing: what finds no room is refused, and offering does not wait.
#[test]
fn what_finds_no_room_is_refused_and_nothing_waits() {
    let (_dir, path) = scratch();
    drop(History::open(&path, &about()).unwrap());
    // Another process holds the file, as a disk that hangs would.
    let other = Connection::open(&path).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    let began = std::time::Instant::now();
    let other_path = path.clone();
    let mut feed = HistoryFeed::of_notes(move || History::open(&other_path, &about()));
    let taken = (0..4000).filter(|at| feed.offer_note(AT(*at), Note::Observed {})).count();
    assert!((1000..3000).contains(&taken), "{taken}");
    feed.end_within(Duration::from_millis(50));
    assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
}

/// A thread that ends without a word is a failure as well.
#[test]
fn a_thread_that_panics_is_a_failure() {
    let feed = HistoryFeed::of_notes(|| panic!("as a bug would"));
    let has_failed = (0..1000).any(|_| {
        std::thread::sleep(Duration::from_millis(5));
        feed.failed().is_some()
    });
    assert!(has_failed, "{:?}", feed.failed());
}

fn spans(of: &[(u64, u64)]) -> Spans {
    Spans::of(of.iter().map(|&(from, to)| (Tick::from_millis(from), Tick::from_millis(to))))
}

#[test]
fn what_overlaps_or_touches_is_joined() {
    assert_eq!(spans(&[(5, 9), (1, 3), (2, 4), (4, 5), (7, 7), (20, 30)]), spans(&[(1, 9), (20, 30)]));
    assert_eq!(spans(&[(1, 9), (20, 30)]).total(), Duration::from_millis(18));
}

#[test]
fn what_is_taken_and_what_is_left_are_the_whole() {
    for (others, left) in [
        (vec![], vec![(10, 20), (30, 40)]),
        (vec![(0, 5), (20, 30), (40, 50)], vec![(10, 20), (30, 40)]),
        (vec![(12, 15)], vec![(10, 12), (15, 20), (30, 40)]),
        (vec![(11, 12), (13, 14), (15, 35)], vec![(10, 11), (12, 13), (14, 15), (35, 40)]),
        (vec![(0, 100)], vec![]),
    ] {
        let mut of = spans(&[(10, 20), (30, 40)]);
        let taken = of.take(&spans(&others));
        assert_eq!(of, spans(&left), "{others:?}");
        assert_eq!(taken + of.total(), Duration::from_millis(20), "{others:?}");
    }
}

#[test]
fn a_fault_has_no_time_that_was_measured_as_it_came() {
    for (text, cause) in [
        ("clamp (node 06h): no heartbeat (1017h) for 201 ms", "clamp (node 06h): no heartbeat (1017h)"),
        (
            "io (10.0.0.4:502 unit 1): not asked for 152 ms; tried again in 99 ms; look",
            "io (10.0.0.4:502 unit 1): not asked; look",
        ),
        ("waits for ms, for 2 s; for  ms", "waits for ms, for 2 s; for  ms"),
    ] {
        let tracking = tracked(&[(0, Note::Began {}), (0, mode("auto", true)), (1_000, fault(0, text))]);
        let report = tracking.report((AT(0), AT(2_000)), &ReportParameters::default());
        assert_eq!(report.stops[0].cause.text, format!("bar: {cause}"));
    }
}

#[test]
fn a_cause_has_no_number_of_a_cycle() {
    let cause = |why: &str| {
        let tracking = tracked(&[(0, Note::Began {}), (0, mode("auto", true)), (2_000, waited(0, why, 1_000, 2_000))]);
        tracking.stations()[0].waits[0].why.clone()
    };
    let why = "transfer: 4th lower (cycle 12), for advance clamp; mill_1: feed (cycle -1), for it";
    assert_eq!(cause(why), "transfer: 4th lower, for advance clamp; mill_1: feed, for it");
    for same in ["a plausible cycle of mill_1 (it reports 7), for x", "x (cycle time)", "x (cycle ", ""] {
        assert_eq!(cause(same), same);
    }
}
