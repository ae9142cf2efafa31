//! The coordinator is killed at every record and every message of a course with exceptions, also where messages get lost or
//! come twice: the work really done on each part is the same, and no alarm is raised in vain.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::exception::ExceptionStage;
use linewright_coordinator_cell::{CellTable, Fifo, OrderKey, PlayerInput, PlayerState, RecordKind};
use linewright_simulation::cell::{CellSim, CellSimOptions, SimulatedOperator};

use super::bench::{options, table, workcell};

/// A course: two parts; the robot comes to M1 without the first, and M3 has an alarm while it works.
fn play(table: &Arc<CellTable>, stations: usize, options: CellSimOptions) -> CellSim {
    let mut sim = CellSim::new(table.clone(), stations, options);
    sim.senses = true;
    let id = |name: &str| {
        let known = &table.handling().stations;
        known.iter().find(|(_, of)| **of == *name).map(|(id, _)| id.index()).expect("there is such a station")
    };
    for name in ["robot", "m1"] {
        sim.stations[id(name)].is_stuck = true;
    }
    let m3 = table.handling().resource_named("M3").expect("there is such a resource");
    let (mut operator, mut has_alarmed) = (SimulatedOperator::default(), false);
    for _ in 0..2_000 {
        if sim.state().left() == 2 {
            return sim;
        }
        let next = sim.now + Duration::from_millis(250);
        sim.run(&mut Fifo, next);
        let works = |sim: &CellSim| sim.state().firings().any(|of| table.mode_name(of.mode).starts_with("M3.process"));
        if !has_alarmed && works(&sim) {
            sim.say(&mut Fifo, &[PlayerInput::Alarm { resource: m3, text: "smoke" }]);
            // Killed before it was written down, it is lost; the operator checks that.
            has_alarmed = sim.state().exceptions().is_down(m3).is_some();
        }
        operator.look(&mut sim, &mut Fifo);
    }
    panic!("it does not come to an end: {:#?}", sim.log.iter().rev().take(40).collect::<Vec<_>>());
}

/// Work really done on the parts that have left, however they are numbered. Which machine does a step that several can
/// do depends on when.
fn done(sim: &CellSim) -> Vec<Vec<String>> {
    let name = |mode| sim.table.mode_name(mode).replace(['1', '2', '3'], "");
    let mut all: Vec<Vec<String>> =
        sim.truth.done.values().map(|modes| modes.iter().map(|&mode| name(mode)).collect()).collect();
    all.sort();
    all
}

fn assert_sound(sim: &CellSim, at: usize) {
    assert_eq!((sim.state().left(), sim.state().parts().len(), sim.truth.parts().len()), (2, 0, 0), "at {at}");
    let exceptions = sim.state().exceptions();
    assert_eq!((exceptions.open().len(), exceptions.down().len(), exceptions.scrapped()), (0, 0, 0), "at {at}");
    let keys: Vec<OrderKey> =
        sim.stations.iter().flat_map(|station| station.done.iter().map(|done| done.key)).collect();
    assert_eq!(keys.iter().collect::<BTreeSet<_>>().len(), keys.len(), "at {at}: an order was done twice");
    // Every alarm was raised once: after a restart the same number.
    let alarms = sim.log.iter().filter(|record| matches!(&record.fact, RecordKind::Exception(step) if is_alarm(step)));
    let last = exceptions.alarms().len();
    assert_eq!(last, 0, "at {at}: {:?}", alarms.collect::<Vec<_>>());
}

fn is_alarm(step: &linewright_coordinator_cell::exception::ExceptionStep) -> bool {
    matches!(step, linewright_coordinator_cell::exception::ExceptionStep::Alarmed { .. })
}

/// Stages of exceptions in which the second life began.
fn stages(table: &Arc<CellTable>, sim: &CellSim, of: &mut BTreeSet<&'static str>) {
    let begins = |fact: &RecordKind| matches!(fact, RecordKind::Epoch { epoch } if *epoch > 1);
    let Some(at) = sim.log.iter().position(|record| begins(&record.fact)) else { return };
    let state = PlayerState::replay(table.clone(), &sim.log[..at]).expect("it fits");
    of.extend(state.exceptions().open().map(|(_, trouble)| match trouble.stage {
        ExceptionStage::Securing if trouble.standing.is_empty() => "nobody is at rest",
        ExceptionStage::Securing => "somebody is at rest",
        ExceptionStage::Waiting(_) => "somebody is asked",
        ExceptionStage::Restoring { .. } => "model and plant are compared",
    }));
    of.extend((state.exceptions().down().len() > 0).then_some("something is down"));
    let closed = state.firings().len() == 0 && state.exceptions().open().len() == 0;
    let again = table.modes().any(|mode| state.parts().any(|part| state.exceptions().times(mode, Some(part.id)) > 0));
    of.extend((closed && again).then_some("it is to be done once more"));
}

/// All stages there are.
const STAGES: [&str; 6] = [
    "it is to be done once more",
    "model and plant are compared",
    "nobody is at rest",
    "somebody is asked",
    "somebody is at rest",
    "something is down",
];

fn killed_at_every_step(bad_luck: u64) {
    let (cell, table) = table(&workcell(), &[1, 1]);
    let stations = cell.controllers.len();
    let calm = CellSimOptions { bad_luck, replays: false, ..options(4) };
    let whole = play(&table, stations, calm.clone());
    let expected = done(&whole);
    assert_sound(&whole, usize::MAX);
    let mut seen = BTreeSet::new();
    for at in 0..whole.steps {
        let sim = play(&table, stations, CellSimOptions { crash_at: vec![at], ..calm.clone() });
        assert_eq!(sim.lives, 2);
        assert_sound(&sim, at);
        if bad_luck == 0 {
            assert_eq!(done(&sim), expected, "at {at}");
        }
        stages(&table, &sim, &mut seen);
    }
    assert!(seen.into_iter().eq(STAGES), "it was killed in every stage");
}

#[test]
fn it_comes_to_the_same_whichever_step_it_is_killed_at() {
    killed_at_every_step(0);
}

/// With lost and doubled messages other orders may be late, so what is done can be done elsewhere.
#[test]
fn it_comes_to_an_end_whichever_step_it_is_killed_at_where_messages_get_lost() {
    killed_at_every_step(8);
}
