//! Bits of a PDO ↔ bits of an owner's process image.

use linewright_line::{InputId, OutputId};

/// The image bits a device's input bits stand for.
pub(super) fn gather(bits: u64, map: &[Option<InputId>]) -> u128 {
    let on = map.iter().take(64).enumerate().filter(|(at, _)| bits >> at & 1 == 1);
    on.fold(0, |image, (_, input)| image | input.map_or(0, InputId::bit))
}

/// The device's output bits for an image. A bit that carries no output of the owner stays off.
pub(super) fn scatter(image: u128, map: &[Option<OutputId>]) -> u64 {
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
}
