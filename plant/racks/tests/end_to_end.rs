//! A manager drives the plant over a virtual bus, in real time.

use std::future::pending;
use std::time::Duration;

use linewright_canopen::{BusEvent, Manager};
use linewright_fieldbus::bus::{self, Transport};
use linewright_fieldbus::{Bus, Clock, Driver};
use linewright_fieldbus_seam::InputImage;
use linewright_line::{DeviceBus as BusName, Line, Owner};
use linewright_plant::PlantOptions;
use linewright_racks::{RackOptions, run_plant};
use linewright_testkit::presses::*;

const LINE_BUS: &str = "vcan-line";
const WAIT: Duration = Duration::from_secs(20);

struct RackBench {
    _dir: tempfile::TempDir,
    bus: bus::BusOptions,
    line: Line,
    clock: Clock,
    plant: tokio::task::JoinHandle<()>,
}

impl RackBench {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let bus = bus::BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) };
        let clock = Clock::start();
        let plant = PlantOptions::default();
        let options =
            RackOptions { line_bus: LINE_BUS.to_owned(), bus: bus.clone(), plant, clock, run: None, mishap: None };
        let plant = tokio::spawn(async move { run_plant(&line(), &options, None, pending()).await.unwrap() });
        RackBench { _dir: dir, bus, line: line(), clock, plant }
    }

    fn driver(&self, on: BusName, interface: &str) -> Driver {
        let devices = self.line.devices.iter().filter(|d| d.bus == on);
        let manager = Manager::new(devices, self.line.timing).unwrap();
        Driver::new(Bus::open(interface, &self.bus).unwrap(), manager, self.clock)
    }
}

/// Runs the driver until the inputs are as wanted; returns the events on the way.
async fn until(driver: &mut Driver, owner: Owner, wanted: impl Fn(InputImage) -> bool) -> Vec<BusEvent> {
    let mut seen = Vec::new();
    let reached = tokio::time::timeout(WAIT, async {
        while !wanted(driver.inputs(owner)) {
            seen.extend(driver.next().await.expect("nobody else is there"));
        }
    });
    if reached.await.is_err() {
        panic!("never reached; inputs {:?}, events {seen:?}", driver.inputs(owner));
    }
    seen
}

fn valid(bits: u128) -> impl Fn(InputImage) -> bool {
    move |inputs| inputs.valid && inputs.bits == bits
}

#[tokio::test]
async fn a_manager_drives_a_motion_and_sees_the_limit_switch() {
    let bench = RackBench::new();
    // Both buses at once: the coordinator's, with the first press and the console, and the second press's own.
    let mut line = bench.driver(BusName::Line, LINE_BUS);
    let mut own = bench.driver(BusName::Own("press2".to_owned()), "press2");
    for (driver, station) in [(&mut line, PRESS), (&mut own, OTHER)] {
        let owner = Owner::Station(station);
        until(driver, owner, valid(BACK)).await;
        let start = bench.clock.now();
        driver.set_outputs(owner, FORWARD);
        until(driver, owner, valid(FRONT)).await;
        let took = bench.clock.now().since(start);
        assert!(took >= FORWARD_TIME.mul_f64(0.99), "{took:?}");
        driver.set_outputs(owner, RETURN);
        until(driver, owner, valid(BACK)).await;
        driver.release_outputs();
    }
    bench.plant.abort();
}
