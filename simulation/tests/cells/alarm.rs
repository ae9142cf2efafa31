//! An alarm is given by hand of a machine while the robot is on its way to it: both stand at once, wherever that is, and
//! stay there until they are led on by hand, whatever is lost on the way and whichever process is killed.

use std::time::Duration;

use linewright_coordinator_cell::{ActivityPhase, PlayerInput};
use linewright_line::net::ControlMode;
use linewright_line::{Owner, RestId, StationId, Tick};
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, CellSimOptions};
use linewright_station_logic::PanelCommand;

use super::{LONG, Shipped, dispatcher, is_machined, options, shipped};

const MILLIS: fn(u64) -> Duration = Duration::from_millis;
/// The longest that a message takes here which is not delayed beyond that, there and back.
const SLOW: u64 = 200;

/// Positions of all axes.
fn positions(of: &Shipped, sim: &CellSim) -> String {
    let plant = sim.floor.as_ref().expect("real stations").plant();
    let all = of.line.station_ids().map(|id| plant.inputs(Owner::Station(id)));
    format!("{:?}", all.collect::<Vec<_>>())
}

fn drives(sim: &CellSim, station: StationId) -> bool {
    let controller = sim.floor.as_ref().expect("real stations").controller(station);
    controller.marking().any(|place| place.is_operating())
}

/// The rest that a station stands at.
fn rest(sim: &CellSim, station: StationId) -> Option<RestId> {
    sim.floor.as_ref().expect("real stations").controller(station).report().order.and_then(|order| order.rest)
}

/// The alarm is given so long after the loading has started.
fn run(of: &Shipped, options: CellSimOptions, after: Duration, kill: bool) {
    let is_calm = options.bad_luck == 0;
    let mut sim = of.sim(options, 0.0);
    let mut dispatcher = dispatcher(&of.cell, &of.table);
    let mut now = Tick::ZERO;
    let loads = |sim: &CellSim| {
        sim.state().firings().find(|of| sim.table.mode_name(of.mode).starts_with("load ")).map(|of| (of.id, of.mode))
    };
    let of_machines = ["m1", "m2"].map(|name| of.line.station_named(name).expect("there"));
    let open = rest(&sim, of_machines[0]);
    let (firing, mode) = loop {
        now = now + MILLIS(10);
        sim.run_on(&mut dispatcher, now);
        if let Some(of) = loads(&sim) {
            break of;
        }
    };
    let slot = sim.floor.as_ref().expect("real stations").plant().parts().next().and_then(|(_, at)| at.spot);
    let slot = slot.expect("it is in the store");
    now = now + after;
    sim.run_on(&mut dispatcher, now);
    let machine = of.table.handling().mode(mode).to.expect("a machine");
    let orders = sim.state().firing(firing).expect("it goes on").orders.clone();
    let stations: Vec<StationId> = orders.iter().map(|order| order.station).collect();
    sim.say(&mut dispatcher, &[PlayerInput::Alarm { resource: machine, text: "smoke" }]);
    assert!(sim.state().firing(firing).is_some_and(|of| of.phase != ActivityPhase::Running));

    if is_calm {
        // A message takes 20 ms at most.
        now = now + MILLIS(50);
        sim.run_on(&mut dispatcher, now);
        assert!(stations.iter().all(|&station| !drives(&sim, station)), "after {after:?} something moves on");
    }
    // Until the alarm is raised; then nothing of it moves, and nothing moves later.
    while sim.state().exceptions().alarms().next().is_none() {
        now = now + MILLIS(10);
        sim.run_on(&mut dispatcher, now);
    }
    assert!(stations.iter().all(|&station| !drives(&sim, station)), "somebody is asked while something moves");
    if kill {
        for &station in &stations {
            sim.floor.as_mut().expect("real stations").kill(station);
        }
        now = now + MILLIS(300);
        sim.run_on(&mut dispatcher, now);
        for &station in &stations {
            sim.floor.as_mut().expect("real stations").restart(station).expect("it compiles");
        }
    }
    let before = positions(of, &sim);
    now = now + Duration::from_secs(60);
    sim.run_on(&mut dispatcher, now);
    assert_eq!(positions(of, &sim), before, "what was stopped stays where it was");

    // What the machine holds already stays there; else people lead all back to where they began.
    let is_held =
        stations.iter().any(|&id| of_machines.contains(&id) && rest(&sim, id).is_some_and(|at| Some(at) != open));
    let (button, word) = match is_held {
        true => (PanelCommand::Advance(true), "as-done"),
        false => (PanelCommand::Retract(true), "as-before"),
    };
    let floor = sim.floor.as_mut().expect("real stations");
    floor.mode(ControlMode::Manual);
    for &station in stations.iter().rev() {
        now = now.max(floor.lead(station, button));
    }
    if !is_held {
        let (_, at) = floor.plant().parts().next().expect("it is somewhere");
        assert_eq!(at.spot, Some(slot), "it is put back into the slot that it came from");
    }
    floor.mode(ControlMode::Auto);
    now = now + MILLIS(500);
    sim.run_on(&mut dispatcher, now);
    for _ in 0..2 {
        let alarm = sim.state().exceptions().alarms().next().map(|alarm| alarm.id);
        alarm.into_iter().for_each(|alarm| sim.say(&mut dispatcher, &[PlayerInput::Answer { alarm, word }]));
        now = now + MILLIS(2 * SLOW);
        sim.run_on(&mut dispatcher, now);
    }
    assert!(sim.state().firing(firing).is_none(), "after {after:?} it is not closed");
    sim.say(&mut dispatcher, &[PlayerInput::Resource { resource: machine, up: true }]);
    assert_eq!(sim.state().exceptions().is_down(machine), None, "{:?}", sim.events.last());
    sim.run(&mut dispatcher, LONG);
    of.is_done(&sim);
    is_machined(of, &sim, [1, 0]);
}

#[test]
fn alarm_stops_robot_and_machine_wherever_they_are() {
    let of = shipped("workcell-c1", &[1, 0]);
    for seconds in 0..12 {
        run(&of, options(1, 0, Vec::new()), Duration::from_secs(seconds) + MILLIS(130), seconds % 2 == 0);
    }
}

/// Messages are slow, lost and doubled.
#[test]
fn alarm_stops_them_also_where_messages_get_lost() {
    let of = shipped("workcell-c1", &[1, 0]);
    let mut rng = Rng::new(7);
    for seed in 0..20 {
        let delay = (MILLIS(1), MILLIS(rng.within(10, SLOW)));
        let after = MILLIS(rng.within(500, 11_000));
        run(&of, CellSimOptions { delay, ..options(seed, 8, Vec::new()) }, after, rng.below(2) == 0);
    }
}
