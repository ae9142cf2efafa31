//! Interfaces of the kernel that are missing, down or gone, and names that cannot be theirs.

use std::io;

use linewright_fieldbus::bus::means_gone;
use linewright_fieldbus::{Bus, BusError, BusOptions, Transport};

#[tokio::test]
async fn an_interface_that_is_missing_is_an_error_where_the_virtual_bus_was_not_asked_for() {
    let options = BusOptions { transport: Transport::SocketCan, ..BusOptions::default() };
    let error = Bus::open("lw-absent", &options).err().expect("there is no such interface");
    assert!(matches!(&error, BusError::Missing { name, .. } if name == "lw-absent"), "{error:?}");
    let text = error.to_string();
    assert!(text.starts_with("there is no CAN interface lw-absent (") && text.contains("--virtual-bus"), "{text}");
}

#[test]
fn names_that_leave_the_directory_are_refused() {
    for name in ["", ".", "..", "../x", "a/b", "sixteen-letters-", "né"] {
        assert!(matches!(Bus::open(name, &BusOptions::default()), Err(BusError::Name { .. })), "{name}");
    }
}

#[test]
fn an_interface_that_is_down_or_no_more_is_gone_and_a_full_queue_is_not() {
    let gone = |code| means_gone(&io::Error::from_raw_os_error(code)).is_some();
    assert!([libc::ENETDOWN, libc::ENODEV, libc::ENXIO].into_iter().all(gone));
    assert!(![libc::ENOBUFS, libc::EAGAIN, libc::EINTR, libc::ENOMEM].into_iter().any(gone));
    assert_eq!(means_gone(&io::Error::other("no number")), None);
}
