//! Devices in Modbus: what is read, and rules between two of them.

use std::time::Duration;

use linewright_line::{
    InputId, Modbus, OutputId, Owner, RegisterValue, StationId, Table, TransferLine, WatchdogRegister, parse,
};

pub const DEVICE: &str = r#"[[device]]
name = "clamp 1 io"
kind = "modbus"
station = "clamp_1"
inputs = ["LS_open", "LS_closed", "low_pressure", "", "", "SS_manual", "PB_advance", "PB_return"]
outputs = ["open", "close", "lamp_clamp"]

[device.modbus]
address = "10.0.0.5:502"
unit = 7
cycle_ms = 10
timeout_ms = 80
inputs = { table = "input_registers", first = 20 }
outputs = { table = "holding_registers", first = 30 }
read_back = true
watchdog = { register = 40, timeout_ms = 200 }
expect = [{ register = 0, value = 1025 }]
settings = [{ register = 41, value = 200 }]
"#;

/// The shipped line with this device for its clamp.
pub fn line(device: &str) -> String {
    let text = TransferLine::default().text();
    let start = text.find("[[device]]\nname = \"clamp 1 io\"").expect("the clamp's device");
    let end = start + 1 + text[start + 1..].find("[[device]]").expect("another one");
    format!("{}{device}\n{}", &text[..start], &text[end..])
}

fn modbus(device: &str) -> Modbus {
    match parse("line.toml", &line(device)) {
        Ok(parsed) => parsed.line.devices.iter().find_map(|device| device.modbus().cloned()).expect("one in Modbus"),
        Err(problems) => panic!("{problems:#}"),
    }
}

#[test]
fn a_device_in_modbus_is_read_with_all_it_says() {
    let expected = Modbus {
        address: "10.0.0.5:502".to_owned(),
        unit: 7,
        cycle: Duration::from_millis(10),
        timeout: Duration::from_millis(80),
        inputs: [Some(0), Some(1), Some(2), None, None, Some(3), Some(4), Some(5)].map(|i| i.map(InputId)).to_vec(),
        inputs_at: (Table::InputRegisters, 20),
        outputs: (0..3).map(|output| Some(OutputId(output))).collect(),
        outputs_at: (Table::HoldingRegisters, 30),
        reads_back: true,
        watchdog: Some(WatchdogRegister { register: 40, timeout: Duration::from_millis(200) }),
        without_watchdog: None,
        expect: vec![RegisterValue { register: 0, value: 1025 }],
        settings: vec![RegisterValue { register: 41, value: 200 }],
    };
    assert_eq!(modbus(DEVICE), expected);
    let end = DEVICE.find("unit").expect("its unit");
    let short = modbus(&format!("{}without_watchdog = \"a relay\"\n", &DEVICE[..end]));
    assert_eq!((short.unit, short.cycle.as_millis(), short.timeout.as_millis()), (1, 20, 100));
    assert_eq!((short.inputs_at, short.outputs_at), ((Table::DiscreteInputs, 0), (Table::Coils, 0)));
    let line = parse("line.toml", &line(DEVICE)).expect("parses").line;
    let clamp = line.station_named("clamp_1").expect("it is there");
    assert_ne!(clamp, StationId(0));
    assert_eq!(
        line.input_text(Owner::Station(clamp), InputId(1)),
        "LS_closed (clamp 1 io, 10.0.0.5:502 unit 7, input register 20 bit 1)"
    );
}

#[test]
fn a_device_in_modbus_has_its_table() {
    let head = &DEVICE[..DEVICE.find("\n[device.modbus]").expect("its table") + 1];
    let problems = parse("line.toml", &line(head)).expect_err("its table is missing");
    let said: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
    assert!(said.contains(&"a device of kind `modbus` needs a `modbus` table"), "{said:?}");
}

/// A second device at the same server, of another station.
fn other_device() -> String {
    let other = DEVICE.replace("clamp 1 io", "other").replace("clamp_1", "mill_1");
    let other = other.replace("inputs = [", "inputs = []\n# [");
    other.replace("outputs = [\"open\", \"close\", \"lamp_clamp\"]", "outputs = [\"extra\"]")
}

#[test]
fn two_devices_do_not_write_the_same_outputs() {
    let other = other_device();
    let text = line(&format!("{DEVICE}\n{other}"));
    let problems = parse("line.toml", &text).expect_err("they overlap");
    let said: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
    assert!(said.contains(&"two devices write the same holding registers there"), "{said:?}");
    let apart = text.replacen("first = 30", "first = 31", 1);
    if let Err(problems) = parse("line.toml", &apart) {
        assert!(problems.iter().all(|problem| !problem.message.contains("two devices")), "{problems:#}");
    }
}

#[test]
fn a_watchdog_register_is_written_by_one_device_alone() {
    let other = other_device();
    let other = other.replace("first = 30", "first = 31");
    let said = |other: &str| {
        let problems = parse("line.toml", &line(&format!("{DEVICE}\n{other}"))).expect_err("they overlap");
        problems.iter().map(|problem| problem.message.clone()).collect::<Vec<_>>()
    };
    // The same watchdog would be written for both: while one node hangs, the other keeps its outputs on.
    assert!(
        said(&other).iter().any(|text| text == "the watchdog and the watchdog share register 40"),
        "{:?}",
        said(&other)
    );
    let within = other.replace("register = 40", "register = 30");
    assert!(
        said(&within).iter().any(|text| text == "the watchdog and outputs share register 30"),
        "{:?}",
        said(&within)
    );
}

#[test]
fn an_address_has_a_host_and_a_port() {
    let with = |address: &str| DEVICE.replace("10.0.0.5:502", address);
    for address in ["192.168.1.20:502", "press-io:1502", "[::1]:502"] {
        assert_eq!(modbus(&with(address)).address, address);
    }
    for address in ["", ":", "host", "host:", ":502", "host:0", "host:65536", "host:+5", "a b:502", "::1:502", "[]:5"] {
        let problems = parse("line.toml", &line(&with(address))).expect_err(address);
        assert!(problems.iter().any(|problem| problem.message.contains("is no address")), "{address}: {problems:#}");
    }
}
