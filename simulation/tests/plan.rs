//! The plan: the largest cycle ratio against the growth of the earliest schedule, which does not use circuits.

use linewright_line::{Arrow, Line, StationId};
use linewright_simulation::{LinePlan, Rng};

use crate::common::*;

/// The transfer line with other durations and further arrows that keep it from deadlock: those of the chart's own
/// order, or carried over.
fn varied(rng: &mut Rng) -> Line {
    let mut line = transfer_line(1 + rng.below(3) as usize);
    for station in &mut line.stations {
        for operation in &mut station.operations {
            operation.duration = std::time::Duration::from_millis(rng.within(50, 2000));
        }
    }
    for _ in 0..rng.below(4) {
        let pick = |rng: &mut Rng, line: &Line| {
            let id = StationId::at(rng.below(line.stations.len() as u64) as usize);
            let op = rng.below(line.station(id).operations.len() as u64) as usize;
            (id, linewright_line::OpId::at(op))
        };
        let (from, to) = (pick(rng, &line), pick(rng, &line));
        if from.0 != to.0 {
            line.arrows.push(Arrow { from, to, lag: rng.within(1, 2) as u32, auto: true, manual: true });
        }
    }
    line
}

#[test]
fn the_cycle_ratio_is_the_growth_of_the_schedule() {
    let mut rng = Rng::new(3);
    for round in 0..300 {
        let line = varied(&mut rng);
        let plan = LinePlan::of(&line);
        let circuit = plan.longest_circuit().expect("every chart has circuits");
        // Far enough for the transient to be over, over a number of cycles that every period divides.
        let (from, over) = (200, 60);
        let schedule = plan.schedule(from + over);
        let (id, operation) = circuit.operations[0];
        let end =
            |cycle: usize| plan.planned(&schedule, (id, operation), cycle as i32).expect("within the schedule").end;
        let growth = end(from + over) - end(from);
        assert_eq!(growth * circuit.cycles, circuit.micros * over as u64, "round {round}: {circuit:?}");
    }
}
