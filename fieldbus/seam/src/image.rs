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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_go_where_the_map_says() {
        let map = [Some(InputId(5)), None, Some(InputId(127))];
        assert_eq!(gather(0b111, &map), 1 << 5 | 1 << 127);
        assert_eq!(gather(0b010, &map), 0);
        let map = [Some(OutputId(3)), None, Some(OutputId(0))];
        assert_eq!(scatter(u128::MAX, &map), 0b101);
        assert_eq!(scatter(1, &map), 0b100);
    }

    #[test]
    fn an_image_that_becomes_invalid_counts_a_loss() {
        let at = Tick::from_millis;
        let up = InputImage::NEVER.followed_by(at(5), 1, true, Some(at(5)));
        assert_eq!((up.since, up.losses), (at(5), 0));
        let on = up.followed_by(at(7), 3, true, None);
        assert_eq!((on.bits, on.since, on.updated), (3, at(5), at(5)));
        let lost = on.followed_by(at(9), 3, false, None);
        assert_eq!((lost.since, lost.losses), (at(9), 1));
        assert_eq!(lost.followed_by(at(11), 3, false, None).losses, 1);
    }
}
