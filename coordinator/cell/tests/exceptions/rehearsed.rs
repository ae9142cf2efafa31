//! The verdict on an answer before it is given, beside what becomes of it when it is.

use std::time::Duration;

use linewright_coordinator_cell::exception::{ExceptionStep, Whereabouts};
use linewright_coordinator_cell::texts::{AnswerRemark, ListedAnswer};
use linewright_coordinator_cell::{AnswerVerdict, PartId, TaskReport};
use linewright_line::{StationId, Tick};

use super::bench::{CellBench, workcell_line};

const PART: PartId = PartId(1);

impl CellBench {
    fn verdict(&self, word: &str) -> AnswerVerdict {
        let reports: Vec<TaskReport> = self.sim.stations.iter().map(|station| station.heard()).collect();
        let reports: Vec<(StationId, &TaskReport)> =
            reports.iter().enumerate().map(|(at, report)| (StationId::at(at), report)).collect();
        self.sim.coordination.rehearsed(self.sim.now, self.alarm().id, word, &reports)
    }

    /// What becomes of it.
    fn outcome(&mut self, word: &str) -> AnswerVerdict {
        let (before, refused, store) = (self.steps().len(), self.objections().len(), self.resource("ST"));
        self.answer(word);
        if let Some((_, why)) = self.objections().get(refused) {
            return AnswerVerdict::Refused(*why);
        }
        self.hear();
        let steps = self.steps().split_off(before);
        let found = steps.into_iter().find_map(|step| match step {
            ExceptionStep::Mismatch { found, .. } => Some(AnswerVerdict::Contradicted(found.clone())),
            // Machines and the robot have a sensor, the store has none: only that the part is in the machine is seen.
            ExceptionStep::Closed { ruling, unchecked, .. } => {
                assert_eq!(*unchecked, []);
                let unseen = if ruling.part == Whereabouts::To { None } else { Some(store) };
                Some(AnswerVerdict::Taken { unseen: unseen.into_iter().collect() })
            }
            _ => None,
        });
        found.expect("it comes to an end")
    }
}

/// Wherever the part is, and however the stations stand.
#[test]
fn the_verdict_is_what_becomes_of_the_answer() {
    let mut seen = Vec::new();
    for place in [Some("ST"), Some("M1"), Some("R"), None] {
        for is_held in [false, true] {
            for word in ["in-store", "in-machine", "scrap"] {
                let mut bench = CellBench::c1(&[1, 0]);
                bench.at("robot").holds = is_held;
                bench.load_fails();
                let at = place.map(|name| bench.resource(name));
                bench.sim.truth.put(PART, at);
                bench.hear();
                let (verdict, records) = (bench.verdict(word), bench.sim.log.len());
                assert_eq!(bench.sim.log.len(), records, "nothing is written");
                assert_eq!(verdict, bench.outcome(word), "{place:?} {is_held} {word}");
                seen.push(verdict);
            }
        }
    }
    let count = |is: fn(&AnswerVerdict) -> bool| seen.iter().filter(|verdict| is(verdict)).count();
    let refused = count(|of| matches!(of, AnswerVerdict::Refused(_)));
    let contradicted = count(|of| matches!(of, AnswerVerdict::Contradicted(_)));
    let fits = count(|of| matches!(of, AnswerVerdict::Taken { unseen } if unseen.is_empty()));
    let unseen = count(|of| matches!(of, AnswerVerdict::Taken { unseen } if !unseen.is_empty()));
    assert!(refused > 3 && contradicted > 3 && fits > 0 && unseen > 3, "{seen:?}");
}

#[test]
fn each_answer_says_whether_it_fits_the_sensors() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.load_fails();
    let texts = |bench: &CellBench| -> Vec<String> {
        let (line, alarm) = (workcell_line(|line| line), bench.alarm());
        let meanings = linewright_coordinator_cell::texts::alarm::meanings(&bench.sim.coordination, alarm);
        let answer = |(word, meaning): (&String, String)| ListedAnswer {
            word: word.clone(),
            meaning,
            remark: AnswerRemark::of(&line, bench.state(), alarm.id, &bench.verdict(word)),
        };
        let answers = alarm.words.iter().zip(meanings).map(answer).collect();
        ListedAnswer::in_order(answers).iter().map(ListedAnswer::text).collect()
    };
    bench.hear();
    assert_eq!(
        texts(&bench),
        [
            "in-store (once more, part at ST; not measured: look at ST)",
            "scrap (part gone; not measured: look at ST)",
            "in-machine (done, part at M1; contradicts the sensors: M1: part expected, sensor off)",
        ]
    );
    let machine = bench.resource("M1");
    bench.sim.truth.put(PART, Some(machine));
    bench.hear();
    assert_eq!(texts(&bench)[0], "in-machine (done, part at M1; fits the sensors)");
    let robot = bench.resource("R");
    bench.sim.truth.put(PART, Some(robot));
    bench.hear();
    let refused = "in-machine (done, part at M1; refused now: R: sensor on, but the answer states no part there)";
    assert!(texts(&bench)[1..].contains(&refused.to_owned()), "{:?}", texts(&bench));
}

/// While a station is not received, each answer names it with the remedy: at first the verdict is unknown, later the answer is refused.
#[test]
fn answers_name_a_station_that_is_not_received() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.load_fails();
    bench.hear();
    let m1 = bench.station("m1");
    let text = |bench: &CellBench, now: Tick, silent: StationId| {
        let all: Vec<TaskReport> = bench.sim.stations.iter().map(|station| station.heard()).collect();
        let known = all.iter().enumerate().map(|(at, report)| (StationId::at(at), report));
        let known: Vec<(StationId, &TaskReport)> = known.filter(|(id, _)| *id != silent).collect();
        let verdict = bench.sim.coordination.rehearsed(now, bench.alarm().id, "in-store", &known);
        let line = workcell_line(|line| line);
        let remark = AnswerRemark::of(&line, bench.state(), bench.alarm().id, &verdict);
        ListedAnswer { remark, ..ListedAnswer::from("in-store") }.text()
    };
    let now = bench.sim.now;
    assert_eq!(
        text(&bench, now, m1),
        "in-store (not known: no state received from m1; start it again, or look at its host and network)"
    );
    let later = text(&bench, now + Duration::from_secs(600), m1);
    assert!(later.starts_with("in-store (refused now: ") && later.contains("no state received"), "{later}");
}

/// The part is in the machine before and after the work on it, so its sensor is on in both cases: the rehearsal states that, and that a person
/// has to look.
#[test]
fn whether_a_part_was_worked_on_is_not_measured() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.until_that(|bench| bench.firing("M1.process<A.new>").is_some());
    bench.at("m1").fails_with = Some(7);
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    bench.hear();
    let unseen = AnswerVerdict::WorkUnseen { at: bench.resource("M1") };
    for word in ["as-before", "as-done"] {
        assert_eq!(bench.verdict(word), unseen, "{word}");
    }
    let (line, alarm) = (workcell_line(|line| line), bench.alarm().id);
    let remark = AnswerRemark::of(&line, bench.state(), alarm, &bench.verdict("as-done"));
    let listed = ListedAnswer { remark, ..ListedAnswer::from("as-done") }.text();
    assert_eq!(listed, "as-done (not measured: whether it was worked on; the sensor of M1 sees the part, look at it)");
    // Without its part the machine contradicts both.
    bench.sim.truth.put(PART, None);
    bench.hear();
    assert!(matches!(bench.verdict("as-done"), AnswerVerdict::Contradicted(_)), "{:?}", bench.verdict("as-done"));
}
