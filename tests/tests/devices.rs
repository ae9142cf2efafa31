//! Devices fall silent, or boot, in the middle of a motion.
//!
//! ```text
//!   station ──outputs──▶ gateway ──▶ manager ══CAN══▶ device ──▶ axis
//!                            ▲                          ✝ silent: 200 ms later lost, its outputs off by itself
//!                            └ an image decided before the loss is never energised after it
//! ```

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_plant::DeviceFault;
use linewright_station_logic::{HappeningKind, StopCause};
use linewright_tests::Sim;

const DEVICES: [(&str, &str); 5] = [
    ("transfer", "transfer io"),
    ("clamp_1", "clamp 1 io"),
    ("mill_1", "mill 1 io"),
    ("mill_1", "mill 1 positioning drive"),
    ("mill_1", "mill 1 main drive"),
];

/// From here on the station's outputs stay off until a person has recovered it.
fn off_until_recovered(sim: &mut Sim, station: &str) {
    let id = sim.id(station);
    let stands = sim.energised(id);
    assert_eq!(stands, 0, "{station} has let go");
    let again = sim.wait_for(Duration::from_secs(3), |s| s.energised(id) != 0);
    assert!(!again, "{station}: what was decided before the loss is not energised after it");
}

fn bring_back(sim: &mut Sim) {
    sim.bring_back();
    sim.run_until_done("mill_1", "reset main slide", 4);
    for part in 1..=3 {
        assert_eq!(sim.observer().machined(1, part), 1, "part {part} is machined once");
    }
}

#[test]
fn a_device_that_falls_silent_at_any_moment() {
    for moment in (0..3560).step_by(60) {
        for (station, device) in DEVICES {
            let mut sim = Sim::in_second_cycle(moment, moment);
            let id = sim.id(station);
            let was_moving = sim.controller(id).is_some_and(|c| c.marking().any(|p| p.is_operating()));
            sim.fail_device(device, Some(DeviceFault::Silent));
            let lost = sim.line().timing.heartbeat_timeout + sim.line().timing.heartbeat + Duration::from_millis(5);
            sim.run_for(lost);
            off_until_recovered(&mut sim, station);
            assert_eq!(sim.mode(), Some(ControlMode::StandBy));
            let stopped =
                sim.log().of(id).any(|(_, e)| matches!(e.what, HappeningKind::Stopped(_, _, StopCause::Devices)));
            assert!(stopped || !was_moving || !sim.is_incomplete(station));
            let refusal = sim.ask(ModeCommand::Auto).expect_err("its devices are lost");
            assert!(refusal.contains(&format!("{station}: I/O devices lost")), "{refusal}");
            sim.fail_device(device, None);
            off_until_recovered(&mut sim, station);
            bring_back(&mut sim);
        }
    }
}

#[test]
fn a_device_that_boots_at_any_moment() {
    for moment in (0..3560).step_by(60) {
        for (station, device) in DEVICES {
            let mut sim = Sim::in_second_cycle(moment, moment);
            sim.fail_device(device, Some(DeviceFault::Reboot));
            sim.run_for(Duration::from_millis(3));
            if sim.mode() == Some(ControlMode::Auto) {
                // Its loss and return fell into one image: the number of losses still shows it.
                sim.run_for(Duration::from_millis(60));
            }
            off_until_recovered(&mut sim, station);
            bring_back(&mut sim);
        }
    }
}

#[test]
fn a_gateway_that_is_replaced_does_not_energise_what_was_decided_for_its_predecessor() {
    // Sooner than a station's image runs out, so every station still speaks of inputs of the gateway before.
    for moment in (0..3560).step_by(40) {
        let mut sim = Sim::in_second_cycle(moment, moment);
        sim.kill_coordinator();
        sim.run_for(Duration::from_millis(5));
        sim.restart_coordinator(true);
        // It listens before it sends; by then every device has missed the manager before and let go by itself.
        sim.run_for(sim.line().timing.heartbeat_timeout + Duration::from_millis(10));
        let moving: Vec<bool> = sim.line().station_ids().map(|id| sim.energised(id) != 0).collect();
        assert!(moving.iter().all(|on| !on), "nothing is on when a new manager begins to send");
        let again = sim.wait_for(Duration::from_secs(3), Sim::anything_energised);
        if again {
            let auto = sim.mode() == Some(ControlMode::Auto);
            panic!("energised again by itself at {moment} ms, auto: {auto}");
        }
    }
}

#[test]
fn a_console_that_falls_silent_is_an_emergency_stop() {
    let mut sim = Sim::in_second_cycle(700, 700);
    sim.fail_device("console io", Some(DeviceFault::Silent));
    sim.run_for(Duration::from_millis(300));
    assert_eq!(sim.mode(), Some(ControlMode::EStop));
    assert!(!sim.anything_energised());
    assert!(sim.ask(ModeCommand::Reset).is_err_and(|refusal| refusal.contains("console")));
    sim.fail_device("console io", None);
    sim.settle();
    sim.order(ModeCommand::Reset);
    bring_back(&mut sim);
}
