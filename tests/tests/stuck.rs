//! Switches and relays that stay as they are, undetected on the bus: the device is in order, and its inputs or outputs
//! are false. A motion that should end does not, and the operator reads which switch was waited for and its place.
//!
//! A relay that does not open is not among them: no signal shows it. With the motion back both of its outputs are on,
//! which only the wiring can prevent; see `docs/can.md`.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, OpId, OutputId, Owner, StationId};
use linewright_station_logic::{HappeningKind, StopCause};
use linewright_tests::{WatchedLine, moments, transfer_line};

/// Every operation whose signal is on a digital device: the operation, the device, the signal.
fn wired<T>(
    line: &Line,
    signal: impl Fn(&linewright_line::Operation) -> T,
    carries: impl Fn(&linewright_line::Device, &T) -> bool,
) -> Vec<(StationId, OpId, String, T)> {
    let mut all = Vec::new();
    for station in line.station_ids() {
        for (at, operation) in line.station(station).operations.iter().enumerate() {
            let signal = signal(operation);
            let own = line.devices.iter().filter(|device| device.owner == Owner::Station(station));
            if let Some(device) = own.into_iter().find(|device| carries(device, &signal)) {
                all.push((station, OpId::at(at), device.name.clone(), signal));
            }
        }
    }
    all
}

fn switches(line: &Line) -> Vec<(StationId, OpId, String, InputId)> {
    wired(line, |operation| operation.normal.complete, |device, input| device.input_bits().contains(&Some(*input)))
}

fn relays(line: &Line) -> Vec<(StationId, OpId, String, OutputId)> {
    wired(line, |operation| operation.normal.actuator, |device, output| device.output_bits().contains(&Some(*output)))
}

/// Why the operation was stopped last, and what the operator reads of it.
fn last_stop(sim: &WatchedLine, station: StationId) -> Option<(OpId, StopCause, String)> {
    let stops = sim.log().of(station).filter_map(|(_, event)| match event.what {
        HappeningKind::Stopped(op, block, cause) => Some((op, cause, cause.text_of(sim.line(), station, op, block))),
        _ => None,
    });
    stops.last()
}

fn says_where(said: &str, switch: &str, device: &str) -> bool {
    said.contains(&format!("{switch} ({device}, node ")) && said.contains("6000h:")
}

/// Runs in auto until a station stands with an operation that did not end.
fn until_found(sim: &mut WatchedLine, station: StationId) {
    let name = sim.line().station(station).name.clone();
    let is_lost = |s: &WatchedLine| s.controller(station).is_some_and(|c| c.position_lost().is_some());
    sim.run_until("it is found", |s| s.is_incomplete(&name) || is_lost(s));
    sim.run_until("the line stands by", |s| s.mode() == Some(ControlMode::StandBy));
    sim.settle();
    assert_eq!(sim.trouble(station), Vec::<String>::new(), "nothing is wrong with the device, as far as it knows");
    assert!(!sim.anything_energised());
}

fn in_auto(line: &Line, seed: u64) -> WatchedLine {
    let mut sim = WatchedLine::new(line, seed);
    sim.start_auto();
    sim.run_until_done("clamp_1", "return clamp", 2);
    sim.run_for(Duration::from_millis(seed));
    sim
}

#[test]
fn a_switch_that_does_not_close() {
    let line = transfer_line(1.0);
    for (station, _, device, switch) in switches(&line) {
        for moment in moments(0, 600) {
            let mut sim = in_auto(&line, moment);
            let lives = sim.lives();
            let name = line.station(station).inputs[switch.index()].clone();
            sim.wire(Owner::Station(station), &name, Some(false));
            until_found(&mut sim, station);
            // A motion towards it waits in vain; where an axis stands at it, its position is lost.
            let lost = sim.controller(station).and_then(|c| c.position_lost());
            let (found, said) = match last_stop(&sim, station) {
                Some((stopped, StopCause::Watchdog, said)) => {
                    // Others may wait for the same switch.
                    (sim.line().operation((station, stopped)).normal.complete, said)
                }
                stop => {
                    let (_, input) = lost.unwrap_or_else(|| panic!("{device} at {moment} ms: {stop:?}"));
                    (input, sim.fault(station))
                }
            };
            assert_eq!(found, switch, "{device} at {moment} ms: {said}");
            assert!(says_where(&said, &name, &device), "{said}");
            sim.wire(Owner::Station(station), &name, None);
            sim.bring_back();
            sim.goes_on(&lives);
        }
    }
}

#[test]
fn a_switch_that_is_closed_from_the_start() {
    let line = transfer_line(1.0);
    for (station, op, device, switch) in switches(&line) {
        let mut sim = in_auto(&line, 3);
        let lives = sim.lives();
        let name = line.station(station).inputs[switch.index()].clone();
        // Just after it was closed rightly: with the next motion it stays so.
        let cycle = sim.done(station, op) + 1;
        sim.run_until("done", |s| s.done(station, op) >= cycle);
        sim.wire(Owner::Station(station), &name, Some(true));
        until_found(&mut sim, station);
        let (stopped, cause, said) = last_stop(&sim, station).unwrap();
        let waited_for = sim.line().operation((station, stopped)).normal.complete;
        // The next motion either leaves it, and has not arrived while it is on, or is to arrive at it.
        let expected = match waited_for == switch {
            true => StopCause::SwitchStuck,
            false => StopCause::BothSwitchesOn { behind: switch },
        };
        assert_eq!(cause, expected, "{device}: {said}");
        assert!(says_where(&said, &name, &device), "{said}");
        sim.wire(Owner::Station(station), &name, None);
        sim.bring_back();
        sim.goes_on(&lives);
    }
}

#[test]
fn a_relay_that_does_not_close() {
    let line = transfer_line(1.0);
    for (station, op, device, output) in relays(&line) {
        for moment in moments(0, 600) {
            let mut sim = in_auto(&line, moment);
            let lives = sim.lives();
            sim.stick(&device, output, Some(false));
            until_found(&mut sim, station);
            let (stopped, cause, said) = last_stop(&sim, station).unwrap();
            assert_eq!(stopped, op, "{device} at {moment} ms: {said}");
            assert!(matches!(cause, StopCause::Watchdog | StopCause::SwitchStuck), "{said}");
            sim.stick(&device, output, None);
            sim.bring_back();
            sim.goes_on(&lives);
        }
    }
}
