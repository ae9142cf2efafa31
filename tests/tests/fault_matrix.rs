//! Every fault of a device, at every station, at boot and all through the cycle.
//!
//! ```text
//!   fault ──▶ its station faults, reports: device, node, object, cause ──▶ repair ──▶ booted again, by itself
//!             its outputs are off and stay off                               operator recovers, auto
//!             the others finish their operation and start nothing            each part machined once, no node restarted
//! ```
//!
//! The observer has looked after every event: no conflict, no part carried on that was not machined.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{DeviceIdentity, Line, Owner, Reaction, StationId};
use linewright_plant::{DeviceFault, FrameFaults};
use linewright_station_logic::{HappeningKind, StopCause};
use linewright_testkit::cases::cases;
use linewright_tests::{Rng, WatchedLine, moments, transfer_line};

/// Faults, in this order, and the expected description.
struct Case {
    faults: &'static [DeviceFault],
    said: &'static str,
}

const REFUSED_1017: DeviceFault =
    DeviceFault::Abort { object: (0x1017, 0), code: 0x0606_0000, reading: false, writing: true };
const REFUSED_1000: DeviceFault =
    DeviceFault::Abort { object: (0x1000, 0), code: 0x0800_0020, reading: true, writing: false };
const OVERLOAD: DeviceFault = DeviceFault::Emergency { code: 0x2310, register: 0x05 };

const CASES: [Case; 13] = [
    Case { faults: &[DeviceFault::Silent], said: "no heartbeat (1017h) for " },
    Case { faults: &[DeviceFault::NoHeartbeat], said: "no heartbeat (1017h) for " },
    Case { faults: &[DeviceFault::NoBoot], said: "no heartbeat (1017h) for " },
    Case { faults: &[DeviceFault::Reboot], said: "it has booted (boot-up, 7" },
    Case {
        faults: &[DeviceFault::Identity { object: (0x1018, 2), value: 7 }, DeviceFault::Reboot],
        said: "not started: it is another device: its product code (object 1018h:02) is 00000007h, not 0",
    },
    Case {
        faults: &[DeviceFault::Identity { object: (0x1000, 0), value: 0x0001_0191 }, DeviceFault::Reboot],
        said: "not started: it is another device: its device type (object 1000h:00) is 00010191h, not 0",
    },
    Case {
        faults: &[REFUSED_1017, DeviceFault::Reboot],
        said: "not started: it cannot be configured: object 1017h:00: refused: 06060000h (access failed, hardware error)",
    },
    Case {
        faults: &[REFUSED_1000, DeviceFault::Reboot],
        said: "not started: it cannot be identified: object 1000h:00: refused: 08000020h",
    },
    Case { faults: &[OVERLOAD], said: "emergency 2310h (current " },
    Case { faults: &[OVERLOAD, DeviceFault::Reboot], said: "error register 1001h = 05h" },
    Case {
        faults: &[DeviceFault::Emergency { code: 0x8210, register: 0x11 }],
        said: "emergency 8210h (PDO not processed, it is too short), error register 1001h = 11h",
    },
    Case { faults: &[DeviceFault::BusOff { millis: 60 }], said: "emergency 8140h (recovered from bus-off)" },
    Case { faults: &[DeviceFault::BusOff { millis: 900 }], said: "no heartbeat (1017h) for " },
];

/// The shipped line, whose devices must have their identity.
fn line() -> Line {
    let mut line = transfer_line(1.0);
    for device in &mut line.devices {
        let profile = if device.drive().is_some() { (0x0002_0192, 402) } else { (0x0003_0191, 401) };
        let identity =
            DeviceIdentity { device_type: Some(profile.0), product: Some(profile.1), ..DeviceIdentity::default() };
        device.canopen_mut().expect("CANopen").setup.identity = identity;
    }
    line
}

/// Every device of a station: its name, its node id as people read it, its station.
fn devices(line: &Line) -> Vec<(String, String, StationId)> {
    let of_station = line.devices.iter().filter_map(|device| match device.owner {
        Owner::Station(id) => Some((device.name.clone(), format!("(node {:02X}h): ", device.node_id()?), id)),
        Owner::Console => None,
    });
    of_station.collect()
}

/// Whether this is a fault for the device's station: a drive with a fault signal reports it by that.
fn concerns(line: &Line, case: &Case, device: &str) -> bool {
    let reported = line.devices.iter().any(|d| d.name == device && d.on_emergency() == Reaction::Report);
    !reported || !case.faults.iter().any(|fault| matches!(fault, DeviceFault::Emergency { .. }))
}

fn cause(sim: &mut WatchedLine, device: &str, case: &Case) {
    for fault in case.faults {
        sim.fail_device(device, Some(*fault));
    }
}

/// Whether the description names the device and its fault.
fn is_said(sim: &WatchedLine, station: StationId, device: &str, node: &str, words: &str) -> bool {
    let whose = format!("{device} {node}");
    sim.trouble(station).iter().any(|said| said.starts_with(&whose) && said.contains(words))
}

fn in_mid_cycle(case: &Case, (device, node, station): &(String, String, StationId), moment: u64) {
    let mut sim = WatchedLine::new(&line(), moment);
    sim.start_auto();
    sim.run_until_done("clamp_1", "return clamp", 2);
    sim.run_for(Duration::from_millis(moment));
    let (lives, station) = (sim.lives(), *station);
    let begun = sim.log().of(station).count();
    cause(&mut sim, device, case);
    sim.run_until("its station is told", |s| !s.trouble(station).is_empty());
    let was_moving = sim.marking(station).iter().any(|place| place.is_operating());
    let at_once = is_said(&sim, station, device, node, case.said);
    // A station learns of it by its image, the others by the mode; where loss and return fell into one image, by the
    // next.
    sim.wait_for(Duration::from_millis(60), |s| s.mode() != Some(ControlMode::Auto));
    sim.run_for(Duration::from_millis(6));
    if sim.mode() == Some(ControlMode::Auto) {
        // Over before any node could act on it, and nothing was moving that it could have stopped.
        assert!(at_once && !was_moving && sim.trouble(station).is_empty(), "{device} at {moment} ms");
        sim.fail_device(device, None);
        return sim.goes_on(&lives);
    }
    assert_eq!(sim.mode(), Some(ControlMode::StandBy));
    let others: Vec<StationId> = sim.line().station_ids().filter(|&other| other != station).collect();
    let running: Vec<Vec<StationPlace>> = others.iter().map(|&other| sim.marking(other)).collect();

    // A device that receives nothing lets go by itself, up to a heartbeat later than the manager misses it.
    let heartbeat = sim.line().timing.heartbeat + Duration::from_millis(5);
    let off = sim.wait_for(heartbeat, |s| s.energised(station) == 0);
    assert!(off, "{device} has let go at {moment} ms");
    let said = at_once || sim.wait_for(Duration::from_secs(3), |s| is_said(s, station, device, node, case.said));
    assert!(said, "{device}: {:?}", sim.trouble(station));
    let again = sim.wait_for(Duration::from_secs(2), |s| s.energised(station) != 0);
    assert!(!again, "{device}: what was decided before is not energised after it");
    for (&other, before) in others.iter().zip(running) {
        let end = before.iter().map(|p| if p.is_operating() { StationPlace::completed(p.op) } else { *p });
        assert_eq!(sim.marking(other), end.collect::<Vec<_>>(), "the others finish what they do, and start nothing");
        assert_eq!(sim.trouble(other), Vec::<String>::new(), "and nothing is wrong with them");
    }
    let stopped = |(_, event): &(linewright_line::Tick, linewright_station_logic::StationHappening)| {
        matches!(event.what, HappeningKind::Stopped(_, _, StopCause::Devices))
    };
    let stops = sim.log().of(station).skip(begun).filter(stopped).count();
    let completed = !sim.marking(station).iter().any(|place| place.is_incomplete());
    assert!(stops == 1 || !was_moving || completed, "{device}: stopped because of its devices at {moment} ms");

    sim.fail_device(device, None);
    let again = sim.wait_for(Duration::from_secs(1), |s| s.energised(station) != 0);
    assert!(!again, "{device}: a repair moves nothing");
    sim.bring_back();
    sim.goes_on(&lives);
}

/// About every 720 ms; with `LINEWRIGHT_CASES=300` every 240 ms.
fn all_through_the_cycle(of: &[Case]) {
    let line = line();
    let mut played = 0;
    for (nth, case) in of.iter().enumerate() {
        for (at, device) in devices(&line).iter().enumerate().filter(|(_, device)| concerns(&line, case, &device.0)) {
            // Not the same moments for all: together they are closer than each.
            for moment in moments(nth as u64 * 137 + at as u64 * 240, 720) {
                in_mid_cycle(case, device, moment);
                played += 1;
            }
        }
    }
    println!("{played} runs");
}

#[test]
fn lost_in_mid_cycle() {
    all_through_the_cycle(&CASES[..4]);
}

#[test]
fn another_or_refusing_device_in_mid_cycle() {
    all_through_the_cycle(&CASES[4..8]);
}

#[test]
fn in_error_or_off_the_bus_in_mid_cycle() {
    all_through_the_cycle(&CASES[8..]);
}

#[test]
fn at_boot() {
    let line = line();
    for case in &CASES {
        // A passing fault is over before start is given.
        let passes = matches!(case.faults.last(), Some(DeviceFault::BusOff { .. }) | Some(DeviceFault::Reboot))
            && case.faults.len() == 1;
        for (device, node, station) in devices(&line).iter().filter(|device| concerns(&line, case, &device.0)) {
            let mut sim = WatchedLine::new(&line, 1);
            // An emergency is lost on a manager that still listens whether it is alone; with a standing error, what is
            // read at boot is tried by a case of its own.
            if case.said.starts_with("emergency") {
                sim.run_for(sim.line().timing.heartbeat * 5);
            }
            cause(&mut sim, device, case);
            let lives = sim.lives();
            sim.run_for(Duration::from_secs(2));
            if !passes {
                let said = sim.trouble(*station);
                let never = case.said.starts_with("no heartbeat")
                    && said.iter().any(|s| s.contains("(1017h)") || s.contains("1017h)"));
                assert!(never || is_said(&sim, *station, device, node, case.said), "{device}: {said:?}");
                let _ = sim.ask(ModeCommand::Start);
                let refusal = sim.ask(ModeCommand::Auto).expect_err("its devices are not there");
                assert!(!sim.anything_energised(), "{refusal}");
            }
            sim.fail_device(device, None);
            sim.run_until("everything is heard", WatchedLine::all_heard);
            sim.settle();
            if sim.mode() == Some(ControlMode::Home) {
                sim.order(ModeCommand::Start);
            }
            sim.back_to_auto();
            sim.run_until_done("mill_1", "reset main slide", 2);
            assert_eq!(sim.lives(), lives);
        }
    }
}

#[test]
fn the_managers_interface_leaves_the_bus() {
    for (nth, moment) in (0..3560).step_by(120).enumerate() {
        let mut sim = WatchedLine::new(&line(), moment);
        sim.start_auto();
        sim.run_until_done("clamp_1", "return clamp", 2);
        sim.run_for(Duration::from_millis(moment));
        let lives = sim.lives();
        sim.bus_off(true);
        // Shorter and longer than the devices' own patience.
        sim.run_for(Duration::from_millis([20, 120, 190, 400, 3000][nth % 5]));
        for id in sim.line().station_ids() {
            let said = sim.trouble(id);
            assert!(!said.is_empty() && said.iter().all(|s| s.contains("h): the bus is off since ")), "{said:?}");
        }
        sim.bus_off(false);
        sim.run_for(Duration::from_millis(5));
        assert!(!sim.anything_energised(), "everything is let go first, at {moment} ms");
        let again = sim.wait_for(Duration::from_secs(3), WatchedLine::anything_energised);
        assert!(!again, "and nothing moves by itself, at {moment} ms");
        // The console is on that bus too: this may have been an emergency stop.
        sim.bring_back();
        sim.goes_on(&lives);
    }
}

#[test]
fn frames_that_are_lost_or_come_twice() {
    let mut faults = 0;
    for seed in 0..12 {
        let mut sim = WatchedLine::new(&line(), seed);
        let share = [5, 20, 50][seed as usize % 3];
        let disturb = |sim: &mut WatchedLine, share: u16| {
            for device in sim.line().devices.clone() {
                let seed = seed * 1000 + u64::from(device.node_id().expect("CANopen")) + sim.observer().looks();
                let bad = FrameFaults { lost_to: share, lost_from: share, doubled: 2 * share, seed };
                sim.disturb(&device.name, bad);
            }
        };
        disturb(&mut sim, share);
        let lives = sim.lives();
        sim.start_auto();
        for _ in 0..20 {
            let parts = sim.observer().places();
            let went_on = sim.wait_for(Duration::from_secs(8), |s| {
                s.observer().places() > parts || s.mode() != Some(ControlMode::Auto)
            });
            assert!(went_on, "seed {seed}: it stands and nobody says why");
            if sim.mode() != Some(ControlMode::Auto) {
                faults += 1;
                // An operator does not recover a line on a bus like that.
                disturb(&mut sim, 0);
                sim.bring_back();
                disturb(&mut sim, share);
            }
            if parts >= 3 {
                break;
            }
        }
        disturb(&mut sim, 0);
        sim.bring_back();
        sim.goes_on(&lives);
    }
    println!("{faults} times it had to be brought back");
}

/// Any of it, at any moment, several at once; then all is repaired.
#[test]
fn whatever_devices_suffer_the_line_comes_back() {
    for seed in 0..cases(40) {
        let line = line();
        let mut rng = Rng::new(seed);
        let mut sim = WatchedLine::new(&line, seed);
        let lives = sim.lives();
        sim.start_auto();
        let run_in = rng.within(0, 6000);
        sim.run_for(Duration::from_millis(run_in));
        let devices: Vec<String> = line.devices.iter().map(|device| device.name.clone()).collect();
        for _ in 0..rng.within(1, 8) {
            let device = rng.pick(&devices).clone();
            match rng.below(10) {
                0 => sim.bus_off(true),
                1 | 2 => sim.bus_off(false),
                3 => {
                    let share = |rng: &mut Rng| rng.below(300) as u16;
                    let bad = FrameFaults {
                        lost_to: share(&mut rng),
                        lost_from: share(&mut rng),
                        doubled: share(&mut rng),
                        seed,
                    };
                    sim.disturb(&device, bad);
                }
                4 => sim.fail_device(&device, None),
                _ => {
                    let case = rng.below(CASES.len() as u64) as usize;
                    cause(&mut sim, &device, &CASES[case]);
                }
            }
            let pause = *rng.pick(&[1, 50, 300, 2000]);
            let pause = rng.within(0, pause);
            sim.run_for(Duration::from_millis(pause));
        }
        sim.bus_off(false);
        for device in &devices {
            sim.fail_device(device, None);
        }
        sim.run_for(Duration::from_secs(6));
        sim.bring_back();
        sim.goes_on(&lives);
    }
}
