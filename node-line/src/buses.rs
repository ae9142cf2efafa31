//! The field buses of a node: each kind is opened by its own crate. Another kind gets a line here.

use linewright_fieldbus::{BusOpenError, BusOptions, CanFieldbus, Clock};
use linewright_fieldbus_seam::{Fieldbus, Joined};
use linewright_line::{Device, Timing};
use linewright_modbus_tcp::ModbusTcp;

/// Opens the buses that carry these devices. `interface` is the CAN bus, which is opened unless all of them are elsewhere.
///
/// # Errors
/// When one is not to be had, or the devices cannot share it.
pub fn open_buses<'a>(
    devices: impl IntoIterator<Item = &'a Device>,
    interface: &str,
    options: &BusOptions,
    timing: Timing,
    clock: Clock,
) -> Result<Joined, BusOpenError> {
    let devices: Vec<&Device> = devices.into_iter().collect();
    let owners = devices.iter().map(|device| device.owner);
    let (on_can, elsewhere): (Vec<&Device>, Vec<&Device>) = devices.iter().partition(|device| device.is_on_can());
    let mut buses: Vec<Box<dyn Fieldbus>> = Vec::new();
    if !on_can.is_empty() || elsewhere.is_empty() {
        let on_can = on_can.into_iter().cloned().collect();
        buses.push(Box::new(CanFieldbus::open(interface, options, on_can, timing, clock)?));
    }
    if !elsewhere.is_empty() {
        buses.push(Box::new(ModbusTcp::new(elsewhere, clock)));
    }
    Ok(Joined::new(buses, owners))
}
