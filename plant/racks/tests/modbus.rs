//! A Modbus manager drives the simulated plant over TCP, in real time; and a foreign client does.

use std::future::pending;
use std::process::Command;
use std::time::Duration;

use linewright_fieldbus::Clock;
use linewright_fieldbus::bus::{self, Transport};
use linewright_fieldbus_seam::{Fieldbus, InputImage};
use linewright_line::{
    Device, DeviceBus as BusName, DeviceKind, Line, Modbus, Owner, RegisterValue, Table, WatchdogRegister,
};
use linewright_modbus_tcp::ModbusTcp;
use linewright_plant::PlantOptions;
use linewright_racks::{RackOptions, Served, are_served, can_be_served, run_plant, served_at};
use linewright_testkit::presses::*;
use tokio_modbus::client::{Context, Reader, tcp};
use tokio_modbus::{ExceptionCode, Slave};

const WAIT: Duration = Duration::from_secs(20);
const OWNER: Owner = Owner::Station(PRESS);

/// The line with its first press in Modbus, on a port of this machine; the others are left out.
fn line_on(port: u16, registers: bool) -> Line {
    let mut line = line();
    line.devices.retain(|device| device.owner == OWNER);
    let device = &mut line.devices[0];
    let table = |bits, words| if registers { words } else { bits };
    device.bus = BusName::Line;
    device.kind = DeviceKind::Modbus(Modbus {
        address: format!("127.0.0.1:{port}"),
        unit: 3,
        cycle: Duration::from_millis(10),
        timeout: Duration::from_millis(1000),
        inputs: device.input_bits().to_vec(),
        inputs_at: (table(Table::DiscreteInputs, Table::InputRegisters), 8),
        outputs: device.output_bits().to_vec(),
        outputs_at: (table(Table::Coils, Table::HoldingRegisters), 4),
        reads_back: true,
        watchdog: Some(WatchdogRegister { register: 100, timeout: Duration::from_millis(1500) }),
        without_watchdog: None,
        expect: vec![RegisterValue { register: 0, value: 0x401 }],
        settings: vec![RegisterValue { register: 101, value: 1500 }],
    });
    line
}

fn free_port() -> u16 {
    let socket = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    socket.local_addr().unwrap().port()
}

struct RackServerBench {
    _dir: tempfile::TempDir,
    clock: Clock,
    port: u16,
    devices: Vec<Device>,
    plant: tokio::task::JoinHandle<()>,
}

impl RackServerBench {
    fn new(registers: bool) -> Self {
        Self::open(registers, free_port(), None)
    }

    fn of_run(port: u16, run: Option<String>) -> Self {
        Self::open(false, port, run)
    }

    fn open(registers: bool, port: u16, run: Option<String>) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let bus = bus::BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) };
        let clock = Clock::start();
        let options = RackOptions {
            line_bus: "no-can".to_owned(),
            bus,
            plant: PlantOptions::default(),
            clock,
            run,
            mishap: None,
        };
        let line = line_on(port, registers);
        let devices = line.devices.clone();
        let plant = tokio::spawn(async move { run_plant(&line, &options, None, pending()).await.unwrap() });
        RackServerBench { _dir: dir, clock, port, devices, plant }
    }

    fn manager(&self) -> ModbusTcp {
        ModbusTcp::new(&self.devices, self.clock)
    }

    async fn client(&self) -> Context {
        for _ in 0..100 {
            if let Ok(client) = tcp::connect_slave(([127, 0, 0, 1], self.port).into(), Slave(3)).await {
                return client;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        panic!("the plant is not there");
    }
}

async fn until(bus: &mut ModbusTcp, wanted: impl Fn(InputImage) -> bool) {
    let reached = async {
        while !bus.inputs(OWNER).is_some_and(&wanted) {
            bus.next().await.expect("the bus is there");
        }
    };
    let reached = tokio::time::timeout(WAIT, reached).await;
    assert!(reached.is_ok(), "{:?}, {:?}", bus.inputs(OWNER), bus.trouble(OWNER));
}

fn valid(bits: u128) -> impl Fn(InputImage) -> bool {
    move |inputs| inputs.valid && inputs.bits == bits
}

#[tokio::test]
async fn a_motion_is_driven_in_coils_and_in_registers() {
    for registers in [false, true] {
        let bench = RackServerBench::new(registers);
        let mut bus = bench.manager();
        until(&mut bus, valid(BACK)).await;
        let start = bench.clock.now();
        bus.set_outputs(OWNER, FORWARD);
        until(&mut bus, valid(FRONT)).await;
        let took = bench.clock.now().since(start);
        assert!(took >= FORWARD_TIME.mul_f64(0.99), "{took:?}");
        bus.set_outputs(OWNER, RETURN);
        until(&mut bus, valid(BACK)).await;
        bench.plant.abort();
    }
}

/// A manager that drives the output, as the device's own coils show.
async fn with_output_on(bench: &RackServerBench, client: &mut Context) -> ModbusTcp {
    let mut bus = bench.manager();
    until(&mut bus, valid(BACK)).await;
    bus.set_outputs(OWNER, RETURN);
    let on = async {
        while client.read_coils(4, 2).await.unwrap().unwrap() != [false, true] {
            let _ = tokio::time::timeout(Duration::from_millis(20), bus.next()).await;
        }
    };
    tokio::time::timeout(WAIT, on).await.expect("the output is on");
    bus
}

#[tokio::test]
async fn outputs_go_off_by_the_watchdog_when_the_manager_is_gone_and_at_once_at_its_end() {
    let bench = RackServerBench::new(false);
    let mut client = bench.client().await;
    let bus = with_output_on(&bench, &mut client).await;
    // Its connection closes without a word.
    drop(bus);
    assert_eq!(client.read_coils(4, 2).await.unwrap().unwrap(), [false, true], "most devices keep it");
    tokio::time::sleep(Duration::from_millis(2000)).await;
    assert_eq!(client.read_coils(4, 2).await.unwrap().unwrap(), [false, false]);

    let mut bus = with_output_on(&bench, &mut client).await;
    let releases = tokio::task::spawn_blocking(move || bus.release_outputs());
    releases.await.unwrap();
    assert_eq!(client.read_coils(4, 2).await.unwrap().unwrap(), [false, false]);
    bench.plant.abort();
}

#[tokio::test]
async fn a_simulated_device_has_the_registers_of_its_description_and_no_others() {
    let bench = RackServerBench::new(true);
    let mut client = bench.client().await;
    assert_eq!(client.read_holding_registers(0, 1).await.unwrap(), Ok(vec![0x401]));
    assert_eq!(client.read_input_registers(8, 1).await.unwrap(), Ok(vec![BACK as u16]));
    let nothing = Err(ExceptionCode::IllegalDataAddress);
    assert_eq!(client.read_holding_registers(1, 1).await.unwrap(), nothing);
    assert_eq!(client.read_input_registers(8, 2).await.unwrap(), nothing);
    assert_eq!(client.read_coils(0, 1).await.unwrap(), Err(ExceptionCode::IllegalDataAddress));
    bench.plant.abort();
}

/// In the objects of a simulated CANopen device: inputs held by 5F01h, the device unplugged by 5F00h:00, all cleared by its 0.
#[tokio::test]
async fn an_input_is_stuck_and_a_device_unplugged_until_it_is_cleared() {
    let bench = RackServerBench::new(false);
    let mut client = bench.client().await;
    let address = format!("127.0.0.1:{}", bench.port);
    let name = line_on(bench.port, false).devices[0].name.clone();
    let fail = async |object, value| linewright_racks::fail_device((&address, 3), &name, object, value).await;
    let before = client.read_discrete_inputs(8, 3).await.unwrap().unwrap();
    assert_eq!(fail((0x5F07, 0), 0).await, Ok(0), "nothing is injected");
    assert_eq!(fail((0x5F01, 1), u32::from(!before[0])).await, Ok(1), "its first input");
    let stuck = client.read_discrete_inputs(8, 3).await.unwrap().unwrap();
    assert_eq!((stuck[0], &stuck[1..]), (!before[0], &before[1..]));
    for (object, value) in [((0x5F01, 200), 1), ((0x5F01, 1), 3), ((0x5F02, 1), 1), ((0x5F00, 0), 4)] {
        let refused = fail(object, value).await.expect_err("there is no such fault");
        assert!(refused.contains("has no such fault"), "{refused}");
    }
    assert_eq!(fail((0x5F00, 0), 1).await, Ok(2), "it is unplugged");
    let silent = tokio::time::timeout(Duration::from_millis(300), client.read_discrete_inputs(8, 3)).await;
    assert!(!matches!(silent, Ok(Ok(Ok(_)))), "it answers nothing");
    assert_eq!(fail((0x5F00, 0), 0).await, Ok(0), "it is plugged in again");
    let mut client = bench.client().await;
    assert_eq!(client.read_discrete_inputs(8, 3).await.unwrap().unwrap(), before);
    let other =
        linewright_racks::fail_device((&address, 3), "another", (0x5F00, 0), 0).await.expect_err("none of that name");
    assert!(other.starts_with("no simulated device answers at 127.0.0.1"), "{other}");
    bench.plant.abort();
}

/// A device that answers each request with its function code alone, and what it got.
async fn other_device() -> (String, std::sync::Arc<std::sync::Mutex<Vec<Vec<u8>>>>) {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let requests = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let got = requests.clone();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut head = [0; 7];
            if stream.read_exact(&mut head).await.is_err() {
                continue;
            }
            let mut pdu = vec![0; usize::from(u16::from_be_bytes([head[4], head[5]])) - 1];
            stream.read_exact(&mut pdu).await.unwrap();
            // Illegal function.
            let answer = [&head[..4], &[0, 3, head[6], pdu[0] | 0x80, 1]].concat();
            got.lock().unwrap().push(pdu);
            stream.write_all(&answer).await.unwrap();
        }
    });
    (address, requests)
}

#[tokio::test]
async fn a_simulated_device_is_distinguished_by_its_identification() {
    let bench = RackServerBench::new(false);
    drop(bench.client().await);
    let address = format!("127.0.0.1:{}", bench.port);
    let alone = Served::Simulated { run: None };
    assert_eq!(served_at((&address, 3)).await, Ok(alone.clone()));
    assert_eq!(alone.other_run("line /a in ROS domain 3"), None, "for all");
    let name = line_on(bench.port, false).devices[0].name.clone();
    linewright_racks::fail_device((&address, 3), &name, (0x5F00, 0), 1).await.expect("it is unplugged");
    assert_eq!(served_at((&address, 3)).await, Ok(alone), "also while it is silent");
    bench.plant.abort();

    let (address, requests) = other_device().await;
    assert_eq!(served_at((&address, 3)).await, Ok(Served::Other));
    assert_eq!(*requests.lock().unwrap(), [[0x2B, 0x0E, 3, 0]], "its identification is read, and no more");
}

#[tokio::test]
async fn a_plant_names_its_run_and_no_other_serves_its_addresses() {
    let own = format!("line /presses in ROS domain 3{}", "é".repeat(200));
    let port = free_port();
    let (line, address) = (line_on(port, false), format!("127.0.0.1:{port}"));
    can_be_served(&line).await.expect("nothing is there yet");
    assert!(!are_served(&line, &own).await);
    let bench = RackServerBench::of_run(port, Some(own.clone()));
    drop(bench.client().await);
    assert!(are_served(&line, &own).await, "its name is cut");
    assert!(!are_served(&line, "line /presses in ROS domain 4").await);
    let served = served_at((&address, 3)).await.expect("it answers");
    assert_eq!(served.other_run(&own), None);
    assert!(
        served
            .other_run("line /presses in ROS domain 4")
            .is_some_and(|run| run.starts_with("line /presses in ROS domain 3"))
    );
    let taken = can_be_served(&line).await.expect_err("another run's").to_string();
    let begins =
        format!("cannot serve the simulated Modbus device at {address}: the plant of line /presses in ROS domain 3");
    assert!(taken.starts_with(&begins) && taken.contains("not separated by ROS domains"), "{taken}");
    bench.plant.abort();
}

/// Reads what is compared, turns the press's output on and off again.
const CLIENT: &str = "
import sys
from pymodbus.client import ModbusTcpClient
client = ModbusTcpClient('127.0.0.1', port=int(sys.argv[1]))
assert client.connect()
assert client.read_holding_registers(0, count=1, device_id=3).registers == [0x401]
assert client.read_discrete_inputs(8, count=3, device_id=3).bits[:3] == [False, True, False]
assert not client.write_coils(4, [True, False], device_id=3).isError()
assert not client.write_coil(5, False, device_id=3).isError()
assert client.read_coils(4, count=2, device_id=3).bits[:2] == [True, False]
assert not client.write_registers(100, [7], device_id=3).isError()
assert client.read_coils(0, count=1, device_id=3).exception_code == 2
";

#[tokio::test]
async fn a_foreign_client_reads_and_writes_the_simulated_device() {
    let Ok(python) = std::env::var("LINEWRIGHT_PYTHON") else {
        println!("SKIPPED: no LINEWRIGHT_PYTHON; the comparison with pymodbus needs one that has it");
        return;
    };
    let found = Command::new(&python).args(["-c", "import pymodbus.simulator"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: the Python named by LINEWRIGHT_PYTHON has no pymodbus (pip install pymodbus)");
        return;
    }
    let bench = RackServerBench::new(false);
    drop(bench.client().await);
    let port = bench.port.to_string();
    let client = tokio::task::spawn_blocking(move || Command::new(python).args(["-c", CLIENT, &port]).output());
    let output = client.await.unwrap().expect("Python starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    bench.plant.abort();
}
