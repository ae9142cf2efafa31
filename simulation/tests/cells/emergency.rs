//! The loading whose grasp fails, with a rule that puts its stations into emergency stop: they stand at once while the others
//! work on, over restarts of theirs and of the coordinator, until they are reset and led back by hand.

use std::time::Duration;

use linewright_coordinator_cell::{ActivityPhase, PlayerInput};
use linewright_line::net::ControlMode;
use linewright_line::{Owner, StationId, Tick};
use linewright_plant::MotionFault;
use linewright_simulation::cell::CellSim;
use linewright_station_logic::PanelCommand;

use super::{LONG, dispatcher, grasps, is_machined, options, shipped_but};

const MILLIS: fn(u64) -> Duration = Duration::from_millis;

fn mode(sim: &CellSim, station: StationId) -> ControlMode {
    sim.floor.as_ref().expect("real stations").controller(station).mode()
}

#[test]
fn the_stations_of_a_failed_loading_go_into_emergency_stop_and_the_others_work_on() {
    let stopping = |text: String| text.replace("retries = 2", "retries = 2\nemergency_stop = [\"*\"]");
    let of = shipped_but("workcell-c1", &[1, 1], stopping);
    for crash in [false, true] {
        let mut sim = of.sim(options(1, 0, Vec::new()), 0.0);
        let mut dispatcher = dispatcher(&of.cell, &of.table);
        let robot = of.line.station_named("robot").expect("there");
        // The first part that goes to M1 or M2 is missed.
        grasps(&of, &mut sim, Some(MotionFault::Miss));
        let mut now = Tick::ZERO;
        let firing = loop {
            now = now + MILLIS(10);
            sim.run_on(&mut dispatcher, now);
            if let Some(failed) = sim.state().firings().find(|of| of.phase != ActivityPhase::Running) {
                break failed.clone();
            }
            assert!(now < Tick::from_millis(300_000), "nothing has failed");
        };
        let stations: Vec<StationId> = firing.orders.iter().map(|order| order.station).collect();
        let others: Vec<StationId> = of.line.station_ids().filter(|id| !stations.contains(id)).collect();
        for &station in &stations {
            assert_eq!(mode(&sim, station), ControlMode::EStop, "at once");
            assert_eq!(sim.floor.as_ref().expect("real").plant().outputs(Owner::Station(station)), 0);
        }
        assert!(others.iter().all(|&station| mode(&sim, station) == ControlMode::Auto));

        // Everything is started again, and it still holds.
        if crash {
            sim.options.crash_at = vec![sim.steps];
            for &station in &stations {
                sim.floor.as_mut().expect("real stations").kill(station);
            }
        }
        now = now + MILLIS(500);
        sim.run_on(&mut dispatcher, now);
        if crash {
            for &station in &stations {
                sim.floor.as_mut().expect("real stations").restart(station).expect("it compiles");
            }
        }
        now = now + Duration::from_secs(60);
        sim.run_on(&mut dispatcher, now);
        assert_eq!(sim.lives, 1 + usize::from(crash));
        assert!(stations.iter().all(|&station| mode(&sim, station) == ControlMode::EStop));
        let alarm = sim.state().exceptions().alarms().next().cloned().expect("somebody is asked");
        assert!(alarm.text.contains("robot: in emergency stop"), "{}", alarm.text);

        // Not even manual leads out before the reset.
        let floor = sim.floor.as_mut().expect("real stations");
        floor.mode(ControlMode::Manual);
        assert_eq!(floor.controller(robot).mode(), ControlMode::EStop);
        for &station in &stations {
            sim.say(&mut dispatcher, &[PlayerInput::Reset(station)]);
            assert_eq!(mode(&sim, station), ControlMode::Manual, "{:?}", sim.events.last());
        }
        grasps(&of, &mut sim, None);
        let floor = sim.floor.as_mut().expect("real stations");
        for &station in &stations {
            now = now.max(floor.lead(station, PanelCommand::Retract(true)));
        }
        floor.mode(ControlMode::Auto);
        now = now + MILLIS(500);
        sim.run_on(&mut dispatcher, now);
        sim.say(&mut dispatcher, &[PlayerInput::Answer { alarm: alarm.id, word: "in-store" }]);
        now = now + Duration::from_secs(1);
        sim.run_on(&mut dispatcher, now);
        let down: Vec<_> = sim.state().exceptions().down().map(|(id, _)| id).collect();
        assert_eq!(down.len(), stations.len(), "the resources are left out until somebody says that they are up");
        for resource in down {
            sim.say(&mut dispatcher, &[PlayerInput::Resource { resource, up: true }]);
        }
        assert_eq!(sim.state().exceptions().down().len(), 0, "{:?}", sim.events.last());
        sim.run(&mut dispatcher, LONG);
        of.is_done(&sim);
        is_machined(&of, &sim, [1, 1]);
    }
}
