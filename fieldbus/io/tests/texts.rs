//! All texts of the crate in one list. A new variant without a text, or without a place in the list, does not compile.

use std::io;
use std::path::Path;
use std::time::Duration;

use linewright_canopen::NodeId;
use linewright_canopen::sdo::{ObjectId, TransferError, TransferFailure};
use linewright_fieldbus::sdo_client::SdoError;
use linewright_fieldbus::texts::{BusDescription, BusWarning, RequestReply};
use linewright_fieldbus::{BusError, DriverError};
use linewright_testkit::samples::{listed, samples};

fn error() -> io::Error {
    io::ErrorKind::PermissionDenied.into()
}

fn bus_errors() -> Vec<BusError> {
    let name = || "can0".to_owned();
    samples!(BusError {
        BusError::Name { .. } => BusError::Name { name: "a b".to_owned() };
        BusError::Kernel { .. } => BusError::Kernel { name: name(), error: error() };
        BusError::Missing { .. } => BusError::Missing { name: name(), error: error() };
        BusError::Gone { .. } => BusError::Gone { name: name(), error: error() };
        BusError::Virtual { .. } => BusError::Virtual { name: name(), path: "/run/bus".to_owned(), error: error() };
    })
}

fn driver_errors() -> Vec<DriverError> {
    let bus = || "SocketCAN can0".to_owned();
    samples!(DriverError {
        DriverError::Bus(_) => DriverError::Bus(BusError::Name { name: "a b".to_owned() });
        DriverError::AnotherManager { .. } => DriverError::AnotherManager { bus: bus(), has_sent: false },
            DriverError::AnotherManager { bus: bus(), has_sent: true };
    })
}

fn sdo_errors() -> Vec<SdoError> {
    let cause = TransferFailure::Silent { waited: Duration::from_millis(50), done: 0, asked: 3 };
    let error = TransferError { object: ObjectId::new(0x1018, 1), cause };
    samples!(SdoError {
        SdoError::Transfer { .. } => SdoError::Transfer { node: NodeId::new(17).expect("a node id"), error };
        SdoError::Bus(_) => SdoError::Bus(BusError::Name { name: "a b".to_owned() });
    })
}

fn buses() -> Vec<BusDescription<'static>> {
    let (name, dir) = ("can0", Path::new("/run/bus/can0"));
    samples!(BusDescription<'static> {
        BusDescription::SocketCan { .. } => BusDescription::SocketCan { name };
        BusDescription::Virtual { .. } => BusDescription::Virtual { name, dir, has_can: true },
            BusDescription::Virtual { name, dir, has_can: false };
    })
}

#[test]
fn all_texts_of_buses() {
    let replies = samples!(RequestReply {
        RequestReply::ResetOrdered => RequestReply::ResetOrdered;
        RequestReply::NoCanopen => RequestReply::NoCanopen;
    });
    let warnings = samples!(BusWarning {
        BusWarning::NothingReceived => BusWarning::NothingReceived;
        BusWarning::NotReleased => BusWarning::NotReleased;
        BusWarning::NoLastWire => BusWarning::NoLastWire;
    });
    let lists = [
        listed("buses that cannot be used", &bus_errors(), ToString::to_string),
        listed("managers that cannot go on", &driver_errors(), ToString::to_string),
        listed("objects that are not read or written", &sdo_errors(), ToString::to_string),
        listed("buses", &buses(), ToString::to_string),
        listed("replies, behind the request", &replies, |reply| reply.text().to_owned()),
        listed("warnings", &warnings, ToString::to_string),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
