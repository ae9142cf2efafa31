//! The verdict on an answer before it is given, beside what becomes of it when it is.

use linewright_coordinator_cell::exception::ExceptionStep;
use linewright_coordinator_cell::texts::{AnswerRemark, PermittedAnswer};
use linewright_coordinator_cell::{AnswerVerdict, PartId, TaskReport};
use linewright_line::StationId;

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
        let (before, refused) = (self.steps().len(), self.objections().len());
        self.answer(word);
        if let Some((_, why)) = self.objections().get(refused) {
            return AnswerVerdict::Refused(*why);
        }
        self.hear();
        let steps = self.steps().split_off(before);
        let found = steps.into_iter().find_map(|step| match step {
            ExceptionStep::Mismatch { found, .. } => Some(AnswerVerdict::Contradicted(found.clone())),
            ExceptionStep::Closed { unchecked, .. } => {
                Some(AnswerVerdict::Taken { is_confirmed: unchecked.is_empty() })
            }
            ExceptionStep::Carried { .. } => Some(AnswerVerdict::Taken { is_confirmed: false }),
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
    let fits = count(|of| matches!(of, AnswerVerdict::Taken { is_confirmed: true }));
    assert!(refused > 3 && contradicted > 3 && fits > 3, "{seen:?}");
}

#[test]
fn each_answer_says_whether_it_fits_the_sensors() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.load_fails();
    let texts = |bench: &CellBench| -> Vec<String> {
        let (line, alarm) = (workcell_line(|line| line), bench.alarm());
        let meanings = linewright_coordinator_cell::texts::alarm::meanings(&bench.sim.coordination, alarm);
        let answer = |(word, meaning): (&String, String)| PermittedAnswer {
            word: word.clone(),
            meaning,
            remark: AnswerRemark::of(&line, bench.state(), alarm.id, &bench.verdict(word)),
        };
        alarm.words.iter().zip(meanings).map(|of| answer(of).text()).collect()
    };
    bench.hear();
    assert_eq!(
        texts(&bench),
        [
            "in-store (once more, part at ST; fits the sensors)",
            "in-machine (done, part at M1; contradicts the sensors: M1: part expected, sensor off)",
            "scrap (part gone; fits the sensors)",
        ]
    );
    let robot = bench.resource("R");
    bench.sim.truth.put(PART, Some(robot));
    bench.hear();
    let refused = "in-machine (done, part at M1; refused now: R: sensor on, but the answer states no part there)";
    assert_eq!(texts(&bench)[1], refused);
}
