//! The field buses of a node: each kind is opened by its own crate. Another kind gets a line here.

use linewright_fieldbus::{CanFieldbus, Clock, OpenError, Options, is_on_can};
use linewright_fieldbus_seam::{Fieldbus, Joined};
use linewright_line::{Device, Timing};

/// Opens the buses that carry these devices. `interface` is the CAN bus, which is there as well where no device is.
///
/// # Errors
/// When one is not to be had, or the devices cannot share it.
pub fn open_buses<'a>(
    devices: impl IntoIterator<Item = &'a Device>,
    interface: &str,
    options: &Options,
    timing: Timing,
    clock: Clock,
) -> Result<Joined, OpenError> {
    let devices: Vec<Device> = devices.into_iter().cloned().collect();
    let owners: Vec<_> = devices.iter().map(|device| device.owner).collect();
    let (on_can, _): (Vec<Device>, Vec<Device>) = devices.into_iter().partition(is_on_can);
    let mut buses: Vec<Box<dyn Fieldbus>> = Vec::new();
    buses.push(Box::new(CanFieldbus::open(interface, options, on_can, timing, clock)?));
    Ok(Joined::new(buses, owners))
}
