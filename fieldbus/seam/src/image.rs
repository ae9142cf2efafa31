//! The process image of an owner.

use linewright_line::{InputId, OutputId, Tick};

/// An owner's inputs, as its devices last reported them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputImage {
    /// Bit `i` is the owner's input `i`. The last known values where `valid` is false: for display, not for decisions.
    pub bits: u128,
    /// Every device of the owner that may not be lost is operational, was received in time, has sent its inputs since
    /// it last came up, and is not in error. False for an owner without devices on the bus.
    pub valid: bool,
    /// Since when `valid` is what it is.
    pub since: Tick,
    /// When the owner's devices last sent any inputs; [`Tick::ZERO`] if never.
    pub updated: Tick,
    /// Number of times the image has become invalid: a loss shorter than the reader's scan still shows.
    pub losses: u32,
}

impl InputImage {
    /// The image of an owner from which nothing has been received.
    pub const NEVER: InputImage =
        InputImage { bits: 0, valid: false, since: Tick::ZERO, updated: Tick::ZERO, losses: 0 };

    /// The same with what now is, `updated` being when inputs last came. Counts a loss.
    #[must_use]
    pub fn followed_by(self, now: Tick, bits: u128, valid: bool, updated: Option<Tick>) -> Self {
        InputImage {
            bits,
            valid,
            since: if self.valid == valid { self.since } else { now },
            updated: updated.unwrap_or(self.updated),
            losses: self.losses + u32::from(self.valid && !valid),
        }
    }

    /// One owner's images of two buses as one.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        InputImage {
            bits: self.bits | other.bits,
            valid: self.valid && other.valid,
            since: self.since.max(other.since),
            updated: self.updated.max(other.updated),
            losses: self.losses + other.losses,
        }
    }
}

/// The image bits a device's input bits stand for.
pub fn gather(bits: u64, map: &[Option<InputId>]) -> u128 {
    let on = map.iter().take(64).enumerate().filter(|(at, _)| bits >> at & 1 == 1);
    on.fold(0, |image, (_, input)| image | input.map_or(0, InputId::bit))
}

/// The device's output bits for an image. A bit that carries no output of the owner stays off.
pub fn scatter(image: u128, map: &[Option<OutputId>]) -> u64 {
    let on = map.iter().take(64).enumerate().filter(|(_, output)| output.is_some_and(|id| image & id.bit() != 0));
    on.fold(0, |bits, (at, _)| bits | 1 << at)
}
