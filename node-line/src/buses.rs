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
    let devices: Vec<Device> = devices.into_iter().cloned().collect();
    let owners: Vec<_> = devices.iter().map(|device| device.owner).collect();
    let modbus = ModbusTcp::new(&devices, clock);
    let has_modbus = devices.iter().any(|device| device.modbus().is_some());
    let on_can: Vec<Device> = devices.into_iter().filter(Device::is_on_can).collect();
    let mut buses: Vec<Box<dyn Fieldbus>> = Vec::new();
    if !on_can.is_empty() || !has_modbus {
        buses.push(Box::new(CanFieldbus::open(interface, options, on_can, timing, clock)?));
    }
    if has_modbus {
        buses.push(Box::new(modbus));
    }
    Ok(Joined::new(buses, owners))
}
