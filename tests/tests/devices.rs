//! Nodes between stations and devices: a gateway that is replaced, and a console that falls silent. Faults of stations'
//! devices are in `fault_matrix`.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_plant::DeviceFault;
use linewright_tests::WatchedLine;

#[test]
fn a_gateway_that_is_replaced_does_not_energise_what_was_decided_for_its_predecessor() {
    // Sooner than a station's image runs out, so every station still has inputs of the gateway before.
    for moment in (0..3560).step_by(40) {
        let mut sim = WatchedLine::in_second_cycle(moment, moment);
        sim.kill_coordinator();
        sim.run_for(Duration::from_millis(5));
        sim.restart_coordinator(true);
        // It listens before it sends; by then every device has missed the manager before and let go by itself.
        sim.run_for(sim.line().timing.heartbeat_timeout + Duration::from_millis(10));
        let moving: Vec<bool> = sim.line().station_ids().map(|id| sim.energised(id) != 0).collect();
        assert!(moving.iter().all(|on| !on), "nothing is on when a new manager begins to send");
        let again = sim.wait_for(Duration::from_secs(3), WatchedLine::anything_energised);
        if again {
            let auto = sim.mode() == Some(ControlMode::Auto);
            panic!("energised again by itself at {moment} ms, auto: {auto}");
        }
    }
}

#[test]
fn a_console_that_falls_silent_is_an_emergency_stop() {
    let mut sim = WatchedLine::in_second_cycle(700, 700);
    sim.fail_device("console io", Some(DeviceFault::Silent));
    sim.run_for(Duration::from_millis(300));
    assert_eq!(sim.mode(), Some(ControlMode::EStop));
    assert!(!sim.anything_energised());
    assert!(sim.ask(ModeCommand::Reset).is_err_and(|refusal| refusal.contains("console")));
    sim.fail_device("console io", None);
    sim.settle();
    sim.order(ModeCommand::Reset);
    sim.bring_back();
    sim.makes_each_part_once(4);
}
