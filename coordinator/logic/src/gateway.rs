//! The gateway's rule for outputs: which image is put on the bus, and for how long.
//!
//! Stations whose devices hang on the coordinator's bus send their output images by message. An image is energised only
//! while it is fresh, comes from the newest life of its station, and was decided on inputs that the same devices still
//! vouch for: outputs decided before a device was lost are not put on after it has come back, because the station may
//! not yet have received that the device started over.

use std::time::Duration;

use linewright_line::{StationId, Tick};

/// An output image as a station sent it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputImage {
    /// Bit `i` is output `i` of the station.
    pub bits: u128,
    /// The station vouches for it.
    pub valid: bool,
    /// Number of losses of devices when the inputs it was decided on were sent.
    pub losses: u64,
    /// Boot id of the station it comes from.
    pub boot_id: u64,
    /// Grows with every change of the station's outputs, in one life.
    pub number: u64,
    /// The newest mode epoch the station had received when it decided it.
    pub mode_epoch: u64,
}

/// Outputs on the bus for a station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AppliedImage {
    /// Bit `i` is output `i` of the station.
    pub bits: u128,
    /// Life and number of the station's image it is; `None` when all is off because no image may be used. Sent with the
    /// inputs: the outputs that were in force when they were taken.
    pub image: Option<(u64, u64)>,
}

#[derive(Clone, Copy, Debug)]
struct HeldImage {
    image: OutputImage,
    until: Tick,
}

/// The output images of all stations behind the gateway.
#[derive(Clone, Debug)]
pub struct Gateway {
    stations: Vec<Option<HeldImage>>,
    stale: Duration,
}

impl Gateway {
    /// A gateway that has received nothing: every output is off. `stale` is how long an image lasts.
    pub fn new(stations: usize, stale: Duration) -> Self {
        Gateway { stations: vec![None; stations], stale }
    }

    /// Takes a newer image of a station.
    pub fn hear(&mut self, now: Tick, station: StationId, image: OutputImage) {
        if let Some(held) = self.stations.get_mut(station.index()) {
            *held = Some(HeldImage { image, until: now + self.stale });
        }
    }

    /// Outputs of a station whose devices have been lost `losses` times: its image, or all off. `since` is the epoch of
    /// the last emergency stop: an image from before it is not energised after it.
    pub fn in_force(&self, now: Tick, station: StationId, losses: u64, since: u64) -> AppliedImage {
        match self.stations.get(station.index()).copied().flatten() {
            Some(HeldImage { image, until })
                if now < until && image.valid && image.losses == losses && image.mode_epoch >= since =>
            {
                AppliedImage { bits: image.bits, image: Some((image.boot_id, image.number)) }
            }
            // No image, an image that has expired, or one decided before a loss or an emergency stop: off is the safe state.
            Some(_) | None => AppliedImage::default(),
        }
    }

    /// Expiry of the next image.
    pub fn next_deadline(&self, now: Tick) -> Option<Tick> {
        self.stations.iter().flatten().map(|held| held.until).filter(|&until| until > now).min()
    }
}
