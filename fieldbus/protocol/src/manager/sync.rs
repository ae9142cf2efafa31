//! SYNC: sent by the manager (CiA 301 §7.2.5), and the settings of devices that wait for it.
//!
//! A device that receives no SYNC keeps its outputs, whatever it is sent, and receives every heartbeat of a live
//! manager: its own watch of the manager does not help. Two things do. The SYNC period is written to it (object 1006h),
//! so that it can take its absence for an error, if it is one of those that do. And its inputs must come with SYNC as
//! well (the description's rules see to that): when they stop, the manager stops the device, by which its outputs take
//! their error values, and brings it up anew. One that loses SYNC again and again has a cause that bringing it up does
//! not mend, and is not worth a boot every few hundred milliseconds: after the third time it stays stopped, and is
//! tried again like one that was refused.

use std::time::Duration;

use linewright_line::{Device, DeviceSetup, Timing};

use crate::sdo::SdoWrite;

/// So many frames of inputs in a row may be missing.
const MISSING: u32 = 3;
/// Most time between inputs that come with SYNC: three frames, and no shorter than a heartbeat may.
pub(super) fn inputs_within(device: &Device, timing: &Timing) -> Option<Duration> {
    let every = device.canopen()?.setup.transmission.inputs_every()?;
    let period = timing.sync?;
    (!device.input_bits().is_empty()).then(|| (period * u32::from(every) * MISSING).max(timing.heartbeat_timeout))
}

/// Settings for SYNC before a device is started.
pub(super) fn settings(setup: &DeviceSetup, timing: &Timing) -> Vec<SdoWrite> {
    let transmission = setup.transmission;
    let mut settings = Vec::new();
    if let Some(period) = timing.sync.filter(|_| transmission.is_synchronous()) {
        let micros = u32::try_from(period.as_micros()).unwrap_or(u32::MAX);
        // A device may lack the SYNC period: its inputs show whether SYNC arrives.
        settings.push(SdoWrite { optional: true, ..SdoWrite::new(0x1006, 0, micros.to_le_bytes()) });
    }
    settings.extend(transmission.outputs.map(|kind| SdoWrite::new(0x1400, 2, [kind])));
    settings.extend(transmission.inputs.map(|kind| SdoWrite::new(0x1800, 2, [kind])));
    settings
}
