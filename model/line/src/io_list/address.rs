//! Address of a bit of a device, as in lists.

use std::fmt;

/// Bits of one device each way.
pub const BITS_MAX: usize = 64;

/// Seen from the controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum IoDirection {
    Input,
    Output,
}

/// A bit of a device: `%IX1.3` is bit 3 of the second byte of its inputs, `%QX0.0` the first bit of its outputs (IEC
/// 61131-3, counted within the device).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BitAddress {
    pub direction: IoDirection,
    /// From 0.
    pub bit: usize,
}

impl fmt::Display for BitAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = match self.direction {
            IoDirection::Input => 'I',
            IoDirection::Output => 'Q',
        };
        write!(f, "%{letter}X{}.{}", self.bit / 8, self.bit % 8)
    }
}

impl BitAddress {
    /// `%IX1.3`, `%I1.3`, also in small letters; or as messages have it, `6000h:02 bit 3` and `6200h:02 bit 3`.
    pub fn read(text: &str) -> Option<Self> {
        let text = text.trim().to_ascii_uppercase();
        let (direction, byte, bit) = match text.strip_prefix('%') {
            Some(iec) => {
                let direction = match iec.chars().next()? {
                    'I' => IoDirection::Input,
                    'Q' => IoDirection::Output,
                    _ => return None,
                };
                let place = iec[1..].strip_prefix('X').unwrap_or(&iec[1..]);
                let (byte, bit) = place.split_once('.')?;
                (direction, number(byte, 10)?, number(bit, 10)?)
            }
            None => {
                let (object, bit) = text.split_once(" BIT ")?;
                let (index, sub) = object.split_once("H:")?;
                let direction = match index {
                    "6000" => IoDirection::Input,
                    "6200" => IoDirection::Output,
                    _ => return None,
                };
                (direction, number(sub, 16)?.checked_sub(1)?, number(bit, 10)?)
            }
        };
        (bit < 8 && byte < BITS_MAX / 8).then_some(BitAddress { direction, bit: 8 * byte + bit })
    }
}

/// Digits alone: no sign.
fn number(digits: &str, radix: u32) -> Option<usize> {
    let plain = (1..=2).contains(&digits.len()) && digits.chars().all(|digit| digit.is_digit(radix));
    plain.then(|| usize::from_str_radix(digits, radix).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_as_they_are_written() {
        for direction in [IoDirection::Input, IoDirection::Output] {
            for bit in 0..BITS_MAX {
                let address = BitAddress { direction, bit };
                assert_eq!(BitAddress::read(&address.to_string()), Some(address));
            }
        }
        assert_eq!(BitAddress { direction: IoDirection::Output, bit: 11 }.to_string(), "%QX1.3");
        for same in ["%IX1.3", "%I1.3", " %ix1.3 ", "6000h:02 bit 3", "%IX01.3"] {
            let address = Some(BitAddress { direction: IoDirection::Input, bit: 11 });
            assert_eq!(BitAddress::read(same), address, "{same}");
        }
        for wrong in
            ["", "%", "%IX", "%IX1", "%IX1.8", "%IX8.0", "%MX0.0", "%IW0", "%IX-1.0", "%IX1.3.4", "6000h:00 bit 0", "é"]
        {
            assert_eq!(BitAddress::read(wrong), None, "{wrong}");
        }
    }
}
