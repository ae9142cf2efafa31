//! Random cells, with all kinds of failures: every production comes to its end, each part really goes through its plan
//! and nothing twice, and a wrong answer is found where a sensor contradicts it.
//!
//! This is judged without the coordinator: each part's course must begin outside, go on from where it was each time,
//! and end outside.

use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell, dispatcher};
use linewright_coordinator_cell::exception::{AlarmSubject, ExceptionStage, ExceptionStep};
use linewright_coordinator_cell::{CellTable, OngoingActivity, OrderKey, RecordKind, StationUnavailable};
use linewright_proof::cell::{CellExploration, check};
use linewright_proof::generate::{self, CellShape, Random};
use linewright_simulation::cell::{CellSim, CellSimOptions, SimulatedOperator, StationSpeed as Takes};
use linewright_testkit::cases::cases;

const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };

/// A generated cell that does not get stuck, its machines with sensors and orders for what they do.
fn sound(seed: u64) -> Option<Cell> {
    // With several stores parts can be carried round between them for ever, which is no failure's doing.
    let shape = CellShape { unreserved: 0, wip: 1..=3, stores: 1..=1, ..CellShape::small() };
    let mut text = generate::cell(&shape, seed);
    for (name, prototype) in machines(&text) {
        let header = format!("[[resource]]\nname = \"{name}\"\nprototype = \"{prototype}\"\n");
        text = text.replacen(&header, &format!("{header}presence = \"part_present\"\n"), 1);
        let station = name.to_lowercase();
        text.push_str(&format!(
            "[[action]]\nof = \"{name}.process\"\norders = [{{ station = \"{station}\", task = \"work\" }}]\n"
        ));
    }
    // Activities without duration could go round in circles at one moment.
    text = text.split("[[sync]]").map(timed).collect::<Vec<_>>().join("[[sync]]");
    let cell =
        linewright_cell::parse("cell.toml", &text, None).unwrap_or_else(|problems| panic!("{problems:?}\n{text}")).cell;
    let checked = check(&CellExploration::new(&cell)).ok()?;
    (checked.sound >= cell.limits.wip_max).then_some(cell)
}

/// A synchronisation that takes time.
fn timed(sync: &str) -> String {
    let (own, rest) = sync.split_once("\n\n").unwrap_or((sync, ""));
    let has = !own.contains("actions = ") || own.contains("time_s");
    if has { sync.to_owned() } else { format!("{own}\ntime_s = 3\n\n{rest}") }
}

fn machines(text: &str) -> Vec<(String, String)> {
    let mut rest = text.lines();
    let mut found = Vec::new();
    while let Some(line) = rest.next() {
        if line == "[[resource]]" {
            let value =
                |line: Option<&str>| line.and_then(|line| line.split('"').nth(1)).unwrap_or_default().to_owned();
            let (name, prototype) = (value(rest.next()), value(rest.next()));
            if matches!(prototype.as_str(), "machine" | "human") {
                found.push((name, prototype));
            }
        }
    }
    found
}

fn played(cell: &Cell, parts: &[u32]) -> Arc<CellTable> {
    let table = compile_cell(cell, None, Supply::Batch(parts), PACE).expect("it can be played").table;
    let mut handling = table.handling().clone();
    (handling.lost_after, handling.secure) = (Some(Duration::from_secs(3)), Duration::from_secs(8));
    Arc::new(table.with_handling(handling))
}

/// Something goes wrong at some station, or is well again.
fn trouble(sim: &mut CellSim, random: &mut Random) {
    if sim.stations.is_empty() {
        return;
    }
    let at = random.below(sim.stations.len());
    let station = &mut sim.stations[at];
    match random.below(40) {
        0 => station.fails_with = Some(7),
        1 => station.is_stuck = true,
        2 => station.is_away = true,
        3 => station.forget(),
        4 => station.holds = !station.holds,
        5 => station.unable = Some(StationUnavailable::Devices),
        6 => station.unable = None,
        7..=12 => station.is_away = false,
        _ => (),
    }
}

/// A part of what has failed is no more.
fn breakage(sim: &mut CellSim) {
    let handling = sim.table.handling();
    let inside = |firing: &&OngoingActivity| {
        let handled = handling.mode(firing.mode);
        let trouble = sim.state().exceptions().trouble(firing.id);
        // Once an operator has looked it stays as it was found.
        let waits = trouble
            .is_some_and(|trouble| matches!(trouble.stage, ExceptionStage::Securing | ExceptionStage::Waiting(_)));
        waits && handled.from.is_some() && handled.to.is_some()
    };
    let broken = sim.state().firings().find(inside).map(|firing| firing.id);
    broken.into_iter().for_each(|firing| sim.truth.take_away(firing));
}

/// Plays a production to its end, with failures for a while; gives the number of wrong answers left.
fn play(seed: u64, cell: &Cell, lies: usize) -> (CellSim, usize) {
    let mut random = Random::new(seed);
    let parts: Vec<u32> = cell.part_types.iter().map(|_| 1 + random.below(2) as u32).collect();
    let table = played(cell, &parts);
    let millis = Duration::from_millis;
    let options = CellSimOptions {
        seed,
        pace: Takes::Nominal { spread: 0.3 },
        delay: (millis(1), millis(20)),
        period: millis(400),
        ..CellSimOptions::default()
    };
    let mut sim = CellSim::new(table.clone(), cell.controllers.len(), options);
    sim.senses = true;
    let mut dispatcher = dispatcher(cell, &table);
    let mut operator = SimulatedOperator { lies, ..SimulatedOperator::default() };
    let all = u64::from(parts.iter().sum::<u32>());
    for look in 0..20_000 {
        if sim.state().left() == all {
            return (sim, operator.lies);
        }
        let next = sim.now + millis(500);
        sim.run_on(&mut dispatcher, next);
        if look < 600 {
            trouble(&mut sim, &mut random);
            if lies == 0 && random.below(20) == 0 {
                breakage(&mut sim);
            }
        } else if look == 600 {
            sim.stations.iter_mut().for_each(|station| {
                (station.is_away, station.is_stuck, station.unable, station.holds) = (false, false, None, false);
            });
        }
        operator.look(&mut sim, &mut dispatcher);
    }
    let state = sim.state();
    panic!(
        "seed {seed}: {} of {all} have left; in progress {:#?}; {:#?}",
        state.left(),
        state.firings().collect::<Vec<_>>(),
        state.exceptions()
    );
}

/// Work really done, by the ledgers of the stations.
fn assert_done_once(seed: u64, sim: &CellSim) -> u64 {
    let table = &sim.table;
    let keys: Vec<OrderKey> = sim.stations.iter().flat_map(|of| of.done.iter().map(|done| done.key)).collect();
    let mut different = keys.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), keys.len(), "seed {seed}: an order was done twice");
    assert_eq!((sim.truth.parts().len(), sim.state().parts().len()), (0, 0), "seed {seed}: nothing is left behind");
    let (mut left, mut gone) = (0, 0);
    for (part, modes) in &sim.truth.done {
        let mut at = None;
        for (step, &mode) in modes.iter().enumerate() {
            let from = table.part_in(mode);
            assert_eq!(from, at, "seed {seed}: {part} was not where step {step} of {modes:?} takes it from");
            assert_eq!(from.is_none(), step == 0);
            at = table.part_out(mode);
        }
        if at.is_none() { left += 1 } else { gone += 1 }
    }
    assert_eq!((left, gone), (sim.state().left(), sim.state().exceptions().scrapped()), "seed {seed}");
    gone
}

fn steps(sim: &CellSim) -> impl Iterator<Item = &ExceptionStep> {
    sim.log.iter().filter_map(|record| if let RecordKind::Exception(step) = &record.fact { Some(step) } else { None })
}

#[test]
fn every_cell_comes_to_its_end_whatever_goes_wrong() {
    let (mut cells, mut closed, mut down, mut gone) = (0, 0, 0, 0);
    let mut seed = 0;
    while cells < cases(80) {
        seed += 1;
        let Some(cell) = sound(seed) else { continue };
        cells += 1;
        let (sim, _) = play(seed, &cell, 0);
        gone += assert_done_once(seed, &sim);
        closed += steps(&sim).filter(|step| matches!(step, ExceptionStep::Closed { .. })).count();
        down += steps(&sim).filter(|step| matches!(step, ExceptionStep::Down { .. })).count();
    }
    println!(
        "{cells} of {seed} cells; {closed} failures closed, {down} times a resource was left out, {gone} parts gone"
    );
    assert!(closed > 200 && down > 40 && gone > 4, "{closed} {down} {gone}");
}

/// After a wrong answer the alarm comes again, and the next answer is obeyed.
#[test]
fn a_lie_that_a_sensor_sees_is_asked_about_again() {
    let (mut cells, mut lied, mut seed) = (0, 0, 1_000);
    while cells < cases(25) {
        seed += 1;
        let Some(cell) = sound(seed) else { continue };
        cells += 1;
        let (sim, lies) = play(seed, &cell, 1);
        assert_done_once(seed, &sim);
        let found = steps(&sim)
            .filter(|step| matches!(step, ExceptionStep::Mismatch { about: AlarmSubject::Firing(_), .. }))
            .count();
        assert_eq!(found, 1 - lies, "seed {seed}: it is found if he has lied");
        lied += found;
    }
    assert!(lied as u64 > cases(8), "{lied}");
}
