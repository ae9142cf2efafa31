//! Time of a plan: the shipped line, both shipped cells, and a row of twenty stations.
//!
//! `cargo bench -p linewright-recovery --bench plan -- --once` prints what each comes to, with the time of one run.

#[path = "../tests/cells.rs"]
mod cells;
// Not all of it is used here.
#[allow(dead_code)]
#[path = "../tests/operator.rs"]
mod operator;

use std::time::{Duration, Instant};

use divan::Bencher;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId};
use linewright_plant::MotionFault;
use linewright_proof::generate::{self, LineShape};
use linewright_recovery::{LineSituation, RecoveryEnd, plan};
use linewright_simulation::{MotionSelection, NodeProcess, OperatorAction};
use linewright_testkit::built::transfer_line;

#[derive(Clone, Copy, Debug)]
enum Case {
    /// One operation was stopped by its watchdog.
    Jam,
    /// Whatever moved was stopped.
    EStop,
    /// A station has lost its memory: all are led home.
    LostMemory,
}

const CASES: [Case; 3] = [Case::Jam, Case::EStop, Case::LostMemory];

fn main() {
    if std::env::args().any(|argument| argument == "--once") {
        for (name, line) in [("shipped", transfer_line()), ("row of 20", row())] {
            for case in CASES {
                once(&format!("{name} {case:?}"), &line, &situation(&line, case));
            }
        }
        for (name, line) in cells::shipped() {
            once(&format!("{name} HalfWay"), &line, &cells::half_way(&line));
        }
    } else {
        divan::main();
    }
}

fn once(name: &str, line: &Line, seen: &LineSituation) {
    let begun = Instant::now();
    let found = plan(line, seen);
    let took = begun.elapsed();
    let (presses, expanded) = (found.presses(), found.expanded);
    let is_found = found.end == RecoveryEnd::Auto;
    println!(
        "{name:22} {presses} presses, {expanded} states, {took:?}, shortest {}, found {is_found}",
        found.is_shortest
    );
}

fn row() -> Line {
    generate::line(&LineShape::row(20), 3)
}

fn situation(line: &Line, case: Case) -> LineSituation {
    let mut sim = operator::in_auto(line, 1, Duration::from_secs(7));
    let act = |sim: &mut _, action| linewright_simulation::LineSim::act(sim, action).expect("it is done");
    let station = StationId::at(line.stations.len() / 2);
    match case {
        Case::Jam => {
            let op = (station, OpId(0));
            act(&mut sim, OperatorAction::Fail(op, MotionSelection::Normal, Some(MotionFault::Stick)));
            for _ in 0..3000 {
                operator::run_for(&mut sim, Duration::from_millis(100));
                if sim.mode() != ControlMode::Auto {
                    break;
                }
            }
        }
        Case::EStop => operator::command(&mut sim, ModeCommand::EStop),
        Case::LostMemory => {
            act(&mut sim, OperatorAction::Kill(NodeProcess::Station(station)));
            operator::run_for(&mut sim, Duration::from_secs(3));
            act(&mut sim, OperatorAction::RestartEmpty(NodeProcess::Station(station)));
        }
    }
    operator::run_for(&mut sim, Duration::from_secs(10));
    operator::situation(&sim)
}

#[divan::bench(args = CASES)]
fn shipped_line(bencher: Bencher<'_, '_>, case: &Case) {
    let line = transfer_line();
    let seen = situation(&line, *case);
    bencher.bench(|| plan(&line, &seen));
}

#[divan::bench(args = CASES)]
fn row_of_twenty(bencher: Bencher<'_, '_>, case: &Case) {
    let line = row();
    let seen = situation(&line, *case);
    bencher.bench(|| plan(&line, &seen));
}

#[divan::bench(args = [0, 1])]
fn shipped_cell(bencher: Bencher<'_, '_>, which: usize) {
    let (_, line) = &cells::shipped()[which];
    let seen = cells::half_way(line);
    bencher.bench(|| plan(line, &seen));
}
