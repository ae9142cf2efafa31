//! A manager of ours against the server of the Python package `pymodbus`: an independent implementation of Modbus TCP.
//!
//! Needs `pip install pymodbus` and a Python named by `LINEWRIGHT_PYTHON`; without it nothing is tested.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use linewright_fieldbus::Clock;
use linewright_fieldbus_seam::{Fieldbus, InputImage};
use linewright_line::{
    Device, DeviceBus, DeviceKind, InputId, Modbus, OutputId, Owner, RegisterValue, Table, WatchdogRegister,
};
use linewright_modbus_tcp::ModbusTcp;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};

const OWNER: Owner = Owner::Console;
const WAIT: Duration = Duration::from_secs(30);

/// A Python with pymodbus, or `None`, visibly.
fn python() -> Option<String> {
    let Ok(python) = std::env::var("LINEWRIGHT_PYTHON") else {
        println!("SKIPPED: no LINEWRIGHT_PYTHON; the comparison with pymodbus needs one that has it");
        return None;
    };
    let found = std::process::Command::new(&python).args(["-c", "import pymodbus.simulator"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        println!(
            "SKIPPED: the Python named by LINEWRIGHT_PYTHON has no pymodbus of version 3.11 or later (pip install pymodbus)"
        );
        return None;
    }
    Some(python)
}

struct Server {
    process: Child,
    orders: ChildStdin,
    said: Lines<BufReader<ChildStdout>>,
    port: u16,
}

impl Server {
    async fn start(python: &str) -> Self {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/server.py");
        let mut command = Command::new(python);
        command.arg(script).env("PYTHONDONTWRITEBYTECODE", "1").kill_on_drop(true);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("Python starts");
        let orders = process.stdin.take().expect("its standard input");
        let mut said = BufReader::new(process.stdout.take().expect("its standard output")).lines();
        let first = said.next_line().await.expect("it speaks").expect("a line");
        let port = first.strip_prefix("port ").and_then(|port| port.parse().ok()).expect("its port");
        Server { process, orders, said, port }
    }

    /// Gives it a command while the bus runs on.
    async fn order(&mut self, bus: &mut ModbusTcp, order: &str) {
        self.orders.write_all(format!("{order}\n").as_bytes()).await.expect("it reads");
        self.until(bus, |line| line == "done").await;
    }

    /// Waits, without the bus, until the server reports that its coils are off.
    async fn turns_its_coils_off(&mut self) {
        let off = async { while self.said.next_line().await.expect("it speaks").expect("a line") != "coils 0" {} };
        tokio::time::timeout(WAIT, off).await.expect("the coils go off");
    }

    /// Lets the bus run until the server prints such a line.
    async fn until(&mut self, bus: &mut ModbusTcp, is: impl Fn(&str) -> bool) {
        let found = async {
            loop {
                tokio::select! {
                    line = self.said.next_line() => {
                        if is(&line.expect("it speaks").expect("a line")) {
                            return;
                        }
                    }
                    news = bus.next() => drop(news.expect("the bus is there")),
                }
            }
        };
        tokio::time::timeout(WAIT, found).await.expect("the server says it");
    }
}

fn device(port: u16, change: impl Fn(&mut Modbus)) -> Device {
    let mut modbus = Modbus {
        address: format!("127.0.0.1:{port}"),
        unit: 1,
        cycle: Duration::from_millis(20),
        timeout: Duration::from_millis(500),
        inputs: (0..3).map(|bit| Some(InputId(bit))).collect(),
        inputs_at: (Table::DiscreteInputs, 0),
        outputs: (0..3).map(|bit| Some(OutputId(bit))).collect(),
        outputs_at: (Table::Coils, 0),
        reads_back: true,
        watchdog: Some(WatchdogRegister { register: 16, timeout: Duration::from_secs(2) }),
        without_watchdog: None,
        expect: vec![RegisterValue { register: 0, value: 0x401 }],
        settings: vec![RegisterValue { register: 17, value: 2000 }],
    };
    change(&mut modbus);
    Device { name: "io".to_owned(), owner: OWNER, bus: DeviceBus::Line, kind: DeviceKind::Modbus(modbus) }
}

fn image(bus: &ModbusTcp) -> InputImage {
    bus.inputs(OWNER).expect("its device is here")
}

async fn until(bus: &mut ModbusTcp, what: &str, is: impl Fn(&ModbusTcp) -> bool) {
    let reached = async {
        while !is(bus) {
            tokio::select! {
                news = bus.next() => drop(news.expect("the bus is there")),
                () = tokio::time::sleep(Duration::from_millis(5)) => {}
            }
        }
    };
    let reached = tokio::time::timeout(WAIT, reached).await;
    assert!(reached.is_ok(), "{what}: {:?}, {}", image(bus), bus.trouble(OWNER).join("; "));
}

#[tokio::test]
async fn a_process_image_goes_round_and_lets_go() {
    let Some(python) = python() else { return };
    let mut server = Server::start(&python).await;
    let mut bus = ModbusTcp::new(&[device(server.port, |_| {})], Clock::start());
    until(&mut bus, "it comes up", |bus| image(bus).valid).await;
    bus.set_outputs(OWNER, 0b101);
    // The inputs read what is written to the coils.
    until(&mut bus, "the image comes back", |bus| image(bus).bits == 0b101).await;
    server.until(&mut bus, |line| line == "register 16 9").await;
    assert_eq!(image(&bus).losses, 0);
    bus.set_outputs(OWNER, 0b111);
    until(&mut bus, "all on", |bus| image(bus).bits == 0b111).await;
    bus.release_outputs();
    server.turns_its_coils_off().await;
}

#[tokio::test]
async fn the_last_orders_turn_outputs_off_while_the_bus_gets_no_turn() {
    let Some(python) = python() else { return };
    let mut server = Server::start(&python).await;
    let mut bus = ModbusTcp::new(&[device(server.port, |_| {})], Clock::start());
    until(&mut bus, "it comes up", |bus| image(bus).valid).await;
    bus.set_outputs(OWNER, 0b111);
    until(&mut bus, "all on", |bus| image(bus).bits == 0b111).await;
    let last = bus.last_orders();
    std::thread::spawn(last).join().expect("it does not fail");
    server.turns_its_coils_off().await;
}

#[tokio::test]
async fn a_server_that_is_slow_refuses_or_is_gone_is_lost_by_name_and_comes_back() {
    let Some(python) = python() else { return };
    let mut server = Server::start(&python).await;
    let mut bus = ModbusTcp::new(&[device(server.port, |_| {})], Clock::start());
    until(&mut bus, "it comes up", |bus| image(bus).valid).await;
    server.order(&mut bus, "slow 50").await;
    let is_slow = |bus: &ModbusTcp| bus.diagnoses()[0].message.starts_with("operational, but slow");
    until(&mut bus, "it is slow", is_slow).await;
    assert!(image(&bus).valid);
    server.order(&mut bus, "slow 2000").await;
    until(&mut bus, "no answer in time", |bus| bus.trouble(OWNER).join("").contains("no answer within 500 ms")).await;
    server.order(&mut bus, "ok").await;
    until(&mut bus, "it is back", |bus| image(bus).valid).await;
    server.order(&mut bus, "refuse 4").await;
    let refused = "device failure (exception 4)";
    until(&mut bus, "it refuses", |bus| bus.trouble(OWNER).join("").contains(refused)).await;
    server.order(&mut bus, "ok").await;
    until(&mut bus, "it is back", |bus| image(bus).valid).await;
    assert_eq!(image(&bus).losses, 2);
    server.process.kill().await.expect("it ends");
    until(&mut bus, "it is gone", |bus| bus.trouble(OWNER).join("").contains("no connection: ")).await;
    let trouble = bus.trouble(OWNER).join("");
    assert!(trouble.starts_with(&format!("io (127.0.0.1:{} unit 1): ", server.port)), "{trouble}");
}

#[tokio::test]
async fn a_wrong_register_map_is_said_to_be_one() {
    let Some(python) = python() else { return };
    let server = Server::start(&python).await;
    type Wrong = (fn(&mut Modbus), &'static str);
    let wrongs: [Wrong; 4] = [
        (
            |modbus| modbus.inputs_at.1 = 100,
            "wrong register map: reading 3 discrete inputs from 100 is refused: illegal",
        ),
        (
            |modbus| modbus.outputs_at.1 = 100,
            "wrong register map: writing 3 coils from 100 is refused: illegal data address",
        ),
        (|modbus| modbus.expect[0].value = 5, "another device: holding register 0 is 1025, expected 5"),
        (|modbus| modbus.unit = 9, "unit 9): "),
    ];
    for (change, expected) in wrongs {
        let mut bus = ModbusTcp::new(&[device(server.port, change)], Clock::start());
        until(&mut bus, expected, |bus| {
            let trouble = bus.trouble(OWNER).join("");
            trouble.contains(expected) && trouble.contains("tried again")
        })
        .await;
        assert_eq!(image(&bus).losses, 0, "it never was operational");
    }
}
