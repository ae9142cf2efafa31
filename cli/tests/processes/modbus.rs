//! The shipped line with its clamp in Modbus, by its description alone: it cycles, an emergency stop turns its coils off, and
//! a server that stands still stops the station by the device's name.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::rig::{BUS, Rig, line, send_signal};
use crate::support::{PATIENCE, wait_for};

const UNIT: u8 = 1;

/// The line, its clamp's device at this port. It has longer to answer than on a machine that does nothing else.
fn with_clamp_at(port: u16) -> String {
    let text = line(1.0);
    let before = "name = \"clamp 1 io\"\nstation = \"clamp_1\"\nnode = 0x21\n";
    assert!(text.contains(before));
    let text = text.replace(before, "name = \"clamp 1 io\"\nkind = \"modbus\"\nstation = \"clamp_1\"\n");
    let outputs = "outputs = [\"open\", \"close\", \"lamp_clamp\"]\n";
    assert!(text.contains(outputs));
    let modbus = format!(
        "{outputs}\n[device.modbus]\naddress = \"127.0.0.1:{port}\"\ntimeout_ms = 1000\n\
         watchdog = {{ register = 16, timeout_ms = 3000 }}\n"
    );
    text.replace(outputs, &modbus)
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a port").port()
}

/// The coils `open` and `close`, by a request written by hand.
fn coils(port: u16) -> u8 {
    let mut socket = TcpStream::connect(("127.0.0.1", port)).expect("the simulated device is there");
    socket.set_read_timeout(Some(PATIENCE)).expect("a time-out");
    socket.write_all(&[0, 1, 0, 0, 0, 6, UNIT, 1, 0, 0, 0, 2]).expect("it reads");
    let mut answer = [0; 10];
    socket.read_exact(&mut answer).expect("it answers");
    assert_eq!(answer[..9], [0, 1, 0, 0, 0, 4, UNIT, 1, 1]);
    answer[9]
}

#[test]
fn a_station_runs_in_modbus_stops_at_once_and_names_a_device_that_is_gone() {
    let port = free_port();
    let mut rig = Rig::new(&with_clamp_at(port));
    let operator = rig.in_auto();
    operator.cycles(2);

    // A fault signal that is stuck, by its name.
    let fail = |more: &[&str]| rig.said(&["fail"], &[more, &["--bus", BUS]].concat());
    let said = fail(&["clamp_1", "stuck-on", "--input", "low_pressure"]).expect("the simulated device takes it");
    assert!(said.contains(&format!("clamp 1 io (127.0.0.1:{port} unit 1): low_pressure stuck-on")), "{said}");
    operator.wait("the clamp says why", |heard| heard.station("clamp_1").fault.contains("low_pressure"));
    let refused = fail(&["clamp_1", "lossy"]).expect_err("frames are CAN's");
    assert!(refused.contains("has no such fault"), "{refused}");
    fail(&["clamp_1", "clear"]).expect("all is well");
    operator.recover();
    operator.cycles(1);

    let caught = wait_for(PATIENCE, || coils(port) & 0b10 != 0);
    assert!(caught, "the clamp closes");
    operator.say("estop");
    let off = wait_for(Duration::from_millis(1500), || coils(port) == 0);
    assert!(off, "an emergency stop turns its coils off");
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    operator.say("reset");
    operator.recover();
    operator.cycles(1);

    // Every simulated device stands still; the others are CANopen's.
    let plant = rig.process(&["plant"]).expect("the plant's process");
    send_signal("STOP", plant);
    let by_name = format!("clamp 1 io (127.0.0.1:{port} unit 1): no answer within 1000 ms");
    operator.wait("the station says which device and why", |heard| {
        let state = heard.station("clamp_1");
        !state.devices_valid && state.blocked_by.iter().any(|text| text.contains(&by_name))
    });
    // The console's device is silent too, half a second later: without it the line is in emergency stop.
    operator.wait("the console is lost", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    send_signal("CONT", plant);
    operator.wait("its devices are back", |heard| heard.all(|state| state.devices_valid));
    operator.say("reset");
    operator.recover();
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(0);
}
