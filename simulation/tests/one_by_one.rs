//! Messages that say nothing new wake nobody. That must change nothing: every run here is played twice, once with every
//! message waking its reader, and the two traces are the same to the microsecond — through jitter, loss, deaths, lost
//! devices, buttons and emergency stops. Only what different nodes do in the same microsecond may stand in another order.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{Line, StationId, Tick};
use linewright_plant::MotionFault;
use linewright_simulation::{LineSim, MotionSelection, Network, NodeProcess, OperatorAction, Rng, SimOptions};

use crate::common::*;

/// Somebody does something at random.
fn action(line: &Line, rng: &mut Rng) -> OperatorAction {
    let station = StationId::at(rng.below(line.stations.len() as u64) as usize);
    let op = line.station(station).op_ids().nth(rng.below(2) as usize).unwrap();
    let process = if rng.chance(300) { NodeProcess::Coordinator } else { NodeProcess::Station(station) };
    match rng.below(22) {
        0 => OperatorAction::Command(*rng.pick(&ModeCommand::ALL)),
        1 | 2 => OperatorAction::Command(*rng.pick(&[ModeCommand::Start, ModeCommand::Auto])),
        3 => OperatorAction::Command(*rng.pick(&[ModeCommand::Manual, ModeCommand::Hand])),
        4 | 5 => OperatorAction::Panel { station, advance: rng.chance(600), down: true },
        6 => OperatorAction::Panel { station, advance: rng.chance(600), down: false },
        7 => OperatorAction::Buttons(1 << rng.below(line.buttons.len() as u64)),
        8 => OperatorAction::Buttons(0),
        9 => OperatorAction::Selector(station, rng.chance(400)),
        10 => OperatorAction::Fail(
            (station, op),
            MotionSelection::Both,
            Some(*rng.pick(&[MotionFault::Stick, MotionFault::Slip, MotionFault::SlipBack])),
        ),
        11 => OperatorAction::Fail((station, op), MotionSelection::Both, None),
        12 => OperatorAction::Device(rng.below(line.devices.len() as u64) as usize, rng.chance(500)),
        13 => OperatorAction::Kill(process),
        14 => OperatorAction::Restart(process),
        15 => OperatorAction::Cut(process, NodeProcess::Station(station)),
        16 | 17 => OperatorAction::Heal,
        18 => OperatorAction::DieAtRecord(station, rng.chance(500)),
        19 => OperatorAction::RestartEmpty(process),
        20 => OperatorAction::FillDisk(rng.chance(200)),
        _ => OperatorAction::Command(ModeCommand::Reset),
    }
}

fn trace(line: &Line, seed: u64, one_by_one: bool) -> (String, u64) {
    let mut rng = Rng::new(seed);
    let network = Network {
        delay: Duration::from_micros(rng.within(1, 5000)),
        jitter: Duration::from_micros(rng.below(2) * rng.within(0, 30_000)),
        loss_per_mille: (rng.below(2) * rng.within(0, 300)) as u32,
        ..Network::default()
    };
    let options = SimOptions { seed, network, variation: 0.1, one_by_one, keeps_log: true, ..SimOptions::default() };
    let mut sim = LineSim::new(line, options).unwrap();
    sim.run_to(Tick::from_millis(500));
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        sim.act(OperatorAction::Command(command)).unwrap();
        sim.run_to(sim.now() + Duration::from_millis(100));
    }
    for _ in 0..60 {
        let pause = rng.within(0, 900_000);
        sim.run_to(sim.now() + Duration::from_micros(pause));
        sim.act(action(line, &mut rng)).unwrap();
    }
    sim.run_to(sim.now() + Duration::from_secs(5));
    assert_eq!(sim.conflicts(), [], "seed {seed}: {}", sim.log().tail(line, 80));
    assert_eq!(sim.record().errors(), [] as [String; 0], "seed {seed}");
    (sorted(&sim.log().text(line)), sim.events())
}

/// The lines by time and, within a microsecond, by who speaks; what one node says keeps its order.
fn sorted(trace: &str) -> String {
    let mut lines: Vec<&str> = trace.lines().collect();
    let key = |line: &&str| {
        let mut words = line.split(' ');
        let micros: u64 = words.next().and_then(|time| time.replace('.', "").parse().ok()).expect("a line has a time");
        (micros, words.nth(1).map(str::to_owned))
    };
    lines.sort_by_key(key);
    lines.join("\n")
}

#[test]
fn a_message_that_says_nothing_new_changes_nothing() {
    let mut events = (0, 0);
    for (machines, seeds) in [(1, 120), (3, 30)] {
        let mut line = transfer_line(machines);
        // No term is a whole number of periods: a message that arrives in the microsecond in which the one before it runs out
        // is heard before or after that, as the order of the ways has it.
        line.timing.stale += Duration::from_micros(1_733);
        line.timing.lease += Duration::from_micros(1_733);
        for seed in 1..=seeds {
            let (few, many) = (trace(&line, seed, false), trace(&line, seed, true));
            for (number, (a, b)) in few.0.lines().zip(many.0.lines()).enumerate() {
                assert_eq!(a, b, "seed {seed}, {machines} machines, line {number}");
            }
            assert_eq!(few.0.len(), many.0.len(), "seed {seed}, {machines} machines");
            events = (events.0 + few.1, events.1 + many.1);
        }
    }
    assert!(events.0 * 3 < events.1 * 2, "the shorter way is shorter: {events:?}");
}
