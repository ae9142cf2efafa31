//! Bringing 32 simulated devices up: side by side, as the manager does, and one after the other.
//!
//! Of each the identity is read (1000h, 1018h:01 to 04), heartbeat and watched node are written (1017h, 1016h:01),
//! errors are read (1001h), and it is started; it is up when it sends its inputs. Python does the same.

use std::thread;
use std::time::{Duration, Instant};

use linewright_canopen::{BusEvent, Manager};
use linewright_fieldbus::{Bus, Clock, Driver};
use linewright_line::{
    Canopen, Console, Device, DeviceBus as BusName, DeviceIdentity, DeviceKind, DeviceSetup, InputId, Io, Line,
    MaterialFlow, OutputId, Owner, Timing,
};
use linewright_plant::PlantOptions;
use linewright_racks::{RackOptions, run_plant};

use super::{Place, block_on, of, python};

const DEVICES: u8 = 32;
const REPEATS: usize = 5;

pub fn run(place: &Place) {
    let plant = place.clone();
    // The thread ends with the program: afterwards only silent devices are on this interface.
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let plant = thread::spawn(move || {
        block_on(async {
            let options = RackOptions {
                line_bus: plant.interface.to_owned(),
                bus: plant.options.clone(),
                plant: PlantOptions::default(),
                clock: Clock::start(),
                run: None,
                mishap: None,
            };
            let line = line();
            let stopped = async {
                _ = stopped.await;
            };
            run_plant(&line, &options, None, stopped).await.expect("the plant runs");
        });
    });
    block_on(async {
        let (mut together, mut in_turn) = (Vec::new(), Vec::new());
        for _ in 0..REPEATS {
            together.push(bring_up(place, vec![line().devices]).await);
            in_turn.push(bring_up(place, line().devices.into_iter().map(|device| vec![device]).collect()).await);
        }
        println!("  {DEVICES} devices side by side:        {}", of(&mut together));
        println!("  {DEVICES} devices one after the other: {}", of(&mut in_turn));
    });
    for _ in 0..3 {
        python(place, &["boot", &DEVICES.to_string()]);
    }
    _ = stop.send(());
    plant.join().expect("the plant ends");
}

/// Brings up these groups of devices, one group after the other, after all of them have been reset.
async fn bring_up(place: &Place, groups: Vec<Vec<Device>>) -> Duration {
    let mut tool = Bus::open(place.interface, &place.options).expect("the bus is there");
    tool.send(&"000#8100".parse().expect("a frame"));
    tokio::time::sleep(Duration::from_millis(300)).await;
    drop(tool);
    let began = Instant::now();
    for group in groups {
        let bus = Bus::open(place.interface, &place.options).expect("the bus is there");
        let mut driver =
            Driver::new(bus, Manager::new(&group, line().timing).expect("their ids are right"), Clock::start());
        let mut up = 0;
        while up < group.len() {
            for event in driver.next().await.expect("nobody else is there") {
                match event {
                    BusEvent::DeviceUp { .. } => up += 1,
                    BusEvent::BootFailed { .. } => println!("  {event}"),
                    _ => {}
                }
            }
        }
    }
    began.elapsed()
}

/// 32 devices with four inputs and four outputs each.
fn line() -> Line {
    let device = |id: u8| {
        let first = u16::from(id - 1) * 4;
        let identity = DeviceIdentity {
            device_type: Some(0x0003_0191),
            vendor: Some(0),
            product: Some(401),
            revision: Some(0x0001_0000),
            serial: Some(id.into()),
        };
        Device {
            name: format!("io {id}"),
            owner: Owner::Console,
            bus: BusName::Line,
            kind: DeviceKind::Io(
                Canopen { node_id: id, setup: DeviceSetup { identity, ..DeviceSetup::default() } },
                Io {
                    inputs: (first..first + 4).map(|bit| Some(InputId(bit))).collect(),
                    outputs: (first..first + 4).map(|bit| Some(OutputId(bit))).collect(),
                    analogue: linewright_line::Analogue::default(),
                },
            ),
        }
    };
    Line {
        name: "bench".to_owned(),
        title: "Bench".to_owned(),
        stations: Vec::new(),
        arrows: Vec::new(),
        conflicts: Vec::new(),
        devices: (1..=DEVICES).map(device).collect(),
        buttons: Vec::new(),
        console: Console::default(),
        // Where a system call takes a tenth of a millisecond, 32 devices in one thread are slow.
        timing: Timing {
            heartbeat: Duration::from_millis(250),
            heartbeat_timeout: Duration::from_secs(2),
            ..Timing::default()
        },
        handling: MaterialFlow::default(),
    }
}
