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
    /// `%IX1.3`, `%I1.3`, `I 1.3`, also in small letters and with the German `E` and `A`; or as messages have it,
    /// `6000h:02 bit 3` and `6200h:02 bit 3`.
    pub fn read(text: &str) -> Option<Self> {
        let (direction, byte, bit) = of_messages(text).or_else(|| counted(text))?;
        (bit < 8 && byte < BITS_MAX / 8).then_some(BitAddress { direction, bit: 8 * byte + bit })
    }
}

/// `6000h:02 bit 3`: direction, byte and bit.
fn of_messages(text: &str) -> Option<(IoDirection, usize, usize)> {
    let text = text.trim().to_ascii_uppercase();
    let (object, bit) = text.split_once(" BIT ")?;
    let (index, sub) = object.split_once("H:")?;
    let direction = match index {
        "6000" => IoDirection::Input,
        "6200" => IoDirection::Output,
        _ => return None,
    };
    Some((direction, number(sub, 16, 2)?.checked_sub(1)?, number(bit, 10, 1)?))
}

/// `%IX1.3` as it is counted through a controller, with any byte: direction, byte and bit.
pub(super) fn counted(text: &str) -> Option<(IoDirection, usize, usize)> {
    let (direction, rest) = area(text)?;
    let rest = rest.strip_prefix('X').unwrap_or(&rest).trim_start();
    let (byte, bit) = rest.split_once('.')?;
    let bit = number(bit, 10, 1).filter(|bit| *bit < 8)?;
    Some((direction, number(byte, 10, 5)?, bit))
}

/// `%I4` or `%Q4`: direction and byte.
pub(super) fn byte(text: &str) -> Option<(IoDirection, usize)> {
    let (direction, rest) = area(text)?;
    Some((direction, number(&rest, 10, 5)?))
}

/// Inputs or outputs, and the rest of the address in capitals.
pub(super) fn area(text: &str) -> Option<(IoDirection, String)> {
    let text = text.trim().to_ascii_uppercase();
    let text = text.strip_prefix('%').unwrap_or(&text);
    let direction = match text.chars().next()? {
        'I' | 'E' => IoDirection::Input,
        'Q' | 'A' => IoDirection::Output,
        _ => return None,
    };
    Some((direction, text[1..].trim_start().to_owned()))
}

/// Digits alone, so many at most: no sign.
pub(super) fn number(digits: &str, radix: u32, most: usize) -> Option<usize> {
    let plain = (1..=most).contains(&digits.len()) && digits.chars().all(|digit| digit.is_digit(radix));
    plain.then(|| usize::from_str_radix(digits, radix).ok())?
}
