//! From situations that random faults lead to, the plan leads to auto, and the line works on.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId};
use linewright_plant::MotionFault;
use linewright_proof::generate::{self, LineShape, Random};
use linewright_recovery::{RecoveryEnd, plan};
use linewright_simulation::{LineSim, MotionSelection, NodeProcess, OperatorAction};
use linewright_testkit::built::transfer_line;

use crate::operator::{command, described, in_auto, recover, run_for, situation, works_on};

/// What goes wrong, and is repaired.
#[derive(Clone, Copy, Debug)]
enum Trouble {
    Jam,
    EStop,
    Restart,
    LostMemory,
    /// After a jam people press panels as it comes.
    Panels,
    /// The coordinator's process dies, and comes back with its journal.
    Coordinator,
    /// Two of these, one after the other.
    Two,
}

const WITH_MEMORY: [Trouble; 6] =
    [Trouble::Jam, Trouble::EStop, Trouble::Restart, Trouble::Panels, Trouble::Coordinator, Trouble::Two];
const ALL: [Trouble; 7] = [
    Trouble::Jam,
    Trouble::EStop,
    Trouble::Restart,
    Trouble::LostMemory,
    Trouble::Panels,
    Trouble::Coordinator,
    Trouble::Two,
];

fn act(sim: &mut LineSim, action: OperatorAction) {
    sim.act(action).expect("it is done");
}

fn trouble(sim: &mut LineSim, random: &mut Random, trouble: Trouble) {
    let line = sim.line().clone();
    let station = StationId::at(random.below(line.stations.len()));
    let process = NodeProcess::Station(station);
    match trouble {
        Trouble::Jam | Trouble::Panels => {
            let op = (station, OpId::at(random.below(line.station(station).operations.len())));
            act(sim, OperatorAction::Fail(op, MotionSelection::Normal, Some(MotionFault::Stick)));
            for _ in 0..600 {
                run_for(sim, Duration::from_millis(100));
                if sim.mode() != ControlMode::Auto {
                    break;
                }
            }
            act(sim, OperatorAction::Fail(op, MotionSelection::Normal, None));
            if matches!(trouble, Trouble::Panels) {
                run_for(sim, Duration::from_secs(10));
                command(sim, ModeCommand::Manual);
                (0..6).for_each(|_| press(sim, random));
            }
        }
        Trouble::Coordinator => {
            act(sim, OperatorAction::Kill(NodeProcess::Coordinator));
            run_for(sim, Duration::from_secs(2));
            act(sim, OperatorAction::Restart(NodeProcess::Coordinator));
        }
        Trouble::Two => {
            self::trouble(sim, random, Trouble::Panels);
            let second = if random.below(2) == 0 { Trouble::Restart } else { Trouble::EStop };
            self::trouble(sim, random, second);
        }
        Trouble::EStop => command(sim, ModeCommand::EStop),
        Trouble::Restart | Trouble::LostMemory => {
            act(sim, OperatorAction::Kill(process));
            run_for(sim, Duration::from_secs(2));
            let empty = matches!(trouble, Trouble::LostMemory);
            act(sim, if empty { OperatorAction::RestartEmpty(process) } else { OperatorAction::Restart(process) });
        }
    }
    run_for(sim, Duration::from_secs(10));
}

/// Any panel, for as long as it comes: a motion may be let go half-way.
fn press(sim: &mut LineSim, random: &mut Random) {
    let station = StationId::at(random.below(sim.line().stations.len()));
    let advance = random.below(2) == 0;
    act(sim, OperatorAction::Panel { station, advance, down: true });
    run_for(sim, Duration::from_millis(100 + random.below(2000) as u64));
    act(sim, OperatorAction::Panel { station, advance, down: false });
    run_for(sim, Duration::from_millis(500));
}

fn play(line: &Line, seed: u64, kinds: &[Trouble]) {
    let mut random = Random::new(seed);
    let long = Duration::from_millis(random.below(12_000) as u64);
    let mut sim = in_auto(line, seed, long);
    let kind = kinds[random.below(kinds.len())];
    trouble(&mut sim, &mut random, kind);
    recover(&mut sim);
    works_on(&mut sim);
}

#[test]
fn the_shipped_line_is_recovered_from_whatever_happened() {
    let line = transfer_line();
    for seed in 0..60 {
        play(&line, seed, &ALL);
    }
}

#[test]
fn generated_lines_are_recovered_from_whatever_happened_with_their_memory() {
    let shape = LineShape::default();
    for seed in 0..60 {
        play(&generate::line(&shape, seed), seed, &WITH_MEMORY);
    }
}

/// Where switches measure every conflict all stations come home; elsewhere a plan may end with what blocks.
#[test]
fn generated_lines_without_a_memory_are_recovered_or_what_blocks_is_named() {
    let shape = LineShape::default();
    let mut led = 0;
    for seed in 0..40 {
        let line = generate::line(&shape, seed);
        let mut random = Random::new(seed);
        let mut sim = in_auto(&line, seed, Duration::from_millis(random.below(12_000) as u64));
        trouble(&mut sim, &mut random, Trouble::LostMemory);
        let found = plan(&line, &situation(&sim));
        match found.end {
            RecoveryEnd::Auto => {
                recover(&mut sim);
                works_on(&mut sim);
                led += 1;
            }
            RecoveryEnd::NoWay { reasons, .. } => assert!(!reasons.is_empty(), "seed {seed}"),
            RecoveryEnd::LookAgain | RecoveryEnd::Misfit(_) => panic!("seed {seed}: {}", described(&sim)),
        }
    }
    assert!(led > 5, "{led} of 40");
}

#[test]
fn in_a_row_of_twenty_stations_a_jam_needs_few_states() {
    let line = generate::line(&LineShape::row(20), 3);
    let mut sim = in_auto(&line, 1, Duration::from_secs(7));
    let mut random = Random::new(1);
    trouble(&mut sim, &mut random, Trouble::Jam);
    let found = recover(&mut sim);
    assert!(found.is_shortest && found.expanded < 50, "{} states, {} presses", found.expanded, found.presses());
    works_on(&mut sim);
}
