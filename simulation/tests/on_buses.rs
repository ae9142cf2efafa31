//! The line on its buses, every image in frames and messages; and what can be done to a line however images travel.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{DeviceBus, Line, Owner, StationId};
use linewright_simulation::{
    LineSim, LogKind, Network, NetworkChange, NodeProcess, OperatorAction, RunEnd, RunGoal, SimOptions,
};
use linewright_station_logic::{HappeningKind, StationHappening};

use crate::common::*;

const TRANSFER: StationId = StationId(0);
const CLAMP: StationId = StationId(1);
const MILL: StationId = StationId(2);

fn on_buses() -> SimOptions {
    SimOptions { frames: true, ..logged() }
}

/// The transfer line; its clamp has a bus of its own.
fn with_own_bus() -> Line {
    let mut line = transfer_line(1);
    let own = DeviceBus::Own("can_clamp".to_owned());
    line.devices.iter_mut().filter(|device| device.owner == Owner::Station(CLAMP)).for_each(|d| d.bus = own.clone());
    line.stations[CLAMP.index()].bus = own;
    line
}

fn events(sim: &LineSim, of: StationId, cycles: i32) -> Vec<StationHappening> {
    let all = sim.log().of(of).map(|(_, event)| event);
    all.filter(|e| e.cycle <= cycles && matches!(e.what, HappeningKind::Started(..) | HappeningKind::Completed(..)))
        .collect()
}

/// In the second cycle, as an operation of the mill or the clamp is under way.
fn during(line: &Line, options: SimOptions, station: &str, operation: &str) -> LineSim {
    let mut sim = LineSim::new(line, options).expect("the line starts");
    assert_eq!(sim.run(&RunGoal::cycles(1)), RunEnd::Done);
    let (id, op) = op(line, station, operation);
    let mut events = 0;
    while !sim.controller(id).is_some_and(|c| c.marking().any(|p| p.op == op && p.is_operating())) {
        sim.step();
        events += 1;
        assert!(events < 1_000_000, "{station}: {operation} is never under way");
    }
    sim
}

fn modes(sim: &LineSim) -> Vec<Option<ControlMode>> {
    sim.line().station_ids().map(|id| sim.controller(id).map(|controller| controller.mode())).collect()
}

#[test]
fn a_station_with_a_bus_of_its_own_does_what_it_does_on_the_line_s() {
    let (line, own) = (transfer_line(1), with_own_bus());
    let (shared, end) = run_on_buses(&line);
    let (alone, own_end) = run_on_buses(&own);
    assert_eq!((end, own_end), (RunEnd::Done, RunEnd::Done));
    for id in line.station_ids() {
        assert_eq!(events(&alone, id, 3), events(&shared, id, 3));
        assert!(events(&alone, id, 3).len() >= 10);
    }
    // No image of the clamp's travels by message: a motion takes half a millisecond less.
    let ends = |sim: &LineSim| sim.record().cycle_ends().to_vec();
    assert_ne!(ends(&alone), ends(&shared));
}

fn run_on_buses(line: &Line) -> (LineSim, RunEnd) {
    linewright_simulation::run(line, on_buses(), &RunGoal::cycles(3)).expect("the line starts")
}

#[test]
fn the_manager_of_a_bus_ends_with_the_process_that_reads_it() {
    let line = with_own_bus();
    let mut sim = during(&line, on_buses(), "clamp_1", "advance clamp");
    sim.run_to(sim.now() + Duration::from_millis(5));
    assert_ne!(sim.energised(CLAMP), 0);
    sim.act(OperatorAction::Kill(NodeProcess::Station(CLAMP))).unwrap();
    sim.run_to(sim.now() + Duration::from_millis(20));
    assert_ne!(sim.energised(CLAMP), 0, "its device's heartbeat consumer waits");
    sim.run_to(sim.now() + line.timing.heartbeat_timeout + line.timing.heartbeat);
    assert_eq!(sim.energised(CLAMP), 0);
    sim.act(OperatorAction::Restart(NodeProcess::Station(CLAMP))).unwrap();
    sim.run_to(sim.now() + Duration::from_secs(2));
    assert!(sim.hears(CLAMP));
    // The coordinator reads the line's bus, and not the clamp's.
    sim.act(OperatorAction::Kill(NodeProcess::Coordinator)).unwrap();
    sim.run_to(sim.now() + Duration::from_secs(2));
    let has_devices = |id: StationId| sim.controller(id).is_some_and(|c| c.report().devices_valid);
    assert_eq!([has_devices(TRANSFER), has_devices(CLAMP), has_devices(MILL)], [false, true, false]);
}

#[test]
fn a_network_that_doubles_and_reorders_costs_nothing_but_time() {
    let bad = Network {
        delay: Duration::from_micros(100),
        jitter: Duration::from_millis(15),
        double_per_mille: 300,
        best_effort: true,
        ..Network::default()
    };
    let line = transfer_line(2);
    let options = SimOptions { network: bad, images: bad, ..on_buses() };
    let (sim, end) = linewright_simulation::run(&line, options, &RunGoal::cycles(5)).expect("the line starts");
    assert_eq!((end, sim.record().faults(), sim.conflicts()), (RunEnd::Done, &[][..], &[][..]));
    let (again, _) = linewright_simulation::run(&line, options, &RunGoal::cycles(5)).expect("the line starts");
    assert_eq!(sim.log().entries(), again.log().entries(), "a seed gives the same run");
}

/// The same chance: where each image goes its own way, none waits for one before it that takes longer.
#[test]
fn images_overtake_each_other_and_come_twice() {
    let line = transfer_line(1);
    let run = |best_effort, double_per_mille| {
        let jitter = Duration::from_millis(15);
        let images = Network { jitter, best_effort, double_per_mille, ..Network::default() };
        let options = SimOptions { images, ..on_buses() };
        let (sim, end) = linewright_simulation::run(&line, options, &RunGoal::cycles(3)).expect("the line starts");
        assert_eq!(end, RunEnd::Done);
        (sim.record().cycle_ends().to_vec(), sim.events())
    };
    let (in_order, overtaking, doubled) = (run(false, 0), run(true, 0), run(false, 200));
    assert!(
        std::iter::zip(&overtaking.0, &in_order.0).all(|(sooner, later)| sooner < later),
        "{overtaking:?} {in_order:?}"
    );
    assert!(doubled.1 * 100 > in_order.1 * 102, "{doubled:?} {in_order:?}");
}

/// An order of the emergency stop that came after the first one of manual would bring the stop back.
#[test]
fn orders_keep_their_order() {
    let line = transfer_line(1);
    let jitter = Duration::from_millis(40);
    for seed in 1..=10 {
        let network = Network { jitter, double_per_mille: 200, best_effort: true, ..Network::default() };
        let mut sim = LineSim::new(&line, SimOptions { seed, network, ..on_buses() }).expect("the line starts");
        sim.run_to(sim.now() + Duration::from_secs(1));
        for round in 0..10 {
            for (command, millis) in [(ModeCommand::EStop, 203), (ModeCommand::Reset, 42), (ModeCommand::Manual, 600)] {
                sim.act(OperatorAction::Command(command)).unwrap();
                sim.run_to(sim.now() + Duration::from_millis(millis));
            }
            let tail = || sim.log().tail(&line, 20);
            assert_eq!(modes(&sim), [Some(ControlMode::Manual); 3], "seed {seed}, round {round}: {}", tail());
        }
    }
}

#[test]
fn held_buttons_get_lost_where_a_network_is_that_bad_and_commands_never() {
    let line = transfer_line(1);
    let begun = |best_effort| {
        let network = Network { best_effort, ..Network::default() };
        let mut sim = LineSim::new(&line, SimOptions { network, ..logged() }).expect("the line starts");
        sim.run_to(sim.now() + Duration::from_millis(500));
        sim.act(OperatorAction::Command(ModeCommand::Manual)).unwrap();
        sim.run_to(sim.now() + Duration::from_millis(500));
        assert_eq!(modes(&sim), [Some(ControlMode::Manual); 3]);
        let lost = NetworkChange { loss_per_mille: Some(1000), ..NetworkChange::default() };
        sim.act(OperatorAction::Network(lost)).unwrap();
        sim.act(OperatorAction::Panel { station: TRANSFER, advance: true, down: true }).unwrap();
        sim.act(OperatorAction::Command(ModeCommand::EStop)).unwrap();
        sim.run_to(sim.now() + Duration::from_millis(20));
        assert_eq!((sim.answered(), sim.mode()), (2, ControlMode::EStop));
        sim.record().begun(TRANSFER)
    };
    assert_eq!([false, true].map(begun), [1, 0]);
}

#[test]
fn a_station_that_dies_at_its_record_puts_out_nothing_that_follows() {
    for options in [logged(), on_buses()] {
        let line = transfer_line(1);
        let mut sim = during(&line, options, "clamp_1", "advance clamp");
        assert_eq!(sim.energised(MILL), 0);
        sim.act(OperatorAction::DieAtRecord(MILL, true)).unwrap();
        let before = sim.record().begun(MILL);
        while sim.controller(MILL).is_some() {
            sim.step();
        }
        assert_eq!(sim.record().begun(MILL), before + 1, "it is written down that it moves");
        let end = sim.now() + Duration::from_secs(1);
        assert_eq!(sim.energised(MILL), 0, "and it does not");
        while sim.next_event() <= end {
            sim.step();
            assert_eq!(sim.energised(MILL), 0, "nor later");
        }
        sim.act(OperatorAction::Restart(NodeProcess::Station(MILL))).unwrap();
        assert!(sim.controller(MILL).is_some_and(|c| c.marking().any(|place| place.is_incomplete())));
    }
}

#[test]
fn a_record_that_cannot_be_written_and_a_stop_of_another_coordinator_stop_the_line() {
    for options in [logged(), on_buses()] {
        for foreign in [false, true] {
            let line = transfer_line(1);
            let mut sim = during(&line, options, "mill_1", "feed main slide");
            if foreign {
                sim.act(OperatorAction::ForeignStop).unwrap();
            } else {
                // The line would fall to stand-by; that cannot be written down.
                sim.act(OperatorAction::FillDisk(true)).unwrap();
                sim.act(OperatorAction::Kill(NodeProcess::Station(CLAMP))).unwrap();
            }
            sim.run_to(sim.now() + Duration::from_secs(1));
            let stopped = [TRANSFER, MILL].map(|id| (modes(&sim)[id.index()], sim.energised(id)));
            assert_eq!(stopped, [(Some(ControlMode::EStop), 0); 2], "{}", sim.log().tail(&line, 30));
            assert_eq!(sim.mode(), ControlMode::EStop);
        }
    }
}

#[test]
fn a_station_without_its_memory_is_founded_anew_and_the_line_counts_on() {
    let home =
        "[[step]]\nwhen = \"cycles >= 2\"\ncommand = \"stop\"\n[[step]]\nwhen = \"line is home and all are stopped\"\n";
    let again = "[[step]]\nwhen = \"all are heard\"\nafter_s = 1\ncommand = \"start\"\n[[step]]\ncommand = \"auto\"\n";
    for options in [logged(), on_buses()] {
        let line = transfer_line(1);
        let goal = |cycles, starts, text| RunGoal { cycles, starts, script: script(&line, text) };
        let mut sim = LineSim::new(&line, options).expect("the line starts");
        assert_eq!(sim.run(&goal(2, true, home)), RunEnd::Done);
        let before = sim.record().cycles();
        sim.act(OperatorAction::Kill(NodeProcess::Station(MILL))).unwrap();
        sim.act(OperatorAction::RestartEmpty(NodeProcess::Station(MILL))).unwrap();
        assert_eq!(sim.controller(MILL).map(|c| c.generation()), Some(0));
        let end = sim.run(&goal(before + 3, false, again));
        assert_eq!(end, RunEnd::Done, "{}", sim.log().tail(&line, 40));
        assert_eq!((sim.record().cycles(), sim.record().errors()), (before + 3, &[][..]));
        assert!(
            sim.log()
                .entries()
                .iter()
                .any(|e| matches!(e.what, LogKind::Station(MILL, event) if event.what == HappeningKind::Founded))
        );
        assert_eq!(sim.controller(MILL).map(|c| c.cycle()), Some(3), "its own count is new");
    }
}
