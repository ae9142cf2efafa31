//! A plant that is stopped half-way and started again, in real time.

use std::path::Path;
use std::time::Duration;

use linewright_canopen::Manager;
use linewright_fieldbus::bus::{self, Transport};
use linewright_fieldbus::{Bus, Clock, Driver};
use linewright_fieldbus_seam::InputImage;
use linewright_line::{DeviceBus as BusName, Owner, Tick};
use linewright_plant::{PlantOptions, RackPositions};
use linewright_racks::{KEPT_IN, Keeper, KeptPositions, RackOptions, kept_positions, run_plant};
use linewright_testkit::presses::*;
use tokio::sync::oneshot;

const LINE_BUS: &str = "vcan-kept";
const WAIT: Duration = Duration::from_secs(20);

/// Runs the plant until press 1, driven with these outputs, has these inputs; then stops it.
async fn press(buses: &Path, kept: &Path, outputs: u128, inputs: u128) {
    let bus = bus::BusOptions { transport: Transport::Virtual, dir: Some(buses.to_owned()) };
    let clock = Clock::start();
    let options = RackOptions {
        line_bus: LINE_BUS.to_owned(),
        bus: bus.clone(),
        plant: PlantOptions::default(),
        clock,
        run: None,
        mishap: None,
    };
    let (stop, stopped) = oneshot::channel::<()>();
    let dir = kept.to_owned();
    let plant = tokio::spawn(async move {
        let stopped = async {
            let _ = stopped.await;
        };
        run_plant(&line(), &options, Some(&dir), stopped).await
    });
    tokio::time::sleep(Duration::from_millis(50)).await;
    let described = line();
    let devices = described.devices.iter().filter(|device| device.bus == BusName::Line);
    let manager = Manager::new(devices, described.timing).unwrap();
    let mut driver = Driver::new(Bus::open(LINE_BUS, &bus).unwrap(), manager, clock);
    let owner = Owner::Station(PRESS);
    let is = |image: InputImage, bits: u128| image.valid && image.bits == bits;
    let reached = tokio::time::timeout(WAIT, async {
        while !driver.inputs(owner).valid {
            driver.next().await.unwrap();
        }
        driver.set_outputs(owner, outputs);
        while !is(driver.inputs(owner), inputs) {
            driver.next().await.unwrap();
        }
    });
    assert!(reached.await.is_ok(), "inputs {:?}", driver.inputs(owner));
    let _ = stop.send(());
    plant.await.unwrap().unwrap();
}

fn ram(kept: &Path) -> f64 {
    match kept_positions(kept, &line(), Tick::ZERO, PlantOptions::default()) {
        Ok(KeptPositions::Racks(racks)) => racks[&BusName::Line.to_string()].plant().position(PRESS, RAM),
        Ok(KeptPositions::Nothing) => panic!("nothing is kept"),
        Err(why) => panic!("{why}"),
    }
}

#[tokio::test]
async fn a_plant_that_is_stopped_half_way_goes_on_from_there() {
    let (buses, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    press(buses.path(), kept.path(), FORWARD, 0).await;
    let half_way = ram(kept.path());
    assert!(half_way > 0.0 && half_way < 80.0, "{half_way}");
    // Its output is off, and it stands.
    press(buses.path(), kept.path(), 0, 0).await;
    assert_eq!(ram(kept.path()), half_way);
    press(buses.path(), kept.path(), FORWARD, FRONT).await;
    // Its switch is on a little before the end.
    assert!((ram(kept.path()) - 80.0).abs() < 0.1, "{}", ram(kept.path()));
    // Damaged, of another form, of another line: at home, and begun anew; what could not be used is kept. Of more than five the
    // last is replaced.
    let aside = |nth: usize| kept.path().join(format!("{KEPT_IN}.unusable-{nth}"));
    (2..=4).for_each(|nth| std::fs::write(aside(nth), "earlier").unwrap());
    for (nth, (text, why)) in [1, 5, 5].into_iter().zip([
        ("{\"version\":1,", "EOF"),
        ("{\"version\":9,\"line\":\"presses\"}", "it has form 9, this program reads form 1"),
        ("{\"version\":1,\"line\":\"other\",\"buses\":{}}", "they are those of line `other`"),
    ]) {
        std::fs::write(kept.path().join(KEPT_IN), text).unwrap();
        let refused = kept_positions(kept.path(), &line(), Tick::ZERO, PlantOptions::default());
        let refused = refused.map(|_| ()).unwrap_err();
        assert!(refused.contains(why) && refused.contains("begins at home"), "{refused}");
        press(buses.path(), kept.path(), 0, BACK).await;
        assert_eq!(ram(kept.path()), 0.0);
        assert_eq!(std::fs::read_to_string(aside(nth)).unwrap(), text);
    }
    (2..=4).for_each(|nth| assert_eq!(std::fs::read_to_string(aside(nth)).unwrap(), "earlier"));
    assert!(!aside(6).exists());
}

#[test]
fn nothing_is_written_before_every_bus_has_its_positions() {
    let dir = tempfile::tempdir().unwrap();
    let line = line();
    let mut buses: Vec<String> = line.devices.iter().map(|device| device.bus.to_string()).collect();
    buses.sort();
    buses.dedup();
    assert_eq!(buses.len(), 2);
    let (keeper, writer) = Keeper::begin(dir.path(), &line);
    keeper.keep(&buses[0], RackPositions::default());
    std::thread::sleep(Duration::from_millis(400));
    assert!(!dir.path().join(KEPT_IN).exists());
    keeper.keep(&buses[1], RackPositions::default());
    drop(keeper);
    writer.end();
    let text = std::fs::read(dir.path().join(KEPT_IN)).expect("it is written");
    let file: serde_json::Value = serde_json::from_slice(&text).expect("it is whole");
    assert!(file["buses"].as_object().expect("by name").keys().eq(&buses));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_disk_that_hangs_does_not_keep_a_plant_from_ending() {
    let (buses, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    // Nothing reads from it, so a write to it begins and does not end.
    let hangs = kept.path().join(KEPT_IN).with_extension("json.new");
    let made = std::process::Command::new("mkfifo").arg(&hangs).status().unwrap();
    assert!(made.success());
    let (buses, kept) = (buses.path().to_owned(), kept.path().to_owned());
    let (ended, has_ended) = oneshot::channel();
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(press(&buses, &kept, FORWARD, 0));
        let _ = ended.send(());
    });
    tokio::time::timeout(WAIT, has_ended).await.expect("it ends").unwrap();
    // The thread that writes is let go.
    drop(std::fs::File::open(hangs));
}
