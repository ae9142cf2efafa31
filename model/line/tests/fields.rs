//! Place of a number in a frame, against walking through its bits one by one.

use linewright_line::{Checksum, Coding, FrameField};
use proptest::prelude::*;

fn field() -> impl Strategy<Value = FrameField> {
    (0u8..64, 1u8..=64, any::<bool>(), any::<bool>()).prop_map(|(start, size, motorola, signed)| FrameField {
        start,
        size,
        motorola,
        coding: if signed { Coding::Signed } else { Coding::Unsigned },
        factor: 1.0,
        offset: 0.0,
    })
}

/// The field's bits from the highest to the lowest, as a DBC file counts them; `None` if it leaves the frame.
fn walk(field: &FrameField, len: u8) -> Option<Vec<u8>> {
    let mut bits = Vec::new();
    let mut at = i32::from(field.start);
    for _ in 0..field.size {
        if at < 0 || at >= i32::from(len) * 8 {
            return None;
        }
        bits.push(at as u8);
        // Motorola: down to bit 0 of a byte, then on with bit 7 of the next.
        at = match field.motorola {
            true if at % 8 == 0 => at + 15,
            true => at - 1,
            false => at + 1,
        };
    }
    if !field.motorola {
        bits.reverse();
    }
    Some(bits)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn bits_lie_where_walking_finds_them(field in field(), data: [u8; 8], bits: u64, len in 0u8..=8) {
        let walked = walk(&field, len);
        prop_assert_eq!(field.fits(len), walked.is_some());
        let Some(walked) = walked else { return Ok(()) };
        let slow = walked.iter().fold(0u64, |value, at| value << 1 | u64::from(data[usize::from(at / 8)] >> (at % 8) & 1));
        prop_assert_eq!(field.get(&data), slow);
        let mut put = data;
        field.put(&mut put, bits);
        let mut expected = data;
        for (nth, at) in walked.iter().rev().enumerate() {
            let (byte, bit) = (usize::from(at / 8), at % 8);
            expected[byte] = expected[byte] & !(1 << bit) | ((bits >> nth & 1) as u8) << bit;
        }
        prop_assert_eq!(put, expected);
    }

    /// Whole numbers of up to 52 bits come back as they were; what does not fit is refused.
    #[test]
    fn numbers_come_back(mut field in field(), number in -(1i64 << 52)..1 << 52, offset in -1000i32..1000) {
        field.offset = offset.into();
        let (low, high) = match field.coding {
            Coding::Signed => (-(1i128 << (field.size - 1)), (1i128 << (field.size - 1)) - 1),
            _ => (0, (1i128 << field.size) - 1),
        };
        let value = number as f64 + f64::from(offset);
        match field.bits(value) {
            Some(bits) => prop_assert_eq!(field.value(bits), value),
            None => prop_assert!(!(low..=high).contains(&i128::from(number))),
        }
    }
}

#[test]
fn checksums_are_those_of_their_catalogues() {
    let mut data = [0; 8];
    // CRC-8/SAE-J1850 of "1234567" with the eighth byte left out; of "123456789" it is 4Bh.
    data[..7].copy_from_slice(b"1234567");
    let slow = |bytes: &[u8]| {
        let mut crc = 0xFFu32;
        for byte in bytes {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = if crc & 0x80 != 0 { (crc << 1 ^ 0x11D) & 0x1FF } else { crc << 1 };
            }
        }
        (crc ^ 0xFF) as u8
    };
    assert_eq!(slow(b"123456789"), 0x4B);
    assert_eq!(Checksum::Crc8.of(&data, 8, 7), slow(b"1234567"));
    assert_eq!(Checksum::Xor.of(&data, 8, 7), b'1' ^ b'2' ^ b'3' ^ b'4' ^ b'5' ^ b'6' ^ b'7');
    assert_eq!(Checksum::Sum.of(&[200, 100, 9, 1, 0, 0, 0, 0], 4, 2), 45);
}
