//! All texts of the running plant in one list. A new variant without a text, or without a place in the list, does not
//! compile.

use std::io;
use std::path::Path;
use std::time::Duration;

use linewright_fieldbus::BusError;
use linewright_plant::PositionsMisfit;
use linewright_racks::texts::{ModbusFaultError, PlantNews, UnusablePositions};
use linewright_racks::{PlantError, Served};
use linewright_testkit::samples::{listed, samples};

const ADDRESS: &str = "127.0.0.1:1502";

fn errors() -> Vec<PlantError> {
    let taken = |by| PlantError::ModbusTaken { address: ADDRESS.to_owned(), by };
    samples!(PlantError {
        PlantError::Bus(_) => PlantError::Bus(BusError::Name { name: "a b".to_owned() });
        PlantError::Modbus { .. } =>
            PlantError::Modbus { address: "10.0.0.9:502".to_owned(), error: io::ErrorKind::AddrNotAvailable.into() };
        PlantError::ModbusTaken { .. } => taken(Some(Served::Simulated { run: Some("line `demo`".to_owned()) })),
            taken(Some(Served::Simulated { run: None })), taken(Some(Served::Other)), taken(None);
    })
}

fn unusable() -> Vec<UnusablePositions> {
    samples!(UnusablePositions {
        UnusablePositions::Unreadable(_) => UnusablePositions::Unreadable("permission denied".to_owned());
        UnusablePositions::Version(_) => UnusablePositions::Version(9);
        UnusablePositions::OtherLine(_) => UnusablePositions::OtherLine("other".to_owned());
        UnusablePositions::OtherBuses => UnusablePositions::OtherBuses;
        UnusablePositions::Misfit(_) => UnusablePositions::Misfit(PositionsMisfit("there is no `ram`".to_owned()));
    })
}

fn faults() -> Vec<ModbusFaultError<'static>> {
    let (device, address) = ("io", ADDRESS);
    let why = || "connection refused".to_owned();
    samples!(ModbusFaultError<'static> {
        ModbusFaultError::NoSuchFault { .. } => ModbusFaultError::NoSuchFault { device, address };
        ModbusFaultError::Refused { .. } =>
            ModbusFaultError::Refused { device, address, why: "Illegal function".to_owned() };
        ModbusFaultError::Unreachable { .. } => ModbusFaultError::Unreachable { address, why: why() };
        ModbusFaultError::Unanswered { .. } =>
            ModbusFaultError::Unanswered { address, within: Duration::from_secs(2) };
    })
}

fn news() -> Vec<PlantNews<'static>> {
    let path = Path::new("state/plant.json");
    samples!(PlantNews<'static> {
        PlantNews::Resumed { .. } => PlantNews::Resumed { path };
        PlantNews::NotKept { .. } => PlantNews::NotKept { path, why: "disk full".to_owned() };
        PlantNews::ServerEnded { .. } =>
            PlantNews::ServerEnded { address: ADDRESS, why: "connection reset".to_owned() };
        PlantNews::Mishap { .. } => PlantNews::Mishap { what: "gripper `robot.hand` has left without its part".to_owned() };
    })
}

#[test]
fn all_texts_of_a_running_plant() {
    let path = Path::new("state/plant.json");
    let lists = [
        listed("errors", &errors(), ToString::to_string),
        listed("kept positions", &unusable(), |why| why.text(path)),
        listed("faults of Modbus devices", &faults(), ToString::to_string),
        listed("log", &news(), ToString::to_string),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
